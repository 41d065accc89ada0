"""FFTW itself: found beside pyfftw, called by address, its threads, and what a fork leaves of it.

Without pyfftw, scipy.fft takes over; this is announced once and `backend()` names it for the records.
"""

from __future__ import annotations

import ctypes
import operator
import os
import threading
import warnings
from functools import cache
from pathlib import Path
from typing import Any

try:
    import pyfftw as pyfftw  # noqa: PLC0414  (`plans` asks for it here)
except ImportError:  # the wheel of pyfftw bundles GPL code; some sites do without it
    pyfftw = None
    warnings.warn("pyfftw is not installed: scipy.fft takes over, slower", RuntimeWarning, stacklevel=2)

WORD, _INT = ctypes.c_void_p, ctypes.c_int
_SIDE = [WORD, WORD, _INT, _INT]  # address, embedding, stride, distance
_SIGNATURES: dict[str, tuple[list[Any], Any]] = {
    "plan_many_dft": ([_INT, WORD, _INT, *_SIDE, *_SIDE, _INT, ctypes.c_uint], WORD),
    "plan_with_nthreads": ([_INT], None),
    "make_planner_thread_safe": ([], None),
    "execute_dft": ([WORD, WORD, WORD], None),
    "destroy_plan": ([WORD], None),
}
state = threading.local()  # plans and buffers of each Python thread
_threads = 1
_threaded = False  # whether FFTW has been asked for threads of its own
_orphaned = False  # whether they were lost in a fork: what waits for them waits for ever
planning = threading.RLock()  # the number of threads of the next plan belongs to the process


def set_threads(count: int) -> None:
    """Set the number of threads of every later transform in this process.

    Raises
    ------
    ValueError
        If `count` is not a whole number ≥ 1.
    """
    global _threads  # noqa: PLW0603  (process-wide by contract)
    try:
        whole = 0 if isinstance(count, bool) else operator.index(count)
    except TypeError:
        whole = 0
    if whole < 1:
        raise ValueError(f"threads = {count!r} must be a whole number ≥ 1")
    _threads = whole


def get_threads() -> int:
    """Return the number of threads that transforms use in this process."""
    return _threads


def plan_threads() -> int:
    """Return how many threads FFTW may plan for."""
    global _threaded  # noqa: PLW0603
    if _threads > 1 and _orphaned:
        warnings.warn(
            f"this process was forked from one with threads of FFTW, which do not survive that: transforms use one "
            f"thread, not {_threads}; start worker processes by spawn or forkserver",
            RuntimeWarning,
            stacklevel=4,
        )
        return 1
    _threaded = _threaded or _threads > 1
    return _threads


def forget_plans() -> None:
    """Forget in a forked process the plans of its parent, whose threads are gone."""
    global _orphaned, planning  # noqa: PLW0603
    planning = threading.RLock()
    _orphaned = _orphaned or (_threaded and pyfftw is not None)
    state.__dict__.clear()


if hasattr(os, "register_at_fork"):  # there is no fork elsewhere
    # wait for plans in the making: their threads are gone in the child, and FFTW's planner would stay locked there
    os.register_at_fork(
        before=lambda: planning.acquire(),  # noqa: PLW0108  (each fork makes a new lock)
        after_in_parent=lambda: planning.release(),  # noqa: PLW0108
        after_in_child=forget_plans,
    )


def backend() -> str:
    """Name the library that computes the transforms, with its version."""
    if pyfftw is not None:
        return f"pyfftw {pyfftw.__version__}" + ("" if direct() else ", out of reach of compiled code")
    import scipy

    return f"scipy.fft {scipy.__version__}"


@cache
def direct() -> bool:
    """Whether compiled loops can call FFTW: find its functions, and have its planners wait for each other."""
    if pyfftw is None:
        return False
    if None in [function(f"{prefix}_{name}") for prefix in ("fftw", "fftwf") for name in _SIGNATURES]:
        warnings.warn(
            "compiled code cannot reach the FFTW of pyfftw: contact solves and convolutions are slower",
            RuntimeWarning,
            stacklevel=2,
        )
        return False
    for prefix in ("fftw", "fftwf"):
        function(f"{prefix}_make_planner_thread_safe")()
    return True


@cache
def function(name: str) -> Any:
    """Return a function of the FFTW that pyfftw has loaded; None if there is none."""
    for path in libraries():
        try:
            library = ctypes.CDLL(str(path))
        except OSError:  # of that name, but no library
            continue
        if hasattr(library, name):
            function = library[name]
            function.argtypes, function.restype = _SIGNATURES[name.split("_", 1)[1]]
            return function
    return None


def libraries() -> list[Path]:
    """Where FFTW may be: pyfftw's extension module, which mostly gives all it is linked with, or files beside it."""
    module = Path(pyfftw.pyfftw.__file__)
    folders = module.parent, module.parent.with_name("pyfftw.libs")
    return [module, *sorted(path for folder in folders for path in folder.glob("*fftw3*"))]
