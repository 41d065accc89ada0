"""Tables of a scene: C(q) over the wavenumber, and properties over the absolute temperature."""

from collections.abc import Mapping, Sequence
from math import pi
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, FiniteFloat

from roughsim.scene.schema import (
    KELVIN,
    Quantity,
    Record,
    SceneError,
    as_written,
    is_list,
    record,
)
from roughsim.surface.directions import Directions
from roughsim.surface.topography.texture import Texture

_WAVENUMBER = Quantity("rad/m", "1e4", gt=0)
_PSD = Quantity(
    "", "1e-24; of a table of logarithms write q and C themselves", gt=0, smallest=1e-100
)
_CONDUCTIVITY = Quantity("W/(m K)", '"30 W/(m K)"', gt=0)
_FRICTION = Quantity("", "0.11", gt=0)
MAX_ROWS = 1200  # of all tables C(q) of a scene together: written inline they still fit into 64 KiB
_MOST_DIRECTIONS = 3000
_MAX_TEMPERATURES = 100  # of a table over temperature
Rows = tuple[tuple[float, float], ...]
Numbers = tuple[tuple[FiniteFloat, ...], ...]
# convention of a table → factors to q, rad/m, and to C in Persson's convention:
# surfacetopography divides d²q by 4π²; over the spatial frequency q = 2πf, and d²q = 4π² d²f
PSD_SCALES = {
    "persson": (1.0, 1.0),
    "surfacetopography": (1.0, 1.0 / (4 * pi**2)),
    "frequency": (2 * pi, 1.0 / (4 * pi**2)),
}


def read_psd(value: Any) -> Rows:
    """Read a table C(q) of rows [q, C]: q in rad/m rising, C in m⁴ positive."""
    if not is_list(value) or not 2 <= len(value) <= MAX_ROWS:
        size = f"{len(value)} rows" if is_list(value) else as_written(value)
        raise ValueError(
            f" = {size}: a table C(q) has 2 to {MAX_ROWS} rows [q, C]; average C over bins of log q"
        )
    rows: list[tuple[float, float]] = []
    for i, row in enumerate(value):
        if not is_list(row) or len(row) != 2 or any(isinstance(entry, str) for entry in row):
            raise ValueError(
                f"[{i}] = {as_written(row)} must be two numbers without units, q in rad/m and C in m⁴, for example "
                "[[1e4, 1e-24], [1e5, 1e-27]]"
            )
        rows.append((_WAVENUMBER(row[0], f"[{i}] q"), _PSD(row[1], f"[{i}] C")))
    _check_rising([q for q, _ in rows], "q", "rad/m")
    return tuple(rows)


def _check_rising(values: Sequence[float], name: str, unit: str) -> None:
    """Refuse the rows of a table whose first numbers do not rise."""
    for i in range(1, len(values)):
        if values[i] <= values[i - 1]:
            raise ValueError(
                f"[{i}] has {name} = {values[i]!r} {unit} after {values[i - 1]!r} {unit}; {name} must rise, so sort "
                "the rows"
            )


def _check_psd_error(rows: Numbers) -> Numbers:
    """Return the errors of a table C(q): for each row its standard error, and its change without each scan."""
    if not all(len(row) == len(rows[0]) >= 1 and row[0] >= 0.0 for row in rows):
        raise ValueError(" must have rows of equal length, each with a standard error ≥ 0 first")
    if min(map(min, rows)) <= -1.0:
        raise ValueError(" must have numbers above -1, relative to C, as C stays positive")
    return rows


def _check_directions(rows: Numbers) -> Numbers:
    """Return rows (q, M at even angles); refuse rows that are no M(q, φ), and too many numbers."""
    numbers = sum(map(len, rows))
    if numbers > _MOST_DIRECTIONS:
        raise ValueError(
            f" has {numbers} numbers, above the limit of {_MOST_DIRECTIONS}; load the scan again"
        )
    try:
        directions_of(rows)
    except (ValueError, IndexError) as fault:
        raise ValueError(f" = {len(rows)} rows: {fault}; load the scan again") from None
    return rows


def directions_of(rows: Numbers) -> Directions:
    """Return M(q, φ) of rows (q, M at even angles)."""
    return Directions(tuple(row[0] for row in rows), tuple(row[1:] for row in rows))


def _read_textures(value: Any) -> tuple[Texture, ...]:
    """Read a row of numbers for each map."""
    try:
        textures = tuple(Texture.of_row([*map(float, row)]) for row in value)
    except (TypeError, ValueError):
        raise ValueError(" must have a row of numbers for each map; load the scan again") from None
    for one in textures:
        sizes = one.ratio, one.band_ratio, one.band_low, one.band_high
        if min(sizes) <= 0.0 or not np.isfinite(one).all():
            raise ValueError(" must have ratios and wavenumbers above 0; load the scan again")
    return textures


PsdError = Annotated[Numbers, AfterValidator(_check_psd_error)]
PsdDirections = Annotated[Numbers, AfterValidator(_check_directions)]
PsdTexture = Annotated[tuple[Texture, ...], BeforeValidator(_read_textures)]


def _number_or_table(number: Quantity) -> BeforeValidator:
    """Return the reader of a number, or of a table of it over the absolute temperature.

    A table is kept as rows (temperature, number) with the temperatures rising.
    """

    @record()
    class OverTemperature(Record):
        temperature: tuple[Annotated[float, KELVIN], ...]
        value: tuple[Annotated[float, number], ...]

    def read(value: Any) -> float | Rows:
        if isinstance(value, tuple) and all(
            isinstance(row, tuple) and len(row) == 2 for row in value
        ):
            value = dict(zip(("temperature", "value"), zip(*value, strict=True), strict=True))
        if not isinstance(value, Mapping):
            return float(number(value))
        try:
            table = OverTemperature(**value)
        except SceneError as error:
            example = f'{{ temperature = ["300 K", "900 K"], value = [{number.example}, ...] }}'
            raise ValueError(f".{error}; a table is written as {example}") from None
        kelvin, values = table.temperature, table.value
        if len(kelvin) != len(values) or not 2 <= len(values) <= _MAX_TEMPERATURES:
            counts = f"{len(kelvin)} temperatures and {len(values)} values"
            raise ValueError(f" has {counts}; give 2 to {_MAX_TEMPERATURES} of each, in pairs")
        _check_rising(kelvin, "temperature", "K")
        return tuple(zip(kelvin, values, strict=True))

    return BeforeValidator(read)


# a number, or rows (absolute temperature in K, number), linear between
Conductivity = Annotated[Annotated[float, _CONDUCTIVITY] | Rows, _number_or_table(_CONDUCTIVITY)]
FrictionCoefficient = Annotated[Annotated[float, _FRICTION] | Rows, _number_or_table(_FRICTION)]


def values_of(value: float | Rows | None) -> list[float]:
    """Return the numbers of a property: one, those of all rows of a table, or none."""
    if isinstance(value, tuple):
        return [number for _, number in value]
    return [] if value is None else [value]


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
