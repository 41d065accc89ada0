"""Convolutions with a kernel given by its spectrum or its influences: zeros stay out, columns stay in the cache."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughsim.fourier import plans
from roughsim.fourier.plans import Lines, Rows, lines

_ROWS = 64  # rows at a time, of an influence
_BLOCK = 256  # bytes of a row of columns taken at a time: they stay in the cache


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
        rows, block = plans.rows((field.shape[0], shape[1]), field.dtype), _block(shape, field.dtype)
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
    rows = plans.rows((min(_ROWS, influence.shape[0]), points), np.dtype(np.float64))
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


def _rows_forward(field: NDArray[Any], shape: tuple[int, int]) -> Rows:
    nx, ny = field.shape
    rows = plans.rows((nx, shape[1]), field.dtype)
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


def _rows_backward(rows: Rows, shape: tuple[int, int], factor: float) -> NDArray[Any]:
    rows.backward()
    result: NDArray[Any] = np.multiply(rows.field[:, : shape[1]], rows.field.dtype.type(factor))
    return result
