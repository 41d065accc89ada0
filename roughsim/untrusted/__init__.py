"""Files from elsewhere are not trusted: what an HDF5 file could reach or claim is looked at before anything is read.

A file of HDF5 can name other files (external links, external and virtual datasets), hold links to anywhere in itself,
objects that Python would have to build, and shapes that no memory holds. The writers here use none of that, so all of
it is refused by the name of the object.
"""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Iterator
from math import inf, prod
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError
from roughsim.show.text import plain
from roughsim.untrusted.apart import EndedError, call_apart

_OBJECTS = re.compile(rb"'descr'\s*:\s*[^,}]*\|?O")  # in the header of a .npy


def refuse_foreign(file: Any, path: Path, *, written_here: bool = True) -> None:
    """Refuse an open HDF5 file that is not made of plain numbers of its own.

    Parameters
    ----------
    file : h5py.File
        Just opened; no dataset of it is read here.
    path : Path
        What to call it.
    written_here : bool, optional
        Whether it claims to be a file of roughsim, which holds numbers and hard links only. Those of instruments also
        hold text, records and soft links.

    Raises
    ------
    RecordError
        Naming the object and what it is: a link that is not a hard one, a dataset that lies in other files, one whose
        entries are not numbers, or shapes that together need more than half of the machine's memory.
    """
    declared, most = 0.0, 0.5 * memory()
    for name, identifier in _datasets(file, path, written_here):
        _check_storage(identifier, path, name, written_here)
        declared += _declared(identifier)
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


def refuse_file_of_instrument(path: Path) -> None:
    """Refuse a file that another program will read, if it leads to other files or unpacks beyond memory.

    Raises
    ------
    RecordError
        If it is no regular file, larger than an eighth of memory, a zip whose entries are larger than half of memory
        once unpacked, a pickle, or an HDF5 file that `refuse_foreign` refuses.
    """
    size, room = regular_file(path).stat().st_size, memory()
    if size > 0.125 * room:
        raise RecordError(f"{path} has {size / 1e9:.3g} GB, above an eighth of the machine's memory; crop it first")
    start = _start(path)
    if start.startswith(b"\x89HDF\r\n\x1a\n"):
        try:
            call_apart(_walk, path, seconds=5.0 + size / 1e7)
        except EndedError as error:
            raise RecordError(f"{path} cannot be read: {error}; it is damaged, save it again") from error
    elif start.startswith(b"PK"):
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > 0.5 * room:
            raise RecordError(f"{path} unpacks to {unpacked / 1e9:.3g} GB, above half of the machine's memory")
    elif start.startswith(b"\x80") or (start.startswith(b"\x93NUMPY") and _OBJECTS.search(start)):
        raise RecordError(f"{path} holds pickled Python objects, which run code when they are read; nothing was read")


def _walk(path: Path) -> None:
    """Refuse an HDF5 file that leads elsewhere, and read all of it once."""
    import h5py

    def read(_: str, item: Any) -> None:
        list(item.attrs.values())
        if isinstance(item, h5py.Dataset):
            item[()]

    with h5py.File(path, "r", locking=False) as file:
        refuse_foreign(file, path, written_here=False)
        file.visititems(read)


def _start(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(4096)


def _datasets(file: Any, path: Path, hard_only: bool) -> Iterator[tuple[str, Any]]:
    """Yield name and identifier of every dataset, each once, following hard links only."""
    from h5py import h5d, h5g, h5o

    seen, groups = set(), [("", file.id)]
    while groups:
        place, group = groups.pop()
        for key in group:
            name = f"{place}/{plain(key.decode(errors='replace'))[:80]}"
            if not _is_hard(group, key, path, name, hard_only):
                continue
            identifier = h5o.open(group, key)
            address = h5o.get_info(identifier).addr
            if address in seen:
                continue
            seen.add(address)
            if isinstance(identifier, h5g.GroupID):
                groups.append((name, identifier))
            elif isinstance(identifier, h5d.DatasetID):
                yield name, identifier


def _is_hard(group: Any, key: bytes, path: Path, name: str, hard_only: bool) -> bool:
    from h5py import h5l

    kind = group.links.get_info(key).type
    if kind == h5l.TYPE_HARD:
        return True
    if kind == h5l.TYPE_SOFT and not hard_only:
        return False  # what it leads to in the file has a hard link too
    words = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link, which leads to another file"}
    what = words.get(kind, "a link of an unknown kind")
    raise RecordError(f"{path}: {name} is {what}; only what lies in the file itself is read, and nothing was read")


def _check_storage(identifier: Any, path: Path, name: str, numbers_only: bool) -> None:
    """Refuse a dataset that lies in other files, or whose entries are not numbers."""
    from h5py import h5d, h5t

    properties, kind = identifier.get_create_plist(), identifier.get_type().get_class()
    if properties.get_external_count():
        raise RecordError(f"{path}: {name} is an external dataset, stored in another file; nothing was read")
    if properties.get_layout() == h5d.VIRTUAL:
        raise RecordError(f"{path}: {name} is a virtual dataset, made of other files; nothing was read")
    if numbers_only and kind not in (h5t.INTEGER, h5t.FLOAT):
        raise RecordError(f"{path}: {name} holds objects, not plain numbers; nothing was read")


def _declared(identifier: Any) -> float:
    """The bytes that a dataset would fill in memory."""
    shape = identifier.shape  # () of a scalar, None of an empty one
    return 0.0 if shape is None else float(prod(shape)) * float(identifier.get_type().get_size())
