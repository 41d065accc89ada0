"""The cell: its sides, and the error of its finite size."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.estimate import cell_size
from roughsim.prediction.asperities import asperity_area

WAVE = 2 * pi / 6350


@pytest.fixture(scope="module")
def steel():
    return rs.load_scene("steel-1.2GPa")


@pytest.fixture(scope="module")
def soft():
    """Elastic contact of a self-affine surface, H = 0.8, over a factor of 20."""
    return elastic()


def elastic(pressure="10 MPa", **surface):
    face = {"rms_height": "1 um", "hurst": 0.8, "q_min": 6350.0, "q_max": 20 * 6350.0} | surface
    body = {
        "youngs_modulus": 2e11,
        "poisson_ratio": 0.3,
        "conductivity": 30.0,
        "density": 7900,
        "heat_capacity": 500,
    }
    sliding = {"friction_coefficient": 0.1, "speed": [0.0, 0.04, 1e6], "nominal_pressure": pressure}
    return rs.load_scene({"surface": face, "body": body, "sliding": sliding})


def flat(scene, q_min=5e4):
    return replace(scene, surface=replace(scene.surface, roll_off_exponent=0.0, q_min=q_min))


def loaded(scene, pressure):
    return replace(scene, sliding=replace(scene.sliding, nominal_pressure=pressure))


def cell(waves):
    return (waves * WAVE, waves * WAVE)


def test_the_area_of_a_hill_follows_from_the_two_moments_of_a_power_law(soft):
    # C = q^(−3.6) from q₀ to 20 q₀: ∫ρ² d²r = 2π ∫q C² dq/(∫q C dq)²
    square, first = (1 - 20**-5.2) / 5.2, (1 - 20**-1.6) / 1.6
    expected = 2 * pi * square / first**2 / 6350**2
    assert asperity_area(soft, 4 * WAVE) == pytest.approx(expected, rel=1e-4)
    # a plateau to the cell's own wave adds ∫ρ d²r = 2π C/∫q C dq
    plateau = elastic(q_min=6350.0 / 16, q_roll_off=6350.0)
    first = (1 - 16.0**-2) / 2 + (1 - 20**-1.6) / 1.6
    square = (1 - 16.0**-2) / 2 + (1 - 20**-5.2) / 5.2
    expected = 2 * pi * (1 / first + square / first**2) / 6350**2
    assert asperity_area(plateau, 8 * WAVE) == pytest.approx(expected, rel=1e-4)


def test_the_error_is_the_inverse_of_the_number_of_hills_that_carry_load(soft):
    asperity = asperity_area(soft, 4 * WAVE)
    asperities = (4 * WAVE) ** 2 / asperity
    share = (
        0.4 * prediction.area_fractions(soft, 2 * pi / (np.sqrt(asperity) / 2))["contact_fraction"]
    )
    low = (0.03 / share + 0.2) / asperities
    assert cell_size.size_error(soft, cell(4)) == pytest.approx(low / (1 + low), rel=1e-4)
    assert cell_size.size_error(soft, cell(4), "contact_fraction") == cell_size.size_error(
        soft, cell(4)
    )
    assert np.isnan(cell_size.size_error(soft, cell(4), "correlation_radius_0"))


def test_the_error_is_of_the_shorter_side_and_falls_with_its_square_and_the_load(steel):
    light = loaded(steel, 1e5)

    def error(scene, lengths, column=""):
        found = cell_size.size_error(scene, lengths, "contact_fraction", column)
        return found / (1 - found)  # of the value found, not of the true one

    one = error(light, cell(4))
    assert error(light, (4 * WAVE, 16 * WAVE)) == one
    assert error(light, cell(8)) == pytest.approx(one / 4)
    # where few asperities carry load the error is as the inverse of their share; the smoothed column has 0.4 times as
    # many
    assert error(loaded(steel, 2e5), cell(4)) == pytest.approx(one / 2, rel=3e-3)
    assert error(light, cell(4), "smoothed") == pytest.approx(2.5 * one, rel=3e-3)
    assert error(light, cell(4), "capped") == one


def test_waves_far_shorter_than_a_hill_change_nothing(soft):
    # loads that touch on as much of the asperities: C(q) to 20 and to 2000 q_min, with equal waves up to there
    face = soft.surface
    long = replace(
        face,
        q_max=2000 * 6350.0,
        rms_height=face.rms_height * np.sqrt((1 - 2000**-1.6) / (1 - 20**-1.6)),
    )
    longer = replace(soft, surface=long)
    np.testing.assert_allclose(
        cell_size.size_error(longer, cell(4)), cell_size.size_error(soft, cell(4)), rtol=0.03
    )


def test_a_cell_shorter_than_the_longest_wave_lacks_what_is_longer(soft):
    whole = asperity_area(soft, 2 * WAVE)
    for waves in (1 - 1e-12, 1.0, 1 + 1e-12):  # however the side is rounded
        assert asperity_area(soft, waves * WAVE) == whole
    assert asperity_area(soft, 0.9 * WAVE) > 1.1 * whole


def test_a_cell_holds_four_longest_waves(steel):
    for target in (inf, 0.01):
        lengths, why = cell_size.choose_lengths(steel, target)
        assert lengths == pytest.approx(cell(4))
        assert "4 longest waves" in why
    given = replace(steel, numerics=replace(steel.numerics, lengths=cell(3)))
    assert cell_size.choose_lengths(given, 1e-4) == (cell(3), "given in the scene")


@pytest.mark.parametrize("pressure", [6e5, 2e6, 6e6])
@pytest.mark.parametrize("target", [0.01, 0.002])
def test_a_cell_under_light_load_is_the_shortest_whose_error_is_a_part_of_the_target(
    steel, pressure, target
):
    light = loaded(steel, pressure)
    lengths, why = cell_size.choose_lengths(light, target)
    waves = round(lengths[0] / WAVE)
    assert f"{waves} longest waves" in why
    errors = [cell_size.size_error(light, cell(n)) for n in (waves - 2, waves)]
    assert errors[1] <= 0.1**0.5 * target or waves == 32
    assert errors[0] > 0.1**0.5 * target or waves == 4
    assert (", as in fewer" in why) is (waves > 4)


@pytest.mark.parametrize("q_min", [5e4, 1e3])
def test_a_plateau_counts_waves_of_its_end(steel, q_min):
    lengths, why = cell_size.choose_lengths(flat(steel, q_min))
    assert lengths[0] == pytest.approx(
        8 * 2 * pi / 9.4e4
    )  # or 4 of the longest, where these are less
    assert "C(q) is flat below q_roll_off" in why


def test_one_face_without_a_plateau_counts_longest_waves(steel):
    scene = flat(steel)
    keys = ("rms_height", "hurst", "q_min", "q_roll_off", "q_max", "roll_off_exponent")
    face = {key: getattr(scene.surface, key) for key in keys}
    hard = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "like": None}
    for exponent, side in ((1.5, 4 * 2 * pi / 5e4), (0.0, 8 * 2 * pi / 9.4e4)):
        other = replace(scene.counterface, **face | hard | {"roll_off_exponent": exponent})
        assert cell_size.choose_lengths(replace(scene, counterface=other))[0][0] == pytest.approx(
            side
        )


@pytest.mark.slow
@pytest.mark.statistical
def test_t_flash_of_a_small_cell_is_too_low_by_what_is_charged():
    # σ₀/σ_P = .003, q_y = 3 q_min: of four waves against eight, with the members' peak volumes unknown
    light = elastic("6 MPa", rms_height="2.13 um", q_max=96 * 6350.0)
    light = replace(light, body=replace(light.body, penetration_hardness=2e9))
    means, errors, charged = [], [], []
    for waves, count in ((4, 400), (8, 100)):
        numerics = rs.Numerics(
            (rs.Level("capped", (24 * waves, 24 * waves), 6 * 6350.0),), cell(waves)
        )
        members = (rs.realize(light, numerics, seed=waves, index=index) for index in range(count))
        rows = np.array([member.observables.flash_temperature[1:] for member in members])
        means.append(rows.mean(axis=0))
        errors.append(rows.std(axis=0, ddof=1) / np.sqrt(count) / means[-1])
        charged.append(cell_size.size_error(light, cell(waves)))
    low, noise = 1 - means[0] / means[1], np.hypot(*errors)
    expected = 1 - (1 - charged[0]) / (1 - charged[1])
    assert np.all(low > 3 * noise / 2)  # too low
    assert np.all(low < expected + 3 * noise)
    assert np.all(low > 0.4 * expected - 3 * noise)  # and not by much less, also in fast sliding
