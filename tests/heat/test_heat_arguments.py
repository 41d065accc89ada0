"""Numbers in, numbers out: precision and transforms."""

import numpy as np
import pytest
from heat_cases import UNIT, close

from roughsim import Grid, half_space_temperature, sliding_temperature
from roughsim.fourier import Transform, convolution


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
