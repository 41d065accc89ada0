"""The skin of a body and the depth of its heat in a scene: keys, refusals, and temperatures by the theory."""

import re

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.scene import SceneError
from roughsim.scene.changes import read_changes
from roughsim.scene.files import parse_scene
from roughsim.studies.vary import points_of, read_axes
from theory import flash

OXIDE = {
    "thickness": "0.3 um",
    "conductivity": "3 W/(m K)",
    "density": "5200 kg/m^3",
    "heat_capacity": "650 J/(kg K)",
}
STEEL = "steel-1.2GPa"


def steel(**changes):
    return rs.load_scene(STEEL, {key.replace("__", "."): value for key, value in changes.items()})


def test_a_skin_is_read_in_si_and_written_back():
    scene = steel(body__skin=OXIDE, body__heat_depth="0.5 um")
    assert scene.layers[0].skin == (3e-7, 3.0, 3.0 / (5200 * 650))
    assert scene.layers[0] == scene.layers[1]  # like = "body"
    assert scene.layers[0].heat_depth == 5e-7
    assert parse_scene(scene.to_toml()) == scene
    assert hash(parse_scene(scene.to_toml()).conduction()) == hash(scene.conduction())
    assert scene.identity()["body.skin"]["thickness"] == 3e-7


def test_a_skin_has_the_density_and_heat_of_its_body_where_they_are_left_out():
    scene = steel(body__skin={"thickness": 1e-6, "conductivity": 21.0})
    assert scene.layers[0].skin == (1e-6, 21.0, 21.0 / (7900 * 500))


def test_a_counterface_has_a_skin_of_its_own():
    own = {"conductivity": 46.0, "density": 7900.0, "heat_capacity": 500.0}
    scene = steel(counterface={**own, "skin": OXIDE, "heat_depth": 1e-7})
    assert scene.layers[0] == (None, 0.0)
    assert scene.layers[1] == ((3e-7, 3.0, 3.0 / (5200 * 650)), 1e-7)


def test_a_number_within_a_skin_is_set_and_varied():
    changes = read_changes(["body.skin.thickness=1 um", "body.skin.conductivity=3 W/(m K)"])
    assert rs.load_scene(STEEL, changes).body.skin.thickness == 1e-6
    scene = steel(body__skin=OXIDE)
    assert scene.with_("body.skin.thickness", 2e-6).body.skin == type(scene.body.skin)(
        thickness=2e-6, conductivity=3.0, density=5200.0, heat_capacity=650.0
    )
    assert scene.body.skin.thickness == 3e-7
    axes = read_axes({"body.skin.thickness": {"logspace": ["0.1 um", "10 um", 3]}})
    assert [point.values for point in points_of(axes)] == [
        {"body.skin.thickness": value} for value in (1e-7, 1e-6, 1e-5)
    ]
    assert points_of(axes)[1].name == "thickness=1e-06"


def test_the_theory_of_a_scene_has_its_skin_in_every_column():
    scene = steel(body__skin=OXIDE, body__heat_depth="0.2 um")
    law = prediction.calibrated(scene).stress_spectrum
    body = {"conductivity": 30.0, "diffusivity": 30 / (7900 * 500), "friction_coefficient": 0.11}
    layers = {"skin": (3e-7, 3.0, 3.0 / (5200 * 650)), "heat_depth": 2e-7}
    for stress, by_scene in (
        ({"stress_spectrum": law}, prediction.calibrated_predictions(scene)),
        (
            {
                "spectrum": prediction.smoothed_spectrum(scene),
                "effective_modulus": scene.effective_modulus,
                "gamma": 0.294,
            },
            prediction.predictions(scene),
        ),
    ):
        expected = flash.flash_temperature(
            scene.speeds, nominal_pressure=9e7, **stress, **body, **layers
        )
        np.testing.assert_allclose(by_scene["flash_temperature"], expected, rtol=1e-12)


def test_the_sum_over_modes_of_a_fine_grid_is_the_integral_with_a_skin():
    scene = rs.load_scene("demo", {"body.skin": OXIDE, "body.heat_depth": "0.2 um"})
    grid = rs.Grid((512, 512), (8e-3, 8e-3))
    spectrum = prediction.smoothed_spectrum(scene)
    ratios = []
    for layered in (scene, rs.load_scene("demo")):
        sums = prediction.mode_sums(layered, spectrum, grid)
        whole = prediction.predictions(layered)
        names = ("flash_temperature", "flash_gradient", "flash_laplacian", "heat_partition")
        ratios.append([sums[name] / whole[name] for name in names])
    np.testing.assert_allclose(ratios[0], 1.0, atol=0.03)
    np.testing.assert_allclose(ratios[0], ratios[1], atol=0.004)


def test_the_share_of_a_scene_feels_both_skins():
    own = {"conductivity": 30.0, "density": 7900.0, "heat_capacity": 500.0}
    bare, both, resting, moving = (
        prediction.heat_partition(rs.load_scene("demo", changes), rule="mean")
        for changes in (
            {"counterface": own},
            {"counterface": own | {"skin": OXIDE}, "body.skin": OXIDE},
            {"counterface": own | {"skin": OXIDE}},
            {"counterface": own, "body.skin": OXIDE},
        )
    )
    assert ((moving < bare) & (bare < resting)).all()
    assert ((moving < both) & (both < resting)).all()


def test_a_duration_too_short_for_a_skin_is_refused_by_key_with_the_one_that_is_not(tmp_path):
    young = {"sliding__duration": 1e-8, "body__skin": OXIDE}
    with pytest.raises(
        SceneError, match=r"^sliding.duration = 1e-08 s is too short: heat spreads"
    ) as refused:
        rs.run(steel(**young), tmp_path / "run")
    assert not (tmp_path / "run").exists()
    times = float(re.search(r"take ([\d.e+]+) times the duration, or more$", str(refused.value))[1])
    prediction.background(steel(**young | {"sliding__duration": 1.01e-8 * times}))
    with pytest.raises(SceneError):
        prediction.background(steel(**young | {"sliding__duration": 0.98e-8 * times}))
