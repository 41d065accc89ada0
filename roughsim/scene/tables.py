"""Tables of a scene: C(q) over the wavenumber, and properties over the absolute temperature."""

from collections.abc import Mapping
from math import pi
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, FiniteFloat

from roughsim.scene.schema import KELVIN, Quantity, Record, SceneError, as_written, record

_WAVENUMBER = Quantity("rad/m", "1e4", gt=0)
_PSD = Quantity("", "1e-24", gt=0, smallest=1e-100)
_CONDUCTIVITY = Quantity("W/(m K)", '"30 W/(m K)"', gt=0)
_FRICTION = Quantity("", "0.11", gt=0)
MAX_ROWS = 1200  # of all tables C(q) of a scene together: written inline they still fit into 64 KiB
_TEXTURE_NUMBERS = 10  # of a map
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


def _check_psd_error(rows: Numbers) -> Numbers:
    """Return the errors of a table C(q): for each row its standard error, and its change without each scan."""
    if not all(len(row) == len(rows[0]) >= 1 and row[0] >= 0.0 for row in rows):
        raise ValueError(" must have rows of equal length, each with a standard error ≥ 0 first")
    if min(map(min, rows)) <= -1.0:
        raise ValueError(" must have numbers above -1, relative to C, as C stays positive")
    return rows


def _check_psd_texture(rows: Numbers) -> Numbers:
    """Return the textures of maps, each the numbers of `roughsim.surface.topography.Texture` in its order."""
    if not rows or any(len(row) != _TEXTURE_NUMBERS for row in rows):
        raise ValueError(
            f" must have rows of {_TEXTURE_NUMBERS} numbers, one for each map; load the scan again"
        )
    if min(row[place] for row in rows for place in (0, 2, 4, 5)) <= 0.0:
        raise ValueError(" must have ratios and wavenumbers above 0; load the scan again")
    return rows


PsdError = Annotated[Numbers, AfterValidator(_check_psd_error)]
PsdTexture = Annotated[Numbers, AfterValidator(_check_psd_texture)]


def _number_or_table(number: Quantity) -> BeforeValidator:
    """Return the reader of a number, or of a table of it over the absolute temperature.

    A table is kept as rows (temperature, number) with the temperatures rising.
    """

    @record()
    class Table(Record):
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
            table = Table(**value)
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

    return BeforeValidator(read)


# a number, or rows (absolute temperature in K, number), linear between
Conductivity = Annotated[Annotated[float, _CONDUCTIVITY] | Rows, _number_or_table(_CONDUCTIVITY)]
FrictionCoefficient = Annotated[Annotated[float, _FRICTION] | Rows, _number_or_table(_FRICTION)]


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
