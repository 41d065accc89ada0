"""Contact: what is no lawful problem is refused by name and value, before any work."""

import numpy as np
import pytest
from contact_cases import WAVE, press

import roughsim as rs
from roughsim.fourier import plans
from roughsim.scene import parse_scene

SCENE = """
[surface]
rms_height = 1e-6
hurst = 0.8
q_min = 6e3
q_max = 2e5
[body]
youngs_modulus = 2e11
poisson_ratio = {ratio}
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = 1e8
friction_coefficient = 0.1
speed = [1]
[ensemble]
max_realizations = 12
"""


UNLAWFUL = {
    "no load": (lambda: press(nominal_pressure=0.0), "nominal_pressure = 0 Pa must be positive"),
    "load below zero": (
        lambda: press(nominal_pressure=-1.0),
        "nominal_pressure = -1 Pa must be positive",
    ),
    "load NaN": (
        lambda: press(nominal_pressure=np.nan),
        "nominal_pressure = nan Pa must be finite",
    ),
    "load infinite": (
        lambda: press(nominal_pressure=np.inf),
        "nominal_pressure = inf Pa must be finite",
    ),
    "load complex": (
        lambda: press(nominal_pressure=1j),
        "nominal_pressure = 1j must be one real number",
    ),
    "load a field": (
        lambda: press(nominal_pressure=[1.0]),
        r"nominal_pressure = \[1.0\] must be one real number",
    ),
    "load above hardness": (
        lambda: press(solid=rs.Solid(1.0, 0.001)),
        "0.01 Pa exceeds penetration_hardness = 0.001 Pa",
    ),
    "hardness zero": (lambda: rs.Solid(1.0, 0.0), "penetration_hardness = 0 Pa must be positive"),
    "hardness below zero": (
        lambda: rs.Solid(1.0, -1.0),
        "penetration_hardness = -1 Pa must be positive",
    ),
    "hardness NaN": (lambda: rs.Solid(1.0, np.nan), "penetration_hardness = nan Pa must be finite"),
    "modulus zero": (lambda: rs.Solid(0.0), "effective_modulus = 0 Pa must be positive"),
    "modulus below zero": (lambda: rs.Solid(-1.0), "effective_modulus = -1 Pa must be positive"),
    "modulus NaN": (lambda: rs.Solid(np.nan), "effective_modulus = nan Pa must be finite"),
    "modulus infinite": (lambda: rs.Solid(np.inf), "effective_modulus = inf Pa must be finite"),
    "a NaN among heights": (
        lambda: press(np.where(np.eye(64) > 0, np.nan, WAVE)),
        "heights holds 64 values that are NaN",
    ),
    "an infinity among heights": (
        lambda: press(np.where(np.eye(64) > 0, -np.inf, WAVE)),
        "heights holds .* infinite",
    ),
    "heights complex": (lambda: press(WAVE * (1 + 0j)), "heights has dtype complex128"),
    "heights masked": (
        lambda: press(np.ma.masked_greater(WAVE, 0.005)),
        "heights is a masked array",
    ),
    "heights words": (lambda: press(np.full((64, 64), "1")), "heights has dtype <U1"),
    "heights objects": (lambda: press(WAVE.astype(object)), "heights has dtype object"),
    "heights on a line": (lambda: press(WAVE[:, 0]), r"heights has shape \(64,\); a 2-D array"),
    "heights in space": (
        lambda: press(WAVE[None]),
        r"heights has shape \(1, 64, 64\); a 2-D array",
    ),
    "heights without a point": (
        lambda: press(np.zeros((0, 64))),
        r"heights has shape \(0, 64\); a 2-D array",
    ),
    "heights of another grid": (
        lambda: press(WAVE[:32]),
        r"heights has shape \(32, 64\), but the grid",
    ),
    "cell without length": (
        lambda: rs.Grid((64, 64), (0.0, 1.0)),
        "lengths = 0 m must be positive",
    ),
    "cell of length below zero": (
        lambda: rs.Grid((64, 64), (1.0, -1.0)),
        "lengths = -1 m must be positive",
    ),
    "cell of length NaN": (
        lambda: rs.Grid((64, 64), (1.0, np.nan)),
        "lengths = nan m must be finite",
    ),
    "cell infinite": (lambda: rs.Grid((64, 64), (np.inf, 1.0)), "lengths = inf m must be finite"),
    "tolerance zero": (lambda: press(tolerance=0.0), "tolerance = 0 must lie between 0 and 1"),
    "tolerance one": (lambda: press(tolerance=1.0), "tolerance = 1 must lie between 0 and 1"),
    "tolerance below zero": (
        lambda: press(tolerance=-1e-6),
        "tolerance = -1e-06 must lie between 0 and 1",
    ),
    "tolerance NaN": (lambda: press(tolerance=np.nan), "tolerance = nan must be finite"),
    "no iterations": (lambda: press(max_iterations=0), "max_iterations = 0 must be a whole number"),
    "half an iteration": (
        lambda: press(max_iterations=0.5),
        "max_iterations = 0.5 must be a whole number",
    ),
    "iterations NaN": (lambda: press(max_iterations=np.nan), "max_iterations = nan must be finite"),
    "another precision": (lambda: press(precision="half"), "precision = 'half' must be"),
    "ν = 1/2 and more": (lambda: parse_scene(SCENE.format(ratio=0.7)), "poisson_ratio"),
    "ν = −1": (lambda: parse_scene(SCENE.format(ratio=-1)), "poisson_ratio"),
    "ν = 1": (lambda: parse_scene(SCENE.format(ratio=1)), "poisson_ratio"),
    "ν = NaN": (lambda: parse_scene(SCENE.format(ratio="nan")), "poisson_ratio"),
}


@pytest.mark.parametrize("name", UNLAWFUL)
def test_an_unlawful_problem_is_refused_by_name_and_value_before_any_transform(name, monkeypatch):
    def transform(*_, **__):
        pytest.fail("a transform was planned")

    for module, door in ((plans, "Transform"), (plans, "Lines"), (plans, "lines")):
        monkeypatch.setattr(module, door, transform)
    refused, words = UNLAWFUL[name]
    with pytest.raises((TypeError, ValueError), match=words):
        refused()


def test_an_incompressible_body_is_lawful():
    assert parse_scene(SCENE.format(ratio=0.5)).effective_modulus == pytest.approx(2e11 / 0.75)
