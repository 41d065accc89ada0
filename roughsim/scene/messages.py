"""Words of a refusal: the error, a value as a scene file writes it, and the name that may have been meant."""

from __future__ import annotations

import json
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from roughsim.errors import RoughsimError


class SceneError(RoughsimError, ValueError):
    """A scene cannot be used; the message is one line that names the key and says what to do."""


def as_written(value: Any, unit: str = "") -> str:
    """Return a value as the scene file would write it, short and on one line, with its SI unit if it is a number."""
    if isinstance(value, str):
        return shortened(json.dumps(value, ensure_ascii=False))
    if isinstance(value, bool):
        return str(value).lower()
    try:
        text = repr(value)
    except ValueError:  # Python prints no whole number of more than 4300 digits
        return "a number of thousands of digits"
    return shortened(f"{text} {unit}" if unit and isinstance(value, (int, float)) else text)


def shortened(text: str) -> str:
    """Return the first 80 characters."""
    return text if len(text) <= 80 else text[:77] + "..."


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``did you mean "..."?`` for the nearest known word, or the list of them."""
    known = list(known)
    by_lower = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    if near:
        return f'did you mean "{by_lower[near[0]]}"?'
    return f"the choice is {', '.join(known)}"
