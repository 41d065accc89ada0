"""The offset and the shift at which a contact carries its load, against Brent's method and by hand."""

import numpy as np
import pytest
from scipy.optimize import brentq

from roughsim.contact.solver.load import find_offset, find_shift


def clipped(x, cap):
    return np.minimum(np.maximum(x, 0.0), cap)


def offset_of(p, gap, stiffness, cap, target, guess):
    """`find_offset` of these fields, and how often it asked for bounds."""
    asked = []

    def sums(d):
        x = p - stiffness * (gap - d)
        return clipped(x, cap).sum(), np.count_nonzero((x >= 0.0) & (x <= cap))

    def bracket():
        asked.append(1)
        enough = min(cap, 1.001 * target / p.size)
        return (gap - p / stiffness).min(), (gap + (enough - p) / stiffness).max()

    total, inside = sums(guess)
    return *find_offset(sums, bracket, stiffness, target, (guess, total - target, inside)), len(
        asked
    )


def shift_of(p, change, free, cap, target, accuracy):
    def sums(shift):
        x = p + change + shift * free
        return clipped(x, cap).sum(), np.count_nonzero((x >= 0.0) & (x <= cap) & (free > 0))

    return find_shift(sums, target, accuracy, *sums(0.0))


@pytest.mark.parametrize("cap", [np.inf, 1.5])
def test_the_offset_and_the_shift_meet_the_load(cap):
    generator = np.random.default_rng(6)
    p, gap = generator.random(1000), generator.standard_normal(1000)
    for target in (1e-3, 30.0, 700.0):
        expected = brentq(
            lambda d, target=target: clipped(p - 0.7 * (gap - d), cap).sum() - target,
            -20.0,
            20.0,
            xtol=1e-14,
        )
        for guess in (expected + 0.1, -5.0, 5.0):  # near, without contact, and far beyond
            offset, excess, number, _ = offset_of(p, gap, 0.7, cap, target, guess)
            assert offset == pytest.approx(expected, abs=1e-12)
            assert abs(excess) <= 1e-13 * max(target, 1.0)
            target_pressure = p - 0.7 * (gap - offset)
            assert number == np.count_nonzero(clipped(target_pressure, cap) == target_pressure)
    free, change = generator.integers(0, 2, 1000), generator.standard_normal(1000)
    after = lambda shift: clipped(p + change + shift * free, cap).sum()  # noqa: E731
    fixed = after(-100.0)
    for target in (1.01 * fixed, fixed + 100.0):
        found, shift = shift_of(p, change, free, cap, target, 1e-13)
        assert found
        assert after(shift) == pytest.approx(target, rel=1e-12)
    assert not shift_of(p, change, free, cap, 0.9 * fixed, 1e-13)[0]


def test_the_offset_over_flat_ground_is_found_from_far_below():
    offset, _, inside, asked = offset_of(np.zeros(8), np.zeros(8), 0.7, np.inf, 2.8, -1.0)
    assert offset == pytest.approx(0.5, abs=1e-14)
    assert inside == 8
    assert asked == 1  # no point answers to the offset there


def test_a_point_that_joins_at_the_last_moment_is_allowed_for():
    # the first step of Newton's method misses by 1e-10, for it knows of one point
    late = 1.0 - 1e-10
    offset, *_, asked = offset_of(np.zeros(2), np.array([0.0, late]), 1.0, np.inf, 1.0, 0.5)
    assert offset == pytest.approx((1.0 + late) / 2, abs=1e-14)
    assert asked == 0
    found, shift = shift_of(np.zeros(2), np.array([0.0, -late]), np.ones(2), np.inf, 1.0, 1e-14)
    assert found
    assert shift == pytest.approx((1.0 + late) / 2, abs=1e-14)


def test_a_shift_counts_where_rounding_leaves_nothing_better_but_not_where_it_leaves_too_much():
    found, shift = shift_of(
        np.ones(1), np.zeros(1), np.ones(1), np.inf, 1 / 3, 0.0
    )  # 1 + shift is never 1/3 exactly
    assert found
    assert shift == pytest.approx(-2 / 3, abs=1e-15)
    assert not shift_of(np.ones(1), np.zeros(1), np.ones(1), np.inf, 1e-20, 1e-15)[0]
