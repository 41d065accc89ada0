"""The errors of the rows of C(q) of maps, by hand: modes counted, the window, ends of the table, several maps."""

import math

import numpy as np
import pytest

import roughsim as rs
from roughsim.surface.topography.measured import combined, map_spectrum

SIDE = 100e-6
UNIT = 2 * math.pi / SIDE
GRID = rs.Grid((64, 64), (SIDE, SIDE))


def modes_of(low, high):
    """How many modes of the full plane have low ≤ |q| < high, rad/m."""
    n = np.fft.fftfreq(64, 1 / 64)
    q = UNIT * np.hypot(n[:, None], n)
    return np.count_nonzero((q >= low * (1 - 1e-9)) & (q < high * (1 - 1e-9)))


def limits_of(bins):
    return [(10 ** (i / 20), 10 ** ((i + 1) / 20)) for i in bins.index]


@pytest.fixture(scope="module")
def even():
    """A map whose modes do not scatter at all: all have |h_q|² of C ∝ q^(−2)."""
    spectrum = rs.TabulatedSpectrum(np.array([UNIT, 25 * UNIT]), np.array([1e-26, 1e-26 / 625]))
    return rs.synthesize(spectrum, GRID, np.random.default_rng(5))


def test_a_row_of_modes_that_do_not_scatter_has_the_error_of_gaussian_heights(even):
    # |h_q|² of Gaussian heights scatters by its mean; q and −q are one: √(2/n) of n modes
    bins = map_spectrum(even, GRID, periodic=True)
    counted = np.array([modes_of(*limits) for limits in limits_of(bins)])
    full = slice(0, -1)  # up to the last bin, which may have taken the rest
    np.testing.assert_allclose(bins.error[full], np.sqrt(2.0 / counted[full]), rtol=1e-6)


def test_modes_under_the_window_count_as_fewer(even):
    # of w = cos²(πr/2R) in a disk of R = L/2: ∫w⁴ and ∫w² over the square, here by polar quadrature
    r = (np.arange(20000) + 0.5) / 20000 * 0.5
    w = np.cos(math.pi * r) ** 2
    fourth, second = (2 * math.pi * np.mean(w**k * r) * 0.5 for k in (4, 2))
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(6):
        bins = map_spectrum(rng.standard_normal(GRID.shape), GRID, periodic=False)
        ratios.append(
            bins.error[:-1] * np.sqrt([0.5 * modes_of(*limits) for limits in limits_of(bins)[:-1]])
        )
    # where modes happen to scatter by less than their mean, that of Gaussian heights counts: the least of all rows
    assert np.min(ratios) == pytest.approx(math.sqrt(fourth / second**2), rel=2e-3)


def test_a_row_that_was_added_shares_the_error_of_its_neighbour():
    # C ∝ q^(−3): the longest waves have more than the integral from the first row on, so that a row below is added
    spectrum = rs.TabulatedSpectrum(np.array([UNIT, 25 * UNIT]), np.array([1e-26, 1e-26 / 25**3]))
    bins = map_spectrum(
        rs.synthesize(spectrum, GRID, np.random.default_rng(2)), GRID, periodic=True
    )
    found = combined([bins])
    assert bins.longest < 0.99 * UNIT
    assert found.spectrum.q[0] == pytest.approx(bins.longest)
    # both move together, and their sum of squares is that of twice the one
    np.testing.assert_allclose(found.errors[:2, 0], math.sqrt(2.0) * bins.error[0], rtol=1e-12)
    np.testing.assert_allclose(
        found.errors[2:-2, 0], bins.error[1 : len(found.errors) - 3], rtol=1e-12
    )


def test_the_widest_of_several_maps_says_where_the_table_begins(even):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    small = rs.Grid((64, 64), (SIDE / 2, SIDE / 2))
    spectrum = rs.TabulatedSpectrum(
        np.array([2 * UNIT, 50 * UNIT]), np.array([1e-26 / 4, 1e-26 / 2500])
    )
    fine = map_spectrum(
        rs.synthesize(spectrum, small, np.random.default_rng(6)), small, periodic=True
    )
    wide = map_spectrum(even, GRID, periodic=True)
    for maps in ([wide, fine], [fine, wide]):
        assert combined(maps).spectrum.q[0] == pytest.approx(min(wide.longest, wide.q[0]), rel=0.06)


def test_a_map_of_more_roughness_adds_more_of_its_scatter_to_the_mean(even):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    # C of 9 and of 1: the mean of 5 has √(9² + 1²)/2/5 of the error of one
    rough, plain = (map_spectrum(factor * even, GRID, periodic=True) for factor in (3.0, 1.0))
    errors, alone = combined([rough, plain]).errors, combined([plain]).errors
    inside = slice(3, len(errors) - 3)
    np.testing.assert_allclose(errors[inside, 0], math.sqrt(82) / 10 * alone[inside, 0], rtol=1e-6)
