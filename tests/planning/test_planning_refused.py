"""Plans that cannot be meant, or do not fit into memory, are refused in one line before any work."""

from dataclasses import replace

import pytest
from refused_cases import assert_refused
from slide_cases import sliding_scene
from small_scene import CAPPED

import roughsim as rs
from roughsim.scene import parse_scene

SCENE = parse_scene(CAPPED)


def with_level(column, points, q_max):
    level = {"column": column, "shape": [points, points], "q_max": q_max}
    return replace(SCENE, numerics=replace(SCENE.numerics, levels=(level,)))


def slide(keys):
    return sliding_scene(f'history = "sliding"\n{keys}')


LOWEST = rs.Numerics((rs.Level("capped", 64, 5e4), rs.Level("capped", 128, 1e5)), 2e-3)
SLID = rs.plan(sliding_scene())
CALLS = {
    "^target_error = 0.0 must be greater than 0, for": lambda: rs.plan(SCENE, 0.0),
    "^target_error = 1.0 must be less than 1, for": lambda: rs.plan(SCENE, 1.0),
    "^target_error = -0.1 must be greater than 0, for": lambda: rs.plan(SCENE, -0.1),
    "^target_error = nan must be a finite number, for": lambda: rs.plan(SCENE, float("nan")),
    '^target_error = "1" must be less than 1, for': lambda: rs.plan(SCENE, "1"),
    '^column = "elastic" does not fit a scene with a hardness; use "smoothed" or "capped"': lambda: rs.plan(
        with_level("elastic", 64, 1e4)
    ),
    "^memory = .* GB .* exceeds 80 % of": lambda: rs.plan(with_level("capped", 10**6, 1e5)),
    "^slid distance = 0.0002 m at 1 m/s is under 4 pixels of 6.3": lambda: rs.plan(slide('slid_distance = "0.2 mm"')),
    r"^slid_distance = 252000 m is 3.99e\+09 steps of 6.316e-05 m": lambda: rs.plan(slide('duration = "2 h"')),
    "^followed = 0.0001 m is less than 0.001 m, which is 1/16 of the slid distance or 0.5 of the side": lambda: rs.plan(
        replace(
            sliding_scene(),
            numerics=replace(
                sliding_scene().numerics,
                levels=(*SLID.levels[:-1], replace(SLID.levels[-1], followed=1e-4)),
            ),
        )
    ),
    r"^seed = -1 must be a whole number from 0": lambda: rs.realize(SCENE, LOWEST, seed=-1),
    r"^seed = True must be a whole number from 0": lambda: rs.realize(SCENE, LOWEST, seed=True),
    r"^level = 2 must be a whole number from 0 to below 2": lambda: rs.realize(SCENE, LOWEST, seed=1, level=2),
    r"^index = 0.5 must be a whole number from 0": lambda: rs.realize(SCENE, LOWEST, seed=1, index=0.5),
    "^level = . is the slide of one body over the other, which is no single contact": lambda: rs.realize(
        sliding_scene(), SLID, seed=1, level=SLID.slide
    ),
    r"^numerics.levels\[0\].q_max = 250000 rad/m must be at most 200000 rad/m, where C\(q\) ends; lower it": lambda: rs.realize(
        SCENE, rs.Numerics((rs.Level("capped", 256, 2.5e5),), 2e-3), seed=1
    ),
}  # fmt: skip


@pytest.mark.parametrize("words", CALLS)
def test_plans_are_refused(words):
    assert_refused(CALLS[words], words)


@pytest.mark.parametrize(
    ("amount", "scene", "words"),
    [
        (1e7, "steel-2.0GPa", r"^memory = 0.0315 GB \(largest grid\) exceeds 80 % of the 0.01 GB"),
        (1e6, sliding_scene(), r"^memory = 0.000886 GB \(the slide: .* exceeds 80 % of the"),
    ],
)
def test_first_rounds_that_do_not_fit_are_refused(memory, amount, scene, words):
    memory(amount)
    with pytest.raises(rs.ResolutionError, match=words):
        rs.plan(scene)


def test_refused_runs_leave_no_folder(tmp_path):
    with pytest.raises(rs.ResolutionError, match="^slid distance = 0.0002 m at 1 m/s is under 4"):
        rs.run(slide('slid_distance = "0.2 mm"'), tmp_path / "run")
    assert not (tmp_path / "run").exists()
