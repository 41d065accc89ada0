"""Scenes of two sliding bodies with skins: what is slid, what a member holds, and the theory of the scene."""

import numpy as np
import pytest
from slide_cases import MILLIMETRE, sliding_scene

import roughsim as rs
from roughsim.planning.plan import plan
from roughsim.planning.realization import slide_problem
from roughsim.prediction.sliding import sliding_prediction
from roughsim.sliding.member import faces, solve_slide
from theory import two_bodies

SKIN = 'skin = { thickness = "1 um", conductivity = 3, density = 5200, heat_capacity = 650 }\n'
COUNTER_SKIN = 'skin = { thickness = "2 um", conductivity = 300 }\nheat_depth = "0.7 um"\n'
MOVING = (1e-6, 3.0, 3.0 / (5200 * 650))
RESTING = (2e-6, 300.0, 300.0 / (7900 * 500))
DIFFUSIVITY = 30 / (7900 * 500)
HEAT = "conductivity = 30\ndensity = 7900\nheat_capacity = 500\n"


def layered_scene():
    """A body with an oxide on a counterface of the same bulk with another skin, heated in depth."""
    return sliding_scene(
        MILLIMETRE,
        (f"{HEAT}[counterface]", f"{HEAT}{SKIN}[counterface]"),
        ('like = "body"', HEAT + COUNTER_SKIN),
    )


def slide_of(scene):
    return slide_problem(scene, plan(scene))


def test_each_body_of_a_slide_has_its_own_skin():
    problem = slide_of(layered_scene())
    for motion in problem.motions:
        assert motion.moving.skin == MOVING
        assert motion.moving.heat_depth == 0.0
        assert motion.resting.skin == RESTING
        assert motion.resting.heat_depth == 0.7e-6
    both = slide_of(
        sliding_scene(MILLIMETRE, (f"{HEAT}[counterface]", f"{HEAT}{SKIN}[counterface]"))
    )
    assert [motion.resting.skin for motion in both.motions] == [MOVING, MOVING]


def test_a_member_is_the_slide_of_its_faces_with_skins():
    problem = slide_of(layered_scene())
    solution = solve_slide(problem)
    still, riding = faces(problem)
    slid = rs.slide(
        still,
        problem.grid,
        problem.solid,
        nominal_pressure=9e7,
        friction_coefficient=0.11,
        speed=[1.0, 35.0],
        moving=rs.Body(30.0, DIFFUSIVITY, skin=MOVING),
        resting=rs.Body(30.0, DIFFUSIVITY, skin=RESTING, heat_depth=0.7e-6),
        counter_heights=riding,
        slid_distance=1e-3,
        tolerance=1e-4,
    )
    steps = slid.slid_distance.size
    late = np.arange(1, steps + 1) > steps / 2
    for name in ("flash_temperature", "frozen_flash_temperature"):
        stored = solution.numbers[f"sliding_{name}"]
        assert stored == pytest.approx(getattr(slid, name)[:, late].mean(axis=1), rel=1e-9)
    assert solution.numbers["sliding_background"] == pytest.approx(slid.background[:, -1], rel=1e-9)


def test_the_theory_of_a_scene_has_the_skins_of_both_bodies():
    scene = layered_scene()
    by_scene = sliding_prediction(scene)
    points, weights = np.polynomial.legendre.leggauss(3)
    load = {
        "effective_modulus": scene.effective_modulus,
        "nominal_pressure": 9e7,
        "friction_coefficient": 0.11,
    }
    part = 0.5 if scene.sliding_faces[1] is not None else 0.0
    slid = two_bodies.sliding_temperatures(
        scene.speeds,
        scene.spectrum,
        penetration_hardness=1e9,
        conductivity=30.0,
        diffusivity=DIFFUSIVITY,
        skin=MOVING,
        resting_skin=RESTING,
        resting_heat_depth=0.7e-6,
        moving_roughness=part,
        slid_distance=1e-3 * (0.75 + 0.25 * points)[:, None],
        **load,
    )
    assert by_scene.flash_temperature == pytest.approx(
        weights / 2 @ slid.flash_temperature, rel=1e-9
    )
    assert by_scene.heat_partition == pytest.approx(weights / 2 @ slid.moving_share, rel=1e-9)
