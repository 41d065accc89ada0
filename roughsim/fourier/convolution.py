"""Convolutions of a field with a kernel, by the spectrum of the kernel: zeros are not transformed."""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import DTypeLike

from roughsim.fourier.plans import Lines, Transform, lines, transform
from roughsim.grid import Array, Field

_ROWS = 64  # rows at a time, of an influence
_BLOCK = 256  # bytes of a row of columns taken at a time: they stay in the cache


def convolve(field: Field, response: Field, shape: tuple[int, int], factor: float = 1.0) -> Field:
    """Return the part over `field` of its convolution, padded with zeros to `shape`, times `factor`.

    `field` is real, of shape (n_x, n_y); `shape` = (m_x, m_y) is not smaller, and the same for a periodic convolution.
    `response` is the half spectrum of the kernel as `forward` gives it, transposed: shape (m_y//2 + 1, m_x).
    """
    rows = transformed_rows(field, shape)
    for part, block in transformed_columns(rows.spectrum, shape):
        _multiply_columns(block, block.result, response, part, rows.spectrum)
    return np.multiply(rows.inverse()[:, : field.shape[1]], field.dtype.type(factor))


def convolutions(
    field: Field,
    responses: Iterable[Field],
    shape: tuple[int, int],
    factor: float = 1.0,
) -> Iterator[Field]:
    """Yield `convolve` of the field with each response; the field is transformed only once."""
    rows = transformed_rows(field, shape)
    source = np.empty((shape[1] // 2 + 1, shape[0]), rows.spectrum.dtype)
    for part, block in transformed_columns(rows.spectrum, shape):
        source[part] = block.result[: part.stop - part.start]
    for response in responses:
        rows = transform((field.shape[0], shape[1]), field.dtype, (1,))
        for part, block in column_blocks(shape, field.dtype):
            _multiply_columns(block, source[part], response, part, rows.spectrum)
        yield np.multiply(rows.inverse()[:, : field.shape[1]], field.dtype.type(factor))


def influence_spectrum(
    influence: Array, count: int, shape: tuple[int, int], dtype: DTypeLike
) -> Field:
    """Return the response for `convolve` of a kernel given at all offsets in real space, for fields of `dtype`.

    `influence` has the offsets −(n − 1) … n − 1, shape (2 n_x − 1, 2 n_y − 1); if it is even along y the offsets from
    0 on are enough there, shape (2 n_x − 1, n_y). `count` is n_y, and `shape` at least 2n − 1 each.
    """
    # the rows, each with its negative offsets at the end; a few at a time
    before = influence.shape[1] - count
    points = shape[1]
    size = influence.shape[0]
    spectrum = np.empty((size, points // 2 + 1), complex)
    rows = transform((min(_ROWS, size), points), np.float64, (1,))
    for first in range(0, size, _ROWS):
        part = influence[first : first + _ROWS]
        field = rows.field[: part.shape[0]]
        field[:, :count], field[:, count : points - count + 1] = part[:, before:], 0.0
        if count > 1:
            field[:, 1 - count :] = part[:, :before] if before else part[:, :0:-1]
        spectrum[first : first + _ROWS] = rows.forward()[: part.shape[0]]
    # the columns likewise
    nx = size // 2 + 1
    result = np.empty((points // 2 + 1, shape[0]), np.result_type(dtype, np.complex64))
    for columns, block in column_blocks(shape, np.float64):
        width = columns.stop - columns.start
        block.source[:width, :nx] = spectrum[nx - 1 :, columns].T
        block.source[:width, nx : shape[0] - nx + 1] = 0.0
        block.source[:width, shape[0] - nx + 1 :] = spectrum[: nx - 1, columns].T
        block.forward()
        np.multiply(
            block.result[:width],
            1 / (shape[0] * shape[1]),
            out=result[columns],
            casting="same_kind",
        )
    return result


def column_blocks(shape: tuple[int, int], dtype: DTypeLike) -> Iterator[tuple[slice, Lines]]:
    """Yield the columns of the half spectrum of `shape`, a few at a time, with lines that hold them."""
    columns = shape[1] // 2 + 1
    width = _BLOCK // (2 * np.dtype(dtype).itemsize)
    for start in range(0, columns, width):
        yield slice(start, min(start + width, columns)), lines(width, shape[0], np.dtype(dtype))


def transformed_rows(field: Field, shape: tuple[int, int]) -> Transform:
    """Pad the rows with zeros and transform them."""
    nx, ny = field.shape
    rows = transform((nx, shape[1]), field.dtype, (1,))
    rows.field[:, :ny], rows.field[:, ny:] = field, 0.0
    rows.forward()
    return rows


def transformed_columns(spectrum: Field, shape: tuple[int, int]) -> Iterator[tuple[slice, Lines]]:
    """Yield each block of columns, padded with zeros and transformed, in `result`."""
    for part, block in column_blocks(shape, spectrum.real.dtype):
        block.source[: part.stop - part.start, : spectrum.shape[0]] = spectrum[:, part].T
        block.source[:, spectrum.shape[0] :] = 0.0
        block.forward()
        yield part, block


def _multiply_columns(
    block: Lines, source: Field, response: Field, part: slice, spectrum: Field
) -> None:
    """Multiply a block of transformed columns by the response, and write the product back into the spectrum."""
    width = part.stop - part.start
    np.multiply(source[:width], response[part], out=block.result[:width])
    block.backward()
    spectrum[:, part] = block.source[:width, : spectrum.shape[0]].T
