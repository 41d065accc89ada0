"""Files from elsewhere are not trusted: what an HDF5 file could reach or claim is looked at before anything is read.

A file of HDF5 can name other files (external links, external and virtual datasets), hold links to anywhere in itself,
objects that Python would have to build, and shapes that no memory holds. The writers here use none of that, so all of
it is refused by the name of the object.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from math import inf, prod
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError

_LINKS = {"TYPE_SOFT": "a soft link", "TYPE_EXTERNAL": "an external link: it leads to another file"}


def refuse_foreign(file: Any, path: Path) -> None:
    """Refuse an open HDF5 file that is not made of plain numbers of its own.

    Parameters
    ----------
    file : h5py.File
        Just opened; no dataset of it is read here.
    path : Path
        What to call it.

    Raises
    ------
    RecordError
        Naming the object and what it is: a link that is not a hard one, a dataset that lies in other files, one whose
        entries are not numbers, or shapes that together need more than half of the machine's memory.
    """
    declared, most = 0.0, 0.5 * memory()
    for name, identifier in _datasets(file, path):
        declared += _checked_size(identifier, path, name)
        if declared > most:
            raise RecordError(
                f"{path}: {name} declares the shape {identifier.shape}; with it the file would need "
                f"{declared / 1e9:.3g} GB, above half of the machine's memory, {most / 1e9:.3g} GB; nothing was read"
            )


def regular_file(path: Path) -> Path:
    """Return `path` if it is a file; a pipe or a device, which could block for ever, is a RecordError."""
    if path.exists() and not path.is_file():
        raise RecordError(f"{path} is a folder, a pipe or a device; a file is needed")
    return path


def memory() -> float:
    """Return the bytes of memory of this machine; inf where the system does not tell."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return inf


def _datasets(file: Any, path: Path) -> Iterator[tuple[str, Any]]:
    """Yield name and identifier of every dataset, each once, following hard links only."""
    from h5py import h5d, h5g, h5o

    seen, groups = set(), [("", file.id)]
    while groups:
        place, group = groups.pop()
        for key in group:
            name = f"{place}/{key.decode(errors='replace')}"
            _check_link(group, key, path, name)
            identifier = h5o.open(group, key)
            address = h5o.get_info(identifier).addr
            if address in seen:
                continue
            seen.add(address)
            if isinstance(identifier, h5g.GroupID):
                groups.append((name, identifier))
            elif isinstance(identifier, h5d.DatasetID):
                yield name, identifier


def _check_link(group: Any, key: bytes, path: Path, name: str) -> None:
    from h5py import h5l

    kind = group.links.get_info(key).type
    if kind == h5l.TYPE_HARD:
        return
    what = next((text for word, text in _LINKS.items() if kind == getattr(h5l, word)), "a link of an unknown kind")
    raise RecordError(f"{path}: {name} is {what}; only what lies in the file itself is read, and nothing was read")


def _checked_size(identifier: Any, path: Path, name: str) -> float:
    """The bytes that a dataset declares; RecordError if it is not an array of numbers in this file."""
    from h5py import h5d, h5t

    properties, kind = identifier.get_create_plist(), identifier.get_type()
    if properties.get_external_count():
        raise RecordError(f"{path}: {name} is an external dataset, stored in another file; nothing was read")
    if properties.get_layout() == h5d.VIRTUAL:
        raise RecordError(f"{path}: {name} is a virtual dataset, made of other files; nothing was read")
    if kind.get_class() not in (h5t.INTEGER, h5t.FLOAT):
        raise RecordError(f"{path}: {name} holds entries that are not plain numbers; nothing was read")
    shape = identifier.shape
    return 0.0 if shape is None else float(prod(shape)) * float(kind.get_size())
