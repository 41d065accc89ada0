"""Surfaces as they are drawn: the same stream gives the same modes on any grid, and chance is fair."""

import numpy as np
import pytest
from surface_cases import (
    BOTH,
    CIRCLE,
    SPECTRUM,
    WIDE,
    draws,
    modes_of,
    square,
    variance_by_quadrature,
)

from roughsim.grid import Grid
from roughsim.surface.modes import mode_variance
from roughsim.surface.power_laws import SelfAffineSpectrum
from roughsim.surface.synthesis import synthesize


@pytest.mark.parametrize("shape", [(48, 48), (33, 34), (35, 33), (28, 40), (1, 64), (64, 1)])
@pytest.mark.parametrize("seed", [0, 1])
def test_fixed_amplitudes_give_the_same_rms_height_and_slope_in_every_draw(shape, seed):
    grid = Grid(shape, (CIRCLE, 1.2 * CIRCLE))
    heights = synthesize(SPECTRUM, grid, np.random.default_rng(seed))
    power = abs(np.fft.fft2(heights) / heights.size) ** 2
    qx = np.fft.fftfreq(shape[0], 1 / shape[0])[:, None]
    qy = np.fft.fftfreq(shape[1], 1 / shape[1])[None, :] / 1.2
    variance = grid.multiplicity * mode_variance(SPECTRUM, grid)
    q2 = qx**2 + qy[:, : shape[1] // 2 + 1] ** 2
    assert (heights**2).mean() == pytest.approx(variance.sum(), rel=1e-12)
    assert ((qx**2 + qy**2) * power).sum() == pytest.approx((q2 * variance).sum(), rel=1e-12)
    np.testing.assert_allclose(
        abs(modes_of(heights)), np.sqrt(mode_variance(SPECTRUM, grid)), rtol=0, atol=1e-15
    )


@pytest.mark.parametrize("amplitudes", BOTH)
def test_heights_are_real_with_mean_zero(amplitudes):
    for shape in [(32, 32), (27, 32), (32, 27)]:
        heights = synthesize(
            SPECTRUM, Grid(shape, (CIRCLE,) * 2), np.random.default_rng(2), amplitudes=amplitudes
        )
        assert heights.dtype == np.float64
        assert heights.shape == shape
        assert abs(heights.mean()) < 1e-12 * heights.std()


def test_amplitudes_are_fixed_unless_asked_otherwise():
    one = synthesize(SPECTRUM, square(32), np.random.default_rng(2))
    np.testing.assert_array_equal(
        one, synthesize(SPECTRUM, square(32), np.random.default_rng(2), amplitudes="fixed")
    )
    other = synthesize(SPECTRUM, square(32), np.random.default_rng(2), amplitudes="gaussian")
    assert abs((other**2).mean() - (one**2).mean()) > 1e-6


@pytest.mark.parametrize("amplitudes", BOTH)
def test_the_same_stream_gives_the_same_bits_and_another_does_not(amplitudes):
    first, again, other = (
        synthesize(SPECTRUM, square(32), np.random.default_rng(seed), amplitudes=amplitudes)
        for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(first, again)
    assert abs(first - other).max() > 0.1
    rng = np.random.default_rng(7)
    synthesize(SPECTRUM, square(32), rng, amplitudes=amplitudes)
    assert abs(synthesize(SPECTRUM, square(32), rng, amplitudes=amplitudes) - first).max() > 0.1


@pytest.mark.parametrize("amplitudes", BOTH)
@pytest.mark.parametrize("fine", [(96, 96), (64, 32), (32, 160)])
def test_a_finer_grid_shows_the_same_surface_at_the_shared_points(amplitudes, fine):
    surfaces = [
        synthesize(
            SPECTRUM,
            Grid(n, (CIRCLE, 1.1 * CIRCLE)),
            np.random.default_rng(5),
            amplitudes=amplitudes,
        )
        for n in ((32, 32), fine)
    ]
    shared = surfaces[1][:: fine[0] // 32, :: fine[1] // 32]
    np.testing.assert_allclose(shared, surfaces[0], rtol=0, atol=3e-14)


@pytest.mark.parametrize("amplitudes", BOTH)
@pytest.mark.parametrize("q_max", [6.0, 9.5, 13.0, 21.3, 31.4])
@pytest.mark.parametrize("aspect", [1.0, 1.37])
def test_a_higher_q_max_only_adds_modes(amplitudes, q_max, aspect):
    grid = Grid((128, 160), (CIRCLE, aspect * CIRCLE))
    low, high = (
        modes_of(synthesize(s, grid, np.random.default_rng(5), amplitudes=amplitudes))
        for s in (WIDE.truncated(q_max=q_max), WIDE)
    )
    kx = abs(np.fft.fftfreq(128, 1 / 128))[:, None]
    ky = np.arange(81)[None, :]
    inside = np.hypot(kx + 0.5, (ky + 0.5) / aspect) < q_max
    np.testing.assert_allclose(low[inside], high[inside], rtol=0, atol=1e-14)
    # a cell crossed by q_max keeps its phase and loses variance; noise of the transform is 1e-17
    crossed = ~inside & (
        np.hypot(np.maximum(kx - 0.5, 0), np.maximum(ky - 0.5, 0) / aspect) < 0.999 * q_max
    )
    ratio = low[crossed] / high[crossed]
    assert inside.sum() >= 40
    assert abs(ratio.imag).max() < 1e-9
    assert ratio.real.min() > 0
    assert ratio.real.max() < 1 + 1e-9


@pytest.mark.parametrize("amplitudes", BOTH)
def test_a_band_that_ends_at_nyquist_shares_all_other_modes_with_a_finer_grid(amplitudes):
    spectrum = SelfAffineSpectrum.from_rms_height(1.0, hurst=0.8, q_min=2.3, q_max=16.0)
    coarse, fine = (
        modes_of(synthesize(spectrum, square(n), np.random.default_rng(5), amplitudes=amplitudes))
        for n in (32, 64)
    )
    np.testing.assert_allclose(coarse[:16, :16], fine[:16, :16], rtol=0, atol=1e-14)
    np.testing.assert_allclose(coarse[17:, :16], fine[49:, :16], rtol=0, atol=1e-14)
    assert abs(coarse[16, :16]).max() > 1e-4


@pytest.mark.statistical
@pytest.mark.parametrize("n", [31, 36])
def test_the_mean_power_spectrum_of_gaussian_surfaces_is_the_given_one(n):
    count = 256
    power = (abs(draws(SPECTRUM, square(n), "gaussian", count)) ** 2).mean(axis=0)
    expected = variance_by_quadrature(SPECTRUM, n)
    kx, ky = np.fft.fftfreq(n, 1 / n)[:, None], np.arange(n // 2 + 1)[None, :]
    ring = np.rint(np.hypot(kx, ky)).astype(int)
    independent = (ky > 0) | (kx > 0)
    for radius in range(2, 14):
        bin_ = independent & (ring == radius) & (expected > 0)
        ratio = power[bin_].sum() / expected[bin_].sum()
        # each mode is exponential: its mean over the draws scatters by variance/√K, independently of the others
        scatter = np.sqrt((expected[bin_] ** 2).sum() / count) / expected[bin_].sum()
        assert abs(ratio - 1) < min(4 * scatter, 3 / np.sqrt(count)), radius
    every = independent & (expected > 1e-12)
    assert abs(power[every] / expected[every] - 1).max() < 6 / np.sqrt(count)
    assert (power[expected == 0] < 1e-30).all()


@pytest.mark.statistical
def test_gaussian_modes_are_complex_normal_and_fixed_ones_only_turn():
    grid, count = square(29), 256
    deviation = np.sqrt(variance_by_quadrature(SPECTRUM, 29))
    kx, ky = np.fft.fftfreq(29, 1 / 29)[:, None], np.arange(15)[None, :]
    some = ((ky > 0) | (kx > 0)) & (deviation > 1e-6)
    sample = draws(SPECTRUM, grid, "gaussian", count)[:, some] / deviation[some]
    error = 1 / np.sqrt(sample.size)
    assert abs(sample.mean()) < 4 * error
    assert (
        abs((sample**2).mean()) < 4 * np.sqrt(2) * error
    )  # equal, uncorrelated real and imaginary parts
    assert abs((abs(sample) ** 4).mean() - 2) < 4 * np.sqrt(20) * error  # exponential intensity
    turned = draws(SPECTRUM, grid, "fixed", count)[:, some] / deviation[some]
    np.testing.assert_allclose(abs(turned), 1, atol=1e-8)
    for harmonic in (1, 2, 3, 4):  # uniform phases
        assert abs((turned**harmonic).mean()) < 4 * error


@pytest.mark.statistical
@pytest.mark.parametrize("n", [8, 10])
def test_nyquist_modes_carry_their_variance(n):
    # flat C up to Nyquist: self-conjugate modes are real, the others on the edge complex
    spectrum = SelfAffineSpectrum(1.0, 0.0, 1.0, n / 2, n / 2)
    sample = draws(spectrum, square(n), "gaussian", 4000)
    variance = mode_variance(spectrum, square(n))
    edge = {
        (n // 2, 0): 2.0,
        (0, n // 2): 2.0,
        (n // 2, 1): 1.0,
        (1, n // 2): 1.0,
        (n - 1, n // 2): 1.0,
        (2, 0): 1.0,
    }
    for (
        k,
        relative_variance,
    ) in edge.items():  # of the intensity: 2 for a real normal number, 1 for a complex one
        mean = (abs(sample[(..., *k)]) ** 2).mean() / variance[k]
        assert abs(mean - 1) < 4 * np.sqrt(relative_variance / 4000), k
    assert abs(sample[:, n // 2, 0].imag).max() < 1e-15
    np.testing.assert_allclose(sample[:, 1, 0], sample[:, -1, 0].conj(), atol=1e-15)


def test_fixed_modes_on_the_edge_keep_their_amplitude_and_take_either_sign():
    spectrum = SelfAffineSpectrum(1.0, 0.0, 1.0, 4.0, 4.0)
    sample = draws(spectrum, square(8), "fixed", 200)
    deviation = np.sqrt(mode_variance(spectrum, square(8)))
    np.testing.assert_allclose(
        abs(sample), np.broadcast_to(deviation, sample.shape), rtol=0, atol=1e-15
    )
    for k in ((4, 0), (0, 4)):  # their own conjugates: real, plus or minus with equal chance
        assert abs(np.sign(sample[(..., *k)].real).mean()) < 4 / np.sqrt(200)


@pytest.mark.statistical
def test_heights_of_a_gaussian_surface_have_the_kurtosis_of_a_gaussian():
    rng, grid, count = np.random.default_rng(11), square(32), 4000
    z = np.array(
        [synthesize(SPECTRUM, grid, rng, amplitudes="gaussian")[3, 5] for _ in range(count)]
    )
    assert abs(z.mean()) < 4 / np.sqrt(count)
    assert abs((z**2).mean() - 1) < 4 * np.sqrt(2 / count)
    assert abs((z**3).mean()) < 4 * np.sqrt(15 / count)
    assert abs((z**4).mean() / (z**2).mean() ** 2 - 3) < 4 * np.sqrt(24 / count)


@pytest.mark.statistical
@pytest.mark.parametrize("amplitudes", BOTH)
def test_no_direction_is_preferred(amplitudes):
    # ⟨h_x²⟩ − ⟨h_y²⟩ and ⟨h_x h_y⟩ vanish; their scatter is estimated from the draws
    sample = draws(SPECTRUM, square(32), amplitudes, 128)
    kx, ky = np.fft.fftfreq(32, 1 / 32)[:, None], np.arange(17)[None, :]
    power = abs(sample) ** 2 * np.where(ky == 0, 1.0, 2.0)
    for pattern in (kx**2 - ky**2, 2 * kx * ky):
        moment = (pattern * power).sum(axis=(1, 2))
        size = ((kx**2 + ky**2) * power).sum(axis=(1, 2)).mean()
        assert abs(moment.mean()) < 4 * moment.std() / np.sqrt(128) + 1e-12 * size
    mixed = np.einsum("nij,nji->n", sample[:, :17, :17], sample[:, :17, :17].conj())
    assert (
        abs(mixed.mean())
        < 1.1 * abs(sample[0, np.arange(17), np.arange(17)] ** 2).sum() + 4 * mixed.std()
    )
