"""Estimates of two bodies that slide: the frozen estimate times a paired ratio, with both of their errors."""

from dataclasses import replace
from math import hypot, sqrt

import numpy as np
import pytest
from ladder_cases import lowest
from scipy import stats

from roughsim.estimate.contacts import Contacts
from roughsim.estimate.errors import spread_of
from roughsim.estimate.mean import Mean
from roughsim.estimate.reactions import (
    BOLTZMANN,
    Activation,
    ContactMean,
    mean_over_contact,
)
from roughsim.estimate.sliding import (
    sliding_estimate,
    sliding_flash,
    sliding_quantile,
    stretch_of,
    stretched,
    warmed,
    with_background,
)
from roughsim.observables.distribution import BIN_AREAS, Bins
from roughsim.prediction.sliding import SlidingContinuation
from roughsim.table import Estimate


def frozen():
    """T_flash of 200 K, ± 4 K statistical and 1 K of the cell."""
    budget = {"statistical": np.array([4.0]), "size": np.array([1.0])}
    exact = Estimate.of("flash_temperature", "K", [200.0], {"speed": np.array([35.0])}, budget)
    return replace(
        exact,
        standard_error=np.array([2.0]),
        bias=np.array([3.0]),
        n=12,
        effective_n=np.array([12.0]),
    )


# the share of a slide, 1/2, with 3 % of it in doubt by the slide and 2 % by the cell
SHARE = replace(
    frozen(),
    mean=np.array([0.5]),
    budget={"statistical": np.array([9.0]), "slide": np.array([0.015]), "size": np.array([0.01])},
)


def slid(*temperatures):
    """The numbers that slides store: T_flash of sliding and frozen contact, then both with the larger pixel, K."""
    names = "", "frozen_", "coarser_", "coarser_frozen_"
    return dict(
        zip((f"sliding_{name}flash_temperature" for name in names), temperatures, strict=True)
    )


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
    assert found.budget["slide"] == pytest.approx(
        [0.03 * 220.0]
    )  # of the cut-off; the pixel changed nothing


@pytest.mark.parametrize("order", [1.0, 1.25, 1.5])
def test_the_error_of_the_pixel_is_taken_off_and_what_its_order_leaves_is_in_the_error(order):
    # ratios 1.2 − 0.05 h^order at pixels h = 1 and 4/3, and 1.2 without a pixel
    alone = np.full((8, 1), 100.0)
    fine, coarse = (1.2 - 0.05 * h**order for h in (1.0, 4 / 3))
    found = sliding_estimate(
        "flash_temperature", frozen(), slid(alone * fine, alone, alone * coarse, alone), 4 / 3
    )
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
    assert found.budget["statistical"] == pytest.approx(
        [stats.t.ppf(0.975, 39) * error * sqrt(1 + 2 / 39)]
    )
    assert found.budget["slide"] == pytest.approx([0.03 * 0.7])
    assert list(found.budget) == ["statistical", "slide", "size"]
    assert found.budget["size"] == pytest.approx([0.7 / 200.0])  # 1 K of 200 K
    assert found.bias == pytest.approx([0.0])
    assert (found.n, found.effective_n[0]) == (40, 40.0)


TO_THE_END = SlidingContinuation(
    np.array([1.2]), np.array([0.9]), np.array([2.0]), np.array([0.04])
)


def test_a_slide_that_is_followed_in_part_is_continued_with_the_error_of_that():
    alone = np.full((8, 1), 100.0)
    numbers = slid(1.1 * alone, alone, 1.08 * alone, alone) | {"sliding_share": 0.5 * alone / 100.0}
    short = sliding_estimate("flash_temperature", frozen(), numbers, 4 / 3)
    found = sliding_estimate("flash_temperature", frozen(), numbers, 4 / 3, TO_THE_END)
    assert found.mean == pytest.approx(1.2 * short.mean)
    assert found.budget["size"] == pytest.approx(1.2 * short.budget["size"])
    assert found.budget["slide"] == pytest.approx(
        np.hypot(1.2 * short.budget["slide"], 0.04 * 1.2 * 220.0)
    )
    share = sliding_estimate("heat_partition", frozen(), numbers, 4 / 3, TO_THE_END)
    assert share.mean == pytest.approx([0.45])
    assert share.budget["slide"] == pytest.approx([0.45 * hypot(0.03, 0.04)])
    flash = frozen()
    flash.budget["slide"] = np.array([12.0])
    warm = with_background(flash, 300.0 * alone / 100.0, share, TO_THE_END)
    assert warm.mean == pytest.approx([200.0 + 600.0])
    assert warm.budget["slide"] == pytest.approx([12.0 + 600.0 * hypot(0.03, 0.04)])
    for estimate in (found, share):
        assert any(
            "T_flash by the factors 1.2 … 1.2, with an error of 4 %" in note
            for note in estimate.notes
        )


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
        "flash_temperature",
        frozen(),
        slid(alone * ratios, alone, alone * (ratios - 0.01), alone),
        4 / 3,
    )
    change = found.mean[0] / 200.0
    assert found.standard_error == pytest.approx([hypot(2.0 * change, 200.0 * 0.1 / sqrt(39))])


def test_without_a_coarser_grid_the_error_of_the_slide_is_unknown():
    alone = np.full((8, 1), 100.0)
    found = sliding_estimate(
        "flash_temperature", frozen(), slid(1.1 * alone, alone, alone, alone), 1.0
    )
    assert found.mean == pytest.approx([220.0])
    assert found.unknown == ("slide",)
    assert (
        found.notes[-1] == "the slide is not corrected for its pixel, as there is no coarser grid"
    )


def test_the_background_adds_with_its_scatter_and_the_doubt_of_its_share():
    flash = frozen()
    flash.budget["slide"] = np.array([12.0])
    rows = 300.0 + 3.0 * np.tile([-1.0, 1.0], 20)[:, None]
    found = with_background(flash, rows, SHARE)
    error = 3.0 / sqrt(39)
    assert found.mean == pytest.approx([500.0])
    assert found.bias == pytest.approx([3.0])
    assert found.standard_error == pytest.approx([hypot(2.0, error)])
    assert found.budget["statistical"] == pytest.approx(
        [hypot(4.0, stats.t.ppf(0.975, 39) * error)], rel=0.01
    )
    assert found.budget["size"] == pytest.approx([1.0 + 0.02 * 300.0])
    assert found.budget["slide"] == pytest.approx([12.0 + 0.03 * 300.0])


def values(mean, rows, error=0.0):
    """Values of one speed with the scatter of stream 0."""
    errors = {"bandwidth": np.array([error]), "pixel": np.zeros(1), "last step": np.zeros(1)}
    return Mean(np.array([mean]), np.array([mean - 3.0]), {0: rows[:, None]}, errors, "so")


def test_values_of_the_slide_have_the_mean_and_the_scatter_of_its_estimate():
    rng = np.random.default_rng(3)
    ratios, single = 1.1 + 0.1 * rng.standard_normal((40, 1)), 0.5 * np.tile([-1.0, 1.0], 6)
    alone = np.full((40, 1), 100.0)
    numbers = slid(alone * ratios, alone, alone * (ratios - 0.01), alone)
    found = sliding_flash(values(200.0, single, 4.0), numbers, 4 / 3, 7)
    expected = sliding_estimate("flash_temperature", frozen(), numbers, 4 / 3)
    assert found.value == pytest.approx(expected.mean)
    assert found.errors["slide"] == pytest.approx(expected.budget["slide"])
    change = expected.mean[0] / 200.0
    assert found.errors["bandwidth"] == pytest.approx([4.0 * change])
    assert found.finest == pytest.approx([197.0 * change])
    assert {*found.influence} == {0, 7}
    own = np.std(ratios, ddof=1) / sqrt(40)
    of_single = sqrt(12 / 11 * np.sum((single * change) ** 2))
    assert spread_of(found)[0] == pytest.approx([hypot(of_single, 200.0 * own)])


def test_a_quantile_is_its_ratio_to_t_flash_widened_as_the_frozen_distribution():
    flash = values(200.0, np.zeros(12))
    flash = replace(flash, errors={"bandwidth": np.array([8.0]), "slide": np.array([6.0])})
    hot = 220.0 + 20.0 * np.tile([-1.0, 1.0], 20)[:, None]
    slides = lowest(np.full((40, 1), 110.0), name="sliding_flash_temperature", stream=7)
    plain = sliding_quantile(flash, hot, slides, np.ones(1))
    assert plain.value == pytest.approx([400.0])
    assert plain.errors["bandwidth"] == pytest.approx([16.0])
    assert plain.errors["slide"] == pytest.approx([hypot(12.0, 200.0 * 0.03 * 2.0)])
    assert spread_of(plain)[0] == pytest.approx([200.0 / 110.0 * 20.0 / sqrt(39)])
    wide = sliding_quantile(flash, hot, slides, np.array([1.2]))
    assert wide.value == pytest.approx([200.0 * 2.2])  # 1 + 1.2 (2 − 1)
    assert wide.errors["slide"] == pytest.approx(
        [hypot(6.0 * 2.2, 200.0 * 0.03 * 2.2, 200.0 * 0.2)]
    )
    assert spread_of(wide)[0] == pytest.approx(1.2 * spread_of(plain)[0])
    cold = sliding_quantile(flash, np.full((40, 1), 11.0), slides, np.ones(1))
    assert cold.value == pytest.approx([20.0])
    assert cold.errors["slide"] == pytest.approx(
        [hypot(0.6, 200.0 * 0.03)]
    )  # of T_flash, as it is larger


def contacts(temperature, flash=100.0, members=6):
    """A sample of slides whose contacts are alike, with their bins at these temperatures, K."""
    pair = lowest(np.full((members, 1), flash))
    ones = np.ones((members, 1, BIN_AREAS.size))
    object.__setattr__(pair, "bins", Bins(temperature * ones, 1e9 * ones, 0.0 * ones, 0.0 * ones))
    return pair


def mean_over_slides(slides, stretch, of_level):
    """The mean over these slides, whose temperatures about T_flash grow by a factor."""
    samples = [stretched(slides, np.array([stretch]))]
    flash, stretch = of_level.flash, np.array([stretch])
    column = Contacts(samples, flash, flash, np.zeros(1), (1.0,), stretch=stretch)
    return mean_over_contact(column, of_level)


def test_bins_widen_about_t_flash():
    found = stretched(contacts(np.linspace(60.0, 250.0, BIN_AREAS.size)), np.array([1.5]))
    assert found.bins.temperature[3, 0, [0, -1]] == pytest.approx([40.0, 325.0])
    assert (found.bins.pressure == 1e9).all()


def test_the_growth_of_the_frozen_distribution_is_read_off_its_hot_quantile():
    hot, flash = values(190.0, np.zeros(6)), values(70.0, np.zeros(6))
    # over T_flash 2.5 at the lowest level, and 190/70 at the end
    found = stretch_of(flash, hot, np.array([2.5]))
    assert found == pytest.approx([(190.0 / 70.0 - 1.0) / 1.5])
    assert stretch_of(flash, hot, np.ones(1)) == 1.0  # nothing to widen


def test_contacts_of_one_temperature_react_as_at_t_flash_of_the_slide():
    pair, flash = contacts(100.0), values(150.0, np.zeros(6))
    flash = replace(flash, errors={"bandwidth": np.array([2.0]), "slide": np.array([6.0])})
    activation = Activation(1.6e-19, 0.0, np.array([500.0]))
    scale = activation.log_scale(pair.bins, np.ones(1))
    of_level = ContactMean(activation._replace(scale=scale).rates, flash)
    found = mean_over_slides(pair, 1.4, of_level)
    b = 1.6e-19 / (BOLTZMANN * 650.0)
    assert found.value == pytest.approx(np.exp(-b - scale), rel=1e-9)
    slope = np.exp(-b - scale) * b * 150.0 / 650.0  # d rate/d ln T_flash
    assert found.errors["bandwidth"] == pytest.approx(slope * 2.0 / 150.0, rel=1e-4)
    assert found.errors["slide"] == pytest.approx(slope * hypot(6.0 / 150.0, 0.03), rel=1e-4)


def test_the_change_by_a_wider_distribution_counts_as_an_error():
    pair, flash = contacts(np.linspace(20.0, 180.0, BIN_AREAS.size)), values(100.0, np.zeros(6))
    flash = replace(flash, errors={"slide": np.zeros(1)})
    of_level = ContactMean(
        lambda bins, factor: bins.temperature * factor[:, None] + bins.temperature**2, flash
    )
    found = mean_over_slides(pair, 1.1, of_level)
    t = np.linspace(20.0, 180.0, BIN_AREAS.size)
    narrow, wide = ((x + x**2) @ BIN_AREAS for x in (t, 100.0 + 1.1 * (t - 100.0)))
    assert found.value == pytest.approx([wide])
    assert found.finest == pytest.approx([narrow])
    slope = (100.0 + 1.1 * (t - 100.0)) @ BIN_AREAS  # the factor is in the linear term alone
    assert found.errors["slide"] == pytest.approx([hypot(0.03 * slope, wide - narrow)], rel=1e-4)


def test_the_error_of_the_background_joins_that_of_t_flash():
    flash = replace(values(100.0, np.zeros(6)), errors={"slide": np.array([5.0])})
    both = replace(flash, errors={**flash.errors, "size": np.array([0.5])})
    found = warmed(both, np.array([200.0]), SHARE)
    assert found.errors["slide"] == pytest.approx([5.0 + 0.03 * 200.0])
    assert found.errors["size"] == pytest.approx([0.5 + 0.02 * 200.0])
    undefined = replace(
        SHARE, mean=np.full(1, np.nan)
    )  # a body that does not conduct: its share is exact
    assert warmed(flash, np.array([200.0]), undefined).errors["slide"] == pytest.approx([5.0])
