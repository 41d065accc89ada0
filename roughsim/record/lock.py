"""One writer per run folder."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from roughsim.errors import RecordError


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Hold the run folder for writing; the lock of a dead owner on this host is taken over.

    Raises
    ------
    RecordError
        If another process writes to this run, naming it.
    """
    path = folder / "lock"
    mine = json.dumps({"host": socket.gethostname(), "pid": os.getpid()})
    if not _create(path, mine):
        owner = _owner(path)
        if _alive(owner):
            raise RecordError(
                f"{folder} is being written by process {owner.get('pid')} on {owner.get('host')}; wait for it, or "
                f"delete {path} if that process is gone"
            )
        path.unlink(missing_ok=True)
        if not _create(path, mine):
            raise RecordError(f"{folder} was taken by another process at this moment; try again")
    try:
        yield
    finally:
        path.unlink(missing_ok=True)


def writer(folder: Path) -> str | None:
    """Return who writes to a run folder now, as "process 12 on host"; None if nobody does."""
    owner = _owner(folder / "lock")
    return f"process {owner.get('pid')} on {owner.get('host')}" if _alive(owner) else None


def _create(path: Path, text: str) -> bool:
    try:
        handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
    except FileExistsError:
        return False
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    return True


def _owner(path: Path) -> dict[str, object]:
    if not path.is_file():  # a pipe would block
        return {}
    try:
        owner = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return owner if isinstance(owner, dict) else {}


def _alive(owner: dict[str, object]) -> bool:
    """Whether the owner may still run: unknown owners on other hosts are taken to be alive."""
    if owner.get("host") != socket.gethostname():
        return "host" in owner
    try:
        os.kill(int(str(owner.get("pid"))), 0)
    except (ProcessLookupError, ValueError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
