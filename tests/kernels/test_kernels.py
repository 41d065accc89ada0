"""Each kernel of the contact solver beside its plain NumPy twin.

They hold compiled and, with NUMBA_DISABLE_JIT=1, line by line.
"""

import multiprocessing
import warnings

import numpy as np
import pytest

from roughsim import _kernels
from roughsim._kernels import active_set as kernels
from roughsim._kernels import gathering
from roughsim._kernels import lines as line_kernels
from roughsim.observables import stress_spectrum

POINTS = 50
OFFSET, STIFFNESS = 0.2, 0.7


class State:
    """Pressures on and between the bounds, gaps of both signs, and a step; `copy` is for the kernel to change."""

    def __init__(self, cap):
        rng = np.random.default_rng(11)
        top = min(cap, 2.0)
        self.cap = cap
        self.p = np.clip(rng.uniform(-0.5, 1.5 * top, POINTS), 0.0, top)
        self.gap = rng.normal(0.0, 1.0, POINTS) + OFFSET
        self.gap[5] = self.gap[6] = OFFSET  # neither pushes nor gapes
        self.p[5], self.p[6] = 0.0, 0.5
        self.step, self.response, self.heights = rng.normal(0.0, 0.3, (3, POINTS))
        self.free = rng.integers(0, 2, POINTS).astype(np.int8)

    @property
    def law(self):
        return OFFSET, STIFFNESS, self.cap

    @property
    def target(self):
        return self.p - STIFFNESS * (self.gap - OFFSET)

    def clip(self, x):
        return np.clip(x, 0.0, self.cap)


@pytest.fixture(params=[np.inf, 1.0])
def state(request):
    return State(request.param)


def inside(x, cap):
    return (x >= 0.0) & (x <= cap)


def same(found, *expected):
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_heights_are_taken_off_the_displacement(state):
    gap = state.gap.copy()
    found = kernels.subtract_heights(state.heights, state.p, gap, 0.1, 2.0)
    same(found, (state.p**2).sum(), (state.gap**2).sum())
    np.testing.assert_allclose(gap, state.gap - (state.heights - 0.1) / 2.0, rtol=1e-14)


def test_the_gap_of_the_contact_and_its_points_are_summed(state):
    touching = state.p > 0
    sums = kernels.contact_sum(state.p, state.gap)
    same(sums, state.gap[touching].sum(), touching.sum())


def test_the_clipped_sum_is_that_of_the_target(state):
    found = kernels.clipped_sum(state.p, state.gap, state.law)
    same(found, state.clip(state.target).sum(), inside(state.target, state.cap).sum())


def test_points_are_classified_by_where_a_longer_step_would_take_them(state):
    free, rest = np.full(POINTS, 7, np.int8), np.full(POINTS, 7.0)
    reach, unit, limit = 0.35, 3.0, 0.4
    found = kernels.classify(state.p, state.gap, free, rest, state.law, reach, unit, limit)
    rise = state.gap - OFFSET
    moved, near = state.p - state.clip(state.target), state.p - reach * STIFFNESS * rise
    is_free = (near > 0.0) & (near < state.cap)
    above = np.abs(moved) > np.where(inside(state.target, state.cap), limit, reach * limit)
    expected = (
        state.clip(state.target),
        inside(state.target, state.cap),
        (unit * moved) ** 2,
        (unit * state.p) ** 2,
        is_free,
        above,
    )
    same(found, *(values.sum() for values in expected))
    assert np.array_equal(free, is_free)
    np.testing.assert_allclose(rest, np.where(is_free, rise, 0.0), rtol=1e-14)


def test_a_proposal_is_conjugate_where_free_and_a_bound_elsewhere(state):
    if np.isinf(state.cap):  # points are then never pushed: there is no cap to go to
        state.gap = np.maximum(state.gap, OFFSET)
        state.p[(state.free == 0) & (state.gap == OFFSET)] = 0.0
    change, load, inner = np.full(POINTS, 7.0), np.full(POINTS, 7.0), np.full(POINTS, 7, np.int8)
    arrays = state.p, state.gap, state.free, state.response, state.step, change, load, inner
    total, count, added = kernels.propose(*arrays, (0.3, 0.6), state.law)
    rise = state.gap - OFFSET
    to_cap = (rise < 0.0) | ((rise == 0.0) & (state.p > 0.0))
    bound = np.where(to_cap, state.cap, 0.0)
    expected = np.where(state.free == 1, 0.6 * state.step - 0.3 * state.response, bound - state.p)
    np.testing.assert_allclose(change, expected, rtol=1e-14, atol=1e-16)
    x = state.p + expected
    stays = inside(x, state.cap) & (state.free == 1)
    same((total, count), state.clip(x).sum(), stays.sum())
    # bounds move the free points that would leave them, and the others all the way
    moved = np.where(state.free == 1, state.clip(x) - x, expected)
    np.testing.assert_allclose(load, moved, rtol=1e-14, atol=1e-16)
    assert np.array_equal(inner, stays)
    same((added,), abs(moved).sum())


def test_a_shift_moves_the_free_points_alone(state):
    x = state.p + state.step + np.where(state.free == 1, 0.15, 0.0)
    step = np.full(POINTS, 7.0)
    arrays = state.p, state.gap, state.free, state.step, step
    found = kernels.shifted_step(*arrays, OFFSET, 0.15, state.cap)
    expected = state.clip(x) - state.p
    np.testing.assert_allclose(step, expected, rtol=1e-13, atol=1e-16)
    stays = inside(x, state.cap) & (state.free == 1)
    slopes = expected * (state.gap - OFFSET)
    same(found, *(values.sum() for values in (state.clip(x), stays, slopes)))


def test_a_shift_of_the_pressure_itself_ends_at_the_bounds(state):
    p = state.p.copy()
    found = kernels.shifted_load(p, state.free, -0.15, state.cap)
    x = state.p - 0.15 * state.free
    same(found, state.clip(x).sum(), (inside(x, state.cap) & (state.free == 1)).sum())
    kernels.shift_free(p, state.free, -0.15, state.cap)
    np.testing.assert_allclose(p, state.clip(x), atol=1e-16)


def test_points_that_are_not_free_are_put_on_their_bounds():
    p, free = (
        np.array([1.9, 0.1, 0.5, 2.0, 0.0, 0.98, 1.02]),
        np.array([0, 0, 1, 0, 0, 0, 0], np.int8),
    )
    # two just touch: at the cap on a surface that has yielded before, and without pressure; two pass half the cap
    gap = np.array([0.1, 0.3, 0.1, OFFSET, OFFSET, 0.1, 0.3])
    kernels.put_on_bounds(p, gap, free, (OFFSET, STIFFNESS, 2.0))
    assert p.tolist() == [2.0, 0.0, 0.5, 2.0, 0.0, 2.0, 0.0]


def test_the_extent_is_that_of_the_displacement(state):
    displacement = state.gap + (state.heights - 0.1) / 0.4
    found = kernels.extent(state.heights, state.gap, 0.1, 0.4)
    same(found, displacement.min(), displacement.max())


@pytest.mark.parametrize("top", [np.inf, 1.0])
def test_pressure_and_gap_go_back_to_si_and_points_are_counted(state, top):
    p, gap, hardness = np.minimum(state.p, top), state.gap.copy(), 3.0000001 * top
    before = p.copy()
    found = kernels.to_si(p, gap, state.heights, (3.0, 2.0, 0.1), (top, hardness))
    pressure = np.where(before < top, np.minimum(3.0 * before, hardness), hardness)
    np.testing.assert_allclose(p, pressure, rtol=1e-15)
    assert not np.isfinite(hardness) or (p == hardness).sum() == (before >= top).sum() > 0
    np.testing.assert_allclose(gap, 2.0 * state.gap + state.heights - 0.1, rtol=1e-14, atol=1e-15)
    assert found == ((before > 0.0).sum(), (before >= top).sum())


def test_a_gradient_step_goes_to_a_share_of_the_target(state):
    step = state.step.copy()
    found = kernels.gradient_step(state.p, state.gap, step, state.law, 0.9)
    expected = 0.9 * state.clip(state.target) - state.p
    np.testing.assert_allclose(step, expected, rtol=1e-13, atol=1e-16)
    assert found == pytest.approx((expected * (state.gap - OFFSET)).sum(), rel=1e-13)


def test_curvature_and_advance_are_those_of_the_step(state):
    products = (state.step * state.response, state.step**2, state.response**2)
    same(kernels.curvature(state.step, state.response), *(values.sum() for values in products))
    p, gap = state.p.copy(), state.gap.copy()
    found = kernels.advance(p, gap, state.step, state.response, 0.5, 0.0, state.law)
    moved = (
        state.clip(state.p + 0.5 * state.step)
        if np.isfinite(state.cap)
        else np.maximum(state.p + 0.5 * state.step, 0)
    )
    np.testing.assert_allclose(p, moved, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(gap, state.gap + 0.5 * state.response, rtol=1e-14)
    x = p - STIFFNESS * (gap - OFFSET)
    same(found, state.clip(x).sum(), inside(x, state.cap).sum())


def test_a_step_ends_on_the_bound_that_rounding_missed():
    cap, slack = 0.75, 1e-7
    below = np.nextafter(cap, 0.0)
    #            at the cap but for rounding; clearly below; the step was rounded; zero but for that; clearly above
    p = np.array([below, cap * (1 - 1e-15), cap - 0.25, 0.25, 0.25])
    step = np.array(
        [0.0, 0.0, 0.25 * (1 - 0.5 * slack), -0.25 * (1 - 0.5 * slack), -0.25 * (1 - 2 * slack)]
    )
    zero = np.zeros(5)
    kernels.advance(p, zero.copy(), step, zero, 1.0, slack, (0.0, 1.0, cap))
    assert p[[0, 2, 3]].tolist() == [cap, cap, 0.0]
    assert p[1] < cap
    assert p[4] == pytest.approx(0.5 * slack, rel=1e-6)


def test_the_highest_mode_is_the_last_above_a_power():
    rng = np.random.default_rng(3)
    along, across = rng.uniform(0.0, 9.0, 7), rng.uniform(0.0, 9.0, 5)
    spectrum = rng.normal(size=(5, 7)) + 1j * rng.normal(size=(5, 7))
    power, square = np.abs(spectrum[1:4]) ** 2, (across[:, None] + along)[1:4]
    least = float(np.median(power))
    same(line_kernels.highest(1, 4, spectrum, along, across, np.inf), power.max(), 0.0)
    same(
        line_kernels.highest(1, 4, spectrum, along, across, least),
        power.max(),
        square[power > least].max(),
    )


def test_the_sum_at_a_point_is_that_of_all_waves():
    rng = np.random.default_rng(4)
    along, across = rng.uniform(0.0, 9.0, 7), rng.uniform(0.0, 9.0, 5)
    spectrum = rng.normal(size=(5, 7)) + 1j * rng.normal(size=(5, 7))
    x, y = rng.uniform(-3.0, 3.0, 7), rng.uniform(-3.0, 3.0, 5)
    waves = np.sqrt(across[:, None] + along) * spectrum * np.exp(1j * (y[:, None] + x))
    phases = [(np.cos(angle), np.sin(angle)) for angle in (x, y)]
    found = line_kernels.point_sum(spectrum.view(float), along, across, *phases)
    assert found == pytest.approx(waves.real.sum(), rel=1e-13, abs=1e-13)


def test_power_is_gathered_from_four_modes_each():
    rng = np.random.default_rng(5)
    amplitude, slot = (
        rng.normal(size=(6, 4)) + 1j * rng.normal(size=(6, 4)),
        rng.integers(0, 3, (4, 4)),
    )
    quarter, sums = np.zeros((4, 4)), np.ones(5)
    gathering.gather_power(amplitude, np.array([1.0, 2.0, 2.0, 1.0]), slot, quarter, sums)
    power = np.abs(amplitude) ** 2
    power[1:3] += power[:3:-1]
    np.testing.assert_allclose(quarter, power[:4] * [1.0, 2.0, 2.0, 1.0], rtol=1e-14)
    np.testing.assert_allclose(
        sums, 1.0 + np.bincount(slot.ravel(), quarter.ravel(), minlength=5), rtol=1e-14
    )


def test_moments_of_columns_are_sums_of_powers():
    assert gathering.POWERS == stress_spectrum._POWERS  # who gathers without kernels takes as many
    rng = np.random.default_rng(6)
    table, offset = rng.normal(size=(3, 7)), rng.uniform(-0.5, 0.5, (3, 7))
    moments = np.ones((gathering.POWERS, 7))
    gathering.moments_of_columns(table, offset, moments)
    for k, row in enumerate(moments):
        np.testing.assert_allclose(row, 1.0 + (table * offset**k).sum(axis=0), rtol=1e-14)


def test_where_compiled_code_cannot_be_kept_kernels_are_compiled_all_the_same_and_that_is_said(
    monkeypatch,
):
    # on a compute node that may write neither beside the package nor at home
    genuine = _kernels.njit

    def njit(**options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return genuine(**options)

    monkeypatch.setattr(_kernels, "njit", njit)
    with pytest.warns(RuntimeWarning, match="each process compiles again, .* set NUMBA_CACHE_DIR"):
        double = _kernels.kernel()(lambda x: 2.0 * x)
    assert double(1.5) == 3.0
    assert not _kernels.was_compiled(double)  # for a line that says "once on this machine"
    monkeypatch.setattr(multiprocessing.current_process(), "_name", "SpawnProcess-1")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the parent of a worker has said it
        _kernels.kernel()(lambda x: 2.0 * x)
