"""The part of a field in view as an image: which points, their means, their place, their bytes."""

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.charts.maps import palette
from roughsim.explore.content import PIXELS, as_bytes, block_means, image_of

GRID = rs.Grid((12, 10), (6e-3, 2e-3))  # spacing 0.5 mm and 0.2 mm
FIELD = np.random.default_rng(1).normal(size=GRID.shape)


def everything(grid):
    return (0.0, grid.lengths[0]), (0.0, grid.lengths[1])


def shown(field, pixels=PIXELS, grid=GRID):
    """The image of the whole cell whose bytes are those of the limits of the field itself."""
    return image_of(field, grid, everything(grid), (field.min(), field.max()), pixels=pixels)


def test_a_view_of_few_points_shows_every_point():
    image = shown(FIELD)
    assert image.step == (1, 1)
    np.testing.assert_array_equal(image.pixels, as_bytes(FIELD, (FIELD.min(), FIELD.max())))
    assert image.box == pytest.approx((-0.25e-3, -0.1e-3, 6e-3, 2e-3))  # points are centred


def test_an_averaged_view_holds_the_means_of_blocks():
    image = shown(FIELD, pixels=5)
    assert image.step == (3, 2)
    means = FIELD.reshape(4, 3, 5, 2).mean(axis=(1, 3))
    np.testing.assert_array_equal(image.pixels, as_bytes(means, (FIELD.min(), FIELD.max())))


@pytest.mark.parametrize("step", [1, 2, 3, 4, 7, 12])
def test_the_last_block_is_the_mean_of_the_rows_that_it_has(step):
    rows = FIELD.astype(np.float32)
    means = block_means(rows, step)
    assert means.dtype == np.float32
    for k, mean in enumerate(means):
        np.testing.assert_allclose(mean, FIELD[step * k : step * (k + 1)].mean(axis=0), atol=1e-6)
    assert len(means) == -(-12 // step)


def test_blocks_that_do_not_divide_the_cell_keep_their_places():
    image = shown(FIELD, pixels=3)
    assert image.step == (4, 4)  # 10 = 4 + 4 + 2
    last = np.array([[FIELD[4:8, 8:10].mean()]])
    assert image.pixels[2, 1] == as_bytes(last, (FIELD.min(), FIELD.max()))[0, 0]
    assert image.box[3] == pytest.approx(
        12 * 0.2e-3
    )  # the last block reaches beyond the cell: no block is squeezed


@pytest.mark.parametrize(
    "seed", some([*range(8), *(pytest.param(k, marks=pytest.mark.slow) for k in range(8, 30))], 2)
)
def test_an_image_covers_its_view_with_few_pixels_on_a_fixed_raster(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 5000, 2))
    grid = rs.Grid(shape, (4e-3, 3e-3))
    ends = [tuple(rng.uniform(-0.2, 1.2, 2) * length) for length in grid.lengths]
    pixels, box, _, steps, _ = image_of(np.zeros(shape, np.float32), grid, tuple(ends), None)
    for axis in (0, 1):
        size, step, d = box[2 + axis], steps[axis], grid.spacing[axis]
        count = pixels.shape[1 - axis]
        assert 1 <= count <= PIXELS
        first = box[axis] / d + 0.5  # index of the first point
        assert first / step == pytest.approx(round(first / step), abs=1e-6)
        assert size == pytest.approx(count * step * d)
        low, high = (np.clip(end, 0.0, (grid.shape[axis] - 0.5) * d) for end in sorted(ends[axis]))
        assert box[axis] <= low + 1e-12
        assert box[axis] + size >= high - 1e-12


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
    assert image.box == shown(FIELD).box
    wide = image_of(FIELD, GRID, everything(GRID), (-10.0, 10.0))
    assert wide.limits == (-10.0, 10.0)
    np.testing.assert_array_equal(wide.pixels, as_bytes(FIELD, (-10.0, 10.0)))
