"""Heat of a moving source on the periodic cell, against closed forms and the heat kernel summed in time."""

import cmath
from math import pi, sqrt

import mpmath as mp
import numpy as np
import pytest
from heat_cases import REFERENCE, STEEL, UNIT, close, points, steady
from scipy import special

from roughsim import Grid, sliding_temperature
from roughsim.heat.periodic import MovingSource, responses


@pytest.mark.parametrize(
    "case", REFERENCE["modes"], ids=lambda case: f"drift {case['drift']:g} depth {case['depth']}"
)
def test_a_plane_wave_of_heat_diffuses_as_the_heat_kernel_says(case):
    qx, qy = abs(case["qx"]), sqrt(case["q"] ** 2 - case["qx"] ** 2)
    grid = Grid((9, 8), (2 * pi / qx, 2 * pi / (qy or 1.0)))
    x, y = points(grid)
    phase = qx * x + qy * y
    conductivity, diffusivity, flux = 3.0, 0.25, 7.0
    speed = case["drift"] * diffusivity * np.sign(case["qx"])
    body = {
        "conductivity": conductivity,
        "diffusivity": diffusivity,
        "depth": case["depth"],
        "speed": speed,
    }
    if case["spread"] is None:
        actual = steady(flux * np.cos(phase), grid, **body)
    else:
        actual = sliding_temperature(
            flux * np.cos(phase), grid, time=case["spread"] / diffusivity, **body
        )
    # a source along −x sees the wave of reference mirrored: its response at +q_x is the one at −q_x with +v
    response = complex(case["real"], case["imaginary"])
    close(actual, flux / conductivity * (response * np.exp(1j * phase)).real, 1e-13)


@pytest.mark.parametrize("speed", [0.0, 1e-3, 1.0, -1.0, 1e3, -1e6, 1e12])
@pytest.mark.parametrize("shape", [(64, 1), (63, 5), (48, 32)])
def test_a_steady_cosine_source_is_exact_at_any_peclet_number(speed, shape):
    grid = Grid(shape, (2.0, 0.7))
    x, _ = points(grid)
    q = 3 * pi
    decay = cmath.sqrt(q * q - 1j * q * speed / 7.6e-6)
    expected = (np.exp(1j * q * x) / (30.0 * decay)).real
    close(steady(np.cos(q * x), grid, speed=speed, **STEEL), expected, 1e-13)


@pytest.mark.parametrize("speed", [1e-3, -1.0, 1e3, 1e6, 1e12])
@pytest.mark.parametrize("direction", [0.0, 0.3])
def test_a_source_slides_half_the_cell_from_rest_by_default(speed, direction):
    grid = Grid((32, 24), (2.0, 3.0))
    x, y = points(grid)
    qx, qy = 5 * pi, 2 * pi / 3
    chord = 2.0 / np.cos(direction)  # through the centre, it leaves by the sides x = 0 and x = 2
    mp.mp.dps = 40
    along = mp.mpf(qx) * float(np.cos(direction)) + mp.mpf(qy) * float(np.sin(direction))
    decay = mp.sqrt(mp.mpf(qx) ** 2 + mp.mpf(qy) ** 2 - 1j * along * mp.mpf(speed))
    response = complex(mp.erf(decay * mp.sqrt(mp.mpf(chord) / 2 / abs(mp.mpf(speed)))) / decay)
    expected = (response * np.exp(1j * (qx * x + qy * y))).real
    actual = sliding_temperature(
        np.cos(qx * x + qy * y), grid, speed=speed, direction=direction, **UNIT
    )
    close(actual, expected, 1e-13)


def test_a_resting_cosine_source_is_one_over_conductivity_and_wavenumber():
    grid = Grid((16, 12), (1.0, 2.0))
    _, y = points(grid)
    flux = np.cos(2 * pi * y)
    close(sliding_temperature(flux, grid, speed=0.0, **STEEL), flux / (30.0 * 2 * pi), 1e-14)


def test_heat_that_varies_only_across_the_track_does_not_see_the_speed():
    grid = Grid((16, 32), (1.0, 1.0))
    flux = np.broadcast_to(np.random.default_rng(1).random(32), grid.shape)
    close(
        steady(flux, grid, speed=1e9, **UNIT),
        sliding_temperature(flux, grid, speed=0.0, **UNIT),
        1e-14,
    )


@pytest.mark.parametrize("shape", [(16, 16), (15, 17), (1, 1)])
def test_a_uniform_source_leaves_exactly_no_field(shape):
    flux = np.full(shape, 0.1)
    for field in (
        steady(flux, Grid(shape, (1.0, 1.0)), speed=35.0, **STEEL),
        sliding_temperature(
            flux, Grid(shape, (1.0, 1.0)), speed=35.0, direction=1.0, depth=0.1, **STEEL
        ),
    ):
        assert (field == 0.0).all()


# waves at the Nyquist wavenumber run both ways


def test_a_nyquist_wave_along_the_track_keeps_the_real_part_of_its_response():
    grid = Grid((8, 6), (1.0, 1.0))
    flux = np.broadcast_to((-1.0) ** np.arange(8)[:, None], grid.shape)
    expected = flux * (1 / cmath.sqrt((8 * pi) ** 2 - 1j * 8 * pi * 50.0)).real
    close(steady(flux, grid, speed=50.0, **UNIT), expected, 1e-14)


def test_a_nyquist_wave_across_the_track_is_carried_along():
    grid = Grid((8, 12), (1.0, 1.0))
    _, y = points(grid)
    alternating = (-1.0) ** np.arange(8)[:, None]
    decay = cmath.sqrt((8 * pi) ** 2 + (2 * pi) ** 2 - 1j * 2 * pi * 50.0)
    expected = alternating * (np.exp(2j * pi * y) / decay).real
    close(
        steady(alternating * np.cos(2 * pi * y), grid, speed=50.0, direction=pi / 2, **UNIT),
        expected,
        1e-14,
    )


@pytest.mark.parametrize("axis", [0, 1])
def test_a_nyquist_wave_oblique_to_the_track_is_the_mean_of_its_two_senses(axis):
    grid = Grid((8, 6), (1.0, 1.0))
    alternating = (-1.0) ** np.expand_dims(np.arange(grid.shape[axis]), 1 - axis)
    along, across = grid.shape[axis] * pi, 2 * pi
    drift = (50 * np.cos(0.7), 50 * np.sin(0.7))
    flow = [1j * (sense * along * drift[axis] + across * drift[1 - axis]) for sense in (1, -1)]
    response = sum(1 / cmath.sqrt(along**2 + across**2 - term) for term in flow) / 2
    phase = across * points(grid)[1 - axis]
    expected = alternating * (response * np.exp(1j * phase)).real
    close(
        steady(alternating * np.cos(phase), grid, speed=50.0, direction=0.7, **UNIT),
        expected,
        1e-14,
    )


def test_the_shortest_wave_of_both_axes_is_the_mean_of_its_four_senses():
    grid = Grid((8, 6), (1.0, 1.0))
    flux = (-1.0) ** np.add.outer(np.arange(8), np.arange(6))
    qx, qy, vx, vy = 8 * pi, 6 * pi, 50 * np.cos(0.7), 50 * np.sin(0.7)
    terms = [1 / cmath.sqrt(qx**2 + qy**2 - 1j * (sx * qx * vx + qy * vy)) for sx in (1, -1)]
    close(steady(flux, grid, speed=50.0, direction=0.7, **UNIT), flux * sum(terms).real / 2, 1e-14)


@pytest.mark.parametrize("shape", [(8, 6), (7, 6), (8, 5)])
def test_the_response_of_every_wave_is_that_of_a_real_field(shape):
    grid = Grid(shape, (1.0, 1.4))
    whole = np.empty(grid.half_shape, complex)
    for rows, response in responses(grid, MovingSource((30.0, -20.0))):
        whole[rows] = response
    edges = [0, -1] if shape[1] % 2 == 0 else [0]
    opposite = whole[-np.arange(shape[0]) % shape[0]][:, edges]
    np.testing.assert_allclose(opposite, whole[:, edges].conj(), rtol=1e-14, atol=1e-17)


@pytest.mark.parametrize("shape", [(13, 17), (1, 19), (23, 1)])
def test_prime_and_single_rows_of_oblong_cells_are_those_of_a_plain_transform(shape):
    grid = Grid(shape, (1.0, 2.7))
    flux, time = np.random.default_rng(14).random(shape), 0.004
    qx, qy = (2 * pi * np.fft.fftfreq(n, d) for n, d in zip(shape, grid.spacing, strict=True))
    qx, qy = np.meshgrid(qx, qy, indexing="ij")
    decay = np.sqrt(qx**2 + qy**2 - 1j * 40.0 * (qx * np.cos(0.9) + qy * np.sin(0.9)))
    decay[0, 0] = 1.0
    response = special.erf(decay * np.sqrt(time)) / decay
    response[0, 0] = 0.0
    expected = np.fft.ifft2(np.fft.fft2(flux) * response).real
    close(
        sliding_temperature(flux, grid, speed=40.0, direction=0.9, time=time, **UNIT),
        expected,
        1e-13,
    )
