"""The correlation of the stress and its radii, against mode sums and Bessel functions."""

from math import nan, pi, sqrt

import numpy as np
import pytest
from moments_cases import BODY, UNIT, Pressed, patches, plane, points
from scipy.optimize import brentq
from scipy.special import j0, j1, jv, jvp

from roughsim import Grid, HeatSource, measure
from roughsim.observables.moments import StressSpectrum
from roughsim.observables.stress_spectrum import first_root, further_derivatives


@pytest.mark.parametrize(
    "grid",
    [
        Grid((200, 200), (1e-3, 1e-3)),
        Grid((201, 160), (1.0, 1.0)),
        Grid((150, 150), (1.0, 2.5)),
        Grid((6, 7), (1.0, 1.0)),
    ],
    ids=lambda grid: f"{grid.shape} {grid.lengths}",
)
def test_the_stress_correlation_is_the_mode_sum_to_the_corner_of_the_cell(grid):
    pressure = patches(grid)
    seen = measure(Pressed(pressure), grid, HeatSource([1.0], **UNIT))
    qx, qy, variance = plane(pressure, grid)
    distance = np.linspace(0.0, 0.5 * np.hypot(*grid.lengths), 23)
    direct = [np.sum(variance * j0(np.hypot(qx, qy) * r)) for r in distance]
    np.testing.assert_allclose(
        seen.pressure_correlation(distance), direct, rtol=0, atol=1e-13 * direct[0]
    )
    assert seen.pressure_variance == pytest.approx(pressure.var(), rel=1e-13)  # Parseval


@pytest.mark.parametrize("order", [1, 3, 4, 5, 24, 25, 63, 64])
def test_the_correlation_of_a_single_wave_is_a_bessel_function(order):
    grid = Grid((128, 128), (1.0, 1.0))
    x, y = points(grid)
    seen = measure(Pressed(1 + np.cos(2 * pi * (order * x + y))), grid, HeatSource([1.0], **UNIT))
    q = 2 * pi * sqrt(order**2 + 1)
    distance = np.linspace(0.0, sqrt(0.5), 101)
    np.testing.assert_allclose(
        seen.pressure_correlation(distance), 0.5 * j0(q * distance), rtol=0, atol=1e-14
    )


def test_spectra_of_one_grid_may_be_averaged():
    grid = Grid((128, 128), (1.0, 1.0))
    spectra = [
        measure(Pressed(patches(grid, seed)), grid, HeatSource([1.0], **UNIT)).stress_spectrum
        for seed in (1, 2)
    ]
    np.testing.assert_array_equal(spectra[0].wavenumber, spectra[1].wavenumber)
    assert (np.diff(spectra[0].wavenumber) > 0).all()
    assert spectra[0].wavenumber.size < 700  # of 8 000 modes
    mean = StressSpectrum(
        spectra[0].wavenumber, (spectra[0].variance + spectra[1].variance) / 2, spectra[0].reach
    )
    both = [spectrum.pressure_correlation([0.01, 0.3]) for spectrum in spectra]
    np.testing.assert_allclose(
        mean.pressure_correlation([0.01, 0.3]), (both[0] + both[1]) / 2, rtol=1e-12
    )


def test_a_long_narrow_cell_keeps_its_few_modes():
    grid = Grid((4, 5), (1.0, 1e4))
    pressure = patches(grid)
    seen = measure(Pressed(pressure), grid, HeatSource([1.0], **UNIT))
    qx, qy, variance = plane(pressure, grid)
    assert seen.stress_spectrum.wavenumber.size == 8  # of (k_x, k_y) = 0 … 2 each, less q = 0
    direct = [np.sum(variance * j0(np.hypot(qx, qy) * r)) for r in (1e-3, 1.0, 4e3)]
    np.testing.assert_allclose(seen.pressure_correlation([1e-3, 1.0, 4e3]), direct, rtol=1e-12)


def test_a_small_grid_keeps_each_of_its_wavenumbers():
    grid = Grid((8, 8), (1.0, 1.0))  # 40 nodes would be more than its 14 wavenumbers
    seen = measure(Pressed(patches(grid)), grid, HeatSource([1.0], **UNIT)).stress_spectrum
    squares = sorted({i**2 + j**2 for i in range(5) for j in range(5)} - {0})
    np.testing.assert_allclose(seen.wavenumber, 2 * pi * np.sqrt(squares), rtol=1e-14)


def test_distances_keep_their_shape_and_end_at_half_the_diagonal():
    grid = Grid((16, 16), (3.0, 4.0))
    seen = measure(Pressed(patches(grid)), grid, HeatSource([1.0], **UNIT))
    assert seen.pressure_correlation(0.5).shape == ()
    assert seen.pressure_correlation([[0.5, 2.5]]).shape == (1, 2)
    for wrong in (2.51, -0.1, nan):
        with pytest.raises(
            ValueError,
            match=r"r = .* m must lie between 0 and half the diagonal of the cell, 2.5 m",
        ):
            seen.pressure_correlation([0.1, wrong])
    with pytest.raises(TypeError, match="r has dtype"):
        seen.pressure_correlation("far")


@pytest.mark.parametrize("fraction", [0.0, 0.1, 0.5, 0.999])
def test_the_radius_of_a_single_wave_inverts_the_bessel_function(fraction):
    grid = Grid((64, 64), (1e-3, 1e-3))
    q = 2 * pi * 5 / 1e-3
    seen = measure(
        Pressed(1e9 * (1 + np.cos(q * points(grid)[1]))), grid, HeatSource([1.0], **BODY)
    )
    exact = brentq(lambda z: j0(z) - fraction, 0.0, 3.0, xtol=1e-15) / q
    assert seen.stress_spectrum.correlation_radius(fraction) == pytest.approx(exact, rel=1e-11)


def test_the_radius_is_the_first_crossing_even_if_the_curve_only_dips():
    # a fine ripple dips below the level far before the slow wave does
    grid = Grid((256, 256), (1.0, 1.0))
    x, y = points(grid)
    slow, fine = 2 * pi, 2 * pi * 100
    seen = measure(
        Pressed(2 + sqrt(0.7) * np.cos(slow * x) + sqrt(0.3) * np.cos(fine * y)),
        grid,
        HeatSource([1.0], **UNIT),
    )

    def correlation(r):
        return 0.7 * j0(slow * r) + 0.3 * j0(fine * r)

    dip = 3.8317 / fine
    for fraction in (correlation(dip) + 1e-5, correlation(dip) + 1e-9):
        exact = brentq(
            lambda r, level=fraction: correlation(r) - level, 2.4048 / fine, dip, xtol=1e-16
        )
        assert seen.stress_spectrum.correlation_radius(fraction) == pytest.approx(exact, rel=1e-8)


def test_no_fourth_derivative_of_the_bessel_function_exceeds_the_bound_of_the_steps():
    x = np.concatenate((np.linspace(0.0, 100.0, 20001), np.geomspace(100.0, 1e6, 20001)))
    fourth = (
        np.abs(3 * j0(x) - 4 * jv(2, x) + jv(4, x)) / 8
    )  # J_n′ = (J_{n−1} − J_{n+1})/2, four times
    bound = 0.375 / np.hypot(1.0, x / 6.0) ** 0.5  # 3/8 (1 + (x/6)²)^(−1/4)
    assert np.all(fourth <= bound * (1 + 1e-12))
    assert fourth[0] == bound[0] == 0.375
    assert np.all(np.diff(bound) <= 0.0)


def test_no_crossing_is_passed_however_the_curve_ripples():
    rng = np.random.default_rng(7)
    r = np.linspace(0.0, 1.0, 40001)
    places = []
    for _ in range(12):
        q = np.sort(np.exp(rng.uniform(np.log(3.0), np.log(300.0), 6)))
        variance = rng.random(6)
        curve = variance @ j0(np.outer(q, r)) / variance.sum()
        for fraction in (0.6, 0.3, 0.1, 0.0):
            first = int(
                np.argmax(curve < fraction)
            )  # the ripples are a hundred times wider than the steps here
            found = StressSpectrum(q, variance, 1.0).correlation_radius(fraction)
            assert r[first - 1] <= found <= r[first]
            places.append(found * q[-1])
    assert max(places) > 20.0  # some lie beyond many ripples


@pytest.mark.parametrize(
    "terms",
    [(2.0, 0.0, 0.0, 3.0), (0.0, 0.0, 0.0, 5.0), (1e-9, 4.0, 1e6, 1e-12), (3e5, 0.0, 2.0, 1e-3)],
)
def test_a_step_ends_where_its_terms_have_used_up_the_excess(terms):
    for excess in (1e-14, 1e-3, 0.5):
        step = first_root(excess, list(terms))
        used = sum(term * step**power for power, term in enumerate(terms, 1))
        assert excess * (1 - 1e-7) <= used <= excess


@pytest.mark.parametrize("r", [0.0, 1e-3, 0.4, 7.0])
def test_derivatives_of_the_curve_are_those_of_the_bessel_functions(r):
    q, w = np.array([0.5, 2.0, 9.0]), np.array([1.0, 0.3, 0.02])
    sums = [float(w @ (q**power * bessel(q * r))) for power, bessel in ((1, j1), (2, j0), (3, j1))]
    exact = [float(w @ (q**order * jvp(0, q * r, order))) for order in (2, 3)]
    assert further_derivatives(r, *sums) == pytest.approx(exact, rel=1e-9, abs=1e-8)


def test_the_radius_solves_its_equation_on_a_rough_field():
    grid = Grid((128, 128), (1.0, 1.0))
    smooth = np.fft.ifft2(
        np.fft.fft2(patches(grid))
        * np.exp(-10.0 * np.hypot(*np.meshgrid(*[np.fft.fftfreq(128)] * 2)))
    )
    seen = measure(Pressed(smooth.real), grid, HeatSource([1.0], **UNIT))
    for fraction in (0.5, 0.1, 0.0):
        radius = seen.stress_spectrum.correlation_radius(fraction)
        assert seen.pressure_correlation(radius) == pytest.approx(
            fraction * seen.pressure_variance, abs=1e-12
        )
        before = seen.pressure_correlation(np.linspace(0.0, radius * (1 - 1e-9), 300))
        assert (before > fraction * seen.pressure_variance).all()


@pytest.mark.parametrize("fraction", [1.0, -0.1, nan])
def test_a_fraction_that_is_never_reached_is_refused(fraction):
    seen = measure(Pressed(np.eye(8)), Grid((8, 8), (1.0, 1.0)), HeatSource([1.0], **UNIT))
    with pytest.raises(ValueError, match="fraction"):
        seen.stress_spectrum.correlation_radius(fraction)


def test_a_spectrum_gathered_for_short_distances_gives_the_same_curve_there():
    rng = np.random.default_rng(4)
    q = np.sort(rng.uniform(1e3, 4e5, 3000))
    spectrum = StressSpectrum(q, rng.random(3000) / q, 2e-3)
    near = spectrum.gathered(2e-4)
    assert near.wavenumber.size < 1000
    assert near.reach == 2e-4
    assert np.all(np.diff(near.wavenumber) > 0.0)
    r = np.linspace(0.0, 2e-4, 30)
    direct = [float((spectrum.variance * j0(q * x)).sum()) for x in r]
    np.testing.assert_allclose(
        near.pressure_correlation(r), direct, atol=1e-13 * direct[0], rtol=0.0
    )
    # the bound of the curvature is the same
    assert near.variance @ near.wavenumber**2 == pytest.approx(spectrum.variance @ q**2, rel=1e-12)
    assert spectrum.gathered(2e-3) is spectrum


@pytest.mark.parametrize("place", [0.05, 0.5])  # of the reach: within an eighth of it, and beyond
def test_a_radius_is_found_near_and_far(place):
    q = np.concatenate(([2.404825557695773 / (place * 1e-3)], np.linspace(1e5, 2e5, 400)))
    variance = np.concatenate(([1.0], np.full(400, 1e-9)))
    assert StressSpectrum(q, variance, 1e-3).correlation_radius(0.0) == pytest.approx(
        place * 1e-3, rel=1e-5
    )
