"""Two rough bodies with skins, or heated in depth, that slide: limits, steady states, images, and symmetries."""

import numpy as np
import pytest
from scipy.special import erfcx
from test_two_bodies import FRICTION, GLASS, SOLID, STEEL, law, sliding

from theory import background, layered_memory
from theory.skin import BodyLayers

OXIDE = (1e-6, 3.0, 9e-7)
SILVER = (3e-6, 300.0, 1e-4)
LAYERED = {"skin": OXIDE, "resting_skin": SILVER, "resting_heat_depth": 2e-6}
LAYERS = {  # d, κ_s/κ, D/D_s and h
    "oxide": (1e-6, 0.1, 8.4, 0.0),
    "silver": (3e-6, 10.0, 0.076, 0.0),
    "oxide, heated in depth": (1e-6, 0.1, 8.4, 5e-7),
    "heated in depth": (0.0, 1.0, 1.0, 3e-6),
}
INSULATED_MOVING = {
    "conductivity": 1e-9,
    "resting_conductivity": 30.0,
    "resting_diffusivity": 7.6e-6,
}
INSULATED_RESTING = {"resting_conductivity": 1e-9, "resting_diffusivity": 7.6e-6}


def test_a_skin_of_the_same_material_is_no_skin():
    same = {"skin": (2e-6, 30.0, 7.6e-6), "resting_skin": (5e-5, 1.0, 5e-7)}
    bare, layered = (
        sliding(5.0, moving_roughness=0.3, **GLASS),
        sliding(5.0, moving_roughness=0.3, **GLASS, **same),
    )
    for one, other in zip(layered, bare, strict=True):
        assert one == pytest.approx(other, rel=1e-10)


@pytest.mark.parametrize(
    "thin", [{"skin": (1e-12, 3.0, 9e-7)}, {"heat_depth": 1e-12}, {"resting_heat_depth": 1e-12}]
)
def test_layers_without_depth_are_none(thin):
    for one, other in zip(sliding(**thin), sliding(), strict=True):
        assert one == pytest.approx(other, rel=1e-3)


def test_a_thick_skin_is_the_whole_body():
    whole = sliding(**GLASS, moving_roughness=0.3)
    skins = sliding(
        moving_roughness=0.3,
        resting_skin=(1e-2, 1.0, 5e-7),
        resting_conductivity=30.0,
        resting_diffusivity=7.6e-6,
    )
    for one, other in zip(skins, whole, strict=True):
        assert one == pytest.approx(other, rel=2e-3)


def test_twins_with_equal_skins_share_the_heat_evenly():
    slid = sliding(skin=OXIDE, resting_skin=OXIDE, heat_depth=2e-7, resting_heat_depth=2e-7)
    assert slid.moving_share == pytest.approx(0.5, abs=1e-10)
    assert slid.flash_temperature == pytest.approx(slid.resting_flash_temperature, rel=1e-10)
    assert slid.background == pytest.approx(slid.resting_background, rel=1e-10)


@pytest.mark.parametrize("part", [pytest.param(0.0, marks=pytest.mark.slow), 0.3])
def test_the_bodies_exchanged_exchange_their_temperatures(part):
    slid = sliding(5.0, moving_roughness=part, **GLASS, **LAYERED)
    other = sliding(
        5.0,
        moving_roughness=1 - part,
        conductivity=1.0,
        diffusivity=5e-7,
        resting_conductivity=30.0,
        resting_diffusivity=7.6e-6,
        skin=SILVER,
        heat_depth=2e-6,
        resting_skin=OXIDE,
    )
    assert other.resting_flash_temperature == pytest.approx(slid.flash_temperature, rel=1e-9)
    assert other.flash_temperature == pytest.approx(slid.resting_flash_temperature, rel=1e-9)
    assert other.moving_share == pytest.approx(1 - slid.moving_share, rel=1e-9)
    total = slid.resting_flash_temperature + slid.resting_background
    assert slid.contact_temperature == pytest.approx(total, rel=1e-10)


def steady(q, advection, d, k, ratio, h):
    """κT/q̇ of one wave, heat in depth by its mean over the depth of release."""
    below, within = np.sqrt(q**2 - 1j * advection), np.sqrt(q**2 - 1j * ratio * advection)
    if d == 0.0:
        return 1 / (below * (1 + below * h))
    inner = k * within
    echo = (inner - below) / (inner + below)  # of the lower face of the skin

    def by_surface_heat(z):
        direct, reflected = np.exp(-within * z), np.exp(-within * (2 * d - z))
        return (direct + echo * reflected) / (1 - echo * np.exp(-2 * within * d)) / inner

    if h == 0.0:
        return by_surface_heat(0.0)
    points, weights = np.polynomial.legendre.leggauss(40)
    total = by_surface_heat(d) * np.exp(-d / h) / (1 + below * h)
    for z, weight in zip(d * (1 + points) / 2, weights * d / 2, strict=True):
        total = total + weight * np.exp(-z / h) / h * by_surface_heat(z)
    return total


RUBBER_ON_DIAMOND = (2e-6, 0.01, 1e4, 0.0)


@pytest.mark.parametrize(
    "layers", [*LAYERS.values(), RUBBER_ON_DIAMOND], ids=[*LAYERS, "rubber on diamond"]
)
def test_the_gaussians_of_all_times_add_up_to_the_steady_state(layers):
    times = np.geomspace(1e-16, 1e2, 1000)
    spreads, strength = layered_memory.pulses(BodyLayers(*layers), 7.6e-6, times)
    for q in (1e3, 1e5, 3e6):
        decay = np.exp(-spreads[:, None] * q**2 * times)
        heat = (strength * np.sqrt(spreads[:, None] / (np.pi * times)) * decay).sum(axis=0)
        total = np.trapezoid(heat * times, np.log(times))
        assert total == pytest.approx(steady(q, 0.0, *layers).real, rel=1e-3)


@pytest.mark.parametrize(
    "layers",
    [
        pytest.param(LAYERS["oxide"], id="oxide"),
        pytest.param(LAYERS["oxide, heated in depth"], id="both", marks=pytest.mark.slow),
        pytest.param(LAYERS["heated in depth"], id="deep"),
    ],
)
def test_all_heat_in_one_body_ends_at_its_steady_temperature(layers):
    # the rough body carries the spots, or they slide over the smooth one
    _, q, weight = law()
    d, k, ratio, h = layers
    skin = (d, 30.0 * k, 7.6e-6 / ratio) if d else None
    speed, far = 5.0, 2e-1
    angles = (np.arange(300) + 0.5) * np.pi / 600
    advection = q[:, None] * speed * np.cos(angles) / 7.6e-6
    unit = FRICTION * speed / (30.0 * SOLID["nominal_pressure"])
    still = sliding(
        speed,
        slid_distance=far,
        moving_roughness=0.0,
        resting_skin=skin,
        resting_heat_depth=h,
        **INSULATED_MOVING,
    )
    assert still.resting_flash_temperature == pytest.approx(
        unit * weight @ steady(q, 0.0, *layers).real, rel=4e-3
    )
    over = sliding(
        speed, slid_distance=far, moving_roughness=0.0, skin=skin, heat_depth=h, **INSULATED_RESTING
    )
    expected = unit * weight @ steady(q[:, None], advection, *layers).real.mean(axis=1)
    assert over.flash_temperature == pytest.approx(expected, rel=4e-3)
    bare = unit * weight @ steady(q[:, None], advection, 0.0, 1.0, 1.0, 0.0).real.mean(axis=1)
    assert abs(expected / bare - 1) > 0.03


def test_a_resting_source_under_a_skin_of_its_own_diffusivity_grows_by_images():
    _, q, weight = law()
    k, d, diffusivity, speed = 0.2, 2e-6, 7.6e-6, 5.0
    echo = (k - 1) / (k + 1)
    x = (np.arange(4000) + 0.5) / 4000  # √(τ/t)
    for distance in (1e-6, 1e-5, 1e-3):
        time = distance / speed
        tau = time * x**2
        images = sum(echo**n * np.exp(-((n * d) ** 2) / (diffusivity * tau)) for n in range(1, 40))
        kernel = 2 * np.sqrt(diffusivity * time / np.pi) * (1 + 2 * images) / k / x.size
        expected = weight @ (np.exp(-diffusivity * q[:, None] ** 2 * tau) @ kernel)
        slid = sliding(
            speed,
            slid_distance=distance,
            moving_roughness=0.0,
            resting_skin=(d, 30.0 * k, diffusivity),
            **INSULATED_MOVING,
        )
        unit = FRICTION * speed / (30.0 * SOLID["nominal_pressure"])
        assert slid.resting_flash_temperature == pytest.approx(unit * expected, rel=3e-3)


def test_a_resting_source_in_depth_grows_by_its_closed_kernel():
    _, q, weight = law()
    h, diffusivity, speed = 2e-6, 7.6e-6, 5.0
    x = (np.arange(4000) + 0.5) / 4000
    for distance in (1e-6, 1e-5, 1e-3):
        time = distance / speed
        reach = np.sqrt(diffusivity * time) * x
        kernel = 2 * diffusivity * time * x / h * erfcx(reach / h) / x.size
        expected = weight @ (np.exp(-(q[:, None] ** 2) * reach**2) @ kernel)
        slid = sliding(
            speed,
            slid_distance=distance,
            moving_roughness=0.0,
            resting_heat_depth=h,
            **INSULATED_MOVING,
        )
        unit = FRICTION * speed / (30.0 * SOLID["nominal_pressure"])
        assert slid.resting_flash_temperature == pytest.approx(unit * expected, rel=3e-3)


def test_after_long_the_background_has_risen_by_the_skin():
    # 2√(Dt/π) + (d/κ_s)(1 − κ_s²D/κ²D_s)
    d, kappa, diffusivity = OXIDE
    slid = sliding(3.0, slid_distance=1.0, moving_roughness=0.0, skin=OXIDE, **INSULATED_RESTING)
    flux = FRICTION * 3.0 * SOLID["nominal_pressure"]
    bare = background.temperature(1.0 / 3.0, heat_flux=flux, **STEEL)
    rise = flux * d / kappa * (1 - (kappa / 30.0) ** 2 * 7.6e-6 / diffusivity)
    assert slid.background - bare == pytest.approx(rise, rel=0.01)


def test_after_long_the_background_lacks_the_resistance_above_the_heat():
    slid = sliding(
        3.0, slid_distance=1.0, moving_roughness=0.0, heat_depth=4e-6, **INSULATED_RESTING
    )
    flux = FRICTION * 3.0 * SOLID["nominal_pressure"]
    bare = background.temperature(1.0 / 3.0, heat_flux=flux, **STEEL)
    assert bare - slid.background == pytest.approx(flux * 4e-6 / 30.0, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"skin": (1e-6, 3.0)}, "skin = "),
        ({"resting_skin": (1e-6, -3.0, 1e-6)}, "conductivity of the skin = -3"),
        ({"heat_depth": -1e-6}, "heat_depth = -1e-06 m"),
    ],
)
def test_bad_layers_are_refused(changes, message):
    with pytest.raises((TypeError, ValueError), match=message):
        sliding(**changes)
