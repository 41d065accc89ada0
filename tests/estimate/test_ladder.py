"""Ladders of levels: corrections from few realizations, the limit in q_c, the pixel, and what an interval is worth."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ladder_cases import NAME, level, power_law, seldom

from roughsim.estimate import errors as est
from roughsim.estimate.ladder import observe
from roughsim.observables.record import Sample

sys.path.insert(0, str(Path(__file__).parents[2] / "experiments"))
from intervals import coverage


def test_a_fine_level_of_few_realizations_corrects_the_coarse_one():
    rng = np.random.default_rng(0)
    coarse = 10.0 + rng.standard_normal((24, 2))
    fine = 0.7 * coarse + 0.01 * rng.standard_normal((24, 2))
    samples = [level(coarse), seldom(fine, 4, q_max=2.0, side=128.0)]
    values = observe(NAME, samples, capped=True, end=2.0)  # C(q) ends at the finest level: nothing to extrapolate
    expected = coarse.mean(axis=0) * fine[::4].mean(axis=0) / coarse[::4].mean(axis=0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected, rtol=1e-13)
    np.testing.assert_array_equal(np.unique(values.group, return_counts=True)[1], [18, 6])
    full = observe(NAME, [level(coarse), level(fine, q_max=2.0, side=128.0)], capped=True, end=2.0)
    assert values.group.tolist()[:5] == [1, 0, 0, 0, 1]  # 0: the coarsest level alone
    np.testing.assert_allclose(values.base, coarse * expected / coarse.mean(axis=0), rtol=1e-13)
    few, all_ = (est.spread(v.extrapolated, v.base, v.group)[0] for v in (values, full))
    np.testing.assert_allclose(few, all_, rtol=0.2)  # six fine solves are worth almost as much as 24


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_extrapolated_scatters_with_the_coarse_level_too(sign):
    # negative values, as of ∇²T, have ratios like positive ones; by 1/q_c, the last step times 1 − 2/end follows
    rng = np.random.default_rng(3)
    coarse = sign * (10.0 + rng.standard_normal((24, 2)))
    fine = 0.7 * coarse + 0.01 * rng.standard_normal((24, 2))
    values = observe(NAME, [level(coarse), seldom(fine, 4, q_max=2.0)], capped=True, end=8.0)
    ratio = fine[::4].mean(axis=0) / coarse[::4].mean(axis=0)
    factor = ratio + (ratio - 1.0) * (1.0 - 2.0 / 8.0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), factor * coarse.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(values.base, factor * coarse, rtol=1e-12)


def test_elastic_contact_is_corrected_by_differences():
    rng = np.random.default_rng(2)
    coarse = 10.0 + rng.standard_normal((24, 1))
    fine = coarse - 3.0 + 0.01 * rng.standard_normal((24, 1))
    values = observe(NAME, [level(coarse), seldom(fine, 4, q_max=2.0, side=128.0)], capped=False, end=2.0)
    expected = coarse.mean(axis=0) + (fine - coarse)[::4].mean(axis=0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), expected, rtol=1e-13)
    np.testing.assert_allclose(values.base, coarse - coarse.mean(axis=0) + expected, rtol=1e-13)


@pytest.mark.statistical
@pytest.mark.parametrize("mean", [0.0, 10.0])  # differences, as there are two signs; ratios
def test_the_error_of_a_ladder_is_its_scatter_over_many_ladders(mean):
    rng = np.random.default_rng(1)
    means, variances = [], []
    for _ in range(2000):
        coarse = mean + rng.standard_normal((24, 1))
        fine = 0.8 * coarse + 0.5 * rng.standard_normal((24, 1))
        values = observe(NAME, [level(coarse), seldom(fine, 4, q_max=2.0)], capped=True, end=2.0)
        means.append(values.extrapolated.mean())
        variances.append(est.spread(values.extrapolated, values.base, values.group)[0][0] ** 2)
    # 1/√1000 = 3 % is the relative error of the right side, 2 % of the left
    assert np.mean(variances) == pytest.approx(np.var(means), rel=0.08)
    assert np.mean(means) == pytest.approx(0.8 * mean, abs=4 * np.std(means) / np.sqrt(2000))


@pytest.mark.parametrize("exponent", [0.8, 1.0, 1.4])
def test_three_rungs_reach_the_end_of_the_spectrum_exactly(exponent):
    end = 40.0
    values = observe(NAME, power_law([1.0, 2.0, 4.0], exponent), capped=True, end=end)
    assert values.extrapolated.mean() == pytest.approx(7.0 + 3.0 * end**-exponent, rel=1e-10)
    assert values.exponent[0] == pytest.approx(exponent, rel=1e-9)
    remainder = 3.0 * (4.0**-exponent - end**-exponent)
    first_order = 3.0 * (2.0**-exponent - 4.0**-exponent) * (1.0 - 4.0 / end)
    assert values.bandwidth[0] == pytest.approx(max(abs(remainder - first_order), 0.2 * remainder), rel=1e-9)


def test_the_fitted_exponent_scatters_too():
    # rows must follow the pseudo-values n θ − (n − 1) θ₋ᵢ of a jackknife of the whole extrapolation
    rng = np.random.default_rng(11)
    a = 10.0 + rng.standard_normal((40, 1))
    b = a - 2.0 + 0.1 * rng.standard_normal((40, 1))
    c = b - 1.1 + 0.1 * rng.standard_normal((40, 1))

    def limit(keep):
        samples = [level(x[keep], q_max=q, side=64.0 * q) for x, q in ((a, 1.0), (b, 2.0), (c, 4.0))]
        return observe(NAME, samples, capped=True, end=50.0).extrapolated[:, 0]

    rows = limit(np.arange(40))
    pseudo = [40 * rows.mean() - 39 * limit(np.delete(np.arange(40), i)).mean() for i in range(40)]
    np.testing.assert_allclose(rows - rows.mean(), np.array(pseudo) - np.mean(pseudo), atol=0.1)
    assert rows.std() == pytest.approx(np.std(pseudo), rel=0.03)


def test_each_speed_has_its_own_exponent():
    slow, fast = (power_law([1.0, 2.0, 4.0], p) for p in (1.5, 0.8))
    both = [
        replace(a, numbers={NAME: np.hstack([a.numbers[NAME], b.numbers[NAME]])})
        for a, b in zip(slow, fast, strict=True)
    ]
    np.testing.assert_allclose(observe(NAME, both, capped=True).exponent, [1.5, 0.8], rtol=1e-9)


def test_two_rungs_are_doubted_by_half_of_the_remainder():
    values = observe(NAME, power_law([2.0, 4.0], 1.0), capped=True)
    assert values.extrapolated.mean() == pytest.approx(7.0, rel=1e-12)
    assert values.bandwidth[0] == pytest.approx(0.5 * 3.0 / 4.0, rel=1e-12)


def test_one_cut_off_below_the_end_leaves_an_unknown_remainder():
    for capped in (False, True):
        values = observe(NAME, power_law([1.0], 1.0), capped=capped, end=4.0)
        assert np.isnan(values.bandwidth[0])
        assert observe(NAME, power_law([1.0], 1.0), capped=capped, end=1.0).bandwidth[0] == 0.0


def test_steps_that_do_not_fall_leave_half_of_the_remainder_in_doubt():
    samples = [level(np.full((13, 1), value), q_max=q, side=64.0 * q) for q, value in ((1, 9.0), (2, 8.0), (4, 7.0))]
    values = observe(NAME, samples, capped=True)
    assert values.extrapolated.mean() == pytest.approx(6.0, rel=1e-12)  # first order: as much again as the last step
    assert values.bandwidth[0] == pytest.approx(0.5, rel=1e-12)


def test_rungs_that_stand_too_low_are_continued_in_first_order_and_doubted_by_what_they_fit():
    # capped steel from 2 to 64 q_y in per cent of the first: p = 0.4 from the lowest three would end at 36
    values = [100.0, 84.0, 72.0, 66.8, 64.5, 63.5]
    samples = [level(np.full((13, 1), v), q_max=2.0**k, side=64.0 * 2**k) for k, v in enumerate(values)]
    low = observe(NAME, samples[:3], capped=True, settled=2.0)
    assert low.exponent[0] == 1.0
    assert low.extrapolated.mean() == pytest.approx(60.0, rel=1e-12)
    fit = 12.0 / (16 / 12 - 1)  # a geometric series of the steps
    assert low.bandwidth[0] == pytest.approx(1.25 * (fit - 12.0), rel=1e-9)
    anyway = observe(NAME, samples[:3], capped=True)  # p = 0.4 is not believed wherever it comes from
    np.testing.assert_array_equal(anyway.extrapolated, low.extrapolated)
    np.testing.assert_array_equal(anyway.bandwidth, low.bandwidth)
    high = observe(NAME, samples[2:5], capped=True, settled=2.0)
    assert abs(high.extrapolated.mean() - 62.7) <= high.bandwidth[0]
    assert high.bandwidth[0] < 0.1 * low.bandwidth[0]


def test_a_rough_surface_that_falls_slowly_is_extrapolated_by_its_own_exponent():
    # capped contact with H = 0.3 at 30 m/s, 4 to 16 q_y, own runs up to 128 q_y: the limit at 1000 q_y is 292 ± 6
    values = [507.0, 437.0, 387.0]
    samples = [level(np.full((13, 1), v), q_max=4.0 * 2**k, side=64.0 * 2**k) for k, v in enumerate(values)]
    first_order = observe(NAME, samples[1:], capped=True, end=1000.0)
    assert abs(first_order.extrapolated.mean() - 292.0) > first_order.bandwidth[0] + 6.0
    for known in (samples[1:], samples):
        values = observe(NAME, known, capped=True, end=1000.0, usual=0.615)
        assert abs(values.extrapolated.mean() - 292.0) <= values.bandwidth[0] < 50.0


def test_an_exponent_that_the_steps_hardly_tell_is_drawn_to_the_usual_one():
    # the steps fall as 2^(−1.5); that of few realizations with a scatter of 5 in a step of 1 is no more than noise
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((16, 1))
    noise -= noise.mean()

    def limit(scatter):
        rows = (np.full((16, 1), 7.0 + 3.0 * q**-1.5) for q in (1.0, 2.0, 4.0))
        moved = [row + scatter * k * noise for k, row in enumerate(rows)]
        return observe(NAME, [level(x, q_max=2.0**k, side=64.0 * 2**k) for k, x in enumerate(moved)], capped=True)

    sure, unsure = limit(1e-3), limit(5.0)
    assert sure.exponent[0] == pytest.approx(1.5, abs=1e-3)
    assert 1.0 < unsure.exponent[0] < 1.1
    last = 3.0 * (2.0**-1.5 - 4.0**-1.5)
    assert unsure.bandwidth[0] == pytest.approx(0.5 * last, rel=0.1)
    assert sure.bandwidth[0] == pytest.approx(last - last / (2**1.5 - 1), rel=1e-3)


@pytest.mark.parametrize(("waves", "told"), [(0.5, False), (2.0, True)])
def test_a_length_within_a_wave_of_the_cut_off_is_not_extrapolated(waves, told):
    # steel 1.2 GPa, r(g = .5): 10.7, 8.8, 7.8, 7.55 µm, where the first three promised 6.7 ± .2
    def rung(radius, cut_off):  # a single wave, whose J0(q r) is .5 at q r = 1.521144
        wavenumber = np.array([1.5211440576687654 / radius])
        return Sample(cut_off, 64.0 * cut_off, np.arange(12), {}, wavenumber, np.ones((12, 1)), 1e3)

    radii = (10.7, 8.8, 7.8)
    lowest = 0.5 * 2.0 * np.pi * waves / radii[1]  # the second rung is so many waves long
    rungs = [rung(radius, lowest * 2.0**k) for k, radius in enumerate(radii)]
    values = observe("correlation_radius_50", rungs, capped=True, end=1e3 * lowest)
    assert (values.extrapolated.mean() < 7.5) == told
    if not told:
        assert values.extrapolated.mean() == pytest.approx(7.8, rel=1e-6)
        assert values.bandwidth[0] == pytest.approx(1.0, rel=1e-5)


@pytest.mark.statistical
def test_intervals_hold_the_truth_as_often_as_they_say():
    assert 0.90 < coverage(200, 0.015, 0.0, 2)[0] < 0.99


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(("skew", "trials"), [(0.0, 1000), (0.5, 2500)])
def test_intervals_cover_over_many_sequential_trials(skew, trials):
    doubt = 2.0 * np.sqrt(0.05 * 0.95 / trials)  # of the count itself; 5,000 trials stand in docs/errors.md
    assert 0.925 - doubt <= coverage(trials, 0.012, skew, 3)[0] <= 0.97 + doubt


@pytest.mark.statistical
def test_a_partner_that_is_rarer_than_the_rung_above_it_counts_with_its_own_scatter():
    # C(q) ends at the second cut-off, solved for one in two; half the pixel at the first was solved for one in four
    rng, n, count = np.random.default_rng(5), 16, 400
    means, errors = [], []
    for _ in range(count):
        first = 100.0 + rng.standard_normal((n, 1))
        finer = first - 2.0 + 1.5 * rng.standard_normal((n, 1))
        higher = first - 8.0 + rng.standard_normal((n, 1))
        samples = [level(first), seldom(finer, 4, side=128.0), seldom(higher, 2, q_max=2.0, side=128.0)]
        values = observe(NAME, samples, capped=True, end=2.0)
        assert np.bincount(values.group).tolist() == [8, 4, 4]
        means.append(values.extrapolated.mean())
        errors.append(est.spread(values.extrapolated, values.base, values.group)[0][0])
    # the pixel's change is carried to the higher cut-off in proportion, and continued to a vanishing pixel
    left = 2.0 * (92.0 / 100.0) / (1.0 - 2.0**-1.4)
    assert np.mean(means) == pytest.approx(92.0 - left, abs=4 * np.std(means) / np.sqrt(count))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.std(means), rel=0.15)  # 4 of 1/√(2·400)
