"""The lay of a face by line scans: exact structure functions, drawn faces, and refusals."""

import math
import warnings

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.scene.scans import _with_lay
from roughsim.surface.topography.line_lay import Line, lay_of_lines, stretch
from roughsim.surface.topography.reading import Profile

COUNT, STEP = 4096, 2e-6


def waves(angle, gamma, grooves, seed=1):
    """A line across one sum of waves of all directions, from 20 to 100 µm, with an isotropic C(q′)."""
    rng = np.random.default_rng(seed)
    q = 2e5 * 0.3 ** rng.uniform(size=1000)
    turn, phase = 2 * math.pi * rng.uniform(size=(2, 1000))
    # of the stretched face along the line: q′ in its own frame
    across = (math.sin(angle - grooves), math.cos(angle - grooves))
    along = q * (np.cos(turn) * across[1] / math.sqrt(gamma))
    along = along + q * np.sin(turn) * across[0] * math.sqrt(gamma)
    x = STEP * np.arange(COUNT)
    return Line(1e-8 * np.cos(x[:, None] * along + phase).sum(axis=1), COUNT * STEP, angle)


@pytest.mark.parametrize("gamma", some([1.5, 3.0, 6.0], 2))
def test_lines_along_and_across_give_the_lay(gamma):
    for grooves in (0.0, math.pi / 2):
        lines = [waves(angle, gamma, grooves) for angle in (0.0, math.pi / 2)]
        found = lay_of_lines(lines)
        assert found[0] == pytest.approx(gamma, rel=0.08)
        assert found[1] == pytest.approx(grooves)


def test_an_oblique_second_line_gives_the_same_lay():
    lines = [waves(0.3, 4.0, 0.3), waves(0.3 + math.pi / 4, 4.0, 0.3)]
    assert lay_of_lines(lines[::-1])[0] == pytest.approx(4.0, rel=0.1)


def test_three_lines_give_the_direction():
    lines = [waves(angle, 3.0, 0.4) for angle in (0.0, 1.0, 2.0)]
    gamma, grooves = lay_of_lines(lines)
    assert gamma == pytest.approx(3.0, rel=0.15)
    assert grooves == pytest.approx(0.4, abs=0.06)


def test_lines_of_other_steps_and_lengths():
    along, across = (waves(angle, 3.0, 0.0) for angle in (0.0, math.pi / 2))
    coarse = Line(along.heights[:-1024:2], 0.75 * along.length, 0.0)
    assert lay_of_lines([coarse, across])[0] == pytest.approx(3.0, rel=0.12)


def test_lines_become_those_of_the_isotropic_face():
    lines = [waves(angle, 3.0, 0.0) for angle in (0.0, math.pi / 2)]
    profiles = [Profile(line.heights, line.length, False, 1e5) for line in lines]
    section = {"topography_direction": ["0 deg", "90 deg"]}
    (along, across), keys = _with_lay(profiles, section)
    root = math.sqrt(keys["lay"])
    assert along.length == pytest.approx(COUNT * STEP / root)
    assert across.length == pytest.approx(COUNT * STEP * root)
    assert along.reliable == pytest.approx(1e5 * root)
    assert across.reliable == pytest.approx(1e5 / root)


def test_the_stretch_of_lines():
    # f = cos²δ/γ + γ sin²δ
    assert stretch(4.0, 0.0) == pytest.approx(0.5)
    assert stretch(4.0, math.pi / 2) == pytest.approx(2.0)
    assert stretch(4.0, math.pi / 4) == pytest.approx(math.sqrt(0.125 + 2.0))


def scene_of(folder, gamma, **keys):
    names = []
    for k, angle in enumerate((0.0, math.pi / 2)):
        np.savetxt(folder / f"line{k}.txt", waves(angle, gamma, 0.0).heights)
        names.append(str(folder / f"line{k}.txt"))
    body = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "penetration_hardness": 1.2e9}
    heat = {"conductivity": 30.0, "density": 7900.0, "heat_capacity": 500.0}
    slides = {"nominal_pressure": 9e7, "friction_coefficient": 0.11, "speed": [35.0]}
    surface = {
        "topography": names,
        "topography_size": f"{COUNT * STEP} m",
        "topography_unit": "m",
        "topography_direction": ["0 deg", "90 deg"],
    }
    surface = {key: value for key, value in (surface | keys).items() if value is not None}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rs.load_scene({"surface": surface, "body": body | heat, "sliding": slides})


def test_a_scene_of_lines_has_their_lay_and_the_waves_before_it(tmp_path):
    scene = scene_of(tmp_path, 3.0)
    assert scene.lay == pytest.approx(3.0, rel=0.1)
    assert scene.grooves[1] == 0.0
    assert len(scene.directions) == 3
    plain = scene_of(tmp_path, 1.0)
    assert plain.lay == 1.0
    assert not plain.directions
    # C(q′) is that of the face without the lay; of lines as they are it is 45 % less at 1e5 rad/m
    assert scene.spectrum.rms_height == pytest.approx(plain.spectrum.rms_height, rel=0.2)
    assert scene.spectrum(1e5) == pytest.approx(plain.spectrum(1e5), rel=0.3)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"topography_direction": ["0 deg", "10 deg"]}, "up to 10° apart"),
        ({"topography_direction": "0 deg"}, "1 angles for 2 files"),
        ({"lay": 3.0}, "lay does not go with surface.topography"),
    ],
)
def test_lines_without_a_lay_are_refused(tmp_path, keys, words):
    with pytest.raises(ValueError, match=words):
        scene_of(tmp_path, 3.0, **keys)


def test_smooth_and_rough_lines_have_nothing_in_common():
    rough = waves(0.0, 1.0, 0.0)
    faint = Line(1e-6 * rough.heights, rough.length, math.pi / 2)
    with pytest.raises(ValueError, match="no roughness in common"):
        lay_of_lines([rough, faint])
