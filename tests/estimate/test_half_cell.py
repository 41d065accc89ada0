"""Corrections from half or a quarter of the cell: where they are allowed, and the error that they add."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import roughsim as rs
from roughsim.estimate import cell_size
from roughsim.estimate.cell_size import size_error

WAVE = 2 * pi / 6350


@pytest.fixture(scope="module")
def steel():
    return rs.load_scene("steel-1.2GPa")


def loaded(scene, pressure):
    return replace(scene, sliding=replace(scene.sliding, nominal_pressure=pressure))


def cell(waves):
    return (waves * WAVE, waves * WAVE)


@pytest.mark.parametrize(("target", "most"), [(0.01, 0.05), (0.04, 0.1)])
def test_the_squared_error_in_a_part_of_the_cell_is_a_quarter_of_the_target_at_most(
    steel, target, most
):
    assert cell_size.parts_of(steel, cell(4), target) == 4
    # the error over 1 less the error is as (waves)^(−2)
    light = loaded(steel, 1e6)
    error = size_error(light, cell(4))
    # per side of the cell with this error
    waves = 4 * sqrt((1 / most - 1) * error / (1 - error))
    for times, parts in (
        (0.99, 1),
        (1.01, 1),
        (1.99, 1),
        (2.01, 2),
        (3.99, 2),
        (4.01, 4),
        (9.0, 4),
    ):
        lengths = (times * waves * WAVE, 20 * waves * WAVE)
        assert cell_size.parts_of(light, lengths, target) == parts


@pytest.mark.parametrize("target", [0.005, 0.01])
def test_a_part_of_the_cell_of_smoothed_contact_errs_by_the_target_at_most(steel, target):
    light = loaded(steel, 1e6)
    found = {
        waves: cell_size.parts_of(light, cell(waves), target, "smoothed")
        for waves in (8, 24, 40, 64, 256)
    }
    for waves, parts in found.items():
        errors = {n: size_error(light, cell(waves / n), column="smoothed") for n in (4, 2)}
        assert parts == next((n for n, error in errors.items() if error <= target), 1)
    assert set(found.values()) == {1, 2, 4}


@pytest.mark.parametrize("parts", [2, 4])
def test_a_part_adds_half_of_its_error_in_elastic_contact_and_its_square_in_capped_contact(
    steel, parts
):
    light = loaded(steel, 3e6)
    whole, part = (size_error(light, cell(waves)) for waves in (8, 8 / parts))
    found = size_error(light, cell(8), parts=parts)
    assert found == pytest.approx(np.hypot(whole, part**2), rel=1e-9)
    soft = replace(steel, body=replace(steel.body, penetration_hardness=None))
    for scene, column in ((soft, ""), (light, "smoothed")):
        whole, part = (size_error(scene, cell(waves), column=column) for waves in (8, 8 / parts))
        found = size_error(scene, cell(8), column=column, parts=parts)
        assert found == pytest.approx(np.hypot(whole, 0.5 * part), rel=1e-9)


@pytest.mark.slow
@pytest.mark.statistical
def test_half_the_cell_has_the_same_ratio_of_means():
    # σ₀/σ_P = .01, q_y = 3 q_min: from 2 to 4 q_y in cells of four and of two waves, where means differ by a tenth
    scene = rs.load_scene(
        {
            "surface": {
                "rms_height": "2.13 um",
                "hurst": 0.8,
                "q_min": 6350.0,
                "q_max": 96 * 6350.0,
            },
            "body": {
                "youngs_modulus": "200 GPa",
                "poisson_ratio": 0.3,
                "penetration_hardness": "2 GPa",
                "conductivity": 30.0,
                "density": 7900.0,
                "heat_capacity": 500.0,
            },
            "sliding": {
                "friction_coefficient": 0.11,
                "speed": [0.001, 100.0],
                "nominal_pressure": "20 MPa",
            },
        }
    )

    def ratio(waves, count):
        """Change of T_flash, and its standard error."""
        rows = np.empty((2, count, 2))
        for k in (1, 2):
            level = rs.Level("capped", (24 * k * waves,) * 2, 6 * k * 6350.0)
            numerics = rs.Numerics(
                (level,), cell(waves)
            )  # one level: both cut-offs have the same modes
            for i in range(count):
                rows[k - 1, i] = rs.realize(
                    scene, numerics, seed=waves, index=i
                ).observables.flash_temperature
        low, high = rows.mean(axis=1)
        scatter = (rows[1] / high - rows[0] / low).std(axis=0, ddof=1)
        return high / low - 1, high / low * scatter / sqrt(count)

    (whole, error), (half, other) = ratio(4, 100), ratio(2, 300)
    noise = np.hypot(error, other)
    assert np.all(noise < 0.004)
    assert np.all(whole < -0.03)  # there is something to compare
    charged = size_error(scene, cell(2)) ** 2 * np.abs(whole)
    assert np.all(np.abs(half - whole) < charged + 3 * noise)
