"""The maps of two faces in contact: their sum, and its press."""

import math
import warnings

import numpy as np
import pytest
from press_cases import GRID, drawn_map, write_scene

import roughsim as rs
from roughsim.results.folder import open_run
from roughsim.surface.topography.measured import levelled
from roughsim.surface.topography.reading import Topography
from roughsim.surface.topography.sums import sum_of_faces


def face(shape, lengths, heights, *, about=(0.0, 0.0), periodic=False):
    """A map of a function of the distances from its middle, m."""
    grid = rs.Grid(shape, lengths)
    x, y = (
        ((np.arange(n) - 0.5 * (n - 1)) * d + c)
        for n, d, c in zip(shape, grid.spacing, about, strict=True)
    )
    return Topography(heights(x[:, None], y), grid, periodic)


def lopsided(x, y):
    return np.cos(9 * x + 5 * y + 0.3) + 0.4 * np.sin(3 * x - 7 * y)


def other(x, y):
    return np.sin(4 * x + 6 * y + 0.8)


def facing(x, y):
    return lopsided(x, y) + other(x, -y)


@pytest.mark.parametrize(
    ("shape", "lengths", "second", "common"),
    [
        ((64, 80), (0.64, 0.8), ((64, 80), (0.64, 0.8)), (64, 80)),
        ((64, 80), (0.64, 0.8), ((70, 66), (0.7, 0.66)), (64, 66)),
        ((64, 80), (0.64, 0.8), ((40, 50), (0.8, 1.0)), (64, 80)),
        ((40, 50), (0.8, 1.0), ((64, 80), (0.64, 0.8)), (64, 80)),
    ],
    ids=["alike", "cropped", "second coarser", "first coarser"],
)
def test_the_sum_is_of_the_second_face_turned(shape, lengths, second, common):
    found = sum_of_faces(face(shape, lengths, lopsided), face(*second, other))
    assert found.grid.shape == common
    assert found.grid.spacing == pytest.approx((0.01, 0.01))
    exact = levelled(face(common, tuple(0.01 * n for n in common), facing).heights)
    np.testing.assert_allclose(found.heights, exact, atol=2e-4)  # cubic: (q d)⁴/4! per coarse step
    assert "the second one turned about x" in found.taken


def test_periodic_maps_stay_periodic():
    lengths = (2 * math.pi, 4 * math.pi)

    def wave(x, y):
        return np.cos(3 * x + 2 * y + 0.3)

    def both(x, y):
        return wave(x, y) + wave(x, -y)

    one, two = (
        face((32, 32), lengths, wave, periodic=True),
        face((32, 32), lengths, wave, periodic=True),
    )
    found = sum_of_faces(one, two)
    assert found.periodic
    np.testing.assert_allclose(found.heights, face((32, 32), lengths, both).heights, atol=1e-12)
    coarse = face((16, 16), lengths, wave, periodic=True)
    refined = sum_of_faces(one, coarse)
    assert refined.grid.shape == (32, 32)
    assert np.std(refined.heights) == pytest.approx(
        np.std(found.heights), rel=0.05
    )  # the points of the middle differ


@pytest.mark.parametrize("periodic", [True, False])
def test_waves_beyond_the_cut_of_a_face_are_not_in_the_sum(periodic):
    # waves of a period, or of half a period with even ends, as mirror images have them
    shape, lengths = (32, 64), (1.0, 2.0)
    x, y = ((np.arange(n) + 0.5) / n * length for n, length in zip(shape, lengths, strict=True))
    unit = 2 * math.pi if periodic else math.pi
    grid = rs.Grid(shape, lengths)

    def wave(k):
        return np.cos(unit * k * x)[:, None] * np.cos(unit * y)

    noisy = Topography(wave(2) + wave(12), grid, periodic, reliable=8 * unit)
    sharp = Topography(wave(10), grid, periodic)
    for one, two in ((noisy, sharp), (sharp, noisy)):
        found = sum_of_faces(one, two).heights
        np.testing.assert_allclose(found, levelled(wave(2) + wave(10), periodic), atol=1e-12)


@pytest.mark.statistical
@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
def test_two_maps_are_pressed_as_their_sum(capped_scene, tmp_path):
    # the sum by hand, as one map on a smooth face, carries and heats alike
    surface = drawn_map()
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    second = 0.5 * np.roll(surface, 20, axis=0)
    single = write_scene(tmp_path / "one", surface + second[:, ::-1], capped_scene)
    double = write_scene(tmp_path / "two", surface, capped_scene)
    np.save(tmp_path / "two" / "second.npy", 1e6 * second)
    keys = f'topography = "second.npy"\ntopography_size = {list(GRID.lengths)}\ntopography_unit = "um"\n'
    double.write_text(double.read_text().replace("[counterface]\n", f"[counterface]\n{keys}"))
    cut = {"surface.topography_cut": 8e4}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        runs = [rs.press(single, single.parent / "run", changes=cut)]
        runs.append(
            rs.press(
                double, double.parent / "run", changes={**cut, "counterface.topography_cut": 8e4}
            )
        )
    one, two = (run.estimate("flash_temperature").mean for run in runs)
    np.testing.assert_allclose(two, one, rtol=1e-3)
    reasons = {
        reason.quantity: reason.text for reason in open_run(double.parent / "run").numerics.reasons
    }
    assert "sum of both maps" in reasons["map"]
