"""Heat: arguments without meaning are refused by name and value with unit."""

from functools import partial
from math import inf, nan

import numpy as np
import pytest
from heat_cases import STEEL, UNIT
from refused_cases import assert_refused

from roughsim import Body, Grid, HeatSource, Skin, half_space_temperature, partition_heat
from roughsim import sliding_temperature as sliding
from roughsim.errors import ConvergenceError
from roughsim.heat import (
    contact_temperature,
    effective_conductivity,
    effective_temperature,
    joint_distribution,
    profiles,
    share_above,
    source_temperature,
    temperature_correlation,
    uniform_temperature,
    wake_profile,
)

GRID, ONES = Grid((8, 8), (1.0, 1.0)), np.ones((8, 8))
SOURCE = {"speeds": [1.0, 2.0], "friction_coefficient": 0.1, **UNIT}
SLIDES = {"heat_flux": np.eye(8), "grid": GRID, "speed": 1.0, **UNIT}
IN_ALL = {
    "speed = nan": {"speed": nan},
    "speed = inf m/s must be finite": {"speed": inf},
    "speed = '1'": {"speed": "1"},
    r"conductivity = -1 W/\(m K\) must be positive": {"conductivity": -1.0},
    r"conductivity = 0 W/\(m K\) must be positive": {"conductivity": 0.0},
    "conductivity = nan": {"conductivity": nan},
    "diffusivity = 0 m²/s must be positive": {"diffusivity": 0.0},
    "diffusivity = nan": {"diffusivity": nan},
    "direction = inf": {"direction": inf},
    "time = -1.0 s must not be negative": {"time": -1.0},
    "time = nan s must not be negative or NaN": {"time": nan},
    "time has dtype": {"time": "now"},
    r"time has shape \(1, 1\)": {"time": [[1.0]]},
    r"time has shape \(0,\)": {"time": []},
    "depth = -1e-09 m must not be negative": {"depth": -1e-9},
    "depth = inf m": {"depth": inf},
    "heat_flux holds .* NaN or infinite": {"heat_flux": np.full((8, 8), nan)},
    r"heat_flux has shape \(8, 9\)": {"heat_flux": np.ones((8, 9))},
    "heat_flux has dtype complex128": {"heat_flux": 1j * np.eye(8)},
}
IN_LAYERS = {
    "skin = .* must be three numbers": {"skin": (1e-6, 3.0)},
    "skin = 'oxide' must be three numbers": {"skin": "oxide"},
    "thickness of the skin = -1e-06 m must be": {"skin": Skin(-1e-6, 3.0, 1e-6)},
    r"conductivity of the skin = 0 W/\(m K\) must be": {"skin": Skin(1e-6, 0.0, 1e-6)},
    "diffusivity of the skin = inf m²/s must be": {"skin": Skin(1e-6, 3.0, inf)},
    "heat_depth = -1e-09 m must not be negative": {"heat_depth": -1e-9},
}
OWN = {
    "slid_distance = -1 m": lambda: sliding(**SLIDES, slid_distance=-1.0),
    "slid_distance = nan": lambda: sliding(**SLIDES, slid_distance=nan),
    "slid_distance = 'far'": lambda: sliding(**SLIDES, slid_distance="far"),
    "both given": lambda: sliding(**SLIDES, time=1.0, slid_distance=1.0),
    "time = inf s must be finite": lambda: uniform_temperature(1.0, inf, **UNIT),
    "heat_flux = -1 W/m² must not be negative": lambda: source_temperature(
        **SLIDES | {"heat_flux": -ONES}
    ),
    "covered has shape": lambda: source_temperature(**SLIDES, covered=np.ones((2, 3))),
    "covered = -1 must not be negative": lambda: source_temperature(**SLIDES, covered=-ONES),
    "time = 0.0 s must be one positive number": lambda: source_temperature(**SLIDES, time=0.0),
    "time = .* must be one positive number": lambda: source_temperature(**SLIDES, time=[1.0, 2.0]),
    "^heat_flux = -1 W/m²": lambda: shared(-ONES),
    "^time = 0.0 s": lambda: shared(ONES, time=0.0),
    "^time = -1.0 s": lambda: shared(ONES, time=-1.0),
    "^conductivity = 0 W/": lambda: Body(0.0, 1.0),
    "^conductivity = nan": lambda: Body(nan, 1.0),
    "^diffusivity = -1 m²/s must be positive": lambda: Body(1.0, -1.0),
    "^diffusivity = nan": lambda: Body(1.0, nan),
    "^speed = inf m/s must be finite": lambda: Body(1.0, 1.0, inf),
    "heat_depth = -1 m must not be negative": lambda: Body(heat_depth=-1.0, **STEEL),
    "diffusivity of the skin = 0 m²/s must be positive": lambda: Body(
        skin=Skin(1e-6, 1.0, 0.0), **STEEL
    ),
    "point = .* outside": lambda: profiles(ONES, GRID, (8, 0)),
    "bins = 0 must be a whole number": lambda: joint_distribution(ONES, ONES, bins=0),
    "bins = 1.5 must be a whole number": lambda: joint_distribution(ONES, ONES, bins=1.5),
    "bins = True must be a whole number": lambda: joint_distribution(ONES, ONES, bins=True),
    "heat_flux = -1": lambda: contact_temperature(ONES, -ONES),
    "conductivity = -1": lambda: effective_conductivity(lambda t: -1.0, lambda k: 1.0),
}
BEYOND = {  # distances in a cell with a diagonal of √2 m and pixels of 1/8 m
    "between 0 and half the diagonal": (
        partial(temperature_correlation, ONES, GRID),
        (-0.1, 0.71, nan),
    ),
    "at least half a pixel, 0.0625 m": (partial(wake_profile, ONES, ONES, GRID), (0.06, nan, inf)),
}


def shared(flux, **options):
    one = Body(conductivity=1.0, diffusivity=1.0)
    return partition_heat(flux, GRID, moving=one, resting=one, **options)


@pytest.mark.parametrize(
    "function", [sliding, half_space_temperature, source_temperature], ids=lambda f: f.__name__
)
@pytest.mark.parametrize("words", IN_ALL)
def test_each_temperature_refuses_its_arguments(function, words):
    assert_refused(lambda: function(**SLIDES | IN_ALL[words]), words)


@pytest.mark.parametrize("function", [sliding, half_space_temperature], ids=lambda f: f.__name__)
@pytest.mark.parametrize("words", IN_LAYERS)
def test_layers_are_refused_by_name(function, words):
    assert_refused(lambda: function(**SLIDES | IN_LAYERS[words]), words)


@pytest.mark.parametrize("words", OWN)
def test_heat_refuses_by_name_and_value(words):
    assert_refused(OWN[words], words)


@pytest.mark.parametrize("words", BEYOND)
def test_distances_beyond_the_field_are_refused(words):
    function, distances = BEYOND[words]
    for distance in distances:
        assert_refused(lambda r=distance: function([0.5, r]), words)


@pytest.mark.parametrize("name", ["conductivity", "diffusivity"])
def test_heat_source_takes_one_number_or_one_a_speed(name):
    assert getattr(HeatSource(**SOURCE | {name: [1.0, 2.0]}), name) == (1.0, 2.0)
    for words, values in {
        rf"{name} has shape \(3,\) for 2 speeds": [1.0, 2.0, 3.0],
        rf"{name} = -1 .* must be positive": [1.0, -1.0],
    }.items():
        assert_refused(lambda v=values: HeatSource(**SOURCE | {name: v}), words)


def test_runaway_has_no_fixed_point():
    for runaway in (
        lambda: effective_temperature(lambda t: 2.0 * t, background_temperature=300.0),
        lambda: effective_conductivity(lambda t: 10.0 if t < 50 else 100.0, lambda k: 2000 / k),
    ):
        with pytest.raises(ConvergenceError, match="no fixed point"):
            runaway()
    assert effective_conductivity(lambda t: 30.0, lambda k: 1e9 / k) == 30.0


@pytest.mark.parametrize(
    "numbers",
    [
        lambda: contact_temperature(ONES, 0 * ONES).flash_temperature,
        lambda: contact_temperature(ONES, 0 * ONES).max_temperature,
        lambda: joint_distribution(ONES, 0 * ONES).share,
        lambda: share_above(ONES, 0 * ONES, 1.0),
    ],
)
def test_no_contact_has_no_temperature(numbers):
    with pytest.warns(RuntimeWarning, match="no contact"):
        assert np.isnan(numbers()).all()


def test_no_heat_has_no_temperature():
    source = SLIDES | {"heat_flux": 0 * ONES}
    assert not half_space_temperature(**source).any()
    with pytest.warns(RuntimeWarning, match="heat_flux = 0 W/m² everywhere"):
        empty = source_temperature(**source)
    with pytest.warns(RuntimeWarning, match="no contact"):
        both = shared(0 * ONES)
    values = [empty.mean_temperature, both.moving_share, both.mean_share]
    values += [each.flash_temperature for each in (empty, both)]
    assert np.isnan([*values, *(each.max_temperature for each in (empty, both))]).all()
    assert not both.temperature.any()
    assert not both.heat_flux.any()
