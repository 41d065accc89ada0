"""Modes reduced to their wavenumbers: sums over rings are those over the whole plane of numpy's transform."""

import numpy as np
import pytest

from roughsim.fourier.power import gathered_power
from roughsim.grid import Grid, distinct_wavenumbers, modes_between, modes_where

CELLS = [
    Grid((8, 8), (1.0, 1.0)),
    Grid((9, 7), (2.0, 2.0)),
    Grid((6, 9), (1.0, 1.7)),
    Grid((5, 4), (3.0, 0.6)),
]
each_cell = pytest.mark.parametrize("grid", CELLS, ids=lambda grid: f"{grid.shape} {grid.lengths}")


def plane(grid):
    """|q| of the whole plane, and a field on it that is even in the wavevector."""
    qx, qy = (
        2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True)
    )
    power = np.abs(np.fft.fft2(np.random.default_rng(1).standard_normal(grid.shape))) ** 2
    return np.hypot(qx[:, None], qy), power


def quarter_size(grid):
    return (grid.shape[0] // 2 + 1) * (grid.shape[1] // 2 + 1)


@each_cell
def test_a_ring_sums_the_modes_of_the_whole_plane(grid):
    q, power = plane(grid)
    low, high = 2 * np.pi / max(grid.lengths), grid.nyquist
    modes = modes_between(grid, low, high)
    edges = np.geomspace(0.99 * low, 1.01 * high, 4)
    inside = (q > 0.999 * low) & (q < 1.001 * high)
    values = power[:, : grid.shape[1] // 2 + 1][modes.chosen]
    ring = np.digitize(modes.wavenumber, edges) - 1
    np.testing.assert_array_equal(
        np.bincount(ring, modes.multiplicity), np.histogram(q[inside], edges)[0][: ring.max() + 1]
    )
    expected = np.histogram(q[inside], edges, weights=power[inside])[0]
    np.testing.assert_allclose(
        np.bincount(ring, modes.multiplicity * values), expected[: ring.max() + 1], rtol=1e-13
    )


@each_cell
def test_all_modes_are_those_of_the_plane_but_the_mean(grid):
    q, _ = plane(grid)
    modes = modes_between(grid)
    assert modes.multiplicity.sum() == grid.points - 1
    assert (modes.multiplicity * modes.wavenumber**2).sum() == pytest.approx(
        (q**2).sum(), rel=1e-13
    )
    assert not modes.chosen[0, 0]
    one = modes_where(grid, grid.wavenumbers == grid.wavenumbers[1, 0])
    assert (one.wavenumber == grid.wavenumbers[1, 0]).all()


@each_cell
def test_gathered_power_keeps_the_sum_at_each_wavenumber(grid):
    field = np.random.default_rng(1).standard_normal(grid.shape)
    q, power = plane(grid)
    wavenumber, entry = distinct_wavenumbers(grid)
    quarter, sums = gathered_power(np.fft.rfft2(field), grid.multiplicity, entry, wavenumber.size)
    assert quarter.shape == (grid.shape[0] // 2 + 1, grid.shape[1] // 2 + 1)
    np.testing.assert_allclose(sums, np.bincount(entry, quarter.ravel()), rtol=1e-13)
    assert wavenumber[0] == 0.0
    for value in np.unique(np.round(q, 9)):
        at, near = np.abs(q - value) < 1e-6, np.abs(wavenumber - value) < 1e-6
        assert sums[near].sum() == pytest.approx(power[at].sum(), rel=1e-12)
    assert (np.diff(wavenumber) > 0).all()


@each_cell
def test_a_mode_of_the_quarter_plane_is_the_sum_of_four(grid):
    field = np.random.default_rng(1).standard_normal(grid.shape)
    _, power = plane(grid)
    quarter, _ = gathered_power(
        np.fft.rfft2(field), grid.multiplicity, np.zeros(quarter_size(grid), np.intp), 1
    )
    for i, row in enumerate(quarter):
        for j, value in enumerate(row):
            modes = {
                (s * i % grid.shape[0], t * j % grid.shape[1]) for s in (1, -1) for t in (1, -1)
            }
            assert value == pytest.approx(sum(power[mode] for mode in modes), rel=1e-12)
