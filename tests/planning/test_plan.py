"""Plans: what a scene overrides, what is computed in its place, what is expected to be spent, and what is refused."""

import re
from dataclasses import replace

import pytest

import roughsim as rs
from roughsim import plan as _function  # the public name is the function, whatever was imported
from roughsim import prediction
from roughsim.planning.reasons import span
from roughsim.scene import bundled_scenes
from roughsim.scene.numerics import DEFAULT_REASONS, Level


def reason_of(numerics, choice):
    (reason,) = [reason for reason in numerics.reasons if reason.quantity == choice]
    return reason


@pytest.mark.parametrize("name", bundled_scenes())
def test_a_bundled_scene_is_planned_with_a_reason_for_each_choice(name):
    scene = rs.load_scene(name)
    numerics = rs.plan(scene)
    assert numerics == rs.plan(scene)
    choices = [reason.quantity for reason in numerics.reasons]
    assert {"cell", "CPU time", "workers", "memory", "moments", *DEFAULT_REASONS} <= {*choices}
    for column in numerics.columns:
        assert choices.count(column) == len(numerics.of_column(column))


def test_what_the_scene_fixes_is_taken_as_it_is(capped_scene):
    numerics = rs.plan(capped_scene)
    assert [level.shape for level in numerics.levels] == [(64, 64), (64, 64), (128, 128)]
    assert numerics.lengths == (2e-3, 2e-3)
    assert {reason_of(numerics, key).text for key in ("levels", "cell", "tolerance")} == {
        "given in the scene"
    }


@pytest.mark.parametrize(("hardness", "left_out"), [(4e10, True), (2.5e10, False), (1.2e9, False)])
def test_a_hardness_that_is_never_reached_is_left_out_with_a_word(hardness, left_out):
    scene = rs.load_scene("demo")
    hard = replace(scene, body=replace(scene.body, penetration_hardness=hardness))
    areas = prediction.area_fractions(hard)
    assert (areas["plastic_fraction"] / areas["contact_fraction"] < 1e-6) == left_out
    elastic = replace(scene, body=replace(scene.body, penetration_hardness=None))
    assert prediction.computed(hard) == (elastic if left_out else hard)
    numerics = rs.plan(hard)
    assert ("elastic" in numerics.columns) == left_out
    if left_out:
        assert numerics == rs.plan(elastic)
        assert reason_of(numerics, "hardness").value == "40 GPa left out"


def test_a_hardness_is_kept_where_levels_or_targets_ask_for_contact_that_yields():
    scene = rs.load_scene("demo")
    hard = replace(scene, body=replace(scene.body, penetration_hardness=1e11))
    levels = replace(
        hard, numerics=replace(hard.numerics, levels=(Level("capped", (64, 64), 2e4),))
    )
    target = replace(hard, ensemble=replace(hard.ensemble, until={"plastic_fraction": 0.1}))
    for asked in (levels, target):
        assert prediction.computed(asked) is asked
    other = (
        'conductivity = 30\ndensity = 7900\nheat_capacity = 500\npenetration_hardness = "90 GPa"'
    )
    two = rs.scene.parse_scene(re.sub('like = "body"', other, hard.to_toml()))
    assert prediction.computed(two).elastic


def test_the_target_is_that_of_the_scene_or_one_per_cent():
    scene = rs.load_scene("steel-1.2GPa")

    def told(until, target=None):
        numerics = rs.plan(replace(scene, ensemble=replace(scene.ensemble, until=until)), target)
        return reason_of(numerics, "CPU time").text

    assert "total error of 2 %" in told({"flash_temperature": 0.02})
    assert "total error of 1 %" in told({"contact_fraction": 0.02})
    assert "total error of 0.5 %" in told({"flash_temperature": 0.02}, 0.005)


def test_a_target_beyond_the_most_realizations_is_told_with_their_number():
    scene = rs.load_scene("steel-0.5GPa")
    scene = replace(scene, numerics=replace(scene.numerics, lengths=(4e-3, 4e-3)))

    def needed(target):
        why = reason_of(rs.plan(scene, target), "CPU time").text
        found = re.match(
            r"of max_realizations = 400; at least some (\d+) are needed to a total error of", why
        )
        return int(found[1]) if found else None

    assert needed(0.01) is None
    assert needed(0.0004) > 400
    assert needed(0.0002) == pytest.approx(4 * needed(0.0004), rel=0.01)  # as the inverse square


def test_the_cost_grows_as_the_inverse_square_of_the_target_and_ends_with_the_realizations():
    steel = rs.load_scene("steel-0.5GPa")

    def seconds(target, most=1_000_000):
        fixed = replace(steel.numerics, lengths=(4e-3, 4e-3))  # a cell grows with the target, too
        scene = replace(
            steel, ensemble=replace(steel.ensemble, max_realizations=most), numerics=fixed
        )
        value = reason_of(rs.plan(scene, target), "CPU time").value
        low, high = re.fullmatch(r"(.*) to (.*)", value).groups()
        units = {"s": 1.0, "min": 60.0, "h": 3600.0}
        return [float(text.split()[0]) * units[text.split()[1]] for text in (low, high)]

    # both have corrections in the same part of the cell
    (low, high), (lower, higher) = seconds(0.0005), seconds(0.001)
    assert low < high
    assert (low / lower, high / higher) == (
        pytest.approx(4.0, rel=0.1),
        pytest.approx(4.0, rel=0.1),
    )
    assert seconds(0.0005, most=100)[1] < seconds(0.01, most=100)[1] * 1.5


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.123, "0.12 s"), (119, "120 s"), (121, "2 min"), (7300, "2 h"), (5400, "90 min")],
)
def test_spans_of_time_are_rough(seconds, text):
    assert span(seconds) == text


def test_the_public_name_is_the_function():
    assert callable(_function)
    assert _function is rs.plan
