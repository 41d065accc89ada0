"""Checks of untrusted files before reading: links, declared sizes, pickles, and damage.

An HDF5 file can name other files (external links, external and virtual datasets), and declare shapes that no memory
holds. Such a file is refused, and the message names the object.

64 zeroed bytes in the header of an HDF5 file make the library loop in C, without a chance for Python's signal handlers.
So files of instruments are opened in a child process: a library that hangs or crashes ends only the child. One child
serves all calls of a process; the first call starts it. It is no `multiprocessing` child, which would run the caller's
script again. Members of a run are opened in this process: their seal excludes damage, but not forgery.
"""

import atexit
import faulthandler
import gzip
import os
import pickle
import re
import signal
import stat
import sys
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Any

from roughsim.errors import RecordError
from roughsim.machine import available_memory, exceeds, in_words
from roughsim.show.text import plain

_GZIP = b"\x1f\x8b"
_PICKLED_ARRAY = re.compile(rb"'descr'\s*:\s*[^,}]*\|?O")  # in the header of a .npy
_CRASHES = tuple(
    -getattr(signal, name)
    for name in ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE")
    if hasattr(signal, name)
)
_TIMED_OUT = -getattr(signal, "SIGPROF", -1)  # without SIGPROF, faulthandler ends the child with 1
# by the pid of the parent: after a fork the copy must start its own
_children: dict[int, Popen[bytes]] = {}
_lock = Lock()
_OPENER = "the process that opens files from elsewhere"


def regular_file(path: Path) -> Path:
    """Return `path` if it is a file; a pipe or a device, which could block for ever, is a RecordError."""
    try:
        mode = path.stat().st_mode  # asked once: the file may appear or go between two questions
    except (OSError, ValueError):
        return path
    if not stat.S_ISREG(mode):
        raise RecordError(f"{path} is a folder, a pipe or a device; a file is needed")
    return path


def _check_hdf5(file: Any, path: Path) -> None:
    """Raise a RecordError if an open HDF5 file leads elsewhere or declares more than half of the available memory.

    No dataset is read. `path` names the file in the message.
    """
    from h5py import h5d

    declared = 0.0
    for name, dataset in _datasets(file, path):
        properties = dataset.get_create_plist()
        kind = ""
        if properties.get_external_count():
            kind = "an external dataset, stored in another file"
        elif properties.get_layout() == h5d.VIRTUAL:
            kind = "a virtual dataset, made of other files"
        if kind:
            raise RecordError(f"{path}: {name} is {kind}; nothing was read")
        # many datasets that fit one by one may not fit together; an empty dataset has no shape, a scalar the shape ()
        if dataset.shape is not None:
            declared += float(prod(dataset.shape)) * float(dataset.get_type().get_size())
        if exceeds(declared, 0.5):
            raise RecordError(
                f"{path}: {name} declares the shape {dataset.shape}; with it the file would need "
                f"{declared / 1e9:.3g} GB, above half of the {in_words(available_memory())}; nothing was read"
            )


def _datasets(file: Any, path: Path) -> Iterator[tuple[str, Any]]:
    """Yield name and identifier of every dataset, each once, following hard links only."""
    from h5py import h5d, h5g, h5l, h5o

    visited, groups = set(), [("", file.id)]
    while groups:
        parent, group = groups.pop()
        for key in group:
            name = f"{parent}/{plain(key.decode(errors='replace'))[:80]}"
            link = group.links.get_info(key).type
            if link == h5l.TYPE_SOFT:
                continue  # the object that it leads to in this file has a hard link too
            if link != h5l.TYPE_HARD:
                kind = "a link of an unknown kind"
                if link == h5l.TYPE_EXTERNAL:
                    kind = "an external link, which leads to another file"
                raise RecordError(f"{path}: {name} is {kind}; nothing was read")
            address = h5o.get_info(group, key).addr
            if address in visited:  # hard links may form a cycle
                continue
            visited.add(address)
            item = h5o.open(group, key)
            if isinstance(item, h5g.GroupID):
                groups.append((name, item))
            elif isinstance(item, h5d.DatasetID):
                yield name, item


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """Give the path of a file, or of a temporary unpacked copy if it is packed by gzip.

    RecordError for no regular file, more than an eighth of memory packed or unpacked, and a packed file that is
    damaged or holds another packed file.
    """
    with open(regular_file(path), "rb") as file:
        if file.read(2) != _GZIP:
            yield path
            return
    with TemporaryDirectory() as folder:
        copy, limit = Path(folder) / "unpacked", 0.125 * available_memory().amount
        try:
            call_in_child(_unpack, path, copy, limit, seconds=5.0 + path.stat().st_size / 1e6)
        except ChildEndedError as error:
            raise RecordError(f"{path} cannot be unpacked: {error}; unpack it") from error
        yield copy


def _unpack(path: Path, copy: Path, limit: float) -> None:
    """Unpack a file packed by gzip up to a number of bytes; runs in the child."""
    size = 0
    try:
        with gzip.open(path) as packed, open(copy, "wb") as target:
            while block := packed.read(1 << 20):
                if size == 0 and block.startswith(_GZIP):
                    raise RecordError(f"{path} is packed twice; unpack it")
                if (size := size + len(block)) > limit:
                    raise RecordError(
                        f"{path} unpacks to more than {limit / 1e9:.3g} GB, an eighth of the available memory"
                    )
                target.write(block)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise RecordError(
            f"{path} is packed by gzip and cut short or damaged ({error}); copy it again"
        ) from None


def check_measured_file(file: Path, path: Path | None = None) -> None:
    """Raise a RecordError if the file of an instrument leads to other files, runs code, or unpacks beyond memory.

    Other programs will read it. Refused are: no regular file, more than an eighth of memory, a zip whose entries
    unpack to more than half of memory, a pickle, and an HDF5 file that leads elsewhere, declares too much, or cannot be
    read. `path` is the name in messages if `file` is a copy.
    """
    path = path or file
    size = regular_file(file).stat().st_size
    if exceeds(size, 0.125):
        raise RecordError(
            f"{path} has {size / 1e9:.3g} GB, above an eighth of the available memory; crop it first"
        )
    with open(file, "rb") as stream:
        start = stream.read(4096)
    if start.startswith(b"\x89HDF\r\n\x1a\n"):
        try:
            call_in_child(_read_all, file, path, seconds=5.0 + path.stat().st_size / 1e7)
        except ChildEndedError as error:
            raise RecordError(
                f"{path} cannot be read: {error}; it is damaged, save it again"
            ) from error
    elif start.startswith(b"PK"):
        try:
            with zipfile.ZipFile(file) as archive:
                entries = sum(entry.file_size for entry in archive.infolist())
        except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
            raise RecordError(
                f"{path} is a zip that is cut short or damaged ({error}); copy it again"
            ) from None
        if exceeds(entries, 0.5):
            raise RecordError(
                f"{path} unpacks to {entries / 1e9:.3g} GB, above half of the available memory"
            )
    elif start.startswith(b"\x80") or (
        start.startswith(b"\x93NUMPY") and _PICKLED_ARRAY.search(start)
    ):
        raise RecordError(
            f"{path} holds pickled Python objects, which run code when they are read; nothing was read"
        )


def _read_all(source: Path, path: Path) -> None:
    """Check an HDF5 file, and read all of it once: damage on which the library spins shows here, in the child."""
    import h5py

    def read(_: str, item: Any) -> None:
        list(item.attrs.values())
        if isinstance(item, h5py.Dataset):
            item[()]

    with h5py.File(source, "r", locking=False) as file:
        _check_hdf5(file, path)
        file.visititems(read)


class ChildEndedError(Exception):
    """The child ended during a call: the library crashed, or used more CPU time than it had."""


def call_in_child(function: Callable[..., Any], *arguments: Any, seconds: float) -> Any:
    """Return ``function(*arguments)``, computed in the child; an exception it raises is raised here.

    Function, arguments and result are pickled, so the function belongs to a module. After `seconds` of CPU time the
    child is ended: ChildEndedError, as after a crash. OSError if no child can be started or another program ended it.
    """
    with _lock:
        child = _children.get(os.getpid())
        if child is None or child.poll() is not None:
            child = _started()
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            # relative paths are those of here, which may have changed since the child began
            pickle.dump((function, arguments, seconds, os.getcwd()), child.stdin)
            child.stdin.flush()
            result, error = pickle.load(child.stdout)
        except (EOFError, BrokenPipeError):
            code = _wait(child)
            if code == _TIMED_OUT:
                raise ChildEndedError(
                    f"the library did not come back in {seconds:.0f} s of computing"
                ) from None
            if code in _CRASHES:
                raise ChildEndedError(f"the library crashed, signal {-code}") from None
            raise OSError(f"{_OPENER} was ended from outside ({code}); try again") from None
        except BaseException:
            # after an interrupt, the next call would take this answer for its own
            child.kill()
            _wait(child)
            raise
    if error is not None:
        raise error
    return result


def _started() -> Popen[bytes]:
    """Start a child, and wait until it is ready."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from roughsim.untrusted import serve; serve()"
    child = _children[os.getpid()] = Popen(
        [sys.executable, "-c", code], stdin=PIPE, stdout=PIPE, stderr=DEVNULL
    )
    assert child.stdout is not None
    if not child.stdout.read(1):
        raise OSError(f"{_OPENER} did not start; {sys.executable}: {_wait(child)}")
    return child


def _wait(child: Popen[bytes]) -> int:
    """Wait for a child that is ending, close its pipes, and return its exit code."""
    _children.pop(os.getpid(), None)
    child.communicate()  # drops unsent bytes
    return child.returncode


@atexit.register
def end_child() -> None:
    """End the child process, if it runs."""
    child = _children.get(os.getpid())
    if child is not None:
        child.kill()
        _wait(child)


def serve() -> None:
    """Answer calls on the standard streams until they are closed. Runs in the child."""
    # Ctrl-C reaches the parent too, and it ends the child
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # output of functions goes to the error stream, apart from the answers
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    answers.write(b"+")
    answers.flush()
    while True:
        try:
            function, arguments, seconds, folder = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        _limit_cpu_time(seconds)
        result, error = None, None
        try:
            os.chdir(folder)
            result = function(*arguments)
        except Exception as raised:
            error = raised
        _limit_cpu_time(0.0)
        pickle.dump((result, error), answers)
        answers.flush()


def _limit_cpu_time(seconds: float) -> None:
    """Let the system end this process after `seconds` of CPU time (without POSIX: of time); 0 takes the limit off."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, seconds)
    elif seconds:
        faulthandler.dump_traceback_later(seconds, exit=True, file=sys.stderr)
    else:
        faulthandler.cancel_dump_traceback_later()
