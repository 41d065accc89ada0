"""Claims on members, so that several processes on one run folder do not compute the same member.

``RUN/claims/L0-000003`` holds the name of the process that computes some members from this one on, until they are
saved. ``RUN/claims/process-NAME`` holds a number that this process raises every few seconds, its sign of life. A
process counts as ended when its number stays the same for a lease on the reader's own clock: clocks of different
machines are never compared. Members are saved whole and have the same bits whoever computes them. So a claim that is
taken over too early costs time and nothing else.
"""

import os
import re
import secrets
import socket
import time
import warnings
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from typing import Self

from roughsim.store.member_files import MEMBER_NAME

LEASE = 30.0  # s; a process that is silent for so long counts as ended
RENEWAL = 2.0  # s between two signs of life
POINTS = "points"  # folder of the runs of a study
PLAN = "plan"  # claim of the process that plans the points of a study
_PROCESS = re.compile(r"process-([\w.-]{1,200})")
_FILE = re.compile(rf"{_PROCESS.pattern}|{MEMBER_NAME.pattern}|{PLAN}")
_SIGN = re.compile(
    r"\d+\n(?P<host>[\w.-]+) (?P<pid>\d{1,9}) (?P<space>.+)\n"
)  # content of the file of a process
_silent: dict[
    Path, str
] = {}  # files of processes for which `writer` waited in vain, with their content


class Claims:
    """The claims of this process, its signs of life, and the latest signs of life of other processes."""

    def __init__(self, run_folder: Path):
        self.folder = run_folder / "claims"
        self._host = re.sub(r"[^\w.-]", "-", socket.gethostname())[:64]
        # the last part distinguishes it from an earlier or later process of the same host and number
        self.name = f"{self._host}-{os.getpid()}-{secrets.token_hex(8)}"
        self.path = self.folder / f"process-{self.name}"
        self.held: set[str] = set()
        self.was_last = False  # whether no other process was at work when this one left
        self._seen: dict[
            str, tuple[str, float]
        ] = {}  # name of a file → content, and time of its first reading, s
        self._warned = False
        self._end = Event()
        self._thread = Thread(target=self._keep_signing, daemon=True)

    def __enter__(self) -> Self:
        try:
            self.folder.mkdir(exist_ok=True)
            self._made(self.path)  # again if the last process to leave has just removed the folder
            self.sign(0)
        except OSError as error:
            self._go_on_without(error)
        for path in _listed(self.folder, _FILE):
            self._is_stale(path)  # from now on its silence counts
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Release the claims of this process, and remove the claims of processes that have ended."""
        self.release_all()
        self._end.set()
        self._thread.join()
        with suppress(OSError):  # other processes may be quicker, or at work in the folder
            self.was_last = not self.path.exists()  # others count it as ended, or it has no claims
            self.path.unlink(missing_ok=True)
            for path in _listed(self.folder, _FILE):  # claims before the processes that they name
                self._remove_stale(path)
            self.folder.rmdir()  # of processes that leave at once, one can
            self.was_last = True

    def sign(self, count: int) -> None:
        """Write the sign of life number `count`; OSError if the disk refuses."""
        _write_in_place(self.path, f"{count:020d}\n{self._host} {os.getpid()} {process_space()}\n")

    def _keep_signing(self) -> None:
        count = 0
        while not self._end.wait(RENEWAL):
            count += 1
            with suppress(OSError):  # the next one may succeed, or others compute the same members
                self.sign(count)

    def take(self, claim: str) -> bool:
        """Claim a member, or the plan of a study, also from a process that has ended; False if it was claimed before.

        If claim files cannot be made, or those of another user not removed, claims are granted without a file, after
        one warning.
        """
        if claim in self.held:
            return False
        self.held.add(claim)  # first: after an interrupt `release_all` releases what was made
        try:
            if self._made(self.folder / claim):
                return True
        except OSError as error:
            self._go_on_without(error)
            return True
        self.held.discard(claim)
        return False

    def _made(self, path: Path) -> bool:
        """Make the file of a claim; False if another process has it. OSError if the disk or its permissions refuse."""
        for _ in range(3):  # again without the folder, and again after a stale claim was removed
            try:
                _write_in_place(path, self.name, os.O_EXCL)
                return True
            except FileNotFoundError:
                with suppress(OSError):
                    self.folder.mkdir(exist_ok=True)  # the last process to leave removes it
            except FileExistsError:
                if not self._remove_stale(path):
                    return False
        return False  # another process was quicker

    def _remove_stale(self, path: Path) -> bool:
        """Remove a file if it is stale; False if it is not, or if another process removes it.

        One alone makes the guard, and looks again: else a second one would remove the new claim of the first.
        """
        before = _start_of(path)
        guard = path.with_name(f"process-{path.name}")  # stale itself, if this process ends here
        if not self._is_stale(path) or not self._made(guard):
            return False
        if _start_of(path) == before:
            path.unlink(missing_ok=True)
        guard.unlink(missing_ok=True)
        return True

    def release(self, claim: str) -> None:
        """Release a claim, unless another process has taken it over."""
        path = self.folder / claim
        if _start_of(path) == self.name:
            with suppress(OSError):
                path.unlink()
        self.held.discard(
            claim
        )  # at last: an interrupt before it leaves the claim to `release_all`

    def release_all(self) -> None:
        """Release all claims of this process."""
        for claim in list(self.held):
            self.release(claim)

    def _is_stale(self, path: Path) -> bool:
        """Whether the process of a file has ended: silent for a lease, or not among those of this machine.

        It is the process that a claim names. A claim without a name is stale after a lease.
        """
        owner = f"process-{_start_of(path)}"
        if _PROCESS.fullmatch(owner):
            path = self.folder / owner
        content, now = _start_of(path), time.monotonic()
        if path.name not in self._seen or self._seen[path.name][0] != content:
            self._seen[path.name] = content, now
        return now - self._seen[path.name][1] >= LEASE or (
            path != self.path and _has_ended(content)
        )

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

    A process counts if it renews its file while this function waits: a few seconds at most, and no time without such
    files. Processes that compute a study, STUDY/points/RUN, have their file in the folder of the study.
    """
    home = run_folder.absolute()
    homes = [home, home.parent.parent] if home.parent.name == POINTS else [home]
    waiting = {
        path: _start_of(path) for home in homes for path in _listed(home / "claims", _PROCESS)
    }
    waiting = {
        path: content for path, content in waiting.items() if content not in ("", _silent.get(path))
    }
    signs = []
    end = time.monotonic() + 3.0 * RENEWAL
    while waiting and time.monotonic() < end:
        for path, before in list(waiting.items()):
            content = _start_of(path)
            if content != before or _has_ended(content):
                del waiting[path]
            if content != before and (sign := _SIGN.fullmatch(content)):
                signs.append(sign)
        time.sleep(0.05 if waiting else 0.0)
    _silent.update(waiting)
    if not signs:
        return None
    hosts = sorted({sign["host"] for sign in signs})
    if len(signs) == 1:
        return f"process {signs[0]['pid']} on {hosts[0]}"
    return f"{len(signs)} processes on {hosts[0] if len(hosts) == 1 else f'{len(hosts)} hosts'}"


def process_space() -> str:
    """Return the boot of this machine and its container, within which a process number is unique, or "unknown"."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot} {os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        return "unknown"


def _has_ended(content: str) -> bool:
    """Whether a process has ended for certain: it was of this machine and container, and its number is free."""
    sign = _SIGN.fullmatch(content)
    if sign is None or sign["space"] == "unknown" or sign["space"] != process_space():
        return False
    try:
        os.kill(int(sign["pid"]), 0)
    except OSError as error:
        return isinstance(error, ProcessLookupError)
    return False


def _listed(folder: Path, name: re.Pattern[str]) -> list[Path]:
    """Return the paths in a folder with matching names, sorted; empty if it cannot be read."""
    try:
        return sorted(path for path in folder.iterdir() if name.fullmatch(path.name))
    except OSError:
        return []


def _start_of(path: Path) -> str:
    """Return the start of a small file; empty if there is none, it cannot be read, or it is no file."""
    with suppress(OSError):
        if path.is_file():  # a pipe would block
            with open(path, "rb") as file:
                return file.read(4096).decode(errors="replace")
    return ""


def _write_in_place(path: Path, text: str, flags: int = 0) -> None:
    """Write a small file in place, so that it is visible to other machines when they open it."""
    handle = os.open(path, os.O_CREAT | os.O_WRONLY | flags, 0o644)
    try:
        os.write(handle, text.encode())
    finally:
        os.close(handle)
