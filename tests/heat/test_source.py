"""T_flash, T_av and T_max of Hertz, disc and square sources on the free half-space, steady and from rest."""

import json
from math import inf, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from heat_cases import pixel_influence
from some_rows import some

from roughsim import Grid, half_space_temperature
from roughsim.heat import source_temperature
from roughsim.heat.influence import PixelAxis, buried, temperature_at
from theory import hertz

REFERENCE = Path(__file__).parents[1] / "reference"
TRANSIENTS = json.loads((REFERENCE / "transients.json").read_text())
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
PECLET = [0.0, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5]
RESOLUTION = [(8, 0.01), (32, 0.001)]  # pixels per radius, relative error


def square_of_distance(pixels, parts=1):
    """r² at the centres of the pixels, or of parts of them, and the grid of the pixels."""
    count = 2 * (pixels + 1)
    x = (np.arange(count * parts) - (count * parts - 1) / 2) / pixels / parts
    return x[:, None] ** 2 + x**2, Grid((count, count), (count / pixels,) * 2)


def hertz_source(pixels):
    """Flux and covered share of each pixel, as means over 16² parts."""
    square, grid = square_of_distance(pixels, 16)
    shape = (grid.shape[0], 16, grid.shape[1], 16)
    flux = np.sqrt(np.maximum(1 - square, 0.0)).reshape(shape).mean((1, 3))
    return flux, (square < 1).reshape(shape).mean((1, 3)), grid


def hertz_at_centres(pixels, shift=(0.0, 0.0)):
    """Flux at the centres of the pixels; the source stands `shift` pixels off the middle."""
    _, grid = square_of_distance(pixels)
    x, y = ((np.arange(grid.shape[0]) - (grid.shape[0] - 1) / 2 + s) / pixels for s in shift)
    return np.sqrt(np.maximum(1 - x[:, None] ** 2 - y**2, 0.0)), grid


def flash_at_centres(flux, grid, **heat):
    """T_flash = Σ T q̇/Σ q̇ over the centres."""
    return (half_space_temperature(flux, grid, **heat) * flux).sum() / flux.sum()


def disc_source(pixels):
    """A disc of whole pixels, and the radius of the disc of the same area.

    Shares of pixels at the rim would smear heat over the whole of them: at high speed that costs 0.2 % at 32 pixels.
    """
    square, grid = square_of_distance(pixels)
    return square < 1, sqrt((square < 1).sum() / pi) / pixels, grid


def square_source(pixels):
    _, grid = square_of_distance(pixels)
    flux = np.zeros(grid.shape)
    flux[1:-1, 1:-1] = 1.0
    return flux, grid


def place(source, grid):
    """Hottest point from the middle of the grid."""
    return [
        p - (length - step) / 2
        for p, length, step in zip(source.hottest_point, grid.lengths, grid.spacing, strict=True)
    ]


# exact values, steady


@pytest.mark.parametrize("peclet", some(PECLET, 2))
@pytest.mark.parametrize(("pixels", "tolerance"), RESOLUTION)
def test_the_hertz_source_has_its_three_temperatures(peclet, pixels, tolerance):
    flux, covered, grid = hertz_source(pixels)
    source = source_temperature(flux, grid, speed=peclet, covered=covered, **UNIT)
    assert source.flash_temperature == pytest.approx(hertz.flash_temperature(peclet), rel=tolerance)
    assert source.mean_temperature == pytest.approx(hertz.mean_temperature(peclet), rel=tolerance)
    assert source.max_temperature == pytest.approx(hertz.max_temperature(peclet), rel=tolerance)
    assert place(source, grid) == pytest.approx(
        [hertz.hottest_point(peclet), 0.0], abs=0.75 / pixels
    )


@pytest.mark.parametrize("peclet", some(PECLET, 2))
@pytest.mark.parametrize(("pixels", "tolerance"), RESOLUTION)
def test_the_disc_has_its_three_temperatures(peclet, pixels, tolerance):
    flux, radius, grid = disc_source(pixels)
    source = source_temperature(flux, grid, speed=peclet, **UNIT)
    mean, top = (
        hertz.disc_mean_temperature(peclet * radius),
        hertz.disc_max_temperature(peclet * radius),
    )
    assert source.flash_temperature == pytest.approx(radius * mean, rel=tolerance)
    assert source.mean_temperature == pytest.approx(source.flash_temperature, rel=1e-13)
    assert source.max_temperature == pytest.approx(radius * top, rel=tolerance)


@pytest.mark.parametrize("peclet", some(PECLET, 2))
@pytest.mark.parametrize("pixels", [8, 32])
def test_the_square_is_exact_at_any_resolution(peclet, pixels):
    flux, grid = square_source(pixels)
    source = source_temperature(flux, grid, speed=peclet, **UNIT)
    assert source.flash_temperature == pytest.approx(
        hertz.square_mean_temperature(peclet), rel=1e-8
    )
    assert source.mean_temperature == pytest.approx(source.flash_temperature, rel=1e-13)
    # samples half a pixel apart miss a smooth maximum by less than (pixel/4)²; at high speed the search finds it
    smooth = peclet / pixels <= 0.25
    tolerance = 1 / (4 * pixels) ** 2 if smooth else 1e-5
    assert source.max_temperature == pytest.approx(
        hertz.square_max_temperature(peclet), rel=tolerance
    )
    if not smooth:
        behind = (
            1 + place(source, grid)[0]
        )  # the trailing edge is colder: the hottest point lies some D/v before it
        assert behind == pytest.approx(1 + hertz.square_hottest_point(peclet), rel=0.2)


@pytest.mark.parametrize("peclet", [100.0, 1e4])
def test_centres_of_pixels_miss_the_hottest_point(peclet):
    # why: T rises as the root of the length passed, and the last centre is half a pixel short of the edge
    flux, grid = square_source(8)
    centres = half_space_temperature(flux, grid, speed=peclet, **UNIT).max()
    assert centres / hertz.square_max_temperature(peclet) - 1 == pytest.approx(
        -1 / 64 if peclet > 1e3 else -0.008, rel=0.1
    )


# from rest


@pytest.mark.parametrize(
    "case", some(TRANSIENTS, 3), ids=lambda c: f"Pe {c['peclet']:g} Fo {c['fourier_number']:g}"
)
def test_a_square_from_rest_is_exact_at_any_resolution(case):
    flux, grid = square_source(8)
    heat = {"speed": case["peclet"], "time": case["fourier_number"]} | UNIT
    assert source_temperature(flux, grid, **heat).flash_temperature == pytest.approx(
        case["square_mean"], rel=1e-8
    )
    x, y = (
        PixelAxis(3, 2.0, p, s) for p, s in ((case["peclet"], -0.5), (0.0, 0.0))
    )  # the square as one pixel
    only = np.zeros((3, 3))
    only[1, 1] = 1.0
    edge = temperature_at((1, 1), only, x, y, fading=buried(0.0), end=sqrt(case["fourier_number"]))
    assert edge == pytest.approx(case["square_trailing_edge"], rel=2e-9)
    centre = half_space_temperature(only, Grid((3, 3), (6.0, 6.0)), **heat)[1, 1]
    assert centre == pytest.approx(case["square_centre"], rel=2e-9)


@pytest.mark.parametrize(
    "case", TRANSIENTS, ids=lambda c: f"Pe {c['peclet']:g} Fo {c['fourier_number']:g}"
)
@pytest.mark.parametrize(("pixels", "tolerance"), RESOLUTION)
@pytest.mark.parametrize("shift", some([(0.2, 0.4), (0.0, 0.0), (0.5, 0.5)], pairs=True))
def test_a_hertz_source_given_at_the_centres_has_its_flash_temperature_from_rest(
    case, pixels, tolerance, shift
):
    flux, grid = hertz_at_centres(pixels, shift)
    flash = flash_at_centres(flux, grid, speed=case["peclet"], time=case["fourier_number"], **UNIT)
    assert flash == pytest.approx(case["hertz_flash"], rel=tolerance)


@pytest.mark.parametrize("peclet", PECLET)
@pytest.mark.parametrize(("pixels", "tolerance"), [(8, 0.4e-2), (32, 0.4e-3)])
def test_and_steady(peclet, pixels, tolerance):
    for shift in ((0.0, 0.0), (0.5, 0.5), (0.2, 0.4)):
        flash = flash_at_centres(*hertz_at_centres(pixels, shift), speed=peclet, **UNIT)
        assert flash == pytest.approx(hertz.flash_temperature(peclet), rel=tolerance)


@pytest.mark.parametrize("pixels", [8, 32])
def test_young_heat_sees_the_flux_itself_so_that_means_over_pixels_lose_its_variance(pixels):
    # T = 2 q̇ √(t/π) at each point: T_flash ~ ⟨q̇²⟩/⟨q̇⟩, and ∫q̇² = π/2, ∫q̇ = 2π/3 for the Hertz source
    flux, _, grid = hertz_source(pixels)
    time = 1e-8 / pixels**2
    flash = flash_at_centres(flux, grid, speed=1.0, time=time, **UNIT) / (2 * sqrt(time / pi))
    lost = 1 - (flux**2).sum() / flux.sum() / 0.75
    assert flash == pytest.approx(0.75 * (1 - lost), rel=1e-9)
    assert lost == pytest.approx(0.0103 if pixels == 8 else 0.00086, rel=0.02)


@pytest.mark.parametrize(
    "case", some(TRANSIENTS, 3), ids=lambda c: f"Pe {c['peclet']:g} Fo {c['fourier_number']:g}"
)
@pytest.mark.parametrize(("pixels", "tolerance"), RESOLUTION)
def test_a_disc_of_whole_pixels_from_rest_is_as_hot_as_its_rim_allows(case, pixels, tolerance):
    disc, radius, grid = disc_source(pixels)
    speed, time = case["peclet"], case["fourier_number"]
    source = source_temperature(disc, grid, speed=speed / radius, time=time * radius**2, **UNIT)
    young = 1.5 if sqrt(time) < 1.1 / pixels else 1.0  # see below
    assert source.mean_temperature == pytest.approx(
        radius * case["disc_mean"], rel=young * tolerance
    )


@pytest.mark.parametrize("pixels", [8, 32])
def test_young_heat_leaves_over_the_steps_of_the_rim_which_are_longer_than_the_circle(pixels):
    # a straight edge of length S loses the share S √(Dt)/(2√π A): 8R of steps instead of 2πR, whatever the solver
    disc, radius, grid = disc_source(pixels)
    time = (0.01 / pixels) ** 2
    mean = source_temperature(disc, grid, speed=0.0, time=time, **UNIT).mean_temperature
    steps = (
        np.abs(np.diff(disc.astype(int), axis=0)).sum()
        + np.abs(np.diff(disc.astype(int), axis=1)).sum()
    )
    lost = steps / pixels * sqrt(time) / (2 * sqrt(pi) * pi * radius**2)
    assert 1 - mean / (2 * sqrt(time / pi)) == pytest.approx(lost, rel=0.01)
    assert steps == 8 * pixels


@pytest.mark.parametrize(
    "case", TRANSIENTS, ids=lambda c: f"Pe {c['peclet']:g} Fo {c['fourier_number']:g}"
)
def test_no_source_from_rest_is_hotter_than_steady(case):
    # the influence of older heat is positive: a check of the reference itself
    steady = hertz.flash_temperature(case["peclet"]), hertz.disc_mean_temperature(case["peclet"])
    assert case["hertz_flash"] <= steady[0] * (1 + 1e-12)
    assert case["disc_mean"] <= steady[1] * (1 + 1e-12)
    assert case["square_mean"] <= hertz.square_mean_temperature(case["peclet"]) * (1 + 1e-12)


# symmetries


@pytest.mark.parametrize("speed", [0.0, 3.0, 400.0])
def test_turned_and_mirrored_sources_are_as_hot(speed):
    flux, grid = np.random.default_rng(1).random((9, 12)), Grid((9, 12), (2.0, 1.5))
    there = source_temperature(flux, grid, speed=speed, **UNIT)
    back = source_temperature(flux[::-1], grid, speed=-speed, **UNIT)
    turned = source_temperature(
        flux.T, Grid((12, 9), (1.5, 2.0)), speed=speed, direction=pi / 2, **UNIT
    )
    for other in (back, turned):
        for name in ("flash_temperature", "mean_temperature", "max_temperature"):
            assert getattr(other, name) == pytest.approx(getattr(there, name), rel=1e-9)
    if speed:  # at rest the two sides of a pixel may tie
        i, j = there.hottest_point
        assert turned.hottest_point == pytest.approx((j, i), abs=1e-12)
        assert back.hottest_point == pytest.approx((8 * 2.0 / 9 - i, j), abs=1e-12)


@pytest.mark.parametrize("direction", [0.4, 2.0, -2.8])
def test_no_point_of_an_oblique_source_is_hotter(direction):
    flux, grid, drift = np.random.default_rng(2).random((6, 5)), Grid((6, 5), (6.0, 5.0)), 12.0
    source = source_temperature(flux, grid, speed=drift, direction=direction, **UNIT)
    parts = 48  # of a pixel: points that finely spaced, from the same source on smaller pixels
    fine = np.kron(flux, np.ones((parts, parts)))
    field = half_space_temperature(
        fine, Grid(fine.shape, grid.lengths), speed=drift, direction=direction, **UNIT
    )
    assert field.max() < source.max_temperature * (1 + 1e-3)
    assert field.max() == pytest.approx(source.max_temperature, rel=2e-3)
    mean = (field.reshape(6, parts, 5, parts).mean((1, 3)) * flux).sum() / flux.sum()
    assert source.flash_temperature == pytest.approx(mean, rel=2e-4)
    assert source.mean_temperature == pytest.approx(field.mean(), rel=2e-4)


@pytest.mark.parametrize("shift", [-0.5, -0.2, 0.0, 0.49, 0.5])
@pytest.mark.parametrize("drift", [(0.0, 0.0), (1e-7, 0.0), (2.0, -1.0), (-300.0, 40.0)])
def test_the_sum_over_pixels_is_the_same_with_influences(shift, drift):
    flux = np.random.default_rng(3).random((5, 4))
    x, y = PixelAxis(5, 1.0, drift[0], shift), PixelAxis(4, 0.7, drift[1], -shift)
    for end in (inf, 0.8):
        influence = pixel_influence(x, y, fading=buried(0.1), end=end)
        expected = (flux * influence[4 + 3 - np.arange(5)[:, None], 3 + 1 - np.arange(4)]).sum()
        actual = temperature_at((3, 1), flux, x, y, fading=buried(0.1), end=end)
        assert actual == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("shift", [-0.5, -0.2, 0.3])
@pytest.mark.parametrize("drift", [5e-4, 7.0, 300.0, -1e4])
def test_a_point_of_a_large_pixel_is_an_edge_of_small_ones(drift, shift):
    # one heated pixel as 10 × 10 small ones: its edges and inner points are edges of those
    x, y = PixelAxis(3, 1.0, drift, shift), PixelAxis(2, 1.0, 0.0, 0.05)
    influence = pixel_influence(x, y, fading=buried(0.0), end=inf)
    small = pixel_influence(
        PixelAxis(40, 0.1, drift, 0.5), PixelAxis(30, 0.1, 0.0), fading=buried(0.0), end=inf
    )
    for k in (-1, 0, 1):
        at = round(10 * (k + shift)) - 1  # the small pixel of which that is the upper edge
        rows = [39 + at - i for i in range(-5, 5)]
        columns = [29 - j for j in range(-5, 5)]
        expected = small[np.ix_(rows, columns)].sum()
        assert influence[2 + k, 1] == pytest.approx(expected, rel=0, abs=3e-9 * influence.max())


@pytest.mark.parametrize("drift", some([0.0, 1e-7, 0.6, 50.0], 2))
def test_the_mean_over_a_pixel_is_the_mean_of_its_points(drift):
    nodes, weights = np.polynomial.legendre.leggauss(20)
    axes = [PixelAxis(3, 1.0, drift, averaged=True), PixelAxis(2, 1.3, 0.3 * drift, averaged=True)]
    mean = pixel_influence(*axes, fading=buried(0.2), end=inf)  # buried, for a smooth influence
    expected = sum(
        wx
        * wy
        / 4
        * pixel_influence(
            PixelAxis(3, 1.0, drift, sx / 2),
            PixelAxis(2, 1.3, 0.3 * drift, sy / 2),
            fading=buried(0.2),
            end=inf,
        )
        for sx, wx in zip(nodes, weights, strict=True)
        for sy, wy in zip(nodes, weights, strict=True)
    )
    np.testing.assert_allclose(mean, expected, rtol=0, atol=2e-8 * mean.max())


def test_steel_in_si_units_is_the_unit_problem_scaled():
    flux, metre, steel = (
        np.random.default_rng(4).random((7, 6)),
        3e-6,
        {"conductivity": 30.0, "diffusivity": 7.6e-6},
    )
    unit = {"speed": 2.0, "time": 0.9, "depth": 0.2, "direction": 1.0} | UNIT
    plain = source_temperature(flux, Grid((7, 6), (3.0, 4.0)), **unit)
    there = {
        "speed": 2.0 * 7.6e-6 / metre,
        "time": 0.9 * metre**2 / 7.6e-6,
        "depth": 0.2 * metre,
        "direction": 1.0,
    }
    real = source_temperature(4e8 * flux, Grid((7, 6), (3 * metre, 4 * metre)), **there, **steel)
    for name in ("flash_temperature", "mean_temperature", "max_temperature"):
        assert getattr(real, name) == pytest.approx(
            getattr(plain, name) * 4e8 * metre / 30.0, rel=1e-11
        )
    assert real.hottest_point == pytest.approx([metre * p for p in plain.hottest_point], rel=1e-9)
    # the same source on pixels half as long
    finer = source_temperature(np.repeat(flux, 2, axis=0), Grid((14, 6), (3.0, 4.0)), **unit)
    assert finer.flash_temperature == pytest.approx(plain.flash_temperature, rel=1e-8)
    assert finer.mean_temperature == pytest.approx(plain.mean_temperature, rel=1e-8)


def test_depth_cools():
    flux, grid = square_source(4)
    values = [
        source_temperature(flux, grid, speed=5.0, depth=z, **UNIT).max_temperature
        for z in (0.0, 0.1, 1.0)
    ]
    assert values == sorted(values, reverse=True)
    # far below, κT = Q/2πz of the resting square with 4 units of heat
    deep = source_temperature(flux, grid, speed=0.0, depth=40.0, **UNIT).max_temperature
    assert deep == pytest.approx(4 / (2 * pi * 40.0), rel=1e-3)
