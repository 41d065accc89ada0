"""What the camera of a scene sees by theory, and by sums over modes: exact in full contact, and alike elsewhere."""

from dataclasses import replace
from math import inf, pi, sqrt

import numpy as np
import pytest
from small_scene import CAPPED

from roughsim import prediction
from roughsim.estimate.fields import hottest_seen
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.planning.limits import judge
from roughsim.prediction.camera import beyond_cell, camera_of, error_of_law, seen_by, views
from roughsim.results.theories import theory_columns
from roughsim.scene import parse_scene
from theory import camera, flash, lay


def scene(camera="[camera]", **changes):
    text = CAPPED.replace("[theory]", f"{camera}\n[theory]")
    for old, new in changes.items():
        text = text.replace(f"{old} =", f"{new}\n#")
    return parse_scene(text)


def test_a_sharp_camera_sees_the_whole_temperature():
    found = scene()
    law = prediction.calibrated(found).stress_spectrum
    heat = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30 / (7900 * 500)}
    exact = flash.rms_temperature(found.speeds, stress_spectrum=law, nominal_pressure=9e7, **heat)
    np.testing.assert_allclose(
        prediction.calibrated_predictions(found)["seen_rms"], exact, rtol=1e-6
    )


def test_views_know_how_far_each_speed_slid():
    camera = '[camera]\nbehind = "20 um"\nresolution = "4 um"'
    slid = views(scene(camera, speed='duration = "1 ms"\nspeed = [0.1, 35]'))
    assert [one.slid_distance for one in slid] == pytest.approx([1e-4, 35e-3])
    assert slid[0].behind == 2e-5
    assert slid[0].resolution == 4e-6
    assert slid[0].contact_length == inf
    round_one = views(scene(camera, speed='contact_radius = "3 mm"\nspeed = [0.1, 35]'))
    assert [one.slid_distance for one in round_one] == [inf, inf]
    assert round_one[0].contact_length == 6e-3
    assert camera_of(scene("")) is None


def test_waves_of_full_contact_have_an_exact_picture():
    # of two waves of the stress, q̇/(κq) at a vanishing speed, blurred by e^(−q²b²/2); the correlation is of J₀
    found = scene('[camera]\nresolution = "100 um"', speed="speed = [1e-9, 1e-8]")
    q, variance, b = np.array([1e4, 3e4]), np.array([4e12, 1e12]), 1e-4 / sqrt(8 * np.log(2))
    heat = 0.11 * np.array([1e-9, 1e-8]) / 30.0
    exact = heat * sqrt(np.sum(variance / q**2 * np.exp(-((q * b) ** 2))))
    np.testing.assert_allclose(seen_by(found, "seen_rms", q, variance, 1e-3), exact, rtol=1e-9)
    width = seen_by(found, "seen_width", q[:1], variance[:1], 1e-3)
    np.testing.assert_allclose(width, 2 * 1.5211444 / 1e4, rtol=1e-4)


def test_modes_and_integrals_show_alike_pictures():
    found = scene(numerics="numerics", speed="speed = [0.1, 35]")
    spectrum = prediction.smoothed_spectrum(found)
    from roughsim.grid import Grid

    length = 16 * pi / 6350
    sums = prediction.mode_sums(found, spectrum, Grid((512, 512), (length, length)))
    whole = prediction.predictions(found)
    for name, error in (("seen_rms", 0.02), ("seen_width", 0.03)):
        np.testing.assert_allclose(sums[name], whole[name], rtol=error)


def test_a_picture_without_a_theory_is_unknown():
    skin = "skin = { thickness = 1e-6, conductivity = 3 }\ndensity"
    layered = CAPPED.replace("density", skin, 1).replace("speed =", "duration = 1e-3\nspeed =")
    found = parse_scene(layered.replace("[theory]", "[camera]\n[theory]"))
    assert np.isnan(prediction.predictions(found)["seen_rms"][1:]).all()
    assert np.isnan(prediction.predictions(scene())["seen_99"]).all()


def test_a_line_close_behind_a_slow_contact_warns():
    near = scene('[camera]\nbehind = "20 um"', speed="speed = [1, 35]")
    words = [remark.text for remark in judge(near).remarks if "behind/D" in remark.text]
    assert words
    assert "v·behind/D = 2.63 at 1 m/s, below 5" in words[0]
    far = scene('[camera]\nbehind = "200 um"', speed="speed = [1, 35]")
    assert not [remark for remark in judge(far).remarks if "behind/D" in remark.text]


def test_waves_longer_than_the_cell_are_an_error_of_its_picture():
    found = scene(speed="speed = [0.1, 35]")
    assert prediction.beyond_cell(found, 4e-3).max() < 0.02
    # without any wave of the law below 4 mm only a blurred picture misses the rest
    blurred = scene('[camera]\nresolution = "0.3 mm"', speed="speed = [0.1, 35]")
    assert (prediction.beyond_cell(blurred, 2e-3) > 0.02).all()
    assert np.isnan(
        prediction.beyond_cell(scene('[camera]\nresolution = "0.98 mm"'), 1e-3)[1:]
    ).all()


@pytest.mark.usefixtures("few_fields")
def test_one_percent_by_the_law_has_the_errors_of_quantiles():
    found = scene()
    hottest = hottest_seen(found)
    flash_of_law = prediction.calibrated_predictions(found)["flash_temperature"]
    law, form = hottest.budget["law"], hottest.budget["form"]
    # the band of T_flash in contact that yields, and .06 to .24 T_flash by the form of the drawn contacts
    np.testing.assert_allclose(law, 0.07 * hottest.mean, rtol=1e-12)
    assert ((form >= 0.06 * flash_of_law) & (form <= 0.24 * flash_of_law)).all()
    slow, *_, fast = (form[1:] / flash_of_law[1:]).tolist()  # the first is at rest
    assert slow >= fast
    assert (hottest.total_error >= np.hypot(law, form)).all()


@pytest.mark.parametrize("name", ["seen_rms", "seen_99", "seen_width"])
def test_a_blur_over_all_of_the_cell_is_unknown(name):
    found = scene('[camera]\nresolution = "0.9 mm"', speed="speed = [1, 35]")

    def value(side):
        numbers = {"seen_99": np.full((1, 2), 30.0)}
        q, stress = np.geomspace(1e3, 1e5, 400), np.ones((1, 400))
        sample = Sample(1e5, 8.0, np.zeros(1, int), numbers, q, stress, side * np.sqrt(0.5))
        return prediction.of_level(found, OBSERVABLES[name], sample)

    assert np.isnan(value(0.89e-3)).all()
    assert name == "seen_width" or (value(0.91e-3) > 0.0).all()
    assert not any("side of the cell" in one.text for one in judge(found).remarks)
    short = judge(replace(found, numerics=replace(found.numerics, lengths=(0.5e-3, 0.5e-3))))
    words = " ".join(one.text for one in short.remarks)
    assert "camera.resolution = 0.0009 m is above the side of the cell, 0.0005 m" in words


def test_pictures_by_the_law_have_their_band_where_it_was_compared():
    found = scene(speed="speed = [1, 35]")
    law = theory_columns(found)["calibrated"]
    for seen in (law("seen_rms"), law("seen_width")):
        np.testing.assert_allclose(seen.budget["law"], 0.05 * seen.mean, rtol=1e-12)
    # v·behind/D = 2.6 at 1 m/s: heat along sliding, which the line leaves out, is not in the band
    near = scene('[camera]\nbehind = "20 um"', speed="speed = [1, 35]")
    part = theory_columns(near)["calibrated"]("seen_rms").budget["law"]
    assert np.isnan(part).tolist() == [True, False]


def test_law_of_a_lay_sees_each_direction():
    text = CAPPED.replace("lengths = [2e-3, 2e-3]\n", "").replace("hurst", "lay = 3\nhurst", 1)
    looking = '[camera]\nresolution = "20 um"\n[theory]'
    found = parse_scene(text.replace("[theory]", looking).replace("[0, 0.1, 35]", "[35]"))
    stress = lay.stress_of_lay(
        found.spectrum,
        3.0,
        effective_modulus=found.effective_modulus,
        nominal_pressure=9e7,
        penetration_hardness=1e9,
    )
    heat = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30 / (7900 * 500)}
    arguments = {"stress": stress, "view": camera.View(2e-5), "nominal_pressure": 9e7, **heat}
    law = prediction.calibrated_predictions(found)
    for name, band in (("seen_rms", 0.06590), ("seen_width", 0.0994)):
        formula = getattr(camera, name)
        exact = [formula(35.0, direction=angle, **arguments) for angle in (0.0, pi / 2)]
        np.testing.assert_allclose(law[name][::2], exact, rtol=1e-9)
        np.testing.assert_allclose(error_of_law(found, name), band, rtol=1e-3)
    assert hottest_seen(found) is None
    # waves longer than the cell are a small part of the picture, and longer than the finest none of it
    beyond = beyond_cell(found, 2e-3)
    assert (beyond < 0.1).all()
    assert (beyond >= 0.0).all()


@pytest.mark.slow
def test_law_of_a_lay_knows_no_picture_of_a_small_cell():
    text = CAPPED.replace("lengths = [2e-3, 2e-3]\n", "").replace("hurst", "lay = 3\nhurst", 1)
    looking = '[camera]\nresolution = "20 um"\n[theory]'
    found = parse_scene(text.replace("[theory]", looking).replace("[0, 0.1, 35]", "[35]"))
    assert np.isnan(beyond_cell(found, 1e-4)).all()
