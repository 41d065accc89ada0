"""The cell: its sides, and what doubling it changes."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import roughsim as rs
from roughsim.estimate import cell_size
from roughsim.scene.numerics import Level, Numerics

WAVE = 2 * pi / 6350


@pytest.fixture(scope="module")
def steel():
    return rs.load_scene("steel-1.2GPa")


def flat(scene, q_min=5e4):
    return replace(scene, surface=replace(scene.surface, roll_off_exponent=0.0, q_min=q_min))


def test_a_cell_holds_four_longest_waves(steel):
    lengths, why = cell_size.choose_lengths(steel)
    assert lengths == pytest.approx((4 * WAVE, 4 * WAVE))
    assert "4 longest waves" in why
    assert "a larger cell changes T_flash by less than 0.4 %" in why


@pytest.mark.parametrize(("q_min", "waves"), [(5e4, 8), (3.5e4, 4 * 9.4 / 3.5), (1e3, 16)])
def test_a_plateau_is_given_eight_to_sixteen_waves_of_its_end(steel, q_min, waves):
    lengths, why = cell_size.choose_lengths(flat(steel, q_min))
    assert lengths[0] == pytest.approx(waves * 2 * pi / 9.4e4)
    assert "C(q) is flat below q_roll_off" in why


def test_one_face_without_a_plateau_counts_longest_waves(steel):
    scene = flat(steel)
    keys = ("rms_height", "hurst", "q_min", "q_roll_off", "q_max", "roll_off_exponent")
    face = {key: getattr(scene.surface, key) for key in keys}
    hard = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "like": None}
    for exponent, waves in ((1.5, 4 * 2 * pi / 5e4), (0.0, 8 * 2 * pi / 9.4e4)):
        other = replace(scene.counterface, **face | hard | {"roll_off_exponent": exponent})
        assert cell_size.choose_lengths(replace(scene, counterface=other))[0][0] == pytest.approx(waves)


def test_the_size_error_is_of_the_shorter_side_and_grows_with_its_square_below_what_is_needed(steel):
    for scene, enough in ((steel, 4 * WAVE), (flat(steel), 8 * 2 * pi / 9.4e4)):
        assert cell_size.size_error(scene, (enough, enough)) == pytest.approx(0.004)
        assert cell_size.size_error(scene, (enough / 2, 3 * enough)) == pytest.approx(0.016)
        assert cell_size.size_error(scene, (4 * enough, 2 * enough)) == pytest.approx(0.002)
        assert np.isnan(cell_size.size_error(scene, (enough, enough), "correlation_radius_0"))


# two faces in cells of 4, 8 and, as (4·T₈ − T₄)/3, very many longest waves: T_flash at 35 m/s, K
DOUBLED = {
    (1e6, "smoothed"): (339.3, 369.0),
    (3e6, "smoothed"): (358.5, 369.4),
    (10e6, "smoothed"): (392.9, 396.4),
    (1e6, "capped"): (263.61, 266.40),
    (3e6, "capped"): (259.59, 260.65),
}


@pytest.mark.parametrize(("pressure", "column"), DOUBLED)
def test_few_spots_of_contact_are_charged_with_what_doubled_cells_showed(steel, pressure, column):
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=pressure))
    four, eight = DOUBLED[pressure, column]
    left = 1 - four / ((4 * eight - four) / 3)
    assert cell_size.size_error(light, (4 * WAVE, 4 * WAVE), column=column) == pytest.approx(left, rel=0.3)


def test_a_cell_under_light_load_is_longer_and_what_is_still_missing_is_told(steel):
    for pressure, waves, size in ((3e7, 4.0, "0.4"), (1.5e6, 6.32, "0.4"), (3e5, 8.0, "1")):
        lengths, why = cell_size.choose_lengths(
            replace(steel, sliding=replace(steel.sliding, nominal_pressure=pressure))
        )
        assert lengths[0] == pytest.approx(waves * WAVE, rel=1e-3)
        assert f"{waves:g} longest waves" in why
        assert ("few spots carry the load" in why) == (waves > 4)
        assert f"less than {size} %" in why


def test_few_spots_of_contact_grow_with_the_area_and_the_load(steel):
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=1e6))
    double = replace(steel, sliding=replace(steel.sliding, nominal_pressure=2e6))
    small, large = ((waves * WAVE, waves * WAVE) for waves in (4, 8))
    error = cell_size.size_error(light, small, column="smoothed")
    assert cell_size.size_error(light, large, column="smoothed") == pytest.approx(error / 4)
    assert cell_size.size_error(double, small, column="smoothed") == pytest.approx(error / 2)
    assert cell_size.size_error(steel, small, column="smoothed") == cell_size.SIZE_ERROR  # 90 MPa: many spots
    soft = replace(light, body=replace(light.body, penetration_hardness=None))
    assert cell_size.size_error(soft, small) == cell_size.SIZE_ERROR  # no spots of a size of their own


@pytest.mark.slow
@pytest.mark.statistical
def test_a_cell_of_twice_the_side_changes_no_more_than_is_charged(steel, tmp_path):
    means, errors = [], []
    for waves in (2, 4):
        numerics = Numerics((Level("capped", (64 * waves, 64 * waves), 16 * 6350.0),), (waves * WAVE, waves * WAVE))
        run = rs.run(steel, tmp_path / str(waves), numerics=numerics, until={"flash_temperature": 0.01}, workers=1)
        found = run.estimate("flash_temperature")
        means.append(found.mean[-1])
        errors.append(found.standard_error[-1])
    change, noise = means[0] / means[1] - 1, np.hypot(*errors) / means[1]
    assert abs(change) < cell_size.size_error(steel, (2 * WAVE, 2 * WAVE)) + 3 * noise
    assert noise < 0.006
