"""The operator, the extension and the interpolation of the contact solver, each beside its definition."""

import subprocess
import sys
import textwrap
from itertools import pairwise

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim import fourier
from roughsim._kernels.interpolation import interpolate
from roughsim.contact.solver import operators
from roughsim.contact.solver.operators import Extension, Operator, PlainOperator, rms_compliance
from roughsim.fourier.blocks import spans

SIZES = [1, 2, 3, 4, 5, 7, 8, 61, 64]


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


@pytest.mark.parametrize("rows", some(SIZES, 2))
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
    np.testing.assert_allclose(
        operator.forward(field).T, np.fft.rfft2(field) / field.size, atol=1e-15
    )
    operator.inverse(back)
    np.testing.assert_allclose(back, field, atol=1e-14)


@pytest.mark.parametrize("shape", [(12, 10), (9, 11), (64, 61)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("divided", [("rows",), ("columns",), ("rows", "columns")], ids="-".join)
def test_block_by_block_is_the_same_as_in_one_call(shape, dtype, divided, monkeypatch):
    generator, grid = np.random.default_rng(5), rs.Grid(shape, (1.0, 1.0))
    field, free = (
        generator.standard_normal(shape).astype(dtype),
        generator.integers(0, 2, shape).astype(np.int8),
    )
    results = []
    for parts in ((), divided):
        if parts:
            for name, value in (("CACHED", 1), ("GROUP", 2), ("POINTS", shape[0] * shape[1] // 2)):
                monkeypatch.setattr(operators, name, value)
        operator, extension = Operator(grid, dtype), Extension(grid, dtype)
        for name in {"rows", "columns"}.difference(
            parts
        ):  # several groups may be left in the one block
            blocks = operator.row_blocks if name == "rows" else operator.column_blocks
            blocks[:] = [(0, blocks[-1][1])]
        assert (len(operator.row_blocks) > 1, len(operator.column_blocks) > 1) == (
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
        np.testing.assert_allclose(
            part, whole, rtol=0, atol=50 * np.finfo(dtype).eps * np.abs(whole).max()
        )


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_each_column_begins_where_fftw_may_take_it(dtype):
    for shape in ((1, 9), (5, 8), (8, 5), (61, 16)):
        spectrum = Operator(rs.Grid(shape, (1.0, 1.0)), dtype).complex_spectrum
        assert all(column.ctypes.data % fourier.plans.ALIGNMENT == 0 for column in spectrum)


@pytest.mark.slow
def test_without_fftw_in_reach_of_compiled_code_the_fields_are_the_same_and_it_is_told():
    code = """
        import sys, warnings
        import numpy as np
        from roughsim import fourier
        import roughsim as rs
        fourier.plans.libraries = lambda: []
        heights = np.random.default_rng(0).standard_normal((40, 36))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            fourier.plans.FUNCTIONS = fourier.plans.functions()
            p = rs.solve_contact(heights, rs.Grid((40, 36), (1.0, 1.0)), rs.Solid(1.0), nominal_pressure=2.0).pressure
        assert ["cannot reach the FFTW" in str(w.message) for w in caught] == [True], caught
        assert fourier.backend().endswith("out of reach of compiled code")
        sys.stdout.buffer.write(p.tobytes())
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, check=False
    )
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
        for n, m, side, other in zip(
            weight.shape, weight.shape[::-1], spacing, spacing[::-1], strict=True
        )
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
    coarse = push_pull(
        np.minimum(total / whole, 1),
        mean,
        [f * side for f, side in zip(factors, spacing, strict=True)],
    )
    result = np.empty(weight.shape)
    for i, j in np.ndindex(weight.shape):
        rows, columns = (
            parents(k, n, double) for k, n, double in zip((i, j), shape, twice, strict=True)
        )
        linear = sum(a * b * coarse[k, m] for k, a in rows for m, b in columns)
        result[i, j] = weight[i, j] * value[i, j] + (1 - weight[i, j]) * linear
    return result


def parents(child, number, double):
    if not double:
        return [(child, 1.0)]
    return [(child // 2, 0.75), ((child // 2 + (1 if child % 2 else -1)) % number, 0.25)]


@pytest.mark.parametrize(
    "shape", [(8, 8), (7, 5), (1, 6), (9, 1), (13, 16), (2, 3), (1, 1), (5, 32), (3, 2)]
)
@pytest.mark.parametrize(
    "lengths", some([(1.0, 1.0), (1.0, 20.0), (300.0, 1.0), (1.0, 1.6)], 2, pairs=True)
)
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
    np.testing.assert_allclose(
        extended, push_pull(free.astype(float), field, grid.spacing), atol=1e-14
    )
    assert np.sum(extended * other) == pytest.approx(np.sum(field * gathered), rel=1e-12)
    assert cross == pytest.approx(np.sum(gathered * response), rel=1e-12)
    assert own == pytest.approx(np.sum(free * step * response), rel=1e-12)
    assert np.all(gathered[free == 0] == 0.0)
    # load that bounds add to the other points is taken from the free points: the transpose, but on the free points
    load = other * (1 - free)
    change, pressure = step.copy(), rng.uniform(0.0, 2.0, shape)
    clipped, count = extension.gather_load(free, load, pressure, 1.5, change)
    assert np.sum(field * (step - change)) == pytest.approx(
        np.sum(extended * load), rel=1e-11, abs=1e-12
    )
    trial = pressure + change
    assert clipped == pytest.approx(np.clip(trial, 0.0, 1.5).sum(), rel=1e-12)
    assert count == np.count_nonzero((trial >= 0.0) & (trial <= 1.5) & (free == 1))
    assert np.array_equal(change[free == 0], step[free == 0])
    if free.any():  # nothing is lost
        assert np.sum(step - change) == pytest.approx(load.sum(), rel=1e-10, abs=1e-11)


@pytest.mark.parametrize(
    "shape", [((32, 32), (64, 64)), ((33, 32), (65, 32)), ((50, 20), (100, 39)), ((9, 8), (5, 6))]
)
def test_a_start_on_another_grid_is_interpolated_to_second_order(shape):
    errors = []
    for factor in (1, 2):
        coarse, fine = (tuple(n * factor for n in s) for s in shape)
        waves = []
        for n, m in (coarse, fine):
            x, y = np.arange(n) / n, np.arange(m) / m
            waves.append(2.0 + np.add.outer(np.cos(2 * np.pi * x), np.sin(2 * np.pi * y)))
        found, position = np.empty(fine), np.arange(fine[1]) * (coarse[1] / fine[1])
        left = position.astype(np.intp)
        interpolate(0, fine[0], waves[0], left, position - left, found)
        errors.append(np.abs(found - waves[1]).max())
    assert errors[0] < 0.2
    assert errors[1] < errors[0] / 3


def test_blocks_cover_all_rows_and_start_at_even_ones():
    for rows, columns in ((1, 1), (7, 3), (64, 64), (1001, 999), (5, 1 << 20)):
        blocks = spans(rows, columns)
        assert [b for _, b in blocks[:-1]] == [a for a, _ in blocks[1:]]
        assert (blocks[0][0], blocks[-1][1]) == (0, rows)
        assert all(a % 2 == 0 for a, _ in blocks)


def test_the_mean_square_compliance_is_that_of_all_modes():
    for shape, lengths in (
        ((6, 5), (1.0, 3.0)),
        ((300, 700), (1.0, 1.0)),
        ((1, 8), (1.0, 2.0)),
        ((1, 1), (1.0, 1.0)),
    ):
        grid = rs.Grid(shape, lengths)
        qx, qy = (2 * np.pi * np.fft.fftfreq(n, a / n) for n, a in zip(shape, lengths, strict=True))
        expected = np.sqrt(np.mean(compliance(np.hypot(qx[:, None], qy)) ** 2))
        assert rms_compliance(grid) == pytest.approx(expected, rel=1e-12)


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
@pytest.mark.parametrize("threads", [1, 2])
def test_planes_of_a_block_are_divided_only_where_threads_can_share_them(threads):
    fourier.set_threads(threads)
    try:
        large, small = (Operator(rs.Grid((n, n), (1.0, 1.0)), np.float64) for n in (512, 256))
    finally:
        fourier.set_threads(1)
    for blocks, count in ((large.row_blocks, 256), (large.column_blocks, 257)):
        assert len(blocks) == threads
        assert (blocks[0][0], blocks[-1][1]) == (0, count)
        assert all(a[1] == b[0] for a, b in pairwise(blocks))
    assert small.row_blocks == [(0, 128)]


def test_parents_are_gathered_in_as_many_blocks_as_their_children():
    for shape, blocks in (((1024, 1024), 4), ((1025, 1023), 5), ((512, 512), 1), ((63, 64), 1)):
        extension = Extension(rs.Grid(shape, shape), np.float32)  # of square pixels
        rows = [row for a, b in extension.parent_rows for row in range(a, b)]
        assert rows == list(range((shape[0] + 1) // 2))
        assert len(extension.rows) == len(extension.parent_rows) == blocks
