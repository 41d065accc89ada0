"""Tables over temperature of faces with a lay: one constant for each speed in each direction."""

from math import pi

import numpy as np
import pytest
from small_scene import CAPPED

from roughsim import Grid, prediction
from roughsim.results.heated import Way, temperature
from roughsim.scene import parse_scene
from theory import lay

FREE = CAPPED.replace("lengths = [2e-3, 2e-3]\n", "").replace(
    "[0, 0.1, 35]", '[35]\ndirection = ["0 deg", "90 deg"]'
)
HEAT_CAPACITY = 7900 * 500
ANGLES = (0.0, pi / 2)


def over(low, high):
    return f"{{ temperature = [300, 1500], value = [{low}, {high}] }}"


def scene(conductivity="30", friction="0.11", gamma=3, **sliding):
    text = FREE.replace("[surface]\n", f"[surface]\nlay = {gamma}\n")
    keys = {"background_temperature": 350, "heat_partition": 0.9} | sliding
    lines = "".join(f"{key} = {value!r}\n" for key, value in keys.items()).replace("'", '"')
    text = text.replace("heat_partition = 0.9\n", lines)
    text = text.replace("conductivity = 30", f"conductivity = {conductivity}")
    return parse_scene(
        text.replace("friction_coefficient = 0.11", f"friction_coefficient = {friction}")
    )


def flash(found, kappa, friction):
    """T_flash by the law, (directions, speeds), K, of arrays κ and μ."""
    load = {"nominal_pressure": 9e7}
    modulus = {"effective_modulus": found.effective_modulus, "penetration_hardness": 1e9}
    stress = lay.stress_of_lay(found.spectrum, 3.0, **load, **modulus)
    return np.array(
        [
            lay.flash_temperature(
                speed,
                angle,
                stress,
                friction_coefficient=mu,
                conductivity=k,
                diffusivity=k / HEAT_CAPACITY,
                **load,
            )
            for speed, angle, k, mu in zip(found.speeds, ANGLES, kappa, friction, strict=True)
        ]
    )


def test_constants_are_those_of_their_own_temperature():
    found = scene(over(50, 20), over(0.2, 0.05))
    kappa = prediction.conduction(found).conductivity
    friction = prediction.friction_coefficient(found)
    rise = 0.9 * flash(found, kappa, friction)
    np.testing.assert_allclose(kappa, 50 - 30 * (50 + 0.75 * rise) / 1200, rtol=1e-6)
    np.testing.assert_allclose(friction, 0.2 - 0.15 * (50 + rise) / 1200, rtol=1e-6)
    assert kappa[0] < kappa[1]  # hottest along the grooves


def test_law_has_the_temperature_of_these_constants():
    found = scene(over(50, 20), over(0.2, 0.05))
    kappa = prediction.conduction(found).conductivity
    law = prediction.calibrated_predictions(found)["flash_temperature"]
    exact = flash(found, kappa, prediction.friction_coefficient(found))
    np.testing.assert_allclose(law, exact, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["mean", 0.9])
def test_flat_table_is_its_number(rule):
    flat, number = scene(over(30, 30 + 1e-9), heat_partition=rule), scene(heat_partition=rule)
    for name in ("flash_temperature", "heat_partition", "flash_gradient"):
        for predicted in (prediction.calibrated_predictions, prediction.predictions):
            np.testing.assert_allclose(predicted(flat)[name], predicted(number)[name], rtol=1e-9)
    np.testing.assert_allclose(
        prediction.heat_source(flat).conductivity, prediction.heat_source(number).conductivity
    )


def test_lay_of_one_has_the_constants_of_an_isotropic_face():
    plain = scene(over(50, 20), gamma=1)
    assert plain.headings is None
    assert prediction.conduction(plain).conductivity.shape == (1,)


@pytest.mark.slow
def test_share_is_of_its_own_direction():
    found = scene(over(50, 20), heat_partition="mean")
    together = prediction.calibrated_share(found)
    for k, angle in enumerate(ANGLES):
        alone = prediction.calibrated_share(found.towards(angle))
        np.testing.assert_allclose(together[k], alone[0], rtol=1e-9)


@pytest.mark.slow
def test_field_has_the_conductivity_of_its_direction():
    found = scene(over(50, 20))
    grid = Grid((32, 32), (1e-3, 1e-3)).stretched(3.0)
    pressure = np.maximum(np.random.default_rng(0).standard_normal(grid.shape), 0.0) * 1e8
    own = prediction.conduction(found).conductivity
    fields = [temperature(found, pressure, grid, Way(35.0, a, 2e-4), 1.0) for a in ANGLES]
    for field, kappa, angle in zip(fields, own, ANGLES, strict=True):
        number = scene(f"{kappa}", heat_partition=0.9)
        plain = temperature(number, pressure, grid, Way(35.0, angle, 2e-4), 1.0)
        np.testing.assert_allclose(field, plain, rtol=1e-9, atol=1e-9 * plain.max())
