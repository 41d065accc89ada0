"""Lives of contact spots: patterns whose births and deaths are drawn by hand."""

import numpy as np
import pytest

from roughsim.sliding.spots import SpotLives


def watched(*pictures):
    """Lives over positions 0, 1, 2 … m of pictures in which # is contact."""
    spots = SpotLives()
    for n, picture in enumerate(pictures):
        spots.add(float(n), np.array([[c == "#" for c in row] for row in picture.split()]))
    return spots.lives()


def test_a_spot_lives_from_its_first_position_to_its_last():
    lives = watched("..... .....", "..... .##..", "..... ..##.", "..... .....")
    assert lives.distance.tolist() == [2.0]
    assert lives.pixels.tolist() == [2.0]
    assert lives.unfinished == 0


def test_what_is_there_at_the_ends_is_not_counted():
    lives = watched("##... .....", "##... ...##", "..... ...##")
    assert lives.distance.size == 0
    assert lives.unfinished == 2


def test_where_two_join_the_one_that_shares_more_lives_on():
    lives = watched("........", "###..#..", "######..", "......#.", "........")
    # the larger one goes on until position 2; the smaller one dies between 1 and 2
    assert sorted(lives.distance.tolist()) == [1.0, 1.0, 2.0]
    assert lives.unfinished == 0


def test_where_one_parts_it_lives_on_in_the_larger_piece():
    lives = watched(".......", "#####..", "###.#..", "###....", ".......")
    assert sorted(lives.distance.tolist()) == [1.0, 3.0]
    assert sorted(lives.pixels.tolist()) == pytest.approx([1.0, 11 / 3])


def test_a_spot_over_the_side_of_the_cell_is_one():
    lives = watched(".....", "#...#", "#...#", ".....")
    assert lives.distance.tolist() == [2.0]
    assert lives.pixels.tolist() == [2.0]


def test_without_spots_there_are_no_lives():
    assert watched("...", "...").distance.size == 0
    assert SpotLives().lives().unfinished == 0
