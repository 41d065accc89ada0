"""What a reaction feels on the page of a run: the lines of the picture, with their errors and the theory."""

import numpy as np
import pytest
from small_scene import CAPPED

import roughsim as rs
from roughsim.observables.distribution import LEVELS
from roughsim.scene import parse_scene

pytest.importorskip("bokeh")
pytestmark = pytest.mark.usefixtures("few_fields")
REACTION = """
[observables]
temperature_distribution = true
[reaction]
activation_energy = ["1.5 eV", "0.6 eV"]
prefactor = "1e13 1/s"
"""


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    text = CAPPED.replace(
        "heat_partition = 0.9\n", 'heat_partition = 0.9\nbackground_temperature = "700 K"\n'
    )
    scene = parse_scene(text.replace("[theory]\n", f"{REACTION}[theory]\n"))
    return rs.run(scene, tmp_path_factory.mktemp("asked") / "run", max_realizations=3)


def data(page, panel, number):
    return page.reactions.sources[panel][number].data


def test_the_page_has_the_temperatures_and_rates_of_the_comparison(opened, asked):
    page = opened(asked.folder)
    assert page.reactions.root in page.layout.root.children
    assert page.reactions.root.visible
    rows = {
        (row.observable, row.about.get("energy"), row.speed): row for row in rs.compare(asked).rows
    }
    for number, of in enumerate(("", "area_")):
        shown = data(page, "hotter", number)
        np.testing.assert_allclose(shown["y"], 100.0 * (1.0 - np.array([*LEVELS.values()])))
        of_levels = [rows[f"temperature_quantile_{of}{name}", None, 35.0] for name in LEVELS]
        np.testing.assert_allclose(shown["x"], [row.columns["capped"].mean for row in of_levels])
        np.testing.assert_allclose(shown["theory"], [row.calibrated for row in of_levels])
    for number, energy in enumerate((1.5, 0.6)):
        shown = data(page, "activation_temperature", number)
        np.testing.assert_allclose(shown["x"], [0.1, 35.0])  # not at rest
        of_speeds = [rows["activation_temperature", energy, speed] for speed in (0.1, 35.0)]
        np.testing.assert_allclose(shown["y"], [row.columns["capped"].mean for row in of_speeds])
        errors = np.array([row.columns["capped"].total_error for row in of_speeds])
        np.testing.assert_allclose(
            np.array(shown["high"]) - shown["y"], np.where(np.isfinite(errors), errors, 0.0)
        )
        np.testing.assert_allclose(shown["theory"], [row.calibrated for row in of_speeds])
    for number, energy in enumerate((1.5, 0.6)):
        shown = data(page, "reaction_rate", number)
        np.testing.assert_allclose(shown["x"], [0.1, 35.0])
        of_speeds = [rows["reaction_rate", energy, speed] for speed in (0.1, 35.0)]
        np.testing.assert_allclose(shown["y"], [row.columns["capped"].mean for row in of_speeds])
        np.testing.assert_allclose(shown["theory"], [row.calibrated for row in of_speeds])
        assert np.all(np.array(shown["low"]) > 0.0)
    legends = [item.label.value for item in page.reactions.figures["reaction_rate"].legend[0].items]
    assert legends == ["1.5 eV", "0.6 eV"]
