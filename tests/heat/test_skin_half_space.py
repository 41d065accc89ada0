"""A skin and heat in depth on the free half-space, and two such bodies that share their heat."""

from math import inf, pi, sqrt

import numpy as np
import pytest
import scipy
from heat_cases import STEEL
from some_rows import some

from roughsim import Body, Grid, Skin, half_space_temperature, partition_heat, sliding_temperature
from roughsim.heat import depth_profile
from theory.skin import direction_mean, even_part, layers_of

OXIDE = Skin(3e-6, 3.0, 9e-7)
RADIUS = 5e-6
CASES = [(OXIDE, 0.0), (Skin(1e-6, 3.0, 9e-7), 5e-7), (None, 5e-7)]


def hill(count, side=6 * RADIUS):
    """A Gaussian source on an odd grid, its grid, and the index of its middle."""
    x = (np.arange(count) - (count - 1) / 2) * side / count
    return (
        np.exp(-(x[:, None] ** 2 + x**2) / RADIUS**2),
        Grid((count, count), (side, side)),
        count // 2,
    )


def exact_at_the_middle(speed, skin, heat_depth):
    """∫ q dq/2π πR² e^(−q²R²/4) ⟨Re F⟩/κq: at the middle only the mean over directions counts."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    q, share = 7 / RADIUS * (1 + nodes), 7 / RADIUS * weights
    layers = layers_of(skin, heat_depth, *STEEL.values())
    mean = direction_mean(q, speed / STEEL["diffusivity"], layers, even_part)
    return (share * RADIUS**2 / 2 * np.exp(-((q * RADIUS) ** 2) / 4) * mean).sum() / STEEL[
        "conductivity"
    ]


@pytest.mark.parametrize(("skin", "heat_depth"), CASES)
@pytest.mark.parametrize(("speed", "direction"), some([(0.0, 0.0), (1.0, 0.4), (35.0, pi / 2)], 2))
def test_a_gaussian_source_is_as_hot_as_its_hankel_integral(skin, heat_depth, speed, direction):
    flux, grid, middle = hill(61)
    heat = {"speed": speed, "direction": direction, "skin": skin, "heat_depth": heat_depth}
    field = half_space_temperature(flux, grid, **heat, **STEEL)
    assert field[middle, middle] == pytest.approx(
        exact_at_the_middle(speed, skin, heat_depth), rel=4e-3
    )


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


@pytest.mark.parametrize("direction", some([0.4, pi / 2, 2.0], 3))
def test_a_source_mirrored_across_the_other_axis_leaves_a_mirrored_field(direction):
    flux, grid, _ = hill(24)  # padded to 48 points: there are waves at the Nyquist wavenumber
    flux = flux * (1 + 0.3 * np.random.default_rng(2).random(flux.shape))
    left, right = (
        half_space_temperature(field, grid, speed=3.0, direction=angle, skin=OXIDE, **STEEL)
        for field, angle in ((flux, direction), (flux[:, ::-1], -direction))
    )
    np.testing.assert_allclose(right[:, ::-1], left, rtol=0, atol=1e-12 * left.max())


def ierfc(x):
    return np.exp(-(x**2)) / sqrt(pi) - x * scipy.special.erfc(x)


def under_a_skin(times, z, d, ks, ds):
    """κ_s-layer on steel, unit flux from t = 0: images of the interface (Carslaw & Jaeger, 12.8), at a depth z ≤ d."""
    own, below = ks / sqrt(ds), STEEL["conductivity"] / sqrt(STEEL["diffusivity"])
    n, spread = np.arange(-3000, 3001), np.sqrt(ds * times)[:, None]
    images = ((own - below) / (own + below)) ** np.abs(n) * ierfc(
        np.abs(2 * n * d + z) / (2 * spread)
    )
    return 2 * spread[:, 0] / ks * images.sum(axis=1)


def in_depth(times, h):
    """Unit flux released as e^(−z/h)/h under an insulated face from t = 0 (Prahl 1995)."""
    tau = STEEL["diffusivity"] * times / h**2
    return (
        h / STEEL["conductivity"] * (2 * np.sqrt(tau / pi) - 1 + scipy.special.erfcx(np.sqrt(tau)))
    )


PAD = Grid((4, 4), (4e-3, 4e-3))  # 15 times as far to its edges as heat gets
TIMES = np.geomspace(1e-7, 1e-3, 9)
THICK = Skin(1e-5, 3.0, 9e-7)


@pytest.mark.parametrize("speed", [0.0, 0.1])
def test_a_pad_on_layers_warms_as_in_one_dimension(speed):
    options = {"speed": speed, "time": TIMES} | STEEL
    for layers, expected in (
        ({"skin": THICK}, under_a_skin(TIMES, 0.0, *THICK)),
        ({"skin": THICK, "depth": 6e-6}, under_a_skin(TIMES, 6e-6, *THICK)),
        ({"heat_depth": 1e-5}, in_depth(TIMES, 1e-5)),
    ):
        field = half_space_temperature(np.ones(PAD.shape), PAD, **layers, **options)
        np.testing.assert_allclose(field[:, 2, 2], expected, rtol=1e-6, atol=1e-10 * expected.max())


@pytest.mark.parametrize("layers", [{"skin": THICK}, {"heat_depth": 1e-5}])
def test_heat_is_shared_from_rest_as_in_one_dimension(layers):
    # beside an insulator all heat is in the layered body; beside its equal half of it
    expected = under_a_skin(TIMES, 0.0, *THICK) if "skin" in layers else in_depth(TIMES, 1e-5)
    moving = Body(**STEEL, **layers)
    for resting, share in ((Body(1e-9, 1e-6), 1.0), (moving, 0.5)):
        for time, rise in zip(TIMES[::4], expected[::4], strict=True):
            shared = partition_heat(
                np.ones(PAD.shape), PAD, moving=moving, resting=resting, time=time
            )
            assert shared.temperature[2, 2] == pytest.approx(share * rise, rel=1e-4)


@pytest.mark.parametrize("skin", [Skin(3e-7, 3.0, 9e-7), Skin(6e-7, 200.0, 1e-4)])
def test_the_wake_of_a_fast_strip_cools_as_in_one_dimension(skin):
    # a strip 1000 times as wide as the cell is long heats each point of its track for a time: v L/D = 4e5
    length, speed = 1e-5, 5e3
    grid = Grid((64, 3), (64 * length, 3e-1))
    flux = np.zeros(grid.shape)
    flux[48:60] = 1.0
    field = half_space_temperature(flux, grid, speed=speed, skin=skin, **STEEL)[:, 1]
    since = (np.array([[59.5], [47.5]]) - np.arange(58)) * length / speed  # that its edges passed
    begun, ended = (np.where(t > 0, under_a_skin(np.abs(t), 0.0, *skin), 0.0) for t in since)
    np.testing.assert_allclose(field[:58], begun - ended, rtol=2e-3)


@pytest.mark.parametrize("speed", some([0.5, 5.0], 2))
def test_a_thick_skin_is_the_whole_half_space(speed):
    grid, heat = Grid((24, 24), (1e-3, 1e-3)), {"speed": speed}
    flux = np.zeros(grid.shape)
    flux[8:16, 8:16] = 1.0
    ours = {"conductivity": 3.0, "diffusivity": 1e-6}
    whole = half_space_temperature(flux, grid, **heat, **ours)
    steel = Body(speed=0.3, **STEEL)
    share = partition_heat(flux, grid, moving=Body(**ours, **heat), resting=steel).moving_share
    errors = []
    # in the wake at x the body changes e^(−d²v/D_s x) of the temperature: d² v/D_s in cells
    for cells in (2, 40, 1e5):
        skin = Skin(sqrt(cells * 1e-3 * 1e-6 / speed), 3.0, 1e-6)
        field = half_space_temperature(
            flux, grid, skin=skin, conductivity=30.0, diffusivity=1e-5, **heat
        )
        errors.append(np.abs(field - whole).max() / whole.max())
    assert errors[0] > 1e-3
    assert max(errors[1:]) < 1e-9
    moving = Body(30.0, 1e-5, skin=skin, **heat)
    assert partition_heat(flux, grid, moving=moving, resting=steel).moving_share == pytest.approx(
        share, rel=1e-7
    )


@pytest.mark.parametrize("speed", [0.0, 1e-8])
@pytest.mark.parametrize("conductivity", some([3.0, 300.0], 2, pairs=True))
def test_a_body_far_below_a_source_at_rest_is_felt_as_by_images(speed, conductivity):
    # steady: κ_s ΔT = Q/2π Σ 2βⁿ/2nd, Q the heat, β = (κ_s − κ)/(κ_s + κ); the source is small beside d
    flux, grid, middle = hill(9)
    heat = flux.sum() * np.prod(grid.spacing)
    beta = (conductivity - STEEL["conductivity"]) / (conductivity + STEEL["conductivity"])
    whole = half_space_temperature(
        flux, grid, speed=speed, conductivity=conductivity, diffusivity=9e-7
    )
    for thickness in (1e-3, 1e-1):
        skin = Skin(thickness, conductivity, 9e-7)
        field = half_space_temperature(flux, grid, speed=speed, skin=skin, **STEEL)
        change = -heat * np.log1p(-beta) / (2 * pi * conductivity * thickness)
        assert (field - whole)[middle, middle] == pytest.approx(change, rel=1e-3, abs=0.0)


def test_a_slow_source_loses_as_much_over_a_layered_body():
    # at rest less Q v/4πκD, to the first order in the speed: the oldest heat is far beyond the layers
    flux, grid, middle = hill(9)
    heat = flux.sum() * np.prod(grid.spacing)
    slow, still = (
        half_space_temperature(flux, grid, speed=v, skin=Skin(1e-5, 3.0, 9e-7), **STEEL)[
            middle, middle
        ]
        for v in (1e-5, 0.0)
    )
    lost = heat * 1e-5 / (4 * pi * STEEL["conductivity"] * STEEL["diffusivity"])
    assert still - slow == pytest.approx(lost, rel=1e-2, abs=0.0)


@pytest.mark.parametrize("time", [1e-6, inf])
@pytest.mark.parametrize("thickness", some([1e-9, 1e-8], 2))
def test_a_thin_skin_adds_its_resistance_to_a_source(thickness, time):
    # d/κ_s times the flux, less (κ_s/κ)²-times as much by what it conducts and stores
    flux, grid, middle = hill(41)
    options = {"speed": 1.0, "time": time} | STEEL
    bare = half_space_temperature(flux, grid, **options)
    skin = Skin(thickness, 0.03, 9e-9)  # (κ_s/κ)² D/D_s = 8e-4
    rise = half_space_temperature(flux, grid, skin=skin, **options) - bare
    assert rise[middle, middle] == pytest.approx(thickness / 0.03, rel=thickness / 1e-7 + 2e-3)


@pytest.mark.parametrize(("skin", "heat_depth"), some([*CASES, (Skin(1e-4, 3.0, 9e-7), 0.0)], 3))
def test_the_steady_state_is_approached_as_on_a_bare_body(skin, heat_depth):
    # at rest κ(T − T(t)) = Q/(2π√π √(Dt)), Q the heat: what is released in layers has left them by then
    flux, grid, middle = hill(9)
    heat = flux.sum() * np.prod(grid.spacing)
    times = np.array([1e2, 1e4, inf])
    options = {"speed": 0.0, "time": times, "skin": skin, "heat_depth": heat_depth} | STEEL
    field = half_space_temperature(flux, grid, **options)[:, middle, middle]
    missing = heat / (
        2 * pi**1.5 * np.sqrt(STEEL["diffusivity"] * times[:2]) * STEEL["conductivity"]
    )
    np.testing.assert_allclose(field[2] - field[:2], missing, rtol=1e-2)


@pytest.mark.parametrize("speed", some([0.3, 3.0], 2))
@pytest.mark.parametrize(
    "layers", [(OXIDE, 0.0), (Skin(2e-5, 90.0, 4e-5), 0.0), (OXIDE, 1e-6), (None, 2e-6)]
)
def test_a_smooth_source_has_its_hankel_integral_to_four_digits(speed, layers):
    values = []
    for count, pixel in ((61, RADIUS / 10), (121, RADIUS / 20)):
        flux, grid, middle = hill(count, count * pixel)
        field = half_space_temperature(
            flux, grid, speed=speed, skin=layers[0], heat_depth=layers[1], **STEEL
        )
        values.append(field[middle, middle])
    # the pixels differ by a factor of 2, their errors by 4
    assert values[1] + (values[1] - values[0]) / 3 == pytest.approx(
        exact_at_the_middle(speed, *layers), rel=2e-4
    )


@pytest.mark.parametrize(
    ("skin", "time"),
    some([(OXIDE, 1e-6), (Skin(3e-6, 300.0, 1e-4), 1e-8), (Skin(1e-6, 0.2, 1e-7), 1e-5)], 3),
)
def test_both_ways_from_rest_agree(skin, time):
    # waves of a periodic cell, and ages of the heat of each pixel: differences over the source, before images matter
    flux, grid, _ = hill(48, 8 * RADIUS)
    heat = {"speed": 0.3, "skin": skin} | STEEL
    cell = Grid((480, 480), (80 * RADIUS, 80 * RADIUS))
    padded = np.zeros(cell.shape)
    padded[:48, :48] = flux
    options = {"time": time}
    free = half_space_temperature(flux, grid, **heat, **options)
    periodic = sliding_temperature(padded, cell, **heat, **options)[:48, :48]
    places = (slice(16, 32), slice(16, 32))
    free, periodic = (field[places] - field[places].mean() for field in (free, periodic))
    assert np.abs(free - periodic).max() < 5e-3 * np.ptp(free)


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


@pytest.mark.parametrize(
    ("speed", "skin"),
    [
        *((1.0, skin) for skin in (None, OXIDE)),
        *(
            pytest.param(speed, skin, marks=pytest.mark.slow)
            for speed in (0.0, 35.0)
            for skin in (None, OXIDE)
        ),
    ],
)
def test_heat_released_in_depth_makes_no_maximum_below_the_surface(speed, skin):
    # the release falls with z and no heat leaves through the surface
    flux, grid, _ = hill(24)
    heat = {"speed": speed, "skin": skin, "heat_depth": 3e-6}
    depths = np.linspace(0.0, 6e-6, 5)
    below = depth_profile(
        lambda z: half_space_temperature(flux, grid, depth=z, **heat, **STEEL), depths
    )
    assert (np.diff(below) < 0.0).all()
