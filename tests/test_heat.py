"""Heat of a moving source on the periodic cell, against closed forms and the heat kernel summed in time."""

import cmath
import json
import re
import warnings
from math import inf, nan, pi, sqrt
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from scipy import special

from roughsim import Grid, convolution, half_space_temperature, sliding_temperature
from roughsim.heat import responses, uniform_temperature

REFERENCE = json.loads((Path(__file__).parent / "reference" / "heat.json").read_text())
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}


def points(grid):
    return np.meshgrid(*(np.arange(n) * d for n, d in zip(grid.shape, grid.spacing, strict=True)), indexing="ij")


def steady(*args, **kwargs):
    """The paper's kernel; that it warns has a test of its own."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"v L/\(2πD\)")
        return sliding_temperature(*args, slid_distance=inf, **kwargs)


def close(actual, expected, tolerance):
    scale = np.abs(expected).max()
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


# exact cases


@pytest.mark.parametrize("case", REFERENCE["modes"], ids=lambda case: f"drift {case['drift']:g} depth {case['depth']}")
def test_a_plane_wave_of_heat_diffuses_as_the_heat_kernel_says(case):
    qx, qy = abs(case["qx"]), sqrt(case["q"] ** 2 - case["qx"] ** 2)
    grid = Grid((9, 8), (2 * pi / qx, 2 * pi / (qy or 1.0)))
    x, y = points(grid)
    phase = qx * x + qy * y
    conductivity, diffusivity, flux = 3.0, 0.25, 7.0
    speed = case["drift"] * diffusivity * np.sign(case["qx"])
    body = {"conductivity": conductivity, "diffusivity": diffusivity, "depth": case["depth"], "speed": speed}
    if case["spread"] is None:
        actual = steady(flux * np.cos(phase), grid, **body)
    else:
        actual = sliding_temperature(flux * np.cos(phase), grid, time=case["spread"] / diffusivity, **body)
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
    actual = sliding_temperature(np.cos(qx * x + qy * y), grid, speed=speed, direction=direction, **UNIT)
    close(actual, expected, 1e-13)


def test_a_resting_cosine_source_is_one_over_conductivity_and_wavenumber():
    grid = Grid((16, 12), (1.0, 2.0))
    _, y = points(grid)
    flux = np.cos(2 * pi * y)
    close(sliding_temperature(flux, grid, speed=0.0, **STEEL), flux / (30.0 * 2 * pi), 1e-14)


def test_heat_that_varies_only_across_the_track_does_not_see_the_speed():
    grid = Grid((16, 32), (1.0, 1.0))
    flux = np.broadcast_to(np.random.default_rng(1).random(32), grid.shape)
    close(steady(flux, grid, speed=1e9, **UNIT), sliding_temperature(flux, grid, speed=0.0, **UNIT), 1e-14)


@pytest.mark.parametrize("shape", [(16, 16), (15, 17), (1, 1)])
def test_a_uniform_source_leaves_exactly_no_field(shape):
    flux = np.full(shape, 0.1)
    for field in (
        steady(flux, Grid(shape, (1.0, 1.0)), speed=35.0, **STEEL),
        sliding_temperature(flux, Grid(shape, (1.0, 1.0)), speed=35.0, direction=1.0, depth=0.1, **STEEL),
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
    close(steady(alternating * np.cos(2 * pi * y), grid, speed=50.0, direction=pi / 2, **UNIT), expected, 1e-14)


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
    close(steady(alternating * np.cos(phase), grid, speed=50.0, direction=0.7, **UNIT), expected, 1e-14)


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
    for rows, response in responses(grid, (30.0, -20.0)):
        whole[rows] = response
    edges = [0, -1] if shape[1] % 2 == 0 else [0]
    opposite = whole[-np.arange(shape[0]) % shape[0]][:, edges]
    np.testing.assert_allclose(opposite, whole[:, edges].conj(), rtol=1e-14, atol=1e-17)


# symmetries


def mirrored(field):
    return np.roll(field[::-1], 1, axis=0)


@pytest.mark.parametrize("shape", [(16, 16), (15, 18)])
@pytest.mark.parametrize("direction", [0.0, pi])
def test_the_mirror_image_of_the_source_slides_the_other_way(shape, direction):
    grid = Grid(shape, (1.0, 1.3))
    flux = np.random.default_rng(2).random(shape)
    forth = sliding_temperature(flux, grid, speed=20.0, direction=direction, **UNIT)
    back = sliding_temperature(mirrored(flux), grid, speed=-20.0, direction=direction, **UNIT)
    close(back, mirrored(forth), 1e-13)


@pytest.mark.parametrize("speed", [20.0, 1e12])
def test_turning_everything_by_a_right_angle_turns_the_field(speed):
    flux = np.random.default_rng(3).random((14, 9))
    along = steady(flux, Grid((14, 9), (1.0, 1.3)), speed=speed, **UNIT)
    across = steady(flux.T, Grid((9, 14), (1.3, 1.0)), speed=speed, direction=pi / 2, **UNIT)
    close(across.T, along, 1e-13)
    backwards = steady(flux.T, Grid((9, 14), (1.3, 1.0)), speed=-speed, direction=-pi / 2, **UNIT)
    close(backwards.T, along, 1e-13)


@pytest.mark.parametrize("direction", [0.0, 0.4, pi / 2, 2.5])
def test_a_negative_speed_is_the_opposite_direction(direction):
    grid = Grid((80, 70), (1.0, 1.3))
    flux = np.random.default_rng(4).random(grid.shape)
    forth = sliding_temperature(flux, grid, speed=-30.0, direction=direction, **UNIT)
    close(forth, sliding_temperature(flux, grid, speed=30.0, direction=direction + pi, **UNIT), 1e-13)


@pytest.mark.parametrize("direction", [0.0, pi / 2, 2.0])
def test_each_row_of_a_large_grid_has_its_own_response(direction):
    # more rows than one block: against a plain transform of the whole plane, Nyquist waves filtered out
    grid = Grid((150, 141), (1.0, 1.3))
    flux = np.random.default_rng(5).random(grid.shape)
    qx, qy = (2 * pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True))
    qx, qy = np.meshgrid(qx, qy, indexing="ij")
    source = np.fft.fft2(flux)
    source[75] = 0.0
    decay = np.sqrt(qx**2 + qy**2 - 1j * 40.0 * (qx * np.cos(direction) + qy * np.sin(direction)))
    decay[0, 0] = inf
    expected = np.fft.ifft2(source / decay).real
    actual = steady(np.fft.ifft2(source).real, grid, speed=40.0, direction=direction, **UNIT)
    close(actual, expected, 1e-13)


def test_steel_in_si_units_is_the_unit_problem_scaled():
    flux = np.random.default_rng(6).random((24, 24))
    unit = sliding_temperature(flux, Grid((24, 24), (1.0, 1.0)), speed=35.0 * 1e-6 / 7.6e-6, **UNIT)
    steel = sliding_temperature(2e9 * flux, Grid((24, 24), (1e-6, 1e-6)), speed=35.0, **STEEL)
    close(steel, unit * 2e9 * 1e-6 / 30.0, 1e-13)


@pytest.mark.parametrize("speed", [50.0, 500.0])
def test_the_hot_spot_trails_the_source(speed):
    grid = Grid((128, 64), (1.0, 0.5))
    x, y = points(grid)
    flux = np.exp(-((x - 0.5) ** 2 + (y - 0.25) ** 2) / 0.05**2)
    field = sliding_temperature(flux, grid, speed=speed, **UNIT)
    hottest = x[np.unravel_index(field.argmax(), field.shape)]
    assert hottest < 0.5
    assert np.sum(np.gradient(field, axis=0) * flux) < 0.0


# time and depth


def test_a_source_heats_as_the_square_root_of_time_at_first():
    # T/(2 q̇ √(Dt/π)/κ) = 1 − λ²Dt/3 + …: the error falls as t
    grid = Grid((8, 1), (1.0, 1.0))
    x, _ = points(grid)
    flux = np.cos(2 * pi * x)
    times = np.array([1e-5, 1e-6, 1e-7])
    fields = sliding_temperature(flux, grid, speed=0.0, time=times, **UNIT)
    errors = 1 - fields[:, 0, 0] / (2 * np.sqrt(times / pi))
    assert np.polyfit(np.log(times), np.log(errors), 1)[0] == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(errors, (2 * pi) ** 2 * times / 3, rtol=1e-3)


def test_a_series_of_times_is_the_same_as_one_by_one():
    grid = Grid((12, 10), (1.0, 1.0))
    flux = np.random.default_rng(7).random(grid.shape)
    times = [0.0, 1e-4, 0.3, inf]
    with pytest.warns(RuntimeWarning, match="exceeds 1"):
        series = sliding_temperature(flux, grid, speed=9.0, time=times, **UNIT)
    assert series.shape == (4, 12, 10)
    assert (series[0] == 0.0).all()
    for time, field in zip(times[1:3], series[1:3], strict=True):
        np.testing.assert_array_equal(field, sliding_temperature(flux, grid, speed=9.0, time=time, **UNIT))
    np.testing.assert_array_equal(series[3], steady(flux, grid, speed=9.0, **UNIT))


def test_sliding_distance_is_speed_times_time():
    grid = Grid((12, 10), (1.0, 1.0))
    flux = np.random.default_rng(8).random(grid.shape)
    slid = sliding_temperature(flux, grid, speed=-4.0, slid_distance=0.2, **UNIT)
    close(slid, sliding_temperature(flux, grid, speed=-4.0, time=0.05, **UNIT), 1e-14)
    for speed in (0.0, 4.0):
        assert (sliding_temperature(flux, grid, speed=speed, slid_distance=0.0, **UNIT) == 0.0).all()
    assert (sliding_temperature(flux, grid, speed=4.0, time=0.0, depth=0.1, **UNIT) == 0.0).all()


def test_a_mode_forgets_its_start():
    # just beyond D q² t = 40 the steady response takes over, 4e-18 from the transient one
    grid = Grid((4, 1), (2 * pi, 1.0))
    flux = np.cos(points(grid)[0])
    for depth in (0.0, 0.5):
        field = sliding_temperature(flux, grid, speed=0.0, time=[39.9, 40.1], depth=depth, **UNIT)
        np.testing.assert_allclose(field[0], field[1], rtol=0, atol=1e-15)


def test_heat_enters_with_the_prescribed_flux():
    # −κ ∂T/∂z = q̇ at the surface, from rest as well as steady; one-sided difference of second order
    grid = Grid((9, 1), (1.0, 1.0))
    flux = np.cos(2 * pi * points(grid)[0])
    for time in (1e-4, 0.02, 10.0):
        layers = [sliding_temperature(flux, grid, speed=0.3, time=time, depth=d, **STEEL) for d in (0.0, 1e-6, 2e-6)]
        slope = (-3 * layers[0] + 4 * layers[1] - layers[2]) / 2e-6
        close(-30.0 * slope, flux, 1e-4)


def test_a_transient_at_great_depth_does_not_overflow():
    grid = Grid((64, 64), (1.0, 1.0))
    flux = np.random.default_rng(9).random(grid.shape)
    for depth in (1.0, 100.0, 1e6):
        assert np.abs(sliding_temperature(flux, grid, speed=100.0, depth=depth, **UNIT)).max() < 1e-3


@pytest.mark.parametrize("depth", [0.0, 0.02, 0.2])
def test_the_uniform_term_is_diffusion_into_a_half_space(depth):
    mp.mp.dps = 30
    expected = mp.quad(
        lambda u: 2 / mp.sqrt(mp.pi) * mp.exp(-(mp.mpf(depth) ** 2) / (4 * u**2)), [0, 0.01, sqrt(0.003)]
    )
    actual = uniform_temperature(5.0, 0.006, conductivity=2.0, diffusivity=0.5, depth=depth)
    assert actual == pytest.approx(2.5 * float(expected), rel=1e-13)


def test_the_uniform_term_starts_at_zero_and_keeps_the_shape_of_time():
    for depth in (0.0, 1.0):
        assert uniform_temperature(5.0, 0.0, depth=depth, **UNIT) == 0.0
    rise = uniform_temperature(1.0, np.array([0.0, 1.0, 4.0]), **UNIT)
    np.testing.assert_allclose(rise, [0.0, 2 / sqrt(pi), 4 / sqrt(pi)], rtol=1e-15)


@pytest.mark.parametrize("case", REFERENCE["hertz_from_rest"], ids=lambda case: f"Pe {case['peclet']}")
def test_a_hertz_contact_from_rest_meets_free_space(case):
    # in a cell that neither heat nor track has crossed, fields plus uniform term are those of free space; the pixel
    # error of the steep edge falls faster than its width
    errors = []
    for pixels in (4, 8, 16):
        grid = Grid((10 * pixels, 8 * pixels), (10.0, 8.0))
        x, y = points(grid)
        flux = np.sqrt(np.maximum(1 - (x - 5.03) ** 2 - (y - 4.01) ** 2, 0.0))
        when = {"speed": float(case["peclet"]), "time": case["fourier_number"]}
        field = sliding_temperature(flux, grid, **when, **UNIT)
        field = field + uniform_temperature(flux.mean(), when["time"], **UNIT)
        errors.append(abs(np.sum(field * flux) / flux.sum() / case["flash_temperature"] - 1))
    assert errors[2] < 2e-3
    assert errors[2] < errors[0] / 4


# numbers in, numbers out


@pytest.mark.parametrize("options", [{}, {"time": [0.001, 0.1]}, {"depth": 0.01}])
def test_single_precision_stays_single(options):
    grid = Grid((32, 30), (1.0, 1.0))
    flux = np.random.default_rng(10).random(grid.shape)
    single = sliding_temperature(flux.astype(np.float32), grid, speed=30.0, **options, **UNIT)
    assert single.dtype == np.float32
    close(single, sliding_temperature(flux, grid, speed=30.0, **options, **UNIT), 2e-6)


@pytest.mark.parametrize("temperature", [sliding_temperature, half_space_temperature])
def test_a_series_of_times_takes_one_forward_transform_and_one_inverse_each(monkeypatch, temperature):
    calls = []
    for name in ("_rows_forward", "_columns_forward", "_rows_backward"):
        original = getattr(convolution, name)
        monkeypatch.setattr(convolution, name, lambda *given, n=name, f=original: calls.append(n) or f(*given))
    grid, times = Grid((8, 8), (1.0, 1.0)), [0.1, 0.2, 0.0, 0.3]
    fields = temperature(np.eye(8), grid, speed=1.0, time=times, **UNIT)
    assert calls == ["_rows_forward", "_columns_forward", *["_rows_backward"] * 3]
    monkeypatch.undo()
    for time, field in zip(times, fields, strict=True):
        np.testing.assert_array_equal(field, temperature(np.eye(8), grid, speed=1.0, time=time, **UNIT))


def test_the_flux_is_left_alone():
    flux = np.random.default_rng(11).random((8, 8))
    kept = flux.copy()
    flux.flags.writeable = False
    sliding_temperature(flux, Grid((8, 8), (1.0, 1.0)), speed=1.0, **UNIT)
    np.testing.assert_array_equal(flux, kept)


def test_the_steady_kernel_warns_when_hot_tracks_close():
    grid = Grid((8, 8), (1.0, 1.0))
    with pytest.warns(RuntimeWarning, match=r"v L/\(2πD\) = 1.1 exceeds 1.* %; use a finite slid_distance"):
        sliding_temperature(np.eye(8), grid, speed=2.2 * pi, slid_distance=inf, **UNIT)
    sliding_temperature(np.eye(8), grid, speed=1.8 * pi, slid_distance=inf, **UNIT)


def rough_source(points):
    """Isotropic rough heat from waves as long as the cell on: |q̇(q)|² level to 4π/L, then ~ q^−3.6; phases random."""
    grid = Grid((points, points), (1.0, 1.0))
    q = grid.wavenumbers
    amplitude = np.where((q > 0) & (q < pi * points / 2), np.maximum(q / (4 * pi), 1.0) ** -1.8, 0.0)
    noise = np.fft.rfft2(np.random.default_rng(12).standard_normal(grid.shape))
    noise[np.abs(noise) > 0] /= np.abs(noise[np.abs(noise) > 0])
    return np.fft.irfft2(amplitude * noise, s=grid.shape), grid


def isotropic_flash_temperature(flux, speed):
    """Σ|q̇|² (2/π)A(v/Dq)/q over the modes: the mean over all directions of sliding on an endless surface."""
    power = np.abs(np.fft.fft2(flux) / flux.size) ** 2
    q = 2 * pi * np.hypot(*np.meshgrid(*[np.fft.fftfreq(n) * n for n in flux.shape], indexing="ij"))
    a = speed / np.where(q > 0, q, 1.0)
    response = 2 / pi * (1 + a**2) ** -0.25 * special.ellipk((1 - (1 + a**2) ** -0.5) / 2)
    return np.sum(power[q > 0] * response[q > 0] / q[q > 0])


@pytest.mark.parametrize(("laps", "at_least"), [(10.0, 0.05), (100.0, 0.6), (1000.0, 2.5)])
def test_the_warning_of_hot_tracks_names_the_size_of_the_error(laps, at_least):
    flux, grid = rough_source(64)
    speed = 2 * pi * laps
    exact = isotropic_flash_temperature(flux, speed)
    with pytest.warns(RuntimeWarning, match="hot track") as caught:
        field = sliding_temperature(flux, grid, speed=speed, slid_distance=inf, **UNIT)
    named = float(re.search(r"by ([0-9.e+-]+) %", str(caught[0].message)).group(1)) / 100
    rest = np.mean(flux * sliding_temperature(flux, grid, speed=speed, **UNIT))
    assert named == pytest.approx(np.mean(flux * field) / rest - 1, rel=6e-3)  # three digits
    assert named > at_least
    assert rest == pytest.approx(exact, rel=0.03)  # four waves of the length of the cell are no isotropic roughness
    assert 1 + named == pytest.approx(np.mean(flux * field) / exact, rel=0.03)


def test_the_size_of_the_error_counts_every_mode_that_remembers_its_start():
    # against whole fields, on an oblong grid with odd and even sides, slid obliquely, at depth
    grid = Grid((45, 16), (3.0, 1.0))
    flux = np.random.default_rng(13).random(grid.shape)
    heat = {"speed": 3.0 * 7.6e-6, "direction": 0.3, "depth": 0.01} | STEEL
    with pytest.warns(RuntimeWarning, match="hot track") as caught:
        field = sliding_temperature(flux, grid, slid_distance=inf, **heat)
    named = float(re.search(r"by ([0-9.e+-]+) %", str(caught[0].message)).group(1)) / 100
    excess = np.mean(flux * field) / np.mean(flux * sliding_temperature(flux, grid, **heat)) - 1
    assert named == pytest.approx(excess, rel=6e-3)


@pytest.mark.parametrize("peclet", [100.0, 1e3, 1e5])
def test_a_sharp_edge_undershoots_by_a_bounded_share_that_falls_with_the_pixel(peclet):
    # a finite number of waves cannot end at an edge: ahead of a fast square the field is slightly negative
    shares = []
    for points in (64, 256):
        grid = Grid((points, points), (8.0, 8.0))
        x = abs((np.arange(points) - (points - 1) / 2) * 8 / points) < 1
        flux = np.outer(x, x).astype(float)
        field = sliding_temperature(flux, grid, speed=peclet, **UNIT)
        field += uniform_temperature(flux.mean(), 4 / peclet, **UNIT)
        shares.append(-field.min() / field.max())
    assert 0.005 < shares[0] < 0.016
    assert shares[1] < 0.6 * shares[0]  # as the root of the pixel, or faster where heat spreads over a pixel


def test_the_laplacian_converges_at_first_order():
    # waves beyond the grid carry it: Σ|q||q̇|² of a Hertz contact, |q̇|² ~ q^−4, is cut at the Nyquist wavenumber
    errors = []
    for pixels in (8, 16, 32):
        grid = Grid((8 * pixels, 8 * pixels), (8.0, 8.0))
        x = (np.arange(32 * pixels) - (32 * pixels - 1) / 2) / pixels / 4
        fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
        pressure = fine.reshape(8 * pixels, 4, 8 * pixels, 4).mean((1, 3))
        power = np.abs(np.fft.rfft2(pressure) / grid.points) ** 2 * grid.multiplicity
        field = sliding_temperature(pressure, grid, speed=0.0, **UNIT)
        spectrum = np.fft.rfft2(field) * -(grid.wavenumbers**2)
        laplacian = np.sum(np.fft.irfft2(spectrum, s=grid.shape) * pressure) / pressure.sum()
        assert laplacian == pytest.approx(-np.sum(power * grid.wavenumbers) / pressure.mean(), rel=1e-10)
        errors.append(1 + laplacian / (pi / 2))  # the exact one is −(π/2) q̇₁/κR, Eq. (18)
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.06)
    assert errors[2] / errors[1] == pytest.approx(0.5, abs=0.08)


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
    close(sliding_temperature(flux, grid, speed=40.0, direction=0.9, time=time, **UNIT), expected, 1e-13)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("speed", nan),
        ("speed", inf),
        ("conductivity", -1.0),
        ("conductivity", 0.0),
        ("diffusivity", 0.0),
        ("diffusivity", nan),
        ("direction", inf),
        ("slid_distance", -1.0),
        ("slid_distance", nan),
        ("time", -1.0),
        ("time", [0.0, nan]),
        ("time", [[1.0]]),
        ("time", []),
        ("depth", -1e-9),
        ("depth", inf),
        ("heat_flux", np.full((8, 8), nan)),
        ("heat_flux", np.ones((8, 9))),
    ],
)
def test_what_is_not_physical_is_refused_by_name(name, value):
    arguments = {"heat_flux": np.eye(8), "speed": 1.0, **UNIT} | {name: value}
    with pytest.raises(ValueError, match=name):
        sliding_temperature(grid=Grid((8, 8), (1.0, 1.0)), **arguments)


@pytest.mark.parametrize(
    ("name", "value"), [("heat_flux", 1j * np.eye(8)), ("speed", "1"), ("time", "1"), ("slid_distance", "far")]
)
def test_what_is_not_a_number_is_refused_by_name(name, value):
    arguments = {"heat_flux": np.eye(8), "speed": 1.0, **UNIT} | {name: value}
    with pytest.raises(TypeError, match=name):
        sliding_temperature(grid=Grid((8, 8), (1.0, 1.0)), **arguments)


def test_time_and_distance_together_are_refused():
    with pytest.raises(ValueError, match="both given"):
        sliding_temperature(np.eye(8), Grid((8, 8), (1.0, 1.0)), speed=1.0, time=1.0, slid_distance=1.0, **UNIT)


def test_an_endless_uniform_source_is_refused():
    with pytest.raises(ValueError, match="time = inf s must be finite"):
        uniform_temperature(1.0, inf, **UNIT)
