"""Numbers in, numbers out: precision, transforms, and what is refused by name."""

from math import inf, nan

import numpy as np
import pytest
from heat_cases import UNIT, close

from roughsim import Grid, half_space_temperature, sliding_temperature
from roughsim.fourier import Transform, convolution
from roughsim.heat import uniform_temperature


@pytest.mark.parametrize("options", [{}, {"time": [0.001, 0.1]}, {"depth": 0.01}])
def test_single_precision_stays_single(options):
    grid = Grid((32, 30), (1.0, 1.0))
    flux = np.random.default_rng(10).random(grid.shape)
    single = sliding_temperature(flux.astype(np.float32), grid, speed=30.0, **options, **UNIT)
    assert single.dtype == np.float32
    close(single, sliding_temperature(flux, grid, speed=30.0, **options, **UNIT), 2e-6)


@pytest.mark.parametrize("temperature", [sliding_temperature, half_space_temperature])
def test_a_series_of_times_takes_one_forward_transform_and_one_inverse_each(calls, temperature):
    steps = (
        (convolution, "transformed_rows"),
        (convolution, "transformed_columns"),
        (Transform, "inverse"),
    )
    made = [calls(*step) for step in steps]
    grid, times = Grid((8, 8), (1.0, 1.0)), [0.1, 0.2, 0.0, 0.3]
    fields = temperature(np.eye(8), grid, speed=1.0, time=times, **UNIT)
    assert [len(one) for one in made] == [1, 1, 3]
    for time, field in zip(times, fields, strict=True):
        np.testing.assert_array_equal(
            field, temperature(np.eye(8), grid, speed=1.0, time=time, **UNIT)
        )


def test_the_flux_is_left_alone():
    flux = np.random.default_rng(11).random((8, 8))
    kept = flux.copy()
    flux.flags.writeable = False
    sliding_temperature(flux, Grid((8, 8), (1.0, 1.0)), speed=1.0, **UNIT)
    np.testing.assert_array_equal(flux, kept)


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
    ("name", "value"),
    [("heat_flux", 1j * np.eye(8)), ("speed", "1"), ("time", "1"), ("slid_distance", "far")],
)
def test_what_is_not_a_number_is_refused_by_name(name, value):
    arguments = {"heat_flux": np.eye(8), "speed": 1.0, **UNIT} | {name: value}
    with pytest.raises(TypeError, match=name):
        sliding_temperature(grid=Grid((8, 8), (1.0, 1.0)), **arguments)


def test_time_and_distance_together_are_refused():
    with pytest.raises(ValueError, match="both given"):
        sliding_temperature(
            np.eye(8), Grid((8, 8), (1.0, 1.0)), speed=1.0, time=1.0, slid_distance=1.0, **UNIT
        )


def test_an_endless_uniform_source_is_refused():
    with pytest.raises(ValueError, match="time = inf s must be finite"):
        uniform_temperature(1.0, inf, **UNIT)
