"""Real two-dimensional Fourier transforms: the one door to FFTW.

Plans are made with FFTW_ESTIMATE, so the same machine and versions always give the same bits. Each Python thread
has plans of its own (an FFTW plan object owns its buffers). Without pyfftw, scipy.fft takes over; this is announced
once and `backend()` names it for the records.
"""

from __future__ import annotations

import operator
import os
import threading
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

try:
    import pyfftw
except ImportError:  # the wheel of pyfftw bundles GPL code; some sites do without it
    pyfftw = None
    warnings.warn("pyfftw is not installed: scipy.fft takes over, slower", RuntimeWarning, stacklevel=2)

PADDING = 8  # complex numbers between lines, so that equal places do not all fall onto the same part of the cache
_state = threading.local()
_threads = 1
_threaded = False  # whether FFTW has been asked for threads of its own
_orphaned = False  # whether they were lost in a fork: what waits for them waits for ever


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


def _after_fork() -> None:
    """Forget in a forked process the plans of its parent, whose threads are gone."""
    global _orphaned  # noqa: PLW0603
    _orphaned = _orphaned or (_threaded and pyfftw is not None)
    _state.__dict__.clear()


if hasattr(os, "register_at_fork"):  # there is no fork elsewhere
    os.register_at_fork(after_in_child=_after_fork)


def backend() -> str:
    """Name the library that computes the transforms, with its version."""
    if pyfftw is not None:
        return f"pyfftw {pyfftw.__version__}"
    import scipy

    return f"scipy.fft {scipy.__version__}"


class Transform:
    """A pair of buffers joined by a real 2-D transform, for loops that must not allocate.

    `forward()` fills `spectrum` with (1/N) Σ field·exp(−iq·x); `inverse()` fills `field` with Σ spectrum·exp(+iq·x)
    and destroys `spectrum`. With `normalized=False` the factor 1/N is left to the caller.
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike = np.float64, *, normalized: bool = True):
        real = np.dtype(dtype)
        if real not in (np.dtype(np.float64), np.dtype(np.float32)):
            raise TypeError(f"dtype = {real} is not supported; use float32 or float64")
        half = (shape[0], shape[1] // 2 + 1)
        complex_type = np.result_type(real, np.complex64)
        self.scale = 1.0 / (shape[0] * shape[1]) if normalized else None
        self.field: NDArray[Any]
        self.spectrum: NDArray[Any]
        self._plans: tuple[Any, Any] | None = None
        if pyfftw is None:
            self.field, self.spectrum = np.zeros(shape, real), np.zeros(half, complex_type)
            return
        self.field = pyfftw.zeros_aligned(shape, real)
        self.spectrum = pyfftw.zeros_aligned(half, complex_type)
        self._plan()

    def _plan(self) -> None:
        options: dict[str, Any] = {"axes": (0, 1), "flags": ("FFTW_ESTIMATE",), "threads": _plan_threads()}
        self._process = os.getpid()
        self._plans = (
            pyfftw.FFTW(self.field, self.spectrum, **options),
            pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options),
        )

    def _execute(self, plan: int) -> None:
        if self._process != os.getpid():  # plans with threads do not survive a fork
            self._plan()
        if self._plans is not None:
            self._plans[plan].execute()

    def forward(self) -> NDArray[Any]:
        """Transform `field` into `spectrum` and return the latter."""
        if self._plans is None:
            from scipy import fft

            self.spectrum[...] = fft.rfft2(self.field, workers=_threads)
        else:
            self._execute(0)
        if self.scale is not None:
            np.multiply(self.spectrum, self.scale, out=self.spectrum)
        return self.spectrum

    def inverse(self) -> NDArray[Any]:
        """Transform `spectrum` into `field` and return the latter; `spectrum` is destroyed."""
        if self._plans is None:
            from scipy import fft

            self.field[...] = fft.irfft2(self.spectrum, s=self.field.shape, norm="forward", workers=_threads)
        else:
            self._execute(1)
        return self.field


class Lines:
    """A few complex lines, transformed along the last axis from `source` to `result` and back.

    Neither direction is scaled, and each destroys what it starts from. Out of place, since FFTW is twice as slow in
    place when it plans by estimate. `source_pairs` and `result_pairs` show the same memory, its padding included, as
    (real, imaginary) pairs.
    """

    def __init__(self, count: int, points: int, dtype: DTypeLike = np.float64):
        complex_type = np.result_type(dtype, np.complex64)
        make = np.zeros if pyfftw is None else pyfftw.zeros_aligned
        padded = [make((count, points + PADDING), complex_type) for _ in range(2)]
        self.source, self.result = (buffer[:, :points] for buffer in padded)
        self.source_pairs, self.result_pairs = (buffer.view(dtype) for buffer in padded)  # contiguous, for kernels
        self.forward: Callable[[], object]
        self.backward: Callable[[], object]
        if pyfftw is None:
            self.forward, self.backward = self._scipy_forward, self._scipy_backward
            return
        options: dict[str, Any] = {"axes": (1,), "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"), "threads": 1}
        self.forward = pyfftw.FFTW(self.source, self.result, **options).execute
        self.backward = pyfftw.FFTW(self.result, self.source, direction="FFTW_BACKWARD", **options).execute

    def _scipy_forward(self) -> None:
        from scipy import fft

        self.result[...] = fft.fft(self.source, axis=1)

    def _scipy_backward(self) -> None:
        from scipy import fft

        self.source[...] = fft.ifft(self.result, axis=1, norm="forward")


def lines(count: int, points: int, dtype: DTypeLike) -> Lines:
    """Return `Lines` that belong to this Python thread; their buffers are small and kept for the next call."""
    cache = _state.__dict__.setdefault("lines", {})
    key = count, points, dtype
    if key not in cache:
        if len(cache) >= 64:
            cache.pop(next(iter(cache)))
        cache[key] = Lines(count, points, dtype)
    result: Lines = cache[key]
    return result


class Rows:
    """Real rows, transformed along the last axis and back; neither direction is scaled."""

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike):
        complex_type = np.result_type(dtype, np.complex64)
        make = np.zeros if pyfftw is None else pyfftw.zeros_aligned
        self.field: NDArray[Any] = make(shape, dtype)
        self.spectrum: NDArray[Any] = make((shape[0], shape[1] // 2 + PADDING), complex_type)[:, : shape[1] // 2 + 1]
        self.forward: Callable[[], object]
        self.backward: Callable[[], object]
        if pyfftw is None:
            self.forward, self.backward = self._scipy_forward, self._scipy_backward
            return
        options: dict[str, Any] = {
            "axes": (1,),
            "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"),
            "threads": _plan_threads(),
        }
        self.forward = pyfftw.FFTW(self.field, self.spectrum, **options).execute
        self.backward = pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options).execute

    def _scipy_forward(self) -> None:
        from scipy import fft

        self.spectrum[...] = fft.rfft(self.field, axis=1)

    def _scipy_backward(self) -> None:
        from scipy import fft

        self.field[...] = fft.irfft(self.spectrum, n=self.field.shape[1], axis=1, norm="forward")


def rows(shape: tuple[int, int], dtype: DTypeLike) -> Rows:
    """Return `Rows` that belong to this Python thread, kept for the next call; their buffers are large."""
    cache = _state.__dict__.setdefault("rows", {})
    key = (shape, np.dtype(dtype).char, _threads)
    if key not in cache:
        if len(cache) >= 2:  # buffers are large
            cache.pop(next(iter(cache)))
        cache[key] = Rows(shape, dtype)
    result: Rows = cache[key]
    return result


def _transform(shape: tuple[int, int], dtype: DTypeLike) -> Transform:
    cache = _state.__dict__.setdefault("cache", {})
    key = (shape, np.dtype(dtype).char, _threads)
    if key not in cache:
        if len(cache) >= 4:  # buffers are large: keep the latest few
            cache.pop(next(iter(cache)))
        cache[key] = Transform(shape, dtype)
    result: Transform = cache[key]
    return result


def forward(field: NDArray[Any]) -> NDArray[Any]:
    """Return the half spectrum f(q) = (1/N) Σ_x f(x) exp(−iq·x), shape (n_x, n_y//2 + 1), of a real field."""
    transform = _transform(field.shape, field.dtype)
    transform.field[...] = field
    return transform.forward().copy()


def inverse(spectrum: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    """Return the real field f(x) = Σ_q f(q) exp(+iq·x) of `shape` from its half spectrum.

    Raises
    ------
    ValueError
        If the half spectrum does not belong to `shape`.
    """
    half = (shape[0], shape[1] // 2 + 1)
    if spectrum.shape != half:  # it would be broadcast
        raise ValueError(f"spectrum has shape {spectrum.shape}, but a field of shape {shape} needs {half}")
    transform = _transform(shape, spectrum.real.dtype)
    transform.spectrum[...] = spectrum
    return transform.inverse().copy()
