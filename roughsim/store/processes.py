"""Which processes work on a run folder: each gives signs of life in a small file of its own.

``RUN/claims/process-NAME`` holds a number that its process raises every few seconds. A process is gone when the number
stays the same for a lease on the reader's own clock: clocks of different machines are never compared.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

RENEWAL = 2.0  # s between two signs of life
PROCESS_NAME = re.compile(r"[\w.-]{1,200}")
_FILE = re.compile(rf"process-{PROCESS_NAME.pattern}")


class SignsOfLife:
    """What this process writes of itself into a folder, again and again until `stop`."""

    def __init__(self, folder: Path, renewal: float):
        self._host = re.sub(r"[^\w.-]", "-", socket.gethostname())[:64]
        # the last part tells it from a process of the same host and number before or after it
        self.name = f"{self._host}-{os.getpid()}-{secrets.token_hex(8)}"
        self.path = folder / f"process-{self.name}"
        self._renewal = renewal
        self._end = threading.Event()
        self._thread = threading.Thread(target=self.keep_signing, daemon=True)

    def sign(self, count: int) -> None:
        """Write the sign number `count`; OSError if the disk refuses."""
        text = json.dumps({"host": self._host, "pid": os.getpid(), "space": process_space()})
        write_in_place(self.path, f"{count:020d}\n{text}\n")

    def start(self) -> None:
        """Go on with the signs in a thread."""
        self._thread.start()

    def keep_signing(self) -> None:
        """Raise the number until the end."""
        count = 0
        while not self._end.wait(self._renewal):
            count += 1
            with suppress(OSError):  # the next one may succeed, or others compute the same members
                self.sign(count)

    def stop(self) -> None:
        """End the thread and remove the file."""
        self._end.set()
        self._thread.join()
        remove(self.path)


def working(run_folder: Path) -> list[str]:
    """Return the processes that work on a run folder now, each as "process 12 on host".

    A process counts once it has given a sign of life while this function looks: for a few seconds at most, and not at
    all where no process has left a file.
    """
    first = {path: start_of(path) for path in process_files(run_folder / "claims")}
    waiting = {path for path, content in first.items() if not has_ended(content)}
    alive: set[Path] = set()
    end = time.monotonic() + 3.0 * RENEWAL
    while waiting and time.monotonic() < end:
        time.sleep(0.05)
        now = {path: start_of(path) for path in waiting}
        alive |= {path for path, content in now.items() if content and content != first[path]}
        waiting -= alive | {path for path, content in now.items() if not content or has_ended(content)}
    signatures = (signature(first[path]) for path in sorted(alive))
    return [f"process {signed.get('pid', '?')} on {signed.get('host', '?')}" for signed in signatures]


def writer(run_folder: Path) -> str | None:
    """Return who computes a run now, as "process 12 on host" or "3 processes on 2 hosts"; None for nobody."""
    names = working(run_folder)
    if len(names) < 2:
        return names[0] if names else None
    hosts = sorted({name.split(" on ", 1)[1] for name in names})
    return f"{len(names)} processes on {hosts[0] if len(hosts) == 1 else f'{len(hosts)} hosts'}"


def process_files(folder: Path) -> list[Path]:
    """Return the files in which processes give signs of life."""
    return listed(folder, _FILE)


def listed(folder: Path, name: re.Pattern[str]) -> list[Path]:
    """Return what lies in a folder under such names, sorted; nothing where it cannot be read."""
    try:
        return sorted(path for path in folder.iterdir() if name.fullmatch(path.name))
    except OSError:
        return []


def start_of(path: Path) -> bytes:
    """Return the start of a small file; empty if there is none, it cannot be read, or it is no file."""
    try:
        if not path.is_file():  # a pipe would block
            return b""
        with open(path, "rb") as file:
            return file.read(4096)
    except OSError:
        return b""


def write_in_place(path: Path, text: str, flags: int = 0) -> None:
    """Write a small file without moving it, so that other machines see it when they open it."""
    handle = os.open(path, os.O_CREAT | os.O_WRONLY | flags, 0o644)
    try:
        os.write(handle, text.encode())
    finally:
        os.close(handle)


def remove(path: Path) -> None:
    """Remove a file if it is there and may be removed; another process may be quicker."""
    with suppress(OSError):
        path.unlink()


def signature(content: bytes) -> dict[str, Any]:
    """Return what a process has written of itself: host, pid and space; empty if no process writes such."""
    try:
        signed: dict[str, Any] = json.loads(content.partition(b"\n")[2])
        sound = isinstance(signed["pid"], int) and PROCESS_NAME.fullmatch(signed["host"])
    except (ValueError, LookupError, TypeError, RecursionError):
        return {}
    return signed if sound else {}


def has_ended(content: bytes) -> bool:
    """Whether a process is known to have ended: one of this very machine and container, whose number is free."""
    signed = signature(content)
    if signed.get("space") is None or signed["space"] != process_space():
        return False
    try:
        os.kill(signed["pid"], 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def process_space() -> str | None:
    """Return the start of this machine and the container, within which a process number is unique; None if unknown."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot} {os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        return None
