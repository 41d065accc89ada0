"""What cannot be meant is refused in one line that names the key, its value, the limit and the remedy."""

from __future__ import annotations

import pickle
import random
from dataclasses import FrozenInstanceError, replace

import pytest
from refused_cases import assert_refused
from small_scene import CAPPED
from steel_text import STEEL, changed, refusal, table_scene

import roughsim as rs
from roughsim.errors import RoughsimError
from roughsim.scene import SceneError, bundled_scenes, parse_scene, scene_text
from roughsim.scene.changes import read_changes
from roughsim.scene.numerics import Level, Numerics

PRESSURE = '"90 MPa"'
OF_STEEL = [
    (PRESSURE, '"90 MPaa"', 'sliding.nominal_pressure = "90 MPaa": the unit "MPaa" is not known; a quantity in Pa'),
    (PRESSURE, '"90 m/s"', 'sliding.nominal_pressure = "90 m/s" has the dimension [length] / [time]; a quantity in Pa'),
    (PRESSURE, '"90"', 'sliding.nominal_pressure = "90" has no unit; write "90 Pa" or the number 90'),
    (PRESSURE, '"35 degC"', "sliding.nominal_pressure"),
    (PRESSURE, '"9,0 MPa"', "sliding.nominal_pressure"),
    (PRESSURE, '"9**9**9**9"', "sliding.nominal_pressure"),
    (PRESSURE, '"1 km**999999999/m**999999997*Pa"', "sliding.nominal_pressure"),
    (PRESSURE, '"1e999999999 Pa"', "sliding.nominal_pressure"),
    (PRESSURE, '""', "sliding.nominal_pressure"),
    (PRESSURE, '"Pa"', "sliding.nominal_pressure"),
    (PRESSURE, "0", "sliding.nominal_pressure = 0 Pa must be greater than 0 Pa"),
    (PRESSURE, "-9e7", "sliding.nominal_pressure = -90000000.0 Pa must be greater than 0 Pa"),
    (PRESSURE, '"-90 MPa"', 'sliding.nominal_pressure = "-90 MPa" must be greater than 0 Pa'),
    (PRESSURE, "nan", "sliding.nominal_pressure = nan Pa must be a finite number"),
    (PRESSURE, "inf", "sliding.nominal_pressure = inf Pa must be a finite number"),
    (PRESSURE, '"nan Pa"', "sliding.nominal_pressure"),
    (PRESSURE, "true", "sliding.nominal_pressure = true must be a valid number in Pa or a string with a unit"),
    (PRESSURE, "[9e7]", "sliding.nominal_pressure"),
    (PRESSURE, "0x" + "f" * 20000, "sliding.nominal_pressure"),
    (PRESSURE, "1979-05-27", "sliding.nominal_pressure"),
    (PRESSURE, '"1.21 GPa"', "sliding.nominal_pressure = 1.21e+09 Pa exceeds body.penetration_hardness = 1.2e+09 Pa"),
    (PRESSURE, "90 MPa", 'line 27, column 23): "nominal_pressure = 90 MPa'),
    ("hurst = 0.8", "hurts = 0.8", 'surface.hurts = 0.8 is not a key of a scene; did you mean "hurst"?'),
    ("hurst = 0.8", "hurst = 0.8\ngamma = 1", "surface.gamma = 1 is not a key of a scene; it belongs in [theory]"),
    ("hurst = 0.8", "hurst = 0.8\n'a\\nb' = 1", "surface."),
    ("hurst = 0.8", "hurst = 0.8\n'' = 1", 'surface."" = 1'),
    ("hurst = 0.8", "hurst = 0.8\nhurst = 0.8", 'line 9, column 12): "hurst = 0.8'),
    ("hurst = 0.8", "", "surface.hurst is missing; write for example hurst = 0.8"),
    ("hurst = 0.8", "hurst = 1.01", "surface.hurst = 1.01 must be less than or equal to 1"),
    ("hurst = 0.8", "hurst = -0.01", "surface.hurst = -0.01"),
    ("roll_off_exponent = 1.5", "roll_off_exponent = -1", "surface.roll_off_exponent = -1"),
    ('"6350 1/m"', "4.15e7", "surface.q_min = 4.15e+07 rad/m must be below q_max = 4.15e+07 rad/m"),
    ('"6350 1/m"', "1e-320", "surface"),
    ('"0.90 um"', "1e200", "surface"),
    ('"7900 kg/m^3"', "1e-310", "body.density = 1e-310 kg/m^3 must be of a size from 1e-30 to 1e+30 kg/m^3"),
    ('"9.4e4 1/m"', "6000", "surface.q_roll_off = 6000 rad/m must lie between q_min = 6350 rad/m and q_max"),
    ('"9.4e4 1/m"', "4.2e7", "surface.q_roll_off = 4.2e+07 rad/m must lie between"),
    ('q_roll_off = "9.4e4 1/m"', "", "surface.roll_off_exponent = 1.5 needs q_roll_off"),
    ('rms_height = "0.90 um"', "", "surface.rms_height is missing; give exactly one of"),
    ('rms_height = "0.90 um"', "rms_slope = 0", "surface.rms_slope = 0 must be greater than 0"),
    ('rms_height = "0.90 um"', "rms_height = 1e-6\nrms_slope = 0.3", "surface.rms_height and rms_slope are both given"),
    ('rms_height = "0.90 um"', 'rms_height = 1e-6\npsd_convention = "persson"', "surface.psd_convention goes with"),
    ("poisson_ratio = 0.3", "poisson_ratio = -1", "body.poisson_ratio = -1 must be greater than -1"),
    ("poisson_ratio = 0.3", "poisson_ratio = 1", "body.poisson_ratio = 1 must be less than or equal to 0.5"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.51", "body.poisson_ratio = 0.51"),
    ('"200 GPa"', "0", "body.youngs_modulus = 0 Pa must be greater than 0 Pa"),
    ('"30 W/(m K)"', '"30 W/m"', "body.conductivity"),
    ('"1.2 GPa"', '"89 MPa"', "exceeds body.penetration_hardness = 8.9e+07 Pa"),
    ('"1.2 GPa"', "inf", "body.penetration_hardness"),
    ("density =", "diffusivity =", 'body.diffusivity = "7900 kg/m^3" is not a key of a scene; it is conductivity/(den'),
    ("penetration_hardness", "hardness", 'is not a key of a scene; did you mean "penetration_hardness"?'),
    ("friction_coefficient", "friction", 'is not a key of a scene; did you mean "friction_coefficient"?'),
    ("rms_height", "h_rms", 'surface.h_rms = "0.90 um" is not a key of a scene; did you mean "rms_height"?'),
    ("rms_height", "Ra", "for Gaussian heights the rms_height is 1.25 Ra; give that"),
    ("friction_coefficient", "mu", 'is not a key of a scene; did you mean "friction_coefficient"?'),
    ("poisson_ratio", "shear_modulus", "it is youngs_modulus/(2 (1 + poisson_ratio)); give these two"),
    ("[body]", "[bodi]", 'did you mean "body"?'),
    ('"1.2 GPa"', "{ temperature = [300, 900], value = [1e9, 5e8] }",
     "body.penetration_hardness is a table over temperature, with which each speed would have a contact of its own"),
    ("friction_coefficient = 0.11", "friction_coefficient = 0",
     "sliding.friction_coefficient = 0 must be greater than 0"),
    ('"35 m/s"', '"10 m/s"', 'sliding.speed[5] = 10 m/s is there twice'),
    ('"35 m/s"', '"36 km/h"', 'sliding.speed[5] = 10 m/s is there twice'),
    ('"35 m/s"', "-35", "sliding.speed[5] = -35 m/s must be greater than or equal to 0 m/s"),
    ('"35 m/s"', '"35"', 'sliding.speed[5] = "35" has no unit; write "35 m/s" or the number 35'),
    ("0.938", "0", "sliding.heat_partition = 0 must be greater than 0"),
    ("0.938", "1.01", "sliding.heat_partition = 1.01"),
    ("0.938", "true", "sliding.heat_partition = true"),
    ("0.938", '"men"', 'sliding.heat_partition = "men" is not known; did you mean "mean"?'),
    ("0.938", '"total"',
     'sliding.heat_partition = "total" needs the time since sliding began; add for example duration'),
    ("0.938", "0.938\nduration = 0", "sliding.duration = 0 s must be greater than 0 s"),
    ("gamma = 0.294", "gamma = 1.1", "theory.gamma = 1.1 must be less than or equal to 1"),
    ("[theory]", "[theory]\nx.y = 1", "theory.x"),
    ("seed = 1", "seed = -1", "ensemble.seed = -1 must be greater than or equal to 0"),
    ("seed = 1", "seed = 1.0", "ensemble.seed = 1.0 must be a valid integer"),
    ("seed = 1", "seed = true", "ensemble.seed = true must be a valid integer"),
    ("seed = 1", 'seed = "1"', 'ensemble.seed = "1" must be a valid integer'),
    ("seed = 1", f"seed = {2**63}", "ensemble.seed"),
    ("= 400", "= 0", "ensemble.max_realizations = 0 must be greater than or equal to 1"),
    ("flash_temperature =", "flash_temp =", 'ensemble.until.flash_temp is not an observable; did you mean "flash_temp'),
    ('"1 %"', "1", "ensemble.until.flash_temperature = 1 must be less than 1"),
    ('{ flash_temperature = "1 %" }', "1", "ensemble.until = 1 must name observables"),
    ("tolerance = 3e-3", "tolerance = 1", "numerics.tolerance = 1 must be less than 1"),
    ("tolerance = 3e-3", 'precision = "half"', 'numerics.precision = "half" is not known'),
    ("tolerance = 3e-3", "precision = 0x" + "f" * 5000, "numerics.precision = a number of thousands of digits is not"),
    ("tolerance = 3e-3", "lengths = [1, 2, 3]", "numerics.lengths = [1, 2, 3] must be one number or two"),
    ("tolerance = 3e-3", "threads = 0", "numerics.threads = 0"),
    ("tolerance = 3e-3", 'lengths = "5 %"',
     'numerics.lengths = "5 %" has the dimension dimensionless; a quantity in m is expected'),
    ("tolerance = 3e-3", "levels = []", "numerics.levels = [] must be a list of at least one level"),
    ("tolerance = 3e-3", "levels = 3", "numerics.levels = 3 must be a list of at least one level"),
    ("tolerance = 3e-3", "levels = [{}]", "numerics.levels[0].column is missing"),
    ("tolerance = 3e-3", 'levels = [{ column = "cap" }]', 'numerics.levels[0].column = "cap" is not known'),
    ("tolerance = 3e-3", 'levels = [{ column = "capped", shape = 64, q_max = 6e3 }]',
     "numerics.levels[0].q_max = 6000 rad/m must be above 6350 rad/m, where C(q) begins; raise it"),
    ("tolerance = 3e-3",
     'levels = [{ column = "capped", shape = 64, q_max = 1e5 }, { column = "capped", shape = 64, q_max = 4.2e7 }]',
     "numerics.levels[1].q_max = 4.2e+07 rad/m must be at most 4.15e+07 rad/m, where C(q) ends; lower it"),
    ("tolerance = 3e-3", "levels = [{ shap = 3 }]",
     'numerics.levels[0].shap = 3 is not a key of a scene; did you mean "s'),
    ("speed = [", 'speed = "1 m/s, 2 m/s" # [',
     'is not a number with a unit; write for example "35 m/s", or a list of such'),
    ('like = "body"', 'like = "bodies"', 'counterface.like = "bodies" is not known; did you mean "body"?'),
    ('like = "body"', 'like = "body"\nhurst = 1', 'counterface.hurst does not go with like = "body"'),
    ('like = "body"', "", "counterface.like is missing"),
    ('like = "body"', "hurst = 0.8", "counterface.rms_height is missing"),
    ('like = "body"', "conductivity = 3", "counterface.density is missing beside conductivity"),
    ('like = "body"', "youngs_modulus = 3", "counterface.poisson_ratio is missing beside youngs_modulus"),
    ('like = "body"', "penetration_hardness = 8e7", "exceeds counterface.penetration_hardness = 8e+07 Pa"),
    ('title = "', "title = 3 # ", "title = 3 must be one line"),
    ('title = "', 'title = "a\\n', "title = "),
    ('title = "', "surface = 3 # ", "line 6"),
    ('title = "', f"title = {'[' * 5000} # ", "nested too deeply"),
    ('title = "', "[[[ # ", "line 4"),
    ('title = "', 'titel = "', 'titel = "Steel on steel, Sutter & Ranc, hardness 1.2 GPa" is not a key'),
    ('like = "body"', "skin = { thickness = 1e-7, conductivity = 3 }",
     "skin goes with a counterface that takes heat; give its conductivity"),
    ('like = "body"', "heat_depth = 1e-7", "heat_depth goes with a counterface that takes heat"),
    ('like = "body"', 'like = "body"\nskin = { thickness = 1e-7, conductivity = 3 }',
     'skin does not go with like = "body", which fixes it'),
    ("density =", "heat_depth = \"-1 um\"\ndensity =",
     'body.heat_depth = "-1 um" must be greater than or equal to 0 m'),
    ("density =", 'skin = "1 um"\ndensity =', 'body.skin = "1 um" must be a section'),
    ("density =", "skin = { thickness = 1e-6 }\ndensity =",
     "body.skin.conductivity is missing; write for example conductivity ="),
    ("density =", 'skin = { thickness = "-1 um", conductivity = 3 }\ndensity =',
     'body.skin.thickness = "-1 um" must be greater than 0 m'),
    ("density =", "skin = { thicknes = 1e-6, conductivity = 3 }\ndensity =",
     'body.skin.thicknes = 1e-06 is not a key of a scene; did you mean "thick'),
    ("hurst = 0.8", 'hurst = 0.8\npsd_source = "scan"', "surface.psd_source goes with psd_file only"),
    ("tolerance = 3e-3", 'solver = "activ"', 'numerics.solver = "activ" is not known; did you mean "active_set"?'),
    ('until = { flash_temperature = "1 %" }', "until = { temperature_quantile_99 = 0.1 }",
     "ensemble.until.temperature_quantile_99 is of the distribution of the temperature"),
    ("[theory]", '[observables]\ntemperature_distribution = "yes"\n[theory]', "temperature_distribution = "),
    ("[theory]", '[observables]\nheat_above = "900 K"\n[theory]',
     "background_temperature is missing; observables.heat_above needs an absolute"),
    ('"90 MPa"', '"0.9 GPa"\njunction_growth = 100',
     "sliding.nominal_pressure = 9e+08 Pa exceeds 8.07207e+08 Pa, the penetration_hardness lowered by junction_growth"),
    ("[theory]", "[observables]\nheat_above = []\n[theory]", "observables.heat_above = [] holds no number"),
    ("[theory]", "[camera]\nexposure = -1\n[theory]", "camera.exposure = -1 s must be greater than or equal to 0 s"),
    ("[theory]", "[camera]\nresolutoin = 1\n[theory]", 'not a key of a scene; did you mean "resolution"?'),
    ("[theory]", '[camera]\nfixed_to = "bodi"\n[theory]', 'camera.fixed_to = "bodi" is not known; did you mean "body"'),
    ("[theory]", '[camera]\nbehind = 1\nexposure = 1\nfixed_to = "body"\n[theory]',
     "camera.exposure = 1 s does not go with behind"),
    ('until = { flash_temperature = "1 %" }', "until = { seen_rms = 0.1 }",
     "ensemble.until.seen_rms is of the picture of a camera; add a section [camera]"),
]  # fmt: skip
WARM = changed("friction_coefficient =", "background_temperature = 300\nfriction_coefficient =")
REACTION = """[reaction]
activation_energy = ["1 eV", "1.602176634e-19 J"]
activation_volume = "10 angstrom^3"
prefactor = "1e13 1/s"
contact_length = "1 cm"
[theory]"""
OF_REACTIONS = [
    ('["1 eV", "1.602176634e-19 J"]', "[]", "reaction.activation_energy = [] holds no number"),
    ('"1 eV", ', '"-1 eV", ', 'reaction.activation_energy[0] = "-1 eV" must be greater than or equal to 0 J'),
    ('"1 eV", ', '"96 kJ/mol", ', "has the dimension"),
    ('activation_energy = ["1 eV", "1.602176634e-19 J"]\n', "", "reaction.activation_energy is missing; write"),
    ('prefactor = "1e13 1/s"', "", 'reaction.prefactor is missing; write for example prefactor = "1e13 1/s"'),
    ("prefactor =", "prefacter =", "reaction.prefacter = "),
    ('"10 angstrom^3"', '"10 angstrom"', "has the dimension [length]"),
    ("background_temperature = 300\n", "", "background_temperature is missing; [reaction] needs an absolute"),
    ('until = { flash_temperature = "1 %" }', "until = { temperature_quantile_99x = 0.1 }",
     "ensemble.until.temperature_quantile_99x is not an observable"),
]  # fmt: skip
SLIDING = CAPPED.replace(
    "speed = [0, 0.1, 35]", 'history = "sliding"\nslid_distance = 1\nspeed = [0.1, 35]'
)
OF_WARM = [
    ('"30 W/(m K)"', "{ temperature = [400, 900], value = [30, 20] }",
     "sliding.background_temperature = 300 K must lie between 400 K and 900 K, the range of the tables over temperature"),
    ('"30 W/(m K)"', "{ temperature = [100, 250], value = [30, 20] }",
     "sliding.background_temperature = 300 K must lie between 100 K and 250 K"),
    ('"30 W/(m K)"', "{ temperature = [100, 250], value = [30] }",
     "body.conductivity has 2 temperatures and 1 values; give 2 to 100 of each, in pairs"),
    ('"30 W/(m K)"', "{ temperature = [300, 300], value = [30, 20] }",
     "body.conductivity[1] has temperature = 300.0 K after 300.0 K; temperature must rise, so sort the rows"),
    ('"30 W/(m K)"', "{ temperature = [300, 400], value = [30, -20] }",
     "body.conductivity.value[1] = -20 W/(m K) must be greater than 0 W/(m K)"),
    ("friction_coefficient = 0.11", "junction_growth = 9\nfriction_coefficient = { temperature = [300, 900], value = [1, 2] }",
     "sliding.junction_growth = 9 goes with one friction_coefficient: with a table over temperature each speed would"),
]  # fmt: skip
OF_SLIDING = [
    ('history = "sliding"', "", "sliding.slid_distance = 1 m goes with history"),
    ("slid_distance = 1", "", "sliding.slid_distance and sliding.duration are both missing; history"),
    ("slid_distance = 1", "slid_distance = 1\nduration = 1", "sliding.duration are both given; history"),
    ("speed = [0.1", "speed = [0, 0.1", "sliding.speed = 0 m/s does not go with history"),
    ('"sliding"', '"melting"', 'sliding.history = "melting" is not known'),
    ('[counterface]\nlike = "body"', "", "follows the heat of two bodies, but [counterface] is missing"),
    ('q_max = 1e5 },\n]', 'q_max = 1e5 },\n  { column = "sliding", shape = [64, 64], q_max = 2e3, first = 3 },\n]',
     "numerics.levels[3].q_max = 2000 rad/m must be above 6350 rad/m, where C(q) begins; raise it and of all levels below it"),
]  # fmt: skip
ROWS = "psd = [[1e4, 3e-23], [1e5, 7e-27]]"
TABLE = table_scene(ROWS)
TEXTURES = [
    ("3", "surface.psd_texture must have a row of numbers for each map"),
    ("[[1, 2, 3]]", "surface.psd_texture must have a row of numbers for each map"),
    ("[{ ratio = 1 }]", "surface.psd_texture must have a row of numbers for each map"),
    ("[[0, 0.3, 1.2, 0.4, 1e4, 2e4, 0, 3, 0, 1]]", "must have ratios and wavenumbers above 0"),
    ("[[nan, 0.3, 1.2, 0.4, 1e4, 2e4, 0, 3, 0, 1]]", "must have ratios and wavenumbers above 0"),
]
OF_TABLES = [
    (", [1e5, 7e-27]]", "]", "surface.psd = 1 rows"),
    (ROWS, "psd = []", "surface.psd = 0 rows"),
    (ROWS, "psd = 3", "surface.psd = 3: a table C(q) has 2 to 1200 rows"),
    (ROWS, f"psd = {[[i, 1] for i in range(1, 1300)]}", "surface.psd = 1299 rows: a table C(q) has 2 to 1200 rows"),
    ("[1e5, 7e-27]", "[1e5]", "surface.psd[1] = [100000.0] must be two numbers without units, q in rad/m and C in m⁴"),
    ("[1e5, 7e-27]", '["1e5 1/m", 7e-27]', "must be two numbers without units, q in rad/m and C in m⁴"),
    ("[1e5, 7e-27]", "[1e4, 1e-24]", "surface.psd[1] has q = 10000.0 rad/m after 10000.0 rad/m; q must rise"),
    ("7e-27", "-7e-27", "surface.psd[1] C = -7e-27 must be greater than 0"),
    ("[1e4, 3e-23]", "[0, 3e-23]", "surface.psd[0] q = 0 rad/m must be greater than 0 rad/m"),
    ("3e-23", "-22.5", "surface.psd[0] C = -22.5 must be greater than 0, for example 1e-24; of a table of logarithms"),
    ("3e-23", "nan", "surface.psd[0] C = nan must be a finite number"),
    ('psd_convention = "persson"\n', "", 'surface.psd_convention is missing; a table needs "persson"'),
    ('"persson"', '"person"', 'surface.psd_convention = "person" is not known; did you mean "persson"?'),
    (ROWS, ROWS + "\nhurst = 0.8", "surface.hurst = 0.8 does not go with psd_file"),
    (ROWS, ROWS + "\nrms_height = 1e-6", "surface.rms_height and psd_file are both given"),
    *((ROWS, f'{ROWS}\npsd_source = "scan"\npsd_texture = {value}', words) for value, words in TEXTURES),
    (ROWS, 'psd_file = "psd.txt"', 'surface.psd_file = "psd.txt" needs a scene file to lie beside'),
    (ROWS, "psd_file = 3", "surface.psd_file = 3 must be the path of a file"),
    (ROWS, ROWS + '\npsd_file = "a"', "surface.psd does not go with surface.psd_file"),
]  # fmt: skip
TEXTS = [
    (text, *row)
    for text, rows in (
        (STEEL, OF_STEEL),
        (changed("[theory]", REACTION, WARM), OF_REACTIONS),
        (WARM, OF_WARM),
        (SLIDING, OF_SLIDING),
        (TABLE, OF_TABLES),
    )
    for row in rows
]


@pytest.mark.parametrize(("text", "old", "new", "words"), TEXTS, ids=range(len(TEXTS)))
def test_texts_are_refused(text, old, new, words):
    assert words in refusal(changed(old, new, text))


def shared(rule, counterface):
    text = changed("0.938", rule)
    return changed("[counterface]\n" * (not counterface) + 'like = "body"', counterface, text)


def elastic(column):
    level = f'levels = [{{ column = "{column}", shape = 64, q_max = 1e5 }}]'
    return changed('penetration_hardness = "1.2 GPa"', "") + level


def without(section):
    start = STEEL.index(f"[{section}]")
    return STEEL[:start] + STEEL[STEEL.index("\n[", start) :]


LONE, TOTAL = (
    'sliding.heat_partition = "{}" shares the heat with a second body, but {} is missing',
    '"total"\nduration = 1',
)
WHOLE = {
    LONE.format("mean", "[counterface]"): shared('"mean"', ""),
    LONE.format("total", "[counterface]"): shared(TOTAL, ""),
    LONE.format("mean", "counterface.conductivity"): shared('"mean"', "penetration_hardness = 2e9"),
    LONE.format("total", "counterface.conductivity"): shared(TOTAL, "penetration_hardness = 2e9"),
    'numerics.levels[0].column = "capped" needs a body.penetration_hardness': elastic("capped"),
    'numerics.levels[0].column = "quadrant" is not known': elastic("quadrant"),
    "numerics.levels[0] is of a pressed map, whose levels follow from it": elastic("quadrants"),
    **{f"section [{name}] is missing": without(name) for name in ("surface", "body", "sliding")},
    **{f"{name} = 3 must be a section": f"{name} = 3\n" + without(name) for name in ("surface", "body", "sliding")},
}  # fmt: skip


@pytest.mark.parametrize("words", WHOLE)
def test_whole_texts_are_refused(words):
    assert words in refusal(WHOLE[words])


LOW = Level("capped", (64, 64), 5e4)
SLID = Level("sliding", (32, 32), 1e4)


def numerics(*levels, side=2e-3, **keys):
    return lambda: Numerics(levels, (side, side), **keys)


def steel(**keys):
    return lambda: rs.load_scene("steel-1.2GPa", {k.replace("__", "."): v for k, v in keys.items()})


CALLS = {
    r"^numerics.levels.column = \"plastic\" is not known; did you mean": lambda: Level("plastic", 8, 1.0),
    r"^numerics.levels.shape = \[8, 8, 8\] must be one number or two": lambda: Level("elastic", (8, 8, 8), 1.0),
    "^numerics.levels.q_max = -1 rad/m must be greater than 0 rad/m": lambda: Level("elastic", 8, -1),
    r"^numerics.levels.shape = 8.0 must be a valid integer": lambda: Level("elastic", 8.0, 1),
    "^numerics.levels.shape is missing": lambda: Level("elastic"),
    "^numerics.levels.q_max is missing": lambda: Level(column="capped", shape=(3, 3)),
    "^numerics.tolerence = 3 is not a key of a scene; did you mean": numerics(LOW, tolerence=3),
    r'^numerics.lengths\[1\] = "1 s" has the dimension \[time\]; a quantity in m': lambda: Numerics((LOW,), (1, "1 s")),
    r"^numerics.lengths\[1\] = -1.0 m must be greater than 0 m": lambda: Numerics((LOW,), (1.0, -1.0)),
    "^numerics.tolerance = 2.0 must be less than 1": numerics(LOW, tolerance=2.0),
    '^numerics.precision = "half" is not known': numerics(LOW, precision="half"),
    "^numerics.threads = 0 must be greater than or equal to 1": numerics(LOW, threads=0),
    "^numerics.keep_fields = -1 must be greater than or equal to 0": numerics(LOW, keep_fields=-1),
    r"levels = \[\] must be a list of at least one level": numerics(),
    'solver = "other" is not known; the choice is active_set': numerics(LOW, solver="other"),
    r'levels\[0\].cell = "half", but no capped level lies below it': numerics(replace(LOW, cell="half")),
    r"levels\[1\] has the q_max and the pixel of levels\[0\], so that neither": numerics(LOW, LOW),
    r"levels\[1\] has the q_max and the pixel of levels\[0\]": numerics(LOW, replace(LOW, shape=(32, 32), cell="half")),
    r"levels\[1\] lies in half the cell and corrects levels\[0\], whose 63 × 63 points do not divide by 2": numerics(
        replace(LOW, shape=(63, 63)), Level("capped", (64, 64), 1e5, "half")
    ),
    r"levels\[1\] lies in half the cell and corrects levels\[0\], whose 64 × 63 points do not divide by 2": numerics(
        replace(LOW, shape=(64, 63)), Level("capped", (64, 64), 1e5, "half")
    ),
    r"levels\[1\] lies in a quarter of the cell .* 66 × 66 points do not divide by 4": numerics(
        replace(LOW, shape=(66, 66)), Level("capped", (64, 64), 1e5, "quarter")
    ),
    r"q_max = 5e\+05 rad/m exceeds the Nyquist wavenumber 1.005e\+05 rad/m": numerics(replace(LOW, q_max=5e5)),
    r"levels\[0\].q_max = 2.4e\+04 rad/m exceeds .* of the grid \(2, 128\), in the cell of levels\[1\]": numerics(
        Level("capped", (1, 64), 2.4e4, "half"), Level("capped", (17, 23), 2.4e4), Level("capped", (32, 8), 1e4)
    ),
    r"levels\[0\].q_max = 1500 rad/m leaves no wave in a cell of 0.002 × 0.002 m": numerics(replace(LOW, q_max=1.5e3)),
    r"levels\[0\].q_max = 5e\+04 rad/m leaves no wave .* with \(1, 1\) points": numerics(replace(LOW, shape=(1, 1))),
    r"levels\[0\].q_max = 2000 rad/m leaves no wave in a cell of 0.001 × .*, in the cell of levels\[1\]": numerics(
        replace(LOW, q_max=2e3), Level("capped", (64, 64), 1e5, "half")
    ),
    "must be the last level, after all single contacts; keep one": numerics(SLID, LOW),
    r"levels\[0\].column = .* must be the last level": numerics(SLID),
    r"levels\[1\].column = .* must be the last level": numerics(LOW, SLID, SLID),
    r"levels\[0\].first = 4 is for column": numerics(replace(LOW, first=4)),
    r"levels\[1\].cell does not go with column": numerics(LOW, replace(SLID, cell="half")),
    '"speed" is not a key of a scene; did you mean "sliding.speed"': steel(speed=3.0),
    '"slidng.speed" is not a key of a scene; did you mean "sliding"': steel(slidng__speed=3.0),
    '"title" is no section': steel(title__x=3.0),
    'conductivity.value" is not a key of a scene: "body.conductivity" is no table': steel(body__conductivity__value=3),
    r"5e\+09 Pa exceeds body.penetration_hardness": steel(sliding__nominal_pressure="5 GPa"),
    'did you mean "nominal_pressure"': steel(sliding__nominal_presure=3.0),
    "rms_height and rms_slope are both given": steel(surface__rms_slope=0.3),
    r"it names a file, .*load_scene\(SCENE, \{\"surface.psd_file\": PATH\}\)": lambda: replace(
        rs.load_scene("demo").surface, psd_file="psd.csv"
    ),
    "3 must be the name of a key": lambda: rs.load_scene("demo", {3: 5}),
    "must be a key and a value, as in": lambda: read_changes(["sliding.speed"]),
    "--set a is given twice; keep one": lambda: read_changes(["a=1", "a=2"]),
}  # fmt: skip


@pytest.mark.parametrize("words", CALLS)
def test_calls_are_refused(words):
    assert_refused(CALLS[words], words)


def test_slides_need_waves_of_both_faces():
    """Contact of the sum of both needs waves of one, a slide waves of each."""
    own = 'rms_height = "0.2 um"\nhurst = 0.5\nq_min = 6e4\nq_max = 1e5\n'
    text = changed(
        'like = "body"', own + "conductivity = 30\ndensity = 7900\nheat_capacity = 500", SLIDING
    )
    assert parse_scene(text).numerics.levels[0].q_max == 5e4
    slide = '  { column = "sliding", shape = [64, 64], q_max = 5e4 },\n]'
    assert "levels[3].q_max = 50000 rad/m must be above 60000 rad/m, where C(q) begins" in refusal(
        changed("1e5 },\n]", f"1e5 }},\n{slide}", text)
    )


def test_replace_checks_again(steel):
    with pytest.raises(SceneError, match=r"^sliding\.nominal_pressure = -1\.0 Pa must be greater"):
        replace(steel.sliding, nominal_pressure=-1.0)
    with pytest.raises(SceneError, match=r"^surface\.q_min = 1e\+08 rad/m must be below"):
        replace(steel.surface, q_min=1e8)
    with pytest.raises(SceneError, match=r"^sliding\.nominal_pressure = 2e\+09 Pa exceeds"):
        replace(steel, sliding=replace(steel.sliding, nominal_pressure=2e9))
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
