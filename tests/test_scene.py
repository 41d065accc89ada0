"""Scene files: exact numbers in SI, the physics of two bodies, and one-line refusals that name the key."""

from __future__ import annotations

import json
import math
import os
import pickle
import random
import re
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import pytest

from roughsim.errors import RoughsimError
from roughsim.scene import Scene, SceneError, bundled_scenes, first_difference, load_scene, parse_scene, scene_text
from roughsim.scene.quantities import Quantity
from roughsim.scene.sections import section
from roughsim.scene.spectra import NAMES

STEEL = re.sub(r" *#.*", "", scene_text("steel-1.2GPa"))
ROWS = ((1.0e4, 3.0e-23), (1.0e5, 7.0e-27), (2.5e5, 1.0e-29))


@pytest.fixture(scope="module")
def steel() -> Scene:
    return load_scene("steel-1.2GPa")


def approx(value: float, rel: float) -> Any:
    # pytest's own default abs=1e-12 would call any two values of C(q) equal
    return pytest.approx(value, rel=rel, abs=0.0)


def changed(old: str, new: str, text: str = STEEL) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def with_counterface(lines: str) -> str:
    return changed('like = "body"', lines)


def refusal(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    message = str(caught.value)
    assert "\n" not in message
    assert message.isprintable()
    return message


# --- numbers and units


def test_the_bundled_steel_is_the_paper_s_in_si_to_the_last_bit(steel):
    assert steel.surface.rms_height == 9e-7
    assert (steel.surface.q_min, steel.surface.q_roll_off, steel.surface.q_max) == (6350.0, 9.4e4, 4.15e7)
    assert (steel.surface.hurst, steel.surface.roll_off_exponent) == (0.8, 1.5)
    assert (steel.body.youngs_modulus, steel.body.poisson_ratio) == (2e11, 0.3)
    assert (steel.body.conductivity, steel.body.density, steel.body.heat_capacity) == (30.0, 7900.0, 500.0)
    assert (steel.sliding.nominal_pressure, steel.sliding.friction_coefficient) == (9e7, 0.11)
    assert steel.speeds == (0.001, 0.01, 0.1, 1.0, 10.0, 35.0, 100.0)
    assert (steel.sliding.heat_partition, steel.sliding.duration) == (0.938, None)
    assert (steel.theory.gamma, steel.ensemble.seed, steel.ensemble.max_realizations) == (0.294, 1, 400)
    assert (steel.ensemble.until, steel.numerics.tolerance) == ((("flash_temperature", 0.01),), 1e-4)


@pytest.mark.parametrize(("name", "hardness"), [("0.5", 5e8), ("1.2", 1.2e9), ("2.0", 2e9)])
def test_the_three_steels_differ_in_hardness_only(name, hardness, steel):
    scene = load_scene(f"steel-{name}GPa")
    assert scene.penetration_hardness == hardness
    body = replace(scene.body, penetration_hardness=1.2e9)
    assert replace(scene, body=body, title=steel.title) == steel


@pytest.mark.parametrize(
    ("written", "pressure"),
    [
        ("90000000", 9e7),
        ("9e7", 9e7),
        ('"90 MPa"', 9e7),
        ('"90MPa"', 9e7),
        ('"0.09 GPa"', 9e7),
        ('"9e7 N/m^2"', 9e7),
        ('"90 N/mm²"', 9e7),
        ('"90 N mm^-2"', 9e7),
    ],
)
def test_a_pressure_may_be_written_in_any_unit_of_pressure(written, pressure):
    assert parse_scene(changed('"90 MPa"', written)).sliding.nominal_pressure == pressure


def test_conversion_rounds_once_as_if_the_si_number_had_been_written():
    for hundredths in range(1, 60):
        scene = parse_scene(changed('"0.90 um"', f'"{hundredths / 100} um"'))
        assert scene.surface.rms_height == float(f"{hundredths}e-8")


@pytest.mark.parametrize("micro", ["um", "\u00b5m", "\u03bcm", "micrometer"])
def test_every_way_to_write_a_micrometre_is_read(micro):
    assert parse_scene(changed('"0.90 um"', f'"0.90 {micro}"')).surface.rms_height == 9e-7


@pytest.mark.parametrize(
    ("old", "new", "key", "value"),
    [
        ('"6350 1/m"', '"6350 rad/m"', "q_min", 6350.0),
        ('"6350 1/m"', '"6.35 mm^-1"', "q_min", 6350.0),
        ('"6350 1/m"', '"1000 cycle/m"', "q_min", 2000 * math.pi),
        ("hurst = 0.8", 'hurst = "80 %"', "hurst", 0.8),
        ("hurst = 0.8", 'hurst = "0.8"', "hurst", 0.8),
        ("hurst = 0.8", "hurst = 1", "hurst", 1.0),
    ],
)
def test_wavenumbers_are_angular_and_pure_numbers_may_be_percentages(old, new, key, value):
    assert getattr(parse_scene(changed(old, new)).surface, key) == approx(value, rel=1e-15)


def test_one_speed_is_a_list_of_one_and_rest_is_allowed():
    text = changed(STEEL[STEEL.index("speed = [") : STEEL.index("heat_partition")], 'speed = "36 km/h"\n')
    assert parse_scene(text).speeds == (10.0,)
    assert parse_scene(changed('"36 km/h"', "0", text)).speeds == (0.0,)


def test_optional_sections_have_the_stated_defaults():
    scene = parse_scene(STEEL[: STEEL.index("[theory]")])
    assert (scene.theory.gamma, scene.ensemble.seed, scene.ensemble.max_realizations) == (0.45, 1, 400)
    assert scene.ensemble.until == (("flash_temperature", 0.01),)
    assert scene.numerics.tolerance is None
    assert scene.numerics.levels is None
    assert parse_scene(changed("heat_partition = 0.938", "")).sliding.heat_partition == "all"


def test_numerics_are_read_key_by_key():
    lines = """levels = [
  { column = "capped", shape = [512, 256], q_max = "4e5 1/m" },
  { column = "smoothed", shape = 64, q_max = 1e5 },
]
lengths = "4 mm"
precision = "single"
slid_distance = inf
threads = 2
keep_fields = 0"""
    numerics = parse_scene(STEEL + lines).numerics
    assert [(v.column, v.shape, v.q_max) for v in numerics.levels or ()] == [
        ("capped", (512, 256), 4e5),
        ("smoothed", (64, 64), 1e5),
    ]
    assert (numerics.lengths, numerics.precision, numerics.slid_distance) == ((4e-3, 4e-3), "single", math.inf)
    assert (numerics.threads, numerics.keep_fields) == (2, 0)


# --- the physics of two bodies


def test_equal_bodies_halve_the_modulus_and_double_the_spectrum(steel):
    alone = replace(steel, counterface=None)
    assert alone.effective_modulus == approx(2e11 / 0.91, rel=1e-15)
    assert steel.effective_modulus == approx(1e11 / 0.91, rel=1e-15)
    for q in (6350.0, 2e4, 9.4e4, 1e6, 4.15e7):
        assert steel.spectrum(q) == approx(2 * alone.spectrum(q), rel=1e-14)
    assert alone.spectrum.rms_height == approx(9e-7, rel=1e-12)
    assert steel.spectrum.rms_height == approx(9e-7 * math.sqrt(2), rel=1e-12)


def test_steel_has_the_known_modulus_and_diffusivity(steel):
    assert steel.effective_modulus == approx(1.0989e11, rel=1e-5)
    assert steel.diffusivity == approx(7.5949e-6, rel=1e-5)
    assert steel.counter_conductivity == 30.0
    assert steel.counter_diffusivity == approx(30.0 / (7900.0 * 500.0), rel=1e-15)


def test_an_incompressible_body_is_stiffer_by_a_quarter(steel):
    scene = replace(steel, counterface=None, body=replace(steel.body, poisson_ratio=0.5))
    assert scene.effective_modulus == approx(2e11 / 0.75, rel=1e-15)


def test_different_faces_add_their_spectra_and_compliances():
    scene = parse_scene(
        with_counterface(
            'rms_slope = 0.1\nhurst = 0.5\nq_min = 2e4\nq_max = 1e6\nyoungs_modulus = "70 GPa"\npoisson_ratio = 0.2\n'
            'penetration_hardness = "0.8 GPa"\nconductivity = 150\ndensity = 2700\nheat_capacity = 900'
        )
    )
    assert scene.effective_modulus == approx(1 / (0.91 / 2e11 + 0.96 / 7e10), rel=1e-14)
    assert scene.penetration_hardness == 8e8
    assert scene.counter_conductivity == 150.0
    assert scene.counter_diffusivity == approx(150 / (2700 * 900), rel=1e-15)
    alone = replace(scene, counterface=None).spectrum
    # C = a q^(-3) with rms slope 0.1: 2π ∫ q³ C dq = 2π a (q_max - q_min)
    level = 0.1**2 / (2 * math.pi * (1e6 - 2e4))
    for q in (1e4, 3e4, 5e5, 2e6):  # outside, inside, inside and outside the band of the second face
        second = level * q**-3 if 2e4 <= q <= 1e6 else 0.0
        assert scene.spectrum(q) == approx(alone(q) + second, rel=1e-12)


def test_the_softer_body_yields_first_whichever_it_is():
    harder = with_counterface('penetration_hardness = "3 GPa"')
    assert parse_scene(harder).penetration_hardness == 1.2e9
    only_counterface = changed('penetration_hardness = "1.2 GPa"', "", harder)
    assert parse_scene(only_counterface).penetration_hardness == 3e9
    assert not parse_scene(only_counterface).elastic


def test_a_scene_without_hardness_is_elastic():
    scene = parse_scene(changed('penetration_hardness = "1.2 GPa"', ""))
    assert scene.elastic
    assert scene.penetration_hardness == math.inf


def test_a_counterface_without_keys_of_a_kind_is_rigid_smooth_or_insulating(steel):
    alone = replace(steel, counterface=None)
    smooth = parse_scene(with_counterface('youngs_modulus = "200 GPa"\npoisson_ratio = 0.3'))
    rough = parse_scene(with_counterface('rms_height = "0.9 um"\nhurst = 0.8\nq_min = 6350\nq_max = 1e6'))
    assert smooth.spectrum == alone.spectrum
    assert smooth.effective_modulus == steel.effective_modulus
    assert rough.effective_modulus == alone.effective_modulus
    for scene in (alone, smooth, rough):
        assert scene.counter_conductivity is None
        assert scene.counter_diffusivity is None


def test_the_spectrum_has_the_exponents_of_the_scene_on_both_sides_of_the_roll_off(steel):
    assert steel.spectrum(6350.0) / steel.spectrum(9.4e4) == approx((9.4e4 / 6350.0) ** 1.5, rel=1e-12)
    assert steel.spectrum(9.4e4) / steel.spectrum(9.4e5) == approx(10**3.6, rel=1e-12)
    assert steel.spectrum.breaks == (6350.0, 9.4e4, 4.15e7)


@pytest.mark.parametrize("end", ["6350 1/m", "4.15e7 1/m"])
def test_the_roll_off_may_lie_at_either_end(end):
    assert parse_scene(changed("9.4e4 1/m", end)).spectrum.breaks == (6350.0, 4.15e7)


def test_left_out_roll_off_begins_at_q_min():
    text = changed('q_roll_off = "9.4e4 1/m"', "", changed("roll_off_exponent = 1.5", ""))
    scene = parse_scene(text)
    assert scene.spectrum(6350.0) / scene.spectrum(63500.0) == approx(10**3.6, rel=1e-12)


def test_load_equal_to_the_hardness_is_allowed():
    assert parse_scene(changed('"90 MPa"', '"1.2 GPa"')).sliding.nominal_pressure == 1.2e9


# --- tables


def table_scene(rows: str, convention: str = "persson") -> str:
    surface = STEEL[STEEL.index("rms_height") : STEEL.index("[body]")]
    return STEEL.replace(surface, f'{rows}\npsd_convention = "{convention}"\n')


@pytest.mark.parametrize("separator", [" ", "\t", ",", " ; "])
def test_a_table_counts_by_content_however_it_is_stored(tmp_path, separator):
    text = "\n".join(f"{q!r}{separator}{psd!r}" for q, psd in ROWS)
    (tmp_path / "psd.csv").write_text(f"# measured\nq{separator}C\n{text}\n\n")
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.csv"'))
    scene = load_scene(tmp_path / "s.toml")
    assert scene.surface.psd == ROWS
    assert scene == parse_scene(table_scene("psd = [[1e4, 3e-23], [1e5, 7e-27], [2.5e5, 1e-29]]"))
    assert scene.spectrum(1e5) == approx(2 * 7e-27, rel=1e-12)


def test_surfacetopography_s_spectrum_is_4_pi_squared_larger():
    rows = "psd = [[1e4, 3e-23], [1e5, 7e-27], [2.5e5, 1e-29]]"
    persson, other = parse_scene(table_scene(rows)), parse_scene(table_scene(rows, "surfacetopography"))
    assert persson.spectrum(1e5) / other.spectrum(1e5) == approx(39.47841760435743, rel=1e-12)


def test_the_longest_tables_still_fit_into_a_scene_file(tmp_path):
    rng = random.Random(3)
    rows = [[1e4 * 1.005**i * (1 + 1e-4 * rng.random()), 1e-20 * 1.1**-i * rng.random()] for i in range(1200)]
    scene = parse_scene(table_scene(f"psd = {rows}"))
    (tmp_path / "s.toml").write_text(scene.to_toml())
    assert load_scene(tmp_path / "s.toml") == scene
    face = with_counterface("").replace("[sliding]", f'psd = {rows[:700]}\npsd_convention = "persson"\n[sliding]')
    both = face.replace(
        face[face.index("rms_height") : face.index("[body]")], f'psd = {rows[:501]}\npsd_convention = "persson"\n'
    )
    assert "counterface.psd and surface.psd together have 1201 rows" in refusal(both)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("1e4 3e-23", "surface.psd = 1 rows"),
        ("1e4 3e-23\n1e5", 'surface.psd_file = "psd.txt", line 2: "1e5" must be two numbers'),
        ("1e4 3e-23\n1e5 x", "line 2"),
        ("1e4 3e-23\n1e4 1e-24", "surface.psd[1] has q = 10000.0 rad/m after 10000.0 rad/m; q must rise"),
        ("1e4 3e-23\n1e5 -1e-24", "surface.psd[1] C = -1e-24 must be above 0"),
        ("0 3e-23\n1e5 1e-24", "surface.psd[0] q = 0.0 rad/m must be above 0 rad/m"),
        ("1e4 nan\n1e5 1e-24", "surface.psd[0] C = nan must be finite"),
        ("", "surface.psd = 0 rows"),
        ("\n".join(f"{i} 1" for i in range(1, 1300)), "has 1299 rows, above the limit of 1200"),
    ],
)
def test_a_table_that_is_no_spectrum_is_refused(tmp_path, content, words):
    (tmp_path / "psd.txt").write_text(content)
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.txt"'))
    with pytest.raises(SceneError) as caught:
        load_scene(tmp_path / "s.toml")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_table_that_is_not_there_is_refused_by_name(tmp_path):
    (tmp_path / "s.toml").write_text(table_scene('psd_file = "psd.txt"'))
    with pytest.raises(SceneError, match=r"surface\.psd_file = \"psd\.txt\": the table .* does not exist"):
        load_scene(tmp_path / "s.toml")
    assert "surface.psd_file" in refusal(table_scene('psd_file = "psd.txt"'))
    assert "surface.psd_file" in refusal(table_scene("psd_file = 3"))
    assert "psd_file and surface.psd are both given" in refusal(table_scene('psd_file = "a"\npsd = [[1, 2], [2, 3]]'))


def test_a_table_must_state_its_convention_and_excludes_the_self_affine_keys():
    rows = "psd = [[1e4, 3e-23], [1e5, 7e-27]]"
    assert "surface.psd_convention is missing" in refusal(table_scene(rows).replace('psd_convention = "persson"\n', ""))
    assert "surface.hurst = 0.8 does not go with psd_file" in refusal(table_scene(rows + "\nhurst = 0.8"))
    assert "surface.rms_height and psd_file are both given" in refusal(table_scene(rows + "\nrms_height = 1e-6"))
    assert 'surface.psd_convention = "person" is not known; did you mean "persson"?' in refusal(
        table_scene(rows, "person")
    )


# --- refusals

PRESSURE = '"90 MPa"'
REFUSED = [
    (PRESSURE, '"90 MPaa"', 'sliding.nominal_pressure = "90 MPaa": the unit "MPaa" is not known; a pressure'),
    (PRESSURE, '"90 m/s"', 'sliding.nominal_pressure = "90 m/s" has the dimension [length] / [time]; a pressure'),
    (PRESSURE, '"90"', 'sliding.nominal_pressure = "90" has no unit; write "90 Pa" or the number 90'),
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
    (PRESSURE, '"1.21 GPa"', "sliding.nominal_pressure = 1.21e+09 Pa exceeds body.penetration_hardness = 1.2e+09 Pa"),
    (PRESSURE, "90 MPa", 'line 26, column 23): "nominal_pressure = 90 MPa'),
    ("hurst = 0.8", "hurts = 0.8", 'surface.hurts = 0.8 is not a key of a scene; did you mean "hurst"?'),
    ("hurst = 0.8", "hurst = 0.8\ngamma = 1", "surface.gamma = 1 is not a key of a scene; it belongs in [theory]"),
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
    ('"7900 kg/m^3"', "1e-310", "body: the diffusivity becomes inf"),
    ('"9.4e4 1/m"', "6000", "surface.q_roll_off = 6000 rad/m must lie between q_min = 6350 rad/m and q_max"),
    ('"9.4e4 1/m"', "4.2e7", "surface.q_roll_off = 4.2e+07 rad/m must lie between"),
    ('q_roll_off = "9.4e4 1/m"', "", "surface.roll_off_exponent = 1.5 needs q_roll_off"),
    ('rms_height = "0.90 um"', "", "surface.rms_height is missing; give exactly one of"),
    ('rms_height = "0.90 um"', "rms_slope = 0", "surface.rms_slope = 0 must be above 0"),
    ('rms_height = "0.90 um"', "rms_height = 1e-6\nrms_slope = 0.3", "surface.rms_height and rms_slope are both given"),
    ('rms_height = "0.90 um"', 'rms_height = 1e-6\npsd_convention = "persson"', "surface.psd_convention goes with"),
    ("poisson_ratio = 0.3", "poisson_ratio = -1", "body.poisson_ratio = -1 must be above -1 and at most 0.5"),
    ("poisson_ratio = 0.3", "poisson_ratio = 1", "body.poisson_ratio = 1 must be above -1 and at most 0.5"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.51", "body.poisson_ratio = 0.51"),
    ('"200 GPa"', "0", "body.youngs_modulus = 0 Pa must be above 0 Pa"),
    ('"30 W/(m K)"', '"30 W/m"', "body.conductivity"),
    ('"1.2 GPa"', '"89 MPa"', "exceeds body.penetration_hardness = 8.9e+07 Pa"),
    ('"1.2 GPa"', "inf", "body.penetration_hardness"),
    ("[body]", "[bodi]", 'did you mean "body"?'),
    ("friction_coefficient = 0.11", "friction_coefficient = 0", "sliding.friction_coefficient = 0 must be above 0"),
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
    ("flash_temperature =", "flash_temp =", 'ensemble.until.flash_temp is not an observable; did you mean "flash_temp'),
    ('"1 %"', "1", "ensemble.until.flash_temperature = 1 must be above 0 and below 1"),
    ('{ flash_temperature = "1 %" }', "1", "ensemble.until = 1 must name observables"),
    ("tolerance = 1e-4", "tolerance = 1", "numerics.tolerance = 1 must be above 0 and below 1"),
    ("tolerance = 1e-4", 'precision = "half"', 'numerics.precision = "half" is not known'),
    ("tolerance = 1e-4", "lengths = [1, 2, 3]", "numerics.lengths = [1, 2, 3] must be one number or two"),
    ("tolerance = 1e-4", "threads = 0", "numerics.threads = 0"),
    ("tolerance = 1e-4", "levels = []", "numerics.levels = [] holds no level"),
    ("tolerance = 1e-4", "levels = 3", "numerics.levels = 3 cannot be used"),
    ("tolerance = 1e-4", "levels = [{}]", "numerics.levels[0].column is missing"),
    ("tolerance = 1e-4", 'levels = [{ column = "cap" }]', 'numerics.levels[0].column = "cap" is not known'),
    (
        "tolerance = 1e-4",
        "levels = [{ shap = 3 }]",
        'numerics.levels[0].shap = 3 is not a key of a scene; did you mean "s',
    ),
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


# --- a spectrum by name

K = {"name": "k_correlation", "rms_height": 4e-7, "hurst": 0.7, "q_min": 7e3, "q_roll_off": 2e4, "q_max": 9e6}


def named(**changes: Any) -> str:
    """Steel with a k-correlation spectrum; None leaves a key out."""
    pairs = (f"{key} = {json.dumps(value)}" for key, value in (K | changes).items() if value is not None)
    start, end = STEEL.index("rms_height"), STEEL.index("[body]")
    return f"{STEEL[:start]}spectrum = {{ {', '.join(pairs)} }}\n{STEEL[end:]}"


def test_a_named_spectrum_is_doubled_added_and_written_as_others_are():
    scene = parse_scene(named(rms_height="0.4 um"))
    assert scene.spectrum.rms_height == approx(4e-7 * math.sqrt(2), 1e-12)
    assert scene.spectrum.breaks == (7e3, 9e6)
    assert parse_scene(scene.to_toml()) == scene
    assert scene.identity()["surface.spectrum"] == K
    two = parse_scene(with_counterface(f"spectrum = {{ {', '.join(f'{k} = {json.dumps(v)}' for k, v in K.items())} }}"))
    assert two.spectrum.rms_height == approx(math.hypot(9e-7, 4e-7), 1e-12)
    assert first_difference(scene, parse_scene(named(hurst=0.6)))[0] == "surface.spectrum"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (named(name="k_corelation"), 'surface.spectrum.name = "k_corelation" is no spectrum; did you mean "k_correlat'),
        (named(name=None), "surface.spectrum = {'rms_height'"),
        (named(name="../topography"), f"is no spectrum; the choice is {', '.join(NAMES)}"),
        (named(hurst=None), "surface.spectrum.hurst is missing; write for example hurst = 0.8"),
        (named(hurst=1.2), "surface.spectrum.hurst = 1.2 must be at least 0 and at most 1"),
        (named(hrust=0.8), 'surface.spectrum.hrust = 0.8 is not a key of a scene; did you mean "hurst"?'),
        (named(q_max="5 m"), 'surface.spectrum.q_max = "5 m" has the dimension [length]; a wavenumber is expected'),
        (named(q_max=6e3), "surface.spectrum.q_min = 7000 rad/m must be below q_max = 6000 rad/m"),
        (named().replace("[body]", "hurst = 0.8\n[body]"), "surface.hurst = 0.8 does not go with spectrum"),
        (named().replace("[body]", "rms_slope = 0.8\n[body]"), "surface.rms_slope and spectrum are both given"),
        (named().replace("[body]", 'psd_convention = "persson"\n[body]'), "surface.psd_convention goes with psd_file"),
    ],
)
def test_a_wrong_named_spectrum_is_refused_by_its_key(text, told):
    assert f"scene: {told}" in refusal(text) or told in refusal(text)


def test_a_key_of_a_named_spectrum_may_not_mean_something_else_than_elsewhere():
    with pytest.raises(ValueError, match="'hurst' is a key of scenes already"):
        section("spectrum.other", hurst=Quantity("", "2", at_most=3))


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
    with pytest.raises(SceneError, match=r"^sliding\.nominal_pressure = -1\.0 Pa must be above 0 Pa"):
        replace(steel.sliding, nominal_pressure=-1.0)
    with pytest.raises(SceneError, match=r"^surface\.q_min = 1e\+08 rad/m must be below"):
        replace(steel.surface, q_min=1e8)
    with pytest.raises(SceneError, match=r"^sliding\.nominal_pressure = 2e\+09 Pa exceeds"):
        replace(steel, sliding=replace(steel.sliding, nominal_pressure=2e9))
    with pytest.raises(SceneError, match=r"^numerics\.levels\.q_max is missing"):
        type(parse_scene(STEEL + 'levels = [{ column = "capped", shape = 3, q_max = 1 }]').numerics.levels[0])(  # type: ignore[index]
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


# --- files and names


def test_a_misspelt_name_gets_the_nearest_and_the_list():
    with pytest.raises(SceneError) as caught:
        load_scene("steel-1.2Gpa")
    assert 'did you mean "steel-1.2GPa"?' in str(caught.value)
    assert all(name in str(caught.value) for name in bundled_scenes())
    with pytest.raises(SceneError, match="did you mean"):
        scene_text("dmeo")


def test_files_that_are_no_scene_are_refused_in_one_line(tmp_path):
    binary, big, exact = tmp_path / "b.toml", tmp_path / "big.toml", tmp_path / "exact.toml"
    binary.write_bytes(bytes(range(256)))
    big.write_text(STEEL + "#" * (64 * 1024 + 1 - len(STEEL.encode())))
    exact.write_text(STEEL + "#" * (64 * 1024 - len(STEEL.encode())))
    assert load_scene(exact) == load_scene("steel-1.2GPa")
    for path, words in [(binary, "not UTF-8"), (big, "64 KiB"), (tmp_path, "is a folder"), ("a\0.toml", "")]:
        with pytest.raises((SceneError, FileNotFoundError)) as caught:
            load_scene(path)
        assert words in str(caught.value)
        assert str(caught.value).isprintable()
    with pytest.raises(FileNotFoundError, match=r'steel-1\.2\.toml does not exist.*"steel-1\.2GPa"'):
        load_scene(tmp_path / "steel-1.2.toml")
    with pytest.raises(TypeError, match="name_or_path = 3"):
        load_scene(3)  # type: ignore[arg-type]


@pytest.mark.skipif(os.name != "posix", reason="named pipes")
def test_a_pipe_is_refused_rather_than_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(SceneError, match="folder or a device"):
        load_scene(tmp_path / "pipe.toml")


def test_windows_line_ends_and_byte_order_marks_do_not_matter(tmp_path, steel):
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + STEEL.replace("\n", "\r\n").encode())
    assert load_scene(str(path)) == steel


def test_importing_the_package_reads_no_scene_module():
    code = "import sys, roughsim; sys.exit(any(m in sys.modules for m in ('pydantic', 'pint', 'roughsim.scene')))"
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=Path(__file__).parents[1]).returncode == 0


# --- identity and round trip


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
        changed('{ flash_temperature = "1 %" }', '{ flash_width = 0.02, plastic_fraction = "3 %" }'),
        changed('{ flash_temperature = "1 %" }', "{}"),
        STEEL + 'levels = [{ column = "capped", shape = [3, 4], q_max = 7 }]\nlengths = [1, 2]\nslid_distance = inf',
        STEEL[: STEEL.index("[counterface]")] + STEEL[STEEL.index("[sliding]") :],
    ]


@pytest.mark.parametrize("text", variants(), ids=range(len(variants())))
def test_a_scene_written_and_read_again_is_the_same(text):
    scene = parse_scene(text)
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert hash(again) == hash(scene)
    assert again.to_toml() == scene.to_toml()
    assert first_difference(scene, json.loads(json.dumps(again.identity(), allow_nan=False))) is None
    assert pickle.loads(pickle.dumps(scene)) == scene


SAME = [
    ('title = "', 'title = "Other '),
    ("= 400", "= 500"),
    ('"1 %"', '"2 %"'),
    ("tolerance = 1e-4", "tolerance = 1e-4\nkeep_fields = 3"),
    ('"90 MPa"', "9e7"),
]
DIFFERENT = [
    ("seed = 1", "seed = 2", ("ensemble.seed", 1, 2)),
    ('"90 MPa"', '"91 MPa"', ("sliding.nominal_pressure", 9e7, 9.1e7)),
    ("tolerance = 1e-4", "", ("numerics.tolerance", 1e-4, None)),
    ("tolerance = 1e-4", "tolerance = 1e-4\nthreads = 2", ("numerics.threads", None, 2)),
    ("gamma = 0.294", "gamma = 0.3", ("theory.gamma", 0.294, 0.3)),
    ('"1.2 GPa"', '"1.3 GPa"', ("body.penetration_hardness", 1.2e9, 1.3e9)),
    (
        '["0.001 m/s", ',
        "[",
        ("sliding.speed", [0.001, 0.01, 0.1, 1.0, 10.0, 35.0, 100.0], [0.01, 0.1, 1.0, 10.0, 35.0, 100.0]),
    ),
]


@pytest.mark.parametrize(("old", "new"), SAME)
def test_identity_forgets_titles_targets_and_units(old, new, steel):
    assert first_difference(steel, parse_scene(changed(old, new))) is None


@pytest.mark.parametrize(("old", "new", "difference"), DIFFERENT)
def test_identity_names_the_first_key_that_differs(old, new, difference, steel):
    assert first_difference(steel, parse_scene(changed(old, new))) == difference


def test_identity_does_not_depend_on_writing_out_a_default():
    bare = changed('q_roll_off = "9.4e4 1/m"', "", changed("roll_off_exponent = 1.5", ""))
    full = changed('"9.4e4 1/m"', '"6350 1/m"', changed("roll_off_exponent = 1.5", "roll_off_exponent = 0"))
    assert first_difference(parse_scene(bare), parse_scene(full)) is None


# --- mutations


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
