"""Runs and presses: arguments and folders that cannot be are refused in one line, before any work."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from press_cases import drawn_map, write_scene
from refused_cases import assert_refused
from slide_cases import sliding_scene

import roughsim as rs

SHARE = {"until": {"flash_temperature": 1.0}}
FIXED = "does not go with ensemble.realizations = 5, which fixes the number"
RUNS = {  # arguments of a run of a small scene
    "workers = 0": {"workers": 0},
    'until.flash is not an observable; did you mean "flash_width"': {"until": {"flash": 0.1}},
    r'until.flash_temperature = 1.0 must be less than 1, for example "1 %"': SHARE,
    "target_error = 0.3 and until = .* are both given": {
        "target_error": 0.3,
        "until": {"contact_fraction": 0.1},
    },
    "target_error = 1.5": {"target_error": 1.5},
    f"max_realizations = 9 {FIXED}": {"realizations": 5, "max_realizations": 9},
    f"^until = .* {FIXED}": {"realizations": 5, "until": {"flash_temperature": 0.1}},
    f"until = .*0.2.* {FIXED}": {"realizations": 5, "target_error": 0.2},
}
MEMBERS = {
    "seed = -1": {"seed": -1},
    "seed = 1.5": {"seed": 1.5},
    "level = 9": {"level": 9},
    "index = -1": {"index": -1},
    "index = None": {"index": None},
}


@pytest.mark.parametrize("words", RUNS)
def test_a_run_is_refused_before_any_work(words, quick, tmp_path):
    assert_refused(lambda: rs.run(quick, tmp_path / "run", **RUNS[words]), words)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("words", MEMBERS)
def test_a_realization_is_refused_by_name(words, quick):
    numerics = rs.plan(quick)
    assert_refused(lambda: rs.realize(quick, numerics, **{"seed": 1} | MEMBERS[words]), words)


@pytest.mark.parametrize("q_max", [6e3, 3e5])  # below and above C(q)
def test_levels_outside_of_the_spectrum_are_refused(quick, tmp_path, q_max):
    level = {"column": "capped", "shape": [256, 256], "q_max": q_max}
    levels = replace(quick.numerics, levels=(level,)).levels
    numerics = replace(rs.plan(quick), levels=levels)
    begin = partial(rs.run, quick, tmp_path / "run")
    for call in (
        lambda: begin(changes={"numerics.levels": [level]}),
        lambda: begin(numerics=numerics),
    ):
        assert_refused(call, r"numerics.levels\[0\].q_max = .* C\(q\)")
    assert not (tmp_path / "run").exists()


def test_two_faces_that_slide_need_waves_each(tmp_path):
    face = {"rms_height": 1e-7, "hurst": 0.8, "q_min": 6e4, "q_max": 2e5}
    heat = {"conductivity": 30, "density": 7900, "heat_capacity": 500}
    levels = [{"column": "capped", "shape": [64, 64], "q_max": 4e4}]
    changes = {"counterface": face | heat, "numerics.levels": levels}
    words = r"numerics.levels\[1\].q_max = 40000 rad/m must be above 60000 rad/m"
    assert_refused(lambda: rs.run(sliding_scene(), tmp_path / "run", changes=changes), words)
    assert not (tmp_path / "run").exists()


def test_a_study_of_a_fixed_number_has_no_target(quick, tmp_path):
    fixed = replace(quick, ensemble=replace(quick.ensemble, realizations=5))
    vary = {"sliding.nominal_pressure": [5e7]}
    begin = partial(rs.study, fixed, vary=vary, folder=tmp_path / "run")
    words = "target_error = 0.1 does not go with ensemble.realizations = 5"
    assert_refused(lambda: begin(target_error=0.1), words)
    assert not (tmp_path / "run").exists()


def test_folders_with_other_content_are_left_alone(quick, tmp_path):
    (tmp_path / "letter.txt").write_text("dear")
    assert_refused(lambda: rs.run(quick, tmp_path), "holds other files; name a new folder")
    words = "is a file; name a new folder"
    assert_refused(lambda: rs.run(quick, tmp_path / "letter.txt"), words)
    assert (tmp_path / "letter.txt").read_text() == "dear"


def test_estimates_are_asked_for_by_name(capped_run):
    for words, asked in {
        "observable = 'temperature' is unknown; choose one of flash_temperature": ["temperature"],
        "column = 'elastic' is not in this run; it has smoothed, capped": [
            "flash_temperature",
            "elastic",
        ],
    }.items():
        assert_refused(lambda given=asked: capped_run.estimate(*given), words)


@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
def test_what_cannot_be_pressed_is_refused_before_any_work(tmp_path, capped_scene):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    surface = drawn_map()
    scene = write_scene(tmp_path, surface, capped_scene)
    np.save(tmp_path / "other.npy", 1e6 * surface)
    np.save(tmp_path / "small.npy", 1e6 * surface[:40])
    press = partial(rs.press, scene, tmp_path / "run")
    of_map = "surface.topography"
    for words, call in {
        'edges = .* write "mirror" or "tile"': lambda: press(edges="window"),
        r"\[surface\] names no map; to press one": lambda: rs.press(
            "steel-1.2GPa", tmp_path / "run"
        ),
        "counterface is rough, but there is one map": lambda: press(
            changes={"counterface": {"like": "body"}}
        ),
        "names 2 maps": lambda: press(changes={of_map: ["map.npy", "other.npy"]}),
        r"the map has \(40, 64\) points; to press it takes 64": lambda: press(
            changes={of_map: "small.npy"}
        ),
    }.items():
        assert_refused(call, words)
    assert not (tmp_path / "run").exists()
