"""Cell and corrections of elastic contact: what size and highest cut-off leave of the error, over the target."""

from dataclasses import replace
from math import hypot, inf, pi

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.cell_size import first_within, size_error

STEEL = {
    "youngs_modulus": 2e11,
    "poisson_ratio": 0.3,
    "conductivity": 30.0,
    "density": 7900,
    "heat_capacity": 500,
}
Q_MIN, SLOPE = 6350.0, 0.1
TARGETS = [0.05, 0.02, 0.01, 0.007, 0.005, 0.0035, 0.002]
SCENES = {  # H, q_max/q_min, σ₀/(E* rms slope), q_roll_off/q_min
    "broad": (0.7, 256, 0.04, 1),
    "low H": (0.42, 700, 0.1, 1),
    "light": (0.6, 70, 0.004, 1),
    "endless": (0.8, 20_000, 0.03, 1),
    "roll-off": (0.55, 150, 0.02, 4),
    "short": (0.9, 25, 0.2, 1),
}


def elastic(hurst, band, load, roll_off):
    face = {"hurst": hurst, "q_min": Q_MIN, "q_max": band * Q_MIN, "rms_slope": SLOPE}
    if roll_off > 1:
        face |= {"q_roll_off": roll_off * Q_MIN, "roll_off_exponent": 1.5}
    pressure = load * SLOPE * 2e11 / (1 - 0.3**2)
    sliding = {
        "friction_coefficient": 0.1,
        "speed": [0.0, 0.1, 3.0, 100.0],
        "nominal_pressure": pressure,
    }
    return rs.load_scene({"surface": face, "body": STEEL, "sliding": sliding})


SLOW = "low H", "broad", "roll-off"


@pytest.fixture(
    scope="module",
    params=[pytest.param(n, marks=[pytest.mark.slow] if n in SLOW else []) for n in SCENES],
)
def scene(request):
    return elastic(*SCENES[request.param])


def expected(scene, lengths, parts, top):
    """Return the error by size, and 0.3 of what the theory adds beyond the cut-off `top`, rad/m."""
    moving = np.array(scene.speeds) > 0.0
    below, whole = (
        prediction.predictions(scene, q)["flash_temperature"][moving] for q in (top, inf)
    )
    return hypot(size_error(scene, lengths, parts=parts), 0.3 * np.max(1 - below / whole))


def of_plan(scene, target):
    numerics = rs.plan(scene, target)
    return expected(scene, numerics.lengths, numerics.parts("elastic"), numerics.levels[-1].q_max)


def of_grid(scene, waves, parts):
    """Return the same of a cell with so many longest waves per side, and a grid of 4096² points in a part of it."""
    top = min(
        4096 * parts / 3 / waves * Q_MIN, scene.spectrum.breaks[-1]
    )  # 3 points per shortest wave
    return expected(scene, (waves * 2 * pi / Q_MIN,) * 2, parts, top)


def test_a_lower_target_leaves_no_larger_error_by_size_and_cut_off(scene):
    errors = [of_plan(scene, target) for target in TARGETS]
    assert np.all(np.diff(errors) <= 1e-12)
    for target, error in zip(
        TARGETS, errors, strict=True
    ):  # half of the square, or the least in reach
        assert error <= 0.5**0.5 * target or error == errors[-1]


@pytest.mark.parametrize("target", [0.02, 0.005])
def test_the_cell_is_the_shortest_that_suffices_or_the_best(scene, target):
    numerics = rs.plan(scene, target)
    waves = round(numerics.lengths[0] * Q_MIN / (2 * pi))
    errors = {n: min(of_grid(scene, n, parts) for parts in (2, 4)) for n in range(4, 33, 2)}
    sufficient = [n for n, error in errors.items() if error <= 0.5**0.5 * target]
    assert waves == (sufficient[0] if sufficient else min(errors, key=errors.get))
    if sufficient:  # corrections in a quarter where that suffices
        assert (numerics.parts("elastic") == 4) == (of_grid(scene, waves, 4) <= 0.5**0.5 * target)


def test_targets_out_of_reach_have_one_plan():
    scene = elastic(*SCENES["low H"])
    assert rs.plan(scene, 0.001) == rs.plan(scene, 0.0005)
    assert of_plan(scene, 0.001) > 0.001


def test_a_small_cell_that_the_scene_gives_is_corrected_as_a_whole():
    light = elastic(*SCENES["light"])
    small = replace(light, numerics=replace(light.numerics, lengths=(4 * 2 * pi / Q_MIN,) * 2))
    assert rs.plan(small, 0.01).parts("elastic") == 1
    assert rs.plan(small, 0.2).parts("elastic") == 4


def test_contact_at_rest_has_a_plan():
    scene = elastic(*SCENES["endless"])
    resting = replace(scene, sliding=replace(scene.sliding, speed=(0.0,)))
    assert rs.plan(resting, 0.01).levels[-1].shape == (4096, 4096)


def test_the_first_choice_within_a_limit_counts_else_the_last_of_the_best():
    errors = {4: 0.3, 6: 0.1, 8: 0.2, 10: 0.1}
    assert first_within(0.3, errors) == 4
    assert first_within(0.2, errors) == 6
    assert first_within(0.05, errors) == 10
