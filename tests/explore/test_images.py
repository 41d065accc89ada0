"""The part of a field in view as an image: which points, their means, their place, their bytes."""

import numpy as np
import pytest

import roughsim as rs
from roughsim.charts.maps import palette
from roughsim.explore.fields import PIXELS, as_bytes, block_means, image_of, part_in_view

GRID = rs.Grid((12, 10), (6e-3, 2e-3))  # spacing 0.5 mm and 0.2 mm
FIELD = np.random.default_rng(1).normal(size=GRID.shape)


def everything(grid):
    return (0.0, grid.lengths[0]), (0.0, grid.lengths[1])


def test_a_view_of_few_points_shows_every_point():
    part = part_in_view(GRID, *everything(GRID))
    assert part.step == (1, 1)
    np.testing.assert_array_equal(block_means(FIELD, part), FIELD)
    assert part.box == pytest.approx((-0.25e-3, -0.1e-3, 6e-3, 2e-3))  # points are centred


def test_an_averaged_view_holds_the_means_of_blocks():
    part = part_in_view(GRID, *everything(GRID), pixels=5)
    assert part.step == (3, 2)
    image = block_means(FIELD, part)
    assert image.shape == (4, 5)
    for i in range(4):
        for j in range(5):
            assert image[i, j] == pytest.approx(FIELD[3 * i : 3 * i + 3, 2 * j : 2 * j + 2].mean(), rel=1e-12)


def test_blocks_that_do_not_divide_the_cell_keep_their_places():
    part = part_in_view(GRID, *everything(GRID), pixels=3)
    assert part.step == (4, 4)  # 10 = 4 + 4 + 2
    image, box = block_means(FIELD, part), part.box
    assert image[1, 2] == pytest.approx(FIELD[4:8, 8:10].mean(), rel=1e-12)
    assert box[3] == pytest.approx(12 * 0.2e-3)  # the last block reaches beyond the cell: no block is squeezed


@pytest.mark.parametrize("seed", range(30))
def test_a_part_covers_its_view_with_few_pixels_on_a_fixed_raster(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 5000, 2))
    grid = rs.Grid(shape, (4e-3, 3e-3))
    ends = [tuple(rng.uniform(-0.2, 1.2, 2) * length) for length in grid.lengths]
    part = part_in_view(grid, *ends)
    box = part.box
    for axis in (0, 1):
        side, step, d = part[axis], part.step[axis], grid.spacing[axis]
        count = -(-(side.stop - side.start) // step)
        assert 1 <= count <= PIXELS
        assert side.start % step == 0
        low, high = (np.clip(end, 0.0, (grid.shape[axis] - 0.5) * d) for end in sorted(ends[axis]))
        assert box[axis] <= low + 1e-12
        assert box[axis] + box[2 + axis] >= high - 1e-12
    assert max(block_means(np.zeros(shape, np.float32), part).shape) <= PIXELS


def test_bytes_follow_the_limits_and_screens_see_y_upwards():
    image = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])  # x, y
    pixels = as_bytes(image, (0.0, 5.0))
    np.testing.assert_array_equal(pixels, [[0, 153], [51, 204], [102, 255]])  # rows are y
    np.testing.assert_array_equal(as_bytes(image, (2.0, 3.0)), [[0, 255], [0, 255], [0, 255]])
    assert as_bytes(image, (4.0, 4.0)).max() == 0
    assert pixels.dtype == np.uint8
    assert pixels.flags.c_contiguous


def test_colours_are_those_of_the_printed_maps():
    assert len(palette("temperature")) == 256
    assert palette("pressure")[0] == "#ffffff"
    assert palette("heights")[0][1:3] < palette("heights")[255][1:3]  # blue below, red above


def test_an_image_has_the_limits_that_it_is_given_or_its_own():
    image = image_of(FIELD, GRID, everything(GRID), None)
    assert image.limits == (FIELD.min(), FIELD.max())
    assert (image.pixels.min(), image.pixels.max()) == (0, 255)
    assert image.box == part_in_view(GRID, *everything(GRID)).box
    wide = image_of(FIELD, GRID, everything(GRID), (-10.0, 10.0))
    assert wide.limits == (-10.0, 10.0)
    np.testing.assert_array_equal(wide.pixels, as_bytes(FIELD, (-10.0, 10.0)))
