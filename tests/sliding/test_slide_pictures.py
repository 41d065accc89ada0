"""What a camera sees of a slide: frozen contact by its modes, the exposure, and the column sliding of a run."""

from dataclasses import replace
from math import atan, log, sqrt

import numpy as np
import pytest
from scipy.special import erf
from slide_cases import MILLIMETRE, sliding_scene

import roughsim as rs
from roughsim.comparison.camera import pictured
from roughsim.heat.camera import Lens
from roughsim.heat.periodic import MovingSource
from roughsim.observables.camera import Camera
from roughsim.planning.realization import slide_problem
from roughsim.planning.sliding import slide_level
from roughsim.sliding.member import SlideProblem, faces, solve_slide
from roughsim.sliding.path import slope
from roughsim.sliding.pictures import Shutter, exposed

SEEN = ("seen_rms", "seen_99", "seen_width")
SIDE, POINTS, SPEED, DIFFUSIVITY, HEATING = 1e-3, 96, 2.0, 7.6e-6, 0.11 * 2.0 / 30.0
SLID, EXPOSURE, SPREAD = 0.6e-3, 90e-6, 30e-6
FAR = MILLIMETRE.replace("1 mm", "8 mm")


def slide(on_body):
    """A rough face at rest under a flat that takes all heat: its contact is frozen."""
    wave = 2 * np.pi / SIDE
    grid = rs.Grid((POINTS, POINTS), (SIDE, SIDE))
    lens = Lens(SPREAD, EXPOSURE if on_body else 0.0)
    source = MovingSource((SPEED / DIFFUSIVITY, 0.0), DIFFUSIVITY * SLID / SPEED, lens=lens)
    camera = Camera((source,), (HEATING,), atan(slope(grid)))
    return SlideProblem(
        rs.SelfAffineSpectrum.from_rms_slope(0.1, hurst=0.8, q_min=2 * wave, q_max=12 * wave),
        None,
        grid,
        rs.Solid(1e11),
        3e8,
        rs.HeatSource([SPEED], 0.11, 30.0, DIFFUSIVITY),
        (rs.Body(1e-6, DIFFUSIVITY),),
        (SLID,),
        tolerance=1e-6,
        seed=1,
        stream=0,
        shutter=Shutter(camera, (EXPOSURE,), on_body),
    )


def picture_by_modes(problem, on_body):
    """Amplitudes of the picture, K, with the waves along and across sliding: the mean over 8 ages of the contact."""
    grid, slant = problem.grid, slope(problem.grid)
    contact = rs.solve_contact(
        faces(problem)[0], grid, problem.solid, nominal_pressure=3e8, tolerance=1e-6
    )
    flux = HEATING * np.fft.fft2(contact.pressure) / grid.points
    qx, qy = np.meshgrid(*[2 * np.pi * np.fft.fftfreq(POINTS, SIDE / POINTS)] * 2, indexing="ij")
    along, across = (qx + slant * qy) / sqrt(1 + slant**2), (qy - slant * qx) / sqrt(1 + slant**2)
    flux[0, 0], qx[0, 0] = 0.0, 1.0
    root = np.sqrt(qx**2 + qy**2 - 1j * along * SPEED / DIFFUSIVITY)
    picture = np.zeros_like(flux)
    for before in (np.arange(8) + 0.5) / 8 * EXPOSURE:
        grown = erf(root * sqrt(DIFFUSIVITY * (SLID - before) / SPEED))
        # on the body the contact has then still to move by that
        moved = np.exp(1j * along * before) if on_body else 1.0
        picture += flux / root * grown * moved / 8
    blur = SPREAD / sqrt(8 * log(2))
    return picture * np.exp(-(qx**2 + qy**2) * blur**2 / 2), across


@pytest.mark.parametrize("on_body", [True, False], ids=["on the body", "at rest"])
def test_a_picture_of_frozen_contact_is_the_sum_of_its_modes(on_body):
    problem = slide(on_body)
    numbers = solve_slide(problem).numbers
    picture, across = picture_by_modes(problem, on_body)
    field = np.fft.ifft2(picture).real * POINTS**2
    # 8 pixels per shortest wave, and steps of one pixel: .9 % at most, and a quarter of that with half the pixel
    assert numbers["sliding_seen_rms"][0] == pytest.approx(field.std(), rel=0.012)
    assert numbers["sliding_seen_99"][0] == pytest.approx(np.quantile(field, 0.99), rel=0.04)
    y = np.linspace(0.0, 1e-4, 400)
    power = np.abs(picture) ** 2
    correlation = np.array([np.sum(power * np.cos(across * one)) for one in y]) / power.sum()
    half = np.interp(-0.5, -correlation, y)
    assert numbers["sliding_seen_width"][0] == pytest.approx(2 * half, rel=0.015)


@pytest.mark.parametrize("steps", [0.0, 0.3, 1.0, 2.5, 7.0])
def test_an_exposure_averages_linear_temperatures_exactly(steps):
    weights = exposed(steps, 7)
    assert weights.sum() == pytest.approx(1.0, rel=1e-6)
    # their mean age is half of the exposure, so that what changes linearly is averaged exactly
    assert weights @ np.arange(weights.size) == pytest.approx(steps / 2, abs=1e-6)
    np.testing.assert_allclose(exposed(0.5, 7), [0.75, 0.25], atol=1e-12)
    np.testing.assert_allclose(exposed(2.0, 7), [0.25, 0.5, 0.25, 0.0], atol=1e-12)


def test_an_exposure_longer_than_the_slide_is_unknown():
    assert exposed(7.5, 7).size == 0
    problem = replace(slide(True), grid=rs.Grid((32, 32), (SIDE, SIDE)))
    longer = problem.shutter._replace(exposures=(2 * SLID,))
    numbers = solve_slide(replace(problem, shutter=longer)).numbers
    assert all(np.isnan(numbers[f"sliding_{name}"]).all() for name in SEEN)
    assert numbers["sliding_frozen_seen_rms"] > 0.0


def seen_scene(camera, history=MILLIMETRE):
    return sliding_scene(history, ("[theory]", f"[camera]\n{camera}\n[theory]"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    scene = seen_scene('resolution = "20 um"\nexposure = "5 us"\nfixed_to = "body"')
    return rs.run(scene, tmp_path_factory.mktemp("seen") / "run", workers=1, max_realizations=2)


@pytest.mark.parametrize("name", SEEN)
def test_the_column_sliding_changes_the_picture_of_frozen_contact(run, name):
    slid, frozen, coarser, coarser_frozen = (
        np.array([run.members[1, k].numbers[f"sliding_{kind}{name}"] for k in (0, 1)])
        for kind in ("", "frozen_", "coarser_", "coarser_frozen_")
    )
    ratio = slid.mean(axis=0) / frozen.mean(axis=0)
    coarse = coarser.mean(axis=0) / coarser_frozen.mean(axis=0)
    # what is left falls with the pixel to the power 1 … 1.5
    ends = np.array([1 / (4 / 3 - 1), 1 / ((4 / 3) ** 1.5 - 1)])
    change = ratio + ends.mean() * (ratio - coarse)
    single = run.values(name).value  # all heat in the moving body
    assert run.estimate(name, "sliding").mean == pytest.approx(single * change, rel=1e-9)
    assert run.estimate(name, "sliding").budget["slide"].min() > 0.0


@pytest.mark.parametrize(
    ("known", "columns"), [(True, "capped, sliding, calibrated"), (False, "capped, calibrated")]
)
def test_a_line_shows_the_picture_of_columns_that_have_it(run, known, columns):
    seen = run.estimate("seen_rms")
    found = dict.fromkeys(("capped", "sliding", "calibrated"), lambda _: seen)
    if not known:
        found["sliding"] = lambda _: None
    (line,) = pictured(run.scene, found, "capped", "sliding")
    assert line.startswith(f"camera at 35 m/s ({columns}): seen_rms, K {seen.number(1)}, ")


@pytest.mark.parametrize(
    ("camera", "taken"), [('behind = "100 um"', False), ("", True)], ids=["behind", "sharp"]
)
def test_a_line_behind_the_contact_is_not_followed(camera, taken):
    scene = seen_scene(camera)
    problem = slide_problem(scene, rs.plan(scene))
    assert (problem.shutter is not None) == taken


def test_the_shutter_is_open_while_the_bodies_slide_by_speed_times_exposure(run):
    shutter = slide_problem(run.scene, run.numerics).shutter
    assert shutter.exposures == pytest.approx((5e-6, 175e-6))
    assert shutter.on_body
    assert shutter.camera.direction == pytest.approx(atan(slope(run.numerics.grid(1))))
    still = seen_scene("")
    assert not slide_problem(still, rs.plan(still)).shutter.on_body


def test_slides_with_a_camera_are_followed_to_their_end():
    scene, plain = seen_scene("", FAR), sliding_scene(FAR)
    assert slide_level(plain, rs.plan(plain)).followed is not None
    assert slide_level(scene, rs.plan(scene)).followed is None
