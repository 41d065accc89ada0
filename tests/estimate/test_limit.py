"""Beyond the highest cut-off: exact where the law, the shape or the power is, and in doubt by what is stated."""

import numpy as np
import pytest
from ladder_cases import power_law, rungs_at, scattered

from roughsim.estimate.limit import by_law, by_power, by_shape, by_steps

CUT_OFFS, END = (4.0, 8.0, 16.0), 800.0
THEORY = np.array([2.0, 2.8, 3.2, 4.0])  # up to three cut-offs, and over the whole spectrum


def relative_error(mean):
    return np.sqrt(sum(mean.variance.values())) / np.abs(mean.value)


# by the law for contact that yields


def fall(q):
    """T_flash that falls faster below than any power of its last steps."""
    return 7.0 * (1.0 + 1.4 * np.asarray(q) ** -1.1 + 2.0 * np.asarray(q) ** -3.0)


def law_at(q, law=fall):
    return law(np.array([*q, END]))[:, None]


def test_a_part_that_alone_follows_the_law_gives_the_limit_by_steps():
    # T = a + b·law, such as a quantile of the temperature: the law is wrong in proportion
    q = CUT_OFFS[-2:]
    limit = by_steps(rungs_at([[30.0 + 0.6 * fall(x)] for x in q], q), law_at(q))
    assert limit.value[0] == pytest.approx(0.6 * (fall(END) - fall(16.0)), rel=1e-12)
    alike = (30.0 + 0.6 * fall(16.0)) * (fall(END) / fall(16.0) - 1.0)
    size = abs(limit.value[0])
    assert limit.errors["bandwidth"][0] == pytest.approx(
        min(max(abs(alike - limit.value[0]), 0.25 * size), size), rel=1e-9
    )
    assert limit.errors["bandwidth"][0] == pytest.approx(size)  # most of this mean is a
    nearly = by_steps(rungs_at([[0.1 + fall(x)] for x in q], q), law_at(q))
    assert nearly.errors["bandwidth"][0] == pytest.approx(0.25 * abs(nearly.value[0]), rel=1e-12)
    one = by_steps(rungs_at([[2.0 * fall(16.0)]], (16.0,)), law_at((16.0,)))
    assert one.value[0] == pytest.approx(2.0 * (fall(END) - fall(16.0)), rel=1e-12)
    assert one.errors["bandwidth"][0] == pytest.approx(abs(one.value[0]), rel=1e-12)


@pytest.mark.parametrize("count", [2, 3])
def test_a_law_right_but_for_a_factor_gives_the_limit_and_a_share_of_what_follows_is_in_doubt(
    count,
):
    q = CUT_OFFS[-count:]
    limit = by_law(rungs_at([[1.03 * fall(x)] for x in q], q), law_at(q[-2:]))
    follows = 1.03 * (fall(16.0) - fall(END))
    assert limit.value[0] == pytest.approx(-follows, rel=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(0.1 * follows, rel=1e-12)
    assert limit.way == "by the calibrated law"


@pytest.mark.parametrize("unit", [100.0, -100.0])
@pytest.mark.parametrize("missed", [0.01, -0.01])
@pytest.mark.parametrize("foretold", [0.96, 1.04])
def test_the_doubt_of_the_law_and_how_badly_it_foretold_the_last_step_add_as_squares(
    unit, missed, foretold
):
    # the step is .01 off the .04 of the law, which predicts another 2 %
    law = np.array([[1.0], [foretold], [foretold * 0.98]])
    top = (foretold + missed) * unit
    limit = by_law(rungs_at([[unit], [top]], (8.0, 16.0)), law)
    assert limit.value[0] == pytest.approx(-0.02 * top, rel=1e-12)
    by_step = -0.02 * foretold * (top - unit) / (foretold - 1.0)
    assert limit.errors["bandwidth"][0] ** 2 == pytest.approx(
        (by_step + 0.02 * top) ** 2 + (0.1 * 0.02 * top) ** 2, rel=1e-9
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_a_law_does_not_resolve_adds_as_squares(sign):
    for q, of_rest in ((CUT_OFFS[-2:], 0.1), (CUT_OFFS[-1:], 1.0)):
        rungs = rungs_at([[sign * fall(x)] for x in q], q)
        limit = by_law(rungs, law_at(q[-2:]), elastic=True)
        follows = fall(16.0) - fall(END)
        exact = np.hypot(of_rest * follows, 0.004 * fall(16.0))
        assert limit.errors["bandwidth"][0] == pytest.approx(exact, rel=1e-9)
        assert limit.value[0] == pytest.approx(-sign * follows, rel=1e-12)


def test_a_law_that_missed_more_than_the_step_leaves_all_in_doubt_and_no_more():
    law = np.array([[1.0], [0.99], [0.99 * 0.98]])
    limit = by_law(rungs_at([[100.0], [103.0]], (8.0, 16.0)), law)
    assert limit.errors["bandwidth"][0] == pytest.approx(0.02 * 103.0, rel=1e-12)


def test_one_rung_tests_no_law():
    limit = by_law(rungs_at([[fall(16.0)]], (16.0,)), law_at((16.0,)))
    assert limit.value[0] == pytest.approx(fall(END) - fall(16.0), rel=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(fall(16.0) - fall(END), rel=1e-12)


def test_a_law_is_judged_at_each_speed_and_at_rest_nothing_follows():
    law = np.array([[0.0, 1.0, 1.0], [0.0, 0.96, 0.96], [0.0, 0.9, 0.9]])
    limit = by_law(rungs_at([[0.0, 100.0, 100.0], [0.0, 96.0, 98.0]], (8.0, 16.0)), law)
    np.testing.assert_allclose(limit.value, [0.0, -6.0, -98.0 * 0.06 / 0.96], rtol=1e-12)
    of_law, by_step = 98.0 * 0.06 / 0.96, 0.06 * 2.0 / 0.04
    np.testing.assert_allclose(
        limit.errors["bandwidth"], [0.0, 0.6, np.hypot(of_law - by_step, 0.1 * of_law)], rtol=1e-12
    )


def test_by_a_law_the_limit_scatters_as_the_top_does():
    rungs = rungs_at([[fall(x)] for x in CUT_OFFS], scatter=0.05)
    top = rungs[-1].mean
    limit = top + by_law(rungs, law_at(CUT_OFFS[-2:]))
    assert relative_error(limit)[0] == pytest.approx(relative_error(top)[0], rel=1e-12)


# with the shape of the theory


def shaped(count, slope=1.5, theory=THEORY):
    """The rest of a value that is 1 + slope × theory, from the highest of the cut-offs of the theory."""
    means = [[1.0 + slope * value] for value in THEORY[:3]][-count:]
    return by_shape(rungs_at(means, CUT_OFFS[-count:]), theory[-count - 1 :, None])


@pytest.mark.parametrize("count", [2, 3])
def test_a_value_that_goes_with_the_theory_goes_on_as_its_last_step_over_that_of_the_theory(count):
    limit = shaped(count)
    assert limit.value[0] == pytest.approx(1.5 * 0.8, rel=1e-12)
    # by the values it would be 5.8 × 0.8/3.2 = 1.45: nearer than a quarter
    assert limit.errors["bandwidth"][0] == pytest.approx(1.2 * {2: 0.5, 3: 0.25}[count], rel=1e-12)
    assert shaped(count, slope=0.5).errors["bandwidth"][0] == pytest.approx(2.6 / 4 - 0.4, rel=1e-9)
    assert limit.way == "with the shape of the theory"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_cut_off_goes_on_in_proportion_to_the_theory_and_all_of_it_is_in_doubt(sign):
    limit = by_shape(rungs_at([[sign * 5.8]], (16.0,)), THEORY[-2:, None])
    assert limit.value[0] == pytest.approx(sign * 5.8 * 0.25, rel=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(5.8 * 0.25, rel=1e-12)


def test_values_below_zero_go_on_as_those_above():
    limit = by_shape(rungs_at([[-5.2], [-5.8]], (8.0, 16.0)), THEORY[-3:, None])
    assert limit.value[0] == pytest.approx(-1.2, rel=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(0.6, rel=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_where_a_part_of_the_contact_yields_all_of_the_rest_by_the_shape_is_in_doubt(count):
    means = [[1.0 + 1.5 * value] for value in THEORY[3 - count : 3]]
    limit = by_shape(rungs_at(means, CUT_OFFS[3 - count :]), THEORY[-count - 1 :, None], least=1.0)
    assert limit.errors["bandwidth"][0] == pytest.approx(limit.value[0], rel=1e-12)


@pytest.mark.parametrize("means", [[[0.0, 0.3]], [[0.0, 0.25], [0.0, 0.3]]])
def test_what_is_zero_so_far_may_rise_as_much_as_the_theory(means):
    theory = np.array([[1e-4, 2e-3], [5e-4, 3e-3], [4e-3, 4e-3]])[2 - len(means) :]
    limit = by_shape(rungs_at(means, CUT_OFFS[-len(means) :]), theory, least=1.0)
    assert (limit.value[0], limit.errors["bandwidth"][0]) == (0.0, pytest.approx(3.5e-3, rel=1e-12))
    assert limit.errors["bandwidth"][1] > 0.04


def test_a_value_against_the_theory_goes_on_against_it():
    limit = by_shape(rungs_at([[2.0], [1.8]], (8.0, 16.0)), THEORY[-3:, None])
    assert limit.value[0] == pytest.approx(-0.4, rel=1e-12)
    assert limit.errors["bandwidth"][0] == pytest.approx(0.4 + 1.8 * 0.25, rel=1e-12)


@pytest.mark.parametrize(
    "last", [3.2 + 3.0, np.nan]
)  # 1.5 × 3 exceeds half of 5.8; and where nothing is predicted
def test_what_was_not_tried_or_is_not_foretold_is_unknown_and_changes_nothing(last):
    limit = shaped(3, theory=np.array([2.0, 2.8, 3.2, last]))
    assert limit.value[0] == 0.0
    assert np.isnan(limit.errors["bandwidth"][0])
    assert limit.way == ""
    assert all(np.all(rows == 0.0) for rows in limit.influence.values())


def test_what_would_follow_downwards_must_have_been_tried_too():
    limit = by_shape(rungs_at([[1.0], [0.6]], (8.0, 16.0)), THEORY[-3:, None])  # −0.8 of 0.6
    assert limit.value[0] == 0.0
    assert np.isnan(limit.errors["bandwidth"][0])


def test_each_speed_goes_on_or_does_not():
    table = np.column_stack((THEORY[-3:], np.full(3, np.nan)))
    limit = by_shape(rungs_at([[5.2, 5.2], [5.8, 5.8]], (8.0, 16.0)), table)
    np.testing.assert_allclose(limit.value, [1.2, 0.0], rtol=1e-12)
    np.testing.assert_allclose(limit.errors["bandwidth"], [0.6, np.nan], rtol=1e-12)
    assert limit.way == "with the shape of the theory"


def test_half_of_the_value_was_tried():
    for last, tried in (
        (3.2 + 1.9, True),
        (3.2 + 1.95, False),
    ):  # 1.5 × 1.9 and 1.5 × 1.95 around half of 5.8
        assert (
            np.isfinite(shaped(3, theory=np.array([2.0, 2.8, 3.2, last])).errors["bandwidth"][0])
            == tried
        )


def test_nothing_follows_a_theory_that_has_settled_or_is_infinite():
    settled = np.array([2.0, 2.8, 3.2, 3.2])
    assert (
        shaped(3, theory=settled).value[0],
        shaped(3, theory=settled).errors["bandwidth"][0],
    ) == (
        0.0,
        0.0,
    )
    assert shaped(3, theory=settled).way == ""
    at_rest = np.column_stack((np.full(3, np.inf), np.zeros(3), THEORY[-3:]))
    limit = by_shape(rungs_at([[5.2] * 3, [5.8] * 3], (8.0, 16.0)), at_rest)
    np.testing.assert_allclose(limit.value, [0.0, 0.0, 1.2], rtol=1e-12)
    np.testing.assert_allclose(limit.errors["bandwidth"], [0.0, 0.0, 0.6], rtol=1e-12)


def test_the_scatter_of_the_last_step_passes_into_what_follows_with_the_shape():
    top, below = 5.8, 5.2
    limit = by_shape(scattered([below, top], [0.02, 0.03], (8.0, 16.0)), THEORY[-3:, None])
    assert limit.variance[1][0] == pytest.approx((2.0 * 0.03) ** 2, rel=1e-9)
    assert limit.variance[0][0] == pytest.approx((2.0 * 0.02) ** 2, rel=1e-9)


# as a power of the cut-off


def rest_of(p, last_step, end=END):
    """What follows a step from 8 to 16 by T∞ + c q^(−p) through both ends."""
    return last_step * (1.0 - (16.0 / end) ** p) / (2.0**p - 1.0)


@pytest.mark.parametrize("c", [3.0, -3.0])
@pytest.mark.parametrize("exponent", [0.4, 0.8, 1.3, 2.5])
@pytest.mark.parametrize("end", [20.0, 800.0])
def test_a_power_of_the_cut_off_is_continued_exactly_to_a_finite_end(exponent, end, c):
    rungs = rungs_at([[power_law(q, exponent, c=c)] for q in CUT_OFFS])
    limit = by_power(rungs, end, usual=1.0)
    rest = power_law(end, exponent, c=c) - power_law(16.0, exponent, c=c)
    assert limit.value[0] == pytest.approx(rest, rel=1e-9)
    last = power_law(16.0, exponent, c=c) - power_law(8.0, exponent, c=c)
    up_to_usual = abs(rest_of(1.0, last, end) - rest) if exponent < 1.0 else 0.0
    assert limit.errors["bandwidth"][0] == pytest.approx(
        max(0.5 * abs(rest), up_to_usual), rel=1e-9
    )
    assert limit.way == f"as q_c^(−p) with p = {exponent:.2f}"


@pytest.mark.parametrize(("steps", "least"), [(1, 1.0), (2, 0.5), (3, 0.25), (6, 0.25)])
def test_all_of_the_rest_is_in_doubt_after_one_step_and_half_after_two(steps, least):
    q = [2.0**k for k in range(steps + 1)]
    rungs = rungs_at([[power_law(x, 1.0)] for x in q], q)
    limit = by_power(rungs, 2.0 * q[-1], usual=1.0)
    assert limit.value[0] == pytest.approx(power_law(2 * q[-1], 1) - power_law(q[-1], 1))
    assert limit.errors["bandwidth"][0] == pytest.approx(least * abs(limit.value[0]), rel=1e-9)


@pytest.mark.parametrize("ratio", [1.5, 3.0])
def test_cut_offs_need_not_double(ratio):
    q = [4.0 * ratio**k for k in range(3)]
    limit = by_power(rungs_at([[power_law(x, 0.8)] for x in q], q), 800.0, usual=1.3)
    assert limit.value[0] == pytest.approx(power_law(800.0, 0.8) - power_law(q[-1], 0.8), rel=1e-9)


@pytest.mark.parametrize("usual", [0.4, 0.6, 1.0])
def test_two_rungs_go_on_with_the_usual_exponent_and_a_lower_one_is_as_likely(usual):
    rungs = rungs_at([[power_law(q, usual)] for q in (8.0, 16.0)], (8.0, 16.0))
    limit = by_power(rungs, END, usual)
    rest = power_law(END, usual) - power_law(16.0, usual)
    assert limit.value[0] == pytest.approx(rest, rel=1e-9)
    step = power_law(16.0, usual) - power_law(8.0, usual)
    p = max(usual - 0.3, 0.2)  # T∞ + c q^(−p) through both rungs
    c = step / (16.0**-p - 8.0**-p)
    lower = c * (END**-p - 16.0**-p)
    assert limit.errors["bandwidth"][0] == pytest.approx(
        max(abs(lower - rest), abs(rest)), rel=1e-9
    )


@pytest.mark.parametrize("scatter", [1e-4, 0.1, 0.3, 1.0, 100.0])
def test_the_less_the_steps_show_the_more_the_exponent_is_drawn_to_the_usual_one(scatter):
    # steps of −3 and −1.5: p = 1; rungs that scatter so that the p of the steps has this standard error
    means = np.array([10.0, 7.0, 5.5])
    # p = log2((T₀ − T₁)/(T₁ − T₂)): its derivatives
    slopes = np.array([1 / 3.0, -1 / 3.0 - 1 / 1.5, 1 / 1.5]) / np.log(2.0)
    own = scatter / np.linalg.norm(slopes)
    limit = by_power(scattered(means, [own, own, own]), 1e9, usual=0.6)
    trust = 0.3**2 / (0.3**2 + scatter**2)
    p = trust * 1.0 + (1.0 - trust) * 0.6
    assert limit.way.endswith(f"{p:.2f}")

    def rest(p):
        return -1.5 * (1.0 - (16.0 / 1e9) ** p) / (2.0**p - 1.0)

    assert limit.value[0] == pytest.approx(rest(p), rel=1e-9)
    doubtful = abs(rest(p - 0.3 * np.sqrt(1.0 - trust)) - rest(p))
    assert limit.errors["bandwidth"][0] == pytest.approx(
        max(doubtful, (1.0 - 0.5 * trust) * abs(rest(p))), rel=1e-9
    )
    # the realizations scatter in the last step, and in p by the weight of the steps
    by_p = (rest(p + 1e-5) - rest(p - 1e-5)) / 2e-5 * trust * slopes
    by_step = rest(p) / -1.5 * np.array([0.0, -1.0, 1.0])
    variance = [limit.variance[stream][0] for stream in range(3)]
    np.testing.assert_allclose(variance, (own * (by_p + by_step)) ** 2, rtol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    "steps",
    [
        (3.0, -2.0),  # the value has turned
        (-0.1, -2.0),  # a growing step
        (-2.0, -1.8),  # p = 0.15: steps that hardly shrink
        (0.0, -2.0),
    ],
)
def test_steps_that_hardly_shrink_have_the_least_exponent_and_the_error_reaches_the_usual_one(
    steps, sign
):
    means = 10.0 + sign * np.cumsum([0.0, *steps])
    limit = by_power(rungs_at([[mean] for mean in means]), END, 0.6)
    slow, usual = (rest_of(p, sign * steps[1]) for p in (0.2, 0.6))
    assert limit.value[0] == pytest.approx(slow, rel=1e-9)
    assert limit.errors["bandwidth"][0] == pytest.approx(abs(slow - usual), rel=1e-9)


def test_exponents_on_both_sides_of_the_least_give_nearly_the_same():
    below, above = (
        by_power(rungs_at([[power_law(q, p)] for q in CUT_OFFS]), END, 1.0) for p in (0.199, 0.201)
    )
    np.testing.assert_allclose(below.value, above.value, rtol=0.01)
    np.testing.assert_allclose(below.errors["bandwidth"], above.errors["bandwidth"], rtol=0.01)


@pytest.mark.parametrize("last", [0.0, -1e-3, 1e-3])
def test_steps_lost_in_their_scatter_go_on_with_the_usual_exponent_and_all_of_the_rest_is_in_doubt(
    last,
):
    limit = by_power(scattered([10.0, 10.0 - 2e-3, 10.0 - 2e-3 + last], [0.5, 0.5, 0.5]), END, 0.6)
    assert limit.value[0] == pytest.approx(rest_of(0.6, last), rel=1e-3)
    assert limit.errors["bandwidth"][0] >= abs(rest_of(0.6, last)) * 0.999


@pytest.mark.parametrize("exponent", [0.2, 0.3])
@pytest.mark.parametrize("share", [0.01, 0.03])
def test_draws_of_a_slow_power_hold_what_follows(exponent, share):
    # half of the draws at 0.2 show less than the least exponent: at the usual one, .9, two in five hold
    draw, held = np.random.default_rng(3), []
    true = [power_law(q, exponent) for q in (*CUT_OFFS, END)]
    scatter = share * abs(true[2] - true[1])
    for _ in range(200):
        means = true[:3] + scatter * draw.standard_normal(3)
        limit = by_power(scattered(means, [scatter] * 3), END, 0.9)
        found = means[2] + limit.value[0]
        own = scatter**2 + sum(limit.variance.values())[0]
        held.append(
            abs(found - true[3]) <= np.hypot(limit.errors["bandwidth"][0], 1.96 * np.sqrt(own))
        )
    assert np.mean(held) > 0.9


def test_only_the_last_three_rungs_and_each_speed_by_itself_show_the_power():
    q = (2.0, *CUT_OFFS)
    means = [[99.0, 1.0], *([power_law(x, 0.5), power_law(x, 1.5, 4.0, -1.0)] for x in CUT_OFFS)]
    limit = by_power(rungs_at(means, q), END, 1.0)
    expected = [power_law(END, 0.5) - power_law(16.0, 0.5)]
    expected.append(power_law(END, 1.5, 4.0, -1.0) - power_law(16.0, 1.5, 4.0, -1.0))
    np.testing.assert_allclose(limit.value, expected, rtol=1e-9)
    assert limit.way.endswith("p = 0.50, 1.50")


def test_the_scatter_of_the_last_step_passes_into_what_follows_as_a_power():
    limit = by_power(
        scattered([8.0, 7.0], [0.02, 0.03], (8.0, 16.0)), 1e9, 1.0
    )  # all of the step follows again
    assert limit.variance[0][0] == pytest.approx(0.02**2, rel=1e-6)
    assert limit.variance[1][0] == pytest.approx(0.03**2, rel=1e-6)


def test_three_levels_scatter_as_the_limit_of_a_geometric_series():
    # T∞ = T₂ + s²/(d − s), d = T₁ − T₀ and s = T₂ − T₁
    (d, s), errors = (-1.0, -0.6), 1e-4 * np.array([3.0, 2.0, 1.0])
    limit = by_power(scattered([9.0, 8.0, 7.4], errors), np.inf, 1.0)
    assert limit.value[0] == pytest.approx(s**2 / (d - s), rel=1e-4)
    over_d, over_s = -(s**2) / (d - s) ** 2, s * (2.0 * d - s) / (d - s) ** 2
    variance = [limit.variance[stream][0] for stream in range(3)]
    slopes = np.array([-over_d, over_d - over_s, over_s])
    np.testing.assert_allclose(variance, (slopes * errors) ** 2, rtol=1e-2)


@pytest.mark.parametrize("last", [7.01, 6.5])
def test_an_exponent_at_its_least_does_not_scatter(last):
    limit = by_power(scattered([9.0, 8.0, last], [3e-4, 2e-4, 1e-4]), END, 1.0)
    assert limit.way.endswith("p = 0.20")
    follows = (1.0 - (16.0 / END) ** 0.2) / (2.0**0.2 - 1.0)
    assert limit.variance[0][0] == 0.0
    assert limit.variance[2][0] == pytest.approx((1e-4 * follows) ** 2, rel=1e-3)
