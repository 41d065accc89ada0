"""Warnings of a scene: Python's own in functions, lines in the verbs, and in what notebooks and pages show."""

import json
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.cli import main
from roughsim.outputs.run_report import header
from roughsim.show.remarks import Remark, of_several
from roughsim.surface.topography.writing import encoded

STEEP, SOFT, SHARE = (
    "rms slope = 1.",
    "body.youngs_modulus = 210 Pa",
    "the counterface takes heat, too",
)
SIDE = 0.5e-3


@pytest.fixture
def odd(tmp_path):
    """A scene file of steep slopes, a slip of a unit, and no share of the heat between two bodies."""
    body = {
        "youngs_modulus": 210.0,
        "poisson_ratio": 0.3,
        "conductivity": 30.0,
        "density": 7900.0,
        "heat_capacity": 500.0,
    }
    content = {
        "surface": {"rms_height": 5e-5, "hurst": 0.8, "q_min": 2e4, "q_max": 8e4},
        "body": body,
        "counterface": body | {"youngs_modulus": 2e11},
        "sliding": {"nominal_pressure": 10.0, "friction_coefficient": 0.2, "speed": [0.1]},
        "numerics": {
            "lengths": 1e-3,
            "levels": [{"column": "elastic", "shape": [32, 32], "q_max": 4e4}],
        },
        "ensemble": {"max_realizations": 2, "until": {}},
    }
    path = tmp_path / "odd.toml"
    with pytest.warns(rs.SceneWarning):
        path.write_text(rs.load_scene(content).to_toml())
    return path


def given(function, *arguments, **options):
    """Return the remarks on the scene that a call gives, each of which names this line and comes once."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", rs.SceneWarning)
        function(*arguments, **options)
    remarks = [str(one.message) for one in caught if one.category is rs.SceneWarning]
    assert {Path(one.filename) for one in caught if one.category is rs.SceneWarning} == {
        Path(__file__)
    }
    assert len(set(remarks)) == len(remarks)
    return remarks


def of(kind, remarks):
    """Whether there is one remark of a kind."""
    return sum(kind in remark for remark in remarks) == 1


def test_functions_of_a_scene_warn(odd, tmp_path):
    loaded = given(rs.load_scene, odd)
    assert of(STEEP, loaded)
    assert of(SOFT, loaded)
    vary = {"sliding.friction_coefficient": [0.2, 0.3]}
    calls = {
        "theory": given(rs.theory, odd),
        "plan": given(rs.plan, odd),
        "run": given(rs.run, odd, tmp_path / "run", progress=False),
        "study": given(rs.study, odd, vary=vary, folder=tmp_path / "study", progress=False),
    }
    for name, remarks in calls.items():
        assert [of(kind, remarks) for kind in (STEEP, SOFT, SHARE)] == [True] * 3, name
    # T_flash differs between the points of the study, the modulus does not
    (share,) = (remark for remark in calls["study"] if SHARE in remark)
    (soft,) = (remark for remark in calls["study"] if SOFT in remark)
    assert re.match(r"\S+ and 1 more with other numbers: sliding", share)
    assert soft.startswith(SOFT)


def test_a_sound_scene_gives_none():
    with warnings.catch_warnings():
        warnings.simplefilter("error", rs.SceneWarning)
        rs.theory(rs.load_scene("demo"))
        rs.plan("demo")


@pytest.mark.slow
def test_a_press_warns_of_the_map_but_not_of_surfaces_drawn_from_it(tmp_path):
    grid = rs.Grid((96, 96), (SIDE / 4, SIDE))  # waves are four times as long along y
    law = rs.SelfAffineSpectrum.from_rms_height(4e-7, hurst=0.8, q_min=5e4, q_max=2.5e5)
    heights = rs.synthesize(law, grid, np.random.default_rng(1))
    heights -= 70 * heights.std() * (np.random.default_rng(2).random(heights.shape) < 1e-3)
    (tmp_path / "map.nc").write_bytes(encoded(heights, rs.Grid(grid.shape, (SIDE, SIDE)), ".nc"))
    body = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "penetration_hardness": 2e9}
    heat = {"conductivity": 30.0, "density": 7900.0, "heat_capacity": 500.0}
    scene = {
        "surface": {"topography": str(tmp_path / "map.nc")},
        "body": body | heat,
        "counterface": body | heat,
        "sliding": {"nominal_pressure": 5e7, "friction_coefficient": 0.1, "speed": 20.0},
    }
    loaded, drawn = rs.load_scene(scene), given(rs.theory, scene)
    assert any("drawn surfaces" in remark for remark in drawn)
    remarks = given(rs.press, scene, tmp_path / "press", progress=False)
    assert of(SHARE, remarks)
    assert not any("drawn surfaces" in remark or "roughsim press" in remark for remark in remarks)
    assert rs.open_run(tmp_path / "press").warnings == remarks
    assert loaded.surface.psd_texture


@pytest.mark.slow
def test_pages_notebooks_and_json_have_them(odd, tmp_path):
    run = rs.run(odd, tmp_path / "run", progress=False)
    vary = {"sliding.friction_coefficient": [0.2, 0.3]}
    study = rs.study(odd, vary=vary, folder=tmp_path / "study", progress=False)
    comparison, theory = rs.compare(run), rs.theory(odd)
    shown = {
        "theory": theory._repr_html_(),
        "run": run._repr_html_(),
        "comparison": comparison._repr_html_(),
        "comparison of all": str(comparison.table()),
        "study": study._repr_html_(),
        "comparisons": rs.compare(study)._repr_html_(),
        "page": str(header(run, run.warnings)),
        "page of the study": rs.report(study, tmp_path / "study.html").read_text(),
        "theory as JSON": json.dumps(theory.to_dict()["scene_warnings"]),
        "comparison as JSON": json.dumps(comparison.to_dict()["scene_warnings"]),
        "study as JSON": json.dumps(study.to_dict()["scene_warnings"]),
    }
    for name, text in shown.items():
        assert [kind in " ".join(text.split()) for kind in (STEEP, SOFT, SHARE)] == [True] * 3, name


def test_a_run_has_the_temperature_that_mean_gives_in_its_own_contacts(odd, tmp_path):
    run = rs.run(odd, tmp_path / "all", progress=False)
    shared = rs.run(
        odd, tmp_path / "mean", changes={"sliding.heat_partition": "mean"}, progress=False
    )
    (line,) = [line for line in run.warnings if SHARE in line]
    share, mean, everything = map(
        float,
        re.search(r"share is (\S+) and T_flash (\S+) K in elastic .*, not (\S+) K", line).groups(),
    )
    # with the share measured at both, T of the run by "mean" is that of the same contacts
    assert mean == pytest.approx(shared.estimate("flash_temperature").mean[0], rel=1e-3)
    assert everything == pytest.approx(run.estimate("flash_temperature").mean[0], rel=1e-3)
    assert share == pytest.approx(mean / everything, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("verb", some(["theory", "plan", "run", "study"], 2))
def test_verbs_print_each_once_on_the_standard_error(odd, verb, tmp_path, capsys):
    words = [verb, str(odd), *(["--all"] if verb in ("theory", "plan") else [])]
    if verb in ("run", "study"):
        words += ["-o", str(tmp_path / verb)]
    if verb == "study":
        words[1] = str(tmp_path / "study.toml")
        Path(words[1]).write_text(
            'scene = "odd.toml"\n[vary]\n"sliding.friction_coefficient" = [0.2, 0.3]\n'
        )
    with warnings.catch_warnings():
        warnings.simplefilter("always", rs.SceneWarning)  # as outside of tests
        with pytest.raises(SystemExit):
            main(words)
    lines = " ".join(capsys.readouterr().err.split()).split("roughsim: warning: ")[1:]
    assert [of(kind, lines) for kind in (STEEP, SOFT, SHARE)] == [True] * 3


def test_of_several_names_where_numbers_differ():
    soft, slow = Remark("slip", "E", "E = 2 Pa"), Remark("limit", "v", "v = 0")
    hot, hotter = (Remark("limit", "T", f"T = {kelvin} K") for kelvin in ("4", "3.1e+05"))
    told = {"a": [hotter, soft], "b": [hot, soft], "c": [soft, slow]}
    assert list(map(str, of_several(told))) == [
        "E = 2 Pa",  # the most serious first
        "a and 1 more with other numbers: T = 3.1e+05 K",
        "c: v = 0",
    ]
