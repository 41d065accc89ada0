"""Contacts that the calibrated law draws, frozen and sliding: exact limits and solved contacts."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

import roughsim as rs
from roughsim.estimate import fields
from roughsim.observables.distribution import LEVELS
from roughsim.observables.moments import HeatSource
from roughsim.prediction.fields import draw_frozen, draw_slides, walked
from roughsim.sliding.stepping import Motion
from theory import at_rest, clipped, flash, plasticity

DIFFUSIVITY = 7.6e-6
STEEL = {"effective_modulus": 1.0989e11, "nominal_pressure": 9e7, "penetration_hardness": 1.2e9}
FULL = {"effective_modulus": 1.1e11, "nominal_pressure": 0.5e11, "penetration_hardness": 1e11}
SHARES = np.array([*LEVELS.values()])
# C(q) of both faces of two rough steels, h_rms = .9 µm each
ROUGH = rs.SelfAffineSpectrum.from_rms_height(
    9e-7, hurst=0.8, q_min=6350.0, q_roll_off=9.4e4, q_max=4.15e7, roll_off_exponent=1.5
).scaled(2.0)
INSULATING = rs.Body(1e-4, 1e-6)


def self_affine(level, q_max, q_min=5e4):
    return rs.SelfAffineSpectrum(level, 0.8, q_min, 1e5, q_max)


def frozen(speeds, spectrum, solid=STEEL, **numbers):
    return draw_frozen(spectrum, solid, HeatSource(speeds, 0.11, 30.0, DIFFUSIVITY), **numbers)


def slides(speeds, spectrum, solid=STEEL, resting=None, part=0.5, distance=2e-3, **numbers):
    moving = rs.Body(30.0, DIFFUSIVITY)
    motions = [Motion(v, 0.1, moving, resting or moving, distance) for v in speeds]
    return draw_slides(spectrum, solid, motions, part, **numbers)


def over_flash(sample, weight="", prefix=""):
    """Quantiles over T_flash and their standard errors, (levels, speeds)."""
    names = [f"{prefix}temperature_quantile_{weight}{name}" for name in LEVELS]
    ratios = (
        np.array([sample.numbers[name] for name in names]) / sample.numbers["flash_temperature"]
    )
    return ratios.mean(axis=1), ratios.std(axis=1, ddof=1) / np.sqrt(len(sample.rows))


def test_in_full_contact_pressure_and_temperature_are_jointly_normal():
    spectrum, solid = self_affine(1e-29, 1e6), FULL
    (sample, fine), *_ = frozen([0.02], spectrum, solid, fields=6, points=256, seed=3)
    assert (sample.q_max, fine.q_max) == (4 * 2 * 5e4, 8 * 2 * 5e4)
    even, error = (values[:, 0] for values in over_flash(fine, "area_"))
    law = {
        "stress_spectrum": plasticity.stress_spectrum(spectrum, **solid),
        "nominal_pressure": 0.5e11,
        "friction_coefficient": 0.11,
        "conductivity": 30.0,
        "diffusivity": DIFFUSIVITY,
    }
    deviation = even[4] / ndtri(0.9)
    over = float(flash.rms_temperature(0.02, **law) / flash.flash_temperature(0.02, **law))
    assert deviation == pytest.approx(
        over, rel=0.05
    )  # waves of the fields end at half of those of C(q)
    inner = slice(0, 5)
    expected = deviation * ndtri(SHARES)
    assert (np.abs(even - expected) < 4 * error + 0.02 * deviation)[inner].all()
    # the heat σ tilts the normal density by 1 + T T_flash/s², of the mean T_flash: Φ(x) − (T_flash/s) φ(x)
    tilted = [
        brentq(
            lambda x, p=p: ndtr(x) - np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi) / deviation - p, -6, 6
        )
        for p in SHARES
    ]
    heated, error = (values[:, 0] for values in over_flash(fine))
    wanted = deviation * np.array(tilted)
    assert (np.abs(heated - wanted) < 4 * error + 0.02 * deviation)[inner].all()


def test_steel_has_the_quantiles_of_solved_contacts():
    spectrum = ROUGH.truncated(q_max=2.032e5)
    drawn = frozen([1.0, 35.0], spectrum)
    ratio, error = over_flash(drawn.samples[-1])
    # of boundary-element contacts, all heat in the body: slow and fast
    solved = [
        (0.26, 0.64, 0.96, 1.31, 1.67, 2.28, 2.55),
        (0.04, 0.55, 0.96, 1.41, 1.83, 2.58, 3.06),
    ]
    assert (np.abs(ratio.T - solved) < 3 * error.T + 0.06)[:, 1:6].all()
    assert (np.abs(ratio.T - solved)[:, 0] < 0.1).all()  # the coldest are too warm
    assert (np.abs(ratio.T - solved)[:, 6] < 0.2).all()  # .999 is the mean over small fields


@pytest.mark.slow
def test_the_hottest_of_all_steel_is_that_of_a_ladder_of_solved_contacts():
    # boundary-element contacts have 99 % quantiles of 2.43 and 2.72 T_flash at 8e5 1/m, and they rise by .06 more
    drawn = frozen([1.0, 35.0], ROUGH)
    column = fields.drawn_frozen(drawn, 4.15e7, fields.by_law(np.ones(2), 0.0), 0.0)
    hottest = fields.quantile_of(column, "temperature_quantile_99")
    assert hottest.value == pytest.approx([2.49, 2.77], abs=0.12)
    assert (hottest.errors["bandwidth"] < 0.3).all()


def test_fields_end_at_the_wave_of_four_pixels():
    # four longest waves on 128 points: that is 8 q_min
    whole, part = (
        frozen([3.0], self_affine(1e-24, end * 5e4), fields=2, points=128, walk=False)
        for end in (16, 8)
    )
    for name, values in whole.samples[-1].numbers.items():
        assert values == pytest.approx(part.samples[-1].numbers[name], rel=1e-9)
    assert whole.flash[-1] != pytest.approx(part.flash[-1], rel=1e-3)  # it goes on
    assert part.flash[-1] == part.flash[-2]
    (short,), *_ = frozen([3.0], self_affine(1e-24, 4 * 5e4), fields=2, points=128)
    assert short.q_max == 4 * 5e4


@pytest.mark.slow
def test_speeds_keep_their_order_and_seeds_their_fields():
    some = {"spectrum": self_affine(1e-24, 1e6), "fields": 2, "points": 128}
    name = "temperature_quantile_75"

    def quantiles(speeds, **numbers):
        return frozen(speeds, **some, **numbers).samples[-1].numbers[name][0].tolist()

    one, again = quantiles([3.0, 0.1]), quantiles([0.1, 3.0])
    assert one == again[::-1]
    assert quantiles([3.0], seed=1) != one[:1]
    # a way beyond half of the cell counts as that half
    assert quantiles([3.0], slid_distance=1.0) == one[:1]
    near, _ = over_flash(frozen([3.0], **some, slid_distance=1e-5).samples[-1])
    far, _ = over_flash(frozen([3.0], **some).samples[-1])
    assert near[5] < far[5]


@pytest.mark.slow
def test_a_smooth_body_that_takes_all_heat_feels_the_frozen_contact():
    # one face is smooth, the resting body insulating: as frozen, along another direction
    spectrum = self_affine(1e-23, 1.6e5, q_min=2e4)
    known, error = over_flash(frozen([2.0], spectrum, fields=4, points=256).samples[-1])
    slid = slides([2.0], spectrum, resting=INSULATING, part=0.0, distance=1e-3, fields=4)
    own, own_error = over_flash(slid, prefix="sliding_")
    assert (np.abs(own - known) < 4 * np.hypot(error, own_error) + 0.04)[:6].all()


def test_in_full_contact_the_temperature_of_a_slide_is_normal():
    spectrum, solid = self_affine(1e-29, 4e5), FULL
    sample = slides([0.02], spectrum, solid, INSULATING, 0.0, 5e-4, fields=2, points=96)
    even, _ = over_flash(sample, "area_", "sliding_")
    deviation = even[4, 0] / ndtri(0.9)
    assert even[:5, 0] == pytest.approx(deviation * ndtri(SHARES[:5]), abs=0.15 * deviation)


@pytest.mark.slow
def test_slides_of_steel_have_the_quantiles_of_solved_ones():
    # experiments/reactions.py --slide: boundary-element contacts up to 1.016e5 1/m; slow and fast
    slid = np.array(
        [
            (0.316, 0.677, 0.972, 1.295, 1.598, 2.135, 2.444),
            (0.319, 0.689, 0.984, 1.290, 1.568, 2.049, 2.367),
        ]
    )
    sample = slides([1.0, 35.0], ROUGH.truncated(q_max=1.016e5), fields=3)
    ratio = over_flash(sample, prefix="sliding_")[0].T
    assert np.abs(ratio - slid)[:, 1:5].max() < 0.05
    assert np.abs(ratio - slid)[:, 5:].max() < 0.15
    assert np.abs(ratio - slid)[:, 0].max() < 0.07


def test_hot_places_of_waves_that_are_not_drawn_are_those_of_frozen_contact():
    flat = fields.by_law(np.array([100.0]), 0.0, "slide")
    sample = slides([3.0], self_affine(1e-23, 2e5), distance=3e-4, fields=2, points=64)
    drawn, whole = (fields.drawn_slides(sample, flat, np.array([x])) for x in (1.0, 1.3))
    for name in fields.QUANTILES:
        above = fields.quantile_of(drawn, name).value - 100.0
        assert fields.quantile_of(whole, name).value - 100.0 == pytest.approx(1.3 * above, rel=1e-9)


def test_short_slides_have_finer_steps_and_still_shorter_ones_are_refused():
    spectrum = self_affine(1e-23, 2e5)
    pixel = 8 * 2 * np.pi / 5e4 / 160
    sample = slides([3.0], spectrum, distance=3 * pixel, fields=1)
    assert sample.side == 320.0
    with pytest.raises(ValueError, match="slid_distance"):
        slides([3.0], spectrum, distance=0.3 * pixel, fields=1)


def test_outside_the_law_there_are_no_fields():
    with pytest.raises(ValueError, match="penetration_hardness"):
        frozen([1.0], ROUGH, STEEL | {"penetration_hardness": 1e6})
    with pytest.raises(ValueError, match="penetration_hardness"):
        slides([1.0], ROUGH, STEEL | {"penetration_hardness": 1e6})


def test_each_position_of_a_slide_has_the_area_of_the_field():
    from roughsim.prediction.fields import _along

    field = clipped.clipped_field(self_affine(3e-25, 4e7), **STEEL)
    rng = np.random.default_rng(5)
    still, riding = rng.standard_normal((2, 96, 96))
    offsets = np.array([[0, 0], [1, 0], [7, 1]])
    share = float(ndtr(-field.levels[0]))
    ascending = field.ascending(96**2)
    for contact in _along(offsets, 0.8 * still, 0.6 * riding, ascending):
        assert contact.pressure.mean() == pytest.approx(9e7, rel=1e-3)
        assert contact.contact_fraction == pytest.approx(share, rel=0.01)
    first, *others = _along(offsets, still, 0.0 * riding, ascending)
    assert all(contact is first for contact in others)
    moved = [contact.pressure for contact in _along(offsets, 0.0 * still, riding, ascending)]
    for offset, pressure in zip(offsets, moved, strict=True):
        assert (np.roll(pressure, offset, axis=(0, 1)) == moved[0]).all()


class Walk:
    """A walk that has these temperatures over T_flash at the ranks of `shares`."""

    def __init__(self, shares, over):
        self.over_flash = lambda share: np.interp(share, shares, over)


def test_what_a_walk_changes_at_rest_is_carried_over_as_far_as_rest_explains():
    heat, rest = np.array([1.0, 2.0, 1.0, 4.0]), np.array([4.0, 2.0, 1.0, 3.0])
    share = heat / 8
    still = rest / (rest @ share)
    ranks = np.array(
        [0.125 / 2, 0.25, 0.625, 0.9375]
    )  # of 1, 2, 3 and 4, at the middle of their heat
    exact = np.array([0.2, 0.5, 1.2, 1.5])
    alike = np.array([1.0, 3.0, 1.0, 5.0])
    fields = [3.0 * rest, alike, 9.0 - alike, 7.0 + 0.0 * rest]
    same, *moved, far = walked(fields, rest, heat, Walk(ranks, exact))
    changed = exact[[3, 1, 0, 2]]
    assert same == pytest.approx(changed / (changed @ share), rel=1e-12)  # it is that of the walk
    for field, found in zip(fields[1:3], moved, strict=True):
        over = field / (field @ share)
        (own, both), (_, whole) = np.cov(still, over, aweights=share, ddof=0)
        explained = both**2 / own / whole
        wanted = over + np.copysign(explained, both) * np.sqrt(whole / own) * (changed - still)
        assert found == pytest.approx(wanted / (wanted @ share), rel=1e-12)
    assert far == pytest.approx(np.ones(4), rel=1e-12)  # what does not know rest stays
    unchanged = walked([alike], rest, heat, Walk(ranks, np.sort(still)))[0]
    assert unchanged == pytest.approx(alike / (alike @ share), rel=1e-12)


def test_slow_contact_has_the_temperatures_of_the_walk_at_rest():
    spectrum = self_affine(1e-24, 4e5)
    sample = frozen([1e-7], spectrum, fields=2, points=128).samples[-1]
    law = plasticity.stress_spectrum(spectrum, **STEEL)
    exact = at_rest.at_rest(law, 4 * 2 * np.pi / 5e4).over_flash(SHARES[:6])
    assert over_flash(sample)[0][:6, 0] == pytest.approx(exact, abs=0.01)


def test_a_spectrum_with_gaps_keeps_the_fields_as_they_are_drawn():
    class Gap:
        breaks = (5e4, 1e5, 2e5, 4e5)

        def __call__(self, q):
            return np.where((q < 1e5) | (q > 2e5), 1e-24 * (q / 5e4) ** -3.4, 1e-27)

    rows = [frozen([3.0], Gap(), fields=1, points=64, walk=walk) for walk in (True, False)]
    numbers = [one.samples[-1].numbers["temperature_quantile_99"] for one in rows]
    assert not rows[0].walked
    assert numbers[0] == numbers[1]


def test_both_cut_offs_see_the_same_long_waves():
    (low, high), *_ = frozen(
        [3.0], self_affine(1e-23, 1e6), fields=24, points=128, seed=2, walk=False
    )
    rows = [sample.numbers["flash_temperature"][:, 0] for sample in (low, high)]
    assert np.corrcoef(*rows)[0, 1] > 0.5  # of unrelated fields below .4, at 95 %


def test_roughness_at_rest_is_a_moving_source_and_that_of_the_moving_body_one_that_stays():
    spectrum, speed = self_affine(1e-23, 1e5), 3.0
    stress = plasticity.stress_spectrum(spectrum, **STEEL)
    law = flash.flash_temperature(
        speed,
        stress_spectrum=stress,
        nominal_pressure=9e7,
        friction_coefficient=0.1,
        conductivity=30.0,
        diffusivity=DIFFUSIVITY,
    )
    still, riding = (
        slides(
            [speed], spectrum, resting=INSULATING, part=part, distance=3e-4, fields=4, points=64
        ).numbers["flash_temperature"]
        for part in (0.0, 1.0)
    )
    # all heat is in the moving body, and the contact that stays with the resting face is frozen
    error = float(still.std(ddof=1)) / 2.0
    assert still.mean() == pytest.approx(law, abs=4 * error)
    assert riding.mean() > 1.5 * law  # the same points are heated all the way
