"""Surfaces: each mode carries ∫C d²q over its cell, whatever the grid; the rest is chance, and fair."""

import itertools

import numpy as np
import pytest

from roughsim.errors import ResolutionError
from roughsim.grid import Grid
from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.synthesis import mode_variance, synthesize

CIRCLE = 2 * np.pi  # in a cell of this side, modes lie at whole wavenumbers
BOTH = ["fixed", "gaussian"]
STEEP = {"hurst": 0.8, "q_roll_off": 5.3, "roll_off_exponent": 1.5}
SPECTRUM = SelfAffineSpectrum.from_rms_height(1.0, q_min=2.3, q_max=13.4, **STEEP)
WIDE = SelfAffineSpectrum.from_rms_height(1.0, q_min=2.3, q_max=55.5, **STEEP)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def panels(edges):
    """Points and weights between sorted edges (first axis); a cubic map flattens square roots at the edges."""
    t = (NODES + 1) / 2
    width = np.diff(edges, axis=0)[..., None]
    points = edges[:-1, ..., None] + width * (t * t * (3 - 2 * t))
    return points, width * (6 * t * (1 - t) * WEIGHTS / 2)


def cell_integral(spectrum, k, steps):
    """∫ C d²q over the cell of mode k in Cartesian coordinates, panels cut where a break's circle crosses."""
    (x0, x1), (y0, y1) = (((n - 0.5) * step, (n + 0.5) * step) for n, step in zip(k, steps, strict=True))
    circles = np.array(spectrum.breaks)
    ends = [x0, x1, 0.0, *circles, *-circles]
    for y in (y0, y1):
        root = np.sqrt(circles[circles > abs(y)] ** 2 - y * y)
        ends += [*root, *-root]
    x, weight = panels(np.unique(np.clip(ends, x0, x1)))
    x, weight = x.ravel(), weight.ravel()
    roots = np.sqrt(np.maximum(circles[:, None] ** 2 - x**2, 0.0))
    zero = np.zeros((1, x.size))
    y, inner = panels(np.sort(np.clip(np.concatenate([zero + y0, zero, zero + y1, roots, -roots]), y0, y1), axis=0))
    return float(weight @ (spectrum(np.hypot(x[:, None], y)) * inner).sum(axis=(0, 2)))


def square(n, length=CIRCLE):
    return Grid((n, n), (length, length))


def variance_by_quadrature(spectrum, n):
    """The whole table of a square cell of side 2π, n odd or C zero at Nyquist, by symmetry from one octant."""
    half = n // 2 + 1
    table = np.zeros((half, half))
    for i, j in itertools.combinations_with_replacement(range(half), 2):
        table[i, j] = table[j, i] = cell_integral(spectrum, (i, j), (1.0, 1.0)) if i + j else 0.0
    rows = np.arange(n)
    return table[np.minimum(rows, n - rows)]


def modes_of(heights):
    return np.fft.rfft2(heights) / heights.size


def draws(spectrum, grid, amplitudes, count, seed=1):
    rng = np.random.default_rng(seed)
    return np.stack([modes_of(synthesize(spectrum, grid, rng, amplitudes=amplitudes)) for _ in range(count)])


# --- variance of a mode ---------------------------------------------------------------------------------------------

CELLS = {
    "inside q_min": (1, 1),
    "crossed by q_min": (2, 0),
    "crossed by q_min off the axis": (2, 1),
    "crossed by the kink": (5, 0),
    "crossed by the kink off the axis": (4, 3),
    "near": (3, 2),
    "near, on the axis": (0, 4),
    "far": (20, 7),
    "far, on the axis": (30, 0),
    "crossed by q_max": (55, 0),
    "crossed by q_max off the axis": (39, 40),
    "barely touched by q_max": (56, 0),
    "beyond q_max": (57, 0),
}


@pytest.mark.parametrize("k", CELLS.values(), ids=CELLS)
def test_the_variance_of_a_mode_is_the_integral_over_its_cell(k):
    expected = cell_integral(WIDE, k, (1.0, 1.0))
    assert mode_variance(WIDE, square(128))[k] == pytest.approx(expected, rel=1e-8, abs=1e-30)


@pytest.mark.filterwarnings("ignore:q_min:RuntimeWarning")
@pytest.mark.parametrize("aspect", [0.02, 0.3, 1.7, 10.0, 50.0])
@pytest.mark.parametrize("k", [(0, 1), (1, 0), (1, 1), (2, 5), (4, 0), (9, 1), (1, 12), (30, 30)])
def test_the_variance_of_a_mode_in_cells_longer_than_wide(aspect, k):
    grid = Grid((128, 128), (CIRCLE, CIRCLE / aspect))
    spectrum = WIDE if aspect >= 1 else SelfAffineSpectrum.from_rms_height(1.0, q_min=0.02, q_max=1.2, hurst=0.8)
    expected = cell_integral(spectrum, k, (1.0, aspect))
    assert mode_variance(spectrum, grid)[k] == pytest.approx(expected, rel=1e-8, abs=1e-30)


@pytest.mark.parametrize("hurst", [0.0, 0.8, 1.0])
@pytest.mark.parametrize("n", [(120, 120), (121, 119), (111, 112), (112, 111), (200, 130)])
def test_all_modes_together_carry_the_whole_spectrum(n, hurst):
    spectrum = SelfAffineSpectrum.from_rms_height(3e-6, hurst=hurst, q_min=2.3, q_roll_off=5.3, q_max=55.5)
    grid = Grid(n, (CIRCLE, CIRCLE))
    total = (grid.multiplicity * mode_variance(spectrum, grid)).sum()
    assert total == pytest.approx(9e-12, rel=1e-9)


@pytest.mark.parametrize("shape", [(32, 32), (32, 48), (48, 32), (33, 32), (32, 33), (33, 33)])
def test_a_band_that_ends_at_the_nyquist_wavenumber_is_complete(shape):
    # cells of Nyquist modes are halved by the circle q_max and stand for both signs: neither doubled nor halved
    grid = Grid(shape, (CIRCLE, CIRCLE))
    spectrum = SelfAffineSpectrum.from_rms_height(1.0, hurst=0.3, q_min=2.3, q_max=grid.nyquist)
    variance = mode_variance(spectrum, grid)
    assert (grid.multiplicity * variance).sum() == pytest.approx(1.0, rel=1e-9)
    if shape[0] == 32:
        assert variance[16, 0] == pytest.approx(2 * cell_integral(spectrum, (16, 0), (1.0, 1.0)), rel=1e-9)
        assert variance[16, 3] == pytest.approx(2 * cell_integral(spectrum, (16, 3), (1.0, 1.0)), rel=1e-9)


@pytest.mark.filterwarnings("ignore:q_min:RuntimeWarning")
@pytest.mark.parametrize("lengths", [(CIRCLE, CIRCLE), (CIRCLE, CIRCLE / 3), (CIRCLE / 10, CIRCLE)])
def test_only_the_cell_of_the_mean_is_left_out(lengths):
    spectrum = SelfAffineSpectrum.from_rms_height(1.0, hurst=0.8, q_min=0.3, q_max=50.0, q_roll_off=0.6)
    grid = Grid((128, 128), lengths)
    variance = mode_variance(spectrum, grid)
    lost = cell_integral(spectrum, (0, 0), tuple(CIRCLE / length for length in lengths))
    assert lost > 0.02
    assert variance[0, 0] == 0
    assert (grid.multiplicity * variance).sum() == pytest.approx(1 - lost, rel=1e-9)


def test_the_variance_follows_the_grid_when_it_is_turned():
    grid, turned = Grid((40, 60), (CIRCLE, 1.3 * CIRCLE)), Grid((60, 40), (1.3 * CIRCLE, CIRCLE))
    one, other = mode_variance(SPECTRUM, grid), mode_variance(SPECTRUM, turned)
    np.testing.assert_allclose(one[:21], other[:31, :21].T, rtol=1e-12, atol=1e-25)
    np.testing.assert_array_equal(one[1:], one[:0:-1])


def test_a_jump_inside_a_sum_with_many_breaks_is_seen():
    q = np.geomspace(2.5, 20.0, 25)
    total = WIDE + TabulatedSpectrum(q, q**-3.0)
    grid = square(128)
    variance = mode_variance(total, grid)
    assert variance[20, 2] == pytest.approx(cell_integral(total, (20, 2), (1.0, 1.0)), rel=1e-8)
    whole = 1 + 2 * np.pi * (1 / 2.5 - 1 / 20)  # ∫ q^(−2) dq
    assert (grid.multiplicity * variance).sum() == pytest.approx(whole, rel=1e-9)


def test_a_strip_one_point_wide_carries_the_modes_along_it():
    for shape, axis in (((1, 64), 1), ((64, 1), 0)):
        grid = Grid(shape, (CIRCLE, CIRCLE))
        variance = mode_variance(SPECTRUM, grid).reshape(-1)
        assert variance[5] == pytest.approx(cell_integral(SPECTRUM, (5, 0), (1.0, 1.0)), rel=1e-9)
        heights = synthesize(SPECTRUM, grid, np.random.default_rng(0))
        full = 2 * sum(cell_integral(SPECTRUM, (k, 0), (1.0, 1.0)) for k in range(1, 16))
        assert (heights**2).mean() == pytest.approx(full, rel=1e-9)
        assert heights.shape[axis] == 64


def test_one_point_has_no_roughness():
    assert synthesize(SPECTRUM, Grid((1, 1), (CIRCLE, CIRCLE)), np.random.default_rng(0)) == 0.0


# --- one draw -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(48, 48), (33, 34), (35, 33), (28, 40), (1, 64), (64, 1)])
@pytest.mark.parametrize("seed", [0, 1])
def test_fixed_amplitudes_give_the_same_rms_height_and_slope_in_every_draw(shape, seed):
    grid = Grid(shape, (CIRCLE, 1.2 * CIRCLE))
    heights = synthesize(SPECTRUM, grid, np.random.default_rng(seed))
    power = abs(np.fft.fft2(heights) / heights.size) ** 2
    qx = np.fft.fftfreq(shape[0], 1 / shape[0])[:, None]
    qy = np.fft.fftfreq(shape[1], 1 / shape[1])[None, :] / 1.2
    variance = grid.multiplicity * mode_variance(SPECTRUM, grid)
    q2 = qx**2 + qy[:, : shape[1] // 2 + 1] ** 2
    assert (heights**2).mean() == pytest.approx(variance.sum(), rel=1e-12)
    assert ((qx**2 + qy**2) * power).sum() == pytest.approx((q2 * variance).sum(), rel=1e-12)
    np.testing.assert_allclose(abs(modes_of(heights)), np.sqrt(mode_variance(SPECTRUM, grid)), rtol=0, atol=1e-15)


@pytest.mark.parametrize("amplitudes", BOTH)
def test_heights_are_real_with_mean_zero(amplitudes):
    for shape in [(32, 32), (27, 32), (32, 27)]:
        heights = synthesize(SPECTRUM, Grid(shape, (CIRCLE,) * 2), np.random.default_rng(2), amplitudes=amplitudes)
        assert heights.dtype == np.float64
        assert heights.shape == shape
        assert abs(heights.mean()) < 1e-12 * heights.std()


def test_amplitudes_are_fixed_unless_asked_otherwise():
    one = synthesize(SPECTRUM, square(32), np.random.default_rng(2))
    np.testing.assert_array_equal(one, synthesize(SPECTRUM, square(32), np.random.default_rng(2), amplitudes="fixed"))
    other = synthesize(SPECTRUM, square(32), np.random.default_rng(2), amplitudes="gaussian")
    assert abs((other**2).mean() - (one**2).mean()) > 1e-6


@pytest.mark.parametrize("amplitudes", BOTH)
def test_the_same_stream_gives_the_same_bits_and_another_does_not(amplitudes):
    first, again, other = (
        synthesize(SPECTRUM, square(32), np.random.default_rng(seed), amplitudes=amplitudes) for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(first, again)
    assert abs(first - other).max() > 0.1
    rng = np.random.default_rng(7)
    synthesize(SPECTRUM, square(32), rng, amplitudes=amplitudes)
    assert abs(synthesize(SPECTRUM, square(32), rng, amplitudes=amplitudes) - first).max() > 0.1


# --- the same stream on other grids ---------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitudes", BOTH)
@pytest.mark.parametrize("fine", [(96, 96), (64, 32), (32, 160)])
def test_a_finer_grid_shows_the_same_surface_at_the_shared_points(amplitudes, fine):
    surfaces = [
        synthesize(SPECTRUM, Grid(n, (CIRCLE, 1.1 * CIRCLE)), np.random.default_rng(5), amplitudes=amplitudes)
        for n in ((32, 32), fine)
    ]
    shared = surfaces[1][:: fine[0] // 32, :: fine[1] // 32]
    np.testing.assert_allclose(shared, surfaces[0], rtol=0, atol=3e-14)


@pytest.mark.parametrize("amplitudes", BOTH)
@pytest.mark.parametrize("q_max", [6.0, 9.5, 13.0, 21.3, 31.4])
@pytest.mark.parametrize("aspect", [1.0, 1.37])
def test_a_higher_q_max_only_adds_modes(amplitudes, q_max, aspect):
    grid = Grid((128, 160), (CIRCLE, aspect * CIRCLE))
    low, high = (
        modes_of(synthesize(s, grid, np.random.default_rng(5), amplitudes=amplitudes))
        for s in (WIDE.truncated(q_max=q_max), WIDE)
    )
    kx = abs(np.fft.fftfreq(128, 1 / 128))[:, None]
    ky = np.arange(81)[None, :]
    inside = np.hypot(kx + 0.5, (ky + 0.5) / aspect) < q_max
    np.testing.assert_allclose(low[inside], high[inside], rtol=0, atol=1e-14)
    # a cell crossed by q_max keeps its phase and loses variance; noise of the transform is 1e-17
    crossed = ~inside & (np.hypot(np.maximum(kx - 0.5, 0), np.maximum(ky - 0.5, 0) / aspect) < 0.999 * q_max)
    ratio = low[crossed] / high[crossed]
    assert inside.sum() >= 40
    assert abs(ratio.imag).max() < 1e-9
    assert ratio.real.min() > 0
    assert ratio.real.max() < 1 + 1e-9


@pytest.mark.parametrize("amplitudes", BOTH)
def test_a_band_that_ends_at_nyquist_shares_all_other_modes_with_a_finer_grid(amplitudes):
    spectrum = SelfAffineSpectrum.from_rms_height(1.0, hurst=0.8, q_min=2.3, q_max=16.0)
    coarse, fine = (
        modes_of(synthesize(spectrum, square(n), np.random.default_rng(5), amplitudes=amplitudes)) for n in (32, 64)
    )
    np.testing.assert_allclose(coarse[:16, :16], fine[:16, :16], rtol=0, atol=1e-14)
    np.testing.assert_allclose(coarse[17:, :16], fine[49:, :16], rtol=0, atol=1e-14)
    assert abs(coarse[16, :16]).max() > 1e-4


# --- chance ---------------------------------------------------------------------------------------------------------


@pytest.mark.statistical
@pytest.mark.parametrize("n", [31, 36])
def test_the_mean_power_spectrum_of_gaussian_surfaces_is_the_given_one(n):
    count = 256
    power = (abs(draws(SPECTRUM, square(n), "gaussian", count)) ** 2).mean(axis=0)
    expected = variance_by_quadrature(SPECTRUM, n)
    kx, ky = np.fft.fftfreq(n, 1 / n)[:, None], np.arange(n // 2 + 1)[None, :]
    ring = np.rint(np.hypot(kx, ky)).astype(int)
    independent = (ky > 0) | (kx > 0)
    for radius in range(2, 14):
        bin_ = independent & (ring == radius) & (expected > 0)
        ratio = power[bin_].sum() / expected[bin_].sum()
        # each mode is exponential: its mean over the draws scatters by variance/√K, independently of the others
        scatter = np.sqrt((expected[bin_] ** 2).sum() / count) / expected[bin_].sum()
        assert abs(ratio - 1) < min(4 * scatter, 3 / np.sqrt(count)), radius
    every = independent & (expected > 1e-12)
    assert abs(power[every] / expected[every] - 1).max() < 6 / np.sqrt(count)
    assert (power[expected == 0] < 1e-30).all()


@pytest.mark.statistical
def test_gaussian_modes_are_complex_normal_and_fixed_ones_only_turn():
    grid, count = square(29), 256
    deviation = np.sqrt(variance_by_quadrature(SPECTRUM, 29))
    kx, ky = np.fft.fftfreq(29, 1 / 29)[:, None], np.arange(15)[None, :]
    some = ((ky > 0) | (kx > 0)) & (deviation > 1e-6)
    sample = draws(SPECTRUM, grid, "gaussian", count)[:, some] / deviation[some]
    error = 1 / np.sqrt(sample.size)
    assert abs(sample.mean()) < 4 * error
    assert abs((sample**2).mean()) < 4 * np.sqrt(2) * error  # equal, uncorrelated real and imaginary parts
    assert abs((abs(sample) ** 4).mean() - 2) < 4 * np.sqrt(20) * error  # exponential intensity
    turned = draws(SPECTRUM, grid, "fixed", count)[:, some] / deviation[some]
    np.testing.assert_allclose(abs(turned), 1, atol=1e-8)
    for harmonic in (1, 2, 3, 4):  # uniform phases
        assert abs((turned**harmonic).mean()) < 4 * error


@pytest.mark.statistical
@pytest.mark.parametrize("n", [8, 10])
def test_nyquist_modes_carry_their_variance(n):
    # flat C up to Nyquist: self-conjugate modes are real, the others on the edge complex
    spectrum = SelfAffineSpectrum(1.0, 0.0, 1.0, n / 2, n / 2)
    sample = draws(spectrum, square(n), "gaussian", 4000)
    variance = mode_variance(spectrum, square(n))
    edge = {(n // 2, 0): 2.0, (0, n // 2): 2.0, (n // 2, 1): 1.0, (1, n // 2): 1.0, (n - 1, n // 2): 1.0, (2, 0): 1.0}
    for k, relative_variance in edge.items():  # of the intensity: 2 for a real normal number, 1 for a complex one
        mean = (abs(sample[(..., *k)]) ** 2).mean() / variance[k]
        assert abs(mean - 1) < 4 * np.sqrt(relative_variance / 4000), k
    assert abs(sample[:, n // 2, 0].imag).max() < 1e-15
    np.testing.assert_allclose(sample[:, 1, 0], sample[:, -1, 0].conj(), atol=1e-15)


def test_fixed_modes_on_the_edge_keep_their_amplitude_and_take_either_sign():
    spectrum = SelfAffineSpectrum(1.0, 0.0, 1.0, 4.0, 4.0)
    sample = draws(spectrum, square(8), "fixed", 200)
    deviation = np.sqrt(mode_variance(spectrum, square(8)))
    np.testing.assert_allclose(abs(sample), np.broadcast_to(deviation, sample.shape), rtol=0, atol=1e-15)
    for k in ((4, 0), (0, 4)):  # their own conjugates: real, plus or minus with equal chance
        assert abs(np.sign(sample[(..., *k)].real).mean()) < 4 / np.sqrt(200)


@pytest.mark.statistical
def test_heights_of_a_gaussian_surface_have_the_kurtosis_of_a_gaussian():
    rng, grid, count = np.random.default_rng(11), square(32), 4000
    z = np.array([synthesize(SPECTRUM, grid, rng, amplitudes="gaussian")[3, 5] for _ in range(count)])
    assert abs(z.mean()) < 4 / np.sqrt(count)
    assert abs((z**2).mean() - 1) < 4 * np.sqrt(2 / count)
    assert abs((z**3).mean()) < 4 * np.sqrt(15 / count)
    assert abs((z**4).mean() / (z**2).mean() ** 2 - 3) < 4 * np.sqrt(24 / count)


@pytest.mark.statistical
@pytest.mark.parametrize("amplitudes", BOTH)
def test_no_direction_is_preferred(amplitudes):
    # ⟨h_x²⟩ − ⟨h_y²⟩ and ⟨h_x h_y⟩ vanish; their scatter is estimated from the draws
    sample = draws(SPECTRUM, square(32), amplitudes, 128)
    kx, ky = np.fft.fftfreq(32, 1 / 32)[:, None], np.arange(17)[None, :]
    power = abs(sample) ** 2 * np.where(ky == 0, 1.0, 2.0)
    for pattern in (kx**2 - ky**2, 2 * kx * ky):
        moment = (pattern * power).sum(axis=(1, 2))
        size = ((kx**2 + ky**2) * power).sum(axis=(1, 2)).mean()
        assert abs(moment.mean()) < 4 * moment.std() / np.sqrt(128) + 1e-12 * size
    mixed = np.einsum("nij,nji->n", sample[:, :17, :17], sample[:, :17, :17].conj())
    assert abs(mixed.mean()) < 1.1 * abs(sample[0, np.arange(17), np.arange(17)] ** 2).sum() + 4 * mixed.std()


# --- other spectra --------------------------------------------------------------------------------------------------


class Plateau:
    """C = level between 2.3 and 9.9 rad/m; anything with `breaks` will do."""

    __hash__ = None
    breaks = (2.3, 9.9)

    def __init__(self, level=1e-2):
        self.level = level

    def __call__(self, q):
        q = np.asarray(q)
        return np.where((q >= 2.3) & (q <= 9.9), self.level, 0.0)


class HashedPlateau(Plateau):
    __hash__ = object.__hash__


@pytest.mark.parametrize("kind", [Plateau, HashedPlateau])
def test_any_callable_with_breaks_is_a_spectrum(kind):
    spectrum = kind()
    heights = synthesize(spectrum, square(32), np.random.default_rng(0))
    area = np.pi * (9.9**2 - 2.3**2)
    assert (heights**2).mean() == pytest.approx(1e-2 * area, rel=1e-9)
    spectrum.level *= 4  # a spectrum that can change must not be remembered
    twice = synthesize(spectrum, square(32), np.random.default_rng(0))
    np.testing.assert_allclose(twice, 2 * heights, rtol=1e-12)


def test_a_plateau_in_a_callable_a_table_and_a_self_affine_spectrum_is_one_surface():
    spectra = [Plateau(), TabulatedSpectrum([2.3, 5.0, 9.9], [1e-2] * 3), SelfAffineSpectrum(1e-2, 0.5, 2.3, 9.9, 9.9)]
    one, two, three = (synthesize(s, square(32), np.random.default_rng(0)) for s in spectra)
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-12)
    np.testing.assert_allclose(three, one, rtol=0, atol=1e-12)


@pytest.mark.parametrize("level", [-1e-2, float("nan"), float("inf")])
def test_a_spectrum_that_is_negative_or_not_finite_is_refused(level):
    with pytest.raises(ValueError, match=r"spectrum = .* must give C\(q\) finite and ≥ 0"):
        synthesize(Plateau(level), square(32), np.random.default_rng(0))


# --- refusals -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(26, 26), (26, 64), (64, 26), (1, 26)])
def test_a_grid_that_cannot_hold_the_spectrum_is_refused(shape):
    message = r"q_max = 13\.4 rad/m exceeds the Nyquist wavenumber 13 rad/m of the grid \(\d+, 26\)|\(26, \d+\)"
    with pytest.raises(ResolutionError, match=message) as error:
        synthesize(SPECTRUM, Grid(shape, (CIRCLE, CIRCLE)), np.random.default_rng(0))
    assert "refine the grid" in str(error.value)
    synthesize(SPECTRUM, square(27), np.random.default_rng(0))


def test_waves_longer_than_the_cell_are_announced():
    with pytest.warns(RuntimeWarning, match=r"q_min = 2\.3 rad/m lies below 3 rad/m.*enlarge the cell"):
        synthesize(SPECTRUM, square(32, CIRCLE / 3), np.random.default_rng(0))
    synthesize(SPECTRUM, square(32, CIRCLE / 2.3), np.random.default_rng(0))


def test_waves_lost_in_a_narrow_cell_are_announced():
    # the cell of q = 0 reaches to q_x = 5 here, far above the lowest mode 2π/L = 1
    with pytest.warns(RuntimeWarning, match=r"q_min = 2\.3 rad/m lies below 5\.025 rad/m"):
        synthesize(SPECTRUM, Grid((32, 32), (CIRCLE / 10, CIRCLE)), np.random.default_rng(0))


@pytest.mark.parametrize("rng", [None, 5, np.random, np.random.RandomState(0)])
def test_randomness_must_be_handed_in(rng):
    with pytest.raises(TypeError, match=r"rng = .* must be a numpy Generator; make one with np\.random\.default_rng"):
        synthesize(SPECTRUM, square(32), rng)


@pytest.mark.parametrize("amplitudes", ["Gaussian", "random", "", None, True])
def test_misspelt_amplitudes_are_refused(amplitudes):
    with pytest.raises(ValueError, match=r'amplitudes = .* must be "fixed" or "gaussian"'):
        synthesize(SPECTRUM, square(32), np.random.default_rng(0), amplitudes=amplitudes)
