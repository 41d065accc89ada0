"""The bundled steel scene as text, texts made from it, and how they are refused."""

from __future__ import annotations

import re
from typing import Any

import pytest

from roughsim.scene import SceneError, parse_scene, scene_text

STEEL = re.sub(r" *#.*", "", scene_text("steel-1.2GPa"))
ROWS = ((1.0e4, 3.0e-23), (1.0e5, 7.0e-27), (2.5e5, 1.0e-29))


def approx(value: float, rel: float) -> Any:
    # pytest's own default abs=1e-12 would call any two values of C(q) equal
    return pytest.approx(value, rel=rel, abs=0.0)


def changed(old: str, new: str, text: str = STEEL) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def with_counterface(lines: str) -> str:
    return changed('like = "body"', lines)


def refusal(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    message = str(caught.value)
    assert "\n" not in message
    assert message.isprintable()
    return message


def table_scene(rows: str, convention: str = "persson") -> str:
    surface = STEEL[STEEL.index("rms_height") : STEEL.index("[body]")]
    return STEEL.replace(surface, f'{rows}\npsd_convention = "{convention}"\n')
