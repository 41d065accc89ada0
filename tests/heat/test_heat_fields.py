"""What a temperature field says of the whole surface: its mean square, its correlation, and how its tracks cool."""

import numpy as np
import pytest
from scipy.special import j0
from some_rows import some

import roughsim as rs
from roughsim import Grid, half_space_temperature, sliding_temperature
from roughsim.heat import (
    joint_distribution,
    rms_temperature,
    temperature_correlation,
    wake_profile,
)
from theory import flash

UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


class Narrow:
    """|σ_q|² = 1 Pa² m² between two wavenumbers."""

    breaks = (30.0, 60.0)

    def __call__(self, q):
        return np.ones_like(q)


def test_the_correlation_of_one_wave_is_a_bessel_function():
    grid = Grid((48, 32), (3.0, 2.0))
    x, y = (np.arange(n) * d for n, d in zip(grid.shape, grid.spacing, strict=True))
    qx, qy = 2 * np.pi / 3.0 * 4, 2 * np.pi / 2.0 * 3
    field = 5.0 + 7.0 * np.cos(qx * x[:, None] + qy * y)
    assert rms_temperature(field) == pytest.approx(7 / np.sqrt(2), rel=1e-13)
    r = np.array([[0.0, 0.1], [0.7, 1.8]])
    expected = 24.5 * j0(np.hypot(qx, qy) * r)
    np.testing.assert_allclose(
        temperature_correlation(field, grid, r), expected, rtol=1e-12, atol=1e-11
    )
    np.testing.assert_allclose(
        temperature_correlation(field.astype(np.float32), grid, r), expected, atol=1e-4
    )


@pytest.mark.parametrize("speed", [0.3, 20.0, 400.0])
def test_the_field_of_a_wave_in_each_direction_has_the_temperature_of_the_theory(speed):
    """The square of the field of one wave, over 64 directions of sliding: (2/π) K(−a²) times that of v → 0."""
    grid, amplitude = Grid((16, 16), (1.0, 1.0)), 2.0
    x = np.arange(16) / 16
    q = 2 * np.pi * 3
    flux = 10 + amplitude * np.cos(q * x)[:, None] + np.zeros(16)
    turns = np.pi * (np.arange(256) + 0.5) / 256
    with pytest.warns(RuntimeWarning) if speed > 7 else _nothing():
        fields = [
            sliding_temperature(
                flux, grid, speed=speed, direction=turn, slid_distance=np.inf, **UNIT
            )
            for turn in turns
        ]
    square = np.mean([rms_temperature(field) ** 2 for field in fields])
    exact = amplitude**2 / 2 / q**2 * 2 / np.pi * float(flash.square_integral(np.array(speed / q)))
    assert square == pytest.approx(exact, rel=1e-9)


def _nothing():
    from contextlib import nullcontext

    return nullcontext()


def test_the_theory_meets_the_fields_of_a_random_flux():
    """A flux with |q̇_q|² = 1 from 30 to 60 rad/m on a cell of 40 waves: sums over its modes err by the cell."""
    length, n, speed = 8.0, 256, 30.0
    grid = Grid((n, n), (length, length))
    rng = np.random.default_rng(5)
    q = grid.wavenumbers
    inside = (q >= 30.0) & (q <= 60.0)
    squares, correlations, r = [], [], np.array([0.0, 0.02, 0.05, 0.1])
    for turn in np.pi * np.arange(12) / 12:
        # a mode stands for (2π/L)² of the plane, and waves run both ways
        phases = np.exp(2j * np.pi * rng.random(grid.half_shape)) * inside
        flux = np.fft.irfft2(phases * 2 * np.pi / length * n**2, grid.shape)
        flux -= flux.min()
        with pytest.warns(RuntimeWarning, match="hot tracks|periodic"):
            field = sliding_temperature(
                flux, grid, speed=speed, direction=turn, slid_distance=np.inf, **UNIT
            )
        squares.append(rms_temperature(field) ** 2)
        correlations.append(temperature_correlation(field, grid, r))
    given = {
        "nominal_pressure": 1.0,
        "friction_coefficient": 1 / speed,
        "stress_spectrum": Narrow(),
        **UNIT,
    }
    exact = flash.rms_temperature(speed, **given)
    assert np.sqrt(np.mean(squares)) == pytest.approx(exact, rel=2e-3)
    curve = flash.temperature_correlation(r, speed, **given)
    np.testing.assert_allclose(np.mean(correlations, axis=0), curve, atol=3e-3 * exact**2)


def test_pressure_and_temperature_share_out_the_contact():
    pressure = np.array([[1.0, 3.0, 0.0], [1.0, 2.0, 0.0]])
    temperature = np.array([[10.0, 30.0, 500.0], [30.0, 20.0, -5.0]])
    joint = joint_distribution(temperature, pressure, bins=2)
    np.testing.assert_allclose(joint.pressure, [1.0, 2.0, 3.0])
    np.testing.assert_allclose(joint.temperature, [10.0, 20.0, 30.0])
    np.testing.assert_allclose(
        joint.share, [[0.25, 0.25], [0.0, 0.5]]
    )  # 2 Pa and 20 K are in the upper bins


def test_the_shares_of_a_resting_hertz_contact_lie_on_its_curve():
    """With p = √(1 − r²) and κT = π(2 − r²)/8 each pressure has one temperature: p = √(8κT/π − 1)."""
    n = 257
    x = (np.arange(n) - n // 2) / (n // 2)
    square = x[:, None] ** 2 + x**2
    pressure = np.sqrt(np.maximum(1 - square, 0.0))
    joint = joint_distribution(np.pi / 8 * (2 - square), pressure, bins=20)
    assert joint.share.sum() == pytest.approx(1.0, rel=1e-12)
    # below the pressure p lies the share p² of the area
    np.testing.assert_allclose(joint.share.sum(axis=1).cumsum(), joint.pressure[1:] ** 2, atol=2e-2)
    i, j = np.nonzero(joint.share)
    low, high = (np.sqrt(8 / np.pi * joint.temperature[k] - 1) for k in (j, j + 1))
    assert (high > joint.pressure[i] - 1e-9).all()
    assert (low < joint.pressure[i + 1] + 1e-9).all()


def hertz(pixels, reach):
    """(flux, grid, x) of √(1 − r²) with so many pixels per radius, on a square of half-side `reach`."""
    half = int(reach * pixels)
    x = (
        np.arange(-half, half) + 0.5
    ) / pixels  # the rows of the contact are exactly as wide as its diameter
    return (
        np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0)),
        Grid((x.size,) * 2, (x.size / pixels,) * 2),
        x,
    )


@pytest.mark.parametrize("speed", some([0.0, 2.0, 30.0], 2))
def test_the_track_of_a_hertz_contact_cools_as_the_integral_over_its_sources(speed):
    """κT = ∫ q̇ exp(−v(R − (x′ − x))/2D)/(2πR) d²x′, over the tracks behind each point of the rim."""
    flux, grid, _ = hertz(48, 3.0)
    field = half_space_temperature(flux, grid, speed=speed, **UNIT)
    distances = np.array([0.1, 0.4, 1.0, 1.8])
    got = wake_profile(field, flux, grid, distances, periodic=False)
    for value, distance in zip(got, distances, strict=True):
        assert value == pytest.approx(hertz_track(speed, distance), rel=1.5e-3)


def hertz_track(speed, distance):
    """Exact mean of κT over the width of the contact, `distance` behind its rim, of the source √(1 − r²)."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    # sources in polar coordinates, r = sin(t): √(1 − r²) r dr = cos² t sin t dt
    t, turn = np.pi / 4 * (1 + nodes), np.pi * (np.arange(400) + 0.5) / 200
    radius, heat = np.sin(t), weights * np.pi / 4 * np.cos(t) ** 2 * np.sin(t) * np.pi / 200
    sx, sy = radius[:, None] * np.cos(turn), radius[:, None] * np.sin(turn)
    mean = 0.0
    for y, w in zip(nodes, weights, strict=True):  # over the width of the contact
        dx, dy = sx + np.sqrt(1 - y**2) + distance, sy - y
        far = np.hypot(dx, dy)
        mean += (
            w / 2 * float(heat @ (np.exp(-speed * (far - dx) / 2) / far).sum(axis=1)) / (2 * np.pi)
        )
    return mean


def test_a_track_behind_a_contact_of_n_rows_errs_by_up_to_one_row_and_by_little_on_the_mean_of_positions():
    """A Hertz contact at v = 20 D/R, its centre moved over a pixel; 2n rows, or one less with a row on the centre."""
    distances = np.array([0.2, 1.0])
    exact = np.array([hertz_track(20.0, distance) for distance in distances])
    centred = []
    for pixels in (8, 16):
        errors = []
        for shift_x in (0.0, 0.5):
            for shift_y in (0.0, 0.25, 0.5, 0.75):
                x = (np.arange(-5 * pixels, 2 * pixels) + shift_x) / pixels
                y = (np.arange(-2 * pixels, 2 * pixels) + shift_y) / pixels
                flux = np.sqrt(np.maximum(1 - x[:, None] ** 2 - y**2, 0.0))
                grid = Grid(flux.shape, (x.size / pixels, y.size / pixels))
                field = half_space_temperature(flux, grid, speed=20.0, **UNIT)
                errors.append(
                    wake_profile(field, flux, grid, distances, periodic=False) / exact - 1
                )
        assert np.abs(errors).max() < 1 / (2 * pixels)
        assert np.abs(np.mean(errors, axis=0)).max() < 0.3 / (2 * pixels)
        centred.append(errors[0])
    assert centred[0] == pytest.approx(2 * centred[1], rel=0.15)  # of the first order in the pixel
    assert centred[1][0] == pytest.approx(0.027, abs=0.001)


def test_the_track_at_rest_falls_as_the_closed_form():
    """κT = [(2 − r²) asin(1/r) + √(r² − 1)]/4 outside a resting Hertz contact."""
    flux, grid, _ = hertz(64, 3.0)
    got = wake_profile(
        half_space_temperature(flux, grid, speed=0.0, **UNIT),
        flux,
        grid,
        [0.5, 1.5],
        periodic=False,
    )
    y = (np.arange(4000) + 0.5) / 4000
    for value, distance in zip(got, (0.5, 1.5), strict=True):
        r = np.hypot(np.sqrt(1 - y**2) + distance, y)
        exact = np.mean((2 - r**2) * np.arcsin(1 / r) + np.sqrt(r**2 - 1)) / 4
        assert value == pytest.approx(exact, rel=4e-3)


def test_tracks_end_at_the_next_contact_and_wrap_around_a_periodic_cell():
    grid = Grid((8, 3), (16.0, 3.0))  # pixels of 2 m along x
    flux = np.zeros(grid.shape)
    flux[[3, 4], 0] = flux[1, 1] = flux[6, 1] = 1.0
    field = np.arange(8.0)[:, None] + np.array([0.0, 100.0, 1000.0])
    # tracks: row 0 from pixel 3 to 2, 1, 0, 7, 6, 5; row 1 from 1 to 0, 7 and from 6 to 5, 4, 3, 2
    got = wake_profile(field, flux, grid, [1.0, 2.0, 3.0, 7.0, 9.0, 11.0, 13.0])
    expected = [
        (2 + 100 + 105) / 3,
        (1.5 + 103.5 + 104.5) / 3,
        (1 + 107 + 104) / 3,
        (7 + 102) / 2,
        6.0,
        5.0,
        np.nan,
    ]
    np.testing.assert_allclose(got, expected)
    free = wake_profile(field, flux, grid, [1.0, 3.0, 5.0, 7.0], periodic=False)
    np.testing.assert_allclose(free, [(2 + 100 + 105) / 3, (1 + 104) / 2, (0 + 103) / 2, 102.0])
    assert wake_profile(field, flux, grid, []).shape == (0,)
    assert np.isnan(wake_profile(field, 0 * flux, grid, [2.0])).all()


def test_a_step_of_time_back_is_a_distance_behind_a_fast_contact():
    """Fast sliding: κT = √(D/πv) ∫ q̇(x′)/√(x′ − x) dx′ along each track, so far tracks cool as 1/√distance."""
    speed, distances = 3e3, np.array([4.0, 8.0])
    pixels = 24
    flux, grid, _ = hertz(pixels, 10.0)
    got = wake_profile(
        half_space_temperature(flux, grid, speed=speed, **UNIT),
        flux,
        grid,
        distances,
        periodic=False,
    )
    y = (np.arange(2000) + 0.5) / 2000
    x, w = np.polynomial.legendre.leggauss(60)
    chord = np.sqrt(1 - y**2)
    strip = [
        np.mean(chord**2 * (np.sqrt(1 - x**2) / np.sqrt(chord[:, None] * (1 + x) + d) @ w))
        / np.sqrt(np.pi * speed)
        for d in distances
    ]
    np.testing.assert_allclose(got, strip, rtol=5e-3)


def test_the_rms_temperature_of_an_elastic_contact_is_that_of_the_theory():
    """Fields that have slid half a cell, in eight directions: they agree within the accuracy of the theory."""
    spectrum = rs.SelfAffineSpectrum.from_rms_height(2e-8, hurst=0.8, q_min=6e3, q_max=5e4)
    grid = Grid((128, 128), (4e-3, 4e-3))
    solid = rs.Solid(effective_modulus=1e9)
    contact = rs.solve_contact(
        rs.synthesize(spectrum, grid, np.random.default_rng(3)),
        grid,
        solid,
        nominal_pressure=3e5,
        tolerance=1e-6,
    )
    steel = {"conductivity": 30.0, "diffusivity": 7.6e-6}
    squares = []
    for turn in np.pi * np.arange(8) / 8:
        field = sliding_temperature(
            0.1 * 0.01 * contact.pressure, grid, speed=0.01, direction=turn, **steel
        )
        squares.append(rms_temperature(field) ** 2)
    load = {"nominal_pressure": 3e5, "effective_modulus": 1e9}
    exact = flash.rms_temperature(0.01, spectrum, friction_coefficient=0.1, **load, **steel)
    assert np.sqrt(np.mean(squares)) == pytest.approx(exact, rel=0.1)
