"""Surfaces, grids and judges from outside that the tests of contact share."""

import numpy as np
import pytest

import roughsim as rs

SIDE = np.arange(64) / 64
WAVE = 0.01 * np.cos(2 * np.pi * SIDE)[:, None] * np.ones((1, 64))  # amplitude 0.01, one wave
WAVE_PRESSURE = np.pi * 0.01  # p* = π E* Δ/λ of that wave with E* = 1
UNIT = rs.Grid((64, 64), (1.0, 1.0))


def displacement_by_dft(pressure, grid, modulus):
    """S p with numpy's transform and the definition of S; nothing of the solver."""
    qx = 2 * np.pi * np.fft.fftfreq(grid.shape[0], grid.lengths[0] / grid.shape[0])[:, None]
    qy = 2 * np.pi * np.fft.fftfreq(grid.shape[1], grid.lengths[1] / grid.shape[1])[None, :]
    q = np.hypot(qx, qy)
    compliance = np.divide(2.0, modulus * q, out=np.zeros_like(q), where=q > 0)
    return np.fft.ifft2(compliance * np.fft.fft2(pressure)).real


def violation(heights, grid, solid, pressure):
    """Largest violation of the optimality conditions, against the range of the displacement."""
    displacement = displacement_by_dft(pressure, grid, solid.effective_modulus)
    gap = displacement - heights
    free = (pressure > 0) & (pressure < solid.penetration_hardness)
    low, high = pressure <= 0, pressure >= solid.penetration_hardness
    bounds = gap[high].max(initial=-np.inf), gap[low].min(initial=np.inf)
    offset = gap[free].mean() if free.any() else np.mean([b for b in bounds if np.isfinite(b)])
    worst = max(
        np.abs(gap - offset)[free].max(initial=0.0),
        (offset - gap)[low].max(initial=0.0),
        (gap - offset)[high].max(initial=0.0),
    )
    rounding = 64 * np.finfo(float).eps * np.abs(heights).max()
    return max(worst - rounding, 0.0) / max(np.ptp(displacement), np.finfo(float).tiny)


def assert_solved(heights, grid, solid, load, contact):
    assert contact.pressure.min() >= 0.0
    assert contact.pressure.max() <= solid.penetration_hardness
    assert contact.pressure.mean() == pytest.approx(load, rel=1e-12)
    assert violation(np.asarray(heights, float), grid, solid, contact.pressure) <= 1e-6


def rough(points=64, *, hurst=0.8, slope=0.1, per_wave=4, seed=0, lengths=(1.0, 1.0)):
    shape = points if isinstance(points, tuple) else (points, points)
    grid = rs.Grid(shape, lengths)
    q_min = 2 * np.pi / min(lengths)
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        slope, hurst=hurst, q_min=q_min, q_roll_off=2 * q_min, q_max=grid.nyquist * 2 / per_wave
    )
    return rs.synthesize(spectrum, grid, np.random.default_rng(seed)), grid


def q_plane(grid):
    qx = 2 * np.pi * np.fft.fftfreq(grid.shape[0], grid.lengths[0] / grid.shape[0])
    qy = 2 * np.pi * np.fft.fftfreq(grid.shape[1], grid.lengths[1] / grid.shape[1])
    return np.hypot(qx[:, None], qy[None, :])


def press(heights=WAVE, grid=UNIT, solid=None, **options):
    return rs.solve_contact(
        heights, grid, solid or rs.Solid(1.0), **{"nominal_pressure": 0.01, **options}
    )
