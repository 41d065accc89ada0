"""Keys of a lay: what they mean, and what is refused in one sentence."""

from math import cos, pi, sqrt

import numpy as np
import pytest
from small_scene import CAPPED

import roughsim as rs
from roughsim.planning.limits import judge
from roughsim.prediction.statements import statements
from roughsim.scene import SceneError, parse_scene
from roughsim.surface.modes import mode_variance

FREE = CAPPED[: CAPPED.index("[numerics]")].replace("speed = [0, ", "speed = [1, ")
LIKE, OTHER = 'like = "body"', "rms_height = 1e-7\nhurst = 0.8\nq_min = 1e4\nq_max = 1e6"
HEAT = "conductivity = 30\ndensity = 7900\nheat_capacity = 500"
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


def crossed(lay="lay = 2", **keys):
    """A scene of two faces with a lay each."""
    return grooved(text=FREE.replace(LIKE, f"{lay}\n{OTHER}\n{HEAT}"), **keys)


def test_lays_that_differ_have_square_pixels():
    scene = crossed('lay = 2\nlay_direction = "60 deg"')
    assert (scene.lay, scene.grooves, scene.lays_differ) == (1.0, (1.0, 0.0), True)
    assert scene.directions == (0.0, pi / 4, pi / 2)
    assert scene.headings == tuple(angle for angle in scene.directions for _ in scene.speeds[:3])
    assert scene.spectrum.directed
    assert parse_scene(scene.to_toml()) == scene
    # the same lay, if by another turn, is a stretched cell
    same = crossed("lay = 3\nlay_direction = -1e-12")
    assert (same.lay, same.lays_differ, same.spectrum.directed) == (3.0, False, False)
    assert crossed('lay = 3\nlay_direction = "1 deg"').lays_differ
    assert crossed("").lays_differ  # one face alone with a lay


def test_spectrum_of_two_lays_is_the_sum_of_both():
    plain = parse_scene(FREE.replace(LIKE, f"{OTHER}\n{HEAT}"))
    scene = crossed('lay = 2\nlay_direction = "60 deg"')
    angle = np.linspace(0, pi, 50)
    for q in (5e3, 3e4, 2.5e5):
        expected = np.zeros(angle.size)
        for face, lay, turn in zip(plain.faces, (3, 2), (0, pi / 3), strict=True):
            along, across = q * np.cos(angle - turn), q * np.sin(angle - turn)
            expected += face(np.hypot(along * sqrt(lay), across / sqrt(lay)))
        np.testing.assert_allclose(
            scene.spectrum.at(np.full(50, q), angle), expected, rtol=1e-9, atol=0.0
        )
    assert scene.spectrum.rms_height == pytest.approx(plain.spectrum.rms_height, rel=1e-9)


def test_two_lays_have_the_slopes_of_both():
    shape = "hurst = 0.8\nq_min = 5e4\nq_max = 1.5e5"
    text = FREE.replace(LIKE, f"rms_height = 4e-7\n{shape}\nlay = 2\nlay_direction = 1\n{HEAT}")
    begin, end = text.index("[surface]"), text.index("[body]")
    scene = parse_scene(
        text.replace(text[begin:end], f"[surface]\nrms_height = 3e-7\nlay = 3\n{shape}\n")
    )
    grid = rs.Grid((144, 144), (1e-3, 1e-3))
    power = mode_variance(scene.spectrum, grid) * grid.multiplicity
    qx, qy = grid.wavevectors
    # each face alone: ⟨h²⟩ k² with k² = 2π∫q³C/⟨h²⟩ of a power law, half of it in each direction, over or times γ
    (low, high), exponent = (5e4, 1.5e5), 2 * 0.8
    ends = [high**n - low**n for n in (2 - exponent, -exponent)]
    square = ends[0] / (2 - exponent) / (ends[1] / -exponent)
    first, second = 9e-14 * square / 2, 16e-14 * square / 2
    cos2 = cos(1) ** 2
    expected = [
        first / 3 + second * (cos2 / 2 + 2 * (1 - cos2)),
        first * 3 + second * (2 * cos2 + (1 - cos2) / 2),
    ]
    assert power.sum() == pytest.approx(25e-14, rel=1e-9)
    assert np.sum(power * qx**2) == pytest.approx(expected[0], rel=0.01)
    assert np.sum(power * qy**2) == pytest.approx(expected[1], rel=0.01)
    assert scene.rms_slope == pytest.approx(sqrt(sum(expected)), rel=3e-3)


def test_rms_slope_is_of_each_face_with_its_lay():
    rough = FREE.replace('rms_height = "0.9 um"', "rms_slope = 0.2")
    other = "rms_slope = 0.1\nhurst = 0.8\nq_min = 1e4\nq_max = 1e6"
    scene = grooved(text=rough.replace(LIKE, f"lay = 2\n{other}\n{HEAT}"))
    assert scene.rms_slope == pytest.approx(sqrt(0.2**2 + 0.1**2), rel=3e-3)


def test_lays_that_differ_are_stated():
    scene = crossed('lay = 2\nlay_direction = "60 deg"')
    stated = {remark.quantity: remark.value for remark in statements(scene)}
    assert stated["lay of [surface]"] == "3, at 0° from x"
    assert stated["lay of [counterface]"] == "2, at 60° from x"
    assert "lay" not in judge(scene).to_dict()
    assert any("square" in str(reason) for reason in rs.plan(scene).reasons)


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
    'sliding.direction = missing does not go with surface.lay = 3 and history = "sliding"': {
        "sliding": 'history = "sliding"\nslid_distance = 1e-3',
        "text": FREE.replace("heat_partition = 0.9\n", ""),
    },
    "counterface.lay = 2 beside a face of another lay does not go with a conductivity": {
        "keys": "",
        "text": FREE.replace(LIKE, f"lay = 2\n{OTHER}\n{HEAT}").replace(
            "conductivity = 30",
            "conductivity = { temperature = [300, 900], value = [50, 30] }",
            1,
        ),
        "sliding": "background_temperature = 300",
    },
    'counterface.lay = 2 beside a face of another lay does not go with sliding.history = "sliding"': {
        "keys": "",
        "sliding": 'history = "sliding"\nslid_distance = 1e-3',
        "text": FREE.replace(LIKE, f"lay = 2\n{OTHER}\n{HEAT}").replace(
            "heat_partition = 0.9\n", ""
        ),
    },
    "lay = 3 does not go with a scan, which has a lay of its own": {
        "text": f"[surface]\n{MAP}" + FREE[FREE.index("[body]") :]
    },
    "numerics.lengths = .* does not go with surface.lay = 3": {"text": CAPPED},
}


@pytest.mark.parametrize("words", REFUSED)
def test_lay_is_refused_in_one_sentence(words):
    with pytest.raises(SceneError, match=words):
        grooved(**REFUSED[words])
