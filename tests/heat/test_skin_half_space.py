"""A skin and heat in depth on the free half-space, and two such bodies that share their heat."""

from math import pi

import numpy as np
import pytest
import scipy
from heat_cases import STEEL

from roughsim import Body, Grid, Skin, half_space_temperature, partition_heat
from roughsim.heat import depth_profile
from roughsim.heat.half_space import _mean_change, layered_change
from roughsim.heat.skin import Layering
from theory.skin import direction_mean, even_part, layers_of

OXIDE = Skin(3e-6, 3.0, 9e-7)
RADIUS = 5e-6
CASES = [(OXIDE, 0.0), (Skin(1e-6, 3.0, 9e-7), 5e-7), (None, 5e-7)]


def hill(count, side=6 * RADIUS):
    """A Gaussian source on an odd grid, its grid, and the index of its middle."""
    x = (np.arange(count) - (count - 1) / 2) * side / count
    return np.exp(-(x[:, None] ** 2 + x**2) / RADIUS**2), Grid((count, count), (side, side)), count // 2


def exact_at_the_middle(speed, skin, heat_depth):
    """∫ q dq/2π πR² e^(−q²R²/4) ⟨Re F⟩/κq: at the middle only the mean over directions counts."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    q, share = 7 / RADIUS * (1 + nodes), 7 / RADIUS * weights
    layers = layers_of(skin, heat_depth, *STEEL.values())
    mean = direction_mean(q, speed / STEEL["diffusivity"], layers, even_part)
    return (share * RADIUS**2 / 2 * np.exp(-((q * RADIUS) ** 2) / 4) * mean).sum() / STEEL["conductivity"]


@pytest.mark.parametrize(("skin", "heat_depth"), CASES)
@pytest.mark.parametrize(("speed", "direction"), [(0.0, 0.0), (1.0, 0.4), (35.0, pi / 2)])
def test_a_gaussian_source_is_as_hot_as_its_hankel_integral(skin, heat_depth, speed, direction):
    flux, grid, middle = hill(61)
    heat = {"speed": speed, "direction": direction, "skin": skin, "heat_depth": heat_depth}
    field = half_space_temperature(flux, grid, **heat, **STEEL)
    assert field[middle, middle] == pytest.approx(exact_at_the_middle(speed, skin, heat_depth), rel=4e-3)


def test_the_pixel_errs_to_the_second_order():
    errors = []
    for count in (21, 41):
        flux, grid, middle = hill(count)
        field = half_space_temperature(flux, grid, speed=1.0, heat_depth=5e-7, **STEEL)
        errors.append(abs(field[middle, middle] / exact_at_the_middle(1.0, None, 5e-7) - 1))
    assert errors[1] < errors[0] / 3


@pytest.mark.parametrize("depth", [0.0, 2e-6])
def test_a_skin_of_the_same_material_changes_nothing(depth):
    flux, grid, _ = hill(24)
    skin = Skin(1e-6, *STEEL.values())
    times = np.array([1e-5, np.inf])
    bare, layered = (
        half_space_temperature(flux, grid, speed=5.0, depth=depth, time=times, skin=layer, **STEEL)
        for layer in (None, skin)
    )
    np.testing.assert_allclose(layered, bare, rtol=0, atol=1e-13 * bare.max())
    low = half_space_temperature(flux.astype(np.float32), grid, speed=5.0, skin=OXIDE, **STEEL)
    assert low.dtype == np.float32


def test_a_mirrored_source_leaves_a_mirrored_field():
    flux, grid, _ = hill(24)
    flux = flux * (1 + 0.3 * np.random.default_rng(1).random(flux.shape))
    forth, back = (
        half_space_temperature(field, grid, speed=v, skin=OXIDE, heat_depth=1e-6, **STEEL)
        for field, v in ((flux, 3.0), (flux[::-1], -3.0))
    )
    np.testing.assert_allclose(back[::-1], forth, rtol=0, atol=1e-12 * forth.max())


@pytest.mark.parametrize("direction", [0.4, pi / 2, 2.0])
def test_a_source_mirrored_across_the_other_axis_leaves_a_mirrored_field(direction):
    flux, grid, _ = hill(24)  # padded to 48 points: there are waves at the Nyquist wavenumber
    flux = flux * (1 + 0.3 * np.random.default_rng(2).random(flux.shape))
    left, right = (
        half_space_temperature(field, grid, speed=3.0, direction=angle, skin=OXIDE, **STEEL)
        for field, angle in ((flux, direction), (flux[:, ::-1], -direction))
    )
    np.testing.assert_allclose(right[:, ::-1], left, rtol=0, atol=1e-12 * left.max())


def change_by_two_layers(along, across, rate):
    """κT/q̇ of waves under the oxide less that of bare steel, from two layers in series; v/D = `rate`."""
    square = along**2 + across**2
    below, within = (np.sqrt(square - 1j * r * along) for r in (rate, rate * STEEL["diffusivity"] / 9e-7))
    inner, lag = 3.0 / STEEL["conductivity"] * within, np.tanh(within * 3e-6)
    return (inner + below * lag) / (inner * (below + inner * lag)) - 1 / below


LAYERS = Layering(3e-6, 3.0 / STEEL["conductivity"], STEEL["diffusivity"] / 9e-7, 0.0)


def test_waves_at_the_nyquist_wavenumbers_have_the_mean_of_both_directions_along_the_axis():
    grid, rate = Grid((48, 48), (3e-5, 3e-5)), 3.0 / STEEL["diffusivity"]
    ux, uy = np.cos(0.7), np.sin(0.7)
    turned = layered_change(grid, (rate * ux, rate * uy), 0.0, LAYERS) * grid.points
    step = 2 * pi / 3e-5
    for i, j, mirrored in ((11, 24, [(11, -24), (11, 24)]), (24, 11, [(24, 11), (-24, 11)])):
        waves = [(step * i, step * j) for i, j in mirrored]
        both = [change_by_two_layers(ux * qx + uy * qy, ux * qy - uy * qx, rate) for qx, qy in waves]
        assert abs(both[0] - both[1]) > 0.1 * abs(both[0])
        assert turned[j, i] == pytest.approx(sum(both) / 2, rel=1e-12)


@pytest.mark.parametrize(("speed", "across", "error"), [(0.0, 0.3, 1e-10), (1.0, 0.3, 1e-9), (1.0, 2.0, 1e-10)])
@pytest.mark.parametrize("place", [0.0, 0.5, 3.0])
def test_a_long_wave_is_the_mean_over_its_fourier_cell(speed, across, error, place):
    width, rate = 1e5, speed / STEEL["diffusivity"]
    edges = np.array([place - 0.5, place + 0.5]) * width
    # F varies where q along is q_across² D/v
    steps = (across * width) ** 2 / rate * np.array([-100, -10, -1, 0, 1, 10, 100]) if speed else np.zeros(1)
    pieces = [*edges, *steps[(steps > edges[0]) & (steps < edges[1])]]
    exact = 0.0
    for low, high in zip(sorted(pieces)[:-1], sorted(pieces)[1:], strict=True):
        for part, unit in ((np.real, 1), (np.imag, 1j)):
            mean = scipy.integrate.quad(
                lambda x, part=part: part(change_by_two_layers(x, across * width, rate)), low, high, epsrel=1e-12
            )
            exact += unit * mean[0] / width
    got = _mean_change(np.array([place * width]), np.array([across * width]), rate, 0.0, LAYERS, width)[0]
    assert abs(got - exact) < error * abs(exact)


@pytest.mark.parametrize("pointwise", [True, False])
def test_bodies_with_equal_layers_at_rest_share_as_their_conductivities(pointwise):
    # the same d, κ_s/κ, D/D_s and h: the responses differ by κ alone
    flux, grid, _ = hill(16)
    moving = Body(46.0, 1.2e-5, skin=Skin(1e-6, 4.6, 2e-6), heat_depth=3e-7)
    resting = Body(23.0, 1.2e-5, skin=Skin(1e-6, 2.3, 2e-6), heat_depth=3e-7)
    shared = partition_heat(flux, grid, moving=moving, resting=resting, pointwise=pointwise)
    assert shared.moving_share == pytest.approx(46 / 69, rel=1e-6)
    np.testing.assert_allclose(shared.heat_flux, 46 / 69 * flux, rtol=0, atol=1e-6)


@pytest.mark.parametrize("layers", [{"skin": OXIDE}, {"heat_depth": 2e-6}])
def test_a_skin_turns_heat_away_and_depth_takes_more(layers):
    flux, grid, _ = hill(16)
    bare = Body(speed=3.0, **STEEL)
    layered = Body(speed=3.0, **layers, **STEEL)
    resting = Body(**STEEL)
    shares = [partition_heat(flux, grid, moving=body, resting=resting) for body in (bare, layered)]
    assert (shares[1].moving_share < shares[0].moving_share) == ("skin" in layers)
    assert shares[1].residual < 1e-8


def test_bad_layers_are_refused():
    flux, grid, _ = hill(8)
    with pytest.raises(TypeError, match="skin = .* must be three numbers"):
        half_space_temperature(flux, grid, speed=1.0, skin=(1.0,), **STEEL)
    with pytest.raises(ValueError, match="heat_depth = -1 m must not be negative"):
        Body(heat_depth=-1.0, **STEEL)
    with pytest.raises(ValueError, match="diffusivity of the skin = 0 m²/s must be positive"):
        Body(skin=Skin(1e-6, 1.0, 0.0), **STEEL)


@pytest.mark.parametrize("speed", [0.0, 1.0, 35.0])
@pytest.mark.parametrize("skin", [None, OXIDE])
def test_heat_released_in_depth_makes_no_maximum_below_the_surface(speed, skin):
    # the release falls with z and no heat leaves through the surface
    flux, grid, _ = hill(24)
    heat = {"speed": speed, "skin": skin, "heat_depth": 3e-6}
    depths = np.linspace(0.0, 6e-6, 9)
    below = depth_profile(lambda z: half_space_temperature(flux, grid, depth=z, **heat, **STEEL), depths)
    assert (np.diff(below) < 0.0).all()
