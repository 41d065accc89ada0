"""Rounds: the same counts whoever replays them, least work for an error, and levels where others are too large."""

from dataclasses import replace
from itertools import pairwise
from math import ceil

import numpy as np
import pytest
from ladder_cases import NAME, lowest, step
from scipy import stats

from roughsim.estimate.errors import estimate
from roughsim.estimate.levels import Values, values_of
from roughsim.estimate.rounds import MEMBER, Verdict, first_counts, judge, replay
from roughsim.scene.numerics import Level, Numerics

LENGTH, POINTS = 1e-3, 32


def numerics_of(*columns, rungs=3, partners=(0,), slide=None):
    """Numerics whose columns have doubling cut-offs, then partners of these rungs; levels count through the columns."""
    levels = []
    for column in columns:
        points = [POINTS * 2**k for k in range(rungs)]
        own = [Level(column, (n, n), np.pi * n / LENGTH / 2) for n in points]
        own += [replace(own[k], shape=(2 * points[k],) * 2) for k in partners]
        levels += own
    if slide is not None:
        levels.append(Level("sliding", (POINTS, POINTS), levels[0].q_max, first=slide))
    return Numerics(tuple(levels), (LENGTH, LENGTH))


ONE = numerics_of("elastic")  # rungs 0, 1, 2 and the partner 3 of 0


# the first round


def test_a_run_begins_with_the_lowest_level_its_step_and_its_partner():
    assert first_counts(numerics_of("elastic", rungs=4, partners=(0, 1)), 400) == (12, 6, 0, 0, 6, 0)
    assert first_counts(numerics_of("elastic", partners=()), 400) == (12, 6, 0)
    assert first_counts(numerics_of("elastic", rungs=1, partners=()), 400) == (12,)
    assert first_counts(numerics_of("elastic", rungs=1), 400) == (12, 6)
    assert first_counts(numerics_of("smoothed", "capped", rungs=2, partners=(0, 1)), 400) == (12, 6, 6, 0) * 2


def test_no_level_has_more_members_than_are_allowed():
    assert first_counts(ONE, 8) == (8, 6, 0, 6)
    assert first_counts(ONE, 3) == (3, 3, 0, 3)


def test_a_slide_has_its_members_from_the_beginning():
    assert first_counts(numerics_of("elastic", partners=(), slide=8), 400) == (12, 6, 0, 8)
    assert first_counts(numerics_of("elastic", partners=(), slide=8), 5) == (5, 5, 0, 5)
    assert first_counts(replace_first(numerics_of("elastic", partners=(), slide=8)), 20) == (12, 6, 0, 20)


def replace_first(numerics):
    """The same where all realizations have the slide."""
    return replace(numerics, levels=(*numerics.levels[:-1], replace(numerics.levels[-1], first=None)))


# replay

PLAN = [(12, 6, 0, 6), (20, 6, 0, 6), (40, 12, 6, 6), (55, 20, 12, 6)]  # rounds of a run


def by_plan(counts):
    following = PLAN.index(counts) + 1
    if following == len(PLAN):
        return Verdict(True, None, counts, "the targets are met", {})
    return Verdict(False, PLAN[following], PLAN[-1], "statistical", {})


def test_rounds_are_those_whatever_the_order_in_which_members_are_computed():
    rng = np.random.default_rng(1)
    for _ in range(6):
        left = rng.permutation(np.repeat(np.arange(4), [70, 30, 20, 10]))  # more than the rounds ask for
        available = np.zeros(4, dtype=int)
        for level in left:
            available[level] += 1
            rounds = replay(ONE, 400, available, by_plan)
            complete = [counts for counts in PLAN if np.all(available >= counts)]
            if not complete:
                assert rounds.counts == tuple(np.minimum(available, PLAN[0]))
                assert (rounds.wanted, rounds.number, rounds.verdict) == (PLAN[0], 0, None)
                assert not rounds.finished
                assert not rounds.met
                continue
            assert rounds.counts == complete[-1]
            assert rounds.verdict == by_plan(complete[-1])
            ended = complete[-1] == PLAN[-1]
            assert (rounds.finished, rounds.met) == (ended, ended)
            assert rounds.wanted == PLAN[min(len(complete), len(PLAN) - 1)]
            assert rounds.number == min(len(complete), len(PLAN) - 1)
        assert rounds.counts == PLAN[-1]


def test_only_complete_rounds_are_judged_and_each_once():
    judged = []
    replay(ONE, 400, (39, 50, 50, 50), lambda counts: judged.append(counts) or by_plan(counts))
    assert judged == PLAN[:2]


def test_a_run_may_end_without_meeting_its_targets():
    rounds = replay(ONE, 400, (99, 99, 99, 99), lambda counts: Verdict(False, None, counts, "out of reach", {}))
    assert (rounds.counts, rounds.wanted, rounds.number) == (PLAN[0], PLAN[0], 0)
    assert rounds.finished
    assert not rounds.met


# what a round says


def column_values(numerics, column, counts, scatter, *, mean=2.0, **errors):
    """Values of a column whose levels have these relative standard deviations by a member, (speeds,) or one number.

    `errors` are relative: bandwidth, pixel, last_step.
    """
    rows = {}
    mean = np.atleast_1d(np.asarray(mean, dtype=float))
    for level in numerics.of_column(column):
        n = counts[level]
        if n:
            pattern = np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1)
            share = pattern / (np.linalg.norm(pattern) or 1.0) * np.sqrt(n - 1.0) / n
            rows[numerics.stream(level)] = np.outer(share, scatter[level] * mean)
    parts = {name: np.abs(mean) * errors.get(name, 0.0) for name in ("bandwidth", "pixel")}
    parts["last step"] = np.abs(mean) * errors.get("last_step", 0.0)
    return Values(mean, mean, rows, parts)


def totals_of(numerics, scatter, *, size=0.0, **errors):
    """Totals of any observable, of all columns alike."""

    def totals(observable, column, counts):
        values = column_values(numerics, column, counts, scatter, **errors)
        return values, estimate(observable, values, size=size)

    return totals


def cost(numerics, level):
    """Modelled cost of a member: what any takes, and points^1.25 of its grid and of the grid below."""
    grids = [numerics.levels[level]] if numerics.below(level) is None else []
    if numerics.below(level) is not None:
        grids = [numerics.levels[level], numerics.levels[numerics.below(level)]]
    return MEMBER + sum((grid.shape[0] * grid.shape[1]) ** 1.25 for grid in grids)


def quantile_of(parts, counts, times=1.0):
    """Half-width over standard error: Student's t, of Satterthwaite's degrees of freedom, for runs that stop.

    `times` as many degrees of freedom as these members have.
    """
    variances = {level: parts[level] ** 2 / counts[level] for level in parts if counts[level]}
    worth = sum(v**2 / (counts[level] - 1) for level, v in variances.items())
    freedom = times * sum(variances.values()) ** 2 / worth
    return stats.t.ppf(0.975, freedom) * np.sqrt(1.0 + 2.0 / freedom)


SCATTER = {0: 0.3, 1: 0.1, 2: 0.05, 3: 0.02}


def least_work(numerics, counts, goal, scatter=SCATTER):
    """N_l ∝ √(V_l/C_l) so that z² Σ V_l/N_l is goal², with the z of as many degrees of freedom as it takes."""
    used = [level for level in scatter if counts[level]]
    error = np.sqrt(sum(scatter[level] ** 2 / counts[level] for level in used))
    times = (quantile_of(scatter, counts) * error / goal) ** 2
    z = quantile_of(scatter, counts, max(times, 1.0))
    ratio = {level: scatter[level] / np.sqrt(cost(numerics, level)) for level in used}
    scale = (z / goal) ** 2 * sum(scatter[level] ** 2 / ratio[level] for level in used)
    return {level: scale * ratio[level] for level in used}


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
    scatter = {0: np.array([0.1, 0.3]), 1: np.array([0.2, 0.1]), 2: np.zeros(2), 3: np.array([0.01, 0.02])}
    verdict = judge(ONE, {NAME: 0.03}, 10**6, counts, totals_of(ONE, scatter, mean=[4.0, 2.0]))
    each = [least_work(ONE, counts, 0.03, {level: s[k] for level, s in scatter.items()}) for k in range(2)]
    expected = [ceil(max(by_level.get(level, 0.0) for by_level in each)) for level in (0, 1, 3)]
    assert [verdict.needed[level] for level in (0, 1, 3)] == [
        max(n, counts[level]) for n, level in zip(expected, (0, 1, 3), strict=True)
    ]


def half_width(counts, scatter=SCATTER):
    used = [level for level in scatter if counts[level]]
    return quantile_of(scatter, counts) * np.sqrt(sum(scatter[level] ** 2 / counts[level] for level in used))


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
    verdict = judge(ONE, {NAME: 0.1}, 400, (48, 12, 0, 6), totals_of(ONE, SCATTER, mean=[2.0, -5.0], **errors))
    assert verdict.why == why


def test_each_target_must_be_met():
    counts = (48, 12, 0, 6)
    totals = totals_of(ONE, SCATTER)
    error = half_width(counts)
    loose, tight = {NAME: 2.0 * error}, {"pressure_variance": 0.9 * error}
    assert judge(ONE, loose, 10**6, counts, totals).met
    assert not judge(ONE, loose | tight, 10**6, counts, totals).met
    assert set(judge(ONE, loose | tight, 10**6, counts, totals).errors) == {NAME, "pressure_variance"}


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
    assert verdict.why == f"out of reach: errors of {part} are unknown, and no level is left that shows them"


def test_an_unknown_error_of_what_is_zero_meets_the_target():
    totals = totals_of(ONE, SCATTER, mean=[0.0, 3.0], bandwidth=np.array([np.nan, 0.0]))
    assert judge(ONE, {NAME: 0.5}, 10**6, (48, 12, 0, 6), totals).met


def test_members_are_added_to_known_errors_before_an_unknown_one_ends_the_run():
    two = numerics_of("elastic", rungs=2, partners=())
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


LONG = numerics_of("elastic", rungs=4, partners=(0, 1, 3))  # rungs 0 to 3; partners 4 of 0, 5 of 1, 6 of 3


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
        ((12, 6, 0, 0, 6, 6, 0), {"pixel": 0.03}, 2),  # no partner is left up there: a higher cut-off lowers the pixel
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


SHRINKING = replace(  # the rung 3 and its partner in half the cell
    LONG,
    levels=tuple(
        replace(level, cell="half", shape=(level.shape[0] // 2,) * 2) if i in {3, 6} else level
        for i, level in enumerate(LONG.levels)
    ),
)


@pytest.mark.parametrize(("added", "error"), [(3, "bandwidth"), (6, "pixel")])
@pytest.mark.parametrize(
    ("numerics", "fall", "scatter", "share"),
    [
        (LONG, 0.5, 1e-4, 2),
        (LONG, 0.5, 0.004, None),
        (LONG, 0.5, 0.008, None),
        (LONG, 0.5, 0.3, 6),
        (SHRINKING, 2.0, 0.003, None),
    ],
)
def test_an_added_level_begins_with_its_share_by_the_variance_foretold(numerics, fall, scatter, share, added, error):
    # below the rung 3 is the correction 2, below the partner 6 the one of the rung 1
    counts = (48, 12, 12, 0, 6, 12, 0) if added == 3 else (48, 12, 12, 12, 6, 12, 0)
    below = 2 if added == 3 else 5
    by_level = {level: scatter for level in range(7)} | {0: 0.3, 1: 2.0 * scatter, 4: 2.0 * scatter}
    goal = 0.05
    verdict = judge(numerics, {NAME: goal}, 10**6, counts, totals_of(numerics, by_level, **{error: goal}))
    there = {level: by_level[level] for level in range(7) if counts[level]}
    wanted = ceil(least_work(numerics, counts, goal * np.sqrt(0.5), there)[below])
    first = ceil(wanted * np.sqrt(fall * cost(numerics, below) / cost(numerics, added)))
    assert verdict.next[added] == verdict.needed[added] == (share or max(first, 2))


def test_of_two_targets_the_one_that_wants_more_decides_how_an_added_level_begins():
    counts = (48, 12, 0, 6)
    totals = totals_of(ONE, SCATTER, bandwidth=np.nan)
    first = [judge(ONE, {NAME: goal}, 10**6, counts, totals).next[2] for goal in (0.05, 0.4)]
    assert first[0] > first[1] >= 2
    for goals in ({NAME: 0.05, "pressure_variance": 0.4}, {NAME: 0.4, "pressure_variance": 0.05}):
        assert judge(ONE, goals, 10**6, counts, totals).next[2] == first[0]


def test_an_added_level_without_a_correction_of_its_kind_below_it_begins_as_the_first_round_does():
    assert next_of(LONG, (12, 6, 0, 0, 0, 0, 0), pixel=0.03).next == (12, 6, 0, 0, 0, 6, 0)
    assert next_of(LONG, (12, 0, 0, 0, 6, 0, 0), bandwidth=0.03).next == (12, 6, 0, 0, 6, 0, 0)


@pytest.mark.parametrize(("members", "assumed"), [(5, 0.05), (6, 1e-6)])
def test_of_fewer_than_six_members_the_variance_is_at_least_a_quarter_of_that_below(members, assumed):
    counts, goal = (48, 12, members, 0, 6, 0, 0), 0.02
    scatter = {0: 0.3, 1: 0.1, 2: 1e-6, 4: 0.02}
    error = np.sqrt(sum(scatter[level] ** 2 / counts[level] for level in scatter))
    times = (quantile_of(scatter, counts) * error / goal) ** 2
    z = quantile_of(scatter, counts, times)
    spread = scatter | {2: assumed}
    total = sum(spread[level] * np.sqrt(cost(LONG, level)) for level in spread)
    wanted = assumed / np.sqrt(cost(LONG, 2)) * total * (z / goal) ** 2
    verdict = judge(LONG, {NAME: goal}, 10**6, counts, totals_of(LONG, scatter))
    assert verdict.needed[2] == max(ceil(wanted), members)
    assert (wanted > members) == (members == 5)


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
    for share, left in ((0.0, 1.0), (0.6, 0.8), (0.8, 0.6), (0.95, 0.2**0.5), (3.0, 3.0 * 0.2**0.5)):
        wanted = least_work(two, counts, 0.01 * left, scatter)
        assert needed_for(share, counts, 0.01, two) == ceil(wanted[0])


def test_a_level_that_is_added_is_taken_to_leave_half_of_the_squared_target_to_members():
    counts = (48, 12, 0, 6)
    wanted = least_work(ONE, counts, 0.01 * np.sqrt(0.5))
    assert needed_for(0.9, counts, 0.01) == ceil(wanted[0])


def test_out_of_reach_ends_with_its_reason():
    two = numerics_of("elastic", rungs=2)
    verdict = next_of(two, (12, 6, 6), bandwidth=0.03, pixel=0.02)
    assert (verdict.met, verdict.next, verdict.needed) == (False, None, (12, 6, 6))
    assert verdict.why == "out of reach: bandwidth errors are too large, and no level is left that lowers them"
    assert "pixel errors" in next_of(two, (12, 6, 6), bandwidth=0.02, pixel=0.03).why
    assert "size errors" in next_of(two, (12, 6, 6), size=0.03).why


def test_no_more_members_than_are_allowed_ends_a_run():
    verdict = judge(ONE, {NAME: 0.01}, 12, (12, 12, 12, 12), totals_of(ONE, SCATTER))
    assert (verdict.met, verdict.next) == (False, None)
    assert verdict.why == "all realizations are there"
    assert judge(ONE, {NAME: 0.01}, 14, (12, 12, 12, 12), totals_of(ONE, SCATTER)).next == (14,) * 4


# columns


BOTH = numerics_of("smoothed", "capped", rungs=2)  # smoothed 0, 1, partner 2; capped 3, 4, partner 5


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
        values = column_values(both, column, counts, still, bandwidth=0.03 if column == "smoothed" else 0.0)
        return values, estimate(observable, values)

    loose = judge(both, {NAME: 0.02}, 400, (12, 6, 0, 6) * 2, totals)
    assert loose.met  # the main column is
    counts = (12, 6, 0, 6, 12, 6, 0, 6)

    def noisy(observable, column, counts):
        scatter = still | {4: 0.3}
        values = column_values(both, column, counts, scatter, bandwidth=0.03 if column == "smoothed" else 0.0)
        return values, estimate(observable, values)

    following = judge(both, {NAME: 0.02}, 400, counts, noisy).next
    assert following == (12, 6, 2, 6, 24, 6, 0, 6)


# without a target


def run(numerics, until, most, totals, available=10**9):
    return replay(
        numerics, most, (available,) * len(numerics.levels), lambda c: judge(numerics, until, most, c, totals)
    )


def test_without_a_target_a_run_ends_with_all_realizations_of_the_lowest_level():
    rounds = run(ONE, {}, 100, totals_of(ONE, SCATTER))
    assert rounds.finished
    assert not rounds.met
    assert rounds.counts[0] == 100
    assert rounds.verdict.why == "all realizations are there"
    assert rounds.verdict.errors == {}
    # the others in the shares that take least work
    wanted = least_work(ONE, rounds.counts, 1.0)
    assert rounds.counts[1] == pytest.approx(max(6, 100 * wanted[1] / wanted[0]), abs=2)
    assert rounds.counts[3] == pytest.approx(max(6, 100 * wanted[3] / wanted[0]), abs=2)


def test_without_a_target_rounds_double_at_most_and_add_levels_for_one_percent():
    counts, seen = first_counts(ONE, 100), []
    while counts is not None:
        seen.append(counts)
        counts = judge(ONE, {}, 100, counts, totals_of(ONE, SCATTER, bandwidth=0.011)).next
    assert [c[0] for c in seen] == [12, 24, 48, 96, 100]
    assert seen[1][2] == 6
    assert run(ONE, {}, 100, totals_of(ONE, SCATTER, bandwidth=0.007)).counts[2] == 0


def test_without_scatter_and_without_a_target_all_realizations_are_computed():
    still = dict.fromkeys(range(4), 0.0)
    assert run(ONE, {}, 50, totals_of(ONE, still)).counts[0] == 50
    assert run(ONE, {}, 50, totals_of(ONE, still, mean=0.0)).counts[0] == 50


def test_few_realizations_are_all_computed_in_the_first_round():
    rounds = run(ONE, {}, 4, totals_of(ONE, SCATTER))
    assert (rounds.counts, rounds.number, rounds.finished) == ((4, 4, 0, 4), 0, True)


# targets that change


def test_a_tighter_target_goes_on_and_a_wider_one_stops_earlier():
    totals = totals_of(ONE, SCATTER)
    wide, tight = (run(ONE, {NAME: goal}, 10**6, totals) for goal in (0.04, 0.02))
    assert wide.met
    assert tight.met
    assert half_width(wide.counts) <= 0.04
    assert half_width(tight.counts) <= 0.02
    assert all(a <= b for a, b in zip(wide.counts, tight.counts, strict=True))

    # with the members of the one run, the other comes to what it comes to by itself
    def with_those_of(done, goal):
        return replay(ONE, 10**6, done.counts, lambda c: judge(ONE, {NAME: goal}, 10**6, c, totals))

    assert with_those_of(tight, 0.04) == wide
    contacts_along = with_those_of(wide, 0.02)
    assert not contacts_along.finished
    assert all(a <= b for a, b in zip(contacts_along.counts, wide.counts, strict=True))
    assert any(want > have for want, have in zip(contacts_along.wanted, wide.counts, strict=True))


# as often as stated


def simulated(scene, numerics, goal, levels, seed):
    """A run whose members are drawn, by level (fine mean, coarse mean, scatter, scatter of the step), to its end."""
    rng = np.random.default_rng(seed)
    most = 600
    rows = []
    for fine, coarse, scatter, of_step in levels:
        common = 1.0 + scatter * rng.standard_normal((most, 1))
        rows.append((fine * (common + of_step * rng.standard_normal((most, 1))), coarse * common))

    def pairs(counts):
        result = []
        for level in numerics.of_column("elastic"):
            n = counts[level]
            if not n:
                continue
            fine, coarse = (x[:n] for x in rows[level])
            below = numerics.below(level)
            if below is None:
                result.append(lowest(fine, numerics.levels[level].q_max))
                continue
            grids = numerics.levels[below], numerics.levels[level]
            cut_offs, sides = [grid.q_max for grid in grids], [float(grid.shape[0]) for grid in grids]
            result.append(step(level, fine, coarse, cut_offs, sides=sides))
        return result

    def totals(observable, column, counts):
        values = values_of(scene, column, observable, pairs(counts))
        return values, estimate(observable, values)

    rounds = run(numerics, {NAME: goal}, most, totals)
    return rounds, totals(NAME, "elastic", rounds.counts)[1]


@pytest.fixture
def sliding_scene(capped_scene):
    """Elastic contact at one speed; C(q) ends at 2e5 rad/m."""
    body = replace(capped_scene.body, penetration_hardness=None)
    elastic = replace(capped_scene.numerics, levels=None)
    return replace(capped_scene, body=body, sliding=replace(capped_scene.sliding, speed=(1.0,)), numerics=elastic)


def elastic_levels(cut_offs):
    """Levels at these cut-offs, and a partner of the lowest."""
    levels = [Level("elastic", (64 * 2**k,) * 2, q) for k, q in enumerate(cut_offs)]
    return Numerics((*levels, Level("elastic", (128, 128), cut_offs[0])), (2e-3, 2e-3))


@pytest.mark.statistical
def test_runs_that_stop_themselves_hold_the_truth_where_scatter_is_all(sliding_scene):
    # three levels that reach the end of C(q), and a pixel that changes nothing
    numerics = elastic_levels((1e5, 2e5))
    levels = [(10.0, 10.0, 0.25, 0.0), (9.0, 10.0, 0.25, 0.06), (10.0, 10.0, 0.25, 0.03)]
    trials, held, members = 260, 0, []
    for seed in range(trials):
        rounds, found = simulated(sliding_scene, numerics, 0.08, levels, seed)
        assert rounds.met
        held += abs(found.mean[0] - 9.0) <= found.total_error[0]
        members.append(rounds.counts[0])
    assert held / trials >= 0.92
    assert 38 < np.mean(members) < 120  # 0.08 = 1.96 · 0.25/√n would be 38


@pytest.mark.statistical
def test_runs_that_choose_their_levels_hold_the_truth(sliding_scene, foretold):
    # what follows beyond a cut-off differs from the shape foretold, and the pixel's change falls faster than assumed
    means = {5e4: 8.0, 1e5: 9.2, 2e5: 9.8}
    shape = {5e4: 8.0, 1e5: 9.3, np.inf: 10.0, 2e5: 10.0}

    foretold.theory = lambda column, cut_offs, observable: np.array([[shape[q]] for q in (*cut_offs, np.inf)])
    numerics = elastic_levels((5e4, 1e5, 2e5))
    finer = 0.99  # by half the pixel, at order 2: 4/3 of it in all, and (5e4/2e5)^.7 of that at the end
    truth = 9.8 * (1.0 - 4 / 3 * 0.01 * 0.25**0.7)
    values = list(means.values())
    levels = [(values[0], values[0], 0.2, 0.0)]
    levels += [(b, a, 0.2, 0.05) for a, b in pairwise(values)]
    levels.append((values[0] * finer, values[0], 0.2, 0.01))
    trials, held, used = 200, 0, 0
    for seed in range(trials):
        rounds, found = simulated(sliding_scene, numerics, 0.03, levels, seed)
        assert rounds.met
        held += abs(found.mean[0] - truth) <= found.total_error[0]
        used += rounds.counts[2] > 0
    assert held / trials >= 0.92
    assert used > 0  # the highest level, by runs that needed it
