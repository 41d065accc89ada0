"""The next round: least work for an error, and levels where others are too large."""

from dataclasses import replace
from math import ceil

import numpy as np
import pytest
from ladder_cases import NAME
from round_cases import (
    ONE,
    POINTS,
    SCATTER,
    column_values,
    cost,
    half_width,
    least_work,
    numerics_of,
    run,
    totals_of,
)

from roughsim.estimate.errors import estimate
from roughsim.estimate.rounds import judge
from roughsim.scene.numerics import Level


@pytest.mark.parametrize("goal", [0.05, 0.02])
def test_members_are_wanted_where_they_take_least_work(goal):
    counts = (48, 12, 0, 6)
    verdict = judge(ONE, {NAME: goal}, 10**6, counts, totals_of(ONE, SCATTER))
    wanted = least_work(ONE, counts, goal)
    expected = [max(ceil(wanted.get(level, 0.0)), counts[level]) for level in range(4)]
    assert verdict.needed == tuple(expected)
    assert verdict.next == tuple(min(n, 2 * have) for n, have in zip(expected, counts, strict=True))
    assert not verdict.met
    assert verdict.why == "statistical"
    # any other share of the members with the same variance takes more work
    variance = sum(SCATTER[level] ** 2 / n for level, n in wanted.items())
    work = sum(cost(ONE, level) * n for level, n in wanted.items())
    for more in (0.9, 1.1):
        for level in wanted:
            other = {k: n * (more if k == level else 1.0) for k, n in wanted.items()}
            scale = sum(SCATTER[k] ** 2 / n for k, n in other.items()) / variance
            assert sum(cost(ONE, k) * n * scale for k, n in other.items()) > work


def test_the_speed_that_wants_most_counts_at_each_level():
    counts = (12, 6, 0, 6)
    scatter = {
        0: np.array([0.1, 0.3]),
        1: np.array([0.2, 0.1]),
        2: np.zeros(2),
        3: np.array([0.01, 0.02]),
    }
    verdict = judge(ONE, {NAME: 0.03}, 10**6, counts, totals_of(ONE, scatter, mean=[4.0, 2.0]))
    each = [
        least_work(ONE, counts, 0.03, {level: s[k] for level, s in scatter.items()})
        for k in range(2)
    ]
    expected = [ceil(max(by_level.get(level, 0.0) for by_level in each)) for level in (0, 1, 3)]
    assert [verdict.needed[level] for level in (0, 1, 3)] == [
        max(n, counts[level]) for n, level in zip(expected, (0, 1, 3), strict=True)
    ]


def test_the_total_error_of_the_worst_speed_decides():
    counts = (48, 12, 0, 6)
    total = np.sqrt(half_width(counts) ** 2 + 0.03**2 + 0.02**2 + 0.01**2 + 0.005**2)
    errors = {"bandwidth": np.array([0.0, 0.03]), "pixel": 0.02, "last_step": 0.01}
    totals = totals_of(ONE, SCATTER, mean=[2.0, 5.0], size=0.005, **errors)
    for goal, met in ((total * (1 + 1e-9), True), (total * (1 - 1e-9), False)):
        verdict = judge(ONE, {NAME: goal}, 10**6, counts, totals)
        assert verdict.errors == {NAME: pytest.approx(total, rel=1e-9)}
        assert verdict.met == met
        assert (verdict.next is None) == met
        if met:
            assert (verdict.why, verdict.needed) == ("the targets are met", counts)


@pytest.mark.parametrize(("worst", "why"), [([0.3, 0.2], "bandwidth"), ([0.2, 0.3], "pixel")])
def test_the_reason_is_the_largest_part_at_the_worst_speed(worst, why):
    errors = {"bandwidth": np.array([worst[0], 0.0]), "pixel": np.array([0.0, worst[1]])}
    verdict = judge(
        ONE, {NAME: 0.1}, 400, (48, 12, 0, 6), totals_of(ONE, SCATTER, mean=[2.0, -5.0], **errors)
    )
    assert verdict.why == why


def test_each_target_must_be_met():
    counts = (48, 12, 0, 6)
    totals = totals_of(ONE, SCATTER)
    error = half_width(counts)
    loose, tight = {NAME: 2.0 * error}, {"pressure_variance": 0.9 * error}
    assert judge(ONE, loose, 10**6, counts, totals).met
    assert not judge(ONE, loose | tight, 10**6, counts, totals).met
    assert set(judge(ONE, loose | tight, 10**6, counts, totals).errors) == {
        NAME,
        "pressure_variance",
    }


@pytest.mark.parametrize(("part", "added"), [("bandwidth", 2), ("pixel", 5)])
def test_an_unknown_error_adds_levels_and_meets_no_target(part, added):
    # one of two speeds suffices; members that the known errors need are there
    errors = {part: np.array([0.0, np.nan])}
    totals = totals_of(LONG, dict.fromkeys(range(7), 1e-6), mean=[2.0, -3.0], **errors)
    counts = (12, 6, 0, 0, 6, 0, 0)
    verdict = judge(LONG, {NAME: 0.02}, 400, counts, totals)
    assert not verdict.met
    assert verdict.next == tuple(2 if level == added else n for level, n in enumerate(counts))
    everywhere = (12, 6, 4, 4, 6, 4, 4)
    verdict = judge(LONG, {NAME: 0.02}, 400, everywhere, totals)
    assert (verdict.met, verdict.next, verdict.needed) == (False, None, everywhere)
    assert (
        verdict.why
        == f"out of reach: errors of {part} are unknown, and no level is left that shows them"
    )


def test_an_unknown_error_of_what_is_zero_meets_the_target():
    totals = totals_of(ONE, SCATTER, mean=[0.0, 3.0], bandwidth=np.array([np.nan, 0.0]))
    assert judge(ONE, {NAME: 0.5}, 10**6, (48, 12, 0, 6), totals).met


def test_members_are_added_to_known_errors_before_an_unknown_one_ends_the_run():
    two = numerics_of("elastic", rungs=2, refined=())
    rounds = run(two, {NAME: 0.04}, 10**6, totals_of(two, SCATTER, pixel=np.nan))
    assert rounds.finished
    assert not rounds.met
    assert "pixel are unknown" in rounds.verdict.why
    assert rounds.verdict.errors[NAME] <= 0.04


@pytest.mark.parametrize("mean", [np.nan, np.inf])
def test_a_mean_that_is_no_number_meets_no_target(mean):
    values, found = totals_of(ONE, SCATTER)(NAME, "elastic", (12, 6, 0, 6))
    lost = replace(found, mean=np.full_like(found.mean, mean))
    verdict = judge(ONE, {NAME: 0.5}, 400, (12, 6, 0, 6), lambda *_: (values, lost))
    assert not verdict.met
    assert verdict.errors == {NAME: np.inf}


def test_what_is_exactly_zero_wants_nothing():
    counts = (48, 12, 0, 6)
    verdict = judge(ONE, {NAME: 0.5}, 10**6, counts, totals_of(ONE, SCATTER, mean=[0.0, 3.0]))
    assert verdict.met
    assert verdict.errors[NAME] == pytest.approx(half_width(counts), rel=1e-9)


def test_one_member_shows_no_scatter_and_no_second_one_is_allowed():
    verdict = judge(ONE, {NAME: 0.5}, 1, (1, 1, 0, 1), totals_of(ONE, SCATTER))
    assert verdict.errors[NAME] == np.inf
    assert (verdict.met, verdict.next, verdict.why) == (False, None, "all realizations are there")


# systematic errors


def next_of(numerics, counts, goal=0.02, most=400, **errors):
    """The next round where scatter is no matter."""
    still = dict.fromkeys(range(len(numerics.levels)), 1e-6)
    return judge(numerics, {NAME: goal}, most, counts, totals_of(numerics, still, **errors))


LONG = numerics_of(
    "elastic", rungs=4, refined=(0, 1, 3)
)  # rungs 0 to 3; refined 4 of 0, 5 of 1, 6 of 3


@pytest.mark.parametrize(
    ("counts", "errors", "added"),
    [
        ((12, 6, 0, 0, 6, 0, 0), {"bandwidth": 0.03}, 2),
        ((12, 6, 6, 0, 6, 0, 0), {"bandwidth": 0.03}, 3),
        ((12, 6, 0, 0, 6, 0, 0), {"last_step": 0.03, "bandwidth": np.nan}, 2),
        ((12, 6, 0, 0, 6, 0, 0), {"pixel": 0.03}, 5),  # of the highest rung that has one
        ((12, 6, 6, 0, 6, 0, 0), {"pixel": 0.03}, 5),  # the rung 2 has none
        ((12, 6, 6, 6, 6, 0, 0), {"pixel": 0.03}, 6),
        ((12, 6, 0, 0, 6, 0, 0), {"pixel": 0.025, "bandwidth": 0.024}, 5),
        ((12, 6, 0, 0, 6, 0, 0), {"pixel": 0.024, "bandwidth": 0.025}, 2),
        ((12, 6, 0, 0, 6, 0, 0), {"pixel": 0.025, "bandwidth": 0.02, "last_step": 0.02}, 2),
        (
            (12, 6, 0, 0, 6, 6, 0),
            {"pixel": 0.03},
            2,
        ),  # no partner is left up there: a higher cut-off lowers the pixel
        ((12, 6, 0, 0, 0, 6, 0), {"pixel": 0.03}, 2),  # one lower down would not count
        ((12, 6, 6, 6, 6, 6, 0), {"bandwidth": 0.03}, 6),  # no rung is left
        # of two speeds the larger error counts
        ((12, 6, 0, 0, 6, 0, 0), {"bandwidth": np.array([0.05, 0.0]), "pixel": 0.04}, 2),
        ((12, 6, 0, 0, 6, 0, 0), {"bandwidth": 0.03, "pixel": np.array([0.04, 0.0])}, 5),
    ],
)
def test_the_level_is_added_that_lowers_the_larger_error(counts, errors, added):
    verdict = next_of(LONG, counts, mean=[2.0, -3.0], **errors)
    expected = list(counts)
    expected[added] = 2
    assert verdict.next == tuple(expected)
    assert verdict.needed == tuple(expected)
    assert next_of(LONG, counts, most=1, mean=[2.0, -3.0], **errors).next[added] == 1


@pytest.mark.parametrize(("added", "error"), [(3, "bandwidth"), (6, "pixel")])
@pytest.mark.parametrize("scatter", [1e-4, 0.3])
def test_an_added_level_begins_with_two_members_whatever_scatters_below_it(scatter, added, error):
    counts = (48, 12, 12, 0, 6, 12, 0) if added == 3 else (48, 12, 12, 12, 6, 12, 0)
    by_level = dict.fromkeys(range(7), scatter)
    verdict = judge(LONG, {NAME: 0.05}, 10**6, counts, totals_of(LONG, by_level, **{error: 0.05}))
    assert verdict.next[added] == verdict.needed[added] == 2


def test_an_added_level_without_a_correction_of_its_kind_below_it_begins_with_two_members():
    assert next_of(LONG, (12, 6, 0, 0, 0, 0, 0), pixel=0.03).next == (12, 6, 0, 0, 0, 2, 0)
    assert next_of(LONG, (12, 0, 0, 0, 6, 0, 0), bandwidth=0.03).next == (12, 2, 0, 0, 6, 0, 0)


def test_an_error_that_counts_at_one_speed_alone_is_lowered_there():
    errors = {"pixel": np.array([0.03, 0.0]), "bandwidth": np.array([0.0, 0.013])}
    verdict = next_of(LONG, (12, 6, 0, 0, 6, 0, 0), mean=[1.0, 2.0], **errors)
    assert verdict.next == (12, 6, 0, 0, 6, 2, 0)


def test_a_chain_of_partners_is_gone_through():
    chain = numerics_of("elastic", rungs=2)
    q = chain.levels[0].q_max
    chain = replace(chain, levels=(*chain.levels, Level("elastic", (4 * POINTS,) * 2, q)))
    assert next_of(chain, (12, 6, 6, 0), pixel=0.03).next == (12, 6, 6, 2)


@pytest.mark.parametrize(("share", "adds"), [(0.7, False), (0.72, True)])
def test_a_level_is_added_where_other_errors_take_more_than_half_of_the_squared_target(share, adds):
    counts = (48, 12, 0, 6)
    goal = 0.9 * half_width(counts)  # not yet met by the members
    errors = {"bandwidth": share * goal * 0.8, "pixel": share * goal * 0.6}
    verdict = judge(ONE, {NAME: goal}, 10**6, counts, totals_of(ONE, SCATTER, **errors))
    assert (verdict.next[2] > 0) == adds


def needed_for(share, counts=(48, 12, 0, 6), goal=0.05, numerics=ONE, **more):
    """Members wanted of the lowest level where other errors are this share of the target."""
    totals = totals_of(numerics, SCATTER, bandwidth=share * goal, **more)
    return judge(numerics, {NAME: goal}, 10**6, counts, totals).needed[0]


def test_members_work_for_what_other_errors_leave_of_the_target():
    two = numerics_of("elastic", rungs=2)  # no level is left to add
    counts = (48, 12, 6)
    scatter = {level: SCATTER[level] for level in range(3)}
    for share, left in (
        (0.0, 1.0),
        (0.6, 0.8),
        (0.8, 0.6),
        (0.95, 0.1**0.5),
        (3.0, 3.0 * 0.1**0.5),
    ):
        wanted = least_work(two, counts, 0.01 * left, scatter)
        assert needed_for(share, counts, 0.01, two) == ceil(wanted[0])


def test_a_level_that_is_added_is_taken_to_end_the_errors_by_levels_alone():
    counts = (48, 12, 0, 6)
    for size, left in ((0.0, 1.0), (0.6, 0.8), (0.95, np.sqrt(0.1 * (0.9**2 + 0.95**2)))):
        wanted = least_work(ONE, counts, 0.01 * left)
        assert needed_for(0.9, counts, 0.01, size=size * 0.01) == ceil(wanted[0])


def test_out_of_reach_ends_with_its_reason():
    two = numerics_of("elastic", rungs=2)
    verdict = next_of(two, (12, 6, 6), bandwidth=0.03, pixel=0.02)
    assert (verdict.met, verdict.next, verdict.needed) == (False, None, (12, 6, 6))
    assert (
        verdict.why
        == "out of reach: bandwidth errors are too large, and no level is left that lowers them"
    )
    assert "pixel errors" in next_of(two, (12, 6, 6), bandwidth=0.02, pixel=0.03).why
    assert "size errors" in next_of(two, (12, 6, 6), size=0.03).why


@pytest.mark.parametrize("size", [0.021, 0.03, 0.3])
def test_where_others_exceed_the_target_errors_by_levels_are_lowered_as_if_they_were_alone(size):
    counts, limit = (12, 6, 0, 0, 6, 0, 0), 0.02 * 0.5**0.5
    above, below = (
        next_of(LONG, counts, bandwidth=limit * (1 + x), size=size) for x in (1e-9, -1e-9)
    )
    assert above.next == (12, 6, 2, 0, 6, 0, 0)
    assert (below.met, below.next) == (False, None)
    assert (
        below.why
        == "out of reach: size errors are too large, and no level is left that lowers them"
    )


def test_no_more_members_than_are_allowed_ends_a_run():
    verdict = judge(ONE, {NAME: 0.01}, 12, (12, 12, 12, 12), totals_of(ONE, SCATTER))
    assert (verdict.met, verdict.next) == (False, None)
    assert verdict.why == "all realizations are there"
    assert judge(ONE, {NAME: 0.01}, 14, (12, 12, 12, 12), totals_of(ONE, SCATTER)).next == (14,) * 4


# columns


BOTH = numerics_of(
    "smoothed", "capped", rungs=2
)  # smoothed 0, 1, partner 2; capped 3, 4, partner 5


def test_both_columns_grow_and_the_main_one_decides():
    scatter = {0: 0.1, 1: 0.02, 2: 0.001, 3: 0.3, 4: 0.1, 5: 0.01}
    counts = (12, 6, 6, 48, 12, 6)
    verdict = judge(BOTH, {NAME: 0.05}, 10**6, counts, totals_of(BOTH, scatter))
    capped = {level: scatter[level] for level in (3, 4, 5)}
    assert verdict.errors[NAME] == pytest.approx(half_width(counts, capped), rel=1e-9)
    expected = dict.fromkeys(range(6), 0.0) | least_work(BOTH, counts, 0.05, capped)
    expected |= least_work(BOTH, counts, 0.05, {level: scatter[level] for level in (0, 1, 2)})
    assert verdict.needed == tuple(max(ceil(expected[level]), counts[level]) for level in range(6))
    loose = judge(BOTH, {NAME: 0.5}, 10**6, counts, totals_of(BOTH, scatter | {0: 9.0}))
    assert loose.met  # whatever the smoothed contact scatters by


def test_no_more_smoothed_contacts_than_capped_ones_to_pair_with():
    scatter = {0: 3.0, 1: 0.02, 2: 0.001, 3: 0.09, 4: 0.01, 5: 0.01}
    counts = (12, 6, 6, 12, 6, 6)
    verdict = judge(BOTH, {NAME: 0.05}, 10**6, counts, totals_of(BOTH, scatter))
    assert counts[3] < verdict.next[3] < 24
    assert verdict.next[0] == verdict.next[3]
    more = (30, 6, 6, 12, 6, 6)  # which are there stay
    assert judge(BOTH, {NAME: 0.05}, 10**6, more, totals_of(BOTH, scatter)).next[0] == 30


def test_a_level_is_added_to_the_column_that_needs_it():
    still = dict.fromkeys(range(12), 1e-6)
    both = numerics_of("smoothed", "capped")

    def totals(observable, column, counts):
        values = column_values(
            both, column, counts, still, bandwidth=0.03 if column == "smoothed" else 0.0
        )
        return values, estimate(observable, values)

    loose = judge(both, {NAME: 0.02}, 400, (12, 6, 0, 6) * 2, totals)
    assert loose.met  # the main column is
    counts = (12, 6, 0, 6, 12, 6, 0, 6)

    def noisy(observable, column, counts):
        scatter = still | {4: 0.3}
        values = column_values(
            both, column, counts, scatter, bandwidth=0.03 if column == "smoothed" else 0.0
        )
        return values, estimate(observable, values)

    following = judge(both, {NAME: 0.02}, 400, counts, noisy).next
    assert following == (12, 6, 2, 6, 24, 6, 0, 6)


@pytest.mark.parametrize(
    ("most", "following", "why"),
    [(400, 96, "statistical"), (48, None, "all realizations are there")],
)
def test_unknown_scatter_takes_twice_the_members_of_the_lowest_level(most, following, why):
    counts = (48, 12, 0, 6)
    known = totals_of(ONE, SCATTER)

    def totals(observable, column, counts):
        values, found = known(observable, column, counts)
        unknown = {**found.budget, "statistical": np.full(1, np.nan)}
        return values, replace(found, budget=unknown)

    verdict = judge(ONE, {NAME: 0.5}, most, counts, totals)
    assert verdict.next == (following and (following, *counts[1:]))
    assert verdict.why == why
    assert not verdict.met
    assert verdict.unknown == ((NAME, "statistical"),)
    assert judge(ONE, {NAME: 0.5}, most, counts, known).met
