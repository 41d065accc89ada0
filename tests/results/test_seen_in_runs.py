"""What the camera of a scene sees in its runs: numbers of members, means with their errors, and pictures."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import erf, ndtr
from small_scene import CAPPED

import roughsim as rs
from roughsim.scene import parse_scene

pytestmark = pytest.mark.usefixtures("few_fields")
SEEN = ("seen_rms", "seen_99", "seen_width")


def scene(camera):
    text = CAPPED.replace("[theory]", f"{camera}\n[theory]").replace(
        "speed = [0, 0.1, 35]", "speed = [0, 35]"
    )
    return parse_scene(text)


@pytest.fixture(scope="module")
def sharp(tmp_path_factory):
    found = scene("[camera]").with_("numerics.keep_fields", 1)
    return rs.run(found, tmp_path_factory.mktemp("sharp") / "run", max_realizations=3, workers=1)


def test_a_sharp_camera_sees_the_temperature(sharp):
    level = sharp.picture("capped")
    hot, seen = (sharp.field(level, 0, name, speed=35.0) for name in ("temperature", "seen"))
    np.testing.assert_allclose(seen, hot, atol=1e-5 * hot.max())
    back = sharp.field(level, 0, "seen", speed=-35.0)
    np.testing.assert_allclose(
        back, sharp.field(level, 0, "temperature", speed=-35.0), atol=1e-5 * hot.max()
    )


def test_members_store_what_one_percent_of_the_picture_exceeds(sharp):
    # by the field of the run, whose share of the heat cancels, and normally distributed older heat; its rms is replaced
    # by that over all directions
    level = sharp.picture("capped")
    (field,) = [sharp.field(level, 0, "temperature", speed=35.0)]
    sample = sharp.members.sample(level)
    q, heat = sample.wavenumber, 0.11 * 35.0 / 30.0
    drift = 35.0 * 7900 * 500 / 30.0
    turn = (np.arange(1000) + 0.5) / 1000 * np.pi / 2
    cosine = np.sin(turn) ** 3  # towards q_x = 0
    weight = 3 * np.sin(turn) ** 2 * np.cos(turn) / np.sqrt(1 - cosine**2) / 1000
    waves = [k**2 - 1j * k * drift * cosine for k in q]
    whole = sample.spectrum[0] @ [weight @ (1 / np.abs(wave)) for wave in waves]
    # half of the cell of 2 mm
    grown = [np.abs(erf(np.sqrt(wave * 1e-3 / drift))) ** 2 / np.abs(wave) for wave in waves]
    older = whole / (sample.spectrum[0] @ [weight @ one for one in grown]) - 1
    spread = field.std() * np.sqrt(older)

    def excess(value):
        return ndtr((field - value) / spread).mean() - 0.01

    shape = brentq(excess, 0.0, 9 * field.std()) / np.hypot(field.std(), spread)
    rms = heat * np.sqrt(whole)
    assert sample.numbers["seen_99"][0, 1] == pytest.approx(shape * rms, rel=2e-3)
    assert sample.numbers["seen_99"][0, 0] < 1e-100


def test_every_column_has_the_picture_with_its_errors(sharp):
    for column in ("smoothed", "capped"):
        for name in SEEN:
            found = sharp.estimate(name, column)
            assert found.mean[1] > 0.0
            assert found.standard_error[1] > 0.0
    assert sharp.estimate("seen_rms").mean[0] == 0.0
    assert sharp.estimate("seen_99").mean[1] > 2 * sharp.estimate("seen_rms").mean[1]
    law = rs.theory(sharp.scene).to_dict()["calibrated"]["seen_rms"]["value"][1]
    assert sharp.estimate("seen_rms").mean[1] == pytest.approx(law, rel=0.1)


def test_a_run_without_a_camera_says_what_to_add(tmp_path):
    plain = rs.run(scene("").with_("numerics.keep_fields", 1), tmp_path / "run", max_realizations=1)
    assert not {*SEEN} & {*plain.observables}
    with pytest.raises(ValueError, match="has no camera; add a section"):
        rs.plot(plain, "seen", tmp_path / "x.png")
    with pytest.raises(ValueError, match="has no camera; add a section"):
        rs.plot(plain, "seen_rms", tmp_path / "x.png")
    with pytest.raises(ValueError, match="whose scene lacks a section"):
        plain.estimate("seen_99")


@pytest.mark.slow
def test_the_picture_is_drawn(sharp, tmp_path):
    assert rs.plot(sharp, "seen", tmp_path / "seen.png").stat().st_size > 1e4
    assert rs.plot(sharp, "seen_width", tmp_path / "width.png").stat().st_size > 1e4
    assert "camera at 35 m/s (capped, calibrated): seen_rms" in str(rs.compare(sharp))
