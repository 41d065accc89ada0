"""Contact: problems drawn at random from all that is lawful, judged by their optimality conditions from outside."""

import warnings

import numpy as np
import pytest
from contact_cases import q_plane, violation

import roughsim as rs

PRIMES = (1, 2, 3, 5, 7, 11, 13, 31, 61, 97, 127, 211, 251, 293)


def side(rng):
    """Points along an axis, 1 … 300: primes often, small numbers as often as large ones."""
    return int(rng.choice(PRIMES)) if rng.random() < 0.4 else round(300 ** rng.random())


def cell(rng):
    """A grid with pixels or a cell up to 1:1000."""
    shape, ratio = (side(rng), side(rng)), 1000 ** rng.random() if rng.random() < 0.5 else 1.0
    lengths = (1.0, ratio) if rng.random() < 0.5 else (ratio, 1.0)
    if rng.random() < 0.5:  # square pixels but for the ratio
        lengths = tuple(n * length / max(shape) for n, length in zip(shape, lengths, strict=True))
    return rs.Grid(shape, lengths)


def filtered(noise, weight):
    return np.fft.irfft2(np.fft.rfft2(noise) * weight, s=noise.shape)


def falling(noise, q, rng):
    cut = q.max() * 30 ** -rng.random()
    return filtered(
        noise, np.where((q > 0) & (q <= cut), np.maximum(q, 1e-300), np.inf) ** -rng.uniform(1, 2.2)
    )


def block(shape):
    heights = np.zeros(shape)
    heights[shape[0] // 3 : shape[0] // 3 * 2 + 1, shape[1] // 4 : shape[1] // 2 + 1] = 1.0
    return heights


def surface(grid, rng):
    noise, shape, q = rng.standard_normal(grid.shape), grid.shape, grid.wavenumbers
    turns = np.hypot(np.fft.fftfreq(shape[0])[:, None] * shape[0], np.arange(shape[1] // 2 + 1))
    radius = q.max() * rng.uniform(0.05, 0.7)
    kinds = {
        "falling with the wavenumber": lambda: falling(noise, q, rng),
        "falling with the turns per cell": lambda: falling(noise, turns, rng),
        "white": lambda: noise,
        "plateau": lambda: block(shape),
        "spikes": lambda: (rng.random(shape) < 0.02) * rng.random(shape),
        "lognormal": lambda: np.exp(rng.uniform(0.5, 3) * noise),
        "ring": lambda: filtered(
            noise, abs(q - radius) < 0.1 * radius + 2 * np.pi / max(grid.lengths)
        ),
        "step": lambda: (
            np.where(np.arange(shape[0])[:, None] < shape[0] // 2, 1.0, 0.0) * np.ones(shape)
        ),
        "levels": lambda: np.round(2 * noise),
    }
    offset = 0.0 if rng.random() < 0.8 else 10 ** rng.uniform(-2, 1)
    return kinds[rng.choice(list(kinds))]() * 10 ** rng.uniform(-4, 1) + offset


def problem(seed):
    rng = np.random.default_rng(seed)
    grid = cell(rng)
    heights = surface(grid, rng)
    full = np.abs(np.fft.ifft2(np.fft.fft2(heights) * q_plane(grid) / 2)).max() or 1.0
    load = full * 10 ** rng.uniform(-6, 0.1)
    cap = np.inf if rng.random() < 0.5 else load * (1 + 10 ** rng.uniform(-2, 2))
    return heights, grid, load, cap, 10 ** rng.uniform(-9, -4)


def solve(seed):
    heights, grid, load, cap, tolerance = problem(seed)
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", "tolerance = .* lies below the rounding floor", RuntimeWarning
        )
        contact = rs.solve_contact(
            heights, grid, rs.Solid(1.0, cap), nominal_pressure=load, tolerance=tolerance
        )
    assert contact.pressure.min() >= 0.0
    assert contact.pressure.max() <= cap
    assert contact.pressure.mean() == pytest.approx(load, rel=1e-12)
    if np.ptp(heights) > 1e-14 * np.abs(heights).max():  # else flat: no displacement to judge by
        assert violation(heights, grid, rs.Solid(1.0, cap), contact.pressure) <= max(
            1.1 * tolerance, 1e-11
        )


@pytest.mark.parametrize("first", range(0, 60, 20))
@pytest.mark.slow
def test_random_lawful_problems_are_solved(first):
    for seed in range(first, first + 20):
        solve(seed)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 1600, 50))
def test_many_random_lawful_problems_are_solved(first):
    for seed in range(first, first + 50):
        solve(seed)
