"""Scenes that nobody would think of: read or refused in one line, planned or refused, never a surprise."""

import json
import warnings

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_keys import KEYS

import roughsim as rs
from roughsim.comparison.tables import theory_dict
from roughsim.planning.limits import judge
from roughsim.scene import SceneError, bundled_scenes, parse_scene, scene_text

LINES = [line for name in bundled_scenes() for line in scene_text(name).splitlines()]
STEADY = {"derandomize": True, "deadline": None, "database": None}  # the same cases in every run
UNITS = (
    "m",
    "um",
    "1/m",
    "Pa",
    "GPa",
    "W/(m K)",
    "m/s",
    "%",
    "",
    "degC",
    "dB",
    "m**9999",
    "µ",
    "1/0",
    "é",
    "kg/m^3",
)


def literal(value):
    """A TOML literal, sometimes an unlawful one."""
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{json.dumps(key)} = {literal(entry)}" for key, entry in value.items())
            + "}"
        )
    return (
        str(value).lower()
        if isinstance(value, bool)
        else repr(value)
        if not isinstance(value, str)
        else value
    )


numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from([0, -0.0, 1e-320, 1e308, 2**63, "nan", "inf", "-inf"]),
)
strings = st.one_of(
    st.text(max_size=20).map(json.dumps),
    st.tuples(st.floats(), st.sampled_from(UNITS)).map(lambda p: f'"{p[0]} {p[1]}"'),
)
scalars = st.one_of(
    numbers,
    strings,
    st.booleans(),
    st.sampled_from(["1979-05-27", "07:32:00", "''", "0x10", '"""']),
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=2)
    ),
)
keys = st.one_of(
    st.sampled_from(sorted(KEYS)),
    st.sampled_from(["[surface]", "psd_file", "x.y", "''"]),
    st.text(max_size=8),
)
lines = st.one_of(
    st.tuples(keys, values).map(lambda pair: f"{pair[0]} = {literal(pair[1])}"),
    st.sampled_from(LINES),
    st.text(max_size=30),
)


@settings(max_examples=100, **STEADY)
@given(
    st.sampled_from(bundled_scenes()),
    st.lists(st.tuples(st.integers(0, 60), lines), min_size=1, max_size=4),
)
@pytest.mark.slow
def test_any_lines_in_a_scene_make_a_scene_or_one_line_of_refusal(name, edits):
    text = [line.split("  #")[0] for line in scene_text(name).splitlines()]
    for place, line in edits:
        text.insert(place % (len(text) + 1), line)
        if place % 2:
            del text[place % len(text)]
    read_or_refused("\n".join(text))


@settings(max_examples=200, **STEADY)
@given(st.text(max_size=200))
@pytest.mark.slow
def test_any_text_is_a_scene_or_one_line_of_refusal(text):
    read_or_refused(text)


def read_or_refused(text):
    try:
        scene = parse_scene(text)
    except SceneError as refusal:
        message = str(refusal)
    else:
        message = "read"
        assert parse_scene(scene.to_toml()) == scene
    assert message.isprintable()
    assert len(message) < 500


def powers(low, high):
    return st.floats(low, high).map(lambda x: 10.0**x)


@st.composite
def lawful(draw):
    """A scene whose every number is lawful, over many decades."""
    q_min, load = draw(powers(-3, 9)), draw(powers(0, 11))
    q_max = q_min * draw(powers(0.01, 6))
    size = draw(st.sampled_from(["rms_height", "rms_slope"]))
    text = f"[surface]\n{size} = {draw(powers(-9, 2))}\nhurst = {draw(st.floats(0, 1))}\n"
    text += f"q_min = {q_min}\nq_max = {q_max}\n"
    if draw(st.booleans()):
        text += f"q_roll_off = {q_min * (q_max / q_min) ** 0.4}\nroll_off_exponent = {draw(st.floats(0, 4))}\n"
    text += f"[body]\nyoungs_modulus = {draw(powers(3, 13))}\npoisson_ratio = {draw(st.floats(-0.9, 0.5))}\n"
    text += "".join(
        f"{key} = {draw(powers(-2, 5))}\n" for key in ("conductivity", "density", "heat_capacity")
    )
    if draw(st.booleans()):
        text += f"penetration_hardness = {load * draw(powers(0, 8))}\n"
    text += draw(st.sampled_from(["", '[counterface]\nlike = "body"\n']))
    text += f"[sliding]\nnominal_pressure = {load}\nfriction_coefficient = {draw(powers(-3, 1))}\n"
    return text + f"speed = [0, {draw(powers(-9, 5))}]\n"


@pytest.mark.slow
@settings(max_examples=80, **STEADY)
@given(lawful())
def test_any_lawful_numbers_are_planned_and_predicted_or_refused(text):
    for ask in (rs.plan, theory_dict, judged):
        assert answered_or_refused(ask, text) < 500


def judged(scene):
    """What is said of a scene is one printable line each, whatever its numbers, and JSON without NaN."""
    found = judge(scene)
    assert all(line.isprintable() and len(line) < 500 for line in found.warnings)
    json.dumps(found.to_dict(), allow_nan=False)


def answered_or_refused(ask, text):
    """Length of the refusal: what `cli.main` turns into one line, and nothing else, may be raised."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            ask(parse_scene(text))
    except (
        ValueError,
        RuntimeError,
    ) as refusal:  # an integral that is not reached names nothing to mend
        return len(str(refusal))
    return 0
