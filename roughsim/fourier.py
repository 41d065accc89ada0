"""Real two-dimensional Fourier transforms: the one door to FFTW.

Plans are made with FFTW_ESTIMATE, so the same machine and versions always give the same bits. Each Python thread
has plans of its own (an FFTW plan object owns its buffers). Without pyfftw, scipy.fft takes over; this is announced
once and `backend()` names it for the records.
"""

from __future__ import annotations

import operator
import threading
import warnings
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

try:
    import pyfftw
except ImportError:  # the wheel of pyfftw bundles GPL code; some sites do without it
    pyfftw = None
    warnings.warn("pyfftw is not installed: scipy.fft takes over, slower", RuntimeWarning, stacklevel=2)

_state = threading.local()
_threads = 1


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
        options: dict[str, Any] = {"axes": (0, 1), "flags": ("FFTW_ESTIMATE",), "threads": _threads}
        self._plans = (
            pyfftw.FFTW(self.field, self.spectrum, **options),
            pyfftw.FFTW(self.spectrum, self.field, direction="FFTW_BACKWARD", **options),
        )

    def forward(self) -> NDArray[Any]:
        """Transform `field` into `spectrum` and return the latter."""
        if self._plans is None:
            from scipy import fft

            self.spectrum[...] = fft.rfft2(self.field, workers=_threads)
        else:
            self._plans[0].execute()
        if self.scale is not None:
            np.multiply(self.spectrum, self.scale, out=self.spectrum)
        return self.spectrum

    def inverse(self) -> NDArray[Any]:
        """Transform `spectrum` into `field` and return the latter; `spectrum` is destroyed."""
        if self._plans is None:
            from scipy import fft

            self.field[...] = fft.irfft2(self.spectrum, s=self.field.shape, norm="forward", workers=_threads)
        else:
            self._plans[1].execute()
        return self.field


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
