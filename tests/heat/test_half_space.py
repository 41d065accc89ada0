"""Heat on the free half-space: the influence of a pixel, and the exact values of Hertz, disc and square sources."""

import json
from math import asinh, cos, erf, exp, inf, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from heat_cases import pixel_influence
from some_rows import some

from roughsim import Grid, half_space_temperature, sliding_temperature
from roughsim.fourier import convolution
from roughsim.heat import uniform_temperature
from roughsim.heat.influence import PixelAxis, buried
from theory import hertz

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "half_space.json").read_text())[
    "pixels"
]
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
PECLET = [0.0, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5]


def plane(pixels_per_radius, margin=1):
    count = 2 * (pixels_per_radius + margin)
    x = (np.arange(count) - (count - 1) / 2) / pixels_per_radius
    return x[:, None], x, Grid((count, count), (count / pixels_per_radius,) * 2)


def pixel_means(x, y, function):
    """Mean of a function of the squared distance over each pixel, from 16² points."""
    fine = (np.arange(16) - 7.5) / 16 * (y[1] - y[0])
    return function(
        (x[:, :, None, None] + fine[:, None]) ** 2 + (y[:, None, None] + fine) ** 2
    ).mean((2, 3))


def hertz_source(pixels_per_radius):
    x, y, grid = plane(pixels_per_radius)
    return pixel_means(x, y, lambda square: np.sqrt(np.maximum(1 - square, 0.0))), grid


@pytest.mark.parametrize(
    "case", REFERENCE, ids=lambda c: f"{c['offset']} p={c['drift']:g} z={c['depth']:g}"
)
def test_a_pixel_heats_the_others_as_moving_point_sources_do(case):
    pixel, drift, direction, (i, j) = (
        case["pixel"],
        case["drift"],
        case["direction"],
        case["offset"],
    )
    x, y = (
        PixelAxis(7, pixel[0], drift * cos(direction)),
        PixelAxis(6, pixel[1], drift * sin(direction)),
    )
    end = inf if case["spread"] is None else sqrt(case["spread"])
    influence = pixel_influence(x, y, fading=buried(case["depth"]), end=end)
    assert influence.shape == (13, 11)
    assert influence[6 + i, 5 + j] == pytest.approx(
        case["influence"], rel=0, abs=1e-9 * influence[6, 5]
    )


@pytest.mark.parametrize(
    "case", [c for c in REFERENCE if c["drift"] in (3.0, 4.0, -4.0)], ids=lambda c: str(c["offset"])
)
def test_one_hot_pixel_of_steel_shows_its_influence(case):
    (i, j), pixel, metre = case["offset"], case["pixel"], 2e-6
    grid = Grid((9, 9), (9 * pixel[0] * metre, 9 * pixel[1] * metre))
    flux = np.zeros((9, 9))
    flux[4, 4] = 5e8
    time = inf if case["spread"] is None else case["spread"] * metre**2 / 7.6e-6
    sliding = {
        "speed": case["drift"] * 7.6e-6 / metre,
        "direction": case["direction"],
        "depth": case["depth"] * metre,
    }
    temperature = half_space_temperature(flux, grid, time=time, **sliding, **STEEL)
    assert temperature[4 + i, 4 + j] == pytest.approx(
        case["influence"] * metre * 5e8 / 30.0, rel=1e-8
    )


@pytest.mark.parametrize("peclet", some(PECLET, 2))
@pytest.mark.parametrize(("pixels", "tolerance"), [(8, 0.01), (32, 0.001)])
def test_the_hertz_source_is_right_at_any_peclet_number(peclet, pixels, tolerance):
    flux, grid = hertz_source(pixels)
    temperature = half_space_temperature(flux, grid, speed=peclet, **UNIT)
    x, y, _ = plane(pixels)
    covered = pixel_means(x, y, lambda square: square < 1)
    assert (temperature * flux).sum() / flux.sum() == pytest.approx(
        hertz.flash_temperature(peclet), rel=tolerance
    )
    assert (temperature * covered).sum() / covered.sum() == pytest.approx(
        hertz.mean_temperature(peclet), rel=tolerance
    )
    assert temperature.max() == pytest.approx(hertz.max_temperature(peclet), rel=tolerance)


def test_a_square_warms_from_rest_like_its_centre_line():
    # at rest the centre of a square of side 2 has κT = (2/√π) ∫ erf(1/2u)² du up to √(Dt)
    grid = Grid((33, 33), (2.0, 2.0))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for time in (1e-3, 0.1, 4.0):
        u = sqrt(time) * (nodes + 1) / 2
        exact = (
            2
            / sqrt(pi)
            * sum(
                w * sqrt(time) / 2 * erf(1 / (2 * v)) ** 2 for v, w in zip(u, weights, strict=True)
            )
        )
        actual = half_space_temperature(np.ones((33, 33)), grid, speed=0.0, time=time, **UNIT)
        assert actual[16, 16] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("depth", [0.0, 0.02])
def test_a_young_field_is_that_of_a_uniform_source(depth):
    actual = half_space_temperature(
        np.full((8, 9), 7.0), Grid((8, 9), (2.0, 3.0)), speed=3.0, time=1e-4, depth=depth, **UNIT
    )
    assert actual[4, 4] == pytest.approx(
        uniform_temperature(7.0, 1e-4, depth=depth, **UNIT), rel=1e-10
    )


def test_what_the_steady_state_has_more_is_the_heat_from_before_the_start():
    # long before the start the source was a point: κ dT = 2 q̇ a² D dt e^(−p²Dt/4)/(4πDt)^(3/2), and u = √(Dt)
    flux, grid, spread, drift = (
        np.random.default_rng(1).random((4, 3)),
        Grid((4, 3), (4.0, 6.0)),
        5000.0,
        2e-4,
    )
    steady, young = (
        half_space_temperature(flux, grid, speed=drift, time=t, **UNIT) for t in (inf, spread**2)
    )
    nodes, weights = np.polynomial.laguerre.laggauss(60)
    u = np.sqrt(spread**2 + 4 * nodes / drift**2)  # e^(−p²u²/4) is the weight
    older = (
        exp(-((drift * spread / 2) ** 2)) * 4 / drift**2 * np.sum(weights / u**3) / (4 * pi**1.5)
    )
    np.testing.assert_allclose(
        steady - young, 2.0 * flux.sum() * older, rtol=4 * drift
    )  # the wake, over 4 lengths


@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, 2.5), (3.0, 0.2)])
def test_a_resting_rectangle_is_exact_everywhere(sides):
    # κT = (1/2π) Σ ± [x asinh(y/x) + y asinh(x/y)] over its corners
    def corner(x, y):
        x, y = abs(x), abs(y)
        return x * asinh(y / x) + y * asinh(x / y)

    a, b = sides
    grid, flux = Grid((7, 5), (7 * a, 5 * b)), np.zeros((7, 5))
    flux[3, 2] = 1.0
    temperature = half_space_temperature(flux, grid, speed=0.0, **UNIT)
    for i in range(7):
        for j in range(5):
            x, y = (i - 3) * a, (j - 2) * b
            ends = [(s, t) for s in (-1, 1) for t in (-1, 1)]
            signs = [s * t * np.sign(x + s * a / 2) * np.sign(y + t * b / 2) for s, t in ends]
            exact = sum(
                c * corner(x + s * a / 2, y + t * b / 2)
                for c, (s, t) in zip(signs, ends, strict=True)
            )
            assert temperature[i, j] == pytest.approx(exact / (2 * pi), rel=1e-9)


@pytest.mark.parametrize("speed", [0.0, 1.0, 1e3, 1e6])
def test_nothing_is_colder_than_the_body(speed):
    # the influence of a pixel is positive: no edge undershoots, at any pixel Péclet number, beyond rounding
    flux = np.zeros((40, 40))
    flux[15:25, 15:25] = 1.0
    temperature = half_space_temperature(flux, Grid((40, 40), (4.0, 4.0)), speed=speed, **UNIT)
    assert temperature.min() > -1e-14 * temperature.max()


@pytest.mark.parametrize("side", [1, 2])
def test_a_patch_of_few_pixels_is_hot_as_a_disc_of_its_area_to_some_percent(side):
    # its shape is that of the grid: nothing better than 10 % may be read off a patch under 4 pixels
    radius, worst = side / sqrt(pi), 0.0
    flux = np.zeros((side + 2, side + 2))
    flux[1:-1, 1:-1] = 1.0
    for peclet in PECLET:
        temperature = half_space_temperature(
            flux, Grid(flux.shape, flux.shape), speed=peclet / radius, **UNIT
        )
        mean = temperature[1:-1, 1:-1].mean() / radius
        worst = max(worst, abs(mean / hertz.disc_mean_temperature(peclet) - 1))
    assert 0.02 < worst < 0.205


def test_a_response_does_not_depend_on_what_was_built_before():
    # buffers are shared by all influences of one padded length
    influence = np.random.default_rng(6).random((69, 69))
    expected = np.zeros((80, 80))
    expected[np.ix_(np.arange(-34, 35), np.arange(-34, 35))] = influence
    convolution.influence_spectrum(np.ones((79, 79)), 40, (80, 80), "d")
    response = convolution.influence_spectrum(influence, 35, (80, 80), "d")
    np.testing.assert_allclose(response, np.fft.rfft2(expected).T / 6400, rtol=0, atol=1e-15)


@pytest.mark.parametrize("shape", [(23, 31), (1, 37), (41, 1)])
def test_single_rows_and_primes_in_single_precision(shape):
    flux, grid = np.random.default_rng(5).random(shape), Grid(shape, (3.0, 7.0))
    heat = {"speed": 9.0, "direction": -0.6} | UNIT
    single = half_space_temperature(flux.astype(np.float32), grid, **heat)
    assert single.dtype == np.float32
    np.testing.assert_allclose(
        single, half_space_temperature(flux, grid, **heat), rtol=0, atol=3e-6 * single.max()
    )


def test_an_isothermal_disc_carries_four_kappa_radius():
    # q̇ = 2κΔT/π√(R² − r²) over a disc: Q = 4κRΔT; the singular edge converges at first order
    x, y, grid = plane(32)
    flux = pixel_means(
        x, y, lambda square: np.where(square < 1, 2 / pi / np.sqrt(np.abs(1 - square)), 0.0)
    )
    flux *= 4.0 / (flux.sum() / 32**2)
    temperature = half_space_temperature(flux, grid, speed=0.0, **UNIT)
    inside = (x**2 + y**2) < 0.8
    np.testing.assert_allclose(temperature[inside], 1.0, rtol=0.01)


def test_far_away_a_patch_is_a_moving_point():
    grid, drift = Grid((301, 3), (301.0, 3.0)), 0.05
    flux = np.zeros((301, 3))
    flux[150, 1] = 1.0
    temperature = half_space_temperature(flux, grid, speed=drift, **UNIT)
    for ahead in (-140, 30):
        exact = exp(-drift * (abs(ahead) + ahead) / 2) / (2 * pi * abs(ahead))
        assert temperature[150 + ahead, 1] == pytest.approx(exact, rel=3e-4)  # a pixel's quadrupole


@pytest.mark.parametrize("speed", [0.0, 1e-9, 1e-3, 1.0, 1e3, 1e6, 1e12])
@pytest.mark.parametrize("time", [inf, 1e-3])
def test_the_mirrored_source_leaves_the_mirrored_field(speed, time):
    flux = np.random.default_rng(4).random((11, 6))
    grid = Grid((11, 6), (2.0, 3.0))
    there = half_space_temperature(flux, grid, speed=speed, time=time, **UNIT)
    back = half_space_temperature(flux[::-1], grid, speed=-speed, time=time, **UNIT)
    turned = half_space_temperature(flux[::-1], grid, speed=speed, time=time, direction=pi, **UNIT)
    np.testing.assert_allclose(back[::-1], there, rtol=0, atol=1e-9 * there.max())
    np.testing.assert_allclose(turned[::-1], there, rtol=0, atol=1e-9 * there.max())
    side = half_space_temperature(
        flux.T, Grid((6, 11), (3.0, 2.0)), speed=speed, time=time, direction=pi / 2, **UNIT
    )
    np.testing.assert_allclose(side.T, there, rtol=0, atol=1e-9 * there.max())
    if speed:
        assert there[:5].sum() != pytest.approx(there[::-1][:5].sum(), rel=1e-13)


def test_the_wake_lies_behind():
    flux = np.zeros((9, 9))
    flux[4, 4] = 1.0
    temperature = half_space_temperature(flux, Grid((9, 9), (9.0, 9.0)), speed=2.0, **UNIT)
    assert temperature[3, 4] > 3 * temperature[5, 4] > 0


@pytest.mark.parametrize("drift", [1e3, 1e6, 1e9, 1e12])
def test_at_high_speed_each_line_along_sliding_keeps_its_heat(drift):
    # then κT = Σ over the pixels passed of 2/√(πp) (√(far edge) − √(near edge)), without spread across
    flux = np.random.default_rng(1).random((40, 3))
    actual = half_space_temperature(flux, Grid((40, 3), (40.0, 3.0)), speed=drift, **UNIT)
    edges = np.sqrt(np.maximum(np.arange(40) + np.array([[-0.5], [0.5]]), 0.0))
    passed = 2 / sqrt(pi * drift) * (edges[1] - edges[0])
    expected = np.array(
        [
            [sum(passed[k] * flux[i + k, j] for k in range(40 - i)) for j in range(3)]
            for i in range(40)
        ]
    )
    np.testing.assert_allclose(
        actual, expected, atol=0.4 * sqrt(40 / drift) * expected.max() + 1e-9
    )


@pytest.mark.parametrize("shape", [(1, 1), (1, 17), (13, 1), (2, 2), (5, 2), (7, 11)])
def test_any_shape_is_the_sum_over_its_pixels(shape):
    flux, grid = np.random.default_rng(2).random(shape), Grid(shape, (2.0, 5.0))
    settings = {"speed": 1.5, "direction": 0.4, "time": 0.7, "depth": 0.1} | UNIT
    actual = half_space_temperature(flux, grid, **settings)
    x, y = (
        PixelAxis(n, d, p)
        for n, d, p in zip(shape, grid.spacing, (1.5 * cos(0.4), 1.5 * sin(0.4)), strict=True)
    )
    influence = pixel_influence(x, y, fading=buried(0.1), end=sqrt(0.7))
    i, j = np.indices(shape)
    expected = sum(
        flux[k, m] * influence[i - k + shape[0] - 1, j - m + shape[1] - 1]
        for k in range(shape[0])
        for m in range(shape[1])
    )
    np.testing.assert_allclose(actual, expected, rtol=1e-12)


def test_times_stack_and_end_in_the_steady_state():
    flux, grid = hertz_source(8)
    times = np.array([0.0, 0.1, 1e12, inf])
    fields = half_space_temperature(flux, grid, speed=1.0, time=times, **UNIT)
    assert fields.shape == (4, *grid.shape)
    assert not fields[0].any()
    np.testing.assert_array_equal(
        fields[1], half_space_temperature(flux, grid, speed=1.0, time=0.1, **UNIT)
    )
    np.testing.assert_allclose(fields[2], fields[3], rtol=1e-5)
    assert (fields[1] < fields[3]).all()


def test_a_large_periodic_cell_comes_close_at_early_times():
    flux, _ = hertz_source(8)
    wide = Grid((72, 72), (9.0, 9.0))
    padded = np.zeros(wide.shape)
    padded[27:45, 27:45] = flux
    free = half_space_temperature(padded, wide, speed=3.0, time=0.2, **UNIT)
    periodic = sliding_temperature(padded, wide, speed=3.0, time=0.2, **UNIT)
    periodic += uniform_temperature(padded.mean(), 0.2, **UNIT)
    np.testing.assert_allclose(
        free, periodic, rtol=0, atol=4e-3 * free.max()
    )  # point samples against pixel means


def test_single_precision_stays_single():
    flux, grid = hertz_source(8)
    double = half_space_temperature(flux, grid, speed=10.0, **UNIT)
    single = half_space_temperature(flux.astype(np.float32), grid, speed=10.0, **UNIT)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, double, rtol=0, atol=3e-6 * double.max())
