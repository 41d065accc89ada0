"""Corrections from half the cell: hand-computed means and errors, and what they add to the error of the size."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from ladder_cases import NAME, level, seldom

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.cell_size import size_error_of_sum
from roughsim.estimate.errors import estimate, quotient, relative_half_width
from roughsim.estimate.ladder import observe

RNG = np.random.default_rng(4)
BASE = 100.0 + 4.0 * RNG.standard_normal((12, 2))
# on other surfaces, with another mean; the finer level lies 10 and 20 below on average
START = 140.0 + 9.0 * RNG.standard_normal((12, 2))
CHANGE = np.array([-10.0, -20.0]) + 0.5 * RNG.standard_normal((12, 2))


def half(sample):
    return replace(sample, part=True)


def ratio(every):
    """What half the cell says of the step, from every so many realizations."""
    return (START + CHANGE)[::every].mean(axis=0) / START[::every].mean(axis=0)


def ladder(every):
    """The run's cell up to q_c = 1, and half the cell from there to 2 for each `every`-th realization."""
    start, fine = (half(seldom(rows, every, q_max=q)) for rows, q in ((START, 1.0), (START + CHANGE, 2.0)))
    return [level(BASE), start, fine]


@pytest.mark.parametrize("every", [1, 3])
def test_half_the_cell_gives_its_ratio_and_no_mean_of_its_own(every):
    values = observe(NAME, ladder(every), capped=True, end=2.0)
    expected = BASE.mean(axis=0) * ratio(every)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected, rtol=1e-12)
    np.testing.assert_allclose(values.finest.mean(axis=0), expected, rtol=1e-12)


@pytest.mark.parametrize("every", [2, 3])
def test_a_ratio_of_other_surfaces_adds_its_variance_to_that_of_the_base(every):
    values = observe(NAME, ladder(every), capped=True, end=2.0)
    # of the product of a mean and a ratio of means
    low, high = START[::every], (START + CHANGE)[::every]
    own = BASE.mean(axis=0) / low.mean(axis=0) * (high - ratio(every) * low)
    variances = (ratio(every) * BASE).var(axis=0, ddof=1) / 12, own.var(axis=0, ddof=1) / len(own)
    error = np.sqrt(sum(variances))
    told = estimate(NAME, values)
    np.testing.assert_allclose(told.standard_error, error, rtol=1e-12)
    # Satterthwaite
    freedom = sum(variances) ** 2 / (variances[0] ** 2 / 11 + variances[1] ** 2 / (len(own) - 1))
    np.testing.assert_allclose(told.effective_n - 1.0, np.minimum(freedom, 11.0), rtol=1e-12)
    half_width = told.half_width / expected_mean(every)
    assert relative_half_width(values) == pytest.approx(half_width.max(), rel=1e-12)


def expected_mean(every):
    return BASE.mean(axis=0) * ratio(every)


def test_the_error_of_a_ratio_takes_corrections_as_independent_too():
    values = observe(NAME, ladder(3), capped=True, end=2.0)
    told = quotient(values, np.array([2.0, 2.0]))
    np.testing.assert_allclose(told.standard_error, estimate(NAME, values).standard_error / 2.0, rtol=1e-12)


def test_a_ratio_takes_corrections_as_independent_only_where_those_of_both_columns_are():
    # the fine level of one column follows its coarse one: 8 of 16 rows are moved by n/8 = 2 times what they add
    rng = np.random.default_rng(9)
    base, constant = 50.0 + rng.standard_normal((16, 1)), np.full((16, 1), 8.0)
    fine = base + 0.7 * (base - 60.0)
    above = observe(NAME, [level(base), seldom(fine, 2, q_max=2.0)], capped=False, end=2.0)
    start, finer = half(seldom(constant, 2)), half(seldom(0.5 * constant, 2, q_max=2.0))
    below = observe(NAME, [level(constant), start, finer], capped=True, end=2.0)
    own, added = base.std(ddof=1), 2.0 * 0.7 * base[::2].std(ddof=1)
    expected = np.sqrt(8.0 * own**2 + 8.0 * (own + added) ** 2) / 16.0
    assert quotient(above, below).standard_error[0] == pytest.approx(expected / 4.0, rel=1e-12)
    mean = above.extrapolated.mean()
    assert quotient(below, above).standard_error[0] == pytest.approx(expected * 4.0 / mean**2, rel=1e-12)


def test_surfaces_of_half_the_cell_have_no_slopes_in_the_base():
    volumes = {"peak_volume": RNG.standard_normal(12), "long_peak_volume": RNG.standard_normal(12)}
    start, fine = (
        half(replace(level(rows, q_max=q), numbers={NAME: rows, **volumes}))
        for rows, q in ((START, 1.0), (START + CHANGE, 2.0))
    )
    values = observe(NAME, [level(BASE), start, fine], capped=True, end=2.0)
    assert values.slopes == 0
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected_mean(1), rtol=1e-12)


def test_the_partner_in_half_the_cell_shows_the_pixel():
    start = half(level(START, side=32.0))
    finer = half(level(START + CHANGE, side=64.0))
    values = observe(NAME, [level(BASE), start, finer], capped=True, end=1.0)
    # of order 1.4: a vanishing pixel changes more than half the pixel, in this ratio
    more = 1.0 / (1.0 - 2.0**-1.4)
    change = BASE.mean(axis=0) * (ratio(1) - 1.0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), BASE.mean(axis=0) + more * change, rtol=1e-12)
    np.testing.assert_allclose(values.pixel, np.abs((more - 1.0) * change), rtol=1e-12)


@pytest.mark.parametrize(("side", "finer"), [(32.0, 48.0), (16.0, 24.0)])
def test_a_partner_in_a_part_of_the_cell_is_finer_than_the_level_there(side, finer):
    # the run's cell has 64 points per side: what counts is 1.5 times the points of the part
    samples = [level(BASE), half(level(START, side=side)), half(level(START + CHANGE, side=finer))]
    values = observe(NAME, samples, capped=True, end=1.0)
    left = 1.0 / (1.0 - 1.5**-1.4) - 1.0
    np.testing.assert_allclose(values.pixel, np.abs(left * BASE.mean(axis=0) * (ratio(1) - 1.0)), rtol=1e-12)


def test_levels_in_the_runs_cell_come_before_those_in_half_of_it():
    # a whole level to q_c = 2, from which half the cell goes on to 4
    start, fine = (half(seldom(rows, 3, q_max=q)) for rows, q in ((START, 2.0), (0.97 * START, 4.0)))
    samples = [level(BASE), level(BASE + CHANGE, q_max=2.0), start, fine]
    values = observe(NAME, samples, capped=True, end=4.0)
    expected = 0.97 * (BASE + CHANGE).mean(axis=0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected, rtol=1e-12)
    np.testing.assert_allclose(values.from_part, 0.03 / 0.97, rtol=1e-12)
    assert not values.independent  # the second level has the surfaces of the first


def test_the_share_that_half_the_cell_adds_has_a_size_error_of_its_own():
    values = observe(NAME, ladder(3), capped=True, end=2.0)
    share = 1.0 / ratio(3) - 1.0
    np.testing.assert_allclose(values.from_part, share, rtol=1e-12)
    steel = rs.load_scene("steel-1.2GPa")
    lengths = (4 * 2 * np.pi / 6350,) * 2  # four longest waves: 0.2 %; of what half of it adds: 0.4 %
    size = size_error_of_sum(steel, lengths, 2, NAME, "capped", values.from_part)
    np.testing.assert_allclose(size, np.sqrt(0.002**2 + (0.004 * share) ** 2), rtol=1e-12)
    # a quarter of twice the sides is the same cell
    twice = (2 * lengths[0], 2 * lengths[1])
    size = size_error_of_sum(steel, twice, 4, NAME, "capped", values.from_part)
    np.testing.assert_allclose(size, np.sqrt(0.001**2 + (0.004 * share) ** 2), rtol=1e-12)
    # few spots: 0.0002 over (waves per side)² σ₀/σ_P; of what half the cell adds, 0.016 over its number of spots
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=1e-3 * 1.2e9))
    size = size_error_of_sum(light, lengths, 2, NAME, "capped", np.array([0.5]))
    spots = 1e-3 * (2 * prediction.yield_wavenumber(light) / 6350) ** 2
    assert size[0] == pytest.approx(sqrt(0.0125**2 + (0.5 * 0.016 / spots) ** 2), rel=1e-9)
    assert 0.2 < spots < 0.3  # q_y is eight times q_min
    np.testing.assert_array_equal(size_error_of_sum(steel, lengths, 2, NAME, "capped", np.zeros(2)), 0.002)


def test_what_is_extrapolated_beyond_half_cells_comes_from_them_too():
    # of two cut-offs, q_c = 1 and 2, by 1/q_c: the last step times 1 − 2/end follows
    values = observe(NAME, ladder(3), capped=True, end=8.0)
    mean = BASE.mean(axis=0) * (ratio(3) + (ratio(3) - 1.0) * (1.0 - 2.0 / 8.0))
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), mean, rtol=1e-12)
    np.testing.assert_allclose(values.from_part, BASE.mean(axis=0) / mean - 1.0, rtol=1e-12)


def test_what_half_a_smaller_cell_adds_is_as_much_less_exact_as_its_means():
    steel, share = rs.load_scene("steel-1.2GPa"), np.array([0.5])
    # 16 times the error at a quarter of the sides; the shorter side counts. With few spots, 16 times fewer of them
    for waves in ((1.0, 1.0), (1.0, 4.0), (4.0, 1.0)):
        lengths = (waves[0] * 2 * np.pi / 6350, waves[1] * 2 * np.pi / 6350)
        size = size_error_of_sum(steel, lengths, 2, NAME, "capped", share)
        np.testing.assert_allclose(size, 16 * np.sqrt(0.002**2 + (0.004 * share) ** 2), rtol=1e-12)
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=1e-4 * 1.2e9))
    lengths = (4 * 2 * np.pi / 6350, 16 * 2 * np.pi / 6350)
    spots = 1e-4 * (2 * prediction.yield_wavenumber(light) / 6350) ** 2
    size = size_error_of_sum(light, lengths, 2, NAME, "capped", share)
    np.testing.assert_allclose(size, np.hypot(0.0002 / (16 * 1e-4), share * 0.016 / spots), rtol=1e-9)


@pytest.mark.parametrize("few", [0.0, -1.0])
def test_values_of_two_signs_have_no_ratio_and_add_their_difference(few):
    # a plastic area that some realizations do not have; the other entry has a ratio still
    start, fine = START.copy(), START + CHANGE
    start[3, 0], fine[6, 0] = few, 0.5 * few
    samples = [level(BASE), half(seldom(start, 3)), half(seldom(fine, 3, q_max=2.0))]
    values = observe(NAME, samples, capped=True, end=2.0)
    change = (fine - start)[::3]
    expected = BASE.mean(axis=0) + change.mean(axis=0)
    expected[1] = expected_mean(3)[1]
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected, rtol=1e-12)
    variances = BASE[:, 0].var(ddof=1) / 12, change[:, 0].var(ddof=1) / 4
    assert estimate(NAME, values).standard_error[0] == pytest.approx(np.sqrt(sum(variances)), rel=1e-12)


@pytest.mark.statistical
def test_the_error_of_a_ratio_of_other_surfaces_is_its_scatter_over_many_ladders():
    # truth: 100 · 0.7; half the cell scatters by 12 % and has another mean
    rng, means, variances = np.random.default_rng(8), [], []
    for _ in range(2000):
        base = 100.0 + 4.0 * rng.standard_normal((24, 1))
        start = 140.0 + 16.0 * rng.standard_normal((24, 1))
        fine = 0.7 * start + 5.0 * rng.standard_normal((24, 1))
        samples = [level(base), half(seldom(start, 2)), half(seldom(fine, 2, q_max=2.0))]
        values = observe(NAME, samples, capped=True, end=2.0)
        means.append(values.extrapolated.mean())
        variances.append(estimate(NAME, values).standard_error[0] ** 2)
    assert np.mean(means) == pytest.approx(70.0, abs=4 * np.std(means) / np.sqrt(2000))
    assert np.mean(variances) == pytest.approx(np.var(means), rel=0.1)


def test_without_half_cells_nothing_comes_from_them():
    values = observe(NAME, [level(BASE), seldom(BASE + CHANGE, 3, q_max=2.0)], capped=True, end=2.0)
    np.testing.assert_array_equal(values.from_part, 0.0)
    assert not values.independent


@pytest.mark.slow
@pytest.mark.statistical
def test_half_the_cell_has_the_same_mean_corrections():
    demo = rs.load_scene("demo")
    side = 4 * 2 * np.pi / 6350

    def rows(share, level, count):
        """T_flash in a cell of this share of the sides, a row per realization."""
        levels = (rs.Level("capped", (int(share * n),) * 2, q) for n, q in ((128, 5e4), (256, 1e5)))
        numerics = rs.Numerics(tuple(levels), (share * side, share * side))
        seed = int(10 * share)
        members = (rs.realize(demo, numerics, seed=seed, level=level, index=index) for index in range(count))
        return np.array([member.observables.flash_temperature for member in members])

    (low, high), (start, fine) = ([rows(share, k, n) for k in (0, 1)] for share, n in ((1.0, 60), (0.5, 240)))
    base = low.mean(axis=0)
    whole, half = ((b - a) / base for a, b in ((low, high), (start, fine)))
    error = np.hypot(whole.std(axis=0, ddof=1) / sqrt(60), half.std(axis=0, ddof=1) / sqrt(240))
    assert np.all(error < 0.002)
    # the stated error of what half the cell adds, and three standard errors: of differences, which differ more
    apart = np.abs(whole.mean(axis=0) - half.mean(axis=0))
    assert np.all(apart <= 0.004 * np.abs(whole.mean(axis=0)) + 3.0 * error)
    # a quarter of the area scatters about four times as much, in variance
    gain = half.var(axis=0, ddof=1) / whole.var(axis=0, ddof=1)
    assert np.all((gain > 2.0) & (gain < 8.0))


def test_what_half_the_cell_adds_in_elastic_contact_is_known_to_nine_percent_of_it():
    steel, share = rs.load_scene("steel-1.2GPa"), np.array([0.5])
    soft = replace(steel, body=replace(steel.body, penetration_hardness=None))
    lengths = (4 * 2 * np.pi / 6350,) * 2
    for scene, column in ((soft, "elastic"), (soft, ""), (steel, "smoothed")):
        size = size_error_of_sum(scene, lengths, 2, NAME, column, share)
        np.testing.assert_allclose(size, np.hypot(0.004, 0.5 * 0.09), rtol=1e-12)
