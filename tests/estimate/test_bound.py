"""Beyond the highest cut-off towards an exact bound: exact where the distance to it is a power."""

import numpy as np
import pytest
from ladder_cases import NAME, ladder, power_law, scattered

from roughsim.estimate.ladder import climb
from roughsim.estimate.limit import by_bound


def rungs_at(means, cut_offs):
    return climb(lambda sample: sample.numbers[NAME], ladder(means, cut_offs))


@pytest.mark.parametrize("c", [3.0, -3.0])
@pytest.mark.parametrize("exponent", [0.4, 0.8, 1.3])
@pytest.mark.parametrize("end", [20.0, 800.0, np.inf])
@pytest.mark.parametrize("q", [(8.0, 16.0), (2.0, 5.0, 16.0)])
def test_a_distance_to_a_bound_that_falls_as_a_power_is_continued_exactly(exponent, c, end, q):
    limit = by_bound(rungs_at([[power_law(x, exponent, c=c)] for x in q], q), end, 7.0)
    now, left = 16.0**-exponent, end**-exponent
    assert limit.rest.value[0] == pytest.approx(c * (left - now), rel=1e-9)
    slower = now * (16.0 / end) ** (exponent - 0.3)
    assert limit.error[0] == pytest.approx(abs(c) * (slower - left), rel=1e-9)
    assert limit.way == f"towards its bound as q_c^(−p) with p = {exponent:.2f}"


def test_one_rung_goes_towards_its_bound_in_first_order_and_its_scatter_falls_as_the_distance():
    limit = by_bound(scattered([8.0], [0.02], (16.0,)), 160.0, 7.0)
    assert limit.rest.value[0] == pytest.approx(-0.9, rel=1e-12)
    assert limit.error[0] == pytest.approx(0.1**0.7 - 0.1, rel=1e-9)
    assert limit.rest.variance[0][0] == pytest.approx((0.9 * 0.02) ** 2, rel=1e-9)


@pytest.mark.parametrize("scatter", [1e-4, 0.1, 0.3, 1.0, 100.0])
def test_the_less_two_distances_show_the_more_their_exponent_is_drawn_to_the_first_order(scatter):
    # p = log2(D₀/D₁) of 4 and 2.5, whose derivatives are 1/D₀ and −1/D₁ over log 2
    own = scatter * np.log(2.0) / np.hypot(1 / 4.0, 1 / 2.5)
    limit = by_bound(scattered([11.0, 9.5], [own, own], (8.0, 16.0)), 32.0, 7.0)
    trust = 0.3**2 / (0.3**2 + scatter**2)
    p = trust * np.log2(4.0 / 2.5) + (1.0 - trust)
    assert limit.rest.value[0] == pytest.approx(2.5 * (0.5**p - 1.0), rel=1e-9)
    assert limit.error[0] == pytest.approx(2.5 * (0.5 ** (p - 0.3) - 0.5**p), rel=1e-9)


def test_a_distance_that_hardly_falls_may_fall_faster_further_on():
    limit = by_bound(rungs_at([[7.4], [7.4]], (8.0, 16.0)), 64.0, 7.0)
    assert limit.rest.value[0] == pytest.approx(0.0, abs=1e-12)
    assert limit.error[0] == pytest.approx(0.4 * (1.0 - 0.25**0.3), rel=1e-9)
    slow = by_bound(rungs_at([[7.0 + 4.0 * x**-0.1] for x in (8.0, 16.0)], (8.0, 16.0)), 64.0, 7.0)
    now, left = (4.0 * x**-0.1 for x in (16.0, 64.0))
    assert slow.rest.value[0] == pytest.approx(left - now, rel=1e-9)
    assert slow.error[0] == pytest.approx(left - now * 0.25**0.4, rel=1e-9)  # more than what follows


@pytest.mark.parametrize("means", [[6.9, 7.4], [7.4, 6.9], [7.0, 7.4], [7.1, 7.4]])
def test_distances_that_are_no_power_go_on_in_first_order(means):
    limit = by_bound(rungs_at([[mean] for mean in means], (8.0, 16.0)), 64.0, 7.0)
    assert limit.rest.value[0] == pytest.approx(-0.75 * (means[1] - 7.0), rel=1e-9)
    assert limit.error[0] == pytest.approx(abs(means[1] - 7.0) * (0.25**0.7 - 0.25), rel=1e-9)
    at_it = by_bound(rungs_at([[means[0]], [7.0]], (8.0, 16.0)), 64.0, 7.0)
    assert (at_it.rest.value[0], at_it.error[0]) == (0.0, 0.0)
