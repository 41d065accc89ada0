"""Rounds: the same counts whoever replays them, and as many members as a whole run needs."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from ladder_cases import NAME, lowest, step
from round_cases import ONE, SCATTER, half_width, least_work, numerics_of, run, totals_of

from roughsim.estimate.errors import estimate
from roughsim.estimate.levels import values_of
from roughsim.estimate.rounds import Verdict, first_counts, judge, replay
from roughsim.scene.numerics import Level, Numerics

# the first round


def test_a_run_begins_with_the_lowest_level_its_step_and_its_partner():
    assert first_counts(numerics_of("elastic", rungs=4, refined=(0, 1)), 400) == (
        12,
        6,
        0,
        0,
        6,
        0,
    )
    assert first_counts(numerics_of("elastic", refined=()), 400) == (12, 6, 0)
    assert first_counts(numerics_of("elastic", rungs=1, refined=()), 400) == (12,)
    assert first_counts(numerics_of("elastic", rungs=1), 400) == (12, 6)
    assert (
        first_counts(numerics_of("smoothed", "capped", rungs=2, refined=(0, 1)), 400)
        == (12, 6, 6, 0) * 2
    )


def test_no_level_has_more_members_than_are_allowed():
    assert first_counts(ONE, 8) == (8, 6, 0, 6)
    assert first_counts(ONE, 3) == (3, 3, 0, 3)


def test_a_slide_has_its_members_from_the_beginning():
    assert first_counts(numerics_of("elastic", refined=(), slide=8), 400) == (12, 6, 0, 8)
    assert first_counts(numerics_of("elastic", refined=(), slide=8), 5) == (5, 5, 0, 5)
    assert first_counts(replace_first(numerics_of("elastic", refined=(), slide=8)), 20) == (
        12,
        6,
        0,
        20,
    )


def replace_first(numerics):
    """The same where all realizations have the slide."""
    return replace(
        numerics, levels=(*numerics.levels[:-1], replace(numerics.levels[-1], first=None))
    )


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
        left = rng.permutation(
            np.repeat(np.arange(4), [70, 30, 20, 10])
        )  # more than the rounds ask for
        available = np.zeros(4, dtype=int)
        for level in left:
            available[level] += 1
            rounds = replay(ONE, 400, available, by_plan)
            complete = [counts for counts in PLAN if np.all(available >= counts)]
            if not complete:
                assert rounds.counts == tuple(np.minimum(available, PLAN[0]))
                assert (rounds.wanted, rounds.number) == (PLAN[0], 0)
                assert (rounds.verdict.needed, rounds.verdict.errors) == (PLAN[0], {})
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
    rounds = replay(
        ONE, 400, (99, 99, 99, 99), lambda counts: Verdict(False, None, counts, "out of reach", {})
    )
    assert (rounds.counts, rounds.wanted, rounds.number) == (PLAN[0], PLAN[0], 0)
    assert rounds.finished
    assert not rounds.met


# without a target


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
    assert seen[1][2] == 2
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
            cut_offs, sides = (
                [grid.q_max for grid in grids],
                [float(grid.shape[0]) for grid in grids],
            )
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
    return replace(
        capped_scene,
        body=body,
        sliding=replace(capped_scene.sliding, speed=(1.0,)),
        numerics=elastic,
    )


def elastic_levels(cut_offs):
    """Levels at these cut-offs, and a partner of the lowest."""
    levels = [Level("elastic", (64 * 2**k,) * 2, q) for k, q in enumerate(cut_offs)]
    return Numerics((*levels, Level("elastic", (128, 128), cut_offs[0])), (2e-3, 2e-3))


@pytest.mark.slow
@pytest.mark.statistical
def test_runs_that_stop_themselves_hold_the_truth_where_scatter_is_all(sliding_scene):
    # three levels that reach the end of C(q), and a pixel that changes nothing
    numerics = elastic_levels((1e5, 2e5))
    levels = [(10.0, 10.0, 0.25, 0.0), (9.0, 10.0, 0.25, 0.06), (10.0, 10.0, 0.25, 0.03)]
    trials, held, members = 130, 0, []
    for seed in range(trials):
        rounds, found = simulated(sliding_scene, numerics, 0.08, levels, seed)
        assert rounds.met
        held += abs(found.mean[0] - 9.0) <= found.total_error[0]
        members.append(rounds.counts[0])
    assert held / trials >= 0.92
    assert 38 < np.mean(members) < 120  # 0.08 = 1.96 · 0.25/√n would be 38


@pytest.mark.slow
@pytest.mark.statistical
def test_runs_that_choose_their_levels_hold_the_truth(sliding_scene, foretold):
    # what follows beyond a cut-off differs from the shape foretold, and the pixel's change falls faster than assumed
    means = {5e4: 8.0, 1e5: 9.2, 2e5: 9.8}
    shape = {5e4: 8.0, 1e5: 9.3, np.inf: 10.0, 2e5: 10.0}

    foretold.theory = lambda column, cut_offs, observable: np.array(
        [[shape[q]] for q in (*cut_offs, np.inf)]
    )
    numerics = elastic_levels((5e4, 1e5, 2e5))
    finer = (
        0.99  # by half the pixel, at order 2: 4/3 of it in all, and (5e4/2e5)^.7 of that at the end
    )
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
