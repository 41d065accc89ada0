"""Peak volumes: their mean over surfaces against closed forms and draws, and what they see of a surface."""

from math import acos, pi, sqrt

import numpy as np
import pytest
from scipy.special import iv
from scipy.stats import norm
from some_rows import some

import roughsim as rs
from roughsim.surface import peak_volume as stage
from roughsim.surface.peak_volume import (
    HeightsAtAPoint,
    excess,
    expected_share,
    heights_at_a_point,
    mean_above,
    mean_exponential,
    peak_volume,
)
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.surface.synthesis import synthesize

GRID = rs.Grid((64, 64), (1e-3, 1e-3))
WAVE = 2 * pi / 1e-3


def of_amplitudes(phased, signed=()):
    """Heights at a point of waves with these amplitudes; long sums, as few waves need them."""
    s = 1.0 + 1j * stage.STEP * np.arange(1 << 15)
    phased, signed = np.asarray(phased, float), np.asarray(signed, float)
    rms = sqrt((phased**2).sum() / 2 + (signed**2).sum())
    return HeightsAtAPoint(rms, 1.0, s, mean_exponential(phased / rms, signed / rms, s))


@pytest.mark.parametrize("level", [0.1, 0.5, 1.0, 1.4])
def test_one_wave_has_the_mean_of_a_cosine(level):
    # (1/π) ∫ (√2 cos φ − t) dφ where √2 cos φ > t
    edge = acos(level / sqrt(2.0))
    exact = (sqrt(2.0) * np.sin(edge) - level * edge) / pi
    assert mean_above(level, of_amplitudes([3e-7])) == pytest.approx(exact, abs=1e-7)


def test_a_mode_that_is_its_own_conjugate_has_a_sign_alone():
    assert mean_above(0.4, of_amplitudes([], [2e-6])) == pytest.approx(0.5 * (1.0 - 0.4), abs=2e-5)


@pytest.mark.parametrize("level", [0.13, 1.0, 2.3, 3.3])
def test_very_many_waves_are_normal(level):
    exact = norm.pdf(level) - level * norm.sf(level)
    assert mean_above(level, of_amplitudes(np.ones(20000))) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("level", some([0.3, 1.2, 2.5], 2))
def test_few_and_unequal_waves_have_the_mean_of_many_draws(level):
    amplitudes = np.array([1.0, 0.7, 0.5, 0.3, 0.2, *np.full(30, 0.05)])
    point = of_amplitudes(amplitudes)
    phases = 2 * pi * np.random.default_rng(1).random((100000, amplitudes.size))
    heights = (amplitudes * np.cos(phases)).sum(axis=1) / point.rms
    above = np.maximum(heights - level, 0.0)
    assert abs(mean_above(level, point) - above.mean()) < 4 * above.std() / sqrt(above.size)
    if level == 2.5:  # and differs from that of a normal surface
        assert abs(
            norm.pdf(level) - level * norm.sf(level) - above.mean()
        ) > 6 * above.std() / sqrt(above.size)


def test_small_waves_enter_by_a_series_as_large_ones_do(monkeypatch):
    amplitudes, s = np.full(1000, 0.0447), np.array([1.0, 1.0 + 3.0j, 1.0 + 9.0j])
    series = mean_exponential(amplitudes, np.array([]), s)
    monkeypatch.setattr(stage, "LARGE", 0.0)
    products = mean_exponential(amplitudes, np.array([]), s)
    np.testing.assert_allclose(series, products, rtol=1e-4, atol=1e-12)


def test_bessel_sums_are_those_of_the_library():
    z = np.array([0.0, 0.3, 1.0 + 12.0j, 2.5 - 17.0j, 29.9j, 29.0])
    np.testing.assert_allclose(stage.bessel(z), iv(0, z), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("q_max", [40 * WAVE, 12 * WAVE])
@pytest.mark.parametrize("load", some([0.01, 0.002], 2))
@pytest.mark.statistical
def test_the_mean_over_surfaces_is_zero(q_max, load):
    grid = rs.Grid((160, 160), GRID.lengths)
    spectrum = rs.SelfAffineSpectrum.from_rms_height(2e-6, hurst=0.8, q_min=3 * WAVE, q_max=q_max)
    found = []
    for seed in range(300):
        heights = synthesize(spectrum, grid, np.random.default_rng(seed))
        found.append(peak_volume(spectrum, grid, heights, load, np.inf))
    found = np.array(found)
    assert abs(found.mean()) <= 4 * found.std() / sqrt(300)
    assert np.all(found != 0.0)


def test_the_volume_is_that_above_the_level_in_rms_heights():
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        2e-6, hurst=0.8, q_min=3 * WAVE, q_max=12 * WAVE
    )
    point = heights_at_a_point(spectrum, GRID)
    heights = np.zeros(GRID.shape)
    heights[:8, :16] = 2.0 * point.rms  # 128 of 4096 points, 1.5 above the level
    assert excess(heights, 0.5, point) + mean_above(0.5, point) == pytest.approx(
        1.5 * 128 / 4096, rel=1e-12
    )
    assert excess(np.zeros(GRID.shape), 0.5, point) == -mean_above(0.5, point)


def test_rms_height_and_slope_are_those_of_every_surface():
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        2e-6, hurst=0.8, q_min=3 * WAVE, q_max=12 * WAVE
    )
    point, heights = (
        heights_at_a_point(spectrum, GRID),
        synthesize(spectrum, GRID, np.random.default_rng(5)),
    )
    assert point.rms == pytest.approx(heights.std(), rel=1e-9)
    half = np.fft.rfft2(heights) / heights.size
    square = (np.abs(half) ** 2 * GRID.multiplicity * GRID.wavenumbers**2).sum()
    assert point.rms_slope == pytest.approx(sqrt(square), rel=1e-9)


def test_the_expected_share_is_elastic_or_yielded():
    assert expected_share(0.1, 1e-3, np.inf) == pytest.approx(sqrt(8 / pi) * 1e-3 / 0.1, rel=1e-3)
    assert expected_share(0.1, 1e-3, 1e-2) == 0.1  # σ₀/σ_P
    assert expected_share(0.1, 1e-9, np.inf) == stage.LEAST_SHARE
    assert expected_share(0.1, 1.0, 1.5) == stage.MOST_SHARE


def test_the_level_of_full_contact_is_that_of_0_45_of_a_normal_surface():
    # at a level below the middle, half the area and more, the mean over surfaces is another integral
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        2e-6, hurst=0.8, q_min=3 * WAVE, q_max=12 * WAVE
    )
    one, other = (synthesize(spectrum, GRID, np.random.default_rng(seed)) for seed in (5, 6))
    volumes = [peak_volume(spectrum, GRID, heights, 1.0, 1.5) for heights in (one, other)]
    above = [
        np.maximum(heights / one.std() - norm.isf(0.45), 0.0).mean() for heights in (one, other)
    ]
    assert volumes[0] - volumes[1] == pytest.approx(above[0] - above[1], rel=1e-6)


def test_a_flat_surface_has_none():
    whole = rs.SelfAffineSpectrum.from_rms_height(2e-6, hurst=0.8, q_min=3 * WAVE, q_max=12 * WAVE)
    flat = TruncatedSpectrum(whole, factor=0.0)
    assert peak_volume(flat, GRID, np.zeros(GRID.shape), 0.01, 1.0) == 0.0
