"""Files on disk: written whole or not at all, read whole or not at all, and never deleted.

`DamagedError` means that the content of a file was read and is proven to be damaged. An `OSError` means that a file
cannot be read now: the disk or the network may give it later.
"""

import errno
import hashlib
import json
import os
import re
import secrets
import socket
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError
from roughsim.machine import exceeds
from roughsim.untrusted import regular_file

_TRIES = 5  # to write a file while other processes remove temporary files
_TEMPORARY = re.compile(r"\..+\.[A-Za-z0-9_-]+\.tmp")


class DamagedError(RecordError):
    """The content of a file is proven to be damaged: its digest or its format is wrong."""


def place_bytes(path: Path, *content: bytes, first: bool = False) -> None:
    """Write a file atomically: in parts to a temporary file, forced to disk, and renamed.

    Any number of processes may write the same file at once. The last whole file stays; with `first` the first one
    stays, and the others get FileExistsError. If the disk refuses, the OSError names the path, and no half-written
    file stays.
    """
    host = re.sub("[^A-Za-z0-9]", "", socket.gethostname())[:24]
    place = _link if first else os.replace
    for tries_left in reversed(range(_TRIES)):
        # a name for this process and this try alone, which is_temporary() recognizes
        temporary = path.with_name(f".{path.name}.{host}-{os.getpid()}-{secrets.token_hex(4)}.tmp")
        try:
            with open(temporary, "wb") as file:
                file.writelines(content)
                file.flush()
                os.fsync(
                    file.fileno()
                )  # a file that is moved before its bytes are on disk may be empty after a crash
            place(temporary, path)
            return
        except OSError as error:
            # another process may have swept the temporary file away; without the folder there is nothing to try again
            swept = isinstance(error, FileNotFoundError) and path.parent.is_dir()
            if not swept or not tries_left:
                raise OSError(error.errno, f"cannot write {path}: {error.strerror}") from error
        finally:
            with suppress(OSError):  # a disk that takes nothing removes nothing either
                temporary.unlink(missing_ok=True)


def _link(temporary: Path, path: Path) -> None:
    """Give a file its place; FileExistsError if another process was quicker."""
    try:
        os.link(temporary, path)  # the one way to place a whole file that refuses an existing one
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: of two processes in the same millisecond the last one stays
        if path.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.replace(temporary, path)


def make_folder(path: Path) -> None:
    """Make a folder, with those above it, if it does not exist; RecordError if a link in its path leads nowhere."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        for place in (path, *path.parents):
            if place.is_symlink() and not place.exists():  # as to a disk that was cleared
                words = f"{place} is a link to {place.readlink()}, which does not exist; make that folder"
                raise RecordError(f"{words}, or name another") from None
        raise


def is_temporary(name: str) -> bool:
    """Whether a name is of a temporary file of `place_bytes`, whose writer may still be at work."""
    return _TEMPORARY.fullmatch(name) is not None


def checksum(value: Any) -> str:
    """Return the checksum of a JSON value."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]


def seal(name: str, digest: Any) -> bytes:
    """Return the last line of a file: its name, and the SHA-256 of all bytes before, of which `digest` has the data."""
    words = f"\nroughsim {name} sha256 ".encode()
    digest.update(words)
    return words + f"{digest.hexdigest()}\n".encode()


def read_bytes(path: Path, most: int | None = None, *, again: bool = True) -> bytes:
    """Return all bytes of a file, read without HDF5 and its locks, `again` if another machine replaces it meanwhile.

    OSError if it cannot be read now, with the file, the reason, and advice. RecordError if it is a folder, a pipe or a
    device, or has more bytes than `most`.
    """
    try:
        with open(regular_file(path), "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if most is not None and size > most:
                raise RecordError(
                    f"{path} has {size / 2**20:.3g} MiB, above the {most >> 20} MiB that roughsim writes"
                )
            if exceeds(size, 0.5):
                raise OSError(
                    errno.ENOMEM, f"it has {size / 1e9:.3g} GB, above half of the available memory"
                )
            return file.read()
    except OSError as error:
        if error.errno == errno.ESTALE and again:
            return read_bytes(path, most, again=False)
        raise not_readable(path, error) from error


def not_readable(path: Path, error: OSError) -> OSError:
    """Return the error for a file that cannot be read now, though it may be sound."""
    reason = error.strerror or error
    advice = "see its permissions, the disk and the network, and try again"
    if error.errno in (errno.EMFILE, errno.ENFILE):
        advice = "close files, or raise the limit of open files (ulimit -n)"
    return OSError(
        error.errno, f"{path} cannot be read now ({reason}); nothing was changed; {advice}"
    )


def set_aside(path: Path, folder: Path) -> Path:
    """Move a file or a folder that is of no use to a free name in a folder, and return its new path.

    OSError if the disk refuses; FileNotFoundError if another process has moved the file.
    """
    folder.mkdir(exist_ok=True)
    is_folder = path.is_dir() and not path.is_symlink()
    make, remove = (Path.mkdir, Path.rmdir) if is_folder else (Path.touch, Path.unlink)
    for number in count():
        kept = folder / (f"{path.stem}-{number}{path.suffix}" if number else path.name)
        with suppress(FileExistsError):
            make(kept, exist_ok=False)  # from now on the name is this process's
            break
    try:
        os.replace(path, kept)
    except OSError:
        remove(kept)
        raise
    return kept
