"""Plans of scenes with history = "sliding": the slide that they add, its memory and cost, and what is refused."""

from dataclasses import replace

import pytest
from slide_cases import sliding_scene

import roughsim as rs
from roughsim.planning import sliding as planning_slide
from roughsim.planning.realization import slide_problem


def test_the_memory_of_both_bodies_is_planned():
    scene = sliding_scene()
    reason = rs.plan(scene).reasons[-1]
    words = "0.00089 GB for the slide: both bodies remember their heat, at each speed"
    assert reason.row == ("memory", "0.25 GB per worker", words)


def test_the_plan_adds_a_slide_on_the_lowest_rung():
    scene = sliding_scene()
    free = replace(scene, numerics=replace(scene.numerics, levels=scene.numerics.levels[:1]))
    numerics = rs.plan(free)
    assert numerics.levels == (
        free.numerics.levels[0],
        replace(free.numerics.levels[0], column="sliding", first=8),
    )
    values = {reason.quantity: reason for reason in numerics.reasons}
    assert values["slid distance"].value == "1 mm"
    assert values["slid distance"].text.startswith(
        "0.5 lengths of the cell, in 16 steps of 63.2 µm"
    )
    assert values["slides"].value == "4"  # max_realizations
    more = replace(free, ensemble=replace(free.ensemble, max_realizations=20))
    assert {reason.quantity: reason.value for reason in rs.plan(more).reasons}["slides"] == "8"
    assert values["snapshots"].value == "16 positions, up to 0.2 MB"  # of 32² points, at two speeds


def test_a_speed_that_ends_earlier_costs_no_more_afterwards():
    scene = sliding_scene()
    problem = slide_problem(scene, rs.plan(scene))
    both = 1 + 0.75**3  # the coarser slide has fewer points and steps
    contact, heat = (
        seconds * problem.grid.points * both for seconds in planning_slide.STEP_SECONDS
    )
    assert planning_slide.seconds_of_slide(problem) == pytest.approx(16 * (contact + 2 * heat))
    half = planning_slide.seconds_of_slide(replace(problem, distances=(0.5e-3, 1e-3)))
    assert half == pytest.approx(
        16 * contact + (8 + 16) * heat
    )  # one speed is followed over half of the steps


def test_the_plan_of_a_frozen_scene_says_what_sliding_would_change(capped_scene):
    (said,) = [reason for reason in rs.plan(capped_scene).reasons if reason.quantity == "history"]
    assert 'With history = "sliding" both faces move' in said.text
    smooth = replace(capped_scene.counterface, like=None, youngs_modulus=2e11, poisson_ratio=0.3)
    alone = replace(
        capped_scene,
        counterface=smooth,
        sliding=replace(capped_scene.sliding, heat_partition="all"),
    )
    assert [reason for reason in rs.plan(alone).reasons if reason.quantity == "history"] == []
