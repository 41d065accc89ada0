"""Reading and checking the keys of a scene.

A section is a `Record`, whose fields are its keys; a number is annotated with its unit and limits, as in
``Annotated[float, Quantity("Pa", ...)]``. Numbers are SI; strings carry a unit ("0.90 um") and are converted by pint in
decimal arithmetic, so that "0.90 um" is exactly 9e-7. Checks raise a ValueError whose text continues the key:
``" = 3 Pa must be ..."``; a record turns it into a `SceneError` of one line.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, make_dataclass
from decimal import Decimal
from functools import lru_cache
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform, get_args, get_type_hints

import numpy as np
from pydantic import (
    ConfigDict,
    GetCoreSchemaHandler,
    TypeAdapter,
    ValidationError,
    WrapValidator,
)
from pydantic.dataclasses import dataclass as pydantic_dataclass
from pydantic_core import core_schema

from roughsim.errors import RoughsimError
from roughsim.scene.spellings import OTHER_NAMES, nearest, suggestion, with_decimal_point
from roughsim.show.text import plain

_SMALLEST, _LARGEST = (
    1e-30,
    1e30,
)  # sizes of lawful numbers, SI: products of several of them do not overflow
_NUMBER_AND_UNIT = re.compile(
    r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*([\w%°/*^()·⋅.\-⁻ ]*)"
)
# unit → SI unit and factor; pint, which takes a third of a second to load, reads all others
USUAL = {
    "%": ("", "0.01"),
    "1/m": ("rad/m", "1"),
    "um": ("m", "1e-6"),
    "mm": ("m", "1e-3"),
    "m/s": ("m/s", "1"),
    "ms": ("s", "1e-3"),
    "K": ("K", "1"),
    "MPa": ("Pa", "1e6"),
    "GPa": ("Pa", "1e9"),
    "kg/m^3": ("kg/m^3", "1"),
    "J/(kg K)": ("J/(kg K)", "1"),
    "W/(m K)": ("W/(m K)", "1"),
    "eV": ("J", "1.602176634e-19"),
    "1/s": ("1/s", "1"),
}
_Made = TypeVar("_Made")
SECTIONS: dict[str, type["Record"]] = {}  # by their names in a scene file; "" is the scene itself
# not functools.cache: mypy takes no class for hashable whose instances are
_KEY_TYPES: dict[type["Record"], dict[str, Any]] = {}


class SceneError(RoughsimError, ValueError):
    """A scene cannot be used; the message is one line with the key, the limit and the remedy."""


def is_list(value: Any) -> bool:
    """Return whether a value is a list or a tuple."""
    return isinstance(value, (list, tuple))


def as_written(value: Any, unit: str = "") -> str:
    """Return a value as the scene file would write it, short and on one line, with its SI unit if it is a number."""
    try:
        text = literal(value)
    except ValueError:  # Python prints no whole number of more than 4300 digits
        return "a number of thousands of digits"
    return shortened(f"{text} {unit}".strip() if type(value) in (int, float) else text)


def literal(value: Any) -> str:
    """Return a value as TOML; a mapping is a table on one line."""
    if isinstance(value, Mapping):
        entries = [f"{key} = {literal(entry)}" for key, entry in value.items() if entry is not None]
        return f"{{ {', '.join(entries)} }}"
    if is_list(value):
        return f"[{', '.join(map(literal, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (str, bool)) else repr(value)


def shortened(text: str) -> str:
    """Return the first 80 characters."""
    return text if len(text) <= 80 else text[:77] + "..."


def did_you_mean(word: str, names: Iterable[str]) -> str:
    """Return ``did you mean "..."?``, or the list of all names if none is close to the word."""
    names = list(names)
    near = nearest(word, names)
    return f'did you mean "{near}"?' if near else f"the choice is {', '.join(names)}"


@dataclass(frozen=True)
class Quantity:
    """A number of a scene: its SI unit ("" for none), an example as written in a file, and its limits by pydantic.

    As the annotation of a field it reads a text with a unit before pydantic checks type and limits.
    """

    unit: str
    example: str
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    may_be_infinite: bool = False
    whole: bool = False
    smallest: float = _SMALLEST  # size of a number that is not zero

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Return the schema of the number: strict, so that no bool and no text without a unit passes."""
        limits: dict[str, Any] = {name: getattr(self, name) for name in ("gt", "ge", "lt", "le")}
        number: core_schema.CoreSchema = core_schema.float_schema(
            strict=True, allow_inf_nan=self.may_be_infinite, **limits
        )
        if self.whole:
            number = core_schema.int_schema(strict=True, **limits)
        return core_schema.no_info_wrap_validator_function(self.read, number)

    def __call__(self, value: Any, where: str = "") -> Any:
        """Return `value` in SI; the second argument is its key, or its place within the key, such as "[2]"."""
        try:
            return TypeAdapter(Annotated[Any, self]).validate_python(value)
        except ValidationError as error:
            raise ValueError(f"{where}{error.errors()[0]['ctx']['error']}") from None

    def read(self, value: Any, check: Callable[[Any], Any]) -> Any:
        """Return a number in SI, of a text with a unit or of NumPy, too; ValueError with what pydantic refuses."""
        number = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, str) and not self.whole:
            number = self.of_text(value)
        try:
            number = check(number)
        except ValidationError as error:
            (detail,) = error.errors()
            wanted = detail["msg"].removeprefix("Input should ")
            if "ctx" in detail:  # a limit
                wanted = f"{wanted} {self.unit}".rstrip()
            elif self.unit and detail["type"] == "float_type":
                wanted += f" in {self.unit} or a string with a unit"
        else:
            size = abs(number)
            if self.whole or not (0.0 < size < self.smallest or _LARGEST < size < math.inf):
                return number
            sizes = f"{self.smallest:g} to {_LARGEST:g} {self.unit}".rstrip()
            wanted = f"be of a size from {sizes}; check the exponent and the unit"
        raise ValueError(
            f" = {as_written(value, self.unit)} must {wanted}, for example {self.example}"
        )

    def of_text(self, value: str) -> float:
        """Return the value of a string with a unit, in SI."""
        match = _NUMBER_AND_UNIT.fullmatch(value) if len(value) <= 100 else None
        key = f" = {as_written(value)}"
        if match is None:
            several = ", or a list of such" * ("," in value)
            hint = with_decimal_point(value) or f"; write for example {self.example}{several}"
            raise ValueError(f"{key} is not a number with a unit{hint}")
        number, name = match[1], match[2].strip()
        if self.unit and not name:
            raise ValueError(
                f'{key} has no unit; write "{number} {self.unit}" or the number {number}'
            )
        unit, factor = USUAL.get(name, (None, "1"))
        if unit == self.unit:
            with suppress(ArithmeticError):  # numbers beyond decimals are refused below
                return float(Decimal(number) * Decimal(factor))
        units = _unit_registry()
        fault = f": the unit {as_written(name)} is not known"
        with suppress(Exception):  # pint fails in a dozen ways, from AssertionError to TokenError
            found = units.parse_units(name)
            fault = f" has the dimension {found.dimensionality}"
            if found.is_compatible_with(self.unit):
                fault = f" cannot be turned into {self.unit}"
                return float(units.Quantity(Decimal(number), found).to(self.unit).magnitude)
        kind = f"a quantity in {self.unit}" if self.unit else "a dimensionless number"
        hint = suggestion(number, name, self.unit, units)
        raise ValueError(f"{key}{fault}; {kind} is expected, for example {self.example}{hint}")


@lru_cache(maxsize=1)  # .4 s
def _unit_registry() -> Any:
    """Return pint's units, made when the first string with a unit is read."""
    import pint  # loading it and its definitions costs more than the rest of a scene

    return pint.UnitRegistry(non_int_type=Decimal)


def whole(example: str, at_least: int, at_most: int = 2**63 - 1) -> Quantity:
    """Return the annotation of a whole number; TOML holds no larger ones."""
    return Quantity("", example, ge=at_least, le=at_most, whole=True)


KELVIN = Quantity("K", '"300 K"', gt=0)
# keys that several records have
RmsHeight = Annotated[float, Quantity("m", '"0.90 um"', gt=0)]
Hurst = Annotated[float, Quantity("", "0.8", ge=0, le=1)]
QMin = Annotated[float, Quantity("rad/m", '"6350 1/m"', gt=0)]
QRollOff = Annotated[float, Quantity("rad/m", '"9.4e4 1/m"', gt=0)]
QMax = Annotated[float, Quantity("rad/m", '"4.15e7 1/m"', gt=0)]


def one_or_list(count: int = 1) -> WrapValidator:
    """Return the annotation of a tuple of `count` equal numbers, which may be written as one number."""

    def read(value: Any, check: Callable[[Any], Any]) -> Any:
        if not is_list(value):
            try:
                return check((value,) * count)
            except ValidationError as error:  # without an index, which the file does not have
                raise ValueError(error.errors()[0]["ctx"]["error"]) from None
        if not value:
            raise ValueError(f" = {as_written(value)} holds no number; write at least one")
        if count not in (1, len(value)):
            raise ValueError(f" = {as_written(value)} must be one number or two, along x and y")
        return check(value)

    return WrapValidator(read)


class Record:
    """A frozen pydantic dataclass whose fields are keys of a scene."""

    __pydantic_config__ = ConfigDict(extra="forbid")
    section: ClassVar[str] = ""

    @classmethod
    def known_keys(cls) -> list[str]:
        """Return the keys that a scene file may give."""
        return [field.name for field in fields(cls)]  # type: ignore[arg-type]


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
def record(
    section: str | None = None, *, kw_only: bool = True, repr: bool = True
) -> Callable[[type[_Made]], type[_Made]]:
    """Return a decorator that makes a class a record, the section of this name; its refusals are `SceneError`s."""

    def decorated(cls: type[Any]) -> Any:
        made: Any = pydantic_dataclass(cls, frozen=True, kw_only=kw_only, repr=repr)
        check = made.__init__

        def checked(self: Any, *values: Any, **keys: Any) -> None:
            try:
                check(self, *values, **keys)
            except ValidationError as error:
                raise refusal(error, made) from None

        made.__init__ = checked
        if section is not None:
            made.section = section
            SECTIONS[section] = made
        return made

    return decorated


def refusal(error: ValidationError, record: type[Record]) -> RoughsimError:
    """Return the error of one line for what pydantic refuses in a record."""
    details = error.errors(include_url=False)
    # an unknown key goes first, for it often explains a missing one
    unknown = (detail for detail in details if detail["type"] == "unexpected_keyword_argument")
    detail = next(unknown, details[0])
    cause = detail.get("ctx", {}).get("error")
    return (
        cause if isinstance(cause, RoughsimError) else SceneError(plain(_one_line(detail, record)))
    )


def optional_keys(record: type[Record]) -> Any:
    """Return a base class with the keys of another record, each of which may be left out: it is then None."""
    hints = _key_types(record)
    own = fields(record)  # type: ignore[arg-type]
    keys = [(field.name, hints[field.name] | None, None) for field in own if field.compare]
    return make_dataclass(
        f"Optional{record.__name__}", keys, bases=(Record,), frozen=True, kw_only=True
    )


def _key_types(record: type[Record]) -> dict[str, Any]:
    """Return the annotated type of each key of a record."""
    if record not in _KEY_TYPES:  # .4 ms for each key of a scene that is written
        _KEY_TYPES[record] = get_type_hints(record, include_extras=True)
    return _KEY_TYPES[record]


def quantity(record: type[Record], key: str) -> Quantity | None:
    """Return the first `Quantity` in the type of a key, such as of each speed of a list; None without one."""
    parts = [_key_types(record).get(key)]
    while parts:
        part = parts.pop(0)
        if isinstance(part, Quantity):
            return part
        parts = [*get_args(part), *parts]
    return None


def unit_of(record: type[Record], key: str) -> str:
    """Return the SI unit of a key; "" without one."""
    number = quantity(record, key)
    return "" if number is None else number.unit


def example(record: type[Record], key: str) -> str:
    """Return an example of a line with a key."""
    number = quantity(record, key)
    value = (
        json.dumps(get_args(_key_types(record)[key])[0]) if number is None else number.example
    )  # first of a Literal
    return f"{key} = {value}"


def _one_line(detail: Any, record: type[Record]) -> str:
    """Return one error of pydantic in a record as a sentence: the key, its value, the limit and the remedy."""
    location, kind, value = detail["loc"], detail["type"], as_written(detail["input"])
    keys = record.known_keys()
    if location and location[0] in range(len(keys)):  # given by its position
        location = (keys[location[0]], *location[1:])
    path = (record.section, *location) if record.section else location
    key, holder = _dotted(path), _dotted(path[:-1])
    # the record in which the key stands: this one, or a section within it
    names = [part for part in path if isinstance(part, str)]
    inner = SECTIONS.get(".".join(names[:-1]), record) if names[1:] else record
    if kind == "value_error":
        # of our own checks: its text goes on after the key of a value, or begins with a key
        text = str(detail["ctx"]["error"])
        return f"{key}.{text}" if key and text[0] not in " .[" else key + text
    if kind == "missing":
        return _missing(key, holder, inner)
    name = names[-1] if names else ""
    hints = {
        "unexpected_keyword_argument": f"is not a key of a scene; {_where_known(name, inner)}",
        "dataclass_type": f"must be a section: a line [{key}] with its keys below",
        "tuple_type": "must be a list",
    }
    if kind == "literal_error":
        words = re.findall(r"'(.*?)'", detail["ctx"]["expected"])
        hints[kind] = "is not known; " + did_you_mean(value.strip('"'), words)
    return f"{key} = {value} {hints.get(kind, detail['msg'].replace('Input should', 'must'))}"


def _missing(key: str, holder: str, record: type[Record]) -> str:
    """Return the message of a missing key or section, with an example."""
    if key in SECTIONS:
        where = "the roughness of a lone rough face stands there, whichever body has it; " * (
            key == "surface"
        )
        return f"section [{key}] is missing; {where}`roughsim new` writes a complete scene to start from"
    text = f"{key} is missing; write for example {example(record, key.rpartition('.')[2])}"
    return f"{text} in [{holder}]" if holder else text


def _where_known(word: str, record: type[Record]) -> str:
    """Return a hint for an unknown key: a similar name of this section, the section that has it, or all names here."""
    order = (*SECTIONS[""].known_keys(), *SECTIONS)
    homes = [
        name for name in order if name and name in SECTIONS and word in SECTIONS[name].known_keys()
    ]
    keys = record.known_keys()
    if not homes and word in OTHER_NAMES:
        return OTHER_NAMES[word]
    if word in keys:  # of a file, whose content the record has
        key = _dotted((record.section, word))
        return f'it names a file, read only when a scene is loaded: roughsim.load_scene(SCENE, {{"{key}": PATH}})'
    return (
        f"it belongs in [{homes[0]}]"
        if homes and not nearest(word, keys)
        else did_you_mean(word, keys)
    )


def _dotted(path: tuple[int | str, ...]) -> str:
    """Return a path as a scene file writes it: ``numerics.levels[0].shape``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (
                part if re.fullmatch(r"[A-Za-z0-9_.-]+", part) else as_written(part)
            )
    return shortened(text)
