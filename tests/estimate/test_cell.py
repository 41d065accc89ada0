"""The cell: its sides, and what doubling it changes."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
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
    assert "a larger cell changes T_flash by less than 0.2 %" in why


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
    for scene, enough, size in ((steel, 4 * WAVE, 0.002), (flat(steel), 8 * 2 * pi / 9.4e4, 0.004)):
        assert cell_size.size_error(scene, (enough, enough)) == pytest.approx(size)
        assert cell_size.size_error(scene, (enough / 2, 3 * enough)) == pytest.approx(4 * size)
        assert cell_size.size_error(scene, (4 * enough, 2 * enough)) == pytest.approx(size / 2)
        assert np.isnan(cell_size.size_error(scene, (enough, enough), "correlation_radius_0"))


def test_capped_contact_depends_less_on_the_cell_than_elastic_contact_but_for_a_tenth_of_the_correlation(steel):
    cell, soft = (4 * WAVE, 4 * WAVE), replace(steel, body=replace(steel.body, penetration_hardness=None))
    cases = {(steel, "capped"): 0.002, (steel, "smoothed"): 0.004, (steel, ""): 0.002, (soft, ""): 0.004}
    for (scene, column), size in cases.items():
        assert cell_size.size_error(scene, cell, column=column) == size
    assert cell_size.size_error(steel, cell, "correlation_radius_50", "capped") == 0.002
    assert cell_size.size_error(steel, cell, "correlation_radius_10", "capped") == 0.004


@pytest.mark.parametrize(("target", "times"), [(0.01, 1), (0.0045, 1), (0.0044, 2), (0.003, 2), (0.001, 2)])
def test_a_small_target_has_a_cell_of_twice_the_sides(steel, target, times):
    lengths, why = cell_size.choose_lengths(steel, target)
    assert lengths == pytest.approx((4 * times * WAVE, 4 * times * WAVE))
    assert f"{4 * times} longest waves" in why
    assert ("too much of the target" in why) is (times == 2)
    given = replace(steel, numerics=replace(steel.numerics, lengths=(3 * WAVE, 3 * WAVE)))
    assert cell_size.choose_lengths(given, target) == ((3 * WAVE, 3 * WAVE), "given in the scene")


def test_corrections_may_come_from_half_of_a_cell_that_suffices_and_from_a_quarter_of_twice_it(steel):
    def parts(scene, waves):
        return cell_size.parts_of(scene, (waves * WAVE, 12 * WAVE))

    assert [parts(steel, waves) for waves in (3.9, 4.0, 7.9, 8.0, 12.0)] == [1, 2, 2, 4, 4]
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=5e-4 * 1.2e9))  # 10 waves for 0.4 %
    assert [parts(light, waves) for waves in (8.0, 9.9, 10.1, 12.0)] == [1, 1, 2, 2]
    soft = replace(steel, body=replace(steel.body, penetration_hardness=None))
    assert parts(soft, 8.0) == 1
    wave = 2 * pi / 9.4e4
    assert [cell_size.parts_of(flat(steel), (waves * wave,) * 2) for waves in (7.9, 8.0, 16.0)] == [1, 2, 4]


def test_a_cell_as_long_as_chosen_has_its_part_however_its_sides_are_rounded(steel):
    for pressure in (9e7, 1.5e6, 1.1e6, 1e6):  # few spots: as long as keeps these within 0.4 %
        scene = replace(steel, sliding=replace(steel.sliding, nominal_pressure=pressure))
        side = cell_size.choose_lengths(scene)[0][0]
        assert [cell_size.parts_of(scene, (side * (1 + off),) * 2) for off in (-1e-12, 1e-12, -1e-6)] == [2, 2, 1]


def test_a_part_of_the_cell_has_half_a_spot_of_contact_as_what_was_measured(steel):
    # on a plateau cells hold many waves and few spots: (side q_y/2π)² σ₀/σ_P
    lengths = (16 * 2 * pi / 9.4e4, 30 * 2 * pi / 9.4e4)  # the shorter side counts
    for share, parts in ((0.41, 4), (0.39, 2), (0.25 * 0.41, 2), (0.25 * 0.39, 1)):
        scene = flat(steel)
        for _ in range(50):  # q_y follows the load
            waves = lengths[0] / 4 * prediction.yield_wavenumber(scene) / (2 * pi)
            load = share / waves**2 * 1.2e9
            scene = replace(scene, sliding=replace(scene.sliding, nominal_pressure=load))
        assert cell_size.parts_of(scene, lengths) == parts


def test_few_spots_on_a_plateau_count_in_waves_of_the_roll_off(steel):
    light = replace(flat(steel), sliding=replace(steel.sliding, nominal_pressure=1e-4 * 1.2e9))
    lengths = (10 * 2 * pi / 9.4e4, 20 * 2 * pi / 9.4e4)
    assert cell_size.size_error(light, lengths, column="capped") == pytest.approx(0.0002 / (1e-4 * 100))
    assert cell_size.size_error(light, lengths, column="smoothed") == pytest.approx(0.0016 / (1e-4 * 100))


def test_a_cell_of_twice_the_sides_states_its_own_error_and_why_it_was_long_before(steel):
    assert cell_size.choose_lengths(steel, 0.003)[1].endswith("a larger cell changes T_flash by less than 0.1 %")
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=1.5e6))
    lengths, why = cell_size.choose_lengths(light, 0.003)
    assert lengths[0] == pytest.approx(2 * 4 * sqrt(2.5) * WAVE)  # 0.0002 / (16 · 2.5 · 1.5e6/1.2e9) is 0.4 %
    assert ": few spots carry the load: half of them would leave too much of the target" in why


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
    for pressure, waves, size in ((3e7, 4.0, "0.2"), (1.5e6, 6.32, "0.4"), (3e5, 8.0, "1")):
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
    assert cell_size.size_error(soft, small) == cell_size.SIZE_ERROR  # elastic, and no spots of a size of their own


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
