"""What a camera sees of one contact: against the theory's own integrals, and against pictures by hand."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from roughsim import Grid, HeatSource, sliding_temperature
from roughsim.heat.camera import Lens
from roughsim.heat.periodic import MovingSource
from roughsim.observables import camera
from roughsim.observables.camera import Camera
from roughsim.observables.record import Sample
from theory.camera import View, seen_rms, seen_width

DIFFUSIVITY = 7.6e-6
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": DIFFUSIVITY}
LOOKS = {
    "sharp": Lens(),
    "blurred": Lens(resolution=30e-6),
    "smeared": Lens(30e-6, 1e-3),
    "behind": Lens(30e-6, 0.0, 1e-4, 1e-3),
    "endless": Lens(0.0, 0.0, 1e-5),
}
GRID = Grid((128, 96), (2e-3, 1.5e-3))


class Band:
    """|σ_q|² = 1e4 Pa² m² from 2e4 to 8e4 rad/m."""

    breaks = (2e4, 8e4)

    def __call__(self, q):
        return np.full(np.shape(q), 1e4)


def nodes():
    """Wavenumbers, and the variance of the stress at each."""
    x, weight = np.polynomial.legendre.leggauss(200)
    q = 5e4 + 3e4 * x
    return q, 2 * pi * q * 1e4 * 3e4 * weight


@pytest.mark.parametrize("slid", [inf, 1e-3])
@pytest.mark.parametrize("name", LOOKS)
def test_means_over_directions_are_the_theory(name, slid):
    lens, (q, variance) = LOOKS[name], nodes()
    length = min(lens.contact_length, slid)
    view = View(lens.resolution, lens.smear, slid, lens.behind, length)
    for speed in (1e-3, 0.3, 35.0):
        rate = speed / DIFFUSIVITY
        source = MovingSource((rate, 0.0), slid / rate, lens=lens._replace(contact_length=length))
        seen = Camera((source,), (0.11 * speed / 30.0,))
        sample = Sample(inf, 0, np.arange(1), {}, q, variance[None], 1e-3)
        stress = {"stress_spectrum": Band(), "nominal_pressure": 1e8, "view": view}
        rms, width = seen_rms(speed, **stress, **HEAT), seen_width(speed, **stress, **HEAT)
        assert camera.seen_rms(sample, seen)[0, 0] == pytest.approx(rms, rel=1e-5)
        if width < 8e-4:  # within the reach of the sample
            assert camera.seen_width(sample, seen)[0, 0] == pytest.approx(width, rel=1e-3)


def field(speed, lens=None, slid=inf, pressure=None):
    """The picture of a pressure, K of 1 W/(m K), by the code under test."""
    source = HeatSource([speed], 1.0, 1.0, DIFFUSIVITY)
    rate = speed / DIFFUSIVITY
    seen = Camera((MovingSource((rate, 0.0), slid / rate, lens=lens),), (speed,))
    return camera.pictures(contact() if pressure is None else pressure, GRID, source, seen)[0]


def contact():
    """A smooth pressure without a direction."""
    rough = np.random.default_rng(3).standard_normal(GRID.shape)
    return np.maximum(gaussian_filter(rough, 3, mode="wrap"), 0.0)


def test_a_sharp_picture_is_the_temperature():
    pressure = contact()
    for slid in (2e-4, 1e-3):
        exact = sliding_temperature(
            pressure / pressure.mean(),
            GRID,
            speed=1.0,
            conductivity=1.0,
            diffusivity=DIFFUSIVITY,
            slid_distance=slid,
        )
        np.testing.assert_allclose(field(1.0, Lens(), slid), exact, atol=1e-5 * exact.max())
    assert field(1.0, Lens()) == pytest.approx(field(1.0, Lens(), 1e-3))  # at most half the cell


def test_a_blurred_picture_is_a_mean_over_pixels():
    b = 60e-6 / sqrt(8 * np.log(2)) / GRID.spacing[0]
    blurred = gaussian_filter(np.float64(field(1.0)), b, mode="wrap", truncate=8)
    np.testing.assert_allclose(field(1.0, Lens(60e-6)), blurred, atol=1e-4 * blurred.max())


def test_an_exposure_is_a_mean_over_places():
    # Simpson's rule over 16 pixels along sliding
    sharp, weights = np.float64(field(1.0)), np.array([1] + [4, 2] * 7 + [4, 1]) / 48
    shifts = zip(range(-8, 9), weights, strict=True)
    mean = sum(weight * np.roll(sharp, shift, axis=0) for shift, weight in shifts)
    smeared = field(1.0, Lens(smear=16 * GRID.spacing[0]))
    np.testing.assert_allclose(smeared, mean, atol=2e-3 * mean.max())


def test_a_line_behind_sums_the_heat_of_all_ages():
    # a wave cos(q·x) of heat over d < u < d + ℓ: ∫ cos(q_x(x + u) + q_y y) e^(−q_y²Du/v) (πDu/v)^(−1/2) D/v du
    speed, d, length, (i, j) = 5.0, 1e-4, 4e-4, (3, 2)
    qx, qy = 2 * pi * i / GRID.lengths[0], 2 * pi * j / GRID.lengths[1]
    x, y = (np.arange(n) * step for n, step in zip(GRID.shape, GRID.spacing, strict=True))
    wave = 1 + np.cos(qx * x[:, None] + qy * y)
    s, weight = np.polynomial.legendre.leggauss(60)
    u, weight = d + length * (1 + s) / 2, weight * length / 2
    spread = DIFFUSIVITY / speed
    decay = weight * np.exp(-(qy**2) * spread * u) * np.sqrt(spread / (pi * u))
    exact = sum(
        part * np.cos(qx * (x[:, None] + age) + qy * y) for age, part in zip(u, decay, strict=True)
    )
    lens = Lens(behind=d, contact_length=length)
    np.testing.assert_allclose(field(speed, lens, pressure=wave), exact, atol=1e-5 * exact.max())


def test_one_percent_of_a_wave_is_hotter_than_its_cosine():
    # a cosine exceeds cos(π/100) on 1 % of its length; its rms is 1/√2
    wave = 1 + np.cos(2 * pi * np.arange(1000) / 1000)[:, None] * np.ones(4)
    grid = Grid((1000, 4), (1e-3, 4e-6))
    seen = Camera((MovingSource((1e-3, 0.0), inf, lens=Lens()),), (1.0,))
    source = HeatSource([1e-3 * DIFFUSIVITY], 1.0, 1.0, DIFFUSIVITY)
    got = camera.hottest_over_rms(wave, grid, source, seen)
    assert got == pytest.approx(sqrt(2) * np.cos(pi / 100), rel=1e-4)


@pytest.mark.parametrize(("smear", "older"), [(1.1e-3, False), (0.9e-3, True)])
def test_an_exposure_longer_than_the_slide_has_no_older_heat(smear, older):
    # the picture slides 1 mm, half of the cell
    rate, lens = 1.0 / DIFFUSIVITY, Lens(smear=smear)
    seen = Camera((MovingSource((rate, 0.0), inf, lens=lens),), (1.0,))
    got = camera.hottest_over_rms(contact(), GRID, HeatSource([1.0], 1.0, 1.0, DIFFUSIVITY), seen)
    picture = np.float64(field(1.0, lens))
    own = np.quantile(picture, 0.99) / picture.std()
    assert (got[0] == pytest.approx(own, rel=1e-4)) != older


def test_a_uniform_contact_makes_a_picture_of_nothing():
    source, seen = HeatSource([1.0], 1.0, 1.0, 1e-5), Camera((MovingSource((1e5, 0.0)),), (1.0,))
    assert camera.hottest_over_rms(np.ones(GRID.shape), GRID, source, seen) == [0.0]


def test_a_correlation_that_never_halves_has_no_width():
    y = camera.distances(1e-3)
    assert np.isnan(camera.widths(np.ones((2, y.size)), y)).all()


def test_a_picture_blurred_beyond_its_cell_is_unknown():
    source = MovingSource((1e5, 0.0), lens=Lens(resolution=1.0))
    seen, heat = Camera((source,), (1.0,)), HeatSource([1e5 * DIFFUSIVITY], 1.0, 1.0, DIFFUSIVITY)
    assert np.isnan(camera.hottest_over_rms(contact(), GRID, heat, seen)).all()
    q, variance = nodes()
    sample = Sample(inf, 0, np.arange(1), {}, q, variance[None], 1e-3)
    assert np.isnan(camera.seen_rms(sample, seen)).all()


@pytest.mark.parametrize(
    ("blur", "seen"), [(0.1, 0.990000), (0.3, 0.910144), (1.0, 0.483941), (3.0, 0.175361)]
)
def test_a_blurred_hertz_contact_at_rest_has_its_exact_centre(blur, seen):
    # at rest T(0) = πq̇₀R/4κ on the free half-space; what blur takes away falls as b²/r³: a cell of 43R adds 3e-4
    radius, grid = 12, Grid((512, 512), (512.0, 512.0))
    x = np.arange(512) - 256
    fine = (np.arange(8) - 3.5) / 8  # a pixel holds the mean heat on it
    flux = np.zeros(grid.shape)
    for i in fine:
        for j in fine:
            square = ((x + i)[:, None] ** 2 + (x + j) ** 2) / radius**2
            flux += np.sqrt(np.maximum(1 - square, 0.0)) / 64
    source = HeatSource([1e-9], 1.0, 1.0, 1.0)
    centres = []
    for lens in (Lens(), Lens(blur * radius * sqrt(8 * np.log(2)))):
        look = Camera((MovingSource((1e-9, 0.0), inf, lens=lens),), (1.0,))
        (picture,) = camera.pictures(flux, grid, source, look)
        centres.append(float(picture[256, 256]) * flux.mean())
    lost = (centres[0] - centres[1]) / (pi * radius / 4)
    assert 1 - lost == pytest.approx(seen, abs=1e-3)


def test_older_heat_makes_the_picture_less_pointed():
    # a short cell shows what a strip shows on which the contact has slid 32 times as far; without older heat + 8 %
    def fields(shape, count):
        step, rng = 2e-3 / 128, np.random.default_rng(2)
        q = (
            2
            * pi
            * np.hypot(*np.meshgrid(*(np.fft.fftfreq(n, step) for n in shape), indexing="ij"))
        )
        root = np.where((q > 6350) & (q < 1e5), np.maximum(q, 2e4) ** -1.8, 0.0)
        for _ in range(count):
            wave = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * root).real
            yield np.float64(wave > np.quantile(wave, 0.91))

    def mean(shape, count):
        grid = Grid(shape, tuple(n * 2e-3 / 128 for n in shape))
        seen = Camera((MovingSource((35.0 / DIFFUSIVITY, 0.0), lens=Lens()),), (1.0,))
        heat = HeatSource([35.0], 1.0, 1.0, DIFFUSIVITY)
        return np.mean(
            [camera.hottest_over_rms(one, grid, heat, seen) for one in fields(shape, count)]
        )

    assert mean((128, 128), 16) == pytest.approx(mean((4096, 128), 2), rel=0.02)


def test_normal_numbers_add_by_their_variances():
    # 1 % of normally distributed numbers is above 2.3263 standard deviations
    normal = np.random.default_rng(5).standard_normal((700, 700))
    for spread in (0.0, 0.3, 2.0):
        exact = 2.326348 * sqrt(1 + spread**2)
        assert camera._exceeded(normal, spread) == pytest.approx(exact, rel=5e-3)
