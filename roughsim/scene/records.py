"""Records of a scene: frozen, checked by pydantic when made or replaced, and refused in one line."""

from __future__ import annotations

import json
import re
from dataclasses import fields, make_dataclass
from functools import lru_cache
from typing import Any, ClassVar, TypeVar, get_args, get_type_hints

from pydantic import ConfigDict, ValidationError

from roughsim.errors import RoughsimError
from roughsim.scene.messages import SceneError, as_written, did_you_mean, shortened
from roughsim.scene.quantities import quantity_of
from roughsim.show.text import plain

Made = TypeVar("Made")
SECTIONS: dict[str, type[Record]] = {}  # by their names in a scene file; "" is the scene itself


class RecordType(type):
    """Makes the constructor of a record raise `SceneError` of one line in place of pydantic's findings."""

    def __call__(cls: type[Made], *args: Any, **values: Any) -> Made:
        """Return a checked record."""
        try:
            return super().__call__(*args, **values)  # type: ignore[misc, no-any-return]
        except ValidationError as error:
            details = error.errors(include_url=False)
        # an unknown key goes first, for it often explains a missing one
        detail = next((d for d in details if d["type"] == "unexpected_keyword_argument"), details[0])
        cause = detail.get("ctx", {}).get("error")
        raise cause if isinstance(cause, RoughsimError) else SceneError(plain(one_line(detail, cls)))


class Record(metaclass=RecordType):
    """A frozen pydantic dataclass whose fields are keys of a scene; ``section="..."`` names the section it is."""

    __pydantic_config__ = ConfigDict(extra="forbid")
    section: ClassVar[str] = ""

    def __init_subclass__(cls, section: str | None = None) -> None:
        if section is not None:
            cls.section = section
            SECTIONS[section] = cls

    @classmethod
    def known_keys(cls) -> list[str]:
        """Return the keys that a scene file may give."""
        return [field.name for field in fields(cls)]  # type: ignore[arg-type]


def optional_keys(record: type[Record]) -> Any:
    """Return a base class with the keys of another record, each of which may be left out: it is then None."""
    hints = key_types(record)
    keys = [(field.name, hints[field.name] | None, None) for field in fields(record) if field.compare]  # type: ignore[arg-type]
    return make_dataclass(f"Optional{record.__name__}", keys, bases=(Record,), frozen=True, kw_only=True)


@lru_cache(maxsize=64)
def key_types(record: Any) -> dict[str, Any]:
    """Return the annotated type of each key of a record."""
    return get_type_hints(record, include_extras=True)


def quantity(record: Any, key: str) -> Any:
    """Return the `Quantity` that reads a key of a record; None where it is no number."""
    return quantity_of(key_types(record).get(key))


def one_line(detail: Any, record: Any) -> str:
    """Return one of pydantic's findings in a record as a sentence: the key, its value, the limit and what to do."""
    location, kind, value = detail["loc"], detail["type"], as_written(detail["input"])
    if location and location[0] in range(len(record.known_keys())):  # given by its position
        location = (record.known_keys()[location[0]], *location[1:])
    path = (record.section, *location) if record.section else location
    key, holder = dotted(path), dotted(path[:-1])
    # the record in which the key stands: this one, or a section within it
    inner = record if len(location) == 1 else SECTIONS.get(re.sub(r"\[\d+\]", "", holder), record)
    if kind == "value_error":  # of our own checks: its text goes on after the key of a value, or begins with a key
        text = str(detail["ctx"]["error"])
        return f"{key}.{text}" if key and text[0] not in " .[" else key + text
    if kind == "unexpected_keyword_argument":
        return f"{key} = {value} is not a key of a scene; {where_known(str(path[-1]), inner)}"
    if kind == "dataclass_type":
        return f"{key} = {value} must be a section: a line [{key}] with its keys below"
    if kind == "missing":
        return missing(key, holder, inner)
    if kind == "literal_error":
        words = re.findall(r"'(.*?)'", detail["ctx"]["expected"])
        return f"{key} = {value} is not known; {did_you_mean(str(detail['input']), words)}"
    return f"{key} = {value} " + ("must be a list" if kind == "tuple_type" else f"cannot be used: {detail['msg']}")


def missing(key: str, holder: str, record: Any) -> str:
    """Return that a key or section is missing, and how a scene file would write it."""
    if key in SECTIONS:
        return f"section [{key}] is missing; `roughsim new` writes a complete scene to start from"
    name = key.rpartition(".")[2]
    number, words = quantity(record, name), get_args(key_types(record)[name])  # words of a Literal
    example = f"{name} = {number.example if number else json.dumps(words[0])}"
    return f"{key} is missing; write for example {example}" + (f" in [{holder}]" if holder else "")


def where_known(word: str, record: Any) -> str:
    """Return where an unknown key may have been meant to go: a near name here, its own section, or all names here."""
    hint = did_you_mean(word, record.known_keys())
    if hint.startswith("did you mean"):
        return hint
    order = (*SECTIONS[""].known_keys(), *SECTIONS)
    section = next((name for name in order if name in SECTIONS and name and word in SECTIONS[name].known_keys()), None)
    return f"it belongs in [{section}]" if section else hint


def dotted(path: tuple[int | str, ...]) -> str:
    """Return a path as a scene file writes it: ``numerics.levels[0].shape``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if re.fullmatch(r"[A-Za-z0-9_.-]+", part) else as_written(part))
    return shortened(text)
