"""Numbers with a unit and limits, as annotations of the keys of a scene: ``Annotated[float, Quantity("Pa", ...)]``.

Pint is used here only. Numbers are SI; strings carry a unit ("0.90 um") and are converted in decimal arithmetic, so
that "0.90 um" is exactly 9e-7. A refusal is a ValueError whose text continues the key: ``" = 3 Pa must be ..."``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from numbers import Integral, Real
from typing import Annotated, Any, get_args

from pydantic import GetCoreSchemaHandler, ValidationError, WrapValidator
from pydantic_core import core_schema

from roughsim.scene.messages import as_written

SMALLEST, LARGEST = 1e-30, 1e30  # no length, pressure or speed of this world is beyond; their products stay numbers
MEANINGS = {
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
NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*([\w%°/*^()·⋅.\-⁻ ]*)")


@dataclass(frozen=True)
class Quantity:
    """One number: its SI unit ("" if it has none), an example as a file would write it, and its limits.

    As the annotation of a field it reads the value before pydantic checks the type.
    """

    unit: str
    example: str
    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf
    may_be_infinite: bool = False
    whole: bool = False
    smallest: float = SMALLEST  # size of a number that is not zero

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Let pydantic read the value first."""
        return core_schema.no_info_before_validator_function(self, handler(source))

    def __call__(self, value: Any, where: str = "") -> Any:
        """Return `value` in SI; `where` is its place within the key, such as "[2]"."""
        as_text = isinstance(value, str) and not self.whole
        number = self.of_text(value, where) if as_text else self.of_number(value, where)
        limits = self.missed_limits(number)
        if limits:
            raise ValueError(f"{where} = {as_written(value, self.unit)} must be {limits}, for example {self.example}")
        return number

    def of_number(self, value: Any, where: str) -> float:
        """Return a number as a float, or as an int if it must be whole; one that is too large is inf."""
        numbers: Any = Integral if self.whole else Real
        if isinstance(value, bool) or not isinstance(value, numbers):
            kind = f"a number in {self.unit} or a string with a unit" if self.unit else "a number"
            kind = "a whole number" if self.whole else kind
            raise ValueError(f"{where} = {as_written(value)} must be {kind}, for example {self.example}")
        try:
            number = float(value)
        except OverflowError:
            return math.inf
        return int(value) if self.whole else number

    def of_text(self, value: str, where: str) -> float:
        """Return the number that a string with a unit stands for, in SI."""
        match = NUMBER_AND_UNIT.fullmatch(value) if len(value) <= 100 else None
        key = f"{where} = {as_written(value)}"
        if match is None:
            raise ValueError(f"{key} is not a number with a unit; write for example {self.example}")
        number, name = match[1], match[2].strip()
        if self.unit and not name:
            raise ValueError(f'{key} has no unit; write "{number} {self.unit}" or the number {number}')
        expected = f"{MEANINGS.get(self.unit, f'a quantity in {self.unit}')} is expected, for example {self.example}"
        try:
            unit = unit_registry().parse_units(name)
        except Exception:  # pint fails in a dozen ways, from AssertionError to TokenError
            raise ValueError(f"{key}: the unit {as_written(name)} is not known; {expected}") from None
        if unit.dimensionality != unit_registry().parse_units(self.unit).dimensionality:
            raise ValueError(f"{key} has the dimension {unit.dimensionality}; {expected}")
        try:
            return float(unit_registry().Quantity(Decimal(number), unit).to(self.unit).magnitude)
        except Exception:  # decimal overflow, units with an offset, logarithmic units
            raise ValueError(f"{key} cannot be turned into {self.unit}; {expected}") from None

    def missed_limits(self, number: float) -> str:
        """Return what a number must be and is not, "" if nothing."""
        if math.isnan(number) or (math.isinf(number) and not self.may_be_infinite):
            return "finite"
        inside = self.at_least <= number <= self.at_most
        if not inside or number <= self.above or (number >= self.below and not math.isinf(self.below)):
            bounds = {"above": self.above, "at least": self.at_least, "below": self.below, "at most": self.at_most}
            texts = [f"{word} {limit:.15g} {self.unit}" for word, limit in bounds.items() if math.isfinite(limit)]
            return " and ".join(text.rstrip() for text in texts)
        if number and not math.isinf(number) and not self.smallest <= abs(number) <= LARGEST:
            size = f"{self.smallest:g} to {LARGEST:g} {self.unit}".rstrip()
            return f"of a size from {size}; check the exponent and the unit"
        return ""


def whole(example: str, at_least: int, at_most: int = 2**63 - 1) -> Quantity:
    """Return the annotation of a whole number; TOML holds no larger ones."""
    return Quantity("", example, at_least=at_least, at_most=at_most, whole=True)


KELVIN = Quantity("K", '"300 K"', above=0)
# keys that several records have
RmsHeight = Annotated[float, Quantity("m", '"0.90 um"', above=0)]
Hurst = Annotated[float, Quantity("", "0.8", at_least=0, at_most=1)]
QMin = Annotated[float, Quantity("rad/m", '"6350 1/m"', above=0)]
QRollOff = Annotated[float, Quantity("rad/m", '"9.4e4 1/m"', above=0)]
QMax = Annotated[float, Quantity("rad/m", '"4.15e7 1/m"', above=0)]


def one_or_list(count: int = 1) -> WrapValidator:
    """Return the annotation of a tuple that may be written as one value, which then stands for `count` of them."""

    def read(value: Any, handler: Callable[[Any], Any]) -> Any:
        if isinstance(value, (list, tuple)):
            if count not in (1, len(value)):
                raise ValueError(f" = {as_written(value)} must be one number or two, along x and y")
            return handler(value)
        try:
            return handler((value,) * count)
        except ValidationError as error:  # without the index of the value, which nobody wrote
            raise error.errors()[0]["ctx"]["error"] from None

    return WrapValidator(read)


def quantity_of(annotation: Any) -> Quantity | None:
    """Return the first quantity within an annotated type, such as that of each speed of a tuple."""
    if isinstance(annotation, Quantity):
        return annotation
    return next((inner for part in get_args(annotation) if (inner := quantity_of(part))), None)


@lru_cache(maxsize=1)
def unit_registry() -> Any:
    """Return pint's units, made when the first string with a unit is read."""
    import pint  # loading it and its definitions costs more than the rest of a scene

    return pint.UnitRegistry(non_int_type=Decimal)
