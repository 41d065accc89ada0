"""The heat of a contact between two bodies: exact shares, equal temperatures, and how the iteration ends."""

from dataclasses import replace
from math import inf, sqrt

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, gmres

from roughsim import (
    Body,
    ConvergenceError,
    Grid,
    Solid,
    half_space_temperature,
    partition_heat,
    solve_contact,
)
from roughsim.heat import partition
from theory import hertz

ONE = Body(conductivity=1.0, diffusivity=1.0)


def contact_of_hertz(pixels_per_radius):
    count = 2 * pixels_per_radius + 2
    x = (np.arange(count) - (count - 1) / 2) / pixels_per_radius
    grid = Grid((count, count), (count / pixels_per_radius,) * 2)
    return np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0)), grid


def solved(operator, values):
    shape = (values.size, values.size)
    return gmres(
        LinearOperator(shape, matvec=operator, dtype=float), values, rtol=1e-10, restart=200
    )[0]


def rough_contact(count=64, pressure=1.0):
    rng = np.random.default_rng(8)
    x = np.arange(count) / count * 2 * np.pi
    waves = [(i, j) for i in range(-8, 9) for j in range(9) if 0 < i * i + j * j <= 64]
    heights = sum(
        (i * i + j * j) ** -0.9 * np.cos(i * x[:, None] + j * x + rng.uniform(0, 2 * np.pi))
        for i, j in waves
    )
    grid = Grid((count, count), (1.0, 1.0))
    return solve_contact(
        heights, grid, Solid(effective_modulus=1.0), nominal_pressure=pressure
    ).pressure, grid


@pytest.mark.parametrize("speed", [0.0, 3.0, -3.0, 1e3])
@pytest.mark.parametrize("time", [inf, 0.1])
@pytest.mark.parametrize("pointwise", [True, False])
def test_equal_diffusivity_and_speed_share_by_conductivity(speed, time, pointwise):
    # both temperatures have one shape: q₂ = κ₂/(κ₁ + κ₂) q̇ at every pixel
    flux, grid = contact_of_hertz(8)
    resting, moving = Body(2.0, 0.7, speed), Body(6.0, 0.7, speed)
    shared = partition_heat(
        5e7 * flux, grid, moving=moving, resting=resting, time=time, pointwise=pointwise
    )
    np.testing.assert_allclose(shared.heat_flux, 0.75 * 5e7 * flux, rtol=1e-7, atol=1e-7)
    assert shared.moving_share == pytest.approx(0.75, rel=1e-9)
    assert shared.mean_share == pytest.approx(0.75, rel=1e-9)
    assert shared.mismatch == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("diffusivities", [(1.0, 1.0), (0.3, 5.0)])
def test_bodies_at_rest_share_by_conductivity(diffusivities):
    flux, grid = contact_of_hertz(8)
    shared = partition_heat(
        flux, grid, moving=Body(1.0, diffusivities[0]), resting=Body(3.0, diffusivities[1])
    )
    np.testing.assert_allclose(shared.heat_flux, flux / 4, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("pointwise", [True, False])
def test_oblong_pixels_are_as_warm_as_each_body_makes_them(pointwise):
    flux, grid = np.random.default_rng(2).random((6, 5)), Grid((6, 5), (3.0, 10.0))
    moving, resting = Body(3.0, 0.7, 2.0), Body(1.0, 0.4)
    shared = partition_heat(flux, grid, moving=moving, resting=resting, pointwise=pointwise)
    moved = half_space_temperature(
        shared.heat_flux, grid, speed=2.0, conductivity=3.0, diffusivity=0.7
    )
    np.testing.assert_allclose(shared.temperature, moved, rtol=1e-12)
    if pointwise:
        rested = half_space_temperature(
            flux - shared.heat_flux, grid, speed=0.0, conductivity=1.0, diffusivity=0.4
        )
        np.testing.assert_allclose(rested, moved, rtol=1e-6)


def test_two_fast_bodies_share_by_effusivity():
    # each line along sliding then warms as κT = 2q̇√(Dx/πv): q₂ ∝ e√v with e = κ/√D
    flux, grid = contact_of_hertz(16)
    resting, moving = Body(1.0, 2.0, 4e9), Body(3.0, 0.5, 1e9)
    weights = [
        body.conductivity * sqrt(body.speed / body.diffusivity) for body in (resting, moving)
    ]
    shared = partition_heat(flux, grid, moving=moving, resting=resting)
    assert shared.moving_share == pytest.approx(weights[1] / sum(weights), rel=1e-3)
    np.testing.assert_allclose(shared.heat_flux, weights[1] / sum(weights) * flux, atol=1e-2)


@pytest.mark.parametrize("time", [inf, 0.3])
@pytest.mark.parametrize("source", [contact_of_hertz(16), rough_contact()], ids=["hertz", "rough"])
def test_both_bodies_have_one_temperature_all_over_the_contact(source, time):
    flux, grid = source
    moving, resting = Body(2.0, 0.5, 20.0), Body(3.0, 4.0, -7.0)
    shared = partition_heat(flux, grid, moving=moving, resting=resting, time=time)
    surface = [
        half_space_temperature(
            heat,
            grid,
            speed=b.speed,
            conductivity=b.conductivity,
            diffusivity=b.diffusivity,
            time=time,
        )
        for b, heat in ((moving, shared.heat_flux), (resting, flux - shared.heat_flux))
    ]
    contact = flux > 0
    np.testing.assert_allclose(
        surface[0][contact], surface[1][contact], rtol=0, atol=2e-7 * surface[0].max()
    )
    np.testing.assert_allclose(
        shared.temperature, surface[0], rtol=0, atol=1e-12 * surface[0].max()
    )
    assert not shared.heat_flux[~contact].any()
    assert shared.flash_temperature == pytest.approx(
        (surface[0] * flux).sum() / flux.sum(), rel=1e-12
    )
    assert shared.max_temperature == pytest.approx(surface[0][contact].max(), rel=1e-12)
    assert shared.residual <= 1e-8


@pytest.mark.parametrize("peclet", [0.1, 10.0, 1e3])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_one_number_is_the_ratio_of_flash_temperatures(peclet, ratio):
    flux, grid = contact_of_hertz(32)
    moving = Body(ratio, ratio, peclet * ratio)
    shared = partition_heat(flux, grid, moving=moving, resting=ONE, pointwise=False)
    still, swift = hertz.flash_temperature(0.0), hertz.flash_temperature(peclet) / ratio
    exact = still / (still + swift)
    assert shared.moving_share == shared.mean_share == pytest.approx(exact, rel=2e-3)
    assert shared.flash_temperature == pytest.approx(exact * swift, rel=2e-3)
    np.testing.assert_allclose(shared.heat_flux, shared.moving_share * flux, rtol=1e-14)
    assert shared.applications == 0


def test_the_mismatch_is_the_local_jump_of_the_one_number_rule():
    flux, grid = contact_of_hertz(16)
    moving = replace(ONE, speed=300.0)
    shared = partition_heat(flux, grid, moving=moving, resting=ONE, pointwise=False)
    s, contact = shared.moving_share, flux > 0
    still = (1 - s) * half_space_temperature(
        flux, grid, speed=0.0, conductivity=1.0, diffusivity=1.0
    )[contact]
    swift = (
        s
        * half_space_temperature(flux, grid, speed=300.0, conductivity=1.0, diffusivity=1.0)[
            contact
        ]
    )
    assert shared.mismatch == pytest.approx(
        abs(still - swift).max() / max(still.max(), swift.max()), rel=1e-10
    )
    assert 0.4 < shared.mismatch < 0.6  # half of T_max


def test_the_pointwise_temperature_is_lower_and_more_even():
    flux, grid = contact_of_hertz(16)
    settings = {"moving": replace(ONE, speed=10.0), "resting": ONE}
    point, one = (partition_heat(flux, grid, pointwise=p, **settings) for p in (True, False))
    assert point.mean_share == one.moving_share
    assert point.max_temperature < one.max_temperature
    assert abs(point.flash_temperature / one.flash_temperature - 1) < 0.05


def test_exchanging_the_bodies_exchanges_the_shares():
    flux, grid = contact_of_hertz(12)
    first, second = Body(2.0, 0.5, 20.0), Body(3.0, 4.0, -7.0)
    there = partition_heat(flux, grid, moving=first, resting=second)
    back = partition_heat(flux, grid, moving=second, resting=first)
    assert there.moving_share + back.moving_share == pytest.approx(1.0, abs=1e-8)
    np.testing.assert_allclose(there.temperature[flux > 0], back.temperature[flux > 0], rtol=1e-6)


@pytest.mark.parametrize("pixels", [8, 32, pytest.param(128, marks=pytest.mark.slow)])
@pytest.mark.parametrize("peclet", [0.1, 10.0, 1e4])
def test_sixteen_applications_are_enough_however_fine_the_pixels(pixels, peclet):
    flux, grid = contact_of_hertz(pixels)
    for resting in (ONE, Body(10.0, 10.0, -3 * peclet)):
        shared = partition_heat(flux, grid, moving=replace(ONE, speed=peclet), resting=resting)
        assert shared.applications <= 16
        assert shared.residual <= 1e-8


@pytest.mark.parametrize("pressure", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("speed", [1.0, 1e3])
def test_sixteen_applications_are_enough_however_dense_the_contact(pressure, speed):
    flux, grid = rough_contact(64, pressure)
    for resting in (ONE, Body(10.0, 10.0, -3 * speed)):
        shared = partition_heat(flux, grid, moving=replace(ONE, speed=speed), resting=resting)
        assert shared.applications <= 16
        assert shared.residual <= 1e-8


def test_an_isothermal_disc_takes_four_kappa_r_times_its_temperature():
    # a disc held ΔT above a resting half-space passes Q = 4κRΔT (Maxwell); for two in series, (S₁ + S₂) q = ΔT, it is
    # Q = 4RΔT/(1/κ₁ + 1/κ₂). The flux is singular at the edge: first order in the pixel at best
    errors = []
    for pixels in (16, 32, 64):
        inside, grid = contact_of_hertz(pixels)
        disc = inside > 0
        total = sum(
            partition.body_spectrum(body, grid, inf)
            for body in (ONE, replace(ONE, conductivity=3.0))
        )
        flux = solved(
            lambda values, d=disc, t=total: partition.on_contact(values, d, t),
            np.ones(int(disc.sum())),
        )
        power = flux.sum() * grid.spacing[0] ** 2
        errors.append(abs(power / (4 / (1 + 1 / 3)) - 1))
    assert errors[2] < 0.02
    assert errors[0] / errors[2] > 2.5


def test_a_single_pixel_and_a_line_are_contacts_too():
    one = np.zeros((4, 5))
    one[1, 2] = 3.0
    for flux in (one, np.ones((1, 7)), np.ones((1, 1)), np.ones((13, 1))):
        shared = partition_heat(
            flux, Grid(flux.shape, (2.0, 3.0)), moving=replace(ONE, speed=2.0), resting=ONE
        )
        assert 0.5 < shared.moving_share < 1.0


def test_an_iteration_cut_short_is_an_error_with_its_residual(monkeypatch):
    monkeypatch.setattr(partition, "_RESTART", 1)
    flux, grid = contact_of_hertz(8)
    with pytest.raises(ConvergenceError, match="residual = ") as caught:
        partition_heat(flux, grid, moving=replace(ONE, speed=100.0), resting=ONE)
    assert caught.value.residual > 1e-8
    assert caught.value.iterations > 0
