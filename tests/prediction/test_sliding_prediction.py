"""The theory of two bodies for a scene: the column calibrated beside the column sliding."""

import json

import numpy as np
import pytest
from slide_cases import MILLIMETRE, sliding_scene
from typer.testing import CliRunner

from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison.tables import theory_dict, theory_table
from theory import two_bodies

DIFFUSIVITY = 30 / (7900 * 500)
STEEL = {
    "effective_modulus": 1.0 / (2 * 0.91 / 200e9),
    "nominal_pressure": 9e7,
    "penetration_hardness": 1e9,
    "friction_coefficient": 0.11,
    "conductivity": 30.0,
    "diffusivity": DIFFUSIVITY,
}


def by_the_theory(scene, speed, distance, **changes):
    return two_bodies.sliding_temperatures(
        speed, scene.spectrum, slid_distance=distance, **STEEL | changes
    )


def last_half(end):
    """Distances in the last half and at the end, m, with their weights in the mean over that half."""
    points, weights = np.polynomial.legendre.leggauss(7)
    return end * np.append(0.75 + 0.25 * points, 1.0), np.append(weights / 2.0, 0.0)


def test_temperatures_are_means_over_the_last_half_of_the_distance():
    scene = sliding_scene()
    slid = prediction.sliding_prediction(scene)
    distances, weights = last_half(1e-3)
    for k, speed in enumerate(scene.speeds):
        expected = by_the_theory(scene, speed, distances)
        mean = weights @ expected.flash_temperature
        assert slid.flash_temperature[k] == pytest.approx(mean, rel=1e-4)
        at_the_end = float(expected.background[-1])
        assert slid.contact_temperature[k] == pytest.approx(mean + at_the_end, rel=1e-4)
    assert slid.heat_partition == pytest.approx([0.5, 0.5], abs=1e-12)


def test_with_a_duration_each_speed_slides_its_own_distance():
    scene = sliding_scene(
        'history = "sliding"\nduration = "20 us"', ("speed = [1, 35]", "speed = [10, 35]")
    )
    slid = prediction.sliding_prediction(scene)
    assert slid.slid_distance == pytest.approx([0.2e-3, 0.7e-3])
    ends = [slid.contact_temperature[k] - slid.flash_temperature[k] for k in (0, 1)]
    expected = [by_the_theory(scene, v, 20e-6 * v).background for v in (10.0, 35.0)]
    assert ends == pytest.approx(expected, rel=1e-9)


def test_the_roughness_of_the_surface_rides_and_that_of_the_counterface_rests():
    # the same shape of C(q), a quarter of the variance of the heights: f = 1/(1 + 1/4) rides
    resting = 'rms_height = "0.45 um"\nhurst = 0.8\nq_min = 6350\nq_roll_off = 2e4\nq_max = 2e5\n'
    resting += "conductivity = 300\ndensity = 8900\nheat_capacity = 400\nyoungs_modulus = 200e9\npoisson_ratio = 0.3\n"
    scene = sliding_scene(MILLIMETRE, ('like = "body"', resting))
    slid = prediction.sliding_prediction(scene)
    bodies = {
        "resting_conductivity": 300.0,
        "resting_diffusivity": 300 / (8900 * 400),
        "moving_roughness": 0.8,
    }
    distances, weights = last_half(1e-3)
    expected = by_the_theory(scene, 35.0, distances, **bodies)
    assert slid.heat_partition[1] == pytest.approx(weights @ expected.moving_share, rel=1e-4)
    assert slid.flash_temperature[1] == pytest.approx(
        weights @ expected.flash_temperature, rel=1e-4
    )


def test_where_the_law_does_not_hold_there_is_none():
    scene = sliding_scene(MILLIMETRE, ('nominal_pressure = "90 MPa"', 'nominal_pressure = "1 MPa"'))
    assert prediction.sliding_prediction(scene) is None
    assert theory_dict(scene)["calibrated"]["sliding"] is None


@pytest.mark.slow
def test_theory_prints_both_bodies_in_motion():
    scene = sliding_scene()
    slid = prediction.sliding_prediction(scene)
    told = json.loads(json.dumps(theory_dict(scene)))["calibrated"]["sliding"]
    assert told["flash_temperature"] == pytest.approx(slid.flash_temperature)
    assert told["heat_partition"] == pytest.approx([0.5, 0.5])
    table = theory_table(scene)
    titles = [column.title for column in table.columns]
    at = titles.index("T_flash sliding, K")
    assert table.cells(at)[1] == f"{slid.flash_temperature[1]:.4g}"
    assert any(
        note.startswith("sliding, calibrated: two bodies that slide") for note in table.notes
    )
    result = CliRunner().invoke(app, ["theory", "demo", "--json"])
    assert "sliding" not in json.loads(result.stdout)["calibrated"]


def test_a_slide_is_continued_by_the_theory_at_both_distances():
    # unlike bodies, the moving one smooth: all three numbers change with the distance
    resting = 'conductivity = 10\ndensity = 7900\nheat_capacity = 500\nyoungs_modulus = "200 GPa"\npoisson_ratio = 0.3'
    scene = sliding_scene('history = "sliding"\nslid_distance = "8 mm"', ('like = "body"', resting))
    found = prediction.sliding_continuation(scene, 2e-3)
    bodies = {
        "resting_conductivity": 10.0,
        "resting_diffusivity": 10 / (7900 * 500),
        "moving_roughness": 0.0,
    }
    for k, speed in enumerate(scene.speeds):
        means = []
        for end in (2e-3, 8e-3):
            late, weights = last_half(end)
            slid = by_the_theory(scene, speed, late, **bodies)
            averages = weights @ np.transpose([slid.flash_temperature, slid.moving_share])
            means.append([*averages, slid.background[-1]])
        expected = np.divide(means[1], means[0])
        assert (np.abs(expected - 1.0) > 3e-4).all()
        assert [values[k] for values in found[:3]] == pytest.approx(expected, rel=1e-4)
    assert found.error == pytest.approx([0.025, 0.025])


def test_twins_that_are_equally_rough_warm_as_the_root_of_the_distance():
    found = prediction.sliding_continuation(
        sliding_scene('history = "sliding"\nslid_distance = "18 mm"'), 2e-3
    )
    assert found.background == pytest.approx([3.0, 3.0], rel=1e-6)
    assert found.heat_partition == pytest.approx([1.0, 1.0], rel=1e-6)
    assert (found.flash_temperature > 1.0).all()  # summits of the moving body stay hot


def test_a_speed_that_is_followed_to_its_end_is_not_continued():
    scene = sliding_scene(
        'history = "sliding"\nduration = "20 us"', ("speed = [1, 35]", "speed = [10, 200]")
    )
    found = prediction.sliding_continuation(scene, 1e-3)  # of 0.2 and 4 mm
    assert [values[0] for values in found] == [1.0, 1.0, 1.0, 0.0]
    assert (found.flash_temperature[1], found.error[1]) != (1.0, 0.0)
    for followed in (None, 4e-3):
        assert (np.array(prediction.sliding_continuation(scene, followed)[:3]) == 1.0).all()


def test_without_a_theory_a_slide_that_ends_sooner_is_refused():
    full = sliding_scene(
        'history = "sliding"\nslid_distance = "8 mm"',
        ('nominal_pressure = "90 MPa"', 'nominal_pressure = "1 MPa"'),
    )
    assert prediction.sliding_prediction(full) is None
    with pytest.raises(
        ValueError,
        match=r"^followed = 0\.002 m is less than the slid distance of 0\.008 m, and .*leave",
    ):
        prediction.sliding_continuation(full, 2e-3)
