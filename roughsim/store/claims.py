"""Who computes what in a run folder: claims spare several processes the same work, and nothing depends on them.

``RUN/claims/L0-000003`` holds the name of the process that computes this member. ``RUN/claims/process-NAME`` holds a
number that this process raises every few seconds. A process is gone when its number stays the same for a lease on the
reader's own clock: clocks of different machines are never compared. Members are placed whole and have the same bits
whoever computes them, so a claim that is taken over too early costs time and nothing else.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import socket
import threading
import time
import warnings
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

LEASE = 30.0  # s; a process that is silent for so long is taken to be gone
RENEWAL = 2.0  # s between two signs of life
_NAME = re.compile(r"[\w.-]{1,200}")
_CLAIM = re.compile(r"L\d+-\d{6,}")


class Claims:
    """The members that this process computes, and what it has seen of other processes.

    Parameters
    ----------
    place : Path
        The run folder.
    lease, renewal : float, optional
        Silence after which a process is taken to be gone, and time between two signs of life, s.
    """

    def __init__(self, place: Path, lease: float | None = None, renewal: float | None = None):
        self.folder = place / "claims"
        self.lease = LEASE if lease is None else lease
        self.renewal = RENEWAL if renewal is None else renewal
        self._host = re.sub(r"[^\w.-]", "-", socket.gethostname())[:64]
        self.name = f"{self._host}-{os.getpid()}-{secrets.token_hex(8)}"  # another one where host and number come again
        self.held: set[str] = set()
        self._seen: dict[str, tuple[bytes, float]] = {}
        self._warned = False
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._renew, daemon=True)

    def __enter__(self) -> Self:
        try:
            self.folder.mkdir(exist_ok=True)
            self._sign(0)
        except OSError as error:
            self._do_without(error)
        for name in _processes(self.folder):
            self._gone(name)  # from now on its silence counts
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give up the claims of this process, and remove those of processes that are gone."""
        self._end.set()
        self._thread.join()
        self.release_all()
        _remove(self.folder / f"process-{self.name}")
        for path in _listed(self.folder):
            if _CLAIM.fullmatch(path.name) and self._stale(path):
                _remove(path)
        for name in _processes(self.folder):
            if self._gone(name):
                _remove(self.folder / f"process-{name}")
        with suppress(OSError):  # others are at work, or it holds files that are not ours
            self.folder.rmdir()

    def take(self, claim: str) -> bool:
        """Claim a member, also from a process that is gone; False if another process computes it.

        Where claim files cannot be made, every claim succeeds, which is said once.
        """
        path = self.folder / claim
        try:
            for _ in range(2):  # once more after a stale claim was removed
                if self._create(path):
                    self.held.add(claim)
                    return True
                if not self._stale(path):
                    return False
                path.unlink(missing_ok=True)
        except OSError as error:
            self._do_without(error)
            return True
        return False  # another process was quicker

    def release(self, claim: str) -> None:
        """Give a claim up, unless another process has taken it over."""
        self.held.discard(claim)
        if _content(self.folder / claim) == self.name.encode():
            _remove(self.folder / claim)

    def release_all(self) -> None:
        """Give all claims of this process up."""
        for claim in list(self.held):
            self.release(claim)

    def claimed(self, claim: str) -> bool:
        """Whether another process computes a member, as far as is known."""
        path = self.folder / claim
        return path.exists() and claim not in self.held and not self._stale(path)

    def _create(self, path: Path) -> bool:
        self.folder.mkdir(exist_ok=True)  # the last process to leave removes it
        try:
            handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
        except FileExistsError:
            return False
        try:
            os.write(handle, self.name.encode())
        finally:
            os.close(handle)
        return True

    def _stale(self, path: Path) -> bool:
        """Whether the process that made a claim is gone; a claim that names none is stale after a lease."""
        content = _content(path)
        owner = content.decode(errors="replace")
        return self._gone(owner) if _NAME.fullmatch(owner) else self._silent(f"{path.name}/", content)

    def _gone(self, name: str) -> bool:
        content = _content(self.folder / f"process-{name}")
        return self._silent(name, content) or (name != self.name and _ended(content))

    def _silent(self, name: str, content: bytes) -> bool:
        """Whether this process has seen the same content for a lease."""
        now = time.monotonic()
        if name not in self._seen or self._seen[name][0] != content:
            self._seen[name] = content, now
        return now - self._seen[name][1] >= self.lease

    def _renew(self) -> None:
        count = 0
        while not self._end.wait(self.renewal):
            count += 1
            with suppress(OSError):  # the next time, or others compute the same members
                self._sign(count)

    def _sign(self, count: int) -> None:
        """Write a sign of life into the file of this process, in place: other machines see it when they open it."""
        text = json.dumps({"host": self._host, "pid": os.getpid(), "space": _space()})
        handle = os.open(self.folder / f"process-{self.name}", os.O_CREAT | os.O_WRONLY, 0o644)
        try:
            os.write(handle, f"{count:020d}\n{text}\n".encode())
        finally:
            os.close(handle)

    def _do_without(self, error: OSError) -> None:
        if not self._warned:
            self._warned = True
            warnings.warn(
                f"claims cannot be made in {self.folder} ({error.strerror}): the run goes on without them, and other "
                f"processes that work on it may compute the same members",
                RuntimeWarning,
                stacklevel=2,
            )


def working(place: Path) -> list[str]:
    """Return the processes that work on a run folder now, each as "process 12 on host".

    A process counts once it has given a sign of life while this function looks: for a few seconds at most, and not at
    all where no process has left a file.
    """
    folder = place / "claims"
    first = {name: _content(folder / f"process-{name}") for name in _processes(folder)}
    asked = {name for name, content in first.items() if not _ended(content)}
    alive: set[str] = set()
    end = time.monotonic() + 3.0 * RENEWAL
    while alive != asked and time.monotonic() < end:
        time.sleep(0.05)
        now = {name: _content(folder / f"process-{name}") for name in asked}
        alive |= {name for name, content in now.items() if content and content != first[name]}
        asked -= {name for name, content in now.items() if not content or _ended(content)} - alive
    found = (_told(first[name]) or {"pid": "?", "host": "?"} for name in sorted(alive))
    return [f"process {told['pid']} on {told['host']}" for told in found]


def writer(place: Path) -> str | None:
    """Return who computes a run now, as "process 12 on host" or "3 processes on 2 hosts"; None for nobody."""
    names = working(place)
    if len(names) < 2:
        return names[0] if names else None
    hosts = sorted({name.split(" on ", 1)[1] for name in names})
    return f"{len(names)} processes on {hosts[0] if len(hosts) == 1 else f'{len(hosts)} hosts'}"


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _processes(folder: Path) -> list[str]:
    names = (path.name.removeprefix("process-") for path in _listed(folder) if path.name.startswith("process-"))
    return [name for name in names if _NAME.fullmatch(name)]


def _content(path: Path) -> bytes:
    """The start of a small file; empty if there is none, it cannot be read, or it is no file."""
    try:
        if not path.is_file():  # a pipe would block
            return b""
        with open(path, "rb") as file:
            return file.read(4096)
    except OSError:
        return b""


def _remove(path: Path) -> None:
    with suppress(OSError):  # another process was quicker, or it is left over
        path.unlink()


def _told(content: bytes) -> dict[str, Any]:
    """What a process has written of itself; empty if that is nothing that one writes."""
    try:
        told = json.loads(content.partition(b"\n")[2])
        sound = isinstance(told["pid"], int) and _NAME.fullmatch(told["host"])
    except (ValueError, LookupError, TypeError, RecursionError):
        return {}
    return told if sound else {}


def _ended(content: bytes) -> bool:
    """Whether a process is known to have ended: one of this very machine and container, whose number is free."""
    told = _told(content)
    if told.get("space") is None or told["space"] != _space():
        return False
    try:
        os.kill(told["pid"], 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def _space() -> str | None:
    """The start of this machine and the container in it, within which a process number is unique; None if unknown."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot} {os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        return None
