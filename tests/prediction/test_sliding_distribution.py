"""The theory of the temperature over two faces that slide, for a scene: rows beside the column sliding."""

import json
from functools import cache

import numpy as np
import pytest
from slide_cases import sliding_scene

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.tables import theory_dict
from roughsim.observables.distribution import LEVELS
from theory import clipped, two_bodies

EV = 1.602176634e-19
DIFFUSIVITY = 30 / (7900 * 500)
SOLID = {
    "effective_modulus": 1.0 / (2 * 0.91 / 200e9),
    "nominal_pressure": 9e7,
    "penetration_hardness": 1e9,
}
BODY = {"conductivity": 30.0, "diffusivity": DIFFUSIVITY}
ASKED = '[reaction]\nactivation_energy = ["1 eV"]\nprefactor = "1e13 1/s"\n[observables]\nheat_above = "700 K"\n[numerics]'
FAR = 'history = "sliding"\nslid_distance = "0.4 mm"'
SHORT = ("q_max = 2e5", "q_max = 5e4")  # all of its waves are drawn
RESTING = 'rms_height = "0.9 um"\nhurst = 0.8\nq_min = 6350\nq_roll_off = 2e4\nq_max = 5e4\n'
RESTING += "conductivity = 30\ndensity = 7900\nheat_capacity = 500\nyoungs_modulus = 200e9\npoisson_ratio = 0.3\n"


def asking(history=FAR, *changes):
    return sliding_scene(
        f'{history}\nbackground_temperature = "600 K"', ("[numerics]", ASKED), SHORT, *changes
    )


@cache
def fields(scene):
    return prediction.sliding_distributions(scene)


def quantiles(scene):
    return prediction.quantiles_of(scene, fields(scene))


def reactions(scene):
    return prediction.sliding_asked_predictions(scene, fields(scene))


@pytest.fixture(scope="module")
def scene():
    return asking()


@pytest.fixture(scope="module")
def drawn(scene):
    distances = np.linspace(0.2e-3, 0.4e-3, 41)
    arguments = SOLID | BODY | {"friction_coefficient": 0.11, "slid_distance": distances}
    flash = [
        two_bodies.sliding_temperatures(v, scene.spectrum, **arguments).flash_temperature
        for v in (1.0, 35.0)
    ]
    mean = np.trapezoid(flash, distances, axis=1) / 0.2e-3
    return clipped.sliding_temperature_distribution(
        [1.0, 35.0], scene.spectrum, **SOLID, **BODY, slid_distance=0.4e-3, flash_temperature=mean
    )


def test_quantiles_are_those_of_drawn_faces_over_the_last_half_of_the_slide(scene, drawn):
    found = quantiles(scene)
    for weight, of in (("heat", ""), ("area", "area_")):
        expected = drawn.quantiles([*LEVELS.values()], by=weight)
        for k, name in enumerate(LEVELS):
            estimate = found[f"temperature_quantile_{of}{name}"]
            assert estimate.value == pytest.approx(expected.value[k], rel=1e-4)
            assert estimate.standard_error == pytest.approx(expected.standard_error[k], rel=1e-4)


def test_reactions_are_those_of_the_moving_body_with_its_own_share_of_the_heat(scene, drawn):
    asked = {each.key: each.estimate.value for each in reactions(scene)}
    rate = drawn.reaction_rate([EV], prefactor=1e13, background_temperature=600.0).value[0]
    assert asked["reaction_rate", 1.0, None] == pytest.approx(rate, rel=1e-3)
    kelvin = drawn.activation_temperature([EV], background_temperature=600.0).value[0]
    assert asked["activation_temperature", 1.0, None] == pytest.approx(kelvin, rel=1e-4)
    assert asked["heat_share_above", None, 700.0] == pytest.approx(
        drawn.share_above(100.0).value, rel=1e-2, abs=1e-9
    )
    assert 0.5 < asked["heat_share_above", None, 700.0][1] < 1.0


def test_with_a_duration_the_background_of_the_slide_is_added_and_each_speed_slides_its_own_way():
    scene = asking(
        'history = "sliding"\nduration = "10 us"', ("speed = [1, 35]", "speed = [10, 35]")
    )
    slid = prediction.sliding_prediction(scene)
    warm = slid.contact_temperature - slid.flash_temperature
    assert (warm > 3.0).all()
    asked = {each.key: each.estimate.value for each in reactions(scene)}
    for k, speed in enumerate((10.0, 35.0)):
        fields = clipped.sliding_temperature_distribution(
            speed,
            scene.spectrum,
            **SOLID,
            **BODY,
            slid_distance=10e-6 * speed,
            flash_temperature=slid.flash_temperature[k],
        )
        rate = fields.reaction_rate(
            [EV], prefactor=1e13, background_temperature=600.0 + warm[k]
        ).value[0]
        assert asked["reaction_rate", 1.0, None][k] == pytest.approx(rate[0], rel=1e-9)


def test_rows_of_a_comparison_have_it_beside_the_slides(tmp_path, scene):
    run = rs.run(scene, tmp_path / "run", max_realizations=2)
    rows = json.loads(json.dumps(rs.compare(run).to_dict()))["rows"]
    found = {
        (row["observable"], row.get("energy"), row.get("temperature"), row["speed"]): row
        for row in rows
    }
    for name, estimate in quantiles(scene).items():
        for k, speed in enumerate((1.0, 35.0)):
            row = found[name, None, None, speed]
            assert row["sliding_calibrated"] == pytest.approx(estimate.value[k], rel=1e-12)
            assert row["sliding_calibrated"] != row["calibrated"]
    for asked in reactions(scene):
        for k, speed in enumerate((1.0, 35.0)):
            row = found[asked.observable, asked.energy, asked.temperature, speed]
            assert row["sliding_calibrated"] == pytest.approx(
                float(asked.estimate.value[k]), rel=1e-12
            )
    # 32² points and two slides of two
    row = found["temperature_quantile_50", None, None, 35.0]
    assert row["sliding_calibrated"] == pytest.approx(row["sliding"]["mean"], rel=0.3)
    quiet = theory_dict(scene)["calibrated"]["sliding"]
    assert {*quiet} == {
        "slid_distance",
        "flash_temperature",
        "heat_partition",
        "contact_temperature",
        "error",
    }


def test_a_scene_that_does_not_ask_has_none():
    silent = sliding_scene(FAR)
    assert quantiles(silent) == {}
    assert reactions(silent) == []


@pytest.mark.parametrize(
    "change",
    [
        ("[body]\n", '[body]\nheat_depth = "1 um"\n'),
        ('like = "body"', f'{RESTING}heat_depth = "1 um"\n'),
        ('nominal_pressure = "90 MPa"', 'nominal_pressure = "1 MPa"'),
    ],
)
def test_without_bare_bodies_in_the_range_of_the_law_there_is_none(change):
    scene = asking(FAR, change)
    assert quantiles(scene) == {}
    assert reactions(scene) == []
