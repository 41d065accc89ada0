"""Moments of one contact for sliding in single directions, from rest, on cells that a lay stretches."""

from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from roughsim import Grid, HeatSource, measure, sliding_temperature
from roughsim.observables import directed

BODY = {"conductivity": 30.0, "diffusivity": 7.6e-6}
CELL = Grid((48, 60), (4e-3, 1e-3))
SPEEDS = [0.01, 1.0, 35.0]
ANGLES = [0.3, 1.2, pi / 2]


def contact(grid, seed=0):
    """Spots of pressure, without waves at the Nyquist wavenumbers, whose derivatives have no sign."""
    heights = np.random.default_rng(seed).standard_normal(grid.shape)
    amplitude = np.fft.fft2(np.maximum(heights - 1.0, 0.0))
    for axis, n in enumerate(grid.shape):
        if n % 2 == 0:
            amplitude = np.moveaxis(amplitude, axis, 0)
            amplitude[n // 2] = 0.0
            amplitude = np.moveaxis(amplitude, 0, axis)
    pressure = 1e9 * np.fft.ifft2(amplitude).real
    return SimpleNamespace(pressure=pressure, contact_fraction=0.2, plastic_fraction=0.0)


def source(directions=tuple(ANGLES), speeds=tuple(SPEEDS), **more):
    return HeatSource(
        speeds, friction_coefficient=0.11, direction=directions, from_rest=True, **BODY, **more
    )


def by_field(touching, grid, speed, angle):
    """T_flash, T′ and ∇²T of the field after half the chord, by its Fourier transform."""
    pressure = touching.pressure
    field = sliding_temperature(0.11 * speed * pressure, grid, speed=speed, direction=angle, **BODY)
    qx, qy = (
        2 * pi * np.fft.fftfreq(n, length / n)
        for n, length in zip(grid.shape, grid.lengths, strict=True)
    )
    qx, qy = np.meshgrid(qx, qy, indexing="ij")
    wave = np.fft.fft2(field)
    slope = np.fft.ifft2(1j * (qx * np.cos(angle) + qy * np.sin(angle)) * wave).real
    curvature = np.fft.ifft2(-(qx**2 + qy**2) * wave).real
    return [np.mean(each * pressure) / pressure.mean() for each in (field, slope, curvature)]


def test_moments_from_rest_are_those_of_the_field():
    touching = contact(CELL)
    found = measure(touching, CELL, source())
    for k, (speed, angle) in enumerate(zip(SPEEDS, ANGLES, strict=True)):
        flash, slope, curvature = by_field(touching, CELL, speed, angle)
        assert found.flash_temperature[k] == pytest.approx(flash, rel=1e-7)
        assert found.flash_gradient[k] == pytest.approx(slope, rel=1e-6)
        assert found.flash_laplacian[k] == pytest.approx(curvature, rel=1e-6)


def test_kept_weights_change_moments_by_rounding(monkeypatch):
    touching = contact(CELL)
    kept = measure(touching, CELL, source())
    monkeypatch.setattr(directed, "_KEPT", 0)
    summed = measure(touching, CELL, source())
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        np.testing.assert_allclose(getattr(kept, name), getattr(summed, name), rtol=1e-7)


def test_turned_cell_turns_the_direction():
    touching = contact(CELL)
    turned = SimpleNamespace(**vars(touching) | {"pressure": touching.pressure.T})
    (nx, ny), (x, y) = CELL.shape, CELL.lengths
    found = measure(touching, CELL, source()).flash_temperature
    other = source(tuple(pi / 2 - angle for angle in ANGLES))
    np.testing.assert_allclose(
        measure(turned, Grid((ny, nx), (y, x)), other).flash_temperature, found, rtol=1e-7
    )


def test_slow_contact_has_no_direction():
    touching = contact(CELL)
    found = measure(touching, CELL, source(speeds=[1e-9] * 3))
    np.testing.assert_allclose(found.flash_temperature, found.resting_flash_temperature, rtol=1e-6)


def test_from_rest_needs_a_direction():
    with pytest.raises(ValueError, match="from_rest = True needs a direction"):
        HeatSource([1.0], friction_coefficient=0.1, from_rest=True, **BODY)


def test_stretched_cell_keeps_points_and_area():
    cell = Grid((8, 6), (2.0, 3.0)).stretched(4.0)
    assert (cell.shape, cell.lengths) == ((8, 6), (4.0, 1.5))
    assert Grid((8, 6), (0.1, 0.3)).stretched(1.0) == Grid((8, 6), (0.1, 0.3))
