"""Contents of a file before units are applied, and the error of files without heights."""

from collections.abc import Sequence
from math import prod
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.machine import exceeds

LEAST_POINTS = {1: 64, 2: 8}  # of a line scan; along each side of a map
_BYTES_PER_POINT = 64.0  # that reading a map and its C(q) take
EVEN = 0.1  # of a step: by so much coordinates may differ from even steps, as they are rounded
_UNITS = {
    1.0: "m meter meters metre metres",
    1e-2: "cm",
    1e-3: "mm millimeter millimeters millimetre millimetres",
    1e-6: "um µm μm micron microns micrometer micrometers micrometre micrometres",
    1e-9: "nm nanometer nanometers nanometre nanometres",
    1e-10: "å angstrom angstroms ångström",
    1e-12: "pm picometer picometers picometre picometres",
}
UNITS = {name: factor for factor, names in _UNITS.items() for name in names.split()}


def unit_name(factor: float) -> str:
    """Return the name of a unit of length given in m."""
    near = min(_UNITS, key=lambda known: abs(known / factor - 1.0))
    return _UNITS[near].split()[0] if abs(near / factor - 1.0) < 1e-9 else f"{factor:.6g} m"


class NoHeightsError(ValueError):
    """A file holds no heights that can be used. The message goes on after the name of the file."""


class Contents(NamedTuple):
    """Heights as a file has them."""

    heights: Array  # in `unit`, undefined points NaN: a map, axis 0 is x, or a line scan
    # length along each axis, in `lateral_unit`; None if the file has none
    sizes: tuple[float, ...] | None = None
    unit: float | None = None  # of the heights, m; None if the file has none
    lateral_unit: float | None = None  # of the sizes, m
    periodic: bool = False
    reliable: float = np.inf  # wavenumber up to which the instrument resolves, rad/m
    left_out: tuple[str, ...] = ()  # of the file's numbers
    # index of these heights in `channels`; None of a file that has no channels
    channel: int | None = None
    channels: tuple[str, ...] = ()  # names of all heights of the file


def check_points(shape: tuple[int, ...]) -> None:
    """Refuse other shapes than maps and line scans, and too small or large ones, before heights are read."""
    least = LEAST_POINTS.get(len(shape))
    if least is None:
        raise NoHeightsError(
            f"holds numbers of shape {shape}; C(q) of a surface needs a map or a line scan"
        )
    if min(shape) < least:
        kind = "along each side" if len(shape) == 2 else "of a line scan"
        raise NoHeightsError(f"has {shape} points; C(q) needs at least {least} {kind}")
    points = prod(float(n) for n in shape)
    if exceeds(_BYTES_PER_POINT * points, 0.5):
        raise NoHeightsError(
            f"declares {points:.3g} points; it takes {1e-9 * _BYTES_PER_POINT * points:.3g} GB to read, above half of "
            "the available memory; crop it"
        )


def index_of_channel(names: Sequence[str], wanted: str | int) -> int:
    """Return the index of the channel with a name, or with a number from 1 on; NoHeightsError if it is not one."""
    if isinstance(wanted, int):
        found = [wanted - 1] if 1 <= wanted <= len(names) else []
    else:
        lower = [name.strip().lower() for name in names]
        found = [i for i, name in enumerate(lower) if name == wanted.strip().lower()]
    if len(found) != 1:
        fault = "several channels of heights" if found else "no channel of heights"
        what = f"with the name {wanted[:40]!r}" if isinstance(wanted, str) else f"number {wanted}"
        raise NoHeightsError(
            f"has {fault} {what}; the choice is {numbered(names)}, by name or by number"
        )
    return found[0]


def numbered(names: Sequence[str]) -> str:
    """Return the names of channels with their numbers, as a text of at most some 200 characters."""
    few = [f"{number} {name[:30]!r}" for number, name in enumerate(names[:6], start=1)]
    return ", ".join(few) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


def length_unit(text: str, what: str) -> float | None:
    """Return a unit in m, None if `text` is empty or "1"; NoHeightsError if it is no length."""
    name = text.strip()
    if name in ("", "1"):
        return None
    if name.lower() not in UNITS:
        raise NoHeightsError(
            f"has {what} in {name[:40]!r}, which is no unit of length; save it in m, or leave it out"
        )
    return UNITS[name.lower()]


def even_step(values: Array, what: str) -> float:
    """Return the step of coordinates at even steps, below 0 if they fall; NoHeightsError if they are uneven."""
    step = float(values[-1] - values[0]) / max(values.size - 1, 1)
    line = values[0] + step * np.arange(values.size)
    even = np.abs(values - line) <= EVEN * abs(step)  # not of undefined ones
    if not np.isfinite(step) or step == 0.0 or not even.all():
        raise NoHeightsError(f"has {what} at uneven steps; put its heights on even steps first")
    return step
