"""Moments of a contact on a body with a skin, or heated in depth: one wave, products of fields, and the theory."""

from math import pi

import numpy as np
import pytest
from moments_cases import BODY, Pressed, patches, points

from roughsim import Grid, HeatSource, Skin, measure, sliding_temperature
from roughsim.observables.temperatures import flash_temperature_along

OXIDE = Skin(3e-7, 3.0, 9e-7)
GRID = Grid((16, 12), (4e-5, 3e-5))
LAYERS = [{"skin": OXIDE}, {"heat_depth": 5e-7}, {"skin": OXIDE, "heat_depth": 5e-7}]


def steady(pressure, speed, direction=0.0, **layers):
    body = {name: BODY[name] for name in ("conductivity", "diffusivity")}
    flux = 0.11 * abs(speed) * pressure
    with pytest.warns(RuntimeWarning, match="hot track"):
        return sliding_temperature(
            flux, GRID, speed=speed, direction=direction, slid_distance=np.inf, **body, **layers
        )


@pytest.mark.parametrize("layers", LAYERS)
def test_one_wave_has_the_mean_of_its_directions(layers):
    x, _ = points(GRID)
    q = 3 * 2 * pi / 4e-5
    seen = measure(
        Pressed(9e7 + 4e7 * np.cos(q * x)), GRID, HeatSource([2.0, -2.0], **BODY, **layers)
    )
    angles = (np.arange(90) + 0.5) * pi / 90
    along = [
        measure(
            Pressed(9e7 + 4e7 * np.cos(q * x)),
            GRID,
            HeatSource([2.0], direction=a, **BODY, **layers),
        )
        for a in angles
    ]
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        mean = np.mean([getattr(one, name)[0] for one in along])
        np.testing.assert_allclose(getattr(seen, name), mean, rtol=1e-12)


@pytest.mark.parametrize("layers", LAYERS)
def test_a_grid_of_odd_numbers_of_points_sees_the_same_wave(layers):
    # no wave of such a grid lacks a derivative along an axis
    found = []
    for grid in (GRID, Grid((15, 11), GRID.lengths)):
        x, _ = points(grid)
        wave = Pressed(9e7 + 4e7 * np.cos(3 * 2 * pi / 4e-5 * x))
        found.append(measure(wave, grid, HeatSource([2.0], **BODY, **layers)).flash_temperature)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-12)


@pytest.mark.parametrize("layers", LAYERS)
def test_one_direction_has_the_products_of_its_field(layers):
    pressure = patches(GRID) * 1e9
    source = HeatSource([2.0], direction=0.7, **BODY, **layers)
    field = steady(pressure, 2.0, 0.7, **layers)
    product = np.mean(field * pressure) / pressure.mean()
    assert measure(Pressed(pressure), GRID, source).flash_temperature[0] == pytest.approx(
        product, rel=1e-12
    )
    young = flash_temperature_along(pressure, GRID, source, 0.7, slid_distance=1.0)
    assert young == pytest.approx(product, rel=1e-9)


@pytest.mark.parametrize("layers", LAYERS)
def test_layers_are_of_each_body_of_a_table(layers):
    # κ and D of two speeds: as two sources
    pressure = Pressed(patches(GRID) * 1e9)
    bodies = {
        "friction_coefficient": 0.11,
        "conductivity": [30.0, 46.0],
        "diffusivity": [7.6e-6, 1.2e-5],
    }
    both = measure(pressure, GRID, HeatSource([1.0, 5.0], **bodies, **layers)).flash_temperature
    for k, speed in enumerate((1.0, 5.0)):
        one = {
            name: np.atleast_1d(value)[k if np.ndim(value) else 0] for name, value in bodies.items()
        }
        alone = measure(pressure, GRID, HeatSource([speed], **one, **layers)).flash_temperature[0]
        assert both[k] == pytest.approx(alone, rel=1e-14)


def test_a_skin_of_the_same_material_changes_no_moment():
    pressure, skin = (
        Pressed(patches(GRID) * 1e9),
        Skin(1e-6, BODY["conductivity"], BODY["diffusivity"]),
    )
    speeds = [0.0, 1e-3, 35.0]
    layered, bare = (
        measure(pressure, GRID, HeatSource(speeds, **BODY, skin=layer)) for layer in (skin, None)
    )
    for name in (
        "flash_temperature",
        "flash_gradient",
        "flash_laplacian",
        "resting_flash_temperature",
    ):
        np.testing.assert_allclose(getattr(layered, name), getattr(bare, name), rtol=1e-11)


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        ({"skin": (1.0, 2.0)}, "skin = .* must be three numbers"),
        ({"skin": Skin(0.0, 3.0, 1e-6)}, "thickness of the skin = 0 m must be positive"),
        ({"heat_depth": -1.0}, "heat_depth = -1 m must not be negative"),
    ],
)
def test_bad_layers_are_refused(layers, message):
    with pytest.raises((TypeError, ValueError), match=message):
        HeatSource([1.0], **BODY, **layers)
