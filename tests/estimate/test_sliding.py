"""Estimates of two bodies that slide: the frozen estimate times a paired ratio, with both of their errors."""

from math import hypot, sqrt

import numpy as np
import pytest
from scipy import stats

from roughsim.estimate.errors import Estimate
from roughsim.estimate.sliding import sliding_estimate, with_background


def frozen():
    """T_flash of 200 K, ± 4 K statistical and 1 K of the cell."""
    return Estimate(
        mean=np.array([200.0]),
        standard_error=np.array([2.0]),
        budget={"statistical": np.array([4.0]), "size": np.array([1.0])},
        observable="flash_temperature",
        unit="K",
        bias=np.array([3.0]),
        n=12,
        effective_n=np.array([12.0]),
    )


def test_the_scatter_of_the_ratio_and_of_the_frozen_estimate_add_as_squares():
    ratios = 1.1 + 0.1 * np.tile([-1.0, 1.0], 20)
    alone = np.full((40, 1), 100.0)
    numbers = {
        "sliding_flash_temperature": alone * ratios[:, None],
        "sliding_frozen_flash_temperature": alone,
    }
    found = sliding_estimate("flash_temperature", frozen(), numbers)
    error = 0.1 / sqrt(39)
    half = stats.t.ppf(0.975, 39) * error
    assert found.mean == pytest.approx([220.0])
    assert found.bias == pytest.approx([3.3])
    assert found.standard_error == pytest.approx([hypot(2.0 * 1.1, 200.0 * error)])
    assert found.budget["statistical"] == pytest.approx([hypot(4.0 * 1.1, 200.0 * half)], rel=0.02)
    assert found.budget["size"] == pytest.approx([1.1])
    assert found.budget["march"] == pytest.approx([0.06 * 220.0])


def test_the_background_adds_with_its_scatter_and_the_doubt_of_its_share():
    flash = frozen()
    flash.budget["march"] = np.array([12.0])
    rows = 300.0 + 3.0 * np.tile([-1.0, 1.0], 20)[:, None]
    found = with_background(flash, rows)
    error = 3.0 / sqrt(39)
    assert found.mean == pytest.approx([500.0])
    assert found.bias == pytest.approx([3.0])
    assert found.standard_error == pytest.approx([hypot(2.0, error)])
    assert found.budget["statistical"] == pytest.approx([hypot(4.0, stats.t.ppf(0.975, 39) * error)], rel=0.01)
    assert found.budget["size"] == pytest.approx([1.0])
    assert found.budget["march"] == pytest.approx([12.0 + 0.02 * 300.0])
