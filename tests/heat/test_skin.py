"""A skin on the half-space and heat released in depth, by closed forms, limits with rates, and finite differences."""

from math import inf, pi, sqrt

import numpy as np
import pytest
import scipy
from depth_cases import decaying_modes
from heat_cases import STEEL, close, points, steady
from some_rows import some

from roughsim import Grid, Skin, sliding_temperature
from roughsim.heat.skin import Layering, direction_means, response_from_rest, steady_response
from roughsim.heat.waves import response_of_waves

OXIDE = Skin(thickness=3e-7, conductivity=3.0, diffusivity=3.0 / 3.4e6)
GRID = Grid((12, 10), (3e-5, 2e-5))
WAVE = 2 * pi / 3e-5, -2 * pi / 2e-5  # q_x, q_y of the flux below
SPEED = 3.0
CASES = [(0.0, 0.3), (0.5, 0.0), (0.5, 0.4), (3.0, 0.1), (0.2, 5.0)]  # d and h times |q|


def wave(grid=GRID):
    x, y = points(grid)
    return np.cos(WAVE[0] * x + WAVE[1] * y)


def amplitude(temperature, grid=GRID):
    """Complex T of exp(i q·x) in a field made by `wave`."""
    x, y = points(grid)
    return 2 * np.mean(temperature * np.exp(-1j * (WAVE[0] * x + WAVE[1] * y)))


def roots(skin=OXIDE, speed=SPEED):
    square, advection = WAVE[0] ** 2 + WAVE[1] ** 2, WAVE[0] * speed
    return [
        np.sqrt(square - 1j * advection / diffusivity)
        for diffusivity in (STEEL["diffusivity"], skin.diffusivity)
    ]


def one_wave(q, advection, *numbers, depth=0.0):
    return complex(
        steady_response(np.array([q**2]), np.array([advection]), Layering(*numbers), depth)[0]
    )


def in_depth(q, advection, layers, nodes, spread=inf):
    """κT/q̇ at the surface of one wave by finite volumes in depth, exact in time; `spread` is D t since the start.

    In the frame of the source (1/D) ∂T/∂t = T″ − (q² − i q·v/D)T + Q, with κ_s and D_s in the skin: eigenvectors of
    conduction over capacity, each of which decays and drifts by itself.
    """
    h = layers[-1]
    deep = (
        14 / np.sqrt(q**2 - 1j * advection).real
        + 40 * h
        + 6 * sqrt(spread if spread < inf else 0.0)
    )
    rates, seen, excited = decaying_modes(q, layers, deep, nodes)
    decay = rates - 1j * advection
    grown = 1.0 if spread == inf else -np.expm1(-decay * spread)
    return complex((seen * grown / decay) @ excited)


def extrapolated(*arguments):
    coarse, fine = (in_depth(*arguments[:3], nodes, *arguments[3:]) for nodes in (250, 500))
    return fine + (fine - coarse) / 3


@pytest.mark.parametrize("thickness", [1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("heat_depth", [0.0, 4e-7, 3e-6])
@pytest.mark.parametrize("depth", [0.0, 5e-7, 4e-6])
def test_a_skin_of_the_same_material_changes_nothing(thickness, heat_depth, depth):
    skin = Skin(thickness, STEEL["conductivity"], STEEL["diffusivity"])
    options = {"speed": SPEED, "heat_depth": heat_depth, "depth": depth} | STEEL
    close(steady(wave(), GRID, skin=skin, **options), steady(wave(), GRID, **options), 1e-13)


@pytest.mark.parametrize(("thickness", "heat_depth"), CASES)
@pytest.mark.parametrize(
    ("conduction", "ratio", "advection"), [(0.1, 3.0, 20.0), (8.0, 0.2, -5.0), (0.3, 1.0, 0.0)]
)
def test_a_wave_is_the_solution_by_finite_differences(
    thickness, heat_depth, conduction, ratio, advection
):
    layers = (
        (thickness, conduction, ratio, heat_depth) if thickness else (0.0, 1.0, 1.0, heat_depth)
    )
    assert one_wave(1.3, advection, *layers) == pytest.approx(
        extrapolated(1.3, advection, layers), rel=2e-5
    )


@pytest.mark.parametrize(("thickness", "heat_depth"), some(CASES, 2))
@pytest.mark.parametrize(
    ("conduction", "ratio", "advection"),
    some([(0.1, 3.0, 20.0), (8.0, 0.2, -5.0), (0.3, 1.0, 0.0)], 2),
)
@pytest.mark.parametrize("spread", [0.01, 1.0])
def test_from_rest_a_wave_is_the_solution_by_finite_differences(
    thickness, heat_depth, conduction, ratio, advection, spread
):
    # heat has spread over a tenth of a wavelength, or over a few layers and beyond
    layers = (
        (thickness, conduction, ratio, heat_depth) if thickness else (0.0, 1.0, 1.0, heat_depth)
    )
    q = 1.3
    grid = Grid((8, 8), (2 * pi / q, 2 * pi / q))
    x, _ = points(grid)
    skin = Skin(thickness, conduction, 1 / ratio) if thickness else None
    options = {
        "conductivity": 1.0,
        "diffusivity": 1.0,
        "speed": advection / q,
        "skin": skin,
        "heat_depth": heat_depth,
    }
    field = sliding_temperature(np.cos(q * x), grid, time=spread, **options)
    exact = extrapolated(q, advection, layers, spread)
    close(field, (exact * np.exp(1j * q * x)).real, 1e-4)


def test_a_thick_skin_forgets_with_its_own_diffusivity():
    # D q² t = 45 and D_s q² t = 4.5: the skin alone, which has 3.7e-3 of its steady temperature to go
    q, spread, ratio = 1.3, 45 / 1.69, 10.0
    risen = scipy.special.erf(sqrt(4.5)) / (0.1 * q)
    one = response_from_rest(
        np.array([q**2]), np.zeros(1), Layering(1e3, 0.1, ratio, 0.0), 0.0, spread
    )
    assert one[0] == pytest.approx(risen, rel=1e-9)


@pytest.mark.parametrize("depth", [0.0, 0.4])
@pytest.mark.parametrize("spread", [0.01, 1.0, 100.0])
def test_from_rest_two_layers_of_one_material_are_bare(depth, spread):
    # the bare transient in closed form, from waves that forget at once to waves that never do
    square, advection = (
        np.geomspace(1e-4, 1e3, 30)[:, None],
        np.append(0.0, np.geomspace(1e-3, 1e3, 20)),
    )
    square, advection = np.broadcast_arrays(square, advection)
    layered = response_from_rest(square, advection, Layering(0.3, 1.0, 1.0, 0.0), depth, spread)
    close(layered, response_of_waves(square, advection, depth, spread), 1e-8)


@pytest.mark.parametrize("skin", [None, Skin(2e-6, 2.0, 1e-6)])
def test_the_excess_of_the_hot_track_is_over_a_start_from_rest(skin):
    options = {"speed": 10.0, "skin": skin} | STEEL
    grid = Grid((48, 16), (3e-5, 1e-5))
    flux = np.random.default_rng(4).random(grid.shape)
    flux -= flux.mean()
    young = (sliding_temperature(flux, grid, **options) * flux).mean()  # half the cell
    with pytest.warns(RuntimeWarning, match="hot track") as said:
        excess = (
            sliding_temperature(flux, grid, slid_distance=inf, **options) * flux
        ).mean() / young - 1
    assert abs(excess) > 1e-4
    assert f"by {100 * excess:.3g} %" in str(said[0].message)


def test_a_long_wave_from_rest_warms_as_one_dimension():
    # q√(Dt) → 0: a flux released as e^(−z/h)/h under an insulated face (Prahl); the wave errs by D q² t
    heat_depth, times = 1e-5, np.geomspace(1e-8, 1e-4, 5)
    errors = []
    for length in (4e-3, 8e-3):
        grid = Grid((8, 8), (length, length))
        flux = np.cos(2 * pi * points(grid)[0] / length)
        field = sliding_temperature(
            flux, grid, speed=0.0, time=times, heat_depth=heat_depth, **STEEL
        )
        tau = STEEL["diffusivity"] * times / heat_depth**2
        exact = (
            heat_depth
            / STEEL["conductivity"]
            * (2 * np.sqrt(tau / pi) - 1 + scipy.special.erfcx(np.sqrt(tau)))
        )
        errors.append(np.abs(field[:, 0, 0] / exact - 1))
    assert errors[1].max() < 2e-3
    assert errors[1][-1] / errors[0][-1] == pytest.approx(0.25, abs=0.01)


def test_a_field_has_the_response_in_closed_form():
    below, within = roots()
    inner, lag = OXIDE.conductivity * within, np.tanh(within * OXIDE.thickness)
    outer = STEEL["conductivity"] * below
    expected = (inner + outer * lag) / (inner * (outer + inner * lag))
    field = steady(wave(), GRID, speed=SPEED, skin=OXIDE, **STEEL)
    assert amplitude(field) == pytest.approx(expected, rel=1e-12)
    mirrored = steady(wave(), GRID, speed=-SPEED, skin=OXIDE, **STEEL)
    assert amplitude(mirrored) == pytest.approx(expected.conjugate(), rel=1e-12)


def test_heat_in_depth_divides_by_one_plus_lambda_h():
    below, _ = roots()
    expected = 1 / (STEEL["conductivity"] * below * (1 + below * 2e-6))
    field = steady(wave(), GRID, speed=SPEED, heat_depth=2e-6, **STEEL)
    assert amplitude(field) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("heat_depth", [0.05, 0.7, 6.0])
def test_heat_in_depth_is_the_mean_over_the_depth_of_its_release(heat_depth):
    # by reciprocity the surface is as hot by heat at z, as z is by heat at the surface
    q, advection, layers = 1.1, 2.0, (0.4, 0.2, 3.0)
    depths, weights = np.polynomial.legendre.leggauss(60)
    total = 0.0
    for low, high in ((0.0, 0.4), (0.4, 0.4 + 30 / (q + 1 / heat_depth))):
        z = (low + high) / 2 + (high - low) / 2 * depths
        response = np.array([one_wave(q, advection, *layers, 0.0, depth=at) for at in z])
        total += (high - low) / 2 * weights @ (response * np.exp(-z / heat_depth) / heat_depth)
    assert one_wave(q, advection, *layers, heat_depth) == pytest.approx(total, rel=1e-9)


@pytest.mark.parametrize(("thickness", "heat_depth"), CASES[1:])
def test_the_heat_is_conserved_in_depth(thickness, heat_depth):
    # κT″ − κλ²T + Q = 0 without a flux at the surface: ∫ κλ²T dz = q̇
    q, advection, k, ratio = 1.2, 3.0, 0.3, 2.5
    depths, weights = np.polynomial.legendre.leggauss(80)
    total = 0.0
    for low, high, share, rate in (
        (0.0, thickness, k, ratio),
        (thickness, thickness + 40.0 * max(1.0, heat_depth), 1.0, 1.0),
    ):
        u = (1 + depths) / 2  # z = low + (high − low) u³
        z = low + (high - low) * u**3
        response = np.array(
            [one_wave(q, advection, thickness, k, ratio, heat_depth, depth=at) for at in z]
        )
        total += (
            share
            * (q**2 - 1j * rate * advection)
            * (high - low)
            * weights
            @ (1.5 * u**2 * response)
        )
    assert total == pytest.approx(1.0, rel=1e-9)


def test_a_thin_skin_adds_its_resistance():
    # to the first order in d: (d/κ_s)(1 − (κ_sλ_s/κλ)²), for long waves (d/κ_s)(1 − κ_s²D/κ²D_s)
    errors = []
    for thickness in (1e-2, 5e-3):
        below, within = np.sqrt(1.0 - 2.0j), np.sqrt(1.0 - 3.0 * 2.0j)
        added = one_wave(1.0, 2.0, thickness, 0.2, 3.0, 0.0) - 1 / below
        errors.append(abs(added / (thickness / 0.2 * (1 - (0.2 * within / below) ** 2)) - 1))
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.02)
    assert errors[0] < 0.05
    long = one_wave(1e-7, 1e-7, 1.0, 0.2, 3.0, 0.0) - 1 / np.sqrt(1e-14 - 1e-7j)
    assert long == pytest.approx(1 / 0.2 * (1 - 0.2**2 * 3.0), rel=2e-3)
    still = one_wave(1e-7, 0.0, 1.0, 0.2, 3.0, 0.0) - 1e7
    assert still == pytest.approx(1 / 0.2 * (1 - 0.2**2), rel=1e-6)


def test_a_shallow_release_lowers_the_surface_by_its_depth():
    for heat_depth in (1e-4, 1e-5):
        lowered = one_wave(1.0, 2.0, 0.5, 0.2, 3.0, 0.0) - one_wave(
            1.0, 2.0, 0.5, 0.2, 3.0, heat_depth
        )
        assert lowered == pytest.approx(heat_depth / 0.2, rel=20 * heat_depth)


@pytest.mark.parametrize("depth", [0.0, 2e-7, 2e-6])
def test_a_thick_skin_is_the_whole_body(depth):
    skin = Skin(1e-3, 3.0, 9e-7)
    options = {"speed": SPEED, "depth": depth, "heat_depth": 3e-7}
    whole = steady(wave(), GRID, conductivity=3.0, diffusivity=9e-7, **options)
    close(steady(wave(), GRID, skin=skin, **options, **STEEL), whole, 1e-13)


def test_fast_sliding_over_a_thick_skin_is_hotter_by_the_ratio_of_effusivities():
    # √(κρc) of steel with κ = 46 over √(κρc) of an oxide: 4.22
    bare = direction_means(np.array([1e5]), 1e10, Layering(0.0, 1.0, 1.0, 0.0))[0]
    skin = direction_means(
        np.array([1e5]), 1e10, Layering(1e-3, 3 / 46, (46 / 3.95e6) / (3 / 3.4e6), 0.0)
    )[0]
    assert skin[0] / bare[0] == pytest.approx(sqrt(46 * 3.95e6 / (3 * 3.4e6)), rel=1e-4)


@pytest.mark.parametrize("thickness", [0.0, 0.8])
def test_equal_decay_in_depth_and_of_the_release_is_regular(thickness):
    # λh = 1 and λ_s h = 1, where the particular solution of the plain formulas has a pole
    layers = (thickness, 0.5, 1.0) if thickness else (0.0, 1.0, 1.0)
    for depth in (0.0, 0.3, 1.7):
        below, here, above = (
            one_wave(1.0, 0.0, *layers, h, depth=depth) for h in (1 - 1e-5, 1.0, 1 + 1e-5)
        )
        assert here == pytest.approx((below + above) / 2, rel=1e-9)


@pytest.mark.parametrize(
    "layers", [(1e-9, 1e-6, 1e6), (1e3, 1e6, 1e-6), (1e-12, 50.0, 2.0), (0.0, 1.0, 1.0)]
)
@pytest.mark.parametrize("heat_depth", [0.0, 1e-300, 1e-12, 1.0, 1e12])
def test_no_size_of_the_layers_leaves_double_precision(layers, heat_depth):
    for depth in (0.0, 1e-9, 1.0, 1e6):
        for q in (1e-6, 1.0, 1e12):
            response = one_wave(q, 1e6 * q, *layers, heat_depth, depth=depth)
            assert np.isfinite(response)
            assert depth > 0.0 or response.real >= -1e-10 * abs(response)


@pytest.mark.parametrize(
    "layers", [(0.7, 0.2, 3.0, 0.0), (0.7, 4.0, 0.3, 0.5), (0.0, 1.0, 1.0, 2.0)]
)
@pytest.mark.parametrize("rate", [0.0, 0.5, 30.0])
def test_the_mean_over_directions_is_a_plain_mean(layers, rate):
    q = np.array([0.3, 1.0, 4.0])
    cosine = np.cos((np.arange(20_000) + 0.5) * pi / 20_000)
    response = (
        steady_response(q[:, None] ** 2, rate * q[:, None] * cosine, Layering(*layers)) * q[:, None]
    )
    even, odd = direction_means(q, rate, Layering(*layers))
    np.testing.assert_allclose(even, response.real.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(
        odd, (1j * cosine * response).real.mean(axis=1), rtol=1e-12, atol=1e-15
    )


def test_many_wavenumbers_are_interpolated_to_twelve_digits():
    q, layers = np.geomspace(1e3, 1e7, 3000), Layering(3e-7, 0.07, 9.0, 1e-7)
    some = slice(5, None, 37)
    for many, few in zip(
        direction_means(q, 4.6e6, layers), direction_means(q[some], 4.6e6, layers), strict=True
    ):
        np.testing.assert_allclose(many[some], few, rtol=1e-11)


def test_any_three_numbers_are_a_skin():
    close(
        steady(wave(), GRID, speed=SPEED, skin=tuple(OXIDE), **STEEL),
        steady(wave(), GRID, speed=SPEED, skin=OXIDE, **STEEL),
        1e-16,
    )
