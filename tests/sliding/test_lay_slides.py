"""Slides of faces with a lay, along and across their grooves: on pixels of γ:1, and the keys of a scene."""

from dataclasses import replace
from math import atan, cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.special import wofz
from small_scene import CAPPED

from roughsim import Body, Grid, Solid
from roughsim.planning.realization import slide_problem
from roughsim.prediction import sliding_prediction
from roughsim.prediction.sliding import continuation_fault, sliding_error
from roughsim.scene import SceneError, parse_scene
from roughsim.scene.numerics import Level, Numerics
from roughsim.sliding.history import follow
from roughsim.sliding.member import faces, solve_slide
from roughsim.sliding.path import oblique_path, slope
from roughsim.sliding.stepping import Motion, contacts

LENGTHS = 3e-3, 1e-3
COARSE, SQUARE = Grid((18, 18), LENGTHS), Grid((54, 18), LENGTHS)
D, SPEED = 7.6e-6, 3.0


def pressed(grid, steps, directed=True):
    """A slide in full contact of two faces with long waves alone: the same on any pixel that resolves them."""
    x, y = (np.arange(n) / n for n in grid.shape)
    wave = np.cos(2 * pi * (2 * x[:, None] + y)) + np.sin(2 * pi * (x[:, None] - 3 * y + 0.1))
    riding = np.cos(2 * pi * (3 * x[:, None] + 2 * y + 0.3))
    path = oblique_path(grid, 1.5 * LENGTHS[0], steps)
    solid = Solid(1e9)
    along = contacts(1e-7 * wave, 1e-7 * riding, grid, solid, 1e7, path, tolerance=1e-9)
    body = Body(30.0, D)
    motions = [Motion(SPEED, 0.3, body, Body(15.0, D / 2))]
    return path, follow(along, grid, path, motions, directed=directed)


def test_oblong_pixels_slide_as_square_ones():
    (path, long), (other, short) = (pressed(grid, 27) for grid in (COARSE, SQUARE))
    np.testing.assert_allclose(path.distance, other.distance, rtol=1e-12)
    frozen = (one.curves["frozen_flash_temperature"] for one in (long, short))
    np.testing.assert_allclose(*frozen, rtol=1e-6)
    # the share of the heat at each point has waves that the long pixel does not resolve
    for name in ("flash_temperature", "moving_share", "background"):
        np.testing.assert_allclose(long.curves[name], short.curves[name], rtol=2e-2)


def test_frozen_contact_slides_along_the_path():
    _, slid = pressed(COARSE, 27)
    angle = atan(slope(COARSE))
    rate, chord = SPEED / D, LENGTHS[0] / cos(angle)
    pressure = np.fft.fft2(slid.contact.pressure) / COARSE.points
    qx, qy = (
        2 * pi * np.fft.fftfreq(n, length / n)
        for n, length in zip(COARSE.shape, LENGTHS, strict=True)
    )
    along = qx[:, None] * cos(angle) + qy * sin(angle)
    root = np.sqrt(qx[:, None] ** 2 + qy**2 - 1j * rate * along)
    root[0, 0] = 1.0
    z = root * sqrt(chord / 2 / rate)
    response = (1 - np.exp(-(z**2)) * wofz(1j * z)) / root
    variance = np.abs(pressure) ** 2
    variance[0, 0] = 0.0
    expected = 0.3 * SPEED / (30.0 * 1e7) * float(np.sum(variance * response.real))
    assert slid.curves["frozen_flash_temperature"][0, -1] == pytest.approx(expected, rel=1e-6)


SLIDING = 'history = "sliding"\nslid_distance = 1e-3\ndirection = "{} deg"\n'
FREE = CAPPED.replace("lengths = [2e-3, 2e-3]\n", "").replace("[0, 0.1, 35]", "[1]")
LEVELS = (
    Level("capped", (48, 48), 5e4),
    Level("sliding", (48, 48), 5e4),
)


def scene(lay=3, direction="30", grooves="30", keys=SLIDING, text=FREE):
    face = f'[surface]\nlay = {lay}\nlay_direction = "{grooves} deg"\n'
    text = text.replace("heat_partition = 0.9\n", keys.format(direction))
    return parse_scene(text.replace("[surface]\n", face))


def problem(**changes):
    return slide_problem(scene(**changes), Numerics(LEVELS, (2e-3, 2e-3), tolerance=1e-4))


def test_slide_stretches_its_cell():
    along, across = problem(), problem(direction="120")
    assert along.cell.lengths == pytest.approx((2e-3 * sqrt(3), 2e-3 / sqrt(3)))
    assert across.cell.lengths == pytest.approx((2e-3 / sqrt(3), 2e-3 * sqrt(3)))
    for one in (along, across):
        coarser = one.coarser
        assert coarser is None or coarser.cell.lengths == one.cell.lengths
    drawn = faces(along), faces(across), faces(problem(lay=1))
    for first, *others in zip(*drawn, strict=True):
        for other in others:
            np.testing.assert_array_equal(first, other)


def test_lay_heats_along_its_grooves():
    found = {}
    short = SLIDING.replace("1e-3", "3e-4")
    for name, angle in {"along": "30", "across": "120"}.items():
        numbers = solve_slide(problem(direction=angle, keys=short)).moments[0].numbers
        found[name] = (
            numbers["sliding_flash_temperature"][0],
            numbers["sliding_frozen_flash_temperature"][0],
        )
    assert found["along"][0] > 1.1 * found["across"][0]
    assert found["along"][1] > 1.1 * found["across"][1]


@pytest.mark.slow
def test_faint_lay_slides_as_none():
    plain = problem(lay=1)
    faint = replace(plain, lay=1.0001)
    names = "sliding_flash_temperature", "sliding_share", "sliding_background"
    first, second = (solve_slide(one).moments[0].numbers for one in (plain, faint))
    for name in names:
        np.testing.assert_allclose(second[name], first[name], rtol=2e-3)
    # in one direction and in the mean over all of them frozen contact is nearly as hot
    frozen = "sliding_frozen_flash_temperature"
    np.testing.assert_allclose(second[frozen], first[frozen], rtol=0.1)


def test_no_theory_slides_with_a_lay():
    found = scene()
    assert sliding_prediction(found) is None
    assert np.isnan(sliding_error(found))
    assert "lay" in continuation_fault(found)


REFUSED = {
    'sliding.direction = 75° does not go with surface.lay = 3 .* write direction = "30 deg" or "120 deg"': {
        "direction": "75"
    },
    "sliding.direction = missing does not go": {
        "keys": SLIDING.replace('direction = "{} deg"\n', "")
    },
    "camera does not go with surface.lay = 3 and sliding.history": {
        "text": FREE.replace("[theory]", "[camera]\n[theory]")
    },
}


@pytest.mark.parametrize("words", REFUSED)
def test_slide_that_no_path_allows_is_refused(words):
    with pytest.raises(SceneError, match=words):
        scene(**REFUSED[words])
