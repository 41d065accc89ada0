"""The page of a run with directions: its curves and reactions in the chosen one, and the map turned to it."""

from math import pi

import numpy as np
import pytest
from small_scene import CAPPED
from tasks_at_once import Now

import roughsim as rs
from roughsim.charts.reaction import points_of, reaction_lines
from roughsim.explore.content import OVER_SPEED, WatchedRun
from roughsim.scene import parse_scene

pytest.importorskip("bokeh")
from bokeh.document import Document

from roughsim.explore.page import Page

SCENE = (
    CAPPED.replace("lengths = [2e-3, 2e-3]\n", "")
    .replace("[surface]\n", '[surface]\nlay = 3\nlay_direction = "30 deg"\n')
    .replace("speed = [0, 0.1, 35]", 'speed = [0.1, 35]\ndirection = ["30 deg", "120 deg"]')
    .replace("max_realizations = 6", "realizations = 2")
    .replace('  { column = "capped", shape = [128, 128], q_max = 1e5 },\n', "")
)
HEAT = "[observables]\ntemperature_distribution = true\n[theory]"


@pytest.fixture(scope="module")
def grooved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("grooved") / "run"
    rs.run(parse_scene(SCENE.replace("[theory]", HEAT)), folder, progress=False)
    return Page(WatchedRun(folder), Document(), Now)


@pytest.mark.slow
@pytest.mark.parametrize("chosen", [1, 0])
def test_curves_are_in_the_chosen_direction(grooved, chosen):
    page = grooved
    control, run = page.controls.direction, page.watched.run
    assert control in page.controls.row.children
    assert control.visible
    assert control.options == [("0", "30°"), ("1", "120°")]
    control.value = str(chosen)
    label = {"direction": run.scene.directions[chosen]}
    for name in OVER_SPEED:
        panel = page.layout.curves[name]
        expected = run.estimate(name, "capped").sel(**label).mean * panel.factor
        np.testing.assert_array_equal(panel.sources["capped"].data["y"], expected)
        theory = panel.sources["theory"].data["y"]
        own = rs.theory(run.scene.towards(label["direction"])).to_dict()
        x = panel.sources["theory"].data["x"]
        at = np.exp(np.interp(np.log([0.1, 35.0]), np.log(x), np.log(theory)))
        np.testing.assert_allclose(at / panel.factor, np.ravel(own[name]), rtol=2e-3)
    # the grooves are along x on the map
    assert page.temperature.direction == pytest.approx(chosen * pi / 2)
    assert page.controls.angle.value == 90 * chosen
    hottest = page.reactions.sources["hotter"][0].data["x"]
    name = "temperature_quantile_05"
    quantile = run.estimate(name, "capped").sel(speed=35.0, **label).mean
    assert hottest[0] == pytest.approx(float(quantile))
    # quantiles of a face with a lay have no law, which neither page nor chart draws
    assert np.isnan(page.reactions.sources["hotter"][0].data["theory"]).all()
    lines = reaction_lines(run, "capped", label["direction"])
    assert points_of(lines["hotter"]["of the heat"], "capped")[2] is None
