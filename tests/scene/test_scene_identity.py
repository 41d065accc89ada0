"""What makes two scenes the same, and a scene written and read again."""

from __future__ import annotations

import json
import pickle
from dataclasses import fields, is_dataclass

import pytest
from steel_text import STEEL, changed, table_scene, with_counterface

from roughsim.scene import bundled_scenes, parse_scene, scene_text
from roughsim.scene.schema import SECTIONS


def variants() -> list[str]:
    total = changed("0.938", '"total"\nduration = "1 ms"')
    return [
        *(scene_text(name) for name in bundled_scenes()),
        table_scene("psd = [[1e4, 3.1e-23], [1e5, 7e-27]]", "surfacetopography"),
        with_counterface(
            "rms_slope = 0.1\nhurst = 0\nq_min = 1e-3\nq_max = 0.3\nconductivity=1\ndensity=2\nheat_capacity=3"
        ),
        total.replace('title = "', 'title = "\\"µ\\\\ 𝛾 '),
        changed('"0.90 um"', "0.1234567890123456789e-6"),
        changed(
            '{ flash_temperature = "1 %" }', '{ flash_width = 0.02, plastic_fraction = "3 %" }'
        ),
        changed('{ flash_temperature = "1 %" }', "{}"),
        STEEL
        + 'levels = [{ column = "capped", shape = [3, 4], q_max = 7e3 }]\nlengths = [1, 2]\nslid_distance = inf',
        STEEL[: STEEL.index("[counterface]")] + STEEL[STEEL.index("[sliding]") :],
    ]


@pytest.mark.parametrize("text", variants(), ids=range(len(variants())))
def test_a_scene_written_and_read_again_is_the_same(text):
    scene = parse_scene(text)
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert hash(again) == hash(scene)
    assert again.to_toml() == scene.to_toml()
    assert scene.identity() == json.loads(json.dumps(again.identity(), allow_nan=False))
    assert pickle.loads(pickle.dumps(scene)) == scene


SAME = [
    ('title = "', 'title = "Other '),
    ("= 400", "= 500"),
    ('"1 %"', '"2 %"'),
    ("tolerance = 3e-3", "tolerance = 3e-3\nkeep_fields = 3"),
    ('"90 MPa"', "9e7"),
    ("heat_capacity =", 'melting_temperature = "1420 K"\nheat_capacity ='),
]
DIFFERENT = [
    ("seed = 1", "seed = 2", ("ensemble.seed", 1, 2)),
    ('"90 MPa"', '"91 MPa"', ("sliding.nominal_pressure", 9e7, 9.1e7)),
    ("tolerance = 3e-3", "", ("numerics.tolerance", 3e-3, None)),
    ("tolerance = 3e-3", "tolerance = 3e-3\nthreads = 2", ("numerics.threads", None, 2)),
    ("gamma = 0.294", "gamma = 0.3", ("theory.gamma", 0.294, 0.3)),
    ('"1.2 GPa"', '"1.3 GPa"', ("body.penetration_hardness", 1.2e9, 1.3e9)),
    (
        '["0.001 m/s", ',
        "[",
        (
            "sliding.speed",
            [0.001, 0.01, 0.1, 1.0, 10.0, 35.0, 100.0],
            [0.01, 0.1, 1.0, 10.0, 35.0, 100.0],
        ),
    ),
]


def test_a_background_counts_where_a_table_or_nothing_but_melting_needs_it(steel):
    melting = changed("heat_capacity =", "melting_temperature = 1420\nheat_capacity =")
    cold = changed(
        "friction_coefficient =", "background_temperature = 77\nfriction_coefficient =", melting
    )
    assert parse_scene(cold).sliding.background_temperature == 77.0
    assert steel.identity() == parse_scene(cold).identity()  # no number of the results changes


REACTION = "[reaction]\nactivation_energy = 1e-19\nprefactor = 1e13\n[theory]"


@pytest.mark.parametrize(
    "asks",
    [
        "[observables]\ntemperature_distribution = true\n[theory]",
        "[observables]\nheat_above = 900\n[theory]",
        REACTION,
        REACTION.replace("1e13", "1e12").replace("1e-19", "[1e-19, 2e-19]"),
    ],
)
def test_a_reaction_changes_a_run_only_by_the_distribution_of_the_temperature(asks, steel):
    warm = "" if "temperature_distribution" in asks else "background_temperature = 300\n"
    text = changed("friction_coefficient =", f"{warm}friction_coefficient =")
    scene = parse_scene(changed("[theory]", asks, text))
    assert scene.distribution
    assert scene.identity() == steel.identity() | {"observables.temperature_distribution": True}
    assert parse_scene(scene.to_toml()) == scene


@pytest.mark.parametrize(("old", "new"), SAME)
def test_identity_forgets_titles_targets_and_units(old, new, steel):
    assert steel.identity() == parse_scene(changed(old, new)).identity()


@pytest.mark.parametrize(("old", "new", "difference"), DIFFERENT)
def test_what_changes_a_number_changes_one_key_of_the_identity(old, new, difference, steel):
    before, after = steel.identity(), parse_scene(changed(old, new)).identity()
    pairs = {key: (before.get(key), after.get(key)) for key in before | after}
    assert [(key, *pair) for key, pair in pairs.items() if pair[0] != pair[1]] == [difference]


def test_identity_does_not_depend_on_writing_out_a_default():
    bare = changed('q_roll_off = "9.4e4 1/m"', "", changed("roll_off_exponent = 1.5", ""))
    full = changed(
        '"9.4e4 1/m"', '"6350 1/m"', changed("roll_off_exponent = 1.5", "roll_off_exponent = 0")
    )
    assert parse_scene(bare).identity() == parse_scene(full).identity()


SELF_AFFINE = "hurst = 0.8\nq_min = 1e3\nq_roll_off = 1e4\nq_max = 1e6\nroll_off_exponent = 1"
BODY = "melting_temperature = 1500\n" + "\n".join(
    line
    for line in STEEL[STEEL.index("[body]") : STEEL.index("[counterface]")].splitlines()[1:]
    if not line.startswith("conductivity")
)
LAYERS = "skin = { thickness = 1e-7, conductivity = 3, density = 5e3, heat_capacity = 600 }\nheat_depth = 1e-7\n"
TABLE = "conductivity = { temperature = [300, 900], value = [50, 30] }\n"
TABLE_FACE = """psd = [[1e4, 3.1e-23], [1e5, 7e-27]]
psd_convention = "persson"
psd_source = "scan"
psd_error = [[0.1], [0.2]]
psd_texture = [[1.1, 0.3, 1.2, 0.4, 1e4, 2e4, 0.0, 3.0, 0.0, 1.0]]
psd_directions = [[1e4, 1.0, 2.0]]
psd_filled = 0.1
psd_scans = ["map.gwy: heights in m"]"""
NAMED_FACE = 'spectrum = { name = "k_correlation", rms_height = 1e-7, hurst = 0.7, q_min = 1e3, q_roll_off = 1e4, q_max = 1e6 }'
NUMERICS = """[numerics]
levels = [{ column = "capped", shape = 64, q_max = 1.5e4 }]
lengths = 0.01
tolerance = 1e-3
precision = "single"
slid_distance = inf
threads = 2
keep_fields = 3
solver = "active_set"
"""
REST = """[sliding]
nominal_pressure = 1e6
friction_coefficient = 0.1
junction_growth = 9
speed = [1, 2]
direction = 0.5
heat_partition = "total"
duration = 1
background_temperature = 300
[observables]
temperature_distribution = true
heat_above = 900
[reaction]
activation_energy = "1 eV"
activation_volume = 1e-29
prefactor = 1e13
contact_length = 1e-3
[theory]
gamma = 0.3
[ensemble]
seed = 4
realizations = 3
max_realizations = 5
until = { flash_width = 0.02 }
"""
FACES = (
    f"rms_height = 1e-7\n{SELF_AFFINE}",
    f"rms_slope = 0.1\n{SELF_AFFINE}",
    TABLE_FACE,
    NAMED_FACE,
)
# what a run may change and stay the same run, or what changes no number
LEFT_OUT = {
    *(
        "ensemble.realizations",
        "ensemble.max_realizations",
        "ensemble.until",
        "numerics.keep_fields",
    ),
} | {
    *("surface.psd_source", "counterface.psd_source", "surface.psd_error", "counterface.psd_error"),
    *("surface.psd_texture", "counterface.psd_texture"),
    *("surface.psd_filled", "counterface.psd_filled"),
    *("surface.psd_scans", "counterface.psd_scans"),
    *("body.melting_temperature", "counterface.melting_temperature"),
    *(
        "reaction.activation_energy",
        "reaction.activation_volume",
        "reaction.prefactor",
        "reaction.contact_length",
    ),
    "observables.heat_above",
}


def test_identity_leaves_out_no_key_but_those_that_change_no_number():
    scenes = [
        parse_scene(
            f"[surface]\n{face}\n[body]\n{BODY}{TABLE}{LAYERS}"
            f"[counterface]\n{face}\n{BODY}{TABLE}{LAYERS}{REST}{NUMERICS}"
        )
        for face in FACES
    ]
    scenes.append(
        parse_scene(
            f'[surface]\n{FACES[0]}\n[body]\n{BODY}{TABLE}[counterface]\nlike = "body"\n{REST}'
        )
    )
    moving = REST.replace('"total"\nduration = 1', '"all"\nhistory = "sliding"\nslid_distance = 1')
    scenes.append(
        parse_scene(
            f'[surface]\n{FACES[0]}\n[body]\n{BODY}{TABLE}[counterface]\nlike = "body"\n{moving}'
        )
    )
    grooved = f"{FACES[0]}\nlay = 3\nlay_direction = 1"
    steel, load = f"{BODY}conductivity = 30\n", REST[: REST.index("heat_partition")]
    scenes.append(
        parse_scene(f"[surface]\n{grooved}\n[body]\n{steel}[counterface]\n{grooved}\n{steel}{load}")
    )
    of_one = REST.replace("background_temperature = 300", "contact_radius = 1\ntrack_radius = 2")
    warm = f"temperature = 300\n{BODY}{TABLE}"
    scenes.append(
        parse_scene(
            f"[surface]\n{FACES[0]}\n[body]\n{warm}[counterface]\n{FACES[0]}\n{warm}{of_one}"
        )
    )
    seen = set()
    for scene in scenes:
        keys = {name: getattr(scene, name) for name in SECTIONS[""].known_keys()}
        sections = {name: value for name, value in keys.items() if is_dataclass(value)}
        stated = {
            f"{name}.{field.name}"
            for name, section in sections.items()
            for field in fields(section)
            if getattr(section, field.name) is not None
        }
        default = (
            {"sliding.history"} if scene.sliding.history == "frozen" else set()
        )  # older runs do not have it
        assert {*scene.identity()} == stated - LEFT_OUT - default
        seen |= stated
    every = {f"{name}.{field.name}" for name in sections for field in fields(SECTIONS[name])}
    assert seen == every  # so that a new key is tried here
