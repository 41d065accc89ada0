"""A run whose faces slide: its exported file and its estimates on disk have the column sliding."""

import h5py
import numpy as np
import pytest

from roughsim.results.export import export_run


@pytest.mark.slow
def test_an_export_has_the_column_sliding_and_the_numbers_of_the_slides(sliding_run, tmp_path):
    run, slide = sliding_run, sliding_run.numerics.slide
    with h5py.File(export_run(run, tmp_path / "sliding.h5")) as file:
        results = file["results"]
        place = list(results["column"].asstr()).index("sliding")
        estimate = run.estimate("flash_temperature", "sliding")
        np.testing.assert_array_equal(results["flash_temperature"][place], estimate.mean)
        np.testing.assert_array_equal(
            results["flash_temperature_total_error"][place], estimate.total_error
        )
        assert np.isnan(results["slope_length"][place]).all()  # a slide does not measure it
        for index in range(run.counts[slide]):
            numbers = run.members[slide, index].numbers
            np.testing.assert_array_equal(
                file["members/sliding_share"][slide, index], numbers["sliding_share"]
            )
        assert "- sliding: simulated contact of two rough faces" in file.attrs["README"]
