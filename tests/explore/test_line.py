"""The line through a marked point: which points of the grid lie next to it."""

import numpy as np
import pytest

import roughsim as rs
from roughsim.explore.content import line_through, nearest_point

GRID = rs.Grid((12, 10), (6e-3, 2e-3))  # spacing 0.5 mm and 0.2 mm


def test_a_click_finds_the_point_whose_pixel_it_hits():
    assert nearest_point(GRID, 1.24e-3, 0.31e-3) == (2, 2)
    assert nearest_point(GRID, 1.26e-3, 0.29e-3) == (3, 1)
    assert nearest_point(GRID, -1.0, 9.0) == (0, 9)


@pytest.mark.parametrize(
    ("direction", "axis", "sign"), [(0.0, 0, 1), (np.pi, 0, -1), (np.pi / 2, 1, 1)]
)
def test_a_line_along_an_axis_meets_each_point_once(direction, axis, sign):
    line = line_through(GRID, (4, 7), direction)
    running, fixed = (line.i, line.j) if axis == 0 else (line.j, line.i)
    np.testing.assert_array_equal(running, np.arange(GRID.shape[axis])[::sign])
    assert set(fixed.tolist()) == {(7, 4)[axis]}
    d = GRID.spacing[axis]
    np.testing.assert_allclose(line.distance, sign * (running - (4, 7)[axis]) * d, atol=1e-12)


@pytest.mark.parametrize("direction", [0.3, 1.0, 2.2, -0.9, -3.0])
def test_an_oblique_line_stays_within_half_a_point_and_ends_at_the_sides(direction):
    point = (4, 7)
    line = line_through(GRID, point, direction)
    place = np.array(point)[:, None] * np.array(GRID.spacing)[:, None]
    exact = (
        place + np.array([[np.cos(direction)], [np.sin(direction)]]) * line.distance
    ) / np.array(GRID.spacing)[:, None]
    assert np.abs(np.stack([line.i, line.j]) - exact).max() <= 0.5 + 1e-9
    assert (line.i[line.distance == 0.0], line.j[line.distance == 0.0]) == point
    assert min(line.i.min(), line.j.min()) >= 0
    assert line.i.max() < GRID.shape[0]
    assert line.j.max() < GRID.shape[1]
    beyond = np.array([line.distance[0] - 0.2e-3, line.distance[-1] + 0.2e-3])
    ends = np.array(point)[:, None] + np.array(
        [[np.cos(direction)], [np.sin(direction)]]
    ) * beyond / np.array(GRID.spacing).reshape(2, 1)
    outside = (ends < -1e-9) | (ends > np.array(GRID.shape).reshape(2, 1) - 1 + 1e-9)
    assert outside.any(axis=0).all()  # one step further is outside
