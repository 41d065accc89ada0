"""Contact: a solve may begin from an earlier contact, which changes its work and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from contact_cases import assert_solved, rough, violation

import roughsim as rs

SOLIDS = {"elastic": rs.Solid(1.0), "capped": rs.Solid(1.0, 0.03)}
LOAD = 0.01


def two_faces(slid):
    """The sum of two rough faces, the second moved by whole pixels along axis 0."""
    (first, grid), (second, _) = rough(128, per_wave=8, seed=1), rough(128, per_wave=8, seed=2)
    return first + np.roll(second, slid, 0), grid


def solved(solid, slid=0, load=LOAD, **options):
    heights, grid = two_faces(slid)
    return rs.solve_contact(heights, grid, solid, nominal_pressure=load, **options)


def on_half_the_points(solid):
    heights, grid = two_faces(1)
    half = rs.Grid((64, 64), grid.lengths)
    return rs.solve_contact(heights[::2, ::2], half, solid, nominal_pressure=LOAD)


STARTS = {
    "slid by one pixel": lambda solid: solved(solid, slid=0),
    "a tenth more load": lambda solid: solved(solid, slid=1, load=1.1 * LOAD),
    "half the load, in single precision": lambda solid: solved(
        solid, slid=1, load=0.5 * LOAD, precision="single"
    ),
    "half the points": on_half_the_points,
}


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)
@pytest.mark.parametrize("start", STARTS)
def test_a_solve_from_an_earlier_contact_meets_the_same_tolerance(start, solid):
    heights, grid = two_faces(1)
    contact = solved(solid, slid=1, start=STARTS[start](solid))
    assert contact.residual <= 1e-6
    assert_solved(heights, grid, solid, LOAD, contact)
    exact = solved(solid, slid=1, tolerance=1e-10).pressure
    assert np.linalg.norm(contact.pressure - exact) <= 5e-6 * np.linalg.norm(exact)


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)
def test_an_earlier_contact_saves_work(solid):
    cold = solved(solid, slid=1)
    itself, coarse = (
        solved(solid, slid=1, start=cold),
        solved(solid, slid=1, start=on_half_the_points(solid)),
    )
    assert itself.transforms < 0.5 * cold.transforms
    assert coarse.transforms < 0.95 * cold.transforms


def strange_starts(contact):
    """Contacts of other surfaces, other grids, and no contact at all."""
    rng = np.random.default_rng(5)
    for shape in ((64, 64), (1, 1), (7, 5), (100, 30), (2, 130)):
        pressure, displacement = (
            rng.exponential(size=shape) * (rng.random(shape) < 0.3),
            rng.standard_normal(shape),
        )
        pressure[0, 0] = 1.0
        for scale in (1e-9, 1.0, 1e9):
            yield replace(contact, pressure=scale * pressure, displacement=scale * displacement)


def test_any_start_leads_to_the_solution():
    heights, grid = rough(64)
    for solid in SOLIDS.values():
        cold = rs.solve_contact(heights, grid, solid, nominal_pressure=LOAD)
        for start in strange_starts(cold):
            contact = rs.solve_contact(heights, grid, solid, nominal_pressure=LOAD, start=start)
            assert violation(heights, grid, solid, contact.pressure) <= 1e-6


def test_a_start_is_not_changed():
    start = solved(SOLIDS["capped"])
    kept = start.pressure.copy(), start.displacement.copy()
    solved(SOLIDS["capped"], slid=1, start=start)
    np.testing.assert_array_equal(start.pressure, kept[0])
    np.testing.assert_array_equal(start.displacement, kept[1])
