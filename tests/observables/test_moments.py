"""Moments of a contact, against closed forms, mode sums and products in real space."""

import cmath
import os
import subprocess
import sys
import textwrap
import warnings
from math import inf, nan, pi, sqrt

import numpy as np
import pytest
from moments_cases import ANGULAR, BODY, CELLS, UNIT, Pressed, patches, plane, points
from scipy.special import ellipk, elliprd

from roughsim import Grid, HeatSource, corrected_fractions, fourier, measure, sliding_temperature
from roughsim.observables import moments


@pytest.mark.parametrize(
    "case", [c for c in ANGULAR if c["a"] > 0], ids=lambda case: f"a = {case['a']:g}"
)
@pytest.mark.parametrize("shape", [(32, 32), (33, 7)])
def test_one_wave_of_pressure_has_its_moments_in_closed_form(case, shape):
    grid, load, swing = Grid(shape, (2e-3, 1e-3)), 9e7, 4e7
    x, _ = points(grid)
    q = 3 * 2 * pi / 2e-3
    speed = case["a"] * BODY["diffusivity"] * q
    seen = measure(
        Pressed(load + swing * np.cos(q * x + 0.3)),
        grid,
        HeatSource([speed, -speed], heat_partition=0.5, **BODY),
    )
    heat = 0.5 * 0.11 * speed / 30.0 * swing**2 / 2 / load
    assert seen.nominal_pressure == pytest.approx(load, rel=1e-14)
    np.testing.assert_allclose(seen.flash_temperature, heat / q * 2 / pi * case["A"], rtol=1e-13)
    np.testing.assert_allclose(seen.flash_gradient, heat * 2 / pi * case["B"], rtol=1e-13)
    np.testing.assert_allclose(seen.flash_laplacian, -heat * q * 2 / pi * case["A"], rtol=1e-13)
    np.testing.assert_allclose(seen.flash_width, 1 / q, rtol=1e-13)
    np.testing.assert_allclose(seen.slope_length, -case["A"] / case["B"] / q, rtol=1e-13)
    np.testing.assert_allclose(seen.resting_flash_temperature, heat / q, rtol=1e-13)
    assert (seen.contact_fraction, seen.plastic_fraction) == (0.25, 0.125)


@pytest.mark.parametrize("speed", [0.5, -40.0, 1e6])
@pytest.mark.parametrize("direction", [0.0, 0.8, pi / 2, 3.0])
def test_one_wave_slid_over_in_one_direction(speed, direction):
    grid = Grid((20, 15), (1.0, 2.0))
    x, y = points(grid)
    qx, qy = 4 * pi, -3 * pi
    q = sqrt(qx**2 + qy**2)
    along = (qx * np.cos(direction) + qy * np.sin(direction)) * np.sign(speed)
    if direction == pi / 2:
        along = qy * np.sign(speed)
    response = 1 / cmath.sqrt(q**2 - 1j * abs(speed) * along)
    seen = measure(
        Pressed(2.0 + np.cos(qx * x + qy * y)),
        grid,
        HeatSource([speed], direction=direction, **UNIT),
    )
    heat = abs(speed) * 0.5 / 2.0
    assert seen.flash_temperature[0] == pytest.approx(heat * response.real, rel=1e-12)
    assert seen.flash_gradient[0] == pytest.approx(heat * (1j * along * response).real, rel=1e-12)
    assert seen.flash_laplacian[0] == pytest.approx(-heat * q**2 * response.real, rel=1e-12)
    assert seen.flash_gradient[0] < 0.0


# sums over all modes


@pytest.mark.parametrize("grid", CELLS, ids=lambda grid: f"{grid.shape} {grid.lengths}")
@pytest.mark.parametrize("direction", [0.0, 0.6, pi / 2, -2.0])
@pytest.mark.parametrize("speed", [3.0, -300.0])
def test_moments_of_one_direction_are_products_in_real_space(grid, direction, speed):
    pressure = patches(grid)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"v L/\(2πD\)")
        heat = abs(speed) * 0.4 * pressure
        sense = {"direction": direction, "slid_distance": inf}
        field = sliding_temperature(
            heat, grid, speed=speed, conductivity=3.0, diffusivity=2.0, **sense
        )
    qx, qy, _ = plane(pressure, grid)
    wave = np.fft.fft2(field)
    laplacian = np.fft.ifft2(-(qx**2 + qy**2) * wave).real
    for axis, q in enumerate((qx, qy)):
        if grid.shape[axis] % 2 == 0:
            np.moveaxis(q, axis, 0)[grid.shape[axis] // 2] = 0.0
    slope = np.fft.ifft2(
        1j * (qx * np.cos(direction) + qy * np.sin(direction)) * wave
    ).real * np.sign(speed)
    seen = measure(
        Pressed(pressure),
        grid,
        HeatSource(
            [speed],
            friction_coefficient=0.4,
            conductivity=3.0,
            diffusivity=2.0,
            direction=direction,
        ),
    )
    for actual, product in (
        (seen.flash_temperature, field),
        (seen.flash_gradient, slope),
        (seen.flash_laplacian, laplacian),
    ):
        assert actual[0] == pytest.approx(np.sum(product * pressure) / pressure.sum(), rel=1e-12)


@pytest.mark.parametrize("grid", CELLS, ids=lambda grid: f"{grid.shape} {grid.lengths}")
def test_the_closed_mean_is_the_mean_over_many_directions(grid):
    # periodic in half a turn: the mean of 120 equal steps converges geometrically
    contact, speeds = Pressed(patches(grid)), [1.0, 30.0]
    mean = measure(contact, grid, HeatSource(speeds, **UNIT))
    turns = [
        measure(contact, grid, HeatSource(speeds, direction=pi * k / 120, **UNIT))
        for k in range(120)
    ]
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        average = np.mean([getattr(turn, name) for turn in turns], axis=0)
        np.testing.assert_allclose(getattr(mean, name), average, rtol=1e-12)


@pytest.mark.parametrize(
    "grid",
    [
        Grid((128, 128), (1.0, 1.0)),
        Grid((151, 96), (1e-3, 1e-3)),
        Grid((120, 90), (1.0, 1.4)),
        Grid((8, 90), (1.0, 400.0)),
    ],
    ids=lambda grid: f"{grid.shape} {grid.lengths}",
)
def test_the_compact_spectrum_sums_every_moment_exactly(grid):
    pressure = patches(grid)
    qx, qy, variance = plane(pressure, grid)
    q = np.hypot(qx, qy)
    q[0, 0] = 1.0
    slow = 2 * pi / max(grid.lengths)
    speeds = [slow * ratio for ratio in (1e-3, 0.3, 3.0, 100.0, 1e4, 1e8)]
    seen = measure(Pressed(pressure), grid, HeatSource(speeds, **UNIT))
    # at the Nyquist wavenumber of an axis only the other component of q has a derivative
    kept = np.ones(grid.shape)
    for axis, component in enumerate((qx, qy)):
        if grid.shape[axis] % 2 == 0:
            edge = np.moveaxis(kept, axis, 0)[grid.shape[axis] // 2]
            edge -= np.moveaxis((component / q) ** 2, axis, 0)[grid.shape[axis] // 2]
    for i, speed in enumerate(speeds):
        a = speed / q
        root = (1 + a**2) ** 0.25
        m = a**2 / (2 * root**2 * (1 + root**2))
        even = 2 / pi * ellipk(m) / root
        odd = -2 / pi * root * m * (ellipk(m) - elliprd(0, 1 - m, 1) / 3) * 2 / a
        exact = np.array(
            [
                np.sum(variance * even / q),
                np.sum(variance * kept * odd),
                -np.sum(variance * even * q),
            ]
        )
        exact *= speed / pressure.mean()
        actual = [seen.flash_temperature[i], seen.flash_gradient[i], seen.flash_laplacian[i]]
        np.testing.assert_allclose(actual, exact, rtol=1e-13)
    resting = np.sum(variance / q) * np.abs(speeds) / pressure.mean()
    np.testing.assert_allclose(seen.resting_flash_temperature, resting, rtol=1e-13)


@pytest.mark.parametrize("hardness", [inf, 1.0])
def test_the_corrected_areas_are_those_of_the_pressure_up_to_its_rounding_below_zero(hardness):
    grid = CELLS[0]
    pressure = np.minimum(patches(grid), hardness)
    rounded = np.where(pressure == 0.0, -1e-12, pressure)
    contact = Pressed(rounded, (pressure > 0.0).mean(), (pressure == hardness).mean())
    seen = measure(contact, grid, HeatSource([1.0], **UNIT))
    expected = corrected_fractions(pressure, hardness)
    assert (seen.contact_fraction_corrected, seen.plastic_fraction_corrected) == expected
    assert (expected[1] > 0.0) == (hardness == 1.0)


def test_a_measurement_does_not_depend_on_those_before_it():
    # what depends on cell and speeds alone is remembered: each of these would be wrong with that of another
    fast, slow = HeatSource([3.0, 10.0], **UNIT), HeatSource([0.1, 0.3], **UNIT)
    phi = np.linspace(0.0, 2 * pi, 400, endpoint=False)
    for grid in (
        Grid((16, 16), (1.0, 1.0)),
        Grid((16, 16), (2.0, 2.0)),
        Grid((16, 15), (1.0, 1.0)),
    ):
        pressure = patches(grid)
        qx, qy, variance = plane(pressure, grid)
        q, variance = np.hypot(qx, qy).ravel()[1:], variance.ravel()[1:]
        for sliding in (fast, slow, fast):
            seen = measure(Pressed(pressure), grid, sliding)
            for speed, value in zip(sliding.speeds, seen.flash_temperature, strict=True):
                even = np.mean(((1 - 1j * speed / q[:, None] * np.cos(phi)) ** -0.5).real, axis=1)
                assert value == pytest.approx(
                    speed / pressure.mean() * np.sum(variance / q * even), rel=1e-12
                )


# limits in the speed


def test_at_rest_there_is_no_heat_but_the_ratios_have_their_limits():
    grid = Grid((24, 24), (1.0, 1.0))
    for direction in (None, 0.4):
        rest, slow = (
            measure(Pressed(patches(grid)), grid, HeatSource([v], direction=direction, **UNIT))
            for v in (0.0, 1e-6)
        )
        assert rest.flash_temperature[0] == rest.flash_gradient[0] == rest.flash_laplacian[0] == 0.0
        assert rest.resting_flash_temperature[0] == 0.0
        assert rest.flash_width[0] == pytest.approx(slow.flash_width[0], rel=1e-9)
        assert rest.slope_length[0] == inf


def test_the_slope_length_of_slow_sliding_is_four_diffusivities_over_speed():
    # for every surface; corrections are of the order (v/Dq)²
    grid = Grid((23, 27), (1.0, 1.0))
    speeds = np.array([1e-1, 1e-2, 1e-3])
    seen = measure(Pressed(patches(grid)), grid, HeatSource(speeds, **UNIT))
    errors = np.abs(seen.slope_length * speeds / 4 - 1)
    assert errors[1] < 1e-5
    np.testing.assert_allclose(errors[:-1] / errors[1:], 100.0, rtol=0.01)


def test_the_slope_length_of_fast_sliding_is_never_below_its_bound():
    # d/D ≥ A/|B| → 2.18844, with equality for a single wavelength
    grid = Grid((23, 23), (1.0, 1.0))
    fast = HeatSource([1e12], **UNIT)
    seen = measure(Pressed(patches(grid)), grid, fast)
    assert seen.slope_length[0] > 2.18844 * seen.flash_width[0]
    single = measure(Pressed(1 + np.cos(2 * pi * points(grid)[0])), grid, fast)
    assert single.slope_length[0] / single.flash_width[0] == pytest.approx(2.18844, rel=1e-5)


def test_opposite_speeds_have_the_same_averaged_moments():
    grid = Grid((16, 15), (1.0, 1.0))
    seen = measure(Pressed(patches(grid)), grid, HeatSource([7.0, -7.0], **UNIT))
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian", "slope_length"):
        forth, back = getattr(seen, name)
        assert forth == back
    assert seen.flash_gradient[0] < 0.0


def test_all_speeds_take_one_forward_transform(calls):
    transforms = calls(fourier.Transform, "forward")
    grid = Grid((16, 16), (1.0, 1.0))
    measure(Pressed(patches(grid)), grid, HeatSource([0.1, 1.0, 10.0], direction=0.3, **UNIT))
    assert len(transforms) == 1


# nothing to measure, and what is refused


def test_uniform_pressure_makes_no_flash_temperature():
    for shape, length in (((15, 11), 1.0), ((1, 1), 1.0), ((1, 1), 0.7), ((1, 1), 3e-3)):
        grid = Grid(shape, (length, length))
        for direction in (None, 1.0):
            seen = measure(
                Pressed(np.full(shape, 0.1)), grid, HeatSource([35.0], direction=direction, **UNIT)
            )
            assert (
                seen.flash_temperature[0]
                == seen.flash_laplacian[0]
                == seen.pressure_variance
                == 0.0
            )
            assert np.isnan(
                [
                    seen.flash_width[0],
                    seen.slope_length[0],
                    seen.stress_spectrum.correlation_radius(0.1),
                ]
            ).all()


def test_a_wave_without_a_derivative_on_the_grid_has_no_slope_length():
    grid = Grid((2, 2), (1.0, 1.0))
    seen = measure(Pressed(np.array([[0.3, 0.9], [0.1, 0.2]])), grid, HeatSource([1.0], **UNIT))
    assert seen.flash_gradient[0] == 0.0
    assert seen.slope_length[0] == inf


def test_an_empty_contact_has_no_temperature_and_says_so():
    grid = Grid((8, 8), (1.0, 1.0))
    with pytest.warns(RuntimeWarning, match="pressure = 0 Pa everywhere: without contact"):
        seen = measure(Pressed(np.zeros((8, 8)), 0.0, 0.0), grid, HeatSource([0.0, 1.0], **UNIT))
    for name in ("temperature", "gradient", "laplacian", "width"):
        assert np.isnan(getattr(seen, f"flash_{name}")).all()
    assert np.isnan(seen.slope_length).all()
    assert np.isnan(seen.resting_flash_temperature).all()


def test_sums_in_pieces_are_those_in_one(monkeypatch):
    grid, sliding = CELLS[1], HeatSource([0.5, 2.0], **UNIT)
    whole = measure(Pressed(patches(grid)), grid, sliding)
    monkeypatch.setattr(moments, "_SHORT", 5)
    pieces = measure(Pressed(patches(grid)), grid, sliding)
    assert whole.stress_spectrum.variance.size % 5
    for name in ("temperature", "gradient", "laplacian"):
        np.testing.assert_allclose(
            getattr(pieces, f"flash_{name}"), getattr(whole, f"flash_{name}"), rtol=1e-13
        )


@pytest.mark.slow
def test_the_bits_of_moments_do_not_depend_on_the_threads_of_the_blas():
    code = """
        import numpy as np, roughsim as rs
        from moments_cases import Pressed, UNIT, patches
        grid = rs.Grid((8, 30000), (1.0, 1.1))
        seen = rs.measure(Pressed(patches(grid)), grid, rs.HeatSource([1.0, 9.0], **UNIT))
        print(seen.stress_spectrum.variance.size, seen.flash_temperature.tobytes(), seen.flash_gradient.tobytes())
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    said = [
        subprocess.run(
            [sys.executable, "-c", textwrap.dedent(code)],
            env=environment | {"OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in "12"
    ]
    assert int(said[0].split()[0]) > 20000
    assert said[0] == said[1]


@pytest.mark.parametrize(
    ("pressure", "message"),
    [
        (np.full((8, 8), nan), "pressure holds 64 values"),
        (np.diag([inf, *[1.0] * 7]), "pressure holds 1 values"),
        (np.diag([-inf, *[1.0] * 7]), "pressure holds 1 values"),
        (np.diag([nan, *[1.0] * 7]), "pressure holds 1 values"),
        (np.ones((8, 9)), r"pressure has shape \(8, 9\)"),
        (-np.eye(8), "compression is positive"),
        (np.eye(8) - np.eye(8)[::-1], "compression is positive"),
    ],
)
def test_a_field_that_is_no_pressure_is_refused(pressure, message):
    with pytest.raises(ValueError, match=message):
        measure(Pressed(pressure), Grid((8, 8), (1.0, 1.0)), HeatSource([1.0], **UNIT))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("speeds", [1.0, nan]),
        ("speeds", [inf]),
        ("friction_coefficient", -0.1),
        ("conductivity", 0.0),
        ("diffusivity", -1.0),
        ("heat_partition", 1.1),
        ("heat_partition", -0.1),
        ("direction", nan),
    ],
)
def test_sliding_that_is_not_physical_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        HeatSource(**{"speeds": [1.0], **UNIT, name: value})


@pytest.mark.parametrize("speeds", [35.0, "35", [], ["35"], [[35.0]]])
def test_speeds_are_a_sequence_of_numbers(speeds):
    with pytest.raises(TypeError, match="speeds"):
        HeatSource(speeds, **UNIT)


def test_sliding_keeps_its_speeds_as_a_tuple():
    sliding = HeatSource(np.array([1.0, 35.0]), **UNIT)
    assert sliding.speeds == (1.0, 35.0)
    assert hash(sliding) == hash(HeatSource((1.0, 35.0), **UNIT))
