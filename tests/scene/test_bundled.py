"""The bundled scenes: each is read, planned with a reason for each choice, predicted, and computed at toy size."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scene_keys import KEYS
from soft_scene import RUBBER

import roughsim as rs
from roughsim import cli
from roughsim.comparison.tables import theory_dict
from roughsim.scene import BLANK, SceneError, bundled_scenes, parse_scene, scene_text

LINES = {"cell", "CPU time", "workers", "tolerance", "memory"}


def test_the_scenes_are_these():
    assert bundled_scenes() == (
        "demo",
        "granite",
        "steel-0.5GPa",
        "steel-1.2GPa",
        "steel-2.0GPa",
    )


@pytest.mark.parametrize("name", bundled_scenes())
def test_a_bundled_scene_is_commented_throughout(name):
    text = scene_text(name)
    assert text.startswith("# ")
    assert max(map(len, text.splitlines())) <= 125
    keys = [line for line in text.splitlines() if re.match(r"[a-z_]+ = ", line)]
    bare = [line.split(" = ")[0] for line in keys if "#" not in line]
    assert set(bare) <= {
        "title",
        "poisson_ratio",
        "density",
        "heat_capacity",
        "conductivity",
        "speed",
    } | {"friction_coefficient"}


def test_numbers_nobody_measured_are_marked_as_assumed():
    assert "ASSUMED" in scene_text("granite")
    assert "assumed" in rs.load_scene("granite").title


@pytest.mark.parametrize("name", ["granite", RUBBER])
def test_scenes_beyond_any_grid_are_cut_with_a_word_and_say_what_is_left_to_q_max(name):
    scene = rs.load_scene(name)
    numerics = rs.plan(scene)
    assert {reason.quantity for reason in numerics.reasons} >= LINES | set(numerics.columns)
    assert numerics.columns == (("elastic",) if scene.elastic else ("smoothed", "capped"))
    side = 4096 if scene.elastic else 2048
    for column in numerics.columns:
        top = numerics.levels[numerics.of_column(column)[-1]]
        assert top.q_max == pytest.approx(side * 2 * np.pi / (3 * numerics.lengths[0]) * top.parts)
        assert top.shape == (side, side)
        last = [reason for reason in numerics.reasons if reason.quantity == column][-1].text
        assert f"C(q) goes on to {scene.spectrum.breaks[-1]:.3g} rad/m" in last


# rubber touches less than steel and runs hot at its finest roughness; rock yields at the short waves alone
@pytest.mark.parametrize(
    ("name", "contact", "yielded"),
    [(RUBBER, (1e-3, 1e-2), (0, 0)), ("granite", (4e-4, 6e-4), (0.9, 1))],
)
def test_theory_of_the_assumed_scenes_is_of_the_size_their_comments_say(name, contact, yielded):
    told = theory_dict(rs.load_scene(name))
    assert contact[0] < told["contact_fraction"] < contact[1]
    assert yielded[0] <= told["plastic_fraction"] / told["contact_fraction"] <= yielded[1]
    assert np.all(np.diff(told["flash_temperature"]) > 0)
    assert np.all(
        np.diff(told["heat_partition"]) > 0
    )  # more heat stays in the body over which the spots slide
    assert told["heat_partition"] == told["heat_partition_theory"]


@pytest.mark.parametrize("name", bundled_scenes())
def test_a_bundled_scene_computes_at_toy_size(name):
    scene = rs.load_scene(name)
    column = "elastic" if scene.elastic else "capped"
    length = 4 * 2 * np.pi / scene.spectrum.breaks[0]
    level = {"column": column, "shape": [64, 64], "q_max": 0.9 * 64 * np.pi / length}
    toy = replace(
        scene, numerics=replace(scene.numerics, levels=(level,), lengths=(length, length))
    )
    one = rs.realize(toy, rs.plan(toy), seed=1, level=0, index=0)
    assert one.observables.flash_temperature.shape == (len(scene.speeds),)
    assert np.all(one.observables.flash_temperature > 0)
    assert 0 < one.contact.contact_fraction < 0.5
    assert one.contact.pressure.mean() == pytest.approx(scene.sliding.nominal_pressure, rel=1e-9)
    assert one.contact.pressure.max() <= scene.penetration_hardness


# --- the form to fill in


def filled(text):
    """The form with every key written out, as its own examples have it."""
    return re.sub(r"(?m)^# (?=\[|[a-z_]+ = )", "", text)


# keys that need or exclude others
RIVALS = (
    "rms_slope|spectrum|topography|topography_size|topography_unit|topography_channel|topography_cut|topography_direction|topography_fill|psd_file|psd_convention|psd_source"
    "|slid_distance|realizations|background_temperature|lay|lay_direction"
)


def without(text, keys):
    return re.sub(rf"(?m)^({keys}) = .*\n", "", text)


def test_the_form_holds_every_key_and_says_what_is_missing():
    form = scene_text(BLANK)
    keys = KEYS - {
        "psd",
        "psd_error",
        "psd_texture",
        "psd_directions",
        "psd_filled",
        "psd_scans",
        "column",
        "shape",
        "cell",
        "first",
        "followed",
        "thickness",
    }
    assert {key for key in keys if not re.search(rf"(?m)^# {key} = ", form)} == set()
    with pytest.raises(
        SceneError, match=r"^blank: surface.rms_height is missing; give exactly one of"
    ):
        rs.load_scene(BLANK)


def test_the_form_filled_in_with_its_own_examples_is_a_scene():
    text = filled(scene_text(BLANK))
    text = without(text, RIVALS)
    scene = parse_scene(text)
    assert scene.counterface.like == "body"
    assert (scene.theory.gamma, scene.ensemble.seed, scene.ensemble.max_realizations) == (
        0.45,
        1,
        400,
    )
    assert rs.plan(scene).levels[0].shape == (1024, 1024)


def test_the_form_s_defaults_are_the_defaults():
    text = filled(scene_text(BLANK))
    text = without(text, f"{RIVALS}|tolerance|lengths|levels")
    written = parse_scene(text)
    bare = parse_scene(text[: text.index("[theory]")])
    assert (written.theory, written.ensemble) == (bare.theory, bare.ensemble)


def test_new_prints_the_form(capsys):
    with pytest.raises(SystemExit):
        cli.main(["new", "blank"])
    assert capsys.readouterr().out == scene_text(BLANK)


@pytest.mark.slow
def test_plan_realize_run_and_compare_take_a_name_a_path_or_a_folder(tmp_path):
    path, folder = tmp_path / "mine.toml", tmp_path / "run"
    path.write_text(scene_text("demo"))
    numerics = rs.plan("demo")
    assert rs.plan(path) == rs.plan(rs.load_scene("demo")) == numerics
    fraction = rs.realize("demo", numerics, seed=1).contact.contact_fraction
    assert fraction == rs.realize(rs.load_scene(path), numerics, seed=1).contact.contact_fraction
    run = rs.run("demo", folder, max_realizations=2, until={})
    assert rs.compare(folder).to_dict() == rs.compare(run).to_dict()
    with pytest.raises(SceneError, match="is not bundled"):
        rs.plan("granit")
    with pytest.raises(TypeError, match="must be the name of a bundled scene, a path or a mapping"):
        rs.plan(7)
