"""How numbers are written for people: the units of tables and figures, and a value with its error.

Every ± is a total error that holds with 95 %. Both numbers end at the second digit of the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, log10
from typing import NamedTuple

# SI unit → unit of the tables, and the factor between them
_SHOWN = {
    "K": ("K", 1.0),
    "K/m": ("K/mm", 1e-3),
    "K/m^2": ("K/µm²", 1e-12),
    "m": ("µm", 1e6),
    "1": ("", 1.0),
    "Pa^2": ("GPa²", 1e-18),
}
_MOST = 6  # digits of a value that are worth printing


class Written(NamedTuple):
    """A value and its error as digits, both in units of 10^power; `error` is empty where there is none."""

    value: str
    error: str
    power: int


def shown(unit: str) -> tuple[str, float]:
    """Return the unit that tables and figures show in place of an SI unit, and the factor between them."""
    return _SHOWN.get(unit, (unit, 1.0))


def plus_minus(value: float, error: float, unknown: Sequence[str] = ()) -> str:
    """Return a value with its total error, as "208.33 ± 0.38".

    Parameters
    ----------
    value, error : float
        In the unit that is shown.
    unknown : sequence of str
        Parts of the error that nothing tells: the rest of it is then a lower bound, "208.33 ± ≥0.38".
    """
    digits, wrong, power = written(value, error, unknown)
    if not wrong:
        return digits
    return f"({digits} ± {wrong})e{power}" if power else f"{digits} ± {wrong}"


def written(value: float, error: float, unknown: Sequence[str] = ()) -> Written:
    """Return the digits of a value and its error, both to the second digit of the error, as for `plus_minus`."""
    if not isfinite(value):
        return Written("–", "", 0)
    if error == 0.0 and not (unknown and value):
        return Written(f"{value + 0.0:.4g}", "", 0)  # + 0.0: no zero is negative
    if error == 0.0 or not isfinite(error):
        return Written(f"{value:.4g}", "unknown", 0)
    at_least = "≥" if unknown else ""
    if abs(value) > 10**_MOST * error:
        return Written(f"{value:.{_MOST}g}", f"{at_least}{error:.1e}", 0)
    large = floor(log10(max(abs(value), error)))
    power = large if not -3 <= large < 5 else 0
    value, error = value / 10.0**power, error / 10.0**power
    places = 1 - int(f"{error:.1e}".partition("e")[2])  # of the error's second digit, once it is rounded
    value, error = round(value, places), round(error, places)
    return Written(f"{value:.{max(places, 0)}f}", f"{at_least}{error:.{max(places, 0)}f}", power)


__all__ = ["Written", "plus_minus", "shown", "written"]
