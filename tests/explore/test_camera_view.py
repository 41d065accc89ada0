"""The page of a run with a camera: the picture as the camera takes it, or the temperature itself."""

import numpy as np
import pytest
from small_scene import CAPPED

import roughsim as rs
from roughsim.scene import parse_scene

pytest.importorskip("bokeh")
pytestmark = pytest.mark.usefixtures("few_fields")


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    text = CAPPED.replace("[theory]", '[camera]\nresolution = "60 um"\n[theory]')
    found = parse_scene(text.replace("until = {}", "until = { seen_rms = 0.1 }"))
    folder = tmp_path_factory.mktemp("seen") / "run"
    return rs.run(
        found.with_("numerics.keep_fields", 1).with_("ensemble.max_realizations", 1), folder
    )


def test_the_page_shows_the_picture_or_the_temperature_itself(seen, opened):
    page = opened(seen.folder)
    camera, level = page.layout.skin.camera, seen.picture("capped")
    assert camera.visible
    assert camera.active
    speed = page.temperature.speed
    for active, name, words in ((True, "seen", "through"), (False, "temperature", "")):
        camera.active = active
        field = seen.field(level, 0, name, speed=speed)
        np.testing.assert_allclose(page.temperature.field, field, atol=1e-5 * field.max())
        title = page.layout.maps["temperature"].figure.title.text
        assert ("through the camera" in title) == bool(words)
