"""What a file from elsewhere may not hold: links to other files, Python objects, and more bytes than memory has.

An HDF5 file can name other files (external links, external and virtual datasets), hold objects that Python would have
to build, and declare shapes that no memory holds. The writers here use none of that. It is refused, naming the object.
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
from roughsim.untrusted.child_process import ChildEndedError, call_in_child

_PICKLED_ARRAY = re.compile(rb"'descr'\s*:\s*[^,}]*\|?O")  # in the header of a .npy


def regular_file(path: Path) -> Path:
    """Return `path` if it is a file; a pipe or a device, which could block for ever, is a RecordError."""
    if path.exists() and not path.is_file():
        raise RecordError(f"{path} is a folder, a pipe or a device; a file is needed")
    return path


def machine_memory() -> float:
    """Return the bytes of memory of this machine; inf where the system does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return inf


def check_hdf5(file: Any, path: Path, *, numbers_only: bool = True) -> None:
    """Raise a RecordError if an open HDF5 file leads elsewhere or declares more than half of the memory.

    No dataset is read. With `numbers_only`, as in files of roughsim, text, records and soft links are refused too;
    instruments write them. `path` is what the message calls the file.
    """
    from h5py import h5d, h5t

    declared, limit = 0.0, 0.5 * machine_memory()
    for name, dataset in _datasets(file, path, numbers_only):
        properties, kind = dataset.get_create_plist(), dataset.get_type()
        if properties.get_external_count():
            raise RecordError(f"{path}: {name} is an external dataset, stored in another file; nothing was read")
        if properties.get_layout() == h5d.VIRTUAL:
            raise RecordError(f"{path}: {name} is a virtual dataset, made of other files; nothing was read")
        if numbers_only and kind.get_class() not in (h5t.INTEGER, h5t.FLOAT):
            raise RecordError(f"{path}: {name} holds objects, not plain numbers; nothing was read")
        # many datasets that fit one by one may not fit together; an empty dataset has no shape, a scalar the shape ()
        declared += 0.0 if dataset.shape is None else float(prod(dataset.shape)) * float(kind.get_size())
        if declared > limit:
            raise RecordError(
                f"{path}: {name} declares the shape {dataset.shape}; with it the file would need "
                f"{declared / 1e9:.3g} GB, above half of the machine's memory, {limit / 1e9:.3g} GB; nothing was read"
            )


def _datasets(file: Any, path: Path, hard_links_only: bool) -> Iterator[tuple[str, Any]]:
    """Yield name and identifier of every dataset, each once, following hard links only."""
    from h5py import h5d, h5g, h5l, h5o

    refused = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link, which leads to another file"}
    visited, groups = set(), [("", file.id)]
    while groups:
        parent, group = groups.pop()
        for key in group:
            name = f"{parent}/{plain(key.decode(errors='replace'))[:80]}"
            link = group.links.get_info(key).type
            if link == h5l.TYPE_SOFT and not hard_links_only:
                continue  # the object that it leads to in this file has a hard link too
            if link != h5l.TYPE_HARD:
                kind, rule = refused.get(link, "a link of an unknown kind"), "only what lies in the file itself is read"
                raise RecordError(f"{path}: {name} is {kind}; {rule}, and nothing was read")
            item = h5o.open(group, key)
            address = h5o.get_info(item).addr
            if address in visited:  # hard links may form a cycle
                continue
            visited.add(address)
            if isinstance(item, h5g.GroupID):
                groups.append((name, item))
            elif isinstance(item, h5d.DatasetID):
                yield name, item


def check_measured_file(path: Path) -> None:
    """Raise a RecordError if the file of an instrument leads to other files, runs code, or unpacks beyond memory.

    Other programs will read it. Refused are: no regular file, more than an eighth of memory, a zip whose entries
    unpack to more than half of memory, a pickle, and an HDF5 file that `check_hdf5` refuses or the library cannot read.
    """
    size, memory = regular_file(path).stat().st_size, machine_memory()
    if size > 0.125 * memory:
        raise RecordError(f"{path} has {size / 1e9:.3g} GB, above an eighth of the machine's memory; crop it first")
    with open(path, "rb") as file:
        start = file.read(4096)
    if start.startswith(b"\x89HDF\r\n\x1a\n"):
        try:
            call_in_child(_read_all, path, seconds=5.0 + size / 1e7)
        except ChildEndedError as error:
            raise RecordError(f"{path} cannot be read: {error}; it is damaged, save it again") from error
    elif start.startswith(b"PK"):
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > 0.5 * memory:
            raise RecordError(f"{path} unpacks to {unpacked / 1e9:.3g} GB, above half of the machine's memory")
    elif start.startswith(b"\x80") or (start.startswith(b"\x93NUMPY") and _PICKLED_ARRAY.search(start)):
        raise RecordError(f"{path} holds pickled Python objects, which run code when they are read; nothing was read")


def _read_all(path: Path) -> None:
    """Check an HDF5 file, and read all of it once: damage on which the library spins shows here, in the child."""
    import h5py

    def read(_: str, item: Any) -> None:
        list(item.attrs.values())
        if isinstance(item, h5py.Dataset):
            item[()]

    with h5py.File(path, "r", locking=False) as file:
        check_hdf5(file, path, numbers_only=False)
        file.visititems(read)
