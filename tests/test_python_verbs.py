"""The verbs from Python: the functions of the command line, by name, path or record."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs


@pytest.fixture(scope="module")
def contact():
    """A contact of two waves, whose load leaves gaps."""
    grid = rs.Grid((32, 32), (1e-3, 1e-3))
    x = np.arange(32) / 32
    heights = 1e-6 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :]
    return rs.solve_contact(heights, grid, rs.Solid(1e11, 1e9), nominal_pressure=1e7)


SOURCE = rs.HeatSource(speeds=[1.0, 35.0], friction_coefficient=0.1, conductivity=30.0, diffusivity=7.6e-6)


def test_a_contact_knows_its_grid_and_solid(contact):
    assert contact.grid == rs.Grid((32, 32), (1e-3, 1e-3))
    assert contact.solid == rs.Solid(1e11, 1e9)


def test_a_contact_is_measured_on_its_own_grid(contact):
    short = rs.measure(contact, SOURCE)
    # a cell of twice the side has waves of twice the length: T ∝ 1/q at rest
    longer = rs.measure(contact, rs.Grid((32, 32), (2e-3, 2e-3)), SOURCE)
    assert short.resting_flash_temperature == pytest.approx(longer.resting_flash_temperature / 2, rel=1e-12)


def test_a_contact_without_grid_needs_one(contact):
    bare = replace(contact, grid=None, solid=None)
    with pytest.raises(TypeError, match=r"contact has no grid; write measure\(contact, grid, heat_source\)"):
        rs.measure(bare, SOURCE)
    with pytest.raises(TypeError, match="measure needs a HeatSource"):
        rs.measure(contact, contact.grid)


def test_records_show_themselves_in_one_line(contact):
    assert repr(contact).startswith("<Contact on 32 × 32 points: contact_fraction 0.")
    moments = rs.measure(contact, SOURCE)
    assert f"T_flash {moments.flash_temperature[0]:.4g}, {moments.flash_temperature[1]:.4g} K" in repr(moments)
    assert "\n" not in repr(contact) + repr(moments)
