"""Contact: the adversarial matrix. What breaks other solvers, each judged by its optimality conditions from outside."""

import numpy as np
import pytest
from contact_cases import UNIT, WAVE, WAVE_PRESSURE, assert_solved, rough
from some_rows import some

import roughsim as rs

ROUGH, GRID = rough()
SHAPES = [
    (63, 63),
    (64, 128),
    (127, 64),
    (256, 64),
    (61, 67),
    (3, 3),
    (2, 2),
    (7, 5),
    (1, 9),
    (128, 1),
]


def waves(shape, seed=3):
    """A rough field of any shape: falling white noise."""
    noise = np.random.default_rng(seed).standard_normal(shape)
    q = np.hypot(np.fft.fftfreq(shape[0])[:, None] * shape[0], np.arange(shape[1] // 2 + 1))
    field = np.fft.irfft2(
        np.fft.rfft2(noise) * np.where(q > 0, 1 / np.maximum(q, 1), 0) ** 1.8, s=shape
    )
    return 0.02 * field / field.std()


def solve(heights, grid, load, cap=np.inf, modulus=1.0, **options):
    solid = rs.Solid(modulus, cap)
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=load, **options)
    assert_solved(np.asarray(heights, float), grid, solid, load, contact)
    return contact


@pytest.mark.parametrize("shape", some(SHAPES, 2, pairs=True))
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 2.0), (3.0, 1.0), (1.0, 20.0)])
def test_any_grid_and_any_oblong_cell(shape, lengths):
    heights, grid = waves(shape), rs.Grid(shape, lengths)
    for load, cap in ((1e-3, np.inf), (0.05, np.inf), (0.05, 0.12)):
        solve(heights, grid, load, cap)


def test_a_surface_in_a_cell_of_one_to_a_thousand():
    grid = rs.Grid((64, 64), (1.0, 1000.0))
    q = np.hypot(*np.broadcast_arrays(*grid.wavevectors))
    noise = np.random.default_rng(3).standard_normal(grid.shape)
    heights = np.fft.irfft2(
        np.fft.rfft2(noise) * np.where(q > 0, 1 / np.maximum(q, 1e-9) ** 1.8, 0), s=grid.shape
    )
    heights *= 0.02 / heights.std()
    for load, cap in ((1e-3, np.inf), (0.05, np.inf), (0.05, 0.12)):
        solve(heights, grid, load, cap)


@pytest.mark.parametrize("ratio", [1.0 + 1e-9, 1.0001, 1.01, 1.5, 2.0, 100.0, 1e6])
@pytest.mark.parametrize("load", [1e-6, 0.01, 1.0])
def test_any_hardness_above_the_load(ratio, load):
    solve(ROUGH, GRID, load, ratio * load)


@pytest.mark.parametrize("load", [1e-30, 1e-16, 1e-8, 1e-4, 0.1, 1.0, 1e6])
def test_any_load_elastic_and_capped(load):
    solve(ROUGH, GRID, load)
    solve(ROUGH, GRID, load, 1.3 * load)


def test_any_units_of_length_and_pressure():
    base = solve(ROUGH, GRID, 0.01, 0.05)
    for length, pressure in (
        (1e-9, 1.0),
        (1e9, 1e9),
        (1e3, 1e11),
        (1e-9, 1e-9),
        (1e-100, 1.0),
        (1e100, 1.0),
        (1.0, 1e160),
    ):
        grid = rs.Grid(GRID.shape, (length, length))
        solid = rs.Solid(pressure, 0.05 * pressure)
        scaled = rs.solve_contact(ROUGH * length, grid, solid, nominal_pressure=0.01 * pressure)
        np.testing.assert_array_equal(scaled.pressure > 0, base.pressure > 0)
        np.testing.assert_allclose(
            scaled.pressure / pressure, base.pressure, rtol=0, atol=1e-9 * base.pressure.max()
        )


@pytest.mark.parametrize("offset", [1e-3, -1e3, 1e3, 1e5])
def test_an_offset_of_the_heights_costs_only_its_rounding(offset):
    base = solve(ROUGH, GRID, 0.01).pressure
    moved = solve(ROUGH + offset, GRID, 0.01).pressure
    rounding = 1e-16 * offset / np.ptp(ROUGH) * 64  # of the heights, against κ
    assert np.linalg.norm(moved - base) < (3e-6 + 100 * abs(rounding)) * np.linalg.norm(base)


FORMS = {
    "whole numbers": lambda h: np.rint(h * 1e6).astype(np.int32),
    "unsigned bytes": lambda h: np.rint((h - h.min()) * 1e3).astype(np.uint8),
    "truth values": lambda h: h > 0,
    "single precision": lambda h: h.astype(np.float32),
    "long double": lambda h: h.astype(np.longdouble),
    "half precision": lambda h: h.astype(np.float16),
    "big-endian": lambda h: h.astype(">f8"),
    "Fortran order": np.asfortranarray,
    "backwards": lambda h: h[::-1, ::-1],
    "every other column": lambda h: np.repeat(h, 2, axis=1)[:, ::2],
    "nested lists": lambda h: h.tolist(),
}


@pytest.mark.parametrize("form", FORMS)
def test_any_lawful_form_of_the_heights(form):
    heights = FORMS[form](ROUGH)
    solve(heights, GRID, 1e-3 * max(float(np.ptp(np.asarray(heights, float))), 1e-3))


def test_heights_far_apart_in_size_are_one_problem():
    for spread in (1e-3, 1.0, 3.0):
        heights = 0.01 * np.exp(spread * np.random.default_rng(1).standard_normal((64, 64)))
        for load, cap in ((1e-3, np.inf), (0.1, np.inf), (0.1, 0.2)):
            solve(heights, UNIT, load, cap)


def test_spikes_pits_ridges_and_checkerboards():
    spike, pit = np.zeros((64, 64)), np.zeros((64, 64))
    spike[5, 7], pit[5, 7] = 0.1, -0.1
    board = 0.01 * (np.indices((64, 64)).sum(axis=0) % 2)
    ridge = np.where(np.arange(64)[:, None] == 3, 0.01, 0.0) * np.ones((1, 64))
    for heights in (spike, pit, board, ridge, board + ridge):
        for load, cap in (
            (1e-6, np.inf),
            (1e-2, np.inf),
            (1.0, np.inf),
            (1e-2, 0.011),
            (1e-2, 0.5),
        ):
            solve(heights, UNIT, load, cap)


@pytest.mark.parametrize(
    "fraction", [1e-6, 1e-3, 0.5, 0.9, 0.999, 0.999999, 1.0, 1.0 + 1e-9, 1.0 + 1e-6]
)
def test_a_wave_along_either_axis_up_to_exactly_full_contact(fraction):
    for heights, grid in (
        (WAVE, UNIT),
        (WAVE.T, UNIT),
        (WAVE[:, :1], rs.Grid((64, 1), (1.0, 1.0))),
        (WAVE[:, :1].T, rs.Grid((1, 64), (1.0, 1.0))),
    ):
        area = 2 / np.pi * np.arcsin(np.sqrt(min(fraction, 1.0)))
        assert solve(heights, grid, fraction * WAVE_PRESSURE).contact_fraction == pytest.approx(
            area, abs=2 / 64
        )


def test_a_ring_of_waves_and_noise_without_a_cut_off():
    rng = np.random.default_rng(0)
    q = GRID.wavenumbers
    phases = np.exp(2j * np.pi * rng.random(q.shape))
    for spectrum in (np.abs(q - 16 * np.pi) < 2, np.ones_like(q), 1 / np.maximum(q, 1)):
        heights = np.fft.irfft2(spectrum * phases, s=(64, 64))
        heights *= 0.01 / heights.std()
        for load, cap in ((1e-3, np.inf), (0.05, np.inf), (0.5, np.inf), (0.05, 0.06), (0.05, 0.3)):
            solve(heights, GRID, load, cap)


def test_the_bisinusoidal_wave_near_full_contact():
    # Johnson, Greenwood & Higginson 1985: 1 − A = (3/2π)(1 − p/p*)
    points, amplitude = 256, 0.005
    x = np.cos(2 * np.pi * np.arange(points) / points)
    heights, grid = amplitude * np.add.outer(x, x), rs.Grid((points, points), (1.0, 1.0))
    # full contact needs π E* Δ (cos + cos) to keep above −p*: p* = 2 π E* Δ with Δ the amplitude of each cosine
    contact = solve(heights, grid, 0.97 * 2 * np.pi * amplitude)
    assert contact.contact_fraction == pytest.approx(1 - 3 / (2 * np.pi) * 0.03, abs=2e-3)
