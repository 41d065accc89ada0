"""The theory of the temperature over two faces that slide, for a scene: rows beside the column sliding."""

import json
from itertools import product

import numpy as np
import pytest
from slide_cases import sliding_scene
from table_cases import by_label

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.tables import theory_dict
from roughsim.estimate import fields
from roughsim.estimate.reactions import BOLTZMANN
from roughsim.observables.distribution import LEVELS
from theory import two_bodies

pytestmark = pytest.mark.usefixtures("few_fields")
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
SHORT = ("q_max = 2e5", "q_max = 4e4")  # all of its waves are drawn
RESTING = 'rms_height = "0.9 um"\nhurst = 0.8\nq_min = 6350\nq_roll_off = 2e4\nq_max = 4e4\n'
RESTING += "conductivity = 30\ndensity = 7900\nheat_capacity = 500\nyoungs_modulus = 200e9\npoisson_ratio = 0.3\n"


def asking(history=FAR, *changes):
    return sliding_scene(
        f'{history}\nbackground_temperature = "600 K"', ("[numerics]", ASKED), SHORT, *changes
    )


def quantiles(scene):
    return fields.quantiles(scene, sliding=True)


def reactions(scene):
    return by_label(fields.asked(scene, sliding=True))


@pytest.fixture(scope="module")
def scene():
    return asking()


def flash_over_the_last_half(scene):
    distances = np.linspace(0.2e-3, 0.4e-3, 41)
    arguments = SOLID | BODY | {"friction_coefficient": 0.11, "slid_distance": distances}
    flash = [
        two_bodies.sliding_temperatures(v, scene.spectrum, **arguments).flash_temperature
        for v in (1.0, 35.0)
    ]
    return np.trapezoid(flash, distances, axis=1) / 0.2e-3


def test_quantiles_are_those_of_drawn_faces_over_the_last_half_of_the_slide(scene):
    numbers = prediction.slid_fields(scene).numbers
    flash = flash_over_the_last_half(scene)
    found = quantiles(scene)
    for name in (f"temperature_quantile_{of}{level}" for of in ("", "area_") for level in LEVELS):
        drawn = numbers[f"sliding_{name}"]
        ratio = drawn.mean(axis=0) / numbers["sliding_flash_temperature"].mean(axis=0)
        assert found[name].mean == pytest.approx(ratio * flash, rel=1e-3)
        assert found[name].n == len(drawn) == 6
        of_law = prediction.sliding_error(scene) * found[name].mean
        assert found[name].budget["law"] == pytest.approx(of_law, rel=1e-9)
    assert prediction.sliding_error(scene) > 0.0
    assert set(found[name].budget) == {"statistical", "slide", "form", "law"}


def test_reactions_are_those_of_the_moving_body_with_its_own_share_of_the_heat(scene):
    found = reactions(scene)
    flash, hot = flash_over_the_last_half(scene), quantiles(scene)
    kelvin = found["activation_temperature", 1.0, None].mean
    assert (kelvin > 600.0 + flash).all()
    assert (kelvin < 600.0 + hot["temperature_quantile_99"].mean).all()
    law = prediction.calibrated(scene).stress_spectrum
    rate = law.contact_fraction * 1e13 * np.exp(-EV / (BOLTZMANN * kelvin))
    assert found["reaction_rate", 1.0, None].mean == pytest.approx(rate, rel=1e-6)
    assert found["reaction_rate", 1.0, None].unknown == ()
    levels = np.array([*LEVELS.values()])
    for k in range(2):
        heat = [hot[f"temperature_quantile_{name}"].mean[k] for name in LEVELS]
        expected = 1.0 - np.interp(100.0, heat, levels, left=0.0, right=1.0)
        assert found["heat_share_above", None, 700.0].mean[k] == pytest.approx(expected, abs=0.03)


def test_with_a_duration_the_background_of_the_slide_is_added_and_each_speed_slides_its_own_way():
    scene = asking(
        'history = "sliding"\nduration = "10 us"',
        ("speed = [1, 35]", "speed = [10, 35]"),
        ('heat_above = "700 K"', 'heat_above = ["650 K", "750 K", "1000 K"]'),
    )
    slid = prediction.sliding_prediction(scene)
    warm = slid.contact_temperature - slid.flash_temperature
    assert (warm > 3.0).all()
    found, hot = reactions(scene), quantiles(scene)
    kelvin = found["activation_temperature", 1.0, None].mean
    assert (kelvin > 600.0 + slid.contact_temperature).all()
    # the heat above a temperature is that above the quantile with the background added
    levels, within = np.array([*LEVELS.values()]), 0
    for k, above in product(range(2), (650.0, 750.0, 1000.0)):
        heat = [hot[f"temperature_quantile_{name}"].mean[k] for name in LEVELS]
        excess = above - 600.0 - warm[k]
        if heat[0] < excess < heat[-1]:
            share = found["heat_share_above", None, above].mean[k]
            assert share == pytest.approx(1.0 - np.interp(excess, heat, levels), abs=0.03)
            within += 1
    assert within > 1
    numbers = prediction.slid_fields(scene).numbers
    alone = asking('history = "sliding"\nduration = "10 us"', ("speed = [1, 35]", "speed = 35"))
    other = prediction.slid_fields(alone).numbers
    name = "sliding_temperature_quantile_90"
    # the fast one alone slides on a coarser grid
    ratios = [
        one[name].mean(axis=0) / one["flash_temperature"].mean(axis=0) for one in (numbers, other)
    ]
    assert ratios[0][-1] == pytest.approx(ratios[1][-1], rel=0.05)


@pytest.mark.slow
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
            assert row["sliding_calibrated"] == pytest.approx(estimate.mean[k], rel=1e-12)
            assert row["sliding_calibrated"] != row["calibrated"]
    for labels, estimate in reactions(scene).items():
        for k, speed in enumerate((1.0, 35.0)):
            row = found[*labels, speed]
            assert row["sliding_calibrated"] == pytest.approx(float(estimate.mean[k]), rel=1e-12)
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
    assert reactions(silent) == {}


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
    assert reactions(scene) == {}
