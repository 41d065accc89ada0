"""Each known cliff from both sides: where a method still holds, and where it fails, warns or refuses."""

import warnings
from itertools import pairwise
from math import inf, nextafter, pi

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.contact import Contact
from roughsim.contact.patches import RESOLVED
from roughsim.heat import hot_spots, uniform_temperature
from theory import hertz

UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


def unit_spectrum(waves, hurst=0.8):
    """h′ = 1, `waves` per unit length at the roll-off and at the end."""
    q = 2 * pi * np.array(waves)
    return rs.SelfAffineSpectrum.from_rms_slope(
        1.0, hurst=hurst, q_min=2 * pi, q_roll_off=q[0], q_max=q[1]
    )


def unit_surface(points, waves=(4, 16), hurst=0.8, seed=0):
    grid = rs.Grid((points, points), (1.0, 1.0))
    return rs.synthesize(unit_spectrum(waves, hurst), grid, np.random.default_rng(seed)), grid


# steady periodic heat: hot tracks


def steady_excess(laps, points=128, directions=8):
    """Steady periodic T_flash of a rough source at vL/(2πD) = laps over the mean over all directions, less one."""
    heights, grid = unit_surface(points, (2, 32), seed=3)
    flux = np.maximum(heights / heights.std() + 3.0, 0.0)
    contact = Contact(flux, heights, 1.0, 0.0, 0.0, 0, 0.0)
    speed = 2 * pi * laps
    exact = rs.measure(contact, grid, rs.HeatSource([speed], 1.0, 1.0, 1.0)).flash_temperature[0]
    turns = [k * pi / directions for k in range(directions)]
    steady = [
        np.mean(
            flux
            * rs.sliding_temperature(
                flux, grid, speed=speed, slid_distance=inf, direction=turn, **UNIT
            )
        )
        for turn in turns
    ]
    rested = [
        np.mean(flux * rs.sliding_temperature(flux, grid, speed=speed, direction=turn, **UNIT))
        for turn in turns
    ]
    scale = speed / flux.mean() / exact
    return float(scale * np.mean(steady) - 1), float(scale * np.mean(rested) - 1)


def test_below_one_lap_the_steady_periodic_kernel_holds_and_does_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        excess, _ = steady_excess(0.7)  # the chord of the cell is up to √2 longer
    assert abs(excess) < 0.005


def test_far_above_one_lap_the_steady_periodic_kernel_is_too_hot_and_warns_where_from_rest_holds():
    with pytest.warns(RuntimeWarning, match="hot track"):
        excess, from_rest = steady_excess(1000.0)
    assert excess > 0.3
    assert abs(from_rest) < 0.02


# a single contact in a periodic box


def hertz_excess(kernel, peclet, side, pixels=8):
    """T_flash of a Hertz source in a box of `side` radii over the exact one, less one."""
    x = (np.arange(8 * pixels * side) - (8 * pixels * side - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    flux = fine.reshape(pixels * side, 8, pixels * side, 8).mean((1, 3))
    field = kernel(flux, rs.Grid(flux.shape, (float(side),) * 2), peclet)
    return float((field * flux).sum() / flux.sum()) / float(hertz.flash_temperature(peclet)) - 1


def steady(flux, grid, speed):
    return rs.sliding_temperature(flux, grid, speed=speed, slid_distance=inf, **UNIT)


def from_rest(flux, grid, speed):
    slid = grid.lengths[0] / 2 / speed
    return rs.sliding_temperature(flux, grid, speed=speed, **UNIT) + uniform_temperature(
        flux.mean(), slid, **UNIT
    )


def free(flux, grid, speed):
    return rs.half_space_temperature(flux, grid, speed=speed, **UNIT)


def test_a_slow_contact_is_spoilt_by_its_box_and_not_by_the_free_half_space():
    assert hertz_excess(steady, 0.01, 4) < -0.4  # it cools through its neighbours' mean
    assert hertz_excess(steady, 0.01, 16) == pytest.approx(
        hertz_excess(steady, 0.01, 4) / 4, rel=0.15
    )  # as R/L
    assert hertz_excess(from_rest, 0.01, 8) > 0.5  # so long a slide warms the whole box
    assert abs(hertz_excess(free, 0.01, 4)) < 0.01


@pytest.mark.parametrize("side", [4, 16])
def test_a_fast_contact_from_rest_does_not_see_its_box(side):
    assert abs(hertz_excess(from_rest, 100.0, side)) < 0.01
    assert abs(hertz_excess(free, 100.0, side)) < 0.01


def test_a_fast_contact_in_a_box_for_ever_is_twice_too_hot():
    with pytest.warns(RuntimeWarning, match="hot track"):
        assert hertz_excess(steady, 1000.0, 16) > 1.0


# roughness that the grid cannot hold


def test_roughness_up_to_the_nyquist_wavenumber_is_drawn_and_a_hair_beyond_is_refused():
    grid = rs.Grid((32, 32), (1.0, 1.0))
    rng = np.random.default_rng(0)
    surface = rs.synthesize(unit_spectrum((2, 16)), grid, rng)
    assert np.isfinite(surface).all()
    beyond = unit_spectrum((2, 16 * (1 + 1e-6)))
    with pytest.raises(rs.ResolutionError, match="exceeds the Nyquist wavenumber"):
        rs.synthesize(beyond, grid, rng)
    with pytest.raises(rs.ResolutionError, match="exceeds the Nyquist wavenumber"):
        rs.Numerics((rs.Level("elastic", (32, 32), beyond.breaks[-1]),), (1.0, 1.0))


def test_roughness_beyond_the_nyquist_wavenumber_is_never_folded_back():
    # cut at Nyquist, the surface lacks just what the spectrum holds above; folded back it would be rougher
    whole, grid = unit_spectrum((2, 64)), rs.Grid((32, 32), (1.0, 1.0))
    cut = whole.truncated(q_max=grid.nyquist)
    height = np.std(rs.synthesize(cut, grid, np.random.default_rng(1)))
    assert height == pytest.approx(cut.rms_height, rel=1e-9)
    assert height < whole.rms_height


@pytest.mark.parametrize("hurst", [0.0, 1.0])
def test_both_ends_of_the_hurst_exponent_are_solved_and_beyond_them_is_refused(hurst):
    heights, grid = unit_surface(64, hurst=hurst)
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.05)
    assert contact.residual <= 1e-6
    with pytest.raises(ValueError, match="hurst"):
        unit_spectrum((4, 16), hurst=hurst + (1e-9 if hurst else -1e-9))


@pytest.mark.parametrize(
    ("pixels", "least", "most"), [(2, 0.10, 0.40), (4, 0.005, 0.06), (8, 0.0, 0.006)]
)
def test_two_pixels_of_the_shortest_wave_are_too_few_and_four_will_do(pixels, least, most):
    flash = []
    for count in (4 * pixels, 4 * 32):  # 32 pixels stand for none
        heights, grid = unit_surface(count, (2, 4))
        contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.05)
        flash.append(
            rs.measure(contact, grid, rs.HeatSource([1e4], 1.0, 1.0, 1.0)).flash_temperature[0]
        )
    assert least <= abs(flash[0] / flash[1] - 1) < most


# contact at its limits


def test_a_hardness_just_above_the_load_is_solved_at_the_load_is_uniform_and_below_is_refused():
    heights, grid = unit_surface(64)
    load = 0.1
    solved = rs.solve_contact(
        heights, grid, rs.Solid(1.0, load * (1 + 1e-6)), nominal_pressure=load
    )
    assert solved.residual <= 1e-6
    assert solved.pressure.mean() == pytest.approx(load, rel=1e-12)
    assert 0.99 < solved.plastic_fraction <= solved.contact_fraction <= 1.0
    equal = rs.solve_contact(heights, grid, rs.Solid(1.0, load), nominal_pressure=load)
    assert (equal.pressure == load).all()
    with pytest.raises(ValueError, match="exceeds penetration_hardness"):
        rs.solve_contact(heights, grid, rs.Solid(1.0, nextafter(load, 0.0)), nominal_pressure=load)


@pytest.mark.parametrize("side", [1 - 1e-6, 1 + 1e-6])
def test_a_load_on_either_side_of_full_contact_gives_the_same_contact(side):
    # p = σ₀ + F⁻¹[E* q h_q/2] is ≥ 0 everywhere from the load that just fills the lowest point
    heights, grid = unit_surface(64)
    modes = np.fft.rfft2(heights)
    q = 2 * pi * np.hypot(64 * np.fft.fftfreq(64)[:, None], 64 * np.fft.rfftfreq(64))
    stress = np.fft.irfft2(0.5 * q * modes, s=heights.shape)
    load = -stress.min() * side
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=load, tolerance=1e-8)
    exact = np.maximum(load + stress, 0.0)
    assert np.linalg.norm(contact.pressure - exact) < 1e-5 * np.linalg.norm(exact)
    assert (contact.contact_fraction == 1.0) == (side > 1.0)


def test_a_tolerance_above_the_rounding_floor_is_met_and_below_it_the_solve_stops_and_says_so():
    heights, grid = unit_surface(64)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        met = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.05, tolerance=1e-11)
    assert met.residual <= 1e-11
    with pytest.warns(RuntimeWarning, match="below the rounding floor"):
        floor = rs.solve_contact(
            heights, grid, rs.Solid(1.0), nominal_pressure=0.05, tolerance=1e-20
        )
    assert 1e-20 < floor.residual < 1e-11


# patches of few pixels


def disc(pixels_per_radius, side=24):
    x = np.arange(side) - (side - 1) / 2
    return (np.hypot(x[:, None], x) < pixels_per_radius).astype(float)


@pytest.mark.parametrize(("radius", "least", "most"), [(1.0, 0.10, 0.30), (8.0, 0.0, 0.012)])
def test_a_patch_of_four_pixels_is_a_square_and_one_of_two_hundred_a_disc(radius, least, most):
    # a resting uniform disc has the mean temperature 8q̇R/3πκ
    flux = disc(radius)
    grid = rs.Grid(flux.shape, (24.0, 24.0))
    field = rs.half_space_temperature(flux, grid, speed=0.0, **UNIT)
    exact = 8 / (3 * pi) * np.sqrt(flux.sum() / pi)
    flash = (field * flux).sum() / flux.sum()
    if radius == 1.0:  # its centres are hotter than its mean by the shape of the grid
        single = rs.half_space_temperature(
            np.where(flux.cumsum().reshape(flux.shape) == 1, flux, 0), grid, speed=0.0, **UNIT
        )
        assert 0.15 < single.max() / (8 / (3 * pi) / np.sqrt(pi)) - 1 < 0.2
        least = 0.0
    assert least <= abs(flash / exact - 1) < most


def test_patches_under_four_pixels_are_counted_apart_and_those_of_four_are_not():
    field = np.zeros((16, 16))
    field[2, 2:5] = 1.0  # three pixels
    field[8:10, 8:10] = 1.0  # four
    spots = hot_spots(field, rs.Grid((16, 16), (1.0, 1.0)), 0.5)
    assert RESOLVED == 4
    assert (spots.count, spots.unresolved) == (2, 1)


# the ladder in the cut-off


def test_rungs_from_four_yield_wavenumbers_extrapolate_and_lower_ones_miss():
    # capped T_flash goes as T + c/q_c only once nearly all of the contact has yielded
    scene = rs.load_scene("steel-0.5GPa")
    q_y, side = prediction.yield_wavenumber(scene), 4 * pi / 6350
    points = [4 * round(f * q_y * side / (2 * pi)) for f in (1, 2, 4, 8, 16)]
    values = []
    for n in points:  # each alone, so that all draw the same surfaces
        numerics = rs.Numerics((rs.Level("capped", (n, n), pi * n / side / 2),), (side, side))
        members = [
            rs.realize(scene, numerics, seed=2, index=i).observables.flash_temperature
            for i in range(3)
        ]
        values.append(np.mean(members, axis=0))
    limits = [2 * fine - coarse for coarse, fine in pairwise(values)]
    from_one, from_two, from_four = (np.abs(limit / limits[-1] - 1) for limit in limits[:-1])
    assert from_one.min() > 0.2
    assert from_two[0] > 0.15  # at the slowest speed, where fine contacts count most
    assert from_four[0] < 0.12
    assert from_four[-1] < 0.05
