"""g_σ(r) of a column: the lowest level in the run's cell, and the changes by higher ones."""

from dataclasses import replace

import numpy as np
from ladder_cases import at_level
from scipy.special import j0

from roughsim.estimate.errors import spread_of
from roughsim.estimate.telescoping import correlation_of
from roughsim.observables.record import Sample

WAVENUMBER = np.array([1.0, 2.0, 5.0, 11.0])
DISTANCE = np.array([0.0, 0.3, 2.0, 2.5])


def sample(q_max, n, seed, *, part=False, side=64.0, reach=3.0):
    """A level whose stress spectra are random numbers."""
    spectrum = np.random.default_rng(seed).random((n, len(WAVENUMBER)))
    return Sample(q_max, side, np.arange(n), {}, WAVENUMBER / q_max, spectrum, reach, part)


def curve(level):
    """The correlation of each realization by SciPy's Bessel function, mode by mode."""
    return sum(
        np.outer(level.spectrum[:, k], j0(q * DISTANCE)) for k, q in enumerate(level.wavenumber)
    )


def test_one_level_is_its_mean():
    level = sample(1.0, 8, 1)
    found = correlation_of([at_level(level, 0, 0)], DISTANCE)
    mean, error, freedom = found.value, *spread_of(found)
    np.testing.assert_allclose(mean, curve(level).mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(error, curve(level).std(axis=0, ddof=1) / 8**0.5, rtol=1e-12)
    np.testing.assert_allclose(freedom, 7.0)


def test_steps_add_their_mean_changes_and_independent_variances():
    low, below, high = sample(1.0, 9, 1), sample(1.0, 5, 2), sample(2.0, 5, 3)
    found = correlation_of([at_level(low, 0, 0), at_level(high, 1, 1, below)], DISTANCE)
    mean, error, freedom = found.value, *spread_of(found)
    change = curve(high) - curve(below)
    np.testing.assert_allclose(mean, curve(low).mean(axis=0) + change.mean(axis=0), rtol=1e-12)
    parts = curve(low).var(axis=0, ddof=1) / 9, change.var(axis=0, ddof=1) / 5
    np.testing.assert_allclose(error, np.sqrt(sum(parts)), rtol=1e-12)
    np.testing.assert_allclose(
        freedom, sum(parts) ** 2 / (parts[0] ** 2 / 8 + parts[1] ** 2 / 4), rtol=1e-12
    )


def test_levels_in_a_part_of_the_cell_add_changes_within_their_reach():
    low = sample(1.0, 9, 1)
    below, high = (sample(q, 4, seed, part=True, reach=2.0) for q, seed in ((1.0, 2), (2.0, 3)))
    found = correlation_of([at_level(low, 0, 0), at_level(high, 1, 1, below)], DISTANCE)
    mean, _, freedom = found.value, *spread_of(found)
    change = np.where(DISTANCE <= 2.0, curve(high) - curve(below), 0.0)
    np.testing.assert_allclose(mean, curve(low).mean(axis=0) + change.mean(axis=0), rtol=1e-12)
    assert freedom[-1] == 8.0  # beyond their reach the run's cell alone counts
    whole = correlation_of(
        [at_level(replace(low, reach=2.0), 0, 0)], DISTANCE
    )  # it holds up to its own reach
    np.testing.assert_allclose(whole.value, curve(low).mean(axis=0), rtol=1e-12)


def test_of_partners_that_of_the_highest_cut_off_counts_alone():
    low, below, high = sample(1.0, 9, 1), sample(1.0, 5, 2), sample(2.0, 5, 3)
    pairs = [at_level(low, 0, 0), at_level(high, 1, 1, below)]
    at_low = at_level(sample(1.0, 5, 4, side=128.0), 2, 2, sample(1.0, 5, 5))
    at_high = at_level(sample(2.0, 5, 6, side=128.0), 3, 3, sample(2.0, 5, 7))
    plain = correlation_of(pairs, DISTANCE).value
    np.testing.assert_array_equal(correlation_of([*pairs, at_low], DISTANCE).value, plain)
    change = (curve(at_high) - curve(at_high.below)).mean(axis=0)
    np.testing.assert_allclose(
        correlation_of([*pairs, at_high], DISTANCE).value, plain + change, rtol=1e-12
    )
    # the lowest level is the highest here
    lowest = correlation_of([pairs[0], at_low], DISTANCE).value
    change = (curve(at_low) - curve(at_low.below)).mean(axis=0)
    np.testing.assert_allclose(lowest, curve(low).mean(axis=0) + change, rtol=1e-12)


def test_the_surfaces_of_the_lowest_level_count_at_their_mean_peak_volume():
    volume = np.random.default_rng(3).standard_normal(20)
    level = sample(1.0, 20, 1)
    spectrum = 0.01 * level.spectrum + 5.0 * volume[:, None]
    level = replace(level, spectrum=spectrum, numbers={"peak_volume": volume[:, None]})
    raw = curve(level)
    rows = np.empty_like(raw)
    for i in range(20):  # each with the slope of all others
        others = np.arange(20) != i
        rows[i] = raw[i] - np.polyfit(volume[others], raw[others], 1)[0] * volume[i]
    found = correlation_of([at_level(level, 0, 0)], DISTANCE)
    mean, error, freedom = found.value, *spread_of(found)
    np.testing.assert_allclose(mean, rows.mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(error, rows.std(axis=0, ddof=1) / 20**0.5, rtol=1e-9)
    np.testing.assert_allclose(freedom, 19.0)
