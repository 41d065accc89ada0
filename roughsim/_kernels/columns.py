"""Columns of a half spectrum to contiguous lines and back, a few at a time: the lines stay in the cache."""

from __future__ import annotations

from typing import Any

from roughsim._kernels import kernel


@kernel()
def gather(spectrum: Any, first: int, count: int, lines: Any) -> None:
    """Copy columns first … first + count − 1 to the lines, one line each."""
    for i in range(spectrum.shape[0]):
        for k in range(count):
            lines[k, i] = spectrum[i, first + k]


@kernel()
def scatter(lines: Any, first: int, count: int, spectrum: Any) -> None:
    """Copy the lines back to the columns."""
    for i in range(spectrum.shape[0]):
        for k in range(count):
            spectrum[i, first + k] = lines[k, i]
