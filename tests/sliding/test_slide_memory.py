"""The planned memory of a slide against the measured peak, bare and with skins."""

import tracemalloc

import numpy as np
import pytest

import roughsim as rs
from roughsim.contact import Solid
from roughsim.observables.moments import HeatSource
from roughsim.sliding.member import SlideProblem, solve_slide

SKIN = rs.Skin(1e-6, 3.0, 9e-7)
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}
SIDE, POINTS = 2e-3, 192


def slide_of(moving, resting, speeds, pixels, points=POINTS):
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        0.2, hurst=0.8, q_min=4 * np.pi / SIDE, q_max=0.5 * np.pi * points / SIDE
    )
    return SlideProblem(
        spectrum,
        spectrum,
        rs.Grid((points, points), (SIDE, SIDE)),
        Solid(1.1e11, 1.2e9),
        9e7,
        HeatSource(speeds=speeds, friction_coefficient=0.1, **STEEL, skin=moving),
        (rs.Body(**STEEL, skin=resting),) * len(speeds),
        (pixels * SIDE / points,) * len(speeds),
        tolerance=3e-3,
        seed=1,
        stream=0,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("moving", "resting", "speeds", "pixels"),
    [
        pytest.param(None, None, [10.0], 20, marks=pytest.mark.slow),
        (SKIN, None, [10.0], 12),
        pytest.param(SKIN, SKIN, [10.0, 35.0], 20, marks=pytest.mark.slow),
    ],
)
def test_the_planned_memory_of_a_slide_is_its_peak_and_at_most_half_more(
    moving, resting, speeds, pixels
):
    solve_slide(
        slide_of(moving, resting, speeds, 4, points=32)
    )  # compiled code and tables are there
    problem = slide_of(moving, resting, speeds, pixels)
    tracemalloc.start()
    try:
        solve_slide(problem)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak <= problem.memory <= 1.5 * peak


def test_a_skin_on_each_body_takes_as_much_memory_as_the_other():
    bare, one, other, both = (
        slide_of(moving, resting, [10.0], 400).memory
        for moving, resting in ((None, None), (SKIN, None), (None, SKIN), (SKIN, SKIN))
    )
    assert one == other
    assert both - one == pytest.approx(one - bare)
    assert one - bare > 100 * POINTS**2  # bytes
