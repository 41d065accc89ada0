"""Lines with the sizes of a skin and of junction growth in scenes without them, and layers that are too thick."""

from math import sqrt

import numpy as np
import pytest
from soft_scene import RUBBER

import roughsim as rs
from roughsim import prediction
from roughsim.planning.limits import judge
from roughsim.prediction.first_micrometre import effects, growth_effects, skin_effects

STEEL = "steel-1.2GPa"


def test_the_sizes_are_ratios_of_the_theory_with_a_skin_and_without():
    scene = rs.load_scene(STEEL)
    oxide = {"thickness": "10 nm", "conductivity": 3, "density": 3400, "heat_capacity": 1000}
    worked = {"thickness": "1 um", "conductivity": 15}
    bare, *layered = (
        prediction.calibrated_predictions(each)["flash_temperature"][-1]
        for each in (scene, scene.with_("body.skin", oxide), scene.with_("body.skin", worked))
    )
    assert skin_effects(scene) == pytest.approx([hot / bare - 1 for hot in layered], rel=1e-12)
    lines = {remark.quantity: remark.text for remark in effects(scene)}
    assert (
        "at 100 m/s 10 nm of oxide make T_flash 9.7 % higher, 1 µm of half the conductivity 38 %"
        in (lines["first micrometre"])
    )
    assert "contact under friction" not in lines  # μ = 0.11


@pytest.mark.parametrize(
    "changes",
    [
        {"body.skin": {"thickness": "10 nm", "conductivity": 3}},
        {"body.heat_depth": "1 um"},
        {"body.conductivity": 3},
        {"sliding.speed": 0},
    ],
)
def test_scenes_with_layers_and_poor_conductors_have_no_such_line(changes):
    assert skin_effects(rs.load_scene(STEEL, changes)) is None


def test_the_growth_of_junctions_lowers_the_hardness():
    scene = rs.load_scene(STEEL, {"sliding.junction_growth": 9})
    assert scene.penetration_hardness == pytest.approx(1.2e9 / sqrt(1 + 9 * 0.11**2), rel=1e-14)
    as_hard = rs.load_scene(STEEL, {"body.penetration_hardness": scene.penetration_hardness})
    for name in ("flash_temperature", "contact_fraction"):
        grown, plain = (prediction.predictions(each)[name] for each in (scene, as_hard))
        np.testing.assert_allclose(grown, plain, rtol=1e-12)
    assert rs.load_scene(STEEL, {"sliding.junction_growth": 0}).penetration_hardness == 1.2e9


def test_much_friction_has_a_line_on_the_growth_of_junctions():
    rubbing = {"sliding.friction_coefficient": 0.3, "sliding.speed": "35 m/s"}
    assert "9 and 25 would change T_flash at 35 m/s by -23 % and -42 %" in growth_effects(
        rs.load_scene(STEEL, rubbing)
    )
    assert "make the yielded contact 2.3 and 3.6 times as large" in growth_effects(
        rs.load_scene("granite")
    )
    assert growth_effects(rs.load_scene(STEEL)) == ""
    assert growth_effects(rs.load_scene(STEEL, rubbing | {"sliding.junction_growth": 9})) == ""
    elastic = {"body.penetration_hardness": None}
    assert growth_effects(rs.load_scene(STEEL, rubbing | elastic)) == ""


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"body.penetration_hardness": None},
            "sliding.junction_growth = 9 lowers a penetration_hardness, and no body",
        ),
        (
            {
                "sliding.friction_coefficient": {"temperature": [300, 900], "value": [0.1, 0.2]},
                "sliding.background_temperature": 300,
            },
            "sliding.junction_growth = 9 goes with one friction_coefficient",
        ),
        (
            {"sliding.nominal_pressure": "1 GPa", "sliding.friction_coefficient": 0.7},
            "the penetration_hardness lowered by junction_growth, which no contact can carry",
        ),
    ],
)
def test_a_growth_that_does_not_fit_is_refused(changes, words):
    with pytest.raises(rs.RoughsimError, match=words):
        rs.load_scene(STEEL, {"sliding.junction_growth": 9} | changes)


def test_a_hardness_that_is_never_reached_is_left_out_with_its_growth():
    scene = rs.load_scene(
        RUBBER, {"body.penetration_hardness": "90 GPa", "sliding.junction_growth": 9}
    )
    assert prediction.computed(scene).elastic


@pytest.mark.parametrize("key", ["body.skin", "body.heat_depth"])
def test_a_layer_as_thick_as_the_roughness_is_long_is_warned_of(key):
    for depth, warned in ((1e-3, True), (1e-5, False)):
        value = {"thickness": depth, "conductivity": 3} if key == "body.skin" else depth
        lines = judge(rs.load_scene(STEEL, {key: value})).warnings
        assert (
            any(line.startswith(key) and "above 0.1 of the cell of" in line for line in lines)
            == warned
        )


def test_a_thick_layer_on_the_counterface_is_warned_of_by_its_own_name():
    own = {"conductivity": 30, "density": 7900, "heat_capacity": 500}
    for key, value in (("skin", {"thickness": 1e-3, "conductivity": 3}), ("heat_depth", 1e-3)):
        warned = judge(rs.load_scene(STEEL, {"counterface": own | {key: value}})).warnings
        line = next(line for line in warned if "above 0.1 of the cell of" in line)
        assert line.startswith(f"counterface.{key}")
        assert ("changes the elastic contact" in line) == (
            key == "skin"
        )  # a depth of the heat has no mechanics
