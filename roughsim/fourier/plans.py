"""Real two-dimensional transforms, lines and rows, with plans that are kept.

Plans are made with FFTW_ESTIMATE, so the same machine and versions always give the same bits. Each Python thread
has plans of its own (a plan object of pyfftw owns its buffers), but for `LinePlans`, which are FFTW's own, called by
address from compiled loops.
"""

from __future__ import annotations

import ctypes
import os
import weakref
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughsim.fourier import library

ALIGNMENT = 64  # bytes, of what is handed to FFTW by address
PADDING = 8  # complex numbers between lines, so that equal places do not all fall onto the same part of the cache
_ESTIMATE = 1 << 6 | 1 << 0  # FFTW_ESTIMATE, FFTW_DESTROY_INPUT


def aligned(shape: tuple[int, int], dtype: Any) -> NDArray[Any]:
    """Return zeros that begin at a multiple of `ALIGNMENT` bytes."""
    size = shape[0] * shape[1] * np.dtype(dtype).itemsize
    memory = np.zeros(size + ALIGNMENT, np.uint8)
    start = -memory.ctypes.data % ALIGNMENT
    result: NDArray[Any] = memory[start : start + size].view(dtype).reshape(shape)
    return result


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
        if library.pyfftw is None:
            self.field, self.spectrum = np.zeros(shape, real), np.zeros(half, complex_type)
            return
        self.field = aligned(shape, real)
        self.spectrum = aligned(half, complex_type)
        self._plan()

    def _plan(self) -> None:
        options: dict[str, Any] = {"axes": (0, 1), "flags": ("FFTW_ESTIMATE",), "threads": library.plan_threads()}
        self._process = os.getpid()
        with library.planning:
            self._plans = (
                library.pyfftw.FFTW(self.field, self.spectrum, **options),
                library.pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options),
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

            self.spectrum[...] = fft.rfft2(self.field, workers=library.get_threads())
        else:
            self._execute(0)
        if self.scale is not None:
            np.multiply(self.spectrum, self.scale, out=self.spectrum)
        return self.spectrum

    def inverse(self) -> NDArray[Any]:
        """Transform `spectrum` into `field` and return the latter; `spectrum` is destroyed."""
        if self._plans is None:
            from scipy import fft

            self.field[...] = fft.irfft2(
                self.spectrum, s=self.field.shape, norm="forward", workers=library.get_threads()
            )
        else:
            self._execute(1)
        return self.field


class LinePlans:
    """FFTW's plans for complex lines, by address: what compiled loops call, for any buffers and from any thread.

    `execute(forward, source, result)` transforms the lines at the address `source`, `distances[0]` complex numbers
    apart, to those at `result`, `distances[1]` apart; `execute(backward, result, source)` goes back. `addresses` are
    those of the three. Neither direction is scaled, and each destroys what it starts from. Memory begins at multiples
    of `ALIGNMENT` bytes.
    """

    def __init__(self, count: int, points: int, distances: tuple[int, int], dtype: Any):
        kind = np.result_type(dtype, np.complex64)
        source, result = (aligned((count, distance), kind) for distance in distances)
        near, far = ((a.ctypes.data, None, 1, d) for a, d in zip((source, result), distances, strict=True))
        prefix = "fftwf" if kind == np.complex64 else "fftw"
        make, destroy = library.function(f"{prefix}_plan_many_dft"), library.function(f"{prefix}_destroy_plan")
        common = 1, ctypes.byref(ctypes.c_int(points)), count
        with library.planning:
            library.function(f"{prefix}_plan_with_nthreads")(1)
            self.forward = make(*common, *near, *far, -1, _ESTIMATE)
            self.backward = make(*common, *far, *near, +1, _ESTIMATE)
        self.execute = library.function(f"{prefix}_execute_dft")
        self.addresses = ctypes.cast(self.execute, library.WORD).value, self.forward, self.backward
        weakref.finalize(self, _destroy, destroy, self.forward, self.backward).atexit = False
        if not (self.forward and self.backward):
            raise MemoryError(f"FFTW has no plan for {count} lines of {points} points: not enough memory")


@lru_cache(maxsize=256)
def line_plans(count: int, points: int, distances: tuple[int, int], dtype: Any) -> LinePlans:
    """Return `LinePlans`, kept for later calls from any thread."""
    return LinePlans(count, points, distances, dtype)


def _destroy(destroy: Callable[[int | None], None], *plans: int | None) -> None:
    with library.planning:
        for plan in plans:
            if plan:
                destroy(plan)


class Lines:
    """A few complex lines, transformed along the last axis from `source` to `result` and back.

    Neither direction is scaled, and each destroys what it starts from. Out of place, since FFTW is twice as slow in
    place when it plans by estimate. `source_pairs` and `result_pairs` show the same memory, its padding included, as
    (real, imaginary) pairs.
    """

    def __init__(self, count: int, points: int, dtype: DTypeLike = np.float64):
        complex_type = np.result_type(dtype, np.complex64)
        padded = [aligned((count, points + PADDING), complex_type) for _ in range(2)]
        self.source, self.result = (buffer[:, :points] for buffer in padded)
        self.source_pairs, self.result_pairs = (buffer.view(dtype) for buffer in padded)  # contiguous, for kernels
        self._ends = self.source.ctypes.data, self.result.ctypes.data
        distances = points + PADDING, points + PADDING
        self.plans = line_plans(count, points, distances, np.dtype(dtype)) if library.direct() else None

    def forward(self) -> None:
        """Transform `source` into `result`."""
        if self.plans is None:
            from scipy import fft

            self.result[...] = fft.fft(self.source, axis=1)
        else:
            self.plans.execute(self.plans.forward, *self._ends)

    def backward(self) -> None:
        """Transform `result` into `source`."""
        if self.plans is None:
            from scipy import fft

            self.source[...] = fft.ifft(self.result, axis=1, norm="forward")
        else:
            self.plans.execute(self.plans.backward, *self._ends[::-1])


def lines(count: int, points: int, dtype: DTypeLike) -> Lines:
    """Return `Lines` that belong to this Python thread; their buffers are small and kept for the next call."""
    cache = library.state.__dict__.setdefault("lines", {})
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
        self.field = aligned(shape, dtype)
        self.spectrum = aligned((shape[0], shape[1] // 2 + PADDING), complex_type)[:, : shape[1] // 2 + 1]
        self.forward: Callable[[], object]
        self.backward: Callable[[], object]
        if library.pyfftw is None:
            self.forward, self.backward = self._scipy_forward, self._scipy_backward
            return
        options: dict[str, Any] = {
            "axes": (1,),
            "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"),
            "threads": library.plan_threads(),
        }
        with library.planning:
            self.forward = library.pyfftw.FFTW(self.field, self.spectrum, **options).execute
            self.backward = library.pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options).execute

    def _scipy_forward(self) -> None:
        from scipy import fft

        self.spectrum[...] = fft.rfft(self.field, axis=1)

    def _scipy_backward(self) -> None:
        from scipy import fft

        self.field[...] = fft.irfft(self.spectrum, n=self.field.shape[1], axis=1, norm="forward")


def rows(shape: tuple[int, int], dtype: DTypeLike) -> Rows:
    """Return `Rows` that belong to this Python thread, kept for the next call; their buffers are large."""
    cache = library.state.__dict__.setdefault("rows", {})
    key = (shape, np.dtype(dtype).char, library.get_threads())
    if key not in cache:
        if len(cache) >= 2:  # buffers are large
            with library.planning:
                cache.pop(next(iter(cache)))
        cache[key] = Rows(shape, dtype)
    result: Rows = cache[key]
    return result


def _transform(shape: tuple[int, int], dtype: DTypeLike) -> Transform:
    cache = library.state.__dict__.setdefault("cache", {})
    key = (shape, np.dtype(dtype).char, library.get_threads())
    if key not in cache:
        if len(cache) >= 4:  # buffers are large: keep the latest few
            with library.planning:
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
