"""What the periodic heat solver errs by: closed hot tracks, sharp edges, the Nyquist wavenumber."""

import re
from math import inf, pi

import numpy as np
import pytest
from heat_cases import STEEL, UNIT
from scipy import special

from roughsim import Grid, sliding_temperature
from roughsim.heat import uniform_temperature


def test_the_steady_kernel_warns_when_hot_tracks_close():
    grid = Grid((8, 8), (1.0, 1.0))
    with pytest.warns(
        RuntimeWarning, match=r"v L/\(2πD\) = 1.1 exceeds 1.* %; use a finite slid_distance"
    ):
        sliding_temperature(np.eye(8), grid, speed=2.2 * pi, slid_distance=inf, **UNIT)
    sliding_temperature(np.eye(8), grid, speed=1.8 * pi, slid_distance=inf, **UNIT)


def rough_source(points):
    """Isotropic rough heat from waves as long as the cell on: |q̇(q)|² level to 4π/L, then ~ q^−3.6; phases random."""
    grid = Grid((points, points), (1.0, 1.0))
    q = grid.wavenumbers
    amplitude = np.where(
        (q > 0) & (q < pi * points / 2), np.maximum(q / (4 * pi), 1.0) ** -1.8, 0.0
    )
    noise = np.fft.rfft2(np.random.default_rng(12).standard_normal(grid.shape))
    noise[np.abs(noise) > 0] /= np.abs(noise[np.abs(noise) > 0])
    return np.fft.irfft2(amplitude * noise, s=grid.shape), grid


def isotropic_flash_temperature(flux, speed):
    """Σ|q̇|² (2/π)A(v/Dq)/q over the modes: the mean over all directions of sliding on an endless surface."""
    power = np.abs(np.fft.fft2(flux) / flux.size) ** 2
    q = 2 * pi * np.hypot(*np.meshgrid(*[np.fft.fftfreq(n) * n for n in flux.shape], indexing="ij"))
    a = speed / np.where(q > 0, q, 1.0)
    response = 2 / pi * (1 + a**2) ** -0.25 * special.ellipk((1 - (1 + a**2) ** -0.5) / 2)
    return np.sum(power[q > 0] * response[q > 0] / q[q > 0])


@pytest.mark.parametrize(("laps", "at_least"), [(10.0, 0.05), (100.0, 0.6), (1000.0, 2.5)])
def test_the_warning_of_hot_tracks_names_the_size_of_the_error(laps, at_least):
    flux, grid = rough_source(64)
    speed = 2 * pi * laps
    exact = isotropic_flash_temperature(flux, speed)
    with pytest.warns(RuntimeWarning, match="hot track") as caught:
        field = sliding_temperature(flux, grid, speed=speed, slid_distance=inf, **UNIT)
    named = float(re.search(r"by ([0-9.e+-]+) %", str(caught[0].message)).group(1)) / 100
    rest = np.mean(flux * sliding_temperature(flux, grid, speed=speed, **UNIT))
    assert named == pytest.approx(np.mean(flux * field) / rest - 1, rel=6e-3)  # three digits
    assert named > at_least
    assert rest == pytest.approx(
        exact, rel=0.03
    )  # four waves of the length of the cell are no isotropic roughness
    assert 1 + named == pytest.approx(np.mean(flux * field) / exact, rel=0.03)


def test_the_size_of_the_error_counts_every_mode_that_remembers_its_start():
    # against whole fields, on an oblong grid with odd and even sides, slid obliquely, at depth
    grid = Grid((45, 16), (3.0, 1.0))
    flux = np.random.default_rng(13).random(grid.shape)
    heat = {"speed": 3.0 * 7.6e-6, "direction": 0.3, "depth": 0.01} | STEEL
    with pytest.warns(RuntimeWarning, match="hot track") as caught:
        field = sliding_temperature(flux, grid, slid_distance=inf, **heat)
    named = float(re.search(r"by ([0-9.e+-]+) %", str(caught[0].message)).group(1)) / 100
    excess = np.mean(flux * field) / np.mean(flux * sliding_temperature(flux, grid, **heat)) - 1
    assert named == pytest.approx(excess, rel=6e-3)


@pytest.mark.parametrize("peclet", [100.0, 1e3, 1e5])
def test_a_sharp_edge_undershoots_by_a_bounded_share_that_falls_with_the_pixel(peclet):
    # a finite number of waves cannot end at an edge: ahead of a fast square the field is slightly negative
    shares = []
    for points in (64, 256):
        grid = Grid((points, points), (8.0, 8.0))
        x = abs((np.arange(points) - (points - 1) / 2) * 8 / points) < 1
        flux = np.outer(x, x).astype(float)
        field = sliding_temperature(flux, grid, speed=peclet, **UNIT)
        field += uniform_temperature(flux.mean(), 4 / peclet, **UNIT)
        shares.append(-field.min() / field.max())
    assert 0.005 < shares[0] < 0.016
    assert (
        shares[1] < 0.6 * shares[0]
    )  # as the root of the pixel, or faster where heat spreads over a pixel


def test_the_laplacian_converges_at_first_order():
    # waves beyond the grid carry it: Σ|q||q̇|² of a Hertz contact, |q̇|² ~ q^−4, is cut at the Nyquist wavenumber
    errors = []
    for pixels in (8, 16, 32):
        grid = Grid((8 * pixels, 8 * pixels), (8.0, 8.0))
        x = (np.arange(32 * pixels) - (32 * pixels - 1) / 2) / pixels / 4
        fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
        pressure = fine.reshape(8 * pixels, 4, 8 * pixels, 4).mean((1, 3))
        power = np.abs(np.fft.rfft2(pressure) / grid.points) ** 2 * grid.multiplicity
        field = sliding_temperature(pressure, grid, speed=0.0, **UNIT)
        spectrum = np.fft.rfft2(field) * -(grid.wavenumbers**2)
        laplacian = np.sum(np.fft.irfft2(spectrum, s=grid.shape) * pressure) / pressure.sum()
        assert laplacian == pytest.approx(
            -np.sum(power * grid.wavenumbers) / pressure.mean(), rel=1e-10
        )
        errors.append(1 + laplacian / (pi / 2))  # the exact one is −(π/2) q̇₁/κR, Eq. (18)
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.06)
    assert errors[2] / errors[1] == pytest.approx(0.5, abs=0.08)
