"""What a scene assumes about its rough faces and its heat is printed, and it is what the code computes."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.planning.limits import judge
from roughsim.planning.realization import slide_problem
from roughsim.prediction.statements import cautions, statements
from roughsim.scene import parse_scene

SURFACE = "rms_height = 1e-6\nhurst = 0.8\nq_min = 6350\nq_max = 2e5\n"
STEEL = "youngs_modulus = 200e9\npoisson_ratio = 0.3\nconductivity = 30\ndensity = 7900\nheat_capacity = 500\n"
BRASS = "youngs_modulus = 100e9\npoisson_ratio = 0.3\nconductivity = 120\ndensity = 8500\nheat_capacity = 380\n"
SLIDING = "[sliding]\nnominal_pressure = 9e7\nfriction_coefficient = 0.11\nspeed = [0.1, 35]\n"
OTHER = "rms_height = 0.3e-6\nhurst = 0.8\nq_min = 6350\nq_max = 2e5\n"


SKIN = "first micrometre"  # its sizes have tests of their own


def scene_of(counterface, sliding=""):
    other = "" if counterface is None else f"[counterface]\n{counterface}"
    return parse_scene(f"[surface]\n{SURFACE}[body]\n{STEEL}{other}{SLIDING}{sliding}")


def said(scene):
    return {
        remark.quantity: remark.value for remark in statements(scene) if remark.quantity != SKIN
    }


ON_BOTH = 'history = "sliding"\nslid_distance = 1e-3\nheat_partition = 0.5\n'


@pytest.mark.parametrize(
    ("counterface", "sliding", "roughness", "heat"),
    [
        (None, "", "on the resting face", "all into the moving body"),
        (BRASS, "", "on the resting face", "all into the moving body"),
        (BRASS, "heat_partition = 0.75\n", "on the resting face", "0.75 into the moving body"),
        (BRASS, 'heat_partition = "mean"\n', "on the resting face", 'by the rule "mean"'),
        ('like = "body"\n', "", "of both faces, on the resting face", "all into the moving body"),
        (BRASS + OTHER, "", "of both faces, on the resting face", "all into the moving body"),
        (BRASS + OTHER, ON_BOTH, "on both faces", "0.5 into the moving body"),
        ('like = "body"\n', ON_BOTH, "on both faces", "0.5 into the moving body"),
        (BRASS, ON_BOTH, "on the resting face", "0.5 into the moving body"),
    ],
)
def test_a_scene_states_where_its_roughness_is_and_where_its_heat_goes(
    counterface, sliding, roughness, heat
):
    assert said(scene_of(counterface, sliding)) == {"roughness": roughness, "heat": heat}


def test_a_lone_rough_face_is_computed_as_one_that_rests_on_the_counterface():
    # the same two bodies, one rough, the other smooth, in both roles: spots at rest on a body heat it for long, and so
    # the fast body takes most of the heat. With the roles exchanged the other body does
    steel_moves = scene_of(BRASS, 'heat_partition = "mean"\n')
    brass_moves = parse_scene(
        f'[surface]\n{SURFACE}[body]\n{BRASS}[counterface]\n{STEEL}{SLIDING}heat_partition = "mean"\n'
    )
    shares = [prediction.heat_partition(scene) for scene in (steel_moves, brass_moves)]
    # long before the speed counts, heat goes by the conductivities: κ/(κ + κ′)
    slow = [scene.with_("sliding.speed", [1e-6]) for scene in (steel_moves, brass_moves)]
    at_rest = [float(prediction.heat_partition(scene)[0]) for scene in slow]
    np.testing.assert_allclose(at_rest, [30 / 150, 120 / 150], rtol=1e-3)
    for share, low in zip(shares, at_rest, strict=True):
        assert (
            low < share[0] < share[1] < 1.0
        )  # the body over which the spots slide takes more, the faster the more


def test_of_two_faces_that_slide_the_first_rides_with_the_moving_body():
    heights = {}
    for name, scene in {
        "two": scene_of(BRASS + OTHER, ON_BOTH),
        "lone": scene_of(BRASS, ON_BOTH),
    }.items():
        problem = slide_problem(scene, rs.plan(scene))
        faces = problem.resting_spectrum, problem.moving_spectrum
        heights[name] = [None if face is None else face.rms_height for face in faces]
    np.testing.assert_allclose(
        heights["two"], [0.3e-6, 1e-6], rtol=0.03
    )  # but for waves beyond q_c; that of [counterface] rests
    assert heights["lone"][0] == pytest.approx(
        1e-6, rel=0.03
    )  # it rests, though it is that of [surface]
    assert heights["lone"][1] is None


ATOMS = OTHER.replace("0.3e-6", "1e-9")


@pytest.mark.parametrize("form", ["", 'heat_partition = "all"\n'])
@pytest.mark.parametrize("counterface", [BRASS, BRASS + OTHER, BRASS + ATOMS, 'like = "body"\n'])
def test_no_share_between_two_conductors_is_warned_of_with_what_mean_gives(counterface, form):
    # long before the speed counts the conductivities share the heat: 30/(30 + 120), and 1/2 between like bodies
    expected = 0.5 if "like" in counterface else 0.2
    scene = scene_of(counterface, form).with_("sliding.speed", [1e-6, 1e-7])
    (line,) = [line for line in judge(scene).warnings if "heat_partition" in line]
    share, by_mean, by_all = map(
        float, re.search(r"share is (\S+) and T_flash (\S+) K .*, not (\S+) K", line).groups()
    )
    assert "the counterface takes heat, too" in line
    assert "at 1e-06 m/s" in line  # the hotter one
    assert (share, by_mean / by_all) == pytest.approx((expected, expected), rel=2e-3)
    assert ("exchange [body] and [counterface]" in line) == (len(scene.faces) == 1)
    assert ("0.5 between equal faces" in line) == ("like" in counterface)
    assert len(line) < 320


def test_the_temperature_by_mean_has_its_own_conductivity():
    # κ halves over 300 K: with a third of the heat the contact is cooler, and conducts better
    table = "conductivity = { temperature = [300, 600], value = [30, 15] }"
    text = f"[surface]\n{SURFACE}[body]\n{STEEL.replace('conductivity = 30', table)}[counterface]\n{BRASS}{SLIDING}"
    scene = parse_scene(f"{text}background_temperature = 300\n").with_("sliding.speed", 0.1)
    (line,) = [line for line in judge(scene).warnings if "heat_partition" in line]
    shared = scene.with_("sliding.heat_partition", "mean")
    assert f"{rs.theory(shared).flash_temperature[0]:.4g} K in theory" in line
    assert f"not {rs.theory(scene).flash_temperature[0]:.4g} K" in line


def test_no_value_of_the_theory_leaves_the_warning(monkeypatch):
    def none(*_):
        raise RuntimeError("the integral is not reached")

    monkeypatch.setattr("roughsim.prediction.statements.predictions", none)
    (line,) = [
        line for line in map(str, cautions(scene_of(BRASS + OTHER))) if "heat_partition" in line
    ]
    assert 'takes heat, too; write "mean"' in line


@pytest.mark.parametrize(
    ("counterface", "sliding"),
    [
        (None, ""),  # there is no other body
        ("youngs_modulus = 1e9\npoisson_ratio = 0.3\n", ""),  # it insulates
        (BRASS, "heat_partition = 1\n"),  # stated
        (BRASS, 'heat_partition = "mean"\n'),
    ],
)
def test_other_scenes_do_not_get_it(counterface, sliding):
    assert not any(
        "takes heat, too" in line for line in judge(scene_of(counterface, sliding)).warnings
    )


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_plan_theory_compare_and_report_print_the_same_statements(tmp_path):
    scene = replace(
        scene_of(BRASS),
        numerics=replace(
            scene_of(BRASS).numerics,
            lengths=(2e-3, 2e-3),
            levels=({"column": "elastic", "shape": [16, 16], "q_max": 1e4},),
        ),
    )
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    rs.run(scene, tmp_path / "run", max_realizations=2, until={})
    outputs = [
        CliRunner().invoke(app, [verb, str(path), "--all"]).output for verb in ("plan", "theory")
    ]
    outputs.append(CliRunner().invoke(app, ["compare", str(tmp_path / "run"), "--all"]).stdout)
    outputs.append(rs.report(rs.open_run(tmp_path / "run"), tmp_path / "run.html").read_text())
    for text in outputs:
        flat = re.sub(r"<[^>]*>", " ", text)
        assert re.search(r"roughness:?\s+on the resting face", flat)
        assert re.search(r"heat:?\s+all into the moving body", flat)
        assert "the counterface takes heat, too" in " ".join(flat.split())
    for verb in ("plan", "theory"):
        told = json.loads(CliRunner().invoke(app, [verb, str(path), "--json"]).stdout)[
            "scene_statements"
        ]
        assert [(row["name"], row["value"]) for row in told if row["name"] != SKIN] == list(
            said(scene).items()
        )
        assert all(row["because"] for row in told)
