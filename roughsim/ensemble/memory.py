"""Memory that arrays have left: whether a process keeps it for the next ones, or the system gets it back.

To get it anew takes 4 % of the time of members of 1024², and 15 to 24 % where their arrays have more than 32 MB: the C
library then asks the system for each of them, and the system fills it with zeros.
"""

import ctypes
from contextlib import suppress
from dataclasses import dataclass

SOME = 128 << 20  # bytes that any process may keep: also one of the caller's, where memory may be watched
MUCH = (1 << 31) - 1  # bytes that a process of a run may keep, until it ends: the most that the C library can be told
FREE, PAGES = -1, -3  # of mallopt: bytes that may lie free, and those from which on an array has pages of its own
SHARE = 3  # of the bytes that are kept, an array has at most one in so many


@dataclass(slots=True)
class Kept:
    """How much this process keeps, bytes; 0: as it was."""

    most: int = 0


_kept = Kept()


def keep_freed_memory(most: int = SOME) -> None:
    """Let this process keep so many bytes that arrays have left; if it keeps more already, that stays."""
    if most > _kept.most:
        _kept.most = most
        with suppress(AttributeError, OSError, TypeError):  # another C library
            allocator = ctypes.CDLL(None)
            allocator.mallopt(FREE, most)
            allocator.mallopt(PAGES, most // SHARE)


def give_memory_back() -> None:
    """Give the system what lies free, and keep less from now on."""
    _kept.most = 0
    keep_freed_memory()
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)
