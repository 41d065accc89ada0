"""Numbers in text: which lines are heights, what a list of points may lack, and how damage is noticed."""

import numpy as np
import pytest

from roughsim.surface.topography.contents import NoHeightsError
from roughsim.surface.topography.text import (
    heights_of,
    refuse_damaged,
    table_of,
    without_coordinates,
)

ROUGH = np.random.default_rng(8).standard_normal((12, 9))  # of steps of about 1
NAMES = "its first line, which counts in even steps"
COLUMN = "its first column, which counts in even steps"


def below(line, heights=ROUGH):
    """What is left out of a map under a first line; the same beside a first column."""
    table = np.vstack([line, heights])
    found, turned = (without_coordinates(numbers).left_out for numbers in (table, table.T))
    assert turned == tuple(COLUMN for _ in found)
    return found


@pytest.mark.parametrize("step", [100.0, -100.0])
@pytest.mark.parametrize(("bend", "counts"), [(0.05, True), (0.55, True), (0.65, False)])
def test_a_first_line_counts_up_to_a_bend_of_six_tenths_of_a_step(bend, counts, step):
    line = 1000.0 + step * np.arange(9)
    line[4] += 100.0 * bend
    assert below(line, 0.1 * ROUGH) == ((NAMES,) if counts else ())


def test_a_bent_line_near_much_rougher_heights_counts_up_to_a_tenth_of_a_step():
    for bend, counts in ((8.0, True), (12.0, False)):
        line = 100.0 * (np.arange(9) - 4.0)
        line[4] += bend
        assert below(line, 1e5 * ROUGH) == ((NAMES,) if counts else ())


def test_a_plane_of_large_numbers_is_not_rough_by_their_rounding():
    plane = 1e9 + np.add.outer(np.arange(1.0, 13.0) / 3.0, np.arange(9) / 7.0)
    assert below(1e9 + np.arange(9) / 8.0, plane) == ()


@pytest.mark.parametrize(("far", "counts"), [(8.0, False), (12.0, True)])
def test_a_bent_line_counts_if_it_is_ten_steps_of_the_heights_away(far, counts):
    heights = np.where(np.arange(12)[:, None] % 2 == 0, 0.0, 1.0) + np.zeros(
        9
    )  # steps of 1 from line to line
    line = far + 0.01 * np.round(1.4 * np.arange(9))
    line -= line.mean() - far
    assert below(line, heights) == ((NAMES,) if counts else ())


def test_a_line_that_turns_or_a_flat_one_does_not_count():
    turned = 1000.0 + 100.0 * np.array([0, 1, 2, 3, 2.9, 5, 6, 7, 8])
    assert below(turned, 0.1 * ROUGH) == ()
    assert below(np.full(9, 1000.0)) == ()


@pytest.mark.parametrize(("straightness", "counts"), [(0.006, True), (0.014, False)])
def test_a_line_near_the_heights_counts_if_it_is_a_hundred_times_as_straight(straightness, counts):
    # heights on a parabola: without their corner x² − 7x + 7 is the distance from the straight line, 7 at most
    heights = np.tile(50.0 + (np.arange(9) - 1.0) ** 2 / 7.0, (4, 1))
    line = 50.0 + 0.5 * (np.arange(9) - 4.0)
    line[4] += straightness
    assert without_coordinates(np.vstack([line, heights])).left_out == ((NAMES,) if counts else ())


def test_two_columns_or_two_lines_are_too_few_to_count():
    assert below(1e3 * np.arange(3.0), 1e-3 * ROUGH[:, :3]) == ()  # the corner is none of them
    assert without_coordinates(np.vstack([np.arange(9.0), ROUGH[0]])).left_out == ()
    least = np.vstack([1e3 * np.arange(4.0), 1e-3 * ROUGH[:2, :4]])
    assert without_coordinates(least).left_out == (NAMES,)


def listed(keep):
    """A text of x, y and height of the chosen points of a grid of 8 × 6, steps 2 and 3."""
    x, y = (
        side.ravel() for side in np.meshgrid(2.0 * np.arange(8), 3.0 * np.arange(6), indexing="ij")
    )
    rows = np.column_stack([50.0 + x, y - 7.0, 10.0 * x + y])[keep]
    return as_text(rows)


def as_text(rows):
    return "\n".join(" ".join(f"{value:g}" for value in row) for row in rows)


def test_a_list_may_lack_three_quarters_of_its_grid():
    k = np.arange(48)
    corner = (k // 6 == 0) | (k % 6 == 0)  # the first column and the first line: 13 of 48 points
    found = heights_of(table_of(listed(corner)))
    assert found.heights.shape == (8, 6)
    assert found.sizes == pytest.approx((16.0, 18.0))
    assert np.count_nonzero(np.isfinite(found.heights)) == 13
    assert found.heights[3, 0] == 60.0
    assert found.heights[0, 2] == 6.0
    diagonal = (k // 6 == np.minimum(k % 6, 7)) | ((k // 6 > 5) & (k % 6 == 5))  # 8 of 48
    with pytest.raises(NoHeightsError, match=r"lists 8 points of a grid of \(8, 6\)"):
        heights_of(table_of(listed(diagonal)))


def test_a_list_of_two_lines_is_a_map():
    found = heights_of(table_of(listed(np.arange(48) < 12)))
    assert (found.heights.shape, found.sizes) == ((2, 6), (4.0, 18.0))


def test_places_of_a_line_scan_may_fall():
    places, heights = 0.25 * np.arange(7), np.arange(7.0) ** 2
    for order in (slice(None), slice(None, None, -1)):
        found = heights_of(table_of(as_text(np.column_stack([3.0 + places, heights])[order])))
        assert found.sizes == (1.75,)
        np.testing.assert_array_equal(found.heights, heights)


def test_a_list_of_one_line_or_with_a_point_twice_is_refused():
    k = np.arange(48)
    with pytest.raises(NoHeightsError, match="but one x alone"):
        heights_of(table_of(listed(k < 6)))
    with pytest.raises(NoHeightsError, match="lists a point twice"):
        heights_of(table_of(listed(np.append(k, 7))))


@pytest.mark.parametrize(
    ("line", "damaged"),
    [
        ("1 x 3", False),
        ("1 2 x 4", True),
        ("1 2 x 4 x", True),
        ("x y 3 4", False),
        ("1 2 3 4", False),
    ],
)
def test_a_line_of_more_than_three_numbers_with_few_words_is_damaged(line, damaged):
    if damaged:
        with pytest.raises(NoHeightsError, match="has 'x' in a line of numbers"):
            refuse_damaged([line])
    else:
        refuse_damaged([line])
