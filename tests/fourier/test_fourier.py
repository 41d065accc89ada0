"""The one door to FFTW: against numpy's transforms, and against waves that are known."""

import os
import resource
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from convolution_cases import SHAPES as SHAPES_OF_CONVOLUTIONS
from convolution_cases import field_and_kernel, sum_over_the_field

from roughsim import fourier
from roughsim.fourier import convolution, plans

SIZES = [1, 2, 3, 4, 5, 7, 8, 61, 64]
SHAPES = [
    *((n, n) for n in SIZES),
    *((1, n) for n in SIZES[1:]),
    *((n, 1) for n in SIZES[1:]),
    (8, 61),
    (64, 7),
    (3, 64),
]


def field_of(shape, seed=0):
    return np.random.default_rng(seed).standard_normal(shape)


def half_of(shape):
    return np.fft.rfft2(field_of(shape)) / (shape[0] * shape[1])


@pytest.fixture
def two_threads():
    fourier.set_threads(2)
    yield
    fourier.set_threads(1)


@pytest.mark.parametrize("shape", SHAPES)
def test_forward_is_the_mean_of_the_field_times_a_wave(shape):
    np.testing.assert_allclose(fourier.forward(field_of(shape)), half_of(shape), rtol=0, atol=4e-16)


@pytest.mark.parametrize("shape", SHAPES)
def test_inverse_is_the_sum_of_the_waves(shape):
    np.testing.assert_allclose(
        fourier.inverse(half_of(shape), shape), field_of(shape), rtol=0, atol=1e-14
    )


@pytest.mark.parametrize("shape", [(8, 8), (5, 7), (1, 6), (6, 1)])
def test_the_sign_of_the_exponent(shape):
    # a phase δ along +x sits at exp(+iδ) of q_x > 0; the mirrored mode is its conjugate
    x, y = np.meshgrid(*(np.arange(n) / n for n in shape), indexing="ij")
    kx, ky = min(shape[0] - 1, 1), min(shape[1] - 1, 1)
    half = fourier.forward(np.cos(2 * np.pi * (kx * x + ky * y) + 0.7))
    assert half[kx, ky] == pytest.approx(0.5 * np.exp(0.7j), abs=1e-15)


@pytest.mark.parametrize("shape", SHAPES)
def test_forward_and_inverse_return_the_field(shape):
    field = field_of(shape)
    np.testing.assert_allclose(
        fourier.inverse(fourier.forward(field), shape), field, rtol=0, atol=1e-14
    )


def test_what_goes_in_is_not_changed():
    field, half = field_of((6, 9)), half_of((6, 9))
    before, half_before = field.copy(), half.copy()
    fourier.forward(field)
    fourier.inverse(half, (6, 9))
    np.testing.assert_array_equal(field, before)
    np.testing.assert_array_equal(half, half_before)


def test_what_comes_out_is_not_overwritten_by_the_next_transform():
    first = fourier.forward(field_of((6, 9)))
    kept = first.copy()
    fourier.forward(field_of((6, 9), seed=1))
    np.testing.assert_array_equal(first, kept)
    back = fourier.inverse(first, (6, 9))
    kept = back.copy()
    fourier.inverse(2 * first, (6, 9))
    np.testing.assert_array_equal(back, kept)


def test_strided_fields_are_taken_as_they_are():
    field = field_of((12, 10))
    np.testing.assert_array_equal(fourier.forward(field.T), fourier.forward(field.T.copy()))
    np.testing.assert_array_equal(
        fourier.forward(field[::2, ::-1]), fourier.forward(field[::2, ::-1].copy())
    )


def test_single_precision_stays_single():
    field = field_of((8, 6)).astype(np.float32)
    half = fourier.forward(field)
    assert half.dtype == np.complex64
    np.testing.assert_allclose(half, np.fft.rfft2(field) / 48, atol=1e-7)
    back = fourier.inverse(half, (8, 6))
    assert back.dtype == np.float32
    np.testing.assert_allclose(back, field, atol=1e-6)
    np.testing.assert_allclose(
        fourier.forward(field_of((8, 6))), half_of((8, 6)), rtol=0, atol=4e-16
    )


def test_the_same_field_gives_the_same_bits_again():
    field = field_of((61, 64))
    first = fourier.forward(field)
    for n in range(4, 10):  # drive the plans out of the cache
        fourier.forward(np.zeros((n, n)))
    np.testing.assert_array_equal(fourier.forward(field), first)


@pytest.mark.usefixtures("two_threads")
def test_two_threads_of_fftw_agree_with_numpy():
    assert fourier.get_threads() == 2
    np.testing.assert_allclose(
        fourier.forward(field_of((128, 96))), half_of((128, 96)), rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(
        fourier.inverse(half_of((128, 96)), (128, 96)), field_of((128, 96)), rtol=0, atol=1e-12
    )


def test_two_python_threads_do_not_disturb_each_other():
    fields = [field_of((64, 48), seed) for seed in range(40)]
    alone = [fourier.forward(field) for field in fields]
    with ThreadPoolExecutor(2) as pool:
        together = list(
            pool.map(
                lambda field: fourier.forward(fourier.inverse(fourier.forward(field), field.shape)),
                fields,
            )
        )
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-15)


@pytest.mark.parametrize("shape", [(8, 6), (5, 5)])
def test_a_transform_that_owns_its_buffers(shape):
    transform = fourier.Transform(shape)
    transform.field[...] = field_of(shape)
    np.testing.assert_allclose(transform.forward(), half_of(shape), atol=1e-15)
    np.testing.assert_allclose(transform.inverse(), field_of(shape), atol=1e-14)
    assert transform.inverse() is transform.field
    assert transform.forward() is transform.spectrum


@pytest.mark.parametrize("shape", [(8, 6), (5, 5), (1, 1)])
def test_rows_are_transformed_each_by_itself_and_unscaled(shape):
    rows = fourier.Transform(shape, axes=(1,))
    rows.field[...] = field_of(shape)
    expected = np.fft.rfft(field_of(shape), axis=1)
    np.testing.assert_allclose(rows.forward(), expected, atol=1e-14)
    rows.spectrum[...] = expected
    np.testing.assert_allclose(rows.inverse(), shape[1] * field_of(shape), atol=1e-13)


@pytest.mark.parametrize("count", [0, -1, 1.5, float("nan"), float("inf"), True, "2", None])
def test_a_number_of_threads_that_is_none_is_refused(count):
    with pytest.raises(ValueError, match=r"threads = .* must be a whole number ≥ 1"):
        fourier.set_threads(count)
    assert fourier.get_threads() == 1


@pytest.mark.parametrize("dtype", [np.int64, np.complex128, np.longdouble, bool])
def test_fields_that_are_not_real_floats_are_refused(dtype):
    with pytest.raises(TypeError, match=r"dtype = .* use float32 or float64"):
        fourier.forward(np.ones((4, 4), dtype))


@pytest.mark.parametrize("shape", [(1, 5), (8, 4), (5, 8), (8, 1)])
def test_a_half_spectrum_of_another_grid_is_refused_rather_than_broadcast(shape):
    with pytest.raises(
        ValueError, match=r"spectrum has shape .* but a field of shape \(8, 8\) needs \(8, 5\)"
    ):
        fourier.inverse(np.ones(shape, dtype=complex), (8, 8))


def test_the_backend_names_itself():
    assert fourier.backend().split()[0] in ("pyfftw", "scipy.fft")


def test_scipy_takes_over_without_pyfftw_and_says_so(tmp_path):
    (tmp_path / "pyfftw.py").write_text("raise ImportError")  # stands before an installed one
    code = """
        import warnings
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            from roughsim import fourier
            from roughsim.fourier import convolution
        assert ["scipy.fft takes over" in str(w.message) for w in caught] == [True], caught
        assert fourier.backend().startswith("scipy.fft "), fourier.backend()
        import numpy as np
        for shape in [(1, 1), (5, 8), (8, 5), (1, 7)]:
            field = np.random.default_rng(0).standard_normal(shape)
            half = fourier.forward(field)
            assert abs(half - np.fft.rfft2(field) / field.size).max() < 1e-15
            assert abs(fourier.inverse(half, shape) - field).max() < 1e-14
            rows = fourier.Transform(shape, axes=(1,))
            rows.field[...] = field
            expected = np.fft.rfft(field, axis=1)
            assert abs(rows.forward() - expected).max() < 1e-14
            rows.spectrum[...] = expected
            assert abs(rows.inverse() - shape[1] * field).max() < 1e-13
        assert fourier.forward(np.ones((4, 4), np.float32)).dtype == np.complex64
        from convolution_cases import SHAPES, field_and_kernel, sum_over_the_field
        for shape, padded in SHAPES:
            field, kernel = field_and_kernel(shape, padded)
            expected = sum_over_the_field(field, kernel)
            response = np.ascontiguousarray(fourier.forward(kernel).T)
            np.testing.assert_allclose(convolution.convolve(field, response, padded), expected, rtol=1e-12)
    """
    tests = Path(__file__).parents[1]
    places = os.pathsep.join(map(str, (tmp_path, Path(fourier.__file__).parents[2], tests)))
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={**os.environ, "PYTHONPATH": places},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("shape", "padded"), SHAPES_OF_CONVOLUTIONS)
def test_a_padded_convolution_is_the_sum_over_the_field(shape, padded):
    field, kernel = field_and_kernel(shape, padded)
    expected = sum_over_the_field(field, kernel)
    response = np.ascontiguousarray(fourier.forward(kernel).T)
    np.testing.assert_allclose(convolution.convolve(field, response, padded), expected, rtol=1e-12)


@pytest.mark.parametrize(("count", "points"), [(1, 1), (3, 7), (16, 64), (5, 61)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_lines_are_transformed_there_and_back(count, points, dtype):
    generator, lines = np.random.default_rng(3), plans.Lines(count, points, dtype)
    field = generator.standard_normal((count, points)) + 1j * generator.standard_normal(
        (count, points)
    )
    lines.source[...] = field
    lines.forward()
    accuracy = 50 * np.finfo(dtype).eps * points
    np.testing.assert_allclose(lines.result, np.fft.fft(field, axis=1), rtol=0, atol=accuracy)
    lines.backward()
    np.testing.assert_allclose(lines.source, points * field, rtol=0, atol=points * accuracy)


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
def test_plans_of_lines_lead_between_lines_at_any_distance():
    made = plans.LinePlans(3, 8, (16, 24), np.float64)
    source, result = plans.aligned((3, 16), complex), plans.aligned((3, 24), complex)
    source[:, :8] = field = np.random.default_rng(4).random((3, 8))
    made.execute(made.forward, source.ctypes.data, result.ctypes.data)
    np.testing.assert_allclose(result[:, :8], np.fft.fft(field, axis=1), atol=1e-14)
    assert not result[:, 8:].any()


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
@pytest.mark.skipif(sys.platform != "linux", reason="the memory of a process as Linux shows it")
def test_plans_of_lines_end_with_their_owner():
    def pages():
        return int(Path("/proc/self/statm").read_text().split()[1])

    for _ in range(100):
        plans.LinePlans(3, 1009, (1009, 1009), np.float64)  # a prime: its plans have tables
    before = pages()
    for _ in range(1000):
        plans.LinePlans(3, 1009, (1009, 1009), np.float64)
    assert (pages() - before) * resource.getpagesize() < 2e6  # 8 MB and more if they stayed


@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
def test_a_plan_that_fftw_cannot_make_is_refused():
    with pytest.raises(MemoryError, match="no plan for 3 lines of 0 points"):
        plans.LinePlans(3, 0, (16, 24), np.float32)


@pytest.mark.skipif(plans.pyfftw is None, reason="there is no FFTW")
@pytest.mark.parametrize("missing", ["fftw_make_planner_thread_safe", "fftwf_execute_dft"])
def test_fftw_in_one_precision_is_out_of_reach(monkeypatch, missing):
    monkeypatch.setattr(plans, "function", lambda name: None if name == missing else list)
    with pytest.warns(RuntimeWarning, match="compiled code cannot reach the FFTW"):
        assert not plans.functions()


@pytest.mark.parametrize("dtype", [np.float64, np.complex64])
def test_memory_for_fftw_begins_where_it_is_fastest(dtype):
    for shape in [(1, 1), (3, 5), (64, 33)]:
        memory = plans.aligned(shape, dtype)
        assert (memory.shape, memory.dtype, memory.any()) == (shape, dtype, False)
        assert memory.ctypes.data % plans.ALIGNMENT == 0
        memory[...] = 1


def test_memory_for_fftw_begins_there_wherever_the_system_puts_it():
    kept = [plans.aligned((1, 1 + size), np.uint8) for size in range(400)]
    assert len({memory.base.ctypes.data % plans.ALIGNMENT for memory in kept}) > 1
    assert {memory.ctypes.data % plans.ALIGNMENT for memory in kept} == {0}


@pytest.mark.slow
@pytest.mark.skipif(not fourier.direct(), reason="FFTW is out of reach of compiled code")
def test_fftw_is_found_beside_an_extension_module_that_does_not_give_it():
    beside = plans.libraries()[1:]
    if not beside:
        pytest.skip("this FFTW belongs to the system")
    code = f"""
        import pathlib, sys
        from roughsim import fourier
        from roughsim.fourier import plans
        beside = [pathlib.Path(name) for name in {[str(path) for path in beside]}]
        plans.libraries = lambda: beside
        plans.FUNCTIONS = plans.functions()
        assert fourier.direct()
        plans.Lines(2, 8).forward()
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(plans.pyfftw is None, reason="there is no FFTW")
def test_a_file_beside_that_is_no_library_is_passed_over(monkeypatch, tmp_path):
    (tmp_path / "fftw3.txt").write_text("no library")
    monkeypatch.setattr(plans, "libraries", lambda: [tmp_path / "fftw3.txt"])
    assert plans.function("fftw_execute_dft") is None


@pytest.mark.slow
def test_plans_are_made_from_many_python_threads_at_a_time():
    def work(k):
        lines, field = plans.Lines(2 + k % 3, 30 + k), field_of((20 + k, 16))
        lines.source[...] = 1.0
        lines.forward()
        return (
            abs(lines.result[:, 0] - lines.source.shape[1]).max()
            + abs(fourier.Transform((20 + k, 16)).spectrum).max()
            + abs(fourier.inverse(fourier.forward(field), field.shape) - field).max()
        )

    with ThreadPoolExecutor(8) as pool:
        assert max(pool.map(work, range(200))) < 1e-12
