"""Loops of the cache-blocked transform: real rows to complex lines, lines to a transposed half spectrum, and back.

Complex numbers are handed in as pairs of reals along the last axis. Two real rows travel as one complex line. The half
spectrum is transposed: entry (k, i) holds column k of row i. The first loops take the lines start … stop − 1 in groups
that fit the cache. `execute` is the function of FFTW with the arguments plan, source, result, all of them addresses,
and `plans` are two addresses of plans for one group, there and back. A last group that is not full is transformed
whole, and only its own lines are used. Other loops sum over a half spectrum.
"""

import numpy as np

from roughsim._kernels import REORDER, kernel

ROWS, COLUMNS, BACK = 1, 2, 4  # stages of a product, to be added up
COMPLY, STIFFEN, THERE, BACKWARD = range(4)  # operation on the columns


@kernel()
def product(stages, task, execute, source, target, rows, columns):
    """Multiply a field by q/2 or by 2/q, or do one stage of the product on some of the lines.

    `stages` is a sum of `ROWS`, `COLUMNS` and `BACK`. `task` is the work on the columns: `COMPLY`, `STIFFEN`, or their
    transform `THERE` or `BACKWARD` alone. `rows` and `columns` hold the arguments of the stages.
    """
    if stages & ROWS:
        _rows_forward(execute, source, rows)
    if stages & COLUMNS:
        if task >= THERE:
            _columns_alone(task == THERE, execute, columns)
        else:
            _columns_product(task == STIFFEN, execute, columns)
    if stages & BACK:
        _rows_backward(execute, target, rows)


@kernel(inline=True)
def _rows_forward(execute, field, lines):
    """Transform pairs of rows to the columns of twice the half spectrum, transposed."""
    start, stop, group, plans, source, result, spectrum = lines
    rows, columns = field.shape
    for first in range(start, stop, group):
        # two rows as the real and imaginary parts of a line; an odd last row has no partner
        for r in range(min(group, stop - first)):
            i = 2 * (first + r)
            k = min(i + 1, rows - 1)
            for j in range(columns):
                source[r, 2 * j] = field[i, j]
                source[r, 2 * j + 1] = field[k, j] if k > i else 0.0
        execute(plans[0], source.ctypes.data, result.ctypes.data)
        # with rows x and y as x + iy the transform Z has X = (Z(k) + Z*(−k))/2 and Y = (Z(k) − Z*(−k))/2i
        for k in range(spectrum.shape[0]):
            a = 2 * k
            b = 2 * (columns - k if k else 0)
            for r in range(min(group, stop - first)):
                c = 4 * (first + r)
                real = result[r, a]
                imaginary = result[r, a + 1]
                other = result[r, b]
                conjugate = result[r, b + 1]
                spectrum[k, c] = real + other
                spectrum[k, c + 1] = imaginary - conjugate
                spectrum[k, c + 2] = imaginary + conjugate
                spectrum[k, c + 3] = other - real


@kernel(inline=True)
def _rows_backward(execute, field, lines):
    """Undo `_rows_forward` but for factors."""
    start, stop, group, plans, source, result, spectrum = lines
    rows, columns = field.shape
    one = field.dtype.type(1.0)
    zero = field.dtype.type(0.0)
    for first in range(start, stop, group):
        for k in range(spectrum.shape[0]):
            a = 2 * k
            b = 2 * (columns - k)
            share = zero if k == 0 or a == columns else one  # k = −k: both spectra are real there
            for r in range(min(group, stop - first)):
                c = 4 * (first + r)
                x = spectrum[k, c]
                y = share * spectrum[k, c + 1]
                u = spectrum[k, c + 2]
                v = share * spectrum[k, c + 3]
                # −k first, which is behind the line for k = 0
                result[r, b] = x + v
                result[r, b + 1] = u - y
                result[r, a] = x - v
                result[r, a + 1] = y + u
        execute(plans[1], result.ctypes.data, source.ctypes.data)
        for r in range(min(group, stop - first)):
            i = 2 * (first + r)
            k = min(i + 1, rows - 1)
            for j in range(columns):
                field[k, j] = source[r, 2 * j + 1]
                field[i, j] = source[r, 2 * j]


@kernel(inline=True)
def _columns_product(stiff, execute, lines):
    """Transform the columns, multiply by factor · q/2 or factor · 2/q, and transform back; q² = along + across."""
    start, stop, group, plans, spectrum, result, weights = lines
    along, across, factor = weights
    half = result.dtype.type(0.5) * factor
    twice = result.dtype.type(2.0) * factor
    for first in range(start, stop, group):
        # a column is multiplied while it is in the cache, and never written out between its two transforms
        line = spectrum.ctypes.data + first * spectrum.strides[0]
        execute(plans[0], line, result.ctypes.data)
        for r in range(min(group, stop - first)):
            other = across[first + r]
            for i in range(
                1 if other == 0 else 0, along.size
            ):  # q = 0 is left out: 2/q has no limit there
                q = np.sqrt(along[i] + other)
                weight = half * q if stiff else twice / q
                result[r, 2 * i] *= weight
                result[r, 2 * i + 1] *= weight
            if other == 0:
                result[r, 0] = 0.0
                result[r, 1] = 0.0
        execute(plans[1], result.ctypes.data, line)


@kernel(inline=True)
def _columns_alone(there, execute, lines):
    """Transform the columns, in place, and multiply by the factor; or transform them back."""
    start, stop, group, plans, spectrum, result, weights = lines
    width = 2 * weights[0].size
    for first in range(start, stop, group):
        line = spectrum.ctypes.data + first * spectrum.strides[0]
        if there:
            execute(plans[0], line, result.ctypes.data)
        for r in range(min(group, stop - first)):
            for i in range(width):
                if there:
                    spectrum[first + r, i] = weights[2] * result[r, i]
                else:
                    result[r, i] = spectrum[first + r, i]
        if not there:
            execute(plans[1], result.ctypes.data, line)


@kernel()
def highest(start, stop, spectrum, along, across, least):
    """The greatest |f(q)|² in these rows of a half spectrum, and the greatest q² with |f(q)|² > least."""
    top = 0.0
    reached = 0.0
    for k in range(start, stop):
        for i in range(along.size):
            real = spectrum[k, i].real
            imaginary = spectrum[k, i].imag
            power = real * real + imaginary * imaginary
            top = max(top, power)
            if power > least:
                reached = max(reached, along[i] + across[k])
    return top, reached


@kernel(fastmath=REORDER)
def point_sum(pairs, along, across, phases_along, phases_across):
    """Σ |q| Re f(q) exp(iφ) over rows of a half spectrum, as pairs; each axis has cos φ and sin φ of its own."""
    cosine, sine = phases_along
    total = 0.0
    for k in range(across.size):
        real = 0.0
        imaginary = 0.0
        line = pairs[k]
        for i in range(along.size):
            q = np.sqrt(along[i] + across[k])
            real += q * (line[2 * i] * cosine[i] - line[2 * i + 1] * sine[i])
            imaginary += q * (line[2 * i] * sine[i] + line[2 * i + 1] * cosine[i])
        total += phases_across[0][k] * real - phases_across[1][k] * imaginary
    return total
