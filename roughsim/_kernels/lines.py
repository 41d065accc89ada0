"""Loops of the cache-blocked transform: real rows to complex lines, lines to a transposed half spectrum, and back.

Complex numbers are handed in as pairs of reals along the last axis. Two real rows travel as one complex line; `first`
is the first row (or column) of the block. The half spectrum is transposed: entry (k, i) holds column k of row i.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel


@kernel(fastmath=REORDER)
def pack(field: Any, first: int, lines: Any) -> None:
    """Write rows first, first + 1 as the real and imaginary parts of line 0, and so on; zero beyond the last row."""
    rows, columns = field.shape
    for r in range(lines.shape[0]):
        i = first + 2 * r
        if i + 1 < rows:
            for j in range(columns):
                lines[r, 2 * j] = field[i, j]
                lines[r, 2 * j + 1] = field[i + 1, j]
        elif i < rows:
            for j in range(columns):
                lines[r, 2 * j] = field[i, j]
                lines[r, 2 * j + 1] = 0.0


@kernel(fastmath=REORDER)
def unpack(lines: Any, first: int, rows: int, field: Any) -> None:
    """Undo `pack`: real and imaginary parts of the lines to rows of the field."""
    columns = field.shape[1]
    for r in range(lines.shape[0]):
        i = first + 2 * r
        if i + 1 < rows:
            for j in range(columns):
                field[i, j] = lines[r, 2 * j]
                field[i + 1, j] = lines[r, 2 * j + 1]
        elif i < rows:
            for j in range(columns):
                field[i, j] = lines[r, 2 * j]


@kernel(fastmath=REORDER)
def split(lines: Any, points: int, first: int, count: int, spectrum: Any) -> None:
    """Separate the transforms of the two rows of each line: twice the half spectrum, transposed."""
    for k in range(spectrum.shape[0]):
        a, b = 2 * k, 2 * (points - k if k else 0)
        for r in range(count):
            zr, zi, wr, wi = lines[r, a], lines[r, a + 1], lines[r, b], lines[r, b + 1]
            c = 2 * first + 4 * r
            spectrum[k, c] = zr + wr
            spectrum[k, c + 1] = zi - wi
            spectrum[k, c + 2] = zi + wi
            spectrum[k, c + 3] = wr - zr


@kernel(fastmath=REORDER)
def join(spectrum: Any, first: int, count: int, points: int, lines: Any) -> None:
    """Undo `split` but for the factor 2: half spectra of two rows to the full spectrum of one complex line."""
    for k in range(spectrum.shape[0]):
        a, b = 2 * k, 2 * (points - k)
        single = k == 0 or a == points
        for r in range(count):
            c = 2 * first + 4 * r
            x, y, u, v = spectrum[k, c], spectrum[k, c + 1], spectrum[k, c + 2], spectrum[k, c + 3]
            if single:
                lines[r, a] = x
                lines[r, a + 1] = u
            else:
                lines[r, a] = x - v
                lines[r, a + 1] = y + u
                lines[r, b] = x + v
                lines[r, b + 1] = u - y


@kernel()
def fetch(spectrum: Any, first: int, count: int, points: int, lines: Any) -> None:
    """Copy rows of the transposed half spectrum to the lines."""
    for r in range(count):
        for i in range(2 * points):
            lines[r, i] = spectrum[first + r, i]


@kernel()
def store(lines: Any, first: int, count: int, points: int, spectrum: Any) -> None:
    """Copy the lines to rows of the transposed half spectrum."""
    for r in range(count):
        for i in range(2 * points):
            spectrum[first + r, i] = lines[r, i]


@kernel(fastmath=REORDER)
def stiffen(lines: Any, first: int, count: int, along: Any, across: Any, factor: Any) -> None:
    """Multiply by factor · q/2, q² = along + across: from displacement to pressure."""
    half = lines.dtype.type(0.5) * factor
    for r in range(count):
        other = across[first + r]
        for i in range(along.size):
            weight = half * np.sqrt(along[i] + other)
            lines[r, 2 * i] *= weight
            lines[r, 2 * i + 1] *= weight


@kernel(fastmath=REORDER)
def comply(lines: Any, first: int, count: int, along: Any, across: Any, factor: Any) -> None:
    """Multiply by factor · 2/q, q² = along + across; q = 0 becomes zero: from pressure to displacement."""
    twice = lines.dtype.type(2.0) * factor
    for r in range(count):
        other = across[first + r]
        for i in range(1 if other == 0 else 0, along.size):
            weight = twice / np.sqrt(along[i] + other)
            lines[r, 2 * i] *= weight
            lines[r, 2 * i + 1] *= weight
        if other == 0:
            lines[r, 0] = 0.0
            lines[r, 1] = 0.0
