"""Contact: what is no lawful problem is refused by name and value, before any work."""

from dataclasses import replace

import numpy as np
import pytest
from contact_cases import UNIT, WAVE, press, rough
from refused_cases import assert_refused

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


HOLED = np.where(np.eye(64) > 0, np.nan, WAVE)
ENDLESS = np.where(np.eye(64) > 0, -np.inf, WAVE)
CHECKED = np.ones((8, 12), bool)
GRID = rs.Grid((8, 12), (4.0, 3.0))
LAWFUL = rs.solve_contact(WAVE, UNIT, rs.Solid(1.0), nominal_pressure=0.01)
ROUGH, CELL = rough(slope=0.5)
CAPPED = rs.solve_contact(ROUGH, CELL, rs.Solid(1.0, 0.1), nominal_pressure=0.03)


def numbers(name, unit, call):
    """What each argument that must be one positive number refuses."""
    return {
        f"{name} = 0{unit} must be positive": lambda: call(0.0),
        f"{name} = -1{unit} must be positive": lambda: call(-1.0),
        f"{name} = nan{unit} must be finite": lambda: call(np.nan),
        f"{name} = 1j must be one real number": lambda: call(1j),
        f"{name} = '1' must be one real number": lambda: call("1"),
        f"{name} = None must be one real number": lambda: call(None),
        rf"{name} = \[1.0\] must be one real number": lambda: call([1.0]),
    }


def deformed(heights=ROUGH, hardness=0.1, contact=CAPPED):
    return rs.plastic_deformation(contact, heights, CELL, rs.Solid(1.0, hardness))


UNLAWFUL = {
    **numbers("nominal_pressure", " Pa", lambda load: press(nominal_pressure=load)),
    **numbers("penetration_hardness", " Pa", lambda hardness: rs.Solid(1.0, hardness)),
    **numbers("effective_modulus", " Pa", rs.Solid),
    "nominal_pressure = inf Pa must be finite": lambda: press(nominal_pressure=np.inf),
    "effective_modulus = inf Pa must be finite": lambda: rs.Solid(np.inf),
    "0.01 Pa exceeds penetration_hardness = 0.001 Pa": lambda: press(solid=rs.Solid(1.0, 0.001)),
    "heights holds 64 values that are NaN": lambda: press(HOLED),
    "heights holds .* infinite": lambda: press(ENDLESS),
    "heights has dtype complex128": lambda: press(WAVE * (1 + 0j)),
    "heights is a masked array": lambda: press(np.ma.masked_greater(WAVE, 0.005)),
    "heights has dtype <U1": lambda: press(np.full((64, 64), "1")),
    "heights has dtype object": lambda: press(WAVE.astype(object)),
    r"heights has shape \(64,\); a 2-D array": lambda: press(WAVE[:, 0]),
    r"heights has shape \(1, 64, 64\); a 2-D array": lambda: press(WAVE[None]),
    r"heights has shape \(0, 64\); a 2-D array": lambda: press(np.zeros((0, 64))),
    r"heights has shape \(32, 64\), but the grid": lambda: press(WAVE[:32]),
    "lengths = 0 m must be positive": lambda: rs.Grid((64, 64), (0.0, 1.0)),
    "lengths = -1 m must be positive": lambda: rs.Grid((64, 64), (1.0, -1.0)),
    "lengths = nan m must be finite": lambda: rs.Grid((64, 64), (1.0, np.nan)),
    "lengths = inf m must be finite": lambda: rs.Grid((64, 64), (np.inf, 1.0)),
    "tolerance = 0 must lie between 0 and 1": lambda: press(tolerance=0.0),
    "tolerance = 1 must lie between 0 and 1": lambda: press(tolerance=1.0),
    "tolerance = -1e-06 must lie between 0 and 1": lambda: press(tolerance=-1e-6),
    "tolerance = nan must be finite": lambda: press(tolerance=np.nan),
    "tolerance = '1'": lambda: press(tolerance="1"),
    "max_iterations = 0 must be a whole number": lambda: press(max_iterations=0),
    "max_iterations = 0.5 must be a whole number": lambda: press(max_iterations=0.5),
    "max_iterations = nan must be finite": lambda: press(max_iterations=np.nan),
    "precision = 'half' must be": lambda: press(precision="half"),
    "start is a ndarray; give the Contact": lambda: press(start=LAWFUL.pressure),
    "start.pressure = 0 Pa everywhere": lambda: press(
        start=replace(LAWFUL, pressure=0.0 * LAWFUL.pressure)
    ),
    "start.pressure holds 64 values that are NaN": lambda: press(
        start=replace(LAWFUL, pressure=HOLED)
    ),
    "poisson_ratio = 0.7": lambda: parse_scene(SCENE.format(ratio=0.7)),
    "poisson_ratio = -1 ": lambda: parse_scene(SCENE.format(ratio=-1)),
    "poisson_ratio = 1 ": lambda: parse_scene(SCENE.format(ratio=1)),
    "poisson_ratio = nan": lambda: parse_scene(SCENE.format(ratio="nan")),
    "mask has dtype float64; give true or false": lambda: rs.contact_patches(1.0 * CHECKED, GRID),
    "^mask has dtype float64; give true or false": lambda: rs.corrected_area(1.0 * CHECKED, GRID),
    r"mask has shape \(12, 8\), but the grid": lambda: rs.contact_patches(CHECKED.T, GRID),
    r"^mask has shape \(12, 8\), but the grid": lambda: rs.corrected_area(CHECKED.T, GRID),
    r"mask has shape \(\)": lambda: rs.contact_patches(True, GRID),
    "pressure = -1e-09": lambda: rs.corrected_fractions([[-1e-9, 1.0]], 1.0),
    "pressure = .*1.1": lambda: rs.corrected_fractions([[0.0, 1.1]], 1.0),
    "^pressure holds .* NaN": lambda: rs.corrected_fractions([[0.0, np.nan]], 1.0),
    r"^pressure has shape \(2,\)": lambda: rs.corrected_fractions([0.0, 1.0], 1.0),
    "^penetration_hardness = -1": lambda: rs.corrected_fractions([[0.0, 1.0]], -1.0),
    "heights: the gap over the elastic contact varies by .* m": lambda: deformed(-ROUGH),
    "heights: the gap over the elastic contact varies": lambda: deformed(ROUGH.T),
    "heights: the gap .* varies by .* m": lambda: deformed(1.001 * ROUGH),
    "heights: the gap": lambda: deformed(hardness=np.inf),  # what has yielded is not elastic
    r"^heights has shape \(32, 64\)": lambda: deformed(ROUGH[:32]),
    r"pressure = 0 to 0.1 Pa leaves the range .* penetration_hardness = 0.09 Pa": lambda: deformed(
        hardness=0.09
    ),
    "^pressure = 0 Pa everywhere": lambda: deformed(
        contact=replace(CAPPED, pressure=0.0 * CAPPED.pressure)
    ),
    **{
        f"nominal_pressures{words}": lambda load=load: rs.follow_loads(
            WAVE, UNIT, rs.Solid(1.0, 0.1), nominal_pressures=[0.01, load]
        )
        for words, load in {
            " = 0 ": 0.0, " = -1 ": -1.0, " .*nan|NaN": np.nan, " .*inf": np.inf, " .*0.2": 0.2, ".*": "1"
        }.items()
    },
}  # fmt: skip


@pytest.mark.parametrize("words", UNLAWFUL)
def test_contact_refuses_before_any_transform(words, monkeypatch):
    def transform(*_, **__):
        pytest.fail("a transform was planned")

    if not words.startswith("heights: the gap"):  # the displacement of the heights shows these
        for module, door in ((plans, "Transform"), (plans, "Lines"), (plans, "lines")):
            monkeypatch.setattr(module, door, transform)
    assert_refused(UNLAWFUL[words], words)


def test_an_incompressible_body_is_lawful():
    assert parse_scene(SCENE.format(ratio=0.5)).effective_modulus == pytest.approx(2e11 / 0.75)
