"""Beyond the highest cut-off towards an exact bound: exact where the distance to it is a power."""

from types import SimpleNamespace

import numpy as np
import pytest
from ladder_cases import (
    BOUND,
    END,
    NAME,
    VARIANCE,
    at_speeds,
    ladder,
    power_law,
    rungs_at,
    scattered,
)

from roughsim.estimate.levels import values_of
from roughsim.estimate.limit import by_bound
from roughsim.surface.power_laws import TabulatedSpectrum


@pytest.mark.parametrize("c", [3.0, -3.0])
@pytest.mark.parametrize("exponent", [0.4, 0.8, 1.3])
@pytest.mark.parametrize("end", [20.0, 800.0, np.inf])
@pytest.mark.parametrize("q", [(8.0, 16.0), (2.0, 5.0, 16.0)])
def test_a_distance_to_a_bound_that_falls_as_a_power_is_continued_exactly(exponent, c, end, q):
    limit = by_bound(rungs_at([[power_law(x, exponent, c=c)] for x in q], q), end, 7.0)
    now, left = 16.0**-exponent, end**-exponent
    assert limit.value[0] == pytest.approx(c * (left - now), rel=1e-9)
    slower = now * (16.0 / end) ** (exponent - 0.3)
    assert limit.errors["bandwidth"][0] == pytest.approx(abs(c) * (slower - left), rel=1e-9)
    assert limit.way == f"towards its bound as q_c^(−p) with p = {exponent:.2f}"


def test_scatter_goes_on_with_distances_and_their_exponent():
    # of D₁(10^(−p) − 1) with p = log2(D₀/D₁), by D₀ and D₁
    limit = by_bound(scattered([9.0, 8.0], [0.003, 0.002], (8.0, 16.0)), 160.0, 7.0)
    assert limit.value[0] == pytest.approx(-0.9, rel=1e-3)
    by_exponent = 0.1 * np.log2(10.0)
    assert limit.variance[0][0] == pytest.approx((by_exponent / 2 * 0.003) ** 2, rel=1e-3)
    assert limit.variance[1][0] == pytest.approx(((by_exponent - 0.9) * 0.002) ** 2, rel=1e-3)


def test_scatter_of_a_growing_distance_stays():
    limit = by_bound(scattered([8.0, 9.0], [0.003, 0.002], (8.0, 16.0)), 160.0, 7.0)
    assert sum(limit.variance.values())[0] == 0.0


@pytest.mark.parametrize("scatter", [1e-4, 0.1, 0.3, 1.0, 100.0])
def test_the_less_two_distances_show_the_more_their_exponent_is_drawn_to_the_first_order(scatter):
    # p = log2(D₀/D₁) of 4 and 2.5, whose derivatives are 1/D₀ and −1/D₁ over log 2
    own = scatter * np.log(2.0) / np.hypot(1 / 4.0, 1 / 2.5)
    limit = by_bound(scattered([11.0, 9.5], [own, own], (8.0, 16.0)), 32.0, 7.0)
    trust = 0.3**2 / (0.3**2 + scatter**2)
    p = trust * np.log2(4.0 / 2.5) + (1.0 - trust)
    assert limit.value[0] == pytest.approx(2.5 * (0.5**p - 1.0), rel=1e-9)
    assert limit.errors["bandwidth"][0] == pytest.approx(
        2.5 * (0.5 ** (p - 0.3) - 0.5**p), rel=1e-9
    )
    assert limit.variance[0][0] == pytest.approx((2.5 * 0.5**p * trust / 4.0 * own) ** 2, rel=1e-6)


def test_a_distance_that_hardly_falls_may_fall_faster_further_on():
    limit = by_bound(rungs_at([[7.4], [7.4]], (8.0, 16.0)), 64.0, 7.0)
    assert limit.value[0] == pytest.approx(0.0, abs=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(0.4 * (1.0 - 0.25**0.3), rel=1e-9)
    slow = by_bound(rungs_at([[7.0 + 4.0 * x**-0.1] for x in (8.0, 16.0)], (8.0, 16.0)), 64.0, 7.0)
    now, left = (4.0 * x**-0.1 for x in (16.0, 64.0))
    assert slow.value[0] == pytest.approx(left - now, rel=1e-9)
    assert slow.errors["bandwidth"][0] == pytest.approx(
        left - now * 0.25**0.4, rel=1e-9
    )  # more than what follows


@pytest.mark.parametrize("growth", [1e-9, 0.01, 0.5])
def test_a_distance_that_grows_stays(growth):
    limit = by_bound(rungs_at([[7.4], [7.4 + growth]], (8.0, 16.0)), 64.0, 7.0)
    assert limit.value[0] == pytest.approx(0.0, abs=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(
        (0.4 + growth) * (1.0 - 0.25**0.3), rel=1e-9
    )


@pytest.mark.parametrize("means", [[6.9, 7.4], [7.4, 6.9], [7.0, 7.4]])
def test_distances_on_both_sides_go_on_in_first_order(means):
    limit = by_bound(rungs_at([[mean] for mean in means], (8.0, 16.0)), 64.0, 7.0)
    assert limit.value[0] == pytest.approx(-0.75 * (means[1] - 7.0), rel=1e-9)
    assert limit.errors["bandwidth"][0] == pytest.approx(
        abs(means[1] - 7.0) * (0.25**0.7 - 0.25), rel=1e-9
    )
    at_it = by_bound(rungs_at([[means[0]], [7.0]], (8.0, 16.0)), 64.0, 7.0)
    assert (at_it.value[0], at_it.errors["bandwidth"][0]) == (0.0, 0.0)


def test_each_speed_has_its_own_exponent():
    q = 8.0, 16.0
    limit = by_bound(
        rungs_at([[power_law(x, 0.5), power_law(x, 1.2, c=-1.0)] for x in q], q), 64.0, 7.0
    )
    end = [
        power_law(64.0, 0.5) - power_law(16.0, 0.5),
        power_law(64.0, 1.2, c=-1.0) - power_law(16.0, 1.2, c=-1.0),
    ]
    np.testing.assert_allclose(limit.value, end, rtol=1e-9)
    assert limit.way.endswith("p = 0.50, 1.20")


# areas and the variance of the stress


def kinked(scene, exponent):
    """Return a scene whose C(q) falls as q^−3.6 up to 4e5/m, and with another exponent from there to the same end."""
    q = np.array([scene.spectrum.breaks[0], 4e5, END])
    psd = 1e-24 * np.array([(q[0] / q[1]) ** -3.6, 1.0, (q[2] / q[1]) ** -exponent])
    fields = {name: getattr(scene, name) for name in ("speeds", "sliding", "penetration_hardness")}
    return SimpleNamespace(spectrum=TabulatedSpectrum(q, psd), **fields)


BOUNDED = {  # bound, side of it, stored number
    "contact_fraction": (BOUND, 1.0, "contact_fraction_corrected"),
    "plastic_fraction": (BOUND, -1.0, "plastic_fraction_corrected"),
    "pressure_variance": (VARIANCE, -1.0, "pressure_variance"),
}


@pytest.mark.parametrize("name", BOUNDED)
def test_areas_and_variance_of_yielded_contact_tend_to_their_bound_as_a_power(steel, asked, name):
    # A_pl ≤ σ₀/σ_P ≤ A: the one falls to it, the other rises; g(0) rises to σ₀(σ_P − σ₀)
    bound, sign, stored = BOUNDED[name]
    means = [bound * (1.0 + sign * x) for x in (0.4, 0.3)]
    values = values_of(steel, "capped", name, ladder(means, (1e5, 2e5), name=stored))
    exponent, ratio = np.log2(0.4 / 0.3), 2e5 / END
    assert values.value[0] == pytest.approx(bound * (1.0 + sign * 0.3 * ratio**exponent), rel=1e-9)
    error = 0.3 * bound * (ratio ** (exponent - 0.3) - ratio**exponent)
    assert values.errors["bandwidth"][0] == pytest.approx(error, rel=1e-9)
    assert values.finest[0] == pytest.approx(means[1], rel=1e-12)
    assert asked == [("theory", "capped", (1e5, 2e5), name)]  # no law


@pytest.mark.parametrize("name", [NAME, "contact_fraction"])
def test_all_that_follows_by_a_power_is_in_doubt_where_the_spectrum_falls_more_steeply(
    steel, asked, name
):
    means = BOUND * np.array([1.4, 1.2, 1.1])
    stored = {"contact_fraction": "contact_fraction_corrected"}.get(name, name)
    pairs = ladder(at_speeds(*means), (1e5, 2e5, 4e5), name=stored)
    scenes = steel, kinked(steel, 5.6), kinked(steel, 2.0)
    law, steep, flat = (values_of(scene, "capped", name, pairs) for scene in scenes)
    np.testing.assert_allclose(steep.value, law.value, rtol=1e-12)
    rest = np.abs(law.value - means[-1])
    np.testing.assert_allclose(steep.errors["bandwidth"], rest, rtol=1e-9)
    assert np.all(law.errors["bandwidth"] < 0.7 * rest)
    np.testing.assert_allclose(
        flat.value, means[-1], rtol=1e-12
    )  # no rule is known where it falls less steeply
    np.testing.assert_allclose(
        flat.errors["bandwidth"], np.nan if name == NAME else 0.1 * BOUND, rtol=1e-9
    )


def test_an_area_that_hardly_changes_is_in_doubt_by_its_exponent_where_the_spectrum_falls_more_steeply(
    steel, asked
):
    pairs = ladder(np.full((2, 1), 1.2 * BOUND), (2e5, 4e5), name="contact_fraction_corrected")
    values = values_of(kinked(steel, 5.6), "capped", "contact_fraction", pairs)
    assert values.value[0] == pytest.approx(1.2 * BOUND, rel=1e-12)
    assert values.errors["bandwidth"][0] == pytest.approx(
        0.2 * BOUND * (1.0 - (4e5 / END) ** 0.3), rel=1e-9
    )


@pytest.mark.parametrize("name", BOUNDED)
def test_no_area_or_variance_is_beyond_its_bound(steel, asked, name):
    bound, sign, stored = BOUNDED[name]
    pairs = ladder([bound * (1.0 + sign * x) for x in (0.01, -0.005)], (1e5, 2e5), name=stored)
    values = values_of(steel, "capped", name, pairs)
    assert values.value[0] == pytest.approx(bound, rel=1e-12)
    assert 0.0 < values.errors["bandwidth"][0] < 0.005 * bound


@pytest.mark.parametrize("name", BOUNDED)
def test_what_follows_beyond_the_bound_leaves_the_way_to_it_in_doubt(steel, foretold, name):
    # the shape of the theory takes the value from .1 before its bound to .15 behind it
    bound, sign, stored = BOUNDED[name]
    foretold.theory = bound * (1.0 + sign * np.array([[0.2], [0.1], [-0.15]]))
    values = values_of(
        steel,
        "capped",
        name,
        ladder([bound * (1.0 + sign * x) for x in (0.2, 0.1)], (1e5, 2e5), name=stored),
    )
    assert values.value[0] == pytest.approx(bound, rel=1e-12)
    assert values.errors["bandwidth"][0] == pytest.approx(0.1 * bound, rel=1e-9)


@pytest.mark.parametrize("name", BOUNDED)
def test_where_nothing_continues_an_area_or_variance_its_bound_limits_the_error(
    steel, foretold, name
):
    foretold.theory = np.full((2, 1), np.nan)
    bound, sign, stored = BOUNDED[name]
    (pair,) = ladder([(1.0 + 0.2 * sign) * bound], (2e5,), name=stored)
    values = values_of(steel, "capped", name, [pair])
    assert values.value[0] == pytest.approx((1.0 + 0.2 * sign) * bound, rel=1e-12)
    assert values.errors["bandwidth"][0] == pytest.approx(0.2 * bound, rel=1e-9)
    elastic = values_of(
        steel, "elastic", name, [pair]
    )  # where nothing yields there is no such bound
    assert np.isnan(elastic.errors["bandwidth"][0])


@pytest.mark.parametrize("name", BOUNDED)
def test_a_bound_does_not_limit_the_error_of_a_map_that_is_cut_off(steel, asked, name):
    # its plateaus ring: with all waves an area or variance may lie further from the bound
    bound, sign, stored = BOUNDED[name]
    pairs = ladder([bound * (1.0 + sign * x) for x in (0.3, -0.1)], (1e5, 2e5), name=stored)
    values = values_of(steel, "capped", name, pairs, continued=False)
    assert values.value[0] == pytest.approx(bound, rel=1e-12)
    assert np.isnan(values.errors["bandwidth"][0])
    assert values.errors["last step"][0] == pytest.approx(0.4 * bound, rel=1e-9)


def test_of_a_map_that_is_cut_off_and_does_not_yield_all_that_may_yield_is_in_doubt(steel, asked):
    pairs = ladder([0.0, 0.0], (1e5, 2e5), name="plastic_fraction_corrected", scatter=0.0)
    values = values_of(steel, "capped", "plastic_fraction", pairs, continued=False)
    assert values.value[0] == 0.0
    assert values.errors["bandwidth"][0] == pytest.approx(BOUND, rel=1e-12)
