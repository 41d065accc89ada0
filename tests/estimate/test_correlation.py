"""g_σ(r) of a column: the coarsest level in the run's cell, and the changes by finer ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import j0

from roughsim.estimate.correlation import correlation_of
from roughsim.observables.record import Sample

WAVENUMBER = np.array([1.0, 2.0, 5.0, 11.0])
DISTANCE = np.array([0.0, 0.3, 2.0, 2.5])


def sample(q_max, rows, seed, *, part=False, side=64.0, reach=3.0):
    """A level whose stress spectra are random numbers."""
    rng = np.random.default_rng(seed)
    rows = np.array(rows)
    return Sample(q_max, side, rows, {}, WAVENUMBER / q_max, rng.random((len(rows), len(WAVENUMBER))), reach, part)


def curve(level, rows=slice(None)):
    """The correlation of each realization by SciPy's Bessel function, mode by mode."""
    return sum(np.outer(level.spectrum[rows, k], j0(q * DISTANCE)) for k, q in enumerate(level.wavenumber))


def test_one_level_is_its_mean():
    level = sample(1.0, range(8), 1)
    mean, error, freedom = correlation_of([level], DISTANCE)
    np.testing.assert_allclose(mean, curve(level).mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(error, curve(level).std(axis=0, ddof=1) / 8**0.5, rtol=1e-12)
    np.testing.assert_allclose(freedom, 7.0)


def test_finer_levels_add_their_mean_changes():
    low, high = sample(1.0, range(9), 1), sample(2.0, range(0, 9, 3), 2)
    mean, error, freedom = correlation_of([low, high], DISTANCE)
    change = curve(high) - curve(low, slice(0, 9, 3))
    np.testing.assert_allclose(mean, curve(low).mean(axis=0) + change.mean(axis=0), rtol=1e-12)
    assert np.all(freedom < 8.0)
    assert np.all(error > 0.0)


def test_levels_in_a_part_of_the_cell_add_independent_changes_within_their_reach():
    low = sample(1.0, range(9), 1)
    start, high = (
        sample(q, rows, seed, part=True, reach=2.0) for q, rows, seed in ((1.0, range(9), 2), (2.0, (0, 4, 8), 3))
    )
    mean, error, freedom = correlation_of([low, start, high], DISTANCE)
    change = np.where(DISTANCE <= 2.0, curve(high) - curve(start, [0, 4, 8]), 0.0)
    np.testing.assert_allclose(mean, curve(low).mean(axis=0) + change.mean(axis=0), rtol=1e-12)
    of_low, of_change = curve(low).var(axis=0, ddof=1) / 9, change.var(axis=0, ddof=1) / 3
    np.testing.assert_allclose(error, np.sqrt(of_low + of_change), rtol=1e-12)
    # Satterthwaite, of eight and two degrees of freedom; beyond the reach only the run's cell tells
    np.testing.assert_allclose(freedom, (of_low + of_change) ** 2 / (of_low**2 / 8 + of_change**2 / 2), rtol=1e-12)
    assert freedom[-1] == pytest.approx(8.0)


def test_a_partner_on_half_the_pixel_is_the_finest_level():
    low = sample(1.0, range(6), 1)
    partner = replace(sample(1.0, range(6), 2), side=128.0)
    mean, *_ = correlation_of([low, partner], DISTANCE)
    np.testing.assert_allclose(mean, curve(partner).mean(axis=0), rtol=1e-12)


def test_the_surfaces_count_at_their_mean_peak_volume():
    rng = np.random.default_rng(3)
    volume = rng.standard_normal(20)
    level = sample(1.0, range(20), 1)
    follows = 5.0 * volume[:, None] * np.ones(len(WAVENUMBER))
    level = replace(level, spectrum=level.spectrum + follows, numbers={"peak_volume": volume[:, None]})
    mean, error, freedom = correlation_of([level], DISTANCE)
    raw = curve(level)
    slope = np.polyfit(volume, raw, 1)[0]
    np.testing.assert_allclose(mean, (raw - slope * volume[:, None]).mean(axis=0), atol=0.05)
    assert error[0] < 0.2 * raw[:, 0].std() / 20**0.5
    np.testing.assert_allclose(freedom, 18.0)  # of 19, one is lost to the slope
