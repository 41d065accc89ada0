"""Signals that end a run as Ctrl-C does: what is stored stays, processes end, and claims are given up."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stopped_by_signals() -> Iterator[Callable[[], None]]:
    """Let SIGTERM, and SIGHUP of a terminal that is closed, end a run as Ctrl-C does.

    Yields a function that raises an interrupt which Python has dropped: Python drops an exception that comes up inside
    a finalizer, of an HDF5 object for instance, and the run would go on. Only the main thread of a process can arrange
    signals; a handler of the program's own for SIGINT or SIGHUP is left alone, and so is a SIGHUP that `nohup` ignores.
    """
    asked = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        asked.set()
        raise KeyboardInterrupt

    def check() -> None:
        if asked.is_set():
            raise KeyboardInterrupt

    before = {}
    if threading.current_thread() is threading.main_thread():
        before[signal.SIGTERM] = signal.signal(signal.SIGTERM, stop)
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            before[signal.SIGINT] = signal.signal(signal.SIGINT, stop)
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:
            before[signal.SIGHUP] = signal.signal(signal.SIGHUP, stop)
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
