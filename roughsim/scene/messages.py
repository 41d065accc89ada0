"""The one line that a wrong scene gets: the key, the value with its unit, the limit, and what to do."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from roughsim.errors import RoughsimError
from roughsim.show.text import plain


class SceneError(RoughsimError, ValueError):
    """A scene cannot be used; the message is one line that names the key and says what to do."""


def refused_value(text: str) -> PydanticCustomError:
    """Return the refusal of one key's value; `text` continues the key: ``" = 3 Pa must be ..."``."""
    return PydanticCustomError("value", "{text}", {"text": text})


def refused_section(text: str) -> PydanticCustomError:
    """Return the refusal of keys that do not go together; `text` begins with a key of the section."""
    return PydanticCustomError("section", "{text}", {"text": text})


def shown(value: Any, unit: str = "") -> str:
    """Return a value as the scene file would write it, short and on one line, with its SI unit if it is a number."""
    if isinstance(value, str):
        return _short(json.dumps(value, ensure_ascii=False))
    if isinstance(value, bool):
        return str(value).lower()
    try:
        text = repr(value)
    except ValueError:  # Python prints no whole number of more than 4300 digits
        return "a number of thousands of digits"
    return _short(f"{text} {unit}" if unit and isinstance(value, (int, float)) else text)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``did you mean "..."?`` for the nearest known word, or the list of them."""
    known = list(known)
    by_lower = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    if near:
        return f'did you mean "{by_lower[near[0]]}"?'
    return f"the choice is {', '.join(known)}"


def one_line(
    error: ValidationError, section: str, known: Mapping[str, tuple[str, ...]], examples: Mapping[str, str]
) -> str:
    """Return the most telling of pydantic's findings as one line.

    Parameters
    ----------
    error : ValidationError
        What pydantic found; an unknown key goes first, for it often explains a missing one.
    section : str
        The section that was being read, "" for the whole scene.
    known : mapping
        The keys of each section; "" holds the sections themselves.
    examples : mapping
        For each key, a value as a scene file would write it.
    """
    details = error.errors(include_url=False)
    first = next((d for d in details if d["type"] == "unexpected_keyword_argument"), details[0])
    return plain(_sentence(first, section, known, examples))


def _sentence(
    detail: ErrorDetails, section: str, known: Mapping[str, tuple[str, ...]], examples: Mapping[str, str]
) -> str:
    path = (section, *detail["loc"]) if section else detail["loc"]
    key, kind = _dotted(path), detail["type"]
    if kind == "value":
        return key + str(detail["ctx"]["text"])
    if kind == "section":
        return f"{key}.{detail['ctx']['text']}" if key else str(detail["ctx"]["text"])
    if kind == "missing":
        return _missing(key, path, examples)
    if kind == "unexpected_keyword_argument":
        return f"{key} = {shown(detail['input'])} is not a key of a scene; {_where(path, known)}"
    if kind == "dataclass_type":
        return f"{key} = {shown(detail['input'])} must be a section: a line [{key}] with its keys below"
    return f"{key} = {shown(detail['input'])} cannot be used: {detail['msg'].lower()}; {_example(path, examples)}"


def _missing(key: str, path: tuple[int | str, ...], examples: Mapping[str, str]) -> str:
    if len(path) == 1:
        return f"section [{key}] is missing; `roughsim new` writes a complete scene to start from"
    return f"{key} is missing; {_example(path, examples)} in [{_dotted(path[:-1])}]"


def _example(path: tuple[int | str, ...], examples: Mapping[str, str]) -> str:
    name = str(path[-1])
    return f"write for example {name} = {examples[name]}" if name in examples else "see `roughsim new` for an example"


def _where(path: tuple[int | str, ...], known: Mapping[str, tuple[str, ...]]) -> str:
    """Where an unknown key may have been meant to go: a near name here, its own section, or the list of names."""
    word = str(path[-1])
    here = ".".join(str(part) for part in path[:-1] if isinstance(part, str))
    names = known.get(here, ())
    if not get_close_matches(word.lower(), names, n=1, cutoff=0.6):
        for section, keys in known.items():
            if word in keys and section:
                return f"it belongs in [{section}]"
    return did_you_mean(word, names)


def _dotted(path: tuple[int | str, ...]) -> str:
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if re.fullmatch(r"[A-Za-z0-9_.-]+", part) else shown(part))
    return _short(text)


def _short(text: str) -> str:
    return text if len(text) <= 80 else text[:77] + "..."
