"""Numbers of any size in any key: a scene, or one line that names the key; never a bare error of arithmetic."""

import importlib
import random
import re
import warnings

import pytest
from scene_keys import KEYS
from soft_scene import RUBBER

from roughsim import cli
from roughsim.comparison.tables import theory_dict
from roughsim.planning.limits import judge
from roughsim.scene import SceneError, bundled_scenes, parse_scene, scene_text
from roughsim.scene.schema import Quantity
from roughsim.scene.sections import SlidingSection

EXTREMES = (
    "0",
    "-0.0",
    "-1",
    "5e-324",
    "1e-300",
    "1e-30",
    "1e-15",
    "1e15",
    "1e30",
    "1e300",
    "1.7e308",
    "-1e300",
)
NAMED = re.compile("|".join(KEYS))
BEYOND = ("5e-324", "1e-300", "1e-31", "1e31", "1e300", "-1.7e308")


def numeric_keys(text):
    return [
        key
        for key in dict.fromkeys(re.findall(r"(?m)^(\w+) = (?!.*\{)[^#\n]*?\d", text))
        if key != "title"
    ]


def with_number(text, key, number):
    return re.sub(
        rf"(?m)^({key} = )[^#\n]*",
        rf"\g<1>{f'[{number}]' if key == 'speed' else number} ",
        text,
        count=1,
    )


def test_a_number_beyond_arithmetic_is_refused_by_its_key():
    text = scene_text("steel-1.2GPa")
    keys = numeric_keys(text)
    assert {
        "youngs_modulus",
        "penetration_hardness",
        "nominal_pressure",
        "q_min",
        "speed",
        "gamma",
    } <= set(keys)
    for key in keys:
        for number in BEYOND:
            with pytest.raises(SceneError, match=key) as refused:
                parse_scene(with_number(text, key, number))
            assert str(refused.value).isprintable()


def test_the_least_and_largest_size_are_lawful_and_their_limits_are_told():
    length = Quantity("m", '"1 m"', gt=0)
    assert (length(1e-30, "x"), length(1e30, "x")) == (1e-30, 1e30)
    for wrong in (0.99e-30, 1.01e30, "1e31 m"):
        with pytest.raises(
            Exception, match=r"must be of a size from 1e-30 to 1e\+30 m; check the exponent"
        ):
            length(wrong, "x")
    assert SlidingSection(nominal_pressure=1, friction_coefficient=1, speed=[0.0, 5.0]).speed == (
        0.0,
        5.0,
    )


def test_a_band_too_wide_to_integrate_over_is_refused_at_once():
    text = scene_text("steel-1.2GPa")
    with pytest.raises(
        SceneError,
        match=r"q_max = 4.15e\+07 rad/m must be at most 1e\+12 times q_min = 1e-10 rad/m",
    ):
        parse_scene(with_number(text, "q_min", "1e-10"))


def test_what_arithmetic_gives_up_names_the_command(capsys, theory_table):
    theory_table(lambda scene: 1.0 / 0.0)
    with pytest.raises(SystemExit):
        cli.main(["theory", "demo"])
    error = capsys.readouterr().err
    assert error == (
        "roughsim: theory demo: ZeroDivisionError (float division by zero): a number is too large or too small "
        "to compute with\n"
    )


def test_a_cut_scene_at_rest_is_planned():
    planning = importlib.import_module("roughsim.planning.plan")
    numerics = planning.plan(parse_scene(with_number(RUBBER.read_text(), "speed", "0")))
    assert numerics.levels


@pytest.mark.slow
def test_extreme_numbers_are_planned_and_predicted_or_refused_in_words():
    planning = importlib.import_module("roughsim.planning.plan")
    rng = random.Random(16)
    texts = {name: scene_text(name) for name in bundled_scenes()}
    cases = [
        (name, key, number)
        for name in texts
        for key in numeric_keys(texts[name])
        for number in EXTREMES
    ]
    for name, key, number in rng.sample(cases, 150):
        text = with_number(texts[name], key, number)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            told = refusal(planning, text)
        assert told is None or NAMED.search(told), (name, key, number, told)


def refusal(planning, text):
    try:
        scene = parse_scene(text)
        theory_dict(scene)
        judge(scene, planning.plan(scene))
    except ValueError as error:  # and no other
        return str(error)
    return None
