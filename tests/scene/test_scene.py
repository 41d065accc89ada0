"""Scene files: exact numbers in SI, every way to write them, and what is left out."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import pint
import pytest
from steel_text import STEEL, approx, changed

from roughsim.scene import load_scene, parse_scene
from roughsim.scene.schema import USUAL


def test_the_bundled_steel_is_the_paper_s_in_si_to_the_last_bit(steel):
    assert steel.surface.rms_height == 9e-7
    assert (steel.surface.q_min, steel.surface.q_roll_off, steel.surface.q_max) == (
        6350.0,
        9.4e4,
        4.15e7,
    )
    assert (steel.surface.hurst, steel.surface.roll_off_exponent) == (0.8, 1.5)
    assert (steel.body.youngs_modulus, steel.body.poisson_ratio) == (2e11, 0.3)
    assert (steel.body.conductivity, steel.body.density, steel.body.heat_capacity) == (
        30.0,
        7900.0,
        500.0,
    )
    assert (steel.sliding.nominal_pressure, steel.sliding.friction_coefficient) == (9e7, 0.11)
    assert steel.speeds == (0.001, 0.01, 0.1, 1.0, 10.0, 35.0, 100.0)
    assert (steel.sliding.heat_partition, steel.sliding.duration) == (0.938, None)
    assert (steel.theory.gamma, steel.ensemble.seed, steel.ensemble.max_realizations) == (
        0.294,
        1,
        400,
    )
    assert (steel.ensemble.until, steel.numerics.tolerance) == (
        (("flash_temperature", 0.01),),
        3e-3,
    )


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


def test_the_usual_units_are_those_of_pint():
    quantity = pint.UnitRegistry(non_int_type=Decimal).Quantity
    by_pint = {
        name: quantity(Decimal(1), name).to(unit).magnitude for name, (unit, _) in USUAL.items()
    }
    assert by_pint == {name: Decimal(factor) for name, (_, factor) in USUAL.items()}


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
    text = changed(
        STEEL[STEEL.index("speed = [") : STEEL.index("heat_partition")], 'speed = "36 km/h"\n'
    )
    assert parse_scene(text).speeds == (10.0,)
    assert parse_scene(changed('"36 km/h"', "0", text)).speeds == (0.0,)


def test_optional_sections_have_the_stated_defaults():
    scene = parse_scene(STEEL[: STEEL.index("[theory]")])
    assert (scene.theory.gamma, scene.ensemble.seed, scene.ensemble.max_realizations) == (
        0.45,
        1,
        400,
    )
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
    assert (numerics.lengths, numerics.precision, numerics.slid_distance) == (
        (4e-3, 4e-3),
        "single",
        math.inf,
    )
    assert (numerics.threads, numerics.keep_fields) == (2, 0)
