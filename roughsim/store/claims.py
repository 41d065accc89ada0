"""Who computes what in a run folder: claims spare several processes the same work, and nothing depends on them.

``RUN/claims/L0-000003`` holds the name of the process that computes this member. Members are placed whole and have the
same bits whoever computes them, so a claim that is taken over too early costs time and nothing else.
"""

from __future__ import annotations

import os
import time
import warnings
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from roughsim.store import processes
from roughsim.store.member_files import MEMBER_NAME
from roughsim.store.processes import (
    PROCESS_NAME,
    SignsOfLife,
    has_ended,
    listed,
    process_files,
    remove,
    start_of,
    write_in_place,
)

LEASE = 30.0  # s; a process that is silent for so long is taken to be gone


class Claims:
    """The members that this process computes, and what it has seen of other processes.

    `lease` and `renewal`, s, replace the `LEASE` of this module and the `RENEWAL` of `processes`.
    """

    def __init__(self, run_folder: Path, lease: float | None = None, renewal: float | None = None):
        self.folder = run_folder / "claims"
        self.lease = LEASE if lease is None else lease
        self.signs = SignsOfLife(self.folder, processes.RENEWAL if renewal is None else renewal)
        self.held: set[str] = set()
        self._seen: dict[str, tuple[bytes, float]] = {}  # name of a file → content, and when it was first seen, s
        self._warned = False

    def __enter__(self) -> Self:
        try:
            self.folder.mkdir(exist_ok=True)
            self.signs.sign(0)
        except OSError as error:
            self._go_on_without(error)
        for path in process_files(self.folder):
            self._is_silent(path)  # from now on its silence counts
        self.signs.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give up the claims of this process, and remove those of processes that are gone."""
        self.release_all()
        self.signs.stop()
        for path in listed(self.folder, MEMBER_NAME):
            if self._is_stale(path):
                remove(path)
        for path in process_files(self.folder):  # after the claims, which are judged by these files
            if self._is_silent(path):
                remove(path)
        with suppress(OSError):  # others are at work, or it holds files that are not ours
            self.folder.rmdir()

    def take(self, claim: str) -> bool:
        """Claim a member, also from a process that is gone; False if another process computes it.

        Where claim files cannot be made, every claim succeeds, which is said once.
        """
        path = self.folder / claim
        try:
            for _ in range(2):  # once more after a stale claim was removed
                self.folder.mkdir(exist_ok=True)  # the last process to leave removes it
                with suppress(FileExistsError):
                    write_in_place(path, self.signs.name, os.O_EXCL)
                    self.held.add(claim)
                    return True
                if not self._is_stale(path):
                    return False
                path.unlink(missing_ok=True)
        except OSError as error:
            self._go_on_without(error)
            return True
        return False  # another process was quicker

    def release(self, claim: str) -> None:
        """Give a claim up, unless another process has taken it over."""
        self.held.discard(claim)
        if start_of(self.folder / claim) == self.signs.name.encode():
            remove(self.folder / claim)

    def release_all(self) -> None:
        """Give all claims of this process up."""
        for claim in list(self.held):
            self.release(claim)

    def claimed(self, claim: str) -> bool:
        """Whether another process computes a member, as far as is known."""
        path = self.folder / claim
        return path.exists() and claim not in self.held and not self._is_stale(path)

    def _is_stale(self, path: Path) -> bool:
        """Whether the process that made a claim is gone; a claim that names none is stale after a lease."""
        owner = start_of(path).decode(errors="replace")
        return self._is_silent(self.folder / f"process-{owner}" if PROCESS_NAME.fullmatch(owner) else path)

    def _is_silent(self, path: Path) -> bool:
        """Whether a file has had the same content for a lease, or is of a process that is known to have ended."""
        content, now = start_of(path), time.monotonic()
        if path.name not in self._seen or self._seen[path.name][0] != content:
            self._seen[path.name] = content, now
        return now - self._seen[path.name][1] >= self.lease or (path != self.signs.path and has_ended(content))

    def _go_on_without(self, error: OSError) -> None:
        if not self._warned:
            self._warned = True
            warnings.warn(
                f"claims cannot be made in {self.folder} ({error.strerror}): the run goes on without them, and other "
                f"processes that work on it may compute the same members",
                RuntimeWarning,
                stacklevel=2,
            )
