"""Tables of a scene: C(q) over the wavenumber, and properties over the absolute temperature."""

from collections.abc import Mapping
from functools import partial
from math import isfinite, pi
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from roughsim.scene.schema import KELVIN, Quantity, Record, SceneError, as_written, record

_WAVENUMBER = Quantity("rad/m", "1e4", gt=0)
_PSD = Quantity("", "1e-24", gt=0, smallest=1e-100)
_CONDUCTIVITY = Quantity("W/(m K)", '"30 W/(m K)"', gt=0)
_FRICTION = Quantity("", "0.11", gt=0)
MAX_ROWS = 1200  # of all tables C(q) of a scene together: written inline they still fit into 64 KiB
_TEXTURE_NUMBERS = 10  # of a map
_MAX_TEMPERATURES = 100  # of a table over temperature
Rows = tuple[tuple[float, float], ...]
# convention of a table → factors to q, rad/m, and to C in Persson's convention:
# surfacetopography divides d²q by 4π²; over the spatial frequency q = 2πf, and d²q = 4π² d²f
PSD_SCALES = {
    "persson": (1.0, 1.0),
    "surfacetopography": (1.0, 1.0 / (4 * pi**2)),
    "frequency": (2 * pi, 1.0 / (4 * pi**2)),
}


def read_psd(value: Any) -> Rows:
    """Read a table C(q) of rows [q, C]: q in rad/m rising, C in m⁴ positive."""
    example = "[[1e4, 1e-24], [1e5, 1e-27]]"
    if not isinstance(value, (list, tuple)) or not 2 <= len(value) <= MAX_ROWS:
        size = f"{len(value)} rows" if isinstance(value, (list, tuple)) else as_written(value)
        raise ValueError(
            f" = {size}: a table C(q) has 2 to {MAX_ROWS} rows [q, C]; average C over bins of log q"
        )
    rows: list[tuple[float, float]] = []
    for i, row in enumerate(value):
        if (
            not isinstance(row, (list, tuple))
            or len(row) != 2
            or any(isinstance(entry, str) for entry in row)
        ):
            numbers = "two numbers without units, q in rad/m and C in m⁴"
            raise ValueError(f"[{i}] = {as_written(row)} must be {numbers}, for example {example}")
        if isinstance(row[1], (int, float)) and row[1] < -1.0:  # log₁₀ C is −40 to −10
            logarithms = "of a table of logarithms write q and C themselves"
            raise ValueError(
                f"[{i}] C = {row[1]!r} m⁴ must be above 0; {logarithms}, for example {example}"
            )
        rows.append((_WAVENUMBER(row[0], f"[{i}] q"), _PSD(row[1], f"[{i}] C")))
        if i and rows[i][0] <= rows[i - 1][0]:
            raise ValueError(
                f"[{i}] has q = {rows[i][0]!r} rad/m after {rows[i - 1][0]!r} rad/m; q must rise, so sort the rows"
            )
    return tuple(rows)


def read_psd_error(value: Any) -> tuple[tuple[float, ...], ...]:
    """Read the errors of a table C(q): for each row its standard error, and its change without each scan."""
    try:
        rows = tuple(tuple(float(error) for error in row) for row in value)
    except (TypeError, ValueError):
        raise ValueError(f" = {as_written(value)} must be rows of numbers, relative to C") from None
    if not all(len(row) == len(rows[0]) >= 1 and row[0] >= 0.0 for row in rows):
        raise ValueError(" must have rows of equal length, each with a standard error ≥ 0 first")
    if not all(isfinite(error) and error > -1.0 for row in rows for error in row):
        raise ValueError(" must have finite numbers above -1, as C stays positive")
    return rows


def read_psd_texture(value: Any) -> tuple[tuple[float, ...], ...]:
    """Read the textures of maps, each the numbers of `roughsim.surface.topography.Texture` in its order."""
    try:
        rows = tuple(tuple(float(number) for number in row) for row in value)
    except (TypeError, ValueError):
        raise ValueError(
            f" = {as_written(value)} must be rows of numbers, one for each map"
        ) from None
    if not rows or not all(
        len(row) == _TEXTURE_NUMBERS and all(map(isfinite, row)) for row in rows
    ):
        raise ValueError(
            f" must have rows of {_TEXTURE_NUMBERS} finite numbers, one for each map; load the scan again"
        )
    if not all(min(row[0], row[2], row[4], row[5]) > 0.0 for row in rows):
        raise ValueError(" must have ratios and wavenumbers above 0; load the scan again")
    return rows


@record()
class _ConductivityTable(Record):
    """κ over the absolute temperature, as a scene file writes it."""

    temperature: tuple[Annotated[float, KELVIN], ...]
    value: tuple[Annotated[float, _CONDUCTIVITY], ...]


@record()
class _FrictionTable(Record):
    """μ over the absolute temperature, as a scene file writes it."""

    temperature: tuple[Annotated[float, KELVIN], ...]
    value: tuple[Annotated[float, _FRICTION], ...]


def _number_or_table(value: Any, number: Quantity, record: type[Any]) -> float | Rows:
    """Read a number, or a table of it, kept as rows (temperature, number) with the temperatures rising."""
    if isinstance(value, tuple) and all(isinstance(row, tuple) and len(row) == 2 for row in value):
        value = {"temperature": [row[0] for row in value], "value": [row[1] for row in value]}
    if not isinstance(value, Mapping):
        return float(number(value))
    try:
        table = record(**value)
    except SceneError as error:
        example = f'{{ temperature = ["300 K", "900 K"], value = [{number.example}, ...] }}'
        raise ValueError(f".{error}; a table is written as {example}") from None
    kelvin, values = table.temperature, table.value
    if len(kelvin) != len(values) or not 2 <= len(values) <= _MAX_TEMPERATURES:
        counts = f"{len(kelvin)} temperatures and {len(values)} values"
        raise ValueError(f" has {counts}; give 2 to {_MAX_TEMPERATURES} of each, in pairs")
    for i in range(1, len(kelvin)):
        if kelvin[i] <= kelvin[i - 1]:
            order = f"{kelvin[i]!r} K after {kelvin[i - 1]!r} K"
            raise ValueError(
                f".temperature[{i}] = {order}; the temperatures must rise, so sort the table"
            )
    return tuple(zip(kelvin, values, strict=True))


# a number, or rows (absolute temperature in K, number), linear between
Conductivity = Annotated[
    Annotated[float, _CONDUCTIVITY] | Rows,
    BeforeValidator(partial(_number_or_table, number=_CONDUCTIVITY, record=_ConductivityTable)),
]
FrictionCoefficient = Annotated[
    Annotated[float, _FRICTION] | Rows,
    BeforeValidator(partial(_number_or_table, number=_FRICTION, record=_FrictionTable)),
]


def at_temperature(value: float | Rows, temperature: float | None) -> float:
    """Return a number unchanged, or a table at an absolute temperature, K, by linear interpolation."""
    if not isinstance(value, tuple):
        return value
    low, high = value[0][0], value[-1][0]
    if temperature is None or not low <= temperature <= high:
        raise SceneError(
            f"temperature = {as_written(temperature, 'K')} must lie between {low:g} K and {high:g} K, the range of the "
            "table"
        )
    return float(np.interp(temperature, *np.array(value).T))
