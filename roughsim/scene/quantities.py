"""The keys of a scene: the unit, the limits and an example of each, and how its value is read.

Pint is used here only. Numbers are SI; strings carry a unit ("0.90 um") and are converted in decimal arithmetic, so
that "0.90 um" is exactly 9e-7.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from numbers import Integral, Real
from typing import Any

from roughsim.contact import methods
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.scene.messages import did_you_mean, refused_value, shown
from roughsim.scene.spectra import NamedSpectrum

MAX_ROWS = 1200  # of all tables C(q) of a scene together: written inline they still fit into 64 KiB
_MAX_TEMPERATURES = 100  # of a table over temperature
_SMALLEST, _LARGEST = 1e-30, 1e30  # no length, pressure or speed of this world is beyond; their products stay numbers
_MEANING = {
    "": "a dimensionless number",
    "m": "a length",
    "rad/m": "a wavenumber",
    "Pa": "a pressure",
    "W/(m K)": "a conductivity",
    "kg/m^3": "a density",
    "J/(kg K)": "a specific heat capacity",
    "m/s": "a speed",
    "s": "a time",
    "K": "an absolute temperature",
}
_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*([\w%°/*^()·⋅.\-⁻ ]*)")


@dataclass(frozen=True, slots=True)
class Quantity:
    """One physical number.

    Parameters
    ----------
    unit : str
        Its SI unit, "" if it has none.
    example : str
        A value as a scene file would write it.
    above, at_least, below, at_most : float, optional
        Limits in `unit`, the first of each pair exclusive.
    may_be_infinite : bool
        Whether inf is a value.
    smallest : float
        Least size of a number that is not zero.
    """

    unit: str
    example: str
    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf
    may_be_infinite: bool = False
    smallest: float = _SMALLEST

    def __call__(self, value: Any, where: str = "") -> float:
        """Return `value` in SI; `where` is its place in the key, such as "[2]"."""
        number = self._of_text(value, where) if isinstance(value, str) else self._of_number(value, where)
        if math.isnan(number) or (math.isinf(number) and not self.may_be_infinite):
            raise refused_value(f"{where} = {shown(value, self.unit)} must be finite, for example {self.example}")
        inside = self.at_least <= number <= self.at_most
        if not inside or number <= self.above or (number >= self.below and not math.isinf(self.below)):
            raise refused_value(
                f"{where} = {shown(value, self.unit)} must be {self._limits()}, for example {self.example}"
            )
        if number and not math.isinf(number) and not self.smallest <= abs(number) <= _LARGEST:
            size = f"{self.smallest:g} to {_LARGEST:g} {self.unit}".rstrip()
            raise refused_value(
                f"{where} = {shown(value, self.unit)} must be of a size from {size}; check the exponent and the unit, "
                f"for example {self.example}"
            )
        return number

    def _of_number(self, value: Any, where: str) -> float:
        if isinstance(value, bool) or not isinstance(value, Real):
            kind = f"a number in {self.unit} or a string with a unit" if self.unit else "a number"
            raise refused_value(f"{where} = {shown(value)} must be {kind}, for example {self.example}")
        try:
            return float(value)
        except OverflowError:
            return math.inf

    def _of_text(self, value: str, where: str) -> float:
        match = _NUMBER_AND_UNIT.fullmatch(value) if len(value) <= 100 else None
        if match is None:
            raise refused_value(
                f"{where} = {shown(value)} is not a number with a unit; write for example {self.example}"
            )
        number, unit = match[1], match[2].strip()
        if self.unit and not unit:
            raise refused_value(
                f'{where} = {shown(value)} has no unit; write "{number} {self.unit}" or the number {number}'
            )
        return self._converted(number, unit, value, where)

    def _converted(self, number: str, unit: str, value: str, where: str) -> float:
        wanted = f"{_MEANING.get(self.unit, f'a quantity in {self.unit}')} is expected, for example {self.example}"
        try:
            found = _registry().parse_units(unit)
        except Exception:  # pint fails in a dozen ways, from AssertionError to TokenError
            raise refused_value(f"{where} = {shown(value)}: the unit {shown(unit)} is not known; {wanted}") from None
        if found.dimensionality != _registry().parse_units(self.unit).dimensionality:
            dimension = str(found.dimensionality)
            raise refused_value(f"{where} = {shown(value)} has the dimension {dimension}; {wanted}")
        try:
            return float(_registry().Quantity(Decimal(number), found).to(self.unit).magnitude)
        except Exception:  # decimal overflow, units with an offset, logarithmic units
            raise refused_value(f"{where} = {shown(value)} cannot be turned into {self.unit}; {wanted}") from None

    def _limits(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        bounds = [("above", self.above), ("at least", self.at_least), ("below", self.below), ("at most", self.at_most)]
        return " and ".join(f"{word} {limit:g}{unit}" for word, limit in bounds if math.isfinite(limit))


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole number within limits."""

    example: str
    at_least: int
    at_most: int = 2**63 - 1  # what TOML must be able to hold

    def __call__(self, value: Any, where: str = "") -> int:
        """Return `value` as an int."""
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise refused_value(f"{where} = {shown(value)} must be a whole number, for example {self.example}")
        if not self.at_least <= int(value) <= self.at_most:
            limits = f"at least {self.at_least} and at most {self.at_most}"
            raise refused_value(f"{where} = {shown(value)} must be {limits}, for example {self.example}")
        return int(value)


@dataclass(frozen=True, slots=True)
class Choice:
    """One word of a list."""

    words: tuple[str, ...]

    @property
    def example(self) -> str:
        """The first word, as a scene file would write it."""
        return json.dumps(self.words[0])

    def __call__(self, value: Any, where: str = "") -> str:
        """Return `value` if it is one of the words."""
        if not isinstance(value, str) or value not in self.words:
            hint = did_you_mean(value if isinstance(value, str) else "", self.words)
            raise refused_value(f"{where} = {shown(value)} is not known; {hint}")
        return value


@dataclass(frozen=True, slots=True)
class Speeds:
    """One speed or a list of different ones."""

    each: Quantity

    @property
    def example(self) -> str:
        """One speed, as a scene file would write it."""
        return self.each.example

    def __call__(self, value: Any) -> tuple[float, ...]:
        """Return the speeds, m/s, in the order given."""
        if not isinstance(value, (list, tuple)):
            return (self.each(value),)
        if not value:
            raise refused_value(f" = [] holds no speed; write for example {self.example}")
        speeds = tuple(self.each(entry, f"[{i}]") for i, entry in enumerate(value))
        twice = next((i for i, speed in enumerate(speeds) if speed in speeds[:i]), None)
        if twice is not None:
            raise refused_value(f"[{twice}] = {shown(value[twice], 'm/s')} is there twice; remove one of the two")
        return speeds


@dataclass(frozen=True, slots=True)
class Pair:
    """Two numbers, along x and y; one number stands for both."""

    each: Callable[..., Any]
    example: str

    def __call__(self, value: Any) -> tuple[Any, Any]:
        """Return the two numbers."""
        if not isinstance(value, (list, tuple)):
            return (self.each(value),) * 2
        if len(value) != 2:
            raise refused_value(f" = {shown(value)} must be one number or two, along x and y: {self.example}")
        return self.each(value[0], "[0]"), self.each(value[1], "[1]")


@dataclass(frozen=True, slots=True)
class Share:
    """The share of heat into the moving body: a number or the name of a rule."""

    each: Quantity
    rules: tuple[str, ...]
    example: str = '"mean"'

    def __call__(self, value: Any) -> float | str:
        """Return the share or the rule's name."""
        if isinstance(value, str) and not re.match(r"\s*[-+.0-9]", value):
            return Choice(self.rules)(value)
        return self.each(value)


@dataclass(frozen=True, slots=True)
class Targets:
    """Observables and the relative half-width each should reach, kept as pairs (name, fraction)."""

    each: Quantity
    example: str = '{ flash_temperature = "1 %" }'

    def __call__(self, value: Any) -> tuple[tuple[str, float], ...]:
        """Return the pairs; a mapping and pairs are both read."""
        if isinstance(value, Mapping):
            value = tuple(value.items())
        if not isinstance(value, (list, tuple)) or any(not isinstance(p, (list, tuple)) or len(p) != 2 for p in value):
            raise refused_value(f" = {shown(value)} must name observables and targets: until = {self.example}")
        for name, _ in value:
            if name not in OBSERVABLES:
                raise refused_value(f".{name} is not an observable; {did_you_mean(str(name), OBSERVABLES)}")
        return tuple((name, self.each(target, f".{name}")) for name, target in value)


@dataclass(frozen=True, slots=True)
class Table:
    """A table C(q) as rows [q, C]: q in rad/m rising, C in m⁴ positive."""

    example: str = "[[1e4, 1e-24], [1e5, 1e-27]]"

    def __call__(self, value: Any) -> tuple[tuple[float, float], ...]:
        """Return the rows."""
        if not isinstance(value, (list, tuple)) or not 2 <= len(value) <= MAX_ROWS:
            count = f"{len(value)} rows" if isinstance(value, (list, tuple)) else shown(value)
            raise refused_value(
                f" = {count}: a table C(q) has 2 to {MAX_ROWS} rows [q, C]; average C over bins of log q"
            )
        rows = tuple(self._row(row, f"[{i}]") for i, row in enumerate(value))
        for i in range(1, len(rows)):
            if rows[i][0] <= rows[i - 1][0]:
                raise refused_value(
                    f"[{i}] has q = {rows[i][0]!r} rad/m after {rows[i - 1][0]!r} rad/m; q must rise, so sort the rows"
                )
        return rows

    def _row(self, row: Any, where: str) -> tuple[float, float]:
        if not isinstance(row, (list, tuple)) or len(row) != 2:
            raise refused_value(f"{where} = {shown(row)} must be two numbers, q in rad/m and C in m⁴: {self.example}")
        if any(isinstance(entry, str) for entry in row):
            raise refused_value(f"{where} = {shown(row)} must be two numbers without units, q in rad/m and C in m⁴")
        return _TABLE_Q(row[0], f"{where} q"), _TABLE_PSD(row[1], f"{where} C")


@dataclass(frozen=True, slots=True)
class OverTemperature:
    """A number, or a table of it over the absolute temperature, kept as rows (temperature, value)."""

    each: Quantity

    @property
    def example(self) -> str:
        """A number, as a scene file would write it."""
        return self.each.example

    def __call__(self, value: Any) -> float | tuple[tuple[float, float], ...]:
        """Return the number, or the rows with the temperatures rising; rows as they are kept are read too."""
        if isinstance(value, tuple) and all(isinstance(row, tuple) and len(row) == 2 for row in value):
            value = {"temperature": [row[0] for row in value], "value": [row[1] for row in value]}
        if not isinstance(value, Mapping):
            return self.each(value)
        temperatures, values = self._columns(value)
        rows = tuple(
            (_KELVIN(t, f".temperature[{i}]"), self.each(entry, f".value[{i}]"))
            for i, (t, entry) in enumerate(zip(temperatures, values, strict=True))
        )
        for i in range(1, len(rows)):
            if rows[i][0] <= rows[i - 1][0]:
                raise refused_value(
                    f".temperature[{i}] = {rows[i][0]!r} K after {rows[i - 1][0]!r} K; the temperatures must rise, so "
                    "sort the table"
                )
        return rows

    def _columns(self, table: Mapping[Any, Any]) -> tuple[Any, Any]:
        """The two lists of a table, of one length."""
        wanted = f'write for example {{ temperature = ["300 K", "900 K"], value = ["50 {self.each.unit}", ...] }}'
        for name in table:
            if name not in ("temperature", "value"):
                raise refused_value(f".{shown(name)} is not a key of a table over temperature; {wanted}")
        columns = table.get("temperature"), table.get("value")
        if not all(isinstance(column, (list, tuple)) for column in columns):
            raise refused_value(f" needs two lists, temperature and value; {wanted}")
        lengths = [len(column or ()) for column in columns]
        if lengths[0] != lengths[1] or not 2 <= lengths[0] <= _MAX_TEMPERATURES:
            raise refused_value(
                f" has {lengths[0]} temperatures and {lengths[1]} values; give 2 to {_MAX_TEMPERATURES} of each, in "
                "pairs"
            )
        return columns


@dataclass(frozen=True, slots=True)
class Title:
    """One line of text."""

    example: str = '"Steel on steel"'

    def __call__(self, value: Any) -> str:
        """Return the title."""
        if not isinstance(value, str) or not value.isprintable() or len(value) > 200:
            raise refused_value(
                f" = {shown(value)} must be one line of at most 200 characters, for example {self.example}"
            )
        return value


Key = Quantity | Whole | Choice | Speeds | Pair | Share | Targets | Table | OverTemperature | Title | NamedSpectrum
_TABLE_Q = Quantity("rad/m", "1e4", above=0)
_TABLE_PSD = Quantity("", "1e-24", above=0, smallest=1e-100)
_KELVIN = Quantity("K", '"300 K"', above=0)
KEYS: dict[str, Key] = {
    "title": Title(),
    "rms_height": Quantity("m", '"0.90 um"', above=0),
    "rms_slope": Quantity("", "0.3", above=0),
    "hurst": Quantity("", "0.8", at_least=0, at_most=1),
    "q_min": Quantity("rad/m", '"6350 1/m"', above=0),
    "q_roll_off": Quantity("rad/m", '"9.4e4 1/m"', above=0),
    "q_max": Quantity("rad/m", '"4.15e7 1/m"', above=0),
    "roll_off_exponent": Quantity("", "1.5", at_least=0, at_most=4),
    "psd": Table(),
    "psd_convention": Choice(("persson", "surfacetopography")),
    "psd_source": Choice(("scan",)),
    "spectrum": NamedSpectrum(),
    "like": Choice(("body",)),
    "youngs_modulus": Quantity("Pa", '"200 GPa"', above=0),
    "poisson_ratio": Quantity("", "0.3", above=-1, at_most=0.5),
    "penetration_hardness": Quantity("Pa", '"1.2 GPa"', above=0),
    "conductivity": OverTemperature(Quantity("W/(m K)", '"30 W/(m K)"', above=0)),
    "density": Quantity("kg/m^3", '"7900 kg/m^3"', above=0),
    "heat_capacity": Quantity("J/(kg K)", '"500 J/(kg K)"', above=0),
    "melting_temperature": Quantity("K", '"1800 K"', above=0),
    "nominal_pressure": Quantity("Pa", '"90 MPa"', above=0),
    "friction_coefficient": Quantity("", "0.11", above=0),
    "speed": Speeds(Quantity("m/s", '"35 m/s"', at_least=0)),
    "heat_partition": Share(Quantity("", "0.938", above=0, at_most=1), ("mean", "total", "all")),
    "duration": Quantity("s", '"1 ms"', above=0),
    "background_temperature": _KELVIN,
    "gamma": Quantity("", "0.45", at_least=0, at_most=1),
    "seed": Whole("1", at_least=0),
    "max_realizations": Whole("400", at_least=1, at_most=1_000_000),
    "until": Targets(Quantity("", '"1 %"', above=0, below=1)),
    "column": Choice(("capped", "smoothed", "elastic")),
    "shape": Pair(Whole("1024", at_least=1, at_most=2**31), "[1024, 1024]"),
    "every": Whole("1", at_least=1, at_most=1_000_000),
    "lengths": Pair(Quantity("m", '"4 mm"', above=0), '["4 mm", "4 mm"]'),
    "tolerance": Quantity("", "1e-4", above=0, below=1),
    "precision": Choice(("double", "single")),
    "solver": Choice(methods.NAMES),
    "slid_distance": Quantity("m", '"2 mm"', above=0, may_be_infinite=True),
    "threads": Whole("1", at_least=1, at_most=4096),
    "keep_fields": Whole("1", at_least=0),
}


def unit_of(key: str) -> str:
    """Return the SI unit of a key's number or numbers, "" if it has none."""
    entry = KEYS.get(key)
    each = entry.each if isinstance(entry, (Speeds, Pair, OverTemperature)) else entry
    return each.unit if isinstance(each, Quantity) else ""


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # loading it and its definitions costs more than the rest of a scene

    return pint.UnitRegistry(non_int_type=Decimal)
