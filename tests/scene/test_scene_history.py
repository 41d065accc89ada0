"""Keys of history = "sliding" in a scene: what goes together, who carries which roughness, and identity."""

import pytest
from small_scene import CAPPED

from roughsim.scene import SceneError, parse_scene

MOVING = CAPPED.replace("speed = [0, 0.1, 35]", "speed = [0.1, 35]")


def scene(history, text=MOVING):
    return parse_scene(text.replace("[theory]", f"{history}\n[theory]"))


def test_a_slide_among_the_levels_needs_the_history():
    slide = '{ column = "sliding", shape = [64, 64], q_max = 5e4, first = 3 },\n]'
    text = MOVING.replace("},\n]", f"}},\n  {slide}")
    assert scene('history = "sliding"\nslid_distance = 1', text).numerics.levels[-1].first == 3
    with pytest.raises(
        SceneError, match=r'levels\[3\].column = "sliding" needs sliding.history = "sliding"'
    ):
        scene("", text)


def test_the_surface_rides_with_the_body_if_both_faces_are_rough():
    own = 'rms_height = "0.2 um"\nhurst = 0.5\nq_min = 1e4\nq_max = 1e5'
    thermal = "conductivity = 30\ndensity = 7900\nheat_capacity = 500"
    rough = scene("", MOVING.replace('like = "body"', f"{own}\n{thermal}"))
    resting, moving = rough.sliding_faces
    assert resting.rms_height == pytest.approx(2e-7)
    assert moving.rms_height == pytest.approx(9e-7)
    smooth = scene("", MOVING.replace('like = "body"', thermal))
    assert smooth.sliding_faces == (smooth.faces[0], None)  # one rough face rests
    alike = scene("")
    assert alike.sliding_faces[0] == alike.sliding_faces[1]


def test_distances_follow_from_the_speeds_and_a_duration():
    assert scene('history = "sliding"\nduration = "2 ms"').sliding.distances == pytest.approx(
        (2e-4, 7e-2)
    )
    assert scene('history = "sliding"\nslid_distance = "2 mm"').sliding.distances == (2e-3, 2e-3)


def test_the_identity_of_frozen_scenes_is_what_it_was():
    frozen = scene("")
    assert "sliding.history" not in frozen.identity()
    assert "sliding.slid_distance" not in frozen.identity()
    assert all("first" not in level for level in frozen.identity()["numerics.levels"])
    assert scene('history = "frozen"').identity() == frozen.identity()
    sliding = scene('history = "sliding"\nslid_distance = 1e-3')
    assert {
        **frozen.identity(),
        "sliding.history": "sliding",
        "sliding.slid_distance": 1e-3,
    } == sliding.identity()
    assert parse_scene(sliding.to_toml()) == sliding
