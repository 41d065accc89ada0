"""Bytes on disk: placed whole or not at all, sealed with a digest, read whole or not at all, and never deleted.

What is read is told apart here, before any library sees it: sound, proven damaged (`DamagedError`), or not to be read
now (`OSError`).
"""

from __future__ import annotations

import errno
import hashlib
import io
import os
import re
import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError
from roughsim.untrusted import machine_memory, regular_file

_SEAL = re.compile(rb"\nroughsim (L(\d+)-(\d{6,})\.h5) sha256 ([0-9a-f]{64})\n\Z")
_LONGEST_SEAL = 200
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_TEMPORARY = re.compile(r"\..+\.[A-Za-z0-9_-]+\.tmp")
_TRIES = 5  # of a temporary file that others remove
_ADVICE = {
    errno.EMFILE: "close files, or raise the limit of open files (ulimit -n)",
    errno.ENFILE: "close files, or raise the limit of open files of this machine",
    errno.EACCES: "see who may read it",
    errno.EPERM: "see who may read it",
    errno.ENOENT: "see whether it was moved",
}


class DamagedError(RecordError):
    """A file is proven to be not what was written: its digest, or the format inside, does not hold."""


def place_bytes(path: Path, *content: bytes | memoryview, first: bool = False) -> None:
    """Write a file, in parts, beside its place, force it to disk, and move it there: whole or not at all.

    Any number of processes may write the same file at once: the last whole one stays, or, with `first`, the first one.

    Raises
    ------
    OSError
        If the disk refuses, naming the path; no half-written file stays. FileExistsError with `first`, if it is there.
    """
    for left in reversed(range(_TRIES)):
        token = f"{re.sub('[^A-Za-z0-9]', '', socket.gethostname())[:24]}-{os.getpid()}-{secrets.token_hex(4)}"
        temporary = path.with_name(f".{path.name}.{token}.tmp")
        try:
            with open(temporary, "wb") as handle:
                handle.writelines(content)
                handle.flush()
                os.fsync(handle.fileno())
            if first:
                _place_first(temporary, path)
            else:
                os.replace(temporary, path)
            return
        except FileNotFoundError as error:  # somebody swept it away underneath
            if not left or not path.parent.is_dir():
                raise _not_written(path, error) from error
        except BaseException as error:
            with suppress(OSError):  # a disk that takes nothing does not let go either
                temporary.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise _not_written(path, error) from error
            raise


def _place_first(temporary: Path, path: Path) -> None:
    """Move a file to its place if nobody was quicker, FileExistsError otherwise."""
    try:
        os.link(temporary, path)  # the one way to move a whole file that refuses an existing one
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: of two processes in the same millisecond the last one stays
        if path.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.replace(temporary, path)
    else:
        temporary.unlink(missing_ok=True)


def _not_written(path: Path, error: OSError) -> OSError:
    return OSError(error.errno, f"cannot write {path}: {error.strerror}")


def is_temporary(name: str) -> bool:
    """Whether a file of this name is one that `place_bytes` has begun; its writer may be at work."""
    return _TEMPORARY.fullmatch(name) is not None


def hdf5_bytes(fill: Callable[[Any], None], **options: Any) -> bytes:
    """Return the content of an HDF5 file that `fill` fills, made in memory: HDF5 never meets a full disk."""
    import h5py

    memory = io.BytesIO()  # not the core driver: before HDF5 2.0 its images of v110 files have a stale checksum
    with h5py.File(memory, "w", libver="v110", **options) as file:
        fill(file)
    return memory.getvalue()


def place_hdf5(path: Path, fill: Callable[[Any], None], **options: Any) -> None:
    """Write an HDF5 file that `fill` fills as `place_bytes` does.

    Raises
    ------
    OSError
        If the disk refuses, naming the path; no half-written file stays.
    """
    place_bytes(path, hdf5_bytes(fill, **options))


def sealed(content: bytes, name: str) -> bytes:
    """Return the bytes of a member's file with its name and SHA-256 behind them, where HDF5 does not look."""
    head = content + f"\nroughsim {name} sha256 ".encode()
    return head + hashlib.sha256(head).hexdigest().encode() + b"\n"


def unlocked(path: Path, most: int | None = None) -> bytes:
    """Return all bytes of a file, read without HDF5 and its locks.

    Raises
    ------
    RecordError
        If it is no file but a folder, a pipe or a device, or has more bytes than `most`.
    OSError
        If it cannot be read now; one sentence says which file, why, and what to do.
    """
    try:
        with open(regular_file(path), "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if most is not None and size > most:
                raise RecordError(f"{path} has more than {most >> 20} MiB: roughsim does not write such")
            if size > 0.5 * machine_memory():
                raise OSError(errno.ENOMEM, f"it has {size / 1e9:.3g} GB, above half of the machine's memory")
            return file.read()
    except OSError as error:
        raise not_readable(path, error) from error


def not_readable(path: Path, error: OSError) -> OSError:
    """Return the error that says that a file cannot be read now, which is no damage."""
    advice = _ADVICE.get(error.errno or 0, "see the disk or the network, and try again")
    return OSError(error.errno, f"{path} cannot be read now ({error.strerror or error}); nothing was changed; {advice}")


def seal_of(path: Path, content: bytes) -> str | None:
    """Return the digest that a member's file bears, if all its bytes agree with it; None for one without a seal.

    Raises
    ------
    DamagedError
        If they do not, or the file was written for another place or is cut off.
    """
    found = _SEAL.search(content, max(len(content) - _LONGEST_SEAL, 0))
    if found is None:
        end = int.from_bytes(content[28:36], "little")  # of the superblock of version 3, which all members have
        if not content.startswith(_SIGNATURE) or end != len(content):
            raise damaged(path, "its digest is missing, and it does not end where it says")
        return None
    name, level, index, digest = (part.decode() for part in found.groups())
    if hashlib.sha256(memoryview(content)[: found.start(4)]).hexdigest() != digest:
        raise damaged(path, "its SHA-256 does not match")
    if name != path.name:
        raise damaged(path, f"it holds level {int(level)}, index {int(index)}, not what its name says")
    return digest


def tail(path: Path) -> bytes:
    """Return the digest that a member's file bears, without looking at the rest; empty where there is none.

    Raises
    ------
    OSError
        As `unlocked`.
    """
    try:
        with open(path, "rb") as file:
            file.seek(max(os.fstat(file.fileno()).st_size - _LONGEST_SEAL, 0))
            found = _SEAL.search(file.read())
    except OSError as error:
        raise not_readable(path, error) from error
    return b"" if found is None or found[1].decode() != path.name else bytes.fromhex(found[4].decode())


def damaged(path: Path, reason: object) -> DamagedError:
    """Return the error that names a damaged file and says what to do."""
    return DamagedError(
        f"{path} is damaged ({reason}); run the scene again: it is moved into the folder 'damaged' and redone"
    )


def set_aside(path: Path) -> Path:
    """Move a damaged file of a run into the folder ``damaged`` of the run, under a name that is free there.

    Parameters
    ----------
    path : Path
        ``RUN/realizations/NAME``.

    Returns
    -------
    Path
        Where it is now.

    Raises
    ------
    OSError
        If the disk refuses, or it is gone: another process has moved it.
    """
    folder = path.parent.parent / "damaged"
    folder.mkdir(exist_ok=True)
    number = 0
    while True:
        place = folder / (f"{path.stem}-{number}{path.suffix}" if number else path.name)
        try:
            os.close(os.open(place, os.O_CREAT | os.O_EXCL | os.O_WRONLY))  # the name is ours alone now
            break
        except FileExistsError:
            number += 1
    try:
        os.replace(path, place)
    except OSError:
        place.unlink()
        raise
    return place
