"""The contact solver inside: its steps, its accounts of rounding, and how it runs."""

import multiprocessing
import signal
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from test_contact_operator import compliance

import roughsim as rs
from roughsim._kernels import active_set as kernels
from roughsim.contact.solver import exchange as exchanges
from roughsim.contact.solver import solve
from roughsim.contact.solver.exchange import exchange
from roughsim.contact.solver.operators import MOST_KEPT, kept_half_space
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.contact.solver.steps import Check, Iterate, workspace_of


def rough(points=64, *, slope=0.5, seed=0, per_wave=4):
    grid = rs.Grid((points, points), (1.0, 1.0))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        slope, hurst=0.8, q_min=2 * np.pi, q_roll_off=4 * np.pi, q_max=grid.nyquist * 2 / per_wave
    )
    return rs.synthesize(spectrum, grid, np.random.default_rng(seed)), grid


def outer_residual(heights, grid, cap, pressure):
    """The residual with numpy's transform and a bisected offset."""
    waves = (
        2 * np.pi * np.fft.fftfreq(n, a / n) for n, a in zip(grid.shape, grid.lengths, strict=True)
    )
    q = np.hypot(*np.meshgrid(*waves, indexing="ij"))
    gap = np.fft.ifft2(compliance(q) * np.fft.fft2(pressure)).real - heights
    kappa = 0.5 * q[np.abs(np.fft.fft2(heights)) > 1e-9 * np.abs(np.fft.fft2(heights)).max()].max()
    low, high = gap.min() - 1, gap.max() + pressure.max()
    for _ in range(200):
        offset = 0.5 * (low + high)
        target = np.clip(pressure - kappa * (gap - offset), 0, cap)
        low, high = (low, offset) if target.mean() > pressure.mean() else (offset, high)
    return np.linalg.norm(pressure - target) / np.linalg.norm(pressure)


@pytest.mark.parametrize("cap", [np.inf, 0.3])
@pytest.mark.parametrize(
    "tolerance",
    [1e-3, 1e-6, 1e-12, *(pytest.param(t, marks=pytest.mark.slow) for t in (1e-5, 1e-9))],
)
def test_the_reported_residual_holds_outside_though_steps_are_single(cap, tolerance):
    # float32 steps must not show: what rounding leaves is bounded by a tenth of the tolerance
    heights, grid = rough(256)
    contact = rs.solve_contact(
        heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.1, tolerance=tolerance
    )
    assert contact.residual <= tolerance
    assert outer_residual(heights, grid, cap, contact.pressure) <= 1.2 * tolerance


def test_loads_that_float32_cannot_hold_are_stepped_in_float64():
    heights, grid = rough()
    for load, kind in ((1e-3, np.float32), (1e-20, np.float64)):
        assert ScaledProblem(heights, 0.0, 1.0, grid, load, np.inf, 100.0).step_type is kind


@pytest.mark.parametrize("cap", [np.inf, 0.3])
def test_work_hardly_grows_as_one_surface_is_refined(cap):
    # goals of the solver: about 20 transforms to 1e-6 at any size; a broken preconditioner needs several times that
    coarse, coarse_grid = rough(128, per_wave=8)
    work = []
    for factor in (1, 2, 4):
        points = 128 * factor
        spectrum = np.zeros((points, points // 2 + 1), complex)
        rows = np.rint(np.fft.fftfreq(128) * 128).astype(int)
        spectrum[rows, :65] = np.fft.rfft2(coarse) * factor**2
        grid = rs.Grid((points, points), coarse_grid.lengths)
        heights = np.fft.irfft2(spectrum, s=grid.shape)
        work.append(
            rs.solve_contact(heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.1).transforms
        )
    assert max(work) < 26
    assert work[2] < 1.25 * work[0]


def fields(seed, points=96):
    heights, grid = rough(points, seed=seed)
    return rs.solve_contact(heights, grid, rs.Solid(1.0, 0.3), nominal_pressure=0.1).pressure


def test_one_and_two_threads_give_the_same_bits():
    try:
        rs.set_threads(2)
        two = fields(0, 520)
    finally:
        rs.set_threads(1)
    np.testing.assert_array_equal(two, fields(0, 520))


def test_two_solves_at_once_equal_two_in_a_row():
    expected = [fields(seed, 200) for seed in range(4)]
    with ThreadPoolExecutor(2) as pool:
        for pressure, alone in zip(pool.map(fields, range(4), [200] * 4), expected, strict=True):
            np.testing.assert_array_equal(pressure, alone)


@pytest.mark.parametrize("points", [48, 130])
def test_buffers_kept_from_another_solve_on_the_grid_leave_no_trace(points):
    # the first solve in a thread of its own finds none; loads far apart take steps of either precision
    heights, grid = rough(points)

    def solve_at(load, cap):
        return rs.solve_contact(heights, grid, rs.Solid(1.0, cap), nominal_pressure=load)

    with ThreadPoolExecutor(1) as pool:
        alone = pool.submit(solve_at, 0.1, 0.3).result()
    for load, cap in ((1e-3, np.inf), (1e-17, np.inf), (0.28, 0.3), (50.0, np.inf)):
        solve_at(load, cap)
        again = solve_at(0.1, 0.3)
        np.testing.assert_array_equal(again.pressure, alone.pressure)
        np.testing.assert_array_equal(again.displacement, alone.displacement)
    assert not np.shares_memory(again.pressure, alone.pressure)


def test_buffers_of_large_grids_are_not_kept():
    for points, same in ((64, True), (520, False)):
        grid = rs.Grid((points, points), (1.0, 1.0))
        operators = [kept_half_space(grid, np.float32) for _ in range(2)]
        assert (operators[0] is operators[1]) == same
    many = [
        kept_half_space(rs.Grid((2, 2 + k), (1.0, 1.0)), np.float32) for k in range(MOST_KEPT + 1)
    ]
    assert kept_half_space(rs.Grid((2, 2), (1.0, 1.0)), np.float32) is not many[0]
    assert kept_half_space(rs.Grid((2, 2 + MOST_KEPT), (1.0, 1.0)), np.float32) is many[-1]


def pressed(heights, grid, threads):
    """Solve with so many threads: the contact solver's own pool, not FFTW's, which do not survive a fork."""
    try:
        rs.set_threads(threads)
        return rs.solve_contact(heights, grid, rs.Solid(1.0, 0.3), nominal_pressure=0.1).pressure
    finally:
        rs.set_threads(1)


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("start", ["spawn", "fork"])
@pytest.mark.slow
def test_a_new_process_gives_the_same_bits(start):
    heights, grid = rough(520)
    expected = pressed(heights, grid, 2)  # leaves a pool of threads, which a fork does not inherit
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(start)) as pool:
        moved = pool.submit(pressed, heights, grid, 2).result(timeout=60)
    np.testing.assert_array_equal(moved, expected)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("threads", "points"), [(1, 1024), (2, 1024), pytest.param(1, 2048, marks=pytest.mark.slow)]
)
def test_an_interrupt_ends_the_solve_soon_and_leaves_it_usable(threads, points):
    heights, grid = rough(points)
    expected = fields(1)
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        rs.set_threads(threads)
        signal.setitimer(
            signal.ITIMER_REAL, 0.1, 0.5
        )  # again: Python drops an interrupt in the callback of a weakref
        start = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.1, tolerance=1e-12)
        assert time.perf_counter() - start < 1.1
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, old)
        rs.set_threads(1)
    np.testing.assert_array_equal(fields(1), expected)


def test_a_stall_is_noticed_and_raised_with_the_best_field(monkeypatch):
    # every iteration counts as a stall, and exchanges are of no use
    monkeypatch.setattr(solve, "exchange", lambda now: now.pressure.fill(now.problem.load))
    monkeypatch.setattr(solve, "PATIENCE", -1)
    heights, grid = rough()
    with pytest.raises(
        rs.ConvergenceError, match=r"stalled: residual .* after \d+ iterations, tolerance 1e-06"
    ) as caught:
        rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.1)
    assert caught.value.residual > 1e-6
    assert caught.value.pressure.shape == grid.shape


def white_noise(shape, lengths):
    """Noise on every pixel, and the range of its full-contact pressure."""
    heights, grid = 0.02 * np.random.default_rng(3).standard_normal(shape), rs.Grid(shape, lengths)
    return (
        heights,
        grid,
        np.abs(np.fft.irfft2(np.fft.rfft2(heights) * grid.wavenumbers / 2, s=shape)).max(),
    )


@pytest.mark.slow
@pytest.mark.parametrize("cap", [np.inf, 0.25])
@pytest.mark.parametrize(
    ("shape", "lengths"),
    [((64, 64), (1.0, 1000.0)), ((8, 8192), (1.0, 1.0)), ((301, 7), (1, 1e-3))],
)
def test_noise_on_every_pixel_of_oblong_cells_is_solved_with_little_work(shape, lengths, cap):
    heights, grid, full = white_noise(shape, lengths)
    contact = rs.solve_contact(
        heights, grid, rs.Solid(1.0, cap * full), nominal_pressure=0.1 * full
    )
    assert contact.transforms < 400
    assert outer_residual(heights, grid, cap * full, contact.pressure) <= 2e-6


@pytest.mark.parametrize("cap", [np.inf, 0.3])
def test_exchanges_of_points_alone_lead_to_the_solution(cap):
    heights, grid = rough()
    exact = rs.solve_contact(
        heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.1, tolerance=1e-9
    ).pressure
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.1, cap, grid.nyquist / 4)
    now = started(problem, np.full(grid.shape, 0.1))
    now.check(1e-6, 0.5)
    exchange(now)
    np.testing.assert_allclose(now.pressure, exact, atol=1e-8 * exact.max())


@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 1000.0)])
def test_single_precision_steps_before_an_exchange_count_their_rounding(lengths):
    # points on a bound are set free only by a gap beyond the rounding that the steps have left in it
    heights, grid, full = white_noise((64, 64), lengths)
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.1 * full, np.inf, grid.nyquist / 2)
    now = started(problem, np.full(grid.shape, 0.1 * full))
    now.check(1e-6, 0.5)
    exchanges._solve_on_free_points(now, 1e-13)
    exact = np.fft.irfft2(compliance(grid.wavenumbers) * np.fft.rfft2(now.pressure), s=grid.shape)
    error = np.std(now.gap - (exact - heights))
    assert error < now.noise < 30 * error


@pytest.mark.parametrize(
    ("blur", "noise", "again"), [(0.2, 0, True), (0, 0.02, True), (0.05, 0.01, False)]
)
def test_rounding_is_weighed_against_the_residual_and_against_the_worst_gap(blur, noise, again):
    # shares of the tolerance: a tenth may be rounding, and the worst point has eight times the rms rounding
    heights, grid = rough()
    problem, tolerance = ScaledProblem(heights, 0.0, 1.0, grid, 0.1, np.inf, grid.nyquist / 4), 1e-3
    now = started(problem, np.maximum(heights, 0.0))
    now.span = now.displacement_span()
    now.noise, done = noise * tolerance * now.span, now.transforms
    state = Check(0.5 * tolerance, 0.0, 1, 1, 0, blur * tolerance)
    solve._check_again(now, state, tolerance, 0.5)
    assert (now.transforms > done) == again


@pytest.mark.parametrize(("load", "cap"), [(0.1, 0.25), (0.1, 0.10001), (0.3, np.inf)])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 1000.0)])
def test_the_displacement_follows_the_pressure_through_single_precision_steps(load, cap, lengths):
    # neither what is snapped onto a bound nor what is added to meet the load may be missing from it
    heights, grid, full = white_noise((128, 128), lengths)
    contact = rs.solve_contact(
        heights, grid, rs.Solid(1.0, cap * full), nominal_pressure=load * full
    )
    exact = np.fft.irfft2(
        compliance(grid.wavenumbers) * np.fft.rfft2(contact.pressure), s=grid.shape
    )
    assert np.abs(contact.displacement - exact).max() <= 3e-7 * np.ptp(exact)


def test_a_step_moves_no_point_further_than_it_says():
    # bounds are met exactly, but by no more than the rounding of the step itself: all points near one share its sign
    rng, cap, slack = np.random.default_rng(4), 1.0, np.float64(2.0 * np.finfo(np.float32).eps)
    pressure = np.concatenate(
        [1.0 - 10.0 ** rng.uniform(-16, -4, 500), 10.0 ** rng.uniform(-16, -4, 500)]
    )
    step = (rng.uniform(-0.9, 0.9, 1000) * np.minimum(pressure, 1 - pressure)).astype(np.float32)
    step[::5] = (np.where(pressure > 0.5, cap, 0.0) - pressure)[::5]
    moved, still = pressure.copy(), np.zeros(1000)
    length = np.float64(1.0)  # typed as a kernel sees it, where numba is switched off too
    kernels.advance(moved, still, step, np.zeros(1000, np.float32), length, slack, (0.0, 1.0, cap))
    assert np.all(np.abs(moved - pressure - step) <= slack * np.abs(step) + 1e-15)
    assert set(moved[::5]) == {0.0, cap}
    assert 0.0 <= moved.min() <= moved.max() <= cap


def test_a_point_near_its_bound_is_judged_by_its_gap_too():
    # p − clip(p − κ gap) sees no more than p; the point is free, so its gap may be twice that
    pressure, gap, limit = np.array([0.6e-3, 1.0, 1.0]), np.array([1.1e-3, -0.9e-3, 1.1e-3]), 1e-3
    free, rest = np.empty(3, np.int8), np.empty(3)
    sums = kernels.classify(pressure, gap, free, rest, (0.0, 1.0, np.inf), solve.REACH, 1.0, limit)
    assert free.tolist() == [1, 1, 1]
    assert sums[-1] == 2


def started(problem, pressure):
    """An iterate of a problem at a pressure."""
    work = workspace_of(problem)
    work.free.fill(0)
    now = Iterate(problem, work, pressure.astype(float), np.empty(problem.grid.shape))
    now.compute_gap(np.float64)
    now.guess_offset()
    return now


@pytest.mark.parametrize("share", [1e-3, 1.0])
def test_the_worst_point_is_judged_against_the_range_of_its_own_displacement(share):
    # the start has the whole load on a few points: a displacement far beyond that of the solution
    heights, grid = rough()
    problem, pressure = (
        ScaledProblem(heights, 0.0, 1.0, grid, 0.05, np.inf, grid.nyquist / 4),
        np.zeros(grid.shape),
    )
    pressure.flat[: max(int(share * 64), 1)] = 1.0
    found = solve.solve_level(problem, pressure, 1e-3, 1000, final=True)
    exact = np.fft.irfft2(compliance(grid.wavenumbers) * np.fft.rfft2(found.pressure), s=grid.shape)
    assert found.residual <= 1e-3
    offset = np.mean((exact - heights)[found.pressure > 0])
    free = found.pressure > 0.05
    assert np.abs((exact - heights)[free] - offset).max() <= 1.5e-3 * np.ptp(exact)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_exchanges_that_lead_in_circles_are_led_out(seed):
    grid = rs.Grid((293, 9), (502.0, 0.03))
    heights = np.exp(1.5 * np.random.default_rng(seed).standard_normal(grid.shape))
    load = (
        4e-4
        * np.abs(np.fft.irfft2(np.fft.rfft2(heights) * grid.wavenumbers / 2, s=grid.shape)).max()
    )
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0, 1.3 * load), nominal_pressure=load)
    assert outer_residual(heights, grid, 1.3 * load, contact.pressure) <= 2e-6


def test_a_failed_solve_leaves_no_trace():
    heights, grid = rough()
    before = fields(0)
    with pytest.raises(rs.ConvergenceError):
        rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.1, max_iterations=2)
    np.testing.assert_array_equal(fields(0), before)


@pytest.mark.parametrize("cap", [np.inf, 0.2])
def test_each_iteration_lowers_the_energy_and_keeps_the_load_and_the_bounds(cap):
    heights, grid = rough()
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.05, cap, 100.0)
    energies = []
    for limit in range(6):
        found = solve.solve_level(problem, None, 1e-12, limit, final=False)
        energies.append(np.sum(found.pressure * (0.5 * (found.gap + heights) - heights)))
        assert found.pressure.mean() == pytest.approx(problem.load, rel=1e-6)
        assert found.pressure.min() >= 0.0
        assert found.pressure.max() <= problem.cap
    assert np.all(np.diff(energies) < 0)


def test_a_gradient_step_keeps_a_load_that_no_offset_meets():
    # the offset is of order one: its last digit is worth more than this load
    heights, grid = rough()
    problem, target = ScaledProblem(heights, 0.0, 1.0, grid, 1e-18, np.inf, 100.0), 1e-18 * 4096
    now = started(problem, np.full(grid.shape, 1e-18))
    now.gap[...] = 1.0 + np.random.default_rng(8).random(grid.shape)
    now.offset = 1.5
    state = now.check(1e-6, 0.5)
    assert 0.1 * target < state.excess < 100.0 * target
    solve.descend(now, state)
    assert now.pressure.sum() / target == pytest.approx(1.0, rel=1e-6)


def test_a_gradient_step_in_several_blocks_is_the_step_in_one():
    # a grid above 512 × 512 has several
    heights, grid = rough()
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.05, 0.12, 100.0)
    begin = np.random.default_rng(6).uniform(0.0, 0.1, grid.shape)
    found = []
    for ends in ((0, 4096), (0, 1024, 4096)):
        now = started(problem, begin)
        now.work = now.work._replace(blocks=list(pairwise(ends)))
        length = solve.descend(now, now.check(1e-6, 0.5))
        assert length.best > 0.0
        found.append(now.pressure.copy())
    np.testing.assert_allclose(found[1], found[0], rtol=1e-5, atol=1e-9)
    assert np.abs(found[0] - begin).max() > 1e-3


def test_a_load_that_no_free_point_can_take_has_no_shift():
    heights, grid = rough()
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.05, np.inf, 100.0)
    now = started(problem, np.full(grid.shape, 0.04))
    assert not now.balance(1e-9)
    assert np.all(now.pressure == 0.04)


def test_balance_moves_the_free_points_alone_and_only_between_the_bounds():
    heights, grid = rough()
    problem = ScaledProblem(heights, 0.0, 1.0, grid, 0.05, 0.12, 100.0)
    now = started(problem, np.random.default_rng(6).uniform(0.0, 0.12, grid.shape))
    now.work.free[::2] = 1
    pressure = now.pressure
    fixed, before = pressure[1::2].copy(), pressure[::2].copy()
    assert now.balance(1e-12)
    np.testing.assert_array_equal(pressure[1::2], fixed)
    shift = np.median(pressure[::2] - before)
    np.testing.assert_allclose(pressure[::2], np.clip(before + shift, 0.0, 0.12), atol=1e-15)
    assert pressure.mean() == pytest.approx(0.05, rel=1e-12)
