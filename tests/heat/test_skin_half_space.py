"""A skin and heat in depth on the free half-space, and two such bodies that share their heat."""

from math import pi

import numpy as np
import pytest
from heat_cases import STEEL

from roughsim import Body, Grid, Skin, half_space_temperature, partition_heat
from roughsim.heat import depth_profile
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
