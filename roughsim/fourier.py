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
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

try:
    import pyfftw
except ImportError:  # the wheel of pyfftw bundles GPL code; some sites do without it
    pyfftw = None
    warnings.warn("pyfftw is not installed: scipy.fft takes over, slower", RuntimeWarning, stacklevel=2)

PADDING = 8  # complex numbers between lines, so that equal places do not all fall onto the same part of the cache
_ROWS = 64  # rows at a time, of an influence
_BLOCK = 256  # bytes of a row of columns taken at a time: they stay in the cache
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


class _Rows:
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


def convolve(field: NDArray[Any], response: NDArray[Any], shape: tuple[int, int], factor: float = 1.0) -> NDArray[Any]:
    """Return the part over `field` of its convolution, padded with zeros to `shape`, times `factor`.

    Rows and columns of zeros are not transformed, and a column is multiplied and transformed back while it is in the
    cache.

    Parameters
    ----------
    field : ndarray
        Real, shape (n_x, n_y).
    response : ndarray
        Half spectrum of the kernel as `forward` gives it, turned: shape (m_y//2 + 1, m_x).
    shape : (int, int)
        (m_x, m_y), not smaller than the field; the shape of the field itself for a periodic convolution.
    factor : float
        Factor on the result.
    """
    rows = _rows_forward(field, shape)
    for part, block in _columns_forward(rows.spectrum, shape):
        _column_backward(block, block.result, response, part, rows.spectrum)
    return _rows_backward(rows, field.shape, factor)


def convolutions(
    field: NDArray[Any], responses: Iterable[NDArray[Any]], shape: tuple[int, int], factor: float = 1.0
) -> Iterator[NDArray[Any]]:
    """Yield `convolve` with one response after the other, from one forward transform of the field.

    The parameters are those of `convolve`; the spectrum of the field is kept meanwhile.
    """
    rows = _rows_forward(field, shape)
    source = np.empty((shape[1] // 2 + 1, shape[0]), rows.spectrum.dtype)
    for part, block in _columns_forward(rows.spectrum, shape):
        source[part] = block.result[: part.stop - part.start]
    for response in responses:
        rows, block = _rows((field.shape[0], shape[1]), field.dtype), _block(shape, field.dtype)
        for part in _parts(shape, block):
            _column_backward(block, source[part], response, part, rows.spectrum)
        yield _rows_backward(rows, field.shape, factor)


def influence_spectrum(
    influence: NDArray[np.float64], count: int, shape: tuple[int, int], dtype: DTypeLike
) -> NDArray[Any]:
    """Return the response for `convolve` of a kernel given at all offsets in real space.

    Parameters
    ----------
    influence : ndarray
        Kernel at the offsets −(n − 1) … n − 1, shape (2 n_x − 1, 2 n_y − 1); if it is even along y the offsets from 0
        on are enough there, shape (2 n_x − 1, n_y).
    count : int
        n_y.
    shape : (int, int)
        (m_x, m_y), at least 2n − 1 each.
    dtype : dtype
        Real type of the fields.

    Returns
    -------
    ndarray
        Shape (m_y//2 + 1, m_x), complex.
    """
    nx = influence.shape[0] // 2 + 1
    turned = _influence_rows(influence, count, shape[1])
    result = np.empty((shape[1] // 2 + 1, shape[0]), np.result_type(dtype, np.complex64))
    kernels, block = _column_kernels(), _block(shape, np.dtype(np.float64))
    for part in _parts(shape, block):
        width = part.stop - part.start
        kernels.gather(turned[nx - 1 :], part.start, width, block.source)
        block.source[:width, nx : shape[0] - nx + 1] = 0.0
        kernels.gather(turned[: nx - 1], part.start, width, block.source[:, shape[0] - nx + 1 :])
        block.forward()
        np.multiply(block.result[:width], 1 / (shape[0] * shape[1]), out=result[part], casting="same_kind")
    return result


def _influence_rows(influence: NDArray[np.float64], count: int, points: int) -> NDArray[np.complex128]:
    """Transforms of the rows, each with its negative offsets at the end of `points` points."""
    spectrum = np.empty((influence.shape[0], points // 2 + 1), np.complex128)
    before = influence.shape[1] - count
    rows = _rows((min(_ROWS, influence.shape[0]), points), np.dtype(np.float64))
    for first in range(0, influence.shape[0], _ROWS):
        part = influence[first : first + _ROWS]
        field = rows.field[: part.shape[0]]
        field[:, :count], field[:, count : points - count + 1] = part[:, before:], 0.0
        if count > 1:
            field[:, 1 - count :] = part[:, :before] if before else part[:, :0:-1]
        rows.forward()
        spectrum[first : first + _ROWS] = rows.spectrum[: part.shape[0]]
    return spectrum


def _column_kernels() -> Any:
    """The compiled loops: imported on first use, for numba is slow to import."""
    from roughsim._kernels import columns

    return columns


def _block(shape: tuple[int, int], dtype: Any) -> Lines:
    """Lines for a few columns of the half spectrum of `shape`."""
    return lines(_BLOCK // (2 * np.dtype(dtype).itemsize), shape[0], dtype)


def _parts(shape: tuple[int, int], block: Lines) -> Iterator[slice]:
    """The columns of the half spectrum of `shape`, a block at a time."""
    columns, width = shape[1] // 2 + 1, block.source.shape[0]
    return (slice(start, min(start + width, columns)) for start in range(0, columns, width))


def _rows_forward(field: NDArray[Any], shape: tuple[int, int]) -> _Rows:
    nx, ny = field.shape
    rows = _rows((nx, shape[1]), field.dtype)
    rows.field[:, :ny], rows.field[:, ny:] = field, 0.0
    rows.forward()
    return rows


def _columns_forward(spectrum: NDArray[Any], shape: tuple[int, int]) -> Iterator[tuple[slice, Lines]]:
    """Yield each block of columns, transformed, in `result`."""
    kernels, block = _column_kernels(), _block(shape, spectrum.real.dtype)
    for part in _parts(shape, block):
        kernels.gather(spectrum, part.start, part.stop - part.start, block.source)
        block.source[:, spectrum.shape[0] :] = 0.0
        block.forward()
        yield part, block


def _column_backward(
    block: Lines, source: NDArray[Any], response: NDArray[Any], part: slice, spectrum: NDArray[Any]
) -> None:
    """Multiply a block of transformed columns, and put it back where it came from."""
    width = part.stop - part.start
    np.multiply(source[:width], response[part], out=block.result[:width])
    block.backward()
    _column_kernels().scatter(block.source, part.start, width, spectrum)


def _rows_backward(rows: _Rows, shape: tuple[int, int], factor: float) -> NDArray[Any]:
    rows.backward()
    result: NDArray[Any] = np.multiply(rows.field[:, : shape[1]], rows.field.dtype.type(factor))
    return result


def _rows(shape: tuple[int, int], dtype: DTypeLike) -> _Rows:
    cache = _state.__dict__.setdefault("rows", {})
    key = (shape, np.dtype(dtype).char, _threads)
    if key not in cache:
        if len(cache) >= 2:  # buffers are large
            cache.pop(next(iter(cache)))
        cache[key] = _Rows(shape, dtype)
    result: _Rows = cache[key]
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
