"""Keys of a lay: what they mean, and what is refused in one sentence."""

from math import pi, sqrt

import pytest
from small_scene import CAPPED

from roughsim.scene import SceneError, parse_scene

FREE = CAPPED[: CAPPED.index("[numerics]")].replace("speed = [0, ", "speed = [1, ")
LIKE, OTHER = 'like = "body"', "rms_height = 1e-7\nhurst = 0.8\nq_min = 1e4\nq_max = 1e6"
MAP = """psd = [[1e4, 3.1e-23], [1e5, 7e-27]]
psd_convention = "persson"
psd_source = "scan"
"""


def grooved(keys="lay = 3", sliding="", text=FREE):
    return parse_scene(
        text.replace("[surface]\n", f"[surface]\n{keys}\n", 1).replace(
            "[sliding]\n", f"[sliding]\n{sliding}\n", 1
        )
    )


def test_lay_makes_an_axis_of_directions():
    scene, speeds = grooved(), parse_scene(FREE).speeds
    assert scene.directions == (0.0, pi / 4, pi / 2)
    assert scene.speeds == 3 * speeds
    assert scene.headings == tuple(angle for angle in scene.directions for _ in speeds)


def test_headings_are_counted_from_the_grooves():
    scene = grooved('lay = 3\nlay_direction = "30 deg"', 'direction = ["30 deg", "100 deg"]')
    assert scene.directions == pytest.approx([pi / 6, 5 * pi / 9])
    assert scene.headings[0] == 0.0
    assert scene.headings[-1] == pytest.approx(7 * pi / 18)


@pytest.mark.parametrize("keys", ["", "lay = 1", "lay = 1.0\nlay_direction = 1"])
def test_isotropic_face_has_no_axis_of_directions(keys):
    scene = grooved(keys, "direction = [0.5, 1]")
    assert scene.directions == ()
    assert scene.headings is None
    assert scene.speeds == scene.sliding.speed


def test_lay_keeps_heights_and_raises_slopes():
    plain, scene = parse_scene(FREE), grooved("lay = 4")
    assert scene.spectrum.rms_height == plain.spectrum.rms_height
    assert scene.rms_slope / scene.spectrum.rms_slope == pytest.approx(
        sqrt((4 + 1 / 4) / 2), rel=1e-14
    )


def test_rms_slope_is_of_the_face_with_its_lay():
    lone = FREE.replace('rms_height = "0.9 um"', "rms_slope = 0.2").replace(
        f"[counterface]\n{LIKE}", ""
    )
    assert grooved("lay = 4", text=lone).rms_slope == pytest.approx(0.2, rel=1e-12)


def test_one_direction_is_stored_as_a_number():
    assert grooved("", "direction = 0.5").identity()["sliding.direction"] == 0.5
    assert grooved("", "direction = [0.5, 1]").identity()["sliding.direction"] == [0.5, 1.0]


REFUSED = {
    "surface.lay = 0.5 must be at least 1: .* write 2, with lay_direction turned by 90 deg": {
        "keys": "lay = 0.5"
    },
    "surface.lay = 21 must be at most 20: .* press a map": {"keys": "lay = 21"},
    "surface.lay_direction = 1 rad goes with lay": {"keys": "lay_direction = 1"},
    r"sliding.direction\[1\] = 6.28319 rad is there twice": {
        "sliding": "direction = [0, 6.283185307179586]"
    },
    'surface.lay = 3 does not go with sliding.history = "sliding"': {
        "sliding": 'history = "sliding"\nslid_distance = 1e-3',
        "text": FREE.replace("heat_partition = 0.9\n", ""),
    },
    "surface.lay = 3 does not go with a conductivity that is a table": {
        "text": FREE.replace(
            "conductivity = 30",
            "conductivity = { temperature = [300, 900], value = [50, 30] }",
        ),
        "sliding": "background_temperature = 300",
    },
    "camera does not go with surface.lay = 3": {"text": f"{FREE}[camera]\nresolution = 1e-5\n"},
    "lay = 3 does not go with a scan, which has a lay of its own": {
        "text": f"[surface]\n{MAP}" + FREE[FREE.index("[body]") :]
    },
    "numerics.lengths = .* does not go with surface.lay = 3": {"text": CAPPED},
    "surface.lay = 3 at 0° and counterface.lay = 1 at 0° differ": {
        "text": FREE.replace(LIKE, OTHER)
    },
}


@pytest.mark.parametrize("words", REFUSED)
def test_lay_is_refused_in_one_sentence(words):
    with pytest.raises(SceneError, match=words):
        grooved(**REFUSED[words])
