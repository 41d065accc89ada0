"""The pixel: a finer grid at the same cut-off corrects the value or says how wrong it may be."""

import numpy as np
import pytest
from ladder_cases import NAME, level, power_law

from roughsim.estimate.ladder import observe
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample


@pytest.mark.parametrize(("capped", "order"), [(False, 2.0), (True, 1.4)])
def test_a_partner_takes_the_error_of_the_pixel_off(capped, order):
    coarse, fine = (level(np.full((12, 1), 5.0 + 0.4 * side**-order), side=side) for side in (1.0, 2.0))
    values = observe(NAME, [coarse, fine], capped=capped, end=1.0)
    assert values.extrapolated.mean() == pytest.approx(5.0, rel=1e-12)
    assert values.finest.mean() == pytest.approx(5.0 + 0.4 * 2.0**-order, rel=1e-12)
    assert values.pixel[0] == pytest.approx(0.4 * 2.0**-order, rel=1e-9)  # as much as was taken off


def test_a_pixel_error_that_goes_with_the_cut_off_is_extrapolated_away():
    def rung(q, pixels):
        return level(np.full((12, 1), 7.0 + 3.0 / q + 2.0 / (pixels * q)), q_max=q, side=pixels * q)

    samples = [rung(1.0, 4.0), rung(1.0, 8.0), rung(2.0, 4.0), rung(2.0, 8.0), rung(4.0, 4.0)]
    values = observe(NAME, samples, capped=True)
    assert values.extrapolated.mean() == pytest.approx(7.0, rel=1e-12)
    assert values.pixel[0] == pytest.approx(0.0, abs=1e-12)


def test_what_is_left_of_the_pixel_shrinks_on_the_way_to_the_top_rung():
    def rung(q, pixels, error):
        return level(np.full((12, 1), 7.0 + 3.0 / q + error), q_max=q, side=pixels * q)

    # half the pixel changes the lower rung by −0.3, the upper one by −0.2: their limit by 2(−0.2) + 0.3 = −0.1
    samples = [rung(1.0, 4.0, 0.3), rung(1.0, 8.0, 0.0), rung(2.0, 4.0, 0.2), rung(2.0, 8.0, 0.0), rung(4.0, 4.0, 0.1)]
    expected = 0.1 * (2.0 / 4.0) / (1.0 - 2.0**-1.4)
    assert observe(NAME, samples, capped=True).pixel[0] == pytest.approx(expected, rel=1e-9)
    alone = [samples[0], samples[2], samples[3], samples[4]]
    expected = 0.2 * (2.0 / 4.0) ** 0.5 / (1.0 - 2.0**-1.4)
    assert observe(NAME, alone, capped=True).pixel[0] == pytest.approx(expected, rel=1e-9)


def test_a_length_that_turns_back_with_the_pixel_stays_that_of_the_finest_grid():
    # r(g = .5) of capped contact: 1.0, 1.018, 1.0184, 1.0165 at 4, 8, 16, 32 pixels per wave; no order, no correction
    def level_of(half, side):  # one wave: g falls to half where J0(q r) = 0.5, at q r = 1.5211
        return Sample(1.0, side, np.arange(12), {}, np.array([1.5211 / half]), np.ones((12, 1)), 10.0)

    order = OBSERVABLES["correlation_radius_50"].pixel_orders
    assert order[0] == 2.0
    assert np.isnan(order[1])
    samples = [level_of(1.0, 64.0), level_of(1.018, 128.0)]
    values = observe("correlation_radius_50", samples, capped=True, end=1.0)
    found = [observe("correlation_radius_50", [x], capped=True, end=1.0).extrapolated.mean() for x in samples]
    assert found == pytest.approx([1.0, 1.018], rel=1e-3)
    assert values.extrapolated.mean() == pytest.approx(found[1], rel=1e-12)
    assert values.pixel[0] == pytest.approx(1.5 * (found[1] - found[0]), rel=1e-9)


def test_the_pixel_of_a_lower_rung_is_taken_off_the_top_in_proportion():
    low = [level(np.full((12, 1), 4.0 * (1.0 + 0.4 * side**-2.0)), q_max=1.0, side=side) for side in (1.0, 2.0)]
    top = level(np.full((12, 1), 5.0 * 1.4), q_max=2.0, side=2.0)
    values = observe(NAME, [*low, top], capped=False, end=2.0)
    assert values.extrapolated.mean() == pytest.approx(5.0, rel=1e-12)
    assert values.pixel[0] == pytest.approx(5.0 * 0.1, rel=1e-12)  # what half the pixel leaves


def test_without_a_finer_grid_nobody_knows_the_pixel():
    for samples in (power_law([1.0], 1.0), power_law([1.0, 2.0], 1.0)):
        assert np.isnan(observe(NAME, samples, capped=True).pixel[0])
