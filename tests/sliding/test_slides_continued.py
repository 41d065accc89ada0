"""Slides continued by the theory, against slides of the same faces to the end: eight lengths of the cell."""

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.scene import parse_scene

LENGTH, FACES, SPEEDS = 2e-3, 2, [0.3, 3.0]
Q_MIN = 4 * 2 * np.pi / LENGTH
SCENE = f"""
[surface]
rms_height = "0.6 um"
hurst = 0.6
q_min = {Q_MIN}
q_roll_off = {1.5 * Q_MIN}
q_max = {6 * Q_MIN}
[body]
youngs_modulus = 200e9
poisson_ratio = 0.3
density = 7900
heat_capacity = 500
conductivity = MOVING
[counterface]
youngs_modulus = 200e9
poisson_ratio = 0.3
density = 7900
heat_capacity = 500
conductivity = RESTING
[sliding]
nominal_pressure = "34 MPa"
friction_coefficient = 0.11
speed = {SPEEDS}
heat_partition = 0.5
history = "sliding"
slid_distance = {8 * LENGTH}
"""


def errors(moving, resting):
    """The relative errors of T_flash over the frozen one, of the share and of the background, (numbers, speeds)."""
    scene = parse_scene(SCENE.replace("MOVING", str(moving)).replace("RESTING", str(resting)))
    grid, members = rs.Grid((64, 64), (LENGTH, LENGTH)), []
    for index in range(FACES):
        slid = rs.slide(
            rs.synthesize(scene.spectrum, grid, np.random.default_rng([5, index])),
            grid,
            rs.Solid(scene.effective_modulus),
            nominal_pressure=34e6,
            friction_coefficient=0.11,
            speed=SPEEDS,
            moving=rs.Body(moving, moving / (7900 * 500)),
            resting=rs.Body(resting, resting / (7900 * 500)),
            slid_distance=8 * LENGTH,
        )
        numbers = []
        for end in (LENGTH, 8 * LENGTH):
            late = (slid.slid_distance > 0.5 * end) & (slid.slid_distance <= end * (1 + 1e-6))
            flash, frozen, share = (
                curve[:, late].mean(axis=1)
                for curve in (
                    slid.flash_temperature,
                    slid.frozen_flash_temperature,
                    slid.moving_share,
                )
            )
            numbers.append([flash / frozen, share, slid.background[:, late][:, -1]])
        members.append(numbers)
    followed, whole = np.mean(members, axis=0)
    return followed * np.array(prediction.sliding_continuation(scene, LENGTH)[:3]) / whole - 1.0


@pytest.mark.slow
@pytest.mark.statistical
def test_the_theory_continues_slides_of_like_bodies_within_its_error():
    assert np.abs(errors(30.0, 30.0)).max() < 0.025


@pytest.mark.slow
@pytest.mark.statistical
def test_and_on_a_much_better_conductor_it_does_not():
    assert np.abs(errors(3.0, 300.0)).max() > 0.04  # so that such slides are followed to their end
