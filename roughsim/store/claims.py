"""Claims on members, so that several processes on one run folder do not compute the same member.

``RUN/claims/L0-000003`` holds the name of the process that computes this member. ``RUN/claims/process-NAME`` holds a
number that this process raises every few seconds, its sign of life. A process counts as ended when its number stays the
same for a lease on the reader's own clock: clocks of different machines are never compared. Members are written whole
and have the same bits whoever computes them. So a claim that is taken over too early costs time and nothing else.
"""

import json
import os
import re
import secrets
import socket
import time
import warnings
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from typing import Any, Self

from roughsim.store.member_files import MEMBER_NAME

LEASE = 30.0  # s; a process that is silent for so long counts as ended
RENEWAL = 2.0  # s between two signs of life
PROCESS_NAME = re.compile(r"[\w.-]{1,200}")
POINTS = "points"  # folder of the runs of a study
PLAN = "plan"  # claim of the process that plans the points of a study
_CLAIM = re.compile(rf"{MEMBER_NAME.pattern}|{PLAN}")
_PROCESS_FILE = re.compile(rf"process-{PROCESS_NAME.pattern}")


class Claims:
    """The claims of this process, its signs of life, and the latest signs of life of other processes."""

    def __init__(self, run_folder: Path):
        self.folder = run_folder / "claims"
        self._host = re.sub(r"[^\w.-]", "-", socket.gethostname())[:64]
        # the last part distinguishes it from an earlier or later process of the same host and number
        self.name = f"{self._host}-{os.getpid()}-{secrets.token_hex(8)}"
        self.path = self.folder / f"process-{self.name}"
        self.held: set[str] = set()
        self._seen: dict[str, tuple[bytes, float]] = {}  # name of a file → content, and when it was first seen, s
        self._warned = False
        self._end = Event()
        self._thread = Thread(target=self._keep_signing, daemon=True)

    def __enter__(self) -> Self:
        try:
            self.folder.mkdir(exist_ok=True)
            self.sign(0)
        except OSError as error:
            self._go_on_without(error)
        for path in _listed(self.folder, _PROCESS_FILE):
            self._is_silent(path)  # from now on its silence counts
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Give up the claims of this process, and remove those of processes that have ended."""
        self.release_all()
        self._end.set()
        self._thread.join()
        _remove(self.path)
        for path in _listed(self.folder, _CLAIM):
            if self._is_stale(path):
                _remove(path)
        for path in _listed(self.folder, _PROCESS_FILE):  # after the claims, which are judged by these files
            if self._is_silent(path):
                _remove(path)
        with suppress(OSError):  # others are at work, or it holds files that are not ours
            self.folder.rmdir()

    def sign(self, count: int) -> None:
        """Give the sign of life number `count`; OSError if the disk refuses."""
        text = json.dumps({"host": self._host, "pid": os.getpid(), "space": process_space()})
        _write_in_place(self.path, f"{count:020d}\n{text}\n")

    def _keep_signing(self) -> None:
        count = 0
        while not self._end.wait(RENEWAL):
            count += 1
            with suppress(OSError):  # the next one may succeed, or others compute the same members
                self.sign(count)

    def take(self, claim: str) -> bool:
        """Claim a member, or the plan of a study, also from a process that has ended; False if it was claimed before.

        Where claim files cannot be made, no other process is asked, and a warning says so once.
        """
        if claim in self.held:
            return False
        path = self.folder / claim
        try:
            for _ in range(3):  # again without the folder, and again after a stale claim was removed
                try:
                    _write_in_place(path, self.name, os.O_EXCL)
                    self.held.add(claim)
                    return True
                except KeyboardInterrupt:  # perhaps between the file and the name in it
                    if _start_of(path) in (b"", self.name.encode()):
                        _remove(path)
                    raise
                except FileNotFoundError:
                    self.folder.mkdir(exist_ok=True)  # the last process to leave removes it
                except FileExistsError:
                    if not self._is_stale(path):
                        return False
                    path.unlink(missing_ok=True)
        except OSError as error:
            self._go_on_without(error)
            self.held.add(claim)
            return True
        return False  # another process was quicker

    def release(self, claim: str) -> None:
        """Give a claim up, unless another process has taken it over."""
        if _start_of(self.folder / claim) == self.name.encode():
            _remove(self.folder / claim)
        self.held.discard(claim)  # at last: an interrupt before it leaves the claim to `release_all`

    def release_all(self) -> None:
        """Give all claims of this process up."""
        for claim in list(self.held):
            self.release(claim)

    def claimed(self, claim: str) -> bool:
        """Whether another process has a claim on a member and shows signs of life."""
        path = self.folder / claim
        return path.exists() and claim not in self.held and not self._is_stale(path)

    def _is_stale(self, path: Path) -> bool:
        """Whether the process that made a claim has ended; a claim without a name is stale after a lease."""
        owner = _start_of(path).decode(errors="replace")
        return self._is_silent(self.folder / f"process-{owner}" if PROCESS_NAME.fullmatch(owner) else path)

    def _is_silent(self, path: Path) -> bool:
        """Whether a file has had the same content for a lease, or is of a process that is known to have ended."""
        content, now = _start_of(path), time.monotonic()
        if path.name not in self._seen or self._seen[path.name][0] != content:
            self._seen[path.name] = content, now
        return now - self._seen[path.name][1] >= LEASE or (path != self.path and _has_ended(content))

    def _go_on_without(self, error: OSError) -> None:
        if not self._warned:
            self._warned = True
            warnings.warn(
                f"claims cannot be made in {self.folder} ({error.strerror}): the run goes on without them, and other "
                f"processes that work on it may compute the same members",
                RuntimeWarning,
                stacklevel=2,
            )


def writer(run_folder: Path) -> str | None:
    """Return the processes that compute a run now, as "process 12 on host" or "3 processes on 2 hosts"; None if none.

    A process counts if it gives a sign of life while this function waits: a few seconds at most, and no time where no
    process has left a file. Those that compute a study, STUDY/points/RUN, sign in the folder of the study.
    """
    homes = [run_folder.absolute()]
    if homes[0].parent.name == POINTS:
        homes.append(homes[0].parent.parent)
    first = {path: _start_of(path) for home in homes for path in _listed(home / "claims", _PROCESS_FILE)}
    waiting = {path for path, content in first.items() if not _has_ended(content)}
    alive: set[Path] = set()
    end = time.monotonic() + 3.0 * RENEWAL
    while waiting and time.monotonic() < end:
        time.sleep(0.05)
        now = {path: _start_of(path) for path in waiting}
        alive |= {path for path, content in now.items() if content and content != first[path]}
        waiting -= alive | {path for path, content in now.items() if not content or _has_ended(content)}
    signed = [_signature(first[path]) for path in alive]
    hosts = sorted({str(signature.get("host", "?")) for signature in signed})
    if len(signed) > 1:
        return f"{len(signed)} processes on {hosts[0] if len(hosts) == 1 else f'{len(hosts)} hosts'}"
    return f"process {signed[0].get('pid', '?')} on {hosts[0]}" if signed else None


def process_space() -> str | None:
    """Return the boot of this machine and its container, within which a process number is unique; None if unknown."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot} {os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        return None


def _has_ended(content: bytes) -> bool:
    """Whether a process is known to have ended: one of this very machine and container, whose number is free."""
    signature = _signature(content)
    if signature.get("space") is None or signature["space"] != process_space():
        return False
    try:
        os.kill(signature["pid"], 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def _signature(content: bytes) -> dict[str, Any]:
    """Return host, pid and space from the file of a process; empty if the content is not of that kind."""
    try:
        signature: dict[str, Any] = json.loads(content.partition(b"\n")[2])
        sound = isinstance(signature["pid"], int) and PROCESS_NAME.fullmatch(signature["host"])
    except (ValueError, LookupError, TypeError, RecursionError):
        return {}
    return signature if sound else {}


def _listed(folder: Path, name: re.Pattern[str]) -> list[Path]:
    """Return what lies in a folder under such names, sorted; nothing where it cannot be read."""
    try:
        return sorted(path for path in folder.iterdir() if name.fullmatch(path.name))
    except OSError:
        return []


def _start_of(path: Path) -> bytes:
    """Return the start of a small file; empty if there is none, it cannot be read, or it is no file."""
    with suppress(OSError):
        if path.is_file():  # a pipe would block
            with open(path, "rb") as file:
                return file.read(4096)
    return b""


def _write_in_place(path: Path, text: str, flags: int = 0) -> None:
    """Write a small file without moving it, so that other machines see it when they open it."""
    handle = os.open(path, os.O_CREAT | os.O_WRONLY | flags, 0o644)
    try:
        os.write(handle, text.encode())
    finally:
        os.close(handle)


def _remove(path: Path) -> None:
    """Remove a file if it is there and may be removed; another process may be quicker."""
    with suppress(OSError):
        path.unlink()
