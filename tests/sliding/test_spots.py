"""Lives of contact spots: patterns whose births and deaths are drawn by hand."""

import numpy as np
import pytest

from roughsim.sliding.spots import Lives, SpotLives, survival


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


def lives_of(ended, so_far=()):
    """Lives of spots of nine pixels, m."""
    ended, so_far = np.array(ended, float), np.array(so_far, float)
    return Lives(ended, np.full(ended.size, 9.0), 0, so_far, np.full(so_far.size, 9.0))


def test_where_all_have_died_survival_is_the_share_that_lived_for_longer():
    ended = [1.0, 2.0, 2.0, 3.0, 7.0]
    expected = [np.mean(np.array(ended) > d) for d in (0.5, 1.0, 2.0, 6.0, 7.0, 9.0)]
    assert survival(lives_of(ended), np.array([0.5, 1.0, 2.0, 6.0, 7.0, 9.0])) == pytest.approx(
        expected
    )


def test_a_spot_that_lives_still_counts_as_long_as_it_was_seen():
    # at 1: one of 4 dies; at 3: one of the 2 that have been seen for so long
    share = survival(lives_of([1.0, 3.0], [2.0, 4.0]), np.array([0.5, 1.0, 2.5, 3.0, 4.0, 5.0]))
    assert share == pytest.approx([1.0, 3 / 4, 3 / 4, 3 / 8, 3 / 8, np.nan], nan_ok=True)


def test_without_a_spot_that_was_born_nothing_is_known():
    assert np.isnan(survival(SpotLives().lives(), np.array([1.0, 2.0]))).all()


def test_spots_below_four_pixels_do_not_count():
    lives = watched("........", "##...###", ".....###", "........")
    assert lives.distance.tolist() == [2.0]  # over the side they are one, of 5 and then 3 pixels
    small = watched(".......", ".##....", ".......")
    assert np.isnan(survival(small, np.array([1.0]))).all()
    assert survival(lives, np.array([1.0, 2.0])).tolist() == [1.0, 0.0]


def test_what_is_there_at_the_end_is_seen_from_its_birth():
    lives = watched(".....", "####.", "####.")
    assert lives.so_far.tolist() == [1.5]
    assert lives.so_far_pixels.tolist() == [4.0]
    assert lives.unfinished == 1


@pytest.mark.statistical
def test_a_short_watch_does_not_make_lives_short():
    # a constant share of the spots dies at each step; the watch is as long as their mean life
    rng, fall, watch, spots = np.random.default_rng(5), 0.1, 10, 40_000
    life, born = rng.geometric(fall, spots), rng.integers(0, watch, spots)
    dead = born + life <= watch
    lives = lives_of(life[dead], watch - born[~dead] + 0.5)
    steps = np.arange(1, 8)
    expected = (1 - fall) ** steps
    assert survival(lives, steps.astype(float)) == pytest.approx(
        expected, abs=4 * 0.5 / np.sqrt(spots / 4)
    )
    assert (
        np.mean(life[dead] > 5) < expected[4] - 0.2
    )  # those alone that were seen to die live for a shorter time
