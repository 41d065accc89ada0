"""What cannot be meant is refused in one line that names the key."""

from __future__ import annotations

import pickle
import random
from dataclasses import FrozenInstanceError, replace

import pytest
from steel_text import STEEL, changed, refusal

from roughsim.errors import RoughsimError
from roughsim.scene import SceneError, bundled_scenes, parse_scene, scene_text

PRESSURE = '"90 MPa"'
REFUSED = [
    (
        PRESSURE,
        '"90 MPaa"',
        'sliding.nominal_pressure = "90 MPaa": the unit "MPaa" is not known; a quantity in Pa',
    ),
    (
        PRESSURE,
        '"90 m/s"',
        'sliding.nominal_pressure = "90 m/s" has the dimension [length] / [time]; a quantity in Pa',
    ),
    (
        PRESSURE,
        '"90"',
        'sliding.nominal_pressure = "90" has no unit; write "90 Pa" or the number 90',
    ),
    (PRESSURE, '"35 degC"', "sliding.nominal_pressure"),
    (PRESSURE, '"9,0 MPa"', "sliding.nominal_pressure"),
    (PRESSURE, '"9**9**9**9"', "sliding.nominal_pressure"),
    (PRESSURE, '"1 km**999999999/m**999999997*Pa"', "sliding.nominal_pressure"),
    (PRESSURE, '"1e999999999 Pa"', "sliding.nominal_pressure"),
    (PRESSURE, '""', "sliding.nominal_pressure"),
    (PRESSURE, '"Pa"', "sliding.nominal_pressure"),
    (PRESSURE, "0", "sliding.nominal_pressure = 0 Pa must be above 0 Pa"),
    (PRESSURE, "-9e7", "sliding.nominal_pressure = -90000000.0 Pa must be above 0 Pa"),
    (PRESSURE, '"-90 MPa"', 'sliding.nominal_pressure = "-90 MPa" must be above 0 Pa'),
    (PRESSURE, "nan", "sliding.nominal_pressure = nan Pa must be finite"),
    (PRESSURE, "inf", "sliding.nominal_pressure = inf Pa must be finite"),
    (PRESSURE, '"nan Pa"', "sliding.nominal_pressure"),
    (PRESSURE, "true", "sliding.nominal_pressure = true must be a number in Pa"),
    (PRESSURE, "[9e7]", "sliding.nominal_pressure"),
    (PRESSURE, "0x" + "f" * 20000, "sliding.nominal_pressure"),
    (PRESSURE, "1979-05-27", "sliding.nominal_pressure"),
    (
        PRESSURE,
        '"1.21 GPa"',
        "sliding.nominal_pressure = 1.21e+09 Pa exceeds body.penetration_hardness = 1.2e+09 Pa",
    ),
    (PRESSURE, "90 MPa", 'line 27, column 23): "nominal_pressure = 90 MPa'),
    (
        "hurst = 0.8",
        "hurts = 0.8",
        'surface.hurts = 0.8 is not a key of a scene; did you mean "hurst"?',
    ),
    (
        "hurst = 0.8",
        "hurst = 0.8\ngamma = 1",
        "surface.gamma = 1 is not a key of a scene; it belongs in [theory]",
    ),
    ("hurst = 0.8", "hurst = 0.8\n'a\\nb' = 1", "surface."),
    ("hurst = 0.8", "hurst = 0.8\n'' = 1", 'surface."" = 1'),
    ("hurst = 0.8", "hurst = 0.8\nhurst = 0.8", 'line 9, column 12): "hurst = 0.8'),
    ("hurst = 0.8", "", "surface.hurst is missing; write for example hurst = 0.8"),
    ("hurst = 0.8", "hurst = 1.01", "surface.hurst = 1.01 must be at least 0 and at most 1"),
    ("hurst = 0.8", "hurst = -0.01", "surface.hurst = -0.01"),
    ("roll_off_exponent = 1.5", "roll_off_exponent = -1", "surface.roll_off_exponent = -1"),
    ('"6350 1/m"', "4.15e7", "surface.q_min = 4.15e+07 rad/m must be below q_max = 4.15e+07 rad/m"),
    ('"6350 1/m"', "1e-320", "surface"),
    ('"0.90 um"', "1e200", "surface"),
    (
        '"7900 kg/m^3"',
        "1e-310",
        "body.density = 1e-310 kg/m^3 must be of a size from 1e-30 to 1e+30 kg/m^3",
    ),
    (
        '"9.4e4 1/m"',
        "6000",
        "surface.q_roll_off = 6000 rad/m must lie between q_min = 6350 rad/m and q_max",
    ),
    ('"9.4e4 1/m"', "4.2e7", "surface.q_roll_off = 4.2e+07 rad/m must lie between"),
    ('q_roll_off = "9.4e4 1/m"', "", "surface.roll_off_exponent = 1.5 needs q_roll_off"),
    ('rms_height = "0.90 um"', "", "surface.rms_height is missing; give exactly one of"),
    ('rms_height = "0.90 um"', "rms_slope = 0", "surface.rms_slope = 0 must be above 0"),
    (
        'rms_height = "0.90 um"',
        "rms_height = 1e-6\nrms_slope = 0.3",
        "surface.rms_height and rms_slope are both given",
    ),
    (
        'rms_height = "0.90 um"',
        'rms_height = 1e-6\npsd_convention = "persson"',
        "surface.psd_convention goes with",
    ),
    (
        "poisson_ratio = 0.3",
        "poisson_ratio = -1",
        "body.poisson_ratio = -1 must be above -1 and at most 0.5",
    ),
    (
        "poisson_ratio = 0.3",
        "poisson_ratio = 1",
        "body.poisson_ratio = 1 must be above -1 and at most 0.5",
    ),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.51", "body.poisson_ratio = 0.51"),
    ('"200 GPa"', "0", "body.youngs_modulus = 0 Pa must be above 0 Pa"),
    ('"30 W/(m K)"', '"30 W/m"', "body.conductivity"),
    ('"1.2 GPa"', '"89 MPa"', "exceeds body.penetration_hardness = 8.9e+07 Pa"),
    ('"1.2 GPa"', "inf", "body.penetration_hardness"),
    (
        "density =",
        "diffusivity =",
        'body.diffusivity = "7900 kg/m^3" is not a key of a scene; it is conductivity/(den',
    ),
    (
        "penetration_hardness",
        "hardness",
        'is not a key of a scene; did you mean "penetration_hardness"?',
    ),
    (
        "friction_coefficient",
        "friction",
        'is not a key of a scene; did you mean "friction_coefficient"?',
    ),
    (
        "rms_height",
        "h_rms",
        'surface.h_rms = "0.90 um" is not a key of a scene; did you mean "rms_height"?',
    ),
    ("rms_height", "Ra", "for Gaussian heights the rms_height is 1.25 Ra; give that"),
    ("friction_coefficient", "mu", 'is not a key of a scene; did you mean "friction_coefficient"?'),
    (
        "poisson_ratio",
        "shear_modulus",
        "it is youngs_modulus/(2 (1 + poisson_ratio)); give these two",
    ),
    ("[body]", "[bodi]", 'did you mean "body"?'),
    (
        '"1.2 GPa"',
        "{ temperature = [300, 900], value = [1e9, 5e8] }",
        "body.penetration_hardness is a table over temperature, with which each speed would have a contact of its own",
    ),
    (
        "friction_coefficient = 0.11",
        "friction_coefficient = 0",
        "sliding.friction_coefficient = 0 must be above 0",
    ),
    ('"35 m/s"', '"10 m/s"', 'sliding.speed[5] = "10 m/s" is there twice'),
    ('"35 m/s"', '"36 km/h"', 'sliding.speed[5] = "36 km/h" is there twice'),
    ('"35 m/s"', "-35", "sliding.speed[5] = -35 m/s must be at least 0 m/s"),
    ('"35 m/s"', '"35"', 'sliding.speed[5] = "35" has no unit; write "35 m/s" or the number 35'),
    ("0.938", "0", "sliding.heat_partition = 0 must be above 0 and at most 1"),
    ("0.938", "1.01", "sliding.heat_partition = 1.01"),
    ("0.938", "true", "sliding.heat_partition = true"),
    ("0.938", '"men"', 'sliding.heat_partition = "men" is not known; did you mean "mean"?'),
    (
        "0.938",
        '"total"',
        'sliding.heat_partition = "total" needs the time since sliding began; add for example duration',
    ),
    ("0.938", "0.938\nduration = 0", "sliding.duration = 0 s must be above 0 s"),
    ("gamma = 0.294", "gamma = 1.1", "theory.gamma = 1.1 must be at least 0 and at most 1"),
    ("[theory]", "[theory]\nx.y = 1", "theory.x"),
    ("seed = 1", "seed = -1", "ensemble.seed = -1 must be at least 0"),
    ("seed = 1", "seed = 1.0", "ensemble.seed = 1.0 must be a whole number"),
    ("seed = 1", "seed = true", "ensemble.seed = true must be a whole number"),
    ("seed = 1", 'seed = "1"', 'ensemble.seed = "1" must be a whole number'),
    ("seed = 1", f"seed = {2**63}", "ensemble.seed"),
    ("= 400", "= 0", "ensemble.max_realizations = 0 must be at least 1"),
    (
        "flash_temperature =",
        "flash_temp =",
        'ensemble.until.flash_temp is not an observable; did you mean "flash_temp',
    ),
    ('"1 %"', "1", "ensemble.until.flash_temperature = 1 must be above 0 and below 1"),
    ('{ flash_temperature = "1 %" }', "1", "ensemble.until = 1 must name observables"),
    ("tolerance = 3e-3", "tolerance = 1", "numerics.tolerance = 1 must be above 0 and below 1"),
    ("tolerance = 3e-3", 'precision = "half"', 'numerics.precision = "half" is not known'),
    (
        "tolerance = 3e-3",
        "precision = 0x" + "f" * 5000,
        "numerics.precision = a number of thousands of digits is not",
    ),
    (
        "tolerance = 3e-3",
        "lengths = [1, 2, 3]",
        "numerics.lengths = [1, 2, 3] must be one number or two",
    ),
    ("tolerance = 3e-3", "threads = 0", "numerics.threads = 0"),
    (
        "tolerance = 3e-3",
        "levels = []",
        "numerics.levels = [] must be a list of at least one level",
    ),
    ("tolerance = 3e-3", "levels = 3", "numerics.levels = 3 must be a list of at least one level"),
    ("tolerance = 3e-3", "levels = [{}]", "numerics.levels[0].column is missing"),
    (
        "tolerance = 3e-3",
        'levels = [{ column = "cap" }]',
        'numerics.levels[0].column = "cap" is not known',
    ),
    (
        "tolerance = 3e-3",
        'levels = [{ column = "capped", shape = 64, q_max = 6e3 }]',
        "numerics.levels[0].q_max = 6000 rad/m must be above 6350 rad/m, where C(q) begins; raise it",
    ),
    (
        "tolerance = 3e-3",
        'levels = [{ column = "capped", shape = 64, q_max = 1e5 }, { column = "capped", shape = 64, q_max = 4.2e7 }]',
        "numerics.levels[1].q_max = 4.2e+07 rad/m must be at most 4.15e+07 rad/m, where C(q) ends; lower it",
    ),
    (
        "tolerance = 3e-3",
        "levels = [{ shap = 3 }]",
        'numerics.levels[0].shap = 3 is not a key of a scene; did you mean "s',
    ),
    (
        "speed = [",
        'speed = "1 m/s, 2 m/s" # [',
        'is not a number with a unit; write for example "35 m/s", or a list of such',
    ),
    (
        'like = "body"',
        'like = "bodies"',
        'counterface.like = "bodies" is not known; did you mean "body"?',
    ),
    (
        'like = "body"',
        'like = "body"\nhurst = 1',
        'counterface.hurst does not go with like = "body"',
    ),
    ('like = "body"', "", "counterface.like is missing"),
    ('like = "body"', "hurst = 0.8", "counterface.rms_height is missing"),
    ('like = "body"', "conductivity = 3", "counterface.density is missing beside conductivity"),
    (
        'like = "body"',
        "youngs_modulus = 3",
        "counterface.poisson_ratio is missing beside youngs_modulus",
    ),
    (
        'like = "body"',
        "penetration_hardness = 8e7",
        "exceeds counterface.penetration_hardness = 8e+07 Pa",
    ),
    ('title = "', "title = 3 # ", "title = 3 must be one line"),
    ('title = "', 'title = "a\\n', "title = "),
    ('title = "', "surface = 3 # ", "line 6"),
    ('title = "', f"title = {'[' * 5000} # ", "nested too deeply"),
    ('title = "', "[[[ # ", "line 4"),
    (
        'title = "',
        'titel = "',
        'titel = "Steel on steel, Sutter & Ranc, hardness 1.2 GPa" is not a key',
    ),
]


@pytest.mark.parametrize(("old", "new", "words"), REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_meant_is_refused_in_one_line_that_names_the_key(old, new, words):
    assert words in refusal(changed(old, new))


@pytest.mark.parametrize("rule", ['"mean"', '"total"\nduration = "1 ms"'])
def test_sharing_heat_needs_a_second_body_that_conducts(rule):
    text = changed("0.938", rule)
    assert parse_scene(text).sliding.heat_partition in ("mean", "total")
    alone = changed('like = "body"', "", changed("[counterface]", "", text))
    assert "but [counterface] is missing" in refusal(alone)
    assert "counterface.conductivity is missing" in refusal(
        changed('like = "body"', "penetration_hardness = 2e9", text)
    )


def test_an_elastic_scene_has_no_capped_level():
    elastic = changed('penetration_hardness = "1.2 GPa"', "")
    level = 'levels = [{{ column = "{}", shape = 64, q_max = 1e5 }}]'
    assert 'numerics.levels[0].column = "capped"' in refusal(elastic + level.format("capped"))
    assert parse_scene(elastic + level.format("elastic")).elastic


def test_an_unknown_solver_is_refused_with_those_there_are():
    assert 'numerics.solver = "activ"' in refusal(STEEL + 'solver = "activ"\n')
    assert parse_scene(STEEL + 'solver = "active_set"\n').numerics.solver == "active_set"


@pytest.mark.parametrize("name", ["surface", "body", "sliding"])
def test_a_section_that_is_missing_or_no_section_is_named(name):
    start = STEEL.index(f"[{name}]")
    end = STEEL.index("\n[", start)
    assert f"section [{name}] is missing" in refusal(STEEL[:start] + STEEL[end:])
    assert f"{name} = 3 must be a section" in refusal(f"{name} = 3\n" + STEEL[:start] + STEEL[end:])


def test_replace_checks_again_and_nothing_can_be_assigned(steel):
    with pytest.raises(
        SceneError, match=r"^sliding\.nominal_pressure = -1\.0 Pa must be above 0 Pa"
    ):
        replace(steel.sliding, nominal_pressure=-1.0)
    with pytest.raises(SceneError, match=r"^surface\.q_min = 1e\+08 rad/m must be below"):
        replace(steel.surface, q_min=1e8)
    with pytest.raises(SceneError, match=r"^sliding\.nominal_pressure = 2e\+09 Pa exceeds"):
        replace(steel, sliding=replace(steel.sliding, nominal_pressure=2e9))
    with pytest.raises(SceneError, match=r"^numerics\.levels\.q_max is missing"):
        type(
            parse_scene(
                STEEL + 'levels = [{ column = "capped", shape = 3, q_max = 1e4 }]'
            ).numerics.levels[0]
        )(  # type: ignore[index]
            column="capped", shape=(3, 3)
        )
    with pytest.raises(FrozenInstanceError):
        steel.sliding.speed = (1.0,)
    assert replace(steel.sliding, speed="36 km/h").speed == (10.0,)


def test_a_refusal_is_a_value_error_of_roughsim_and_survives_a_worker(steel):
    with pytest.raises(SceneError) as caught:
        replace(steel.theory, gamma=2)
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, RoughsimError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def mutated(text: str, rng: random.Random) -> str:
    junk = [
        "nan",
        "-inf",
        "1e400",
        "true",
        '"1 µm"',
        '"3 parsec"',
        "[]",
        "{}",
        "[[1]]",
        '"\\u0000"',
        "0",
        '"%"',
        "'''",
        "-1",
    ]
    lines = [line.split("  #")[0] for line in text.splitlines()]
    for _ in range(rng.randint(1, 3)):
        i = rng.randrange(len(lines))
        key = lines[i].split("=")[0]
        lines[i] = rng.choice(
            [
                lambda i=i, key=key: f"{key} = {rng.choice(junk)}",
                lambda i=i, key=key: lines[i][: rng.randrange(len(lines[i]) + 1)],
                lambda i=i, key=key: lines[i] + "\n" + lines[rng.randrange(len(lines))],
                lambda i=i, key=key: "".join(rng.sample(lines[i], len(lines[i]))),
                lambda i=i, key=key: lines[i].replace("e", rng.choice("eE\t\x01é\u2028"), 1),
            ]
        )()
    return "\n".join(lines)


def test_a_damaged_scene_is_read_or_refused_in_one_line():
    rng = random.Random(20)
    sections = ("surface", "body", "counterface", "sliding", "theory", "ensemble", "numerics")
    words = (*sections, "title", "line ", "end of document")
    messages = []
    for trial in range(400):
        text = mutated(scene_text(rng.choice(bundled_scenes())), rng)
        try:
            scene = parse_scene(text)
        except SceneError as error:
            messages.append((trial, str(error)))
        else:
            assert parse_scene(scene.to_toml()) == scene
    assert len(messages) > 200
    for trial, message in messages:
        assert message.isprintable(), (trial, message)
        assert any(word in message for word in words), (trial, message)
