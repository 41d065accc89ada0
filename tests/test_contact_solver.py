"""The contact solver inside: its operator, preconditioner and cascade, its accounts of rounding, and how it runs."""

import multiprocessing
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import roughsim as rs
from roughsim import fourier
from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import refine
from roughsim.contact import active_set
from roughsim.contact import operator as operators
from roughsim.contact.blocks import spans
from roughsim.contact.extension import Extension
from roughsim.contact.operator import Operator, PlainOperator, rms_compliance

SIZES = [1, 2, 3, 4, 5, 7, 8, 61, 64]


def rough(points=64, *, slope=0.5, seed=0, per_wave=4):
    grid = rs.Grid((points, points), (1.0, 1.0))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        slope, hurst=0.8, q_min=2 * np.pi, q_roll_off=4 * np.pi, q_max=grid.nyquist * 2 / per_wave
    )
    return rs.synthesize(spectrum, grid, np.random.default_rng(seed)), grid


def dense_product(field, lengths, weight):
    """F⁻¹ weight(|q|) F field by matrices of exponentials: the definition, without an FFT."""
    waves, q = [], []
    for points, length in zip(field.shape, lengths, strict=True):
        n = np.arange(points)
        waves.append(np.exp(-2j * np.pi * np.outer(n, n) / points))
        q.append(2 * np.pi / length * np.where(n <= points // 2, n, n - points))
    wavenumber = np.hypot(q[0][:, None], q[1][None, :])
    spectrum = weight(wavenumber) * (waves[0] @ field @ waves[1])
    return (waves[0].conj() @ spectrum @ waves[1].conj()).real / field.size


def compliance(q):
    return np.divide(2.0, q, out=np.zeros_like(q), where=q > 0)


@pytest.mark.parametrize("rows", SIZES)
@pytest.mark.parametrize("columns", SIZES)
@pytest.mark.parametrize("kind", [Operator, PlainOperator])
def test_the_operator_is_its_definition_by_a_dense_transform(rows, columns, kind):
    grid = rs.Grid((rows, columns), (1.0, 1.7))
    field = np.random.default_rng(rows * 100 + columns).standard_normal(grid.shape)
    for dtype, accuracy in ((np.float64, 1e-13), (np.float32, 2e-6)):
        operator, result = kind(grid, dtype), np.empty(grid.shape, dtype)
        for apply, weight in ((operator.comply, compliance), (operator.stiffen, lambda q: q / 2)):
            expected = dense_product(field, grid.lengths, weight)
            apply(field.astype(dtype), result)
            scale = np.abs(expected).max() or 1.0
            np.testing.assert_allclose(result, expected, rtol=0, atol=accuracy * scale)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (6, 5), (64, 61), (300, 32)])
@pytest.mark.parametrize("kind", [Operator, PlainOperator])
def test_the_half_spectrum_is_numpys_and_comes_back(shape, kind):
    field = np.random.default_rng(1).standard_normal(shape)
    operator, back = kind(rs.Grid(shape, (1.0, 1.0)), np.float64), np.empty(shape)
    np.testing.assert_allclose(operator.forward(field).T, np.fft.rfft2(field) / field.size, atol=1e-15)
    operator.inverse(back)
    np.testing.assert_allclose(back, field, atol=1e-14)


@pytest.mark.parametrize("shape", [(12, 10), (9, 11), (64, 61)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("divided", [("rows",), ("columns",), ("rows", "columns")], ids="-".join)
def test_block_by_block_is_the_same_as_in_one_call(shape, dtype, divided, monkeypatch):
    generator, grid = np.random.default_rng(5), rs.Grid(shape, (1.0, 1.0))
    field, free = generator.standard_normal(shape).astype(dtype), generator.integers(0, 2, shape).astype(np.int8)
    results = []
    for parts in ((), divided):
        if parts:
            for name, value in (("CACHED", 1), ("GROUP", 2), ("POINTS", shape[0] * shape[1] // 2)):
                monkeypatch.setattr(operators, name, value)
        operator, extension = Operator(grid, dtype), Extension(grid, dtype)
        for name in {"rows", "columns"}.difference(parts):  # several groups may be left in the one block
            blocks = operator._row_blocks if name == "rows" else operator._column_blocks
            blocks[:] = [(0, blocks[-1][1])]
        assert (len(operator._row_blocks) > 1, len(operator._column_blocks) > 1) == (
            "rows" in parts,
            "columns" in parts,
        )
        if "rows" in parts:
            extension.rows = [(0, 4), (4, shape[0])]
        if "columns" in parts:
            extension.parent_rows = [(0, 1), (1, (shape[0] + 1) // 2)]
        one, two, three = np.empty(shape, dtype), np.empty(shape, dtype), field * free
        operator.comply(field, one)
        operator.stiffen(field, two)
        extension.extend(free, three)
        four = three.copy()
        products = extension.transpose(free, four, one, two)
        results.append((one, two, three, four, np.array(products)))
    for whole, part in zip(*results, strict=True):
        np.testing.assert_allclose(part, whole, rtol=0, atol=50 * np.finfo(dtype).eps * np.abs(whole).max())


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_each_column_begins_where_fftw_may_take_it(dtype):
    for shape in ((1, 9), (5, 8), (8, 5), (61, 16)):
        spectrum = Operator(rs.Grid(shape, (1.0, 1.0)), dtype).complex_spectrum
        assert all(column.ctypes.data % fourier.ALIGNMENT == 0 for column in spectrum)


def test_without_fftw_in_reach_of_compiled_code_the_fields_are_the_same_and_it_is_told():
    code = """
        import sys, warnings
        import numpy as np
        from roughsim import fourier
        fourier._libraries = lambda: []
        import roughsim as rs
        heights = np.random.default_rng(0).standard_normal((40, 36))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            p = rs.solve_contact(heights, rs.Grid((40, 36), (1.0, 1.0)), rs.Solid(1.0), nominal_pressure=2.0).pressure
        assert ["cannot reach the FFTW" in str(w.message) for w in caught] == [True], caught
        assert fourier.backend().endswith("out of reach of compiled code")
        sys.stdout.buffer.write(p.tobytes())
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    heights = np.random.default_rng(0).standard_normal((40, 36))
    grid = rs.Grid((40, 36), (1.0, 1.0))
    pressure = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=2.0).pressure
    plain = np.frombuffer(done.stdout).reshape(40, 36)
    assert np.linalg.norm(plain - pressure) <= 2e-6 * np.linalg.norm(pressure)


def push_pull(weight, value, spacing):
    """The extension, written as its definition: loops over cells, one level at a time."""
    if weight.shape == (1, 1):
        return value
    # both sides of a cell are doubled, or the much shorter one, or the one along which there is more than one cell
    twice = [
        n > 1 and (m == 1 or side <= 1.5 * other)
        for n, m, side, other in zip(weight.shape, weight.shape[::-1], spacing, spacing[::-1], strict=True)
    ]
    factors = [2 if double else 1 for double in twice]
    shape = [-(-n // factor) for n, factor in zip(weight.shape, factors, strict=True)]
    total, mean = np.zeros(shape), np.zeros(shape)
    for i, j in np.ndindex(weight.shape):
        parent = i // factors[0], j // factors[1]
        total[parent] += weight[i, j]
        mean[parent] += weight[i, j] * value[i, j]
    mean = np.divide(mean, total, out=np.zeros(shape), where=total > 0)
    whole = 3 if all(twice) else 1.5
    coarse = push_pull(np.minimum(total / whole, 1), mean, [f * side for f, side in zip(factors, spacing, strict=True)])
    result = np.empty(weight.shape)
    for i, j in np.ndindex(weight.shape):
        rows, columns = (parents(k, n, double) for k, n, double in zip((i, j), shape, twice, strict=True))
        linear = sum(a * b * coarse[k, m] for k, a in rows for m, b in columns)
        result[i, j] = weight[i, j] * value[i, j] + (1 - weight[i, j]) * linear
    return result


def parents(child, number, double):
    if not double:
        return [(child, 1.0)]
    return [(child // 2, 0.75), ((child // 2 + (1 if child % 2 else -1)) % number, 0.25)]


@pytest.mark.parametrize("shape", [(8, 8), (7, 5), (1, 6), (9, 1), (13, 16), (2, 3), (1, 1), (5, 32), (3, 2)])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 20.0), (300.0, 1.0), (1.0, 1.6)])
def test_the_extension_is_push_pull_and_its_transpose_the_transpose(shape, lengths):
    rng = np.random.default_rng(2)
    free = (rng.random(shape) < 0.3).astype(np.int8)
    free.flat[0] = 1
    grid = rs.Grid(shape, lengths)
    extension = Extension(grid, np.float64)
    field, other = rng.standard_normal(shape) * free, rng.standard_normal(shape)
    step, response = rng.standard_normal(shape), rng.standard_normal(shape)
    extended, gathered = field.copy(), other.copy()
    extension.extend(free, extended)
    cross, own = extension.transpose(free, gathered, step, response)
    np.testing.assert_allclose(extended, push_pull(free.astype(float), field, grid.spacing), atol=1e-14)
    assert np.sum(extended * other) == pytest.approx(np.sum(field * gathered), rel=1e-12)
    assert cross == pytest.approx(np.sum(gathered * response), rel=1e-12)
    assert own == pytest.approx(np.sum(free * step * response), rel=1e-12)
    assert np.all(gathered[free == 0] == 0.0)


@pytest.mark.parametrize("shape", [((32, 32), (64, 64)), ((33, 32), (65, 32)), ((50, 20), (100, 39))])
def test_interpolation_to_a_finer_grid_errs_at_third_order(shape):
    errors = []
    for factor in (1, 2):
        coarse, fine = (tuple(n * factor if n > 1 else n for n in s) for s in shape)
        x, y = np.arange(coarse[0]) / coarse[0], np.arange(coarse[1]) / coarse[1]
        wave = 2.0 + np.add.outer(np.cos(2 * np.pi * x), np.sin(4 * np.pi * y))
        pressure, free = np.empty(fine), np.empty(fine, np.int8)
        total, count = refine(0, fine[0], wave, np.inf, pressure, free)
        x, y = np.arange(fine[0]) / fine[0], np.arange(fine[1]) / fine[1]
        errors.append(np.abs(pressure - 2.0 - np.add.outer(np.cos(2 * np.pi * x), np.sin(4 * np.pi * y))).max())
        assert total == pytest.approx(pressure.sum(), rel=1e-12)
        assert count == np.count_nonzero(pressure)
    assert errors[0] < 0.1
    assert errors[1] < errors[0] / 7


def test_blocks_cover_all_rows_and_start_at_even_ones():
    for rows, columns in ((1, 1), (7, 3), (64, 64), (1001, 999), (5, 1 << 20)):
        blocks = spans(rows, columns)
        assert [b for _, b in blocks[:-1]] == [a for a, _ in blocks[1:]]
        assert (blocks[0][0], blocks[-1][1]) == (0, rows)
        assert all(a % 2 == 0 for a, _ in blocks)


def outer_residual(heights, grid, cap, pressure):
    """The residual with numpy's transform and a bisected offset."""
    waves = (2 * np.pi * np.fft.fftfreq(n, a / n) for n, a in zip(grid.shape, grid.lengths, strict=True))
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
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-6, 1e-9, 1e-12])
def test_the_reported_residual_holds_outside_though_steps_are_single(cap, tolerance):
    # float32 steps must not show: what rounding leaves is bounded by a tenth of the tolerance
    heights, grid = rough(256)
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.1, tolerance=tolerance)
    assert contact.residual <= tolerance
    assert outer_residual(heights, grid, cap, contact.pressure) <= 1.2 * tolerance


def test_loads_that_float32_cannot_hold_are_stepped_in_float64():
    heights, grid = rough()
    for load, kind in ((1e-3, np.float32), (1e-20, np.float64)):
        assert active_set.Problem(heights, 0.0, 1.0, grid, load, np.inf, 100.0).step_type is kind


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
        work.append(rs.solve_contact(heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.1).transforms)
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


def pressed(heights, grid, threads):
    """Solve with so many threads: the contact solver's own pool, not FFTW's, which do not survive a fork."""
    try:
        rs.set_threads(threads)
        return rs.solve_contact(heights, grid, rs.Solid(1.0, 0.3), nominal_pressure=0.1).pressure
    finally:
        rs.set_threads(1)


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("start", ["spawn", "fork"])
def test_a_new_process_gives_the_same_bits(start):
    heights, grid = rough(520)
    expected = pressed(heights, grid, 2)  # leaves a pool of threads, which a fork does not inherit
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(start)) as pool:
        moved = pool.submit(pressed, heights, grid, 2).result(timeout=60)
    np.testing.assert_array_equal(moved, expected)


@pytest.mark.parametrize(("threads", "points"), [(1, 1024), (2, 1024), pytest.param(1, 2048, marks=pytest.mark.slow)])
def test_an_interrupt_ends_the_solve_soon_and_leaves_it_usable(threads, points):
    heights, grid = rough(points)
    expected = fields(1)
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        rs.set_threads(threads)
        signal.setitimer(signal.ITIMER_REAL, 0.1)
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
    monkeypatch.setattr(active_set.Iteration, "advance", lambda self: None)
    monkeypatch.setattr(active_set, "exchange_points", lambda state: None)
    heights, grid = rough()
    with pytest.raises(
        rs.ConvergenceError, match=r"stalled: residual .* after \d+ iterations, tolerance 1e-06"
    ) as caught:
        rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.1)
    assert active_set.PATIENCE < caught.value.iterations < 10 * active_set.PATIENCE
    assert caught.value.residual > 1e-6
    assert caught.value.pressure.shape == grid.shape


def white_noise(shape, lengths):
    """Noise on every pixel, and the range of its full-contact pressure."""
    heights, grid = 0.02 * np.random.default_rng(3).standard_normal(shape), rs.Grid(shape, lengths)
    return heights, grid, np.abs(np.fft.irfft2(np.fft.rfft2(heights) * grid.wavenumbers / 2, s=shape)).max()


@pytest.mark.parametrize("cap", [np.inf, 0.25])
@pytest.mark.parametrize(
    ("shape", "lengths"), [((64, 64), (1.0, 1000.0)), ((8, 8192), (1.0, 1.0)), ((301, 7), (1, 1e-3))]
)
def test_noise_on_every_pixel_of_oblong_cells_is_solved_with_little_work(shape, lengths, cap):
    heights, grid, full = white_noise(shape, lengths)
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0, cap * full), nominal_pressure=0.1 * full)
    assert contact.transforms < 400
    assert outer_residual(heights, grid, cap * full, contact.pressure) <= 2e-6


@pytest.mark.parametrize("cap", [np.inf, 0.3])
def test_exchanges_of_points_alone_lead_to_the_solution(cap, monkeypatch):
    heights, grid = rough()
    solid = rs.Solid(1.0, cap)
    expected = rs.solve_contact(heights, grid, solid, nominal_pressure=0.1, tolerance=1e-9).pressure
    monkeypatch.setattr(active_set.Iteration, "advance", lambda self: None)
    alone = rs.solve_contact(heights, grid, solid, nominal_pressure=0.1, tolerance=1e-9).pressure
    np.testing.assert_allclose(alone, expected, atol=1e-8 * expected.max())


@pytest.mark.parametrize(("load", "cap"), [(0.1, 0.25), (0.1, 0.10001), (0.3, np.inf)])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 1000.0)])
def test_the_displacement_follows_the_pressure_through_single_precision_steps(load, cap, lengths):
    # neither what is snapped onto a bound nor what is added to meet the load may be missing from it
    heights, grid, full = white_noise((256, 256), lengths)
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0, cap * full), nominal_pressure=load * full)
    exact = np.fft.irfft2(compliance(grid.wavenumbers) * np.fft.rfft2(contact.pressure), s=grid.shape)
    assert np.abs(contact.displacement - exact).max() <= 3e-7 * np.ptp(exact)


def test_a_step_moves_no_point_further_than_it_says():
    # bounds are met exactly, but by no more than the rounding of the step itself: all points near one share its sign
    rng, cap, slack = np.random.default_rng(4), 1.0, np.float64(2.0 * np.finfo(np.float32).eps)
    pressure = np.concatenate([1.0 - 10.0 ** rng.uniform(-16, -4, 500), 10.0 ** rng.uniform(-16, -4, 500)])
    step = (rng.uniform(-0.9, 0.9, 1000) * np.minimum(pressure, 1 - pressure)).astype(np.float32)
    step[::5] = (np.where(pressure > 0.5, cap, 0.0) - pressure)[::5]
    moved, still = pressure.copy(), np.zeros(1000)
    length = np.float64(1.0)  # typed as a kernel sees it, where numba is switched off too
    kernels.advance(0, 1000, moved, still, step, np.zeros(1000, np.float32), length, slack, (0.0, 1.0, cap))
    assert np.all(np.abs(moved - pressure - step) <= slack * np.abs(step) + 1e-15)
    assert set(moved[::5]) == {0.0, cap}
    assert 0.0 <= moved.min() <= moved.max() <= cap


def test_a_point_near_its_bound_is_judged_by_its_gap_too():
    # p − clip(p − κ gap) sees no more than p; the point is free, so its gap may be twice that
    pressure, gap, limit = np.array([0.6e-3, 1.0, 1.0]), np.array([1.1e-3, -0.9e-3, 1.1e-3]), 1e-3
    free, rest = np.empty(3, np.int8), np.empty(3)
    sums = kernels.classify(0, 3, pressure, gap, (0.0, 1.0, np.inf), active_set.REACH, 1.0, limit, free, rest)
    assert free.tolist() == [1, 1, 1]
    assert sums[-1] == 2


def test_the_worst_point_is_judged_against_the_range_of_its_own_displacement():
    heights, grid = rough()
    state = active_set.Iteration(active_set.Problem(heights, 0.0, 1.0, grid, 0.05, np.inf, grid.nyquist / 4))
    state.pressure[...] = 0.0
    state.pressure[7, 5] = 4096 * 0.05  # the whole load on one point: a displacement far beyond that of the solution
    state.refresh(np.float64)
    state.solve(1e-3, 1000, final=True)
    exact = np.fft.irfft2(compliance(grid.wavenumbers) * np.fft.rfft2(state.pressure), s=grid.shape)
    assert state.residual <= 1e-3
    assert state.range == pytest.approx(np.ptp(exact), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_exchanges_that_lead_in_circles_are_led_out(seed):
    grid = rs.Grid((293, 9), (502.0, 0.03))
    heights = np.exp(1.5 * np.random.default_rng(seed).standard_normal(grid.shape))
    load = 4e-4 * np.abs(np.fft.irfft2(np.fft.rfft2(heights) * grid.wavenumbers / 2, s=grid.shape)).max()
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0, 1.3 * load), nominal_pressure=load)
    assert outer_residual(heights, grid, 1.3 * load, contact.pressure) <= 2e-6


def test_the_mean_square_compliance_is_that_of_all_modes():
    for shape, lengths in (((6, 5), (1.0, 3.0)), ((300, 700), (1.0, 1.0)), ((1, 8), (1.0, 2.0)), ((1, 1), (1.0, 1.0))):
        grid = rs.Grid(shape, lengths)
        qx, qy = (2 * np.pi * np.fft.fftfreq(n, a / n) for n, a in zip(shape, lengths, strict=True))
        expected = np.sqrt(np.mean(compliance(np.hypot(qx[:, None], qy)) ** 2))
        assert rms_compliance(grid) == pytest.approx(expected, rel=1e-12)


def test_a_failed_solve_leaves_no_trace():
    heights, grid = rough()
    before = fields(0)
    with pytest.raises(rs.ConvergenceError):
        rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.1, max_iterations=2)
    np.testing.assert_array_equal(fields(0), before)


def test_a_conjugate_step_lowers_the_energy_and_keeps_the_load():
    heights, grid = rough()
    problem = active_set.Problem(heights, 0.0, 1.0, grid, 0.05, 0.2, 100.0)
    state = active_set.Iteration(problem)
    state.pressure[...] = problem.load
    state.refresh(np.float64)
    state.begin()
    energies = []
    for _ in range(6):
        state.assess(1e-6)
        energies.append(np.sum(state.pressure * (0.5 * (state.gap + heights) - heights)))
        state.advance()
        assert state.pressure.mean() == pytest.approx(problem.load, rel=1e-6)
        assert state.pressure.min() >= 0.0
        assert state.pressure.max() <= problem.cap
    assert np.all(np.diff(energies) < 0)


def test_a_gradient_step_keeps_a_load_that_no_offset_meets(monkeypatch):
    # the offset is of order one: its last digit is worth more than this load
    heights, grid = rough()
    state = active_set.Iteration(active_set.Problem(heights, 0.0, 1.0, grid, 1e-18, np.inf, 100.0))
    state.pressure[...] = 1e-18
    state.gap[...] = 1.0 + np.random.default_rng(8).random(grid.shape)
    state.offset = 1.5
    state.assess(1e-6)
    monkeypatch.setattr(state, "_length", lambda slope: 0.0)
    state._fall_back()
    assert 0.1 * state.target < state.excess < 100.0 * state.target
    assert (state.pressure + state.step).sum() / state.target == pytest.approx(1.0, rel=1e-6)


def test_a_load_that_no_free_point_can_take_has_no_shift():
    heights, grid = rough()
    state = active_set.Iteration(active_set.Problem(heights, 0.0, 1.0, grid, 0.05, np.inf, 100.0))
    state.pressure[...] = 0.04
    assert state.load_shift((0.04 * 4096, 0), 1e-9) is None
