"""Drawn clipped Gaussian fields: their waves, their load and their correlation."""

import numpy as np
import pytest
from yielding_cases import SelfAffine

from theory import clipped, plasticity
from theory.clipped import amplitudes, halved, heights, ranked

STEEL = {"effective_modulus": 1.0989e11, "nominal_pressure": 9e7, "penetration_hardness": 1.2e9}


def drawn_pressure(field, amplitude, rng):
    z = heights(amplitude, rng.standard_normal(amplitude.shape))
    return ranked(z, field.ascending(z.size))


def half_contact():
    """Contact on half of the area with ρ = e^(−r²/2): ⟨FF′⟩ − ¼ = arcsin ρ/2π."""
    r = np.exp(np.arange(-2048, 2048) * 4e-3 + 2e-3)
    steps = np.array([0.0]), np.array([1.0])
    of_half = np.arcsin(np.exp(-(r**2) / 2)) / (2 * np.pi)
    return clipped.ClippedField(*steps, r, of_half, 0.25, clipped.products(*steps))


def test_the_waves_of_a_gaussian_correlation_have_its_transform_as_their_variance():
    amplitude, wrong = amplitudes(half_contact(), 64, 16.0)
    q = 2 * np.pi * np.fft.fftfreq(64, 0.25)
    variance = 2 * np.pi / 16.0**2 * np.exp(-(q[:, None] ** 2 + q**2) / 2)
    variance[0, 0] = 0.0
    # waves as long as infinity, 2 % of the variance, are left out of z and of the pressure
    assert amplitude**2 == pytest.approx(variance / variance.sum(), abs=1.5e-4)
    assert wrong < 3e-4  # the table of angles
    assert (amplitude**2).sum() == pytest.approx(1.0, rel=1e-12)


def test_light_contacts_have_nearly_the_power_of_the_law():
    # contacts avoid one another more than a Gaussian field can
    solid = {**STEEL, "nominal_pressure": 1.2e7}
    spectrum = SelfAffine(level=1e-24, q_max=6.4e5)
    field = clipped.clipped_field(spectrum, **solid)
    length = 4 * 2 * np.pi / 5e4
    amplitude, wrong = amplitudes(field, 128, length)
    assert (amplitude**2).sum() == pytest.approx(1.0, rel=1e-12)
    assert 0.05 < wrong < 0.15
    rng = np.random.default_rng(2)
    along, across = np.meshgrid(*(2 * np.pi * np.fft.fftfreq(128, length / 128),) * 2)
    q = np.hypot(along, across)
    powers = [np.abs(np.fft.fft2(drawn_pressure(field, amplitude, rng))) ** 2 for _ in range(30)]
    drawn = np.mean(powers, axis=0)
    drawn[0, 0] = 0.0
    stress = plasticity.stress_spectrum(spectrum, **solid)
    law = stress(np.where(q > 0, q, q.max()))
    law[0, 0] = 0.0
    bands = [(q > low) & (q <= 2 * low) for low in 5e4 * 2.0 ** np.arange(-1, 4)]
    found, expected = (
        np.array([power[band].sum() for band in bands]) / power.sum() for power in (drawn, law)
    )
    # waves beyond those of the grid count on it too, and 30 fields scatter
    assert np.abs(found - expected).sum() / 2 < wrong + 0.04


def test_drawn_contacts_have_the_load_and_the_correlation_of_the_field():
    field = half_contact()
    amplitude, _ = amplitudes(field, 128, 32.0)
    rng = np.random.default_rng(1)
    drawn = np.stack([drawn_pressure(field, amplitude, rng) for _ in range(12)])
    assert drawn.mean(axis=(1, 2)).tolist() == [0.5] * 12
    assert set(drawn.ravel()) == {0.0, 1.0}
    shift = np.array([4, 6, 8])  # r = 1, 1.5, 2
    both = np.array(
        [[(d * np.roll(d, n, axis)).mean() for n in shift for axis in (0, 1)] for d in drawn]
    )
    expected = 0.25 + np.arcsin(np.exp(-((shift * 0.25) ** 2) / 2)) / (2 * np.pi)
    error = both.std(axis=0) / np.sqrt(12)
    assert (np.abs(both.mean(axis=0) - expected.repeat(2)) < 4 * error + 1e-3).all()


@pytest.mark.parametrize(("points", "fewer"), [(64, 32), (50, 25), (33, 16)])
def test_noise_on_fewer_points_has_the_same_long_waves(points, fewer):
    white = np.random.default_rng(4).standard_normal((points, points))
    coarse = halved(white)
    assert coarse.shape == (fewer, fewer)
    waves, expected = np.fft.fft2(coarse) / fewer, np.fft.fft2(white) / points
    for n in range((1 - fewer) // 2 + 1, fewer // 2):
        for m in range((1 - fewer) // 2 + 1, fewer // 2):
            assert waves[n, m] == pytest.approx(expected[n, m], abs=1e-12)


@pytest.mark.parametrize("points", [16, 15])
def test_a_wave_of_noise_becomes_one_with_its_amplitude(points):
    # white noise on n² points has n²/2 in each of a wave's two modes if it is the cosine: z is n a cos
    amplitude = np.zeros((points, points))
    amplitude[2, 3] = amplitude[-2, -3] = 0.25
    place = np.arange(points)
    wave = np.cos(2 * np.pi * (2 * place[:, None] + 3 * place) / points)
    np.testing.assert_allclose(heights(amplitude, wave), points * 0.25 * wave, atol=1e-12)


def test_drawn_heights_have_the_variance_of_their_waves():
    rng = np.random.default_rng(5)
    amplitude = np.abs(rng.standard_normal((33, 33)))
    amplitude += amplitude[np.ix_(-np.arange(33) % 33, -np.arange(33) % 33)]
    amplitude /= np.linalg.norm(amplitude)
    z = np.stack([heights(amplitude, rng.standard_normal((33, 33))) for _ in range(40)])
    assert np.mean(z**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / 40 * np.sum(amplitude**4)))


def test_the_pressure_is_highest_where_the_field_is():
    z = np.array([[0.3, -1.2, 2.0], [0.1, -0.4, 0.9]])
    pressure = ranked(z, np.array([0.0, 0.0, 1.0, 2.0, 3.0, 5.0]))
    assert pressure.tolist() == [[2.0, 0.0, 5.0], [1.0, 0.0, 3.0]]


def test_equal_shares_of_the_area_have_the_pressure_of_their_middles():
    steps = np.array([-0.02, 0.02]), np.array([1.0, 2.0])
    field = clipped.ClippedField(*steps, np.ones(1), np.ones(1), 1.0, clipped.products(*steps))
    assert field.ascending(1).tolist() == [1.0]  # z = 0
    assert field.ascending(3).tolist() == [0.0, 1.0, 3.0]
