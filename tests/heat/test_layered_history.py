"""The memory of a body with a skin, or heated in depth: finite volumes in depth, closed forms, and limits."""

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from depth_cases import decaying_modes
from some_rows import some

from roughsim import Grid
from roughsim.heat.history import KERNEL_ERROR, History
from roughsim.heat.layered_history import layered_kernel, uniform_rise
from roughsim.heat.skin import Layering

KAPPA, D = 30.0, 7.6e-6
GRID = Grid((8, 8), (4e-5, 4e-5))
MODES = ((1, 0), (2, 1), (4, 3))
STEP, STEPS = 2e-6, 60  # heat spreads 4 µm in a step, 30 µm in all
LAYERS = {  # d, κ_s/κ, D/D_s and h
    "oxide": (2e-6, 0.1, 9.0, 0.0),
    "thick oxide": (2e-5, 0.1, 9.0, 0.0),
    "silver": (5e-6, 10.0, 0.1, 0.0),
    "oxide, heated in depth": (4e-6, 0.1, 9.0, 6e-6),
    "heated in depth": (0.0, 1.0, 1.0, 1e-5),
}


def warmed(flux, layers, step=STEP, kappa=KAPPA, diffusivity=D):
    """Temperatures at the ends of all steps, by a flux at all ends, (steps + 1, *half_shape)."""
    history = History(GRID, kappa, diffusivity, step, len(flux) - 1, flux[0], layers)
    temperatures = []
    for new in flux[1:]:
        temperatures.append(history.known() + history.response * new)
        history.advance(new)
    return np.array(temperatures)


def random_flux(steps=STEPS):
    rng = np.random.default_rng(5)
    return rng.standard_normal((steps + 1, *GRID.half_shape)) + 0j


def by_finite_volumes(flux, q, layers, nodes):
    """The surface temperature of one wave by a flux linear between steps, by finite volumes in depth, exact in time."""
    deep = 7 * sqrt(D * STEP * (len(flux) - 1)) + 40 * layers[-1]
    rates, seen, excited = decaying_modes(q, layers, deep, nodes)
    x = np.maximum(rates * D * STEP, 1e-6)
    fall = np.exp(-x)
    mean = -np.expm1(-x) / x
    late, early = (1 - mean) / x, (mean - fall) / x
    amplitude = np.zeros(rates.size)
    surface = []
    for old, new in pairwise(flux):
        amplitude = fall * amplitude + D * STEP * (late * new + early * old) * excited
        surface.append(seen @ amplitude)
    return np.array(surface) / KAPPA


@pytest.mark.parametrize(
    "layers",
    [
        pytest.param(v, id=k, marks=[pytest.mark.slow] if k in ("thick oxide", "oxide") else [])
        for k, v in LAYERS.items()
    ],
)
def test_waves_and_the_mean_are_those_of_finite_volumes_in_depth(layers):
    flux = random_flux()
    temperatures = warmed(flux, Layering(*layers))
    for mode in ((0, 0), *MODES):
        q = 2 * pi / 4e-5 * np.hypot(*mode)
        coarse, fine = (
            by_finite_volumes(flux[(slice(None), *mode)].real, q, layers, nodes)
            for nodes in (250, 500)
        )
        expected = fine + (fine - coarse) / 3
        got = temperatures[(slice(None), *mode)]
        assert np.abs(got.imag).max() == 0.0
        assert np.abs(got.real - expected).max() < 3e-4 * np.abs(expected).max(), mode


@pytest.mark.parametrize("thickness", some([1e-9, 3e-6, 1e-3], 2))
@pytest.mark.parametrize("steps", [1, 2, 16, 17, 300])
def test_a_skin_of_the_same_material_is_no_skin(thickness, steps):
    flux = random_flux(steps)
    bare, layered = warmed(flux, None), warmed(flux, Layering(thickness, 1.0, 1.0, 0.0))
    assert np.abs(layered - bare).max() < 2 * KERNEL_ERROR * np.abs(bare).max()
    assert np.abs(layered - bare)[:, 0, 0].max() < 1e-9 * np.abs(bare).max()


def test_a_thick_skin_is_the_whole_body():
    flux = random_flux()
    whole = warmed(flux, None, kappa=3.0, diffusivity=9e-7)
    skin = warmed(flux, Layering(1e-3, 0.1, D / 9e-7, 0.0))
    assert np.abs(skin - whole).max() < 2 * KERNEL_ERROR * np.abs(whole).max()


@pytest.mark.parametrize(
    "small", [(1e-8, 0.1, 9.0, 0.0), (2e-9, 10.0, 0.1, 0.0), (0.0, 1.0, 1.0, 1e-8)]
)
def test_thin_layers_fade_in_proportion_to_their_depth(small):
    flux = random_flux()
    bare = warmed(flux, None)[:, 1:3]
    d, k, ratio, h = small
    changes = [
        np.abs(warmed(flux, Layering(n * d, k, ratio, n * h))[:, 1:3] - bare).max() for n in (2, 1)
    ]
    assert changes[0] / changes[1] == pytest.approx(2.0, abs=0.05)
    assert changes[1] < 0.06 * np.abs(bare).max()


@pytest.mark.parametrize("layers", LAYERS.values(), ids=LAYERS)
def test_after_long_the_mean_has_risen_by_the_resistance_less_what_the_layers_store(layers):
    # heat at the surface: (d/κ_s)(1 − (e_s/e)²); in depth, less (h/κ_s)(1 − e^(−d/h)) + (h/κ)e^(−d/h)
    d, k, ratio, h = layers
    rise = d / k * (1 - k**2 * ratio)
    if h:
        rise -= h / k * -np.expm1(-d / h) + h * np.exp(-d / h)
    errors = []
    for spread in (1e-6, 4e-6):  # D t, m²
        steps = 400
        temperatures = warmed(
            np.ones((steps + 1, *GRID.half_shape)) + 0j, Layering(*layers), step=spread / D / steps
        )
        errors.append(KAPPA * temperatures[-1, 0, 0].real - 2 * sqrt(spread / pi) - rise)
        assert uniform_rise(spread, Layering(*layers)) - 2 * sqrt(spread / pi) == pytest.approx(
            errors[-1] + rise, rel=1e-6
        )
    # what is left falls as 1/√t
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)
    assert abs(errors[1]) < 0.03 * abs(rise)


def test_each_weight_of_the_mean_is_that_of_the_images():
    # a skin of the same diffusivity: one image for each pass through it
    k, d, steps = 0.25, 3e-6, 400
    echo = (k - 1) / (k + 1)
    kernel = layered_kernel(GRID, D, Layering(d, k, 1.0, 0.0), STEP, steps)

    def pulse(time):
        images = sum(echo**n * np.exp(-((n * d) ** 2) / (D * time)) for n in range(1, 60))
        return np.sqrt(D * STEP / pi) * (1 + 2 * images) / k

    nodes, weights = np.polynomial.legendre.leggauss(80)

    def integral(low, high, hat):
        w = sqrt(low) + (sqrt(high) - sqrt(low)) * (1 + nodes) / 2
        return (sqrt(high) - sqrt(low)) * weights @ (hat(w**2) * pulse(STEP * w**2))

    for m in (1, 2, 15, 16, 17, 18, 200, 400):
        falling = integral(m - 1, m, lambda u, m=m: 1 - (m - u))
        rising = integral(m, m + 1, lambda u, m=m: 1 - (u - m))
        assert kernel.mean_weights[m] == pytest.approx(falling + rising, rel=1e-7)
        assert kernel.first_weights[m] == pytest.approx(falling, rel=1e-7)


@pytest.mark.parametrize("layers", some(LAYERS.values(), 2, pairs=True), ids=LAYERS)
@pytest.mark.parametrize("decay", [1e-4, 0.1, 10.0])
def test_the_weights_of_the_steps_have_a_positive_real_part_at_every_frequency(layers, decay):
    # else a share that changes from step to step could grow without bound
    steps, mode = 400, (1, 0)
    step = decay / (D * (2 * pi / 4e-5) ** 2)
    pulse = np.zeros((steps + 1, *GRID.half_shape), complex)
    pulse[1] = 1.0
    weights = warmed(pulse, Layering(*layers), step=step)[(slice(None), *mode)].real
    angles = np.linspace(0, pi, 401)[1:]
    real = np.cos(np.outer(angles, np.arange(steps))) @ weights
    cut = abs(weights[-1]) / np.sin(angles / 2)
    assert (real + cut > 0).all()
