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


def slid(*temperatures):
    """The numbers that slides store: T_flash of sliding and frozen contact, then both with the larger pixel, K."""
    names = "", "frozen_", "coarser_", "coarser_frozen_"
    return dict(zip((f"sliding_{name}flash_temperature" for name in names), temperatures, strict=True))


def test_the_scatter_of_the_ratio_and_of_the_frozen_estimate_add_as_squares():
    ratios = 1.1 + 0.1 * np.tile([-1.0, 1.0], 20)
    alone = np.full((40, 1), 100.0)
    numbers = slid(alone * ratios[:, None], alone, alone * ratios[:, None], alone)
    found = sliding_estimate("flash_temperature", frozen(), numbers, 4 / 3)
    error = 0.1 / sqrt(39)
    half = stats.t.ppf(0.975, 39) * error
    assert found.mean == pytest.approx([220.0])
    assert found.bias == pytest.approx([3.3])
    assert found.standard_error == pytest.approx([hypot(2.0 * 1.1, 200.0 * error)])
    assert found.budget["statistical"] == pytest.approx([hypot(4.0 * 1.1, 200.0 * half)], rel=0.02)
    assert found.budget["size"] == pytest.approx([1.1])
    assert found.budget["slide"] == pytest.approx([0.03 * 220.0])  # of the cut-off; the pixel changed nothing


@pytest.mark.parametrize("order", [1.0, 1.25, 1.5])
def test_the_error_of_the_pixel_is_taken_off_and_what_its_order_leaves_is_in_the_error(order):
    # ratios 1.2 − 0.05 h^order at pixels h = 1 and 4/3, and 1.2 without a pixel
    alone = np.full((8, 1), 100.0)
    fine, coarse = (1.2 - 0.05 * h**order for h in (1.0, 4 / 3))
    found = sliding_estimate("flash_temperature", frozen(), slid(alone * fine, alone, alone * coarse, alone), 4 / 3)
    without_cut_off = sqrt(found.budget["slide"][0] ** 2 - (0.03 * 200.0 * fine) ** 2)
    assert 200.0 * fine < 0.99 * found.mean[0]
    assert abs(found.mean[0] - 200.0 * 1.2) <= without_cut_off * (1 + 1e-9)
    assert without_cut_off < 0.4 * (200.0 * (1.2 - fine))
    assert f"{100 * (found.mean[0] / 200.0 / fine - 1):+.2g}" in found.notes[-1]


@pytest.mark.parametrize("change", [0.02, -0.02])
def test_what_the_orders_leave_open_is_half_of_their_difference(change):
    # between the orders 1 and 1.5 the change from 4/3 of the pixel leaves 3 times itself to 1/((4/3)^1.5 − 1) times
    alone = np.full((8, 1), 100.0)
    numbers = slid(1.1 * alone, alone, (1.1 - change) * alone, alone)
    found = sliding_estimate("flash_temperature", frozen(), numbers, 4 / 3)
    most, least = 3.0, 1.0 / ((4 / 3) ** 1.5 - 1.0)
    assert found.mean == pytest.approx([200.0 * (1.1 + 0.5 * (most + least) * change)])
    of_orders = 0.5 * (most - least) * 0.02
    assert found.budget["slide"] == pytest.approx([200.0 * hypot(of_orders, 0.03 * 1.1)])


def test_the_share_of_the_heat_is_that_of_the_members():
    shares = 0.7 + 0.02 * np.tile([-1.0, 1.0], 20)[:, None]
    found = sliding_estimate("heat_partition", frozen(), {"sliding_share": shares})
    error = 0.02 / sqrt(39)
    assert found.mean == pytest.approx([0.7])
    assert found.standard_error == pytest.approx([error])
    assert found.budget["statistical"] == pytest.approx([stats.t.ppf(0.975, 39) * error * sqrt(1 + 2 / 39)])
    assert found.budget["slide"] == pytest.approx([0.03 * 0.7])
    assert list(found.budget) == ["statistical", "slide"]
    assert found.bias == pytest.approx([0.0])
    assert (found.n, found.effective_n[0]) == (40, 40.0)


def test_the_area_is_that_of_single_contacts_and_other_observables_are_refused():
    single = frozen()
    assert sliding_estimate("contact_fraction", single, {}) is single
    with pytest.raises(ValueError, match="flash_gradient"):
        sliding_estimate("flash_gradient", frozen(), {})


def test_members_share_the_scatter_of_both_pixels():
    # each member has the same difference between its pixels, so that the correction scatters by nothing
    ratios = 1.1 + 0.1 * np.tile([-1.0, 1.0], 20)[:, None]
    alone = np.full((40, 1), 100.0)
    found = sliding_estimate(
        "flash_temperature", frozen(), slid(alone * ratios, alone, alone * (ratios - 0.01), alone), 4 / 3
    )
    change = found.mean[0] / 200.0
    assert found.standard_error == pytest.approx([hypot(2.0 * change, 200.0 * 0.1 / sqrt(39))])


def test_without_a_coarser_grid_the_error_of_the_slide_is_unknown():
    alone = np.full((8, 1), 100.0)
    found = sliding_estimate("flash_temperature", frozen(), slid(1.1 * alone, alone, alone, alone), 1.0)
    assert found.mean == pytest.approx([220.0])
    assert found.unknown == ("slide",)
    assert found.notes[-1] == "the slide is not corrected for its pixel, as there is no coarser grid"


def test_the_background_adds_with_its_scatter_and_the_doubt_of_its_share():
    flash = frozen()
    flash.budget["slide"] = np.array([12.0])
    rows = 300.0 + 3.0 * np.tile([-1.0, 1.0], 20)[:, None]
    found = with_background(flash, rows)
    error = 3.0 / sqrt(39)
    assert found.mean == pytest.approx([500.0])
    assert found.bias == pytest.approx([3.0])
    assert found.standard_error == pytest.approx([hypot(2.0, error)])
    assert found.budget["statistical"] == pytest.approx([hypot(4.0, stats.t.ppf(0.975, 39) * error)], rel=0.01)
    assert found.budget["size"] == pytest.approx([1.0])
    assert found.budget["slide"] == pytest.approx([12.0 + 0.03 * 300.0])
