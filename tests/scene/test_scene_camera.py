"""The section [camera]: what it changes in a scene, and its refusals that depend on other sections."""

import pytest
from small_scene import CAPPED

from roughsim.observables.catalogue import observables_of
from roughsim.scene import SceneError, parse_scene

SEEN = {"seen_rms", "seen_99", "seen_width"}


def scene(camera="[camera]", speed="[0, 0.1, 35]"):
    text = CAPPED.replace("speed = [0, 0.1, 35]", f"speed = {speed}")
    return parse_scene(text.replace("[theory]", f"{camera}\n[theory]"))


def test_a_camera_asks_for_what_it_sees():
    assert set(observables_of(scene().asks)) - set(observables_of()) == SEEN
    assert not set(observables_of(scene("").asks)) & SEEN
    assert scene("").camera is None


def test_an_empty_camera_is_sharp_and_rests():
    camera = scene().camera
    assert (camera.resolution, camera.exposure, camera.behind) == (0.0, 0.0, None)
    assert camera.fixed_to == "counterface"


@pytest.mark.parametrize(("fixed_to", "smear"), [("body", 7e-4), ("counterface", 0.0)])
def test_frozen_contact_moves_past_a_camera_on_the_body(fixed_to, smear):
    found = scene(f'[camera]\nexposure = "20 us"\nfixed_to = "{fixed_to}"').camera
    assert found.smear(35.0) == pytest.approx(smear)


def test_a_camera_is_part_of_the_identity():
    plain, sharp, blurred = scene(""), scene(), scene('[camera]\nresolution = "4 um"')
    assert not any(key.startswith("camera") for key in plain.identity())
    assert sharp.identity() != blurred.identity()
    assert parse_scene(blurred.to_toml()) == blurred


@pytest.mark.parametrize(
    ("camera", "speed", "words"),
    [
        ("[camera]", "[0]", "camera sees nothing: sliding.speed = 0 m/s makes no"),
        ("[camera]\nbehind = 1e-5", "[0, 1]", "camera.behind = 1e-05 m does not go with sliding.s"),
    ],
)
def test_a_camera_without_heat_is_refused(camera, speed, words):
    with pytest.raises(SceneError, match=words):
        scene(camera, speed)


def test_a_blur_of_more_than_the_longest_wave_is_refused():
    assert scene('[camera]\nresolution = "0.98 mm"').camera.resolution == 0.98e-3
    words = r"camera.resolution = 1 m is above the longest wave, 2π/q_min = 0.000989478 m"
    with pytest.raises(SceneError, match=words):
        scene('[camera]\nresolution = "1 m"')
