"""The error of the theory of two sliding bodies, beside full contact, which is exact wave by wave."""

from math import isnan

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.tables import sliding_note, theory_dict
from roughsim.prediction.sliding import sliding_error

Q_MIN, Q_ROLL_OFF, Q_MAX = 6283.2, 12566.4, 50265.5
BODIES = {  # κ, ρ and c
    "steel": (30.0, 7900.0, 500.0),
    "hot steel": (50.0, 7900.0, 500.0),
    "light": (30.0, 1000.0, 450.0),  # κ of steel, another effusivity
    "titanium": (7.0, 4430.0, 564.0),
    "brass": (115.0, 8500.0, 380.0),
}
MODULUS = 1 / (2 * 0.91 / 200e9)
FRICTION, SPEEDS = 0.1, (1.0, 60.0)
PART = {
    0.0: (1.0, 0.0),
    0.2: (4.0, 1.0),
    0.5: (1.0, 1.0),
    0.8: (1.0, 4.0),
    1.0: (0.0, 1.0),
}  # resting, moving


def face(height):
    return {
        "rms_height": height,
        "hurst": 0.8,
        "q_min": Q_MIN,
        "q_roll_off": Q_ROLL_OFF,
        "q_max": Q_MAX,
    }


def scene_of(moving, resting, part, pressure, rms_height=2e-7, **sliding):
    """A scene of two bodies, of whose C(q) the `part` rides; a face without roughness of its own has next to none."""
    variances = np.array([1 - part, part]) + 1e-12
    rest, ride = rms_height * np.sqrt(variances)
    keys = ("conductivity", "density", "heat_capacity")
    solid = {"youngs_modulus": 200e9, "poisson_ratio": 0.3}
    given = {
        "surface": face(ride),
        "body": solid | dict(zip(keys, BODIES[moving], strict=True)),
        "counterface": face(rest) | solid | dict(zip(keys, BODIES[resting], strict=True)),
        "sliding": {
            "nominal_pressure": pressure,
            "friction_coefficient": FRICTION,
            "speed": list(SPEEDS),
        }
        | {"history": "sliding", "slid_distance": 5.0, "heat_partition": "mean"}
        | sliding,
    }
    return rs.load_scene(given)


def full_contact(scene, part, moving, resting, pressure):
    """T_flash in steady full contact: every wave shares its heat for itself, as κ₁q : κ₂λ₂ where its face rests.

    λ = √(q² − iq_x v/D) in the body that the wave slides over; κ₁λ₁ : κ₂q where its face moves. A Fourier sum over
    rings and directions.
    """
    q = np.geomspace(Q_MIN, Q_MAX, 401)
    angle = (np.arange(256) + 0.5) * np.pi / 256
    stress = (MODULUS * q / 2) ** 2 * scene.spectrum(q)  # |σ_q|²
    (k1, d1), (k2, d2) = ((k, k / (rho * c)) for k, rho, c in (BODIES[resting], BODIES[moving]))
    found = []
    for speed in SPEEDS:
        over_1, over_2 = (
            np.sqrt(q[:, None] ** 2 - 1j * q[:, None] * np.cos(angle) * speed / d) for d in (d1, d2)
        )
        rests = (1 / (k1 * q[:, None] + k2 * over_2)).real.mean(axis=1)
        rides = (1 / (k1 * over_1 + k2 * q[:, None])).real.mean(axis=1)
        waves = 2 * np.pi * q**2 * stress * ((1 - part) * rests + part * rides)
        found.append(FRICTION * speed / pressure * np.trapezoid(waves, np.log(q)))
    return np.array(found)


def full_pressure(scene):
    """Five standard deviations of the stress of full contact: A = 1."""
    q = np.geomspace(Q_MIN, Q_MAX, 2001)
    return 5 * np.sqrt(
        np.trapezoid(2 * np.pi * q**2 * (MODULUS * q / 2) ** 2 * scene.spectrum(q), np.log(q))
    )


def pairs_of_bodies():
    """Every pair with every part; what differs from others neither in its bodies nor its part alone is slow."""
    pairs = ("steel", "hot steel"), ("titanium", "brass"), ("brass", "titanium"), ("steel", "brass")
    for k, bodies in enumerate(pairs):
        for n, part in enumerate((0.0, 0.2, 0.5, 0.8, 1.0)):
            new = (k, n) in ((1, 1), (2, 2), (3, 4))
            yield pytest.param(*bodies, part, marks=[] if new else [pytest.mark.slow])


@pytest.mark.parametrize(("moving", "resting", "part"), [*pairs_of_bodies()])
def test_full_contact_is_in_the_band(moving, resting, part):
    pressure = full_pressure(scene_of(moving, resting, part, 1e8))
    scene = scene_of(moving, resting, part, pressure)
    exact = full_contact(scene, part, moving, resting, pressure)
    found = prediction.sliding_prediction(scene).flash_temperature
    assert sliding_error(scene) >= 0.06
    np.testing.assert_allclose(found, exact, rtol=0.06)


@pytest.mark.parametrize("part", [0.0, pytest.param(0.3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("moving", "resting"), [("steel", "brass"), ("titanium", "brass")])
def test_full_contact_does_not_depend_on_the_background(moving, resting, part):
    # five times the pressure of full contact: 0.1 K of T_flash at 1 m/s beside a background of thousands
    pressure = 5 * full_pressure(scene_of(moving, resting, part, 1e8))
    scene = scene_of(moving, resting, part, pressure, slid_distance=50.0)
    found = prediction.sliding_prediction(scene).flash_temperature
    np.testing.assert_allclose(
        found, full_contact(scene, part, moving, resting, pressure), rtol=0.04
    )


def test_the_error_is_in_json_and_notes():
    scene = scene_of("titanium", "brass", 0.8, 3e9)
    assert theory_dict(scene)["calibrated"]["sliding"]["error"] == sliding_error(scene)
    assert "within 6 % of slides" in sliding_note(scene)


def test_outside_the_law_no_error_is_known():
    assert isnan(sliding_error(scene_of("steel", "steel", 0.5, 1e3)))
