"""Transforms of planes, rows and lines by FFTW: access to its functions, its threads, and a cache of plans.

Plans are made with FFTW_ESTIMATE, so the same machine and versions always give the same bits. A plan of pyfftw owns its
buffers, so each Python thread has plans of its own. `LinePlans` are plans of FFTW itself, which compiled loops call by
address, from any thread. Without pyfftw, scipy.fft takes over: with one warning, and `backend()` names the library for
the records.
"""

import ctypes
import operator
import os
import threading
import warnings
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy
from numpy.typing import DTypeLike

from roughsim.grid import Field

try:
    import pyfftw
except ImportError:  # the wheel of pyfftw bundles GPL code; some sites do without it
    pyfftw = None
    warnings.warn(
        "pyfftw is not installed: scipy.fft takes over, slower", RuntimeWarning, stacklevel=2
    )

Made = TypeVar("Made")
ALIGNMENT = 64  # bytes, of memory passed to FFTW by address
PADDING = 8  # complex numbers between lines, so that equal places do not all fall onto the same part of the cache
_ESTIMATE = 1 << 6 | 1 << 0  # FFTW_ESTIMATE, FFTW_DESTROY_INPUT
_WORD = ctypes.c_void_p
_INT = ctypes.c_int
_SIDE = [_WORD, _WORD, _INT, _INT]  # address, embedding, stride, distance
_SIGNATURES: dict[str, tuple[list[Any], Any]] = {
    "plan_many_dft": ([_INT, _WORD, _INT, *_SIDE, *_SIDE, _INT, ctypes.c_uint], _WORD),
    "plan_with_nthreads": ([_INT], None),
    "make_planner_thread_safe": ([], None),
    "execute_dft": ([ctypes.c_size_t] * 3, None),  # as numba takes addresses
    "destroy_plan": ([_WORD], None),
}
state = threading.local()  # plans and buffers of each Python thread
_threads = 1
_threaded = False  # whether FFTW has started threads of its own
# whether a fork has lost these threads: a transform that needs them would never end
_orphaned = False
# FFTW's planner, and its number of threads for the next plan, are process-wide
planning = threading.RLock()


def set_threads(count: int) -> None:
    """Set the number of threads of all later transforms in this process.

    Parameters
    ----------
    count : int
        At least 1.

    Raises
    ------
    ValueError
        If `count` is no whole number, or below 1.
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


def _plan_threads() -> int:
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


def _forget_plans() -> None:
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
        after_in_child=_forget_plans,
    )


def backend() -> str:
    """Name the library that computes the transforms, with its version."""
    if pyfftw is not None:
        return f"pyfftw {pyfftw.__version__}" + (
            "" if direct() else ", out of reach of compiled code"
        )
    return f"scipy.fft {scipy.__version__}"


def direct() -> bool:
    """Whether compiled loops can call FFTW."""
    return bool(FUNCTIONS)


def functions() -> dict[str, Any]:
    """Return the functions of the FFTW library that pyfftw has loaded, by name; none if any is out of reach.

    The planners wait for each other from then on.
    """
    if pyfftw is None:
        return {}
    names = [f"{prefix}_{name}" for prefix in ("fftw", "fftwf") for name in _SIGNATURES]
    by_name = {name: function(name) for name in names}
    if None in by_name.values():
        warnings.warn(
            "compiled code cannot reach the FFTW of pyfftw: contact solves and convolutions are slower",
            RuntimeWarning,
            stacklevel=3,
        )
        return {}
    for prefix in ("fftw", "fftwf"):
        by_name[f"{prefix}_make_planner_thread_safe"]()
    return by_name


def function(name: str) -> Any:
    """Return a function of the FFTW library that pyfftw has loaded; None if it is out of reach."""
    for path in libraries():
        try:
            library = ctypes.CDLL(str(path))
        except OSError:  # a file of such a name that is no library
            continue
        if hasattr(library, name):
            function = library[name]
            function.argtypes, function.restype = _SIGNATURES[name.split("_", 1)[1]]
            return function
    return None


def libraries() -> list[Path]:
    """Return the files in which FFTW's functions may be: pyfftw's extension module, and libraries beside it."""
    module = Path(pyfftw.pyfftw.__file__)
    folders = module.parent, module.parent.with_name("pyfftw.libs")
    return [module, *sorted(path for folder in folders for path in folder.glob("*fftw3*"))]


FUNCTIONS = functions()  # 2 ms when the module is loaded


def aligned(shape: tuple[int, int], dtype: Any) -> Field:
    """Return zeros that begin at a multiple of `ALIGNMENT` bytes."""
    size = shape[0] * shape[1] * np.dtype(dtype).itemsize
    memory = np.zeros(size + ALIGNMENT, np.uint8)
    start = -memory.ctypes.data % ALIGNMENT
    return memory[start : start + size].view(dtype).reshape(shape)


def thread_cache(kind: str, key: Any, make: Callable[[], Made], *, most: int) -> Made:
    """Return the entry of this Python thread under a key, or make it; the latest `most` of each kind are kept."""
    cache: dict[Any, Made] = state.__dict__.setdefault(kind, {})
    if key not in cache:
        if len(cache) >= most:
            with planning:  # dropping the object destroys its plan
                cache.pop(next(iter(cache)))
        cache[key] = make()
    return cache[key]


class Transform:
    """A pair of buffers joined by a real transform, for loops that must not allocate.

    Of the plane: `forward()` fills `spectrum` with (1/N) Σ field·exp(−iq·x), and `inverse()` fills `field` with Σ
    spectrum·exp(+iq·x) and destroys `spectrum`. With `axes=(1,)` the rows are transformed each by itself, neither
    direction is scaled, and each destroys its input. It does not survive a fork: its threads are gone there.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: DTypeLike = np.float64,
        *,
        axes: tuple[int, ...] = (0, 1),
    ):
        real = np.dtype(dtype)
        if real not in (np.dtype(np.float64), np.dtype(np.float32)):
            raise TypeError(f"dtype = {real} is not supported; use float32 or float64")
        half = shape[1] // 2 + 1
        plane = axes == (0, 1)
        self.axes = axes
        self.scale = 1.0 / (shape[0] * shape[1]) if plane else None
        self.field = aligned(shape, real)
        # columns are read from the spectra of rows: padding keeps the entries of a column apart in the cache
        width = half if plane else half + PADDING - 1
        self.spectrum = aligned((shape[0], width), np.result_type(real, np.complex64))[:, :half]
        if pyfftw is None:
            return
        flags = ("FFTW_ESTIMATE",) if plane else ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")
        options = {"axes": axes, "flags": flags, "threads": _plan_threads()}
        with planning:
            self.there = pyfftw.FFTW(self.field, self.spectrum, **options)
            self.back = pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options)

    def forward(self) -> Field:
        """Transform `field` into `spectrum` and return the latter."""
        if pyfftw is None:
            self.spectrum[...] = scipy.fft.rfftn(self.field, axes=self.axes, workers=get_threads())
        else:
            self.there.execute()
        if self.scale is not None:
            np.multiply(self.spectrum, self.scale, out=self.spectrum)
        return self.spectrum

    def inverse(self) -> Field:
        """Transform `spectrum` into `field` and return the latter; `spectrum` is destroyed."""
        if pyfftw is None:
            points = [self.field.shape[axis] for axis in self.axes]
            self.field[...] = scipy.fft.irfftn(
                self.spectrum, s=points, axes=self.axes, norm="forward", workers=get_threads()
            )
        else:
            self.back.execute()
        return self.field


def transform(
    shape: tuple[int, int], dtype: DTypeLike, axes: tuple[int, ...] = (0, 1)
) -> Transform:
    """Return a `Transform` that belongs to this Python thread; its buffers are large, so few are kept."""
    key = shape, np.dtype(dtype).char, get_threads()
    most = 4 if axes == (0, 1) else 2
    return thread_cache(
        f"transforms over {axes}", key, lambda: Transform(shape, dtype, axes=axes), most=most
    )


class LinePlans:
    """FFTW's plans for complex lines, by address, for compiled loops: for any buffers and from any thread.

    `execute(forward, source, result)` transforms the lines at the address `source`, `distances[0]` complex numbers
    apart, to the lines at `result`, `distances[1]` apart; `execute(backward, result, source)` goes back. Neither
    direction is scaled, and each destroys its input. Memory begins at multiples of `ALIGNMENT` bytes.
    """

    def __init__(self, count: int, points: int, distances: tuple[int, int], dtype: Any):
        kind = np.result_type(dtype, np.complex64)
        source, result = (aligned((count, distance), kind) for distance in distances)
        near, far = (
            (a.ctypes.data, None, 1, d) for a, d in zip((source, result), distances, strict=True)
        )
        prefix = "fftwf" if kind == np.complex64 else "fftw"
        fftw = FUNCTIONS
        make = fftw[f"{prefix}_plan_many_dft"]
        destroy = fftw[f"{prefix}_destroy_plan"]
        common = 1, ctypes.byref(ctypes.c_int(points)), count
        with planning:
            fftw[f"{prefix}_plan_with_nthreads"](1)
            self.forward = make(*common, *near, *far, -1, _ESTIMATE)
            self.backward = make(*common, *far, *near, +1, _ESTIMATE)
        self.execute = fftw[f"{prefix}_execute_dft"]
        weakref.finalize(self, _destroy_plans, destroy, self.forward, self.backward).atexit = False
        if not (self.forward and self.backward):
            raise MemoryError(
                f"FFTW has no plan for {count} lines of {points} points: not enough memory"
            )


def _destroy_plans(destroy: Callable[[int | None], None], *plans: int | None) -> None:
    """Hand plans back to FFTW."""
    with planning:
        for plan in plans:
            if plan:
                destroy(plan)


class Lines:
    """A few complex lines, transformed along the last axis from `source` to `result` and back.

    Neither direction is scaled, and each destroys its input. Out of place, since FFTW is twice as slow in place when it
    plans by estimate. `source_pairs` and `result_pairs` show the same memory, its padding included, as (real,
    imaginary) pairs.
    """

    def __init__(self, count: int, points: int, dtype: DTypeLike = np.float64):
        complex_type = np.result_type(dtype, np.complex64)
        padded = [aligned((count, points + PADDING), complex_type) for _ in range(2)]
        self.source, self.result = (buffer[:, :points] for buffer in padded)
        # contiguous, for kernels
        self.source_pairs, self.result_pairs = (buffer.view(dtype) for buffer in padded)
        self._ends = self.source.ctypes.data, self.result.ctypes.data
        distances = points + PADDING, points + PADDING
        self.plans = LinePlans(count, points, distances, np.dtype(dtype)) if direct() else None

    def forward(self) -> None:
        """Transform `source` into `result`."""
        if self.plans is None:
            self.result[...] = scipy.fft.fft(self.source, axis=1)
        else:
            self.plans.execute(self.plans.forward, *self._ends)

    def backward(self) -> None:
        """Transform `result` into `source`."""
        if self.plans is None:
            self.source[...] = scipy.fft.ifft(self.result, axis=1, norm="forward")
        else:
            self.plans.execute(self.plans.backward, *self._ends[::-1])


def lines(count: int, points: int, dtype: DTypeLike) -> Lines:
    """Return `Lines` that belong to this Python thread; their buffers are small and kept for the next call."""
    key = count, points, dtype
    return thread_cache("lines", key, lambda: Lines(*key), most=64)


def forward(field: Field) -> Field:
    """Return the half spectrum f(q) = (1/N) Σ_x f(x) exp(−iq·x), shape (n_x, n_y//2 + 1), of a real field."""
    return transformed(field).copy()


def transformed(field: Field) -> Field:
    """Return `forward` of a field in the buffer of this Python thread: the next transform of the shape changes it."""
    buffers = transform((field.shape[0], field.shape[1]), field.dtype)
    buffers.field[...] = field
    return buffers.forward()


def inverse(spectrum: Field, shape: tuple[int, int]) -> Field:
    """Return the real field f(x) = Σ_q f(q) exp(+iq·x) of `shape` from its half spectrum; ValueError if of another."""
    half = (shape[0], shape[1] // 2 + 1)
    if spectrum.shape != half:  # numpy would broadcast it silently
        raise ValueError(
            f"spectrum has shape {spectrum.shape}, but a field of shape {shape} needs {half}"
        )
    buffers = transform(shape, spectrum.real.dtype)
    buffers.spectrum[...] = spectrum
    return buffers.inverse().copy()
