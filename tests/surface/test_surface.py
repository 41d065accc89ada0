"""Surfaces: each mode carries ∫C d²q over its cell, whatever the grid, and what is no surface is refused."""

import numpy as np
import pytest
from some_rows import some
from surface_cases import CIRCLE, SPECTRUM, WIDE, cell_integral, square

from roughsim.errors import ResolutionError
from roughsim.grid import Grid
from roughsim.surface.modes import mode_variance
from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.surface.synthesis import synthesize

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
@pytest.mark.parametrize("aspect", some([0.02, 0.3, 1.7, 10.0, 50.0], 2))
@pytest.mark.parametrize("k", [(0, 1), (1, 0), (1, 1), (2, 5), (4, 0), (9, 1), (1, 12), (30, 30)])
def test_the_variance_of_a_mode_in_cells_longer_than_wide(aspect, k):
    grid = Grid((128, 128), (CIRCLE, CIRCLE / aspect))
    spectrum = (
        WIDE
        if aspect >= 1
        else SelfAffineSpectrum.from_rms_height(1.0, q_min=0.02, q_max=1.2, hurst=0.8)
    )
    expected = cell_integral(spectrum, k, (1.0, aspect))
    assert mode_variance(spectrum, grid)[k] == pytest.approx(expected, rel=1e-8, abs=1e-30)


@pytest.mark.parametrize("hurst", [0.0, 0.8, 1.0])
@pytest.mark.parametrize("n", [(120, 120), (121, 119), (111, 112), (112, 111), (200, 130)])
def test_all_modes_together_carry_the_whole_spectrum(n, hurst):
    spectrum = SelfAffineSpectrum.from_rms_height(
        3e-6, hurst=hurst, q_min=2.3, q_roll_off=5.3, q_max=55.5
    )
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
        assert variance[16, 0] == pytest.approx(
            2 * cell_integral(spectrum, (16, 0), (1.0, 1.0)), rel=1e-9
        )
        assert variance[16, 3] == pytest.approx(
            2 * cell_integral(spectrum, (16, 3), (1.0, 1.0)), rel=1e-9
        )


@pytest.mark.filterwarnings("ignore:q_min:RuntimeWarning")
@pytest.mark.parametrize("lengths", [(CIRCLE, CIRCLE), (CIRCLE, CIRCLE / 3), (CIRCLE / 10, CIRCLE)])
def test_only_the_cell_of_the_mean_is_left_out(lengths):
    spectrum = SelfAffineSpectrum.from_rms_height(
        1.0, hurst=0.8, q_min=0.3, q_max=50.0, q_roll_off=0.6
    )
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


@pytest.mark.parametrize("times", [0, 2])
@pytest.mark.parametrize("kind", [Plateau, HashedPlateau])
def test_any_callable_with_breaks_is_a_spectrum(kind, times):
    own = spectrum = kind()
    for _ in range(times):
        spectrum = TruncatedSpectrum(spectrum)
    heights = synthesize(spectrum, square(32), np.random.default_rng(0))
    area = np.pi * (9.9**2 - 2.3**2)
    assert (heights**2).mean() == pytest.approx(1e-2 * area, rel=1e-9)
    own.level *= 4  # a spectrum that can change must not be remembered
    twice = synthesize(spectrum, square(32), np.random.default_rng(0))
    np.testing.assert_allclose(twice, 2 * heights, rtol=1e-12)


def test_a_plateau_in_a_callable_a_table_and_a_self_affine_spectrum_is_one_surface():
    spectra = [
        Plateau(),
        TabulatedSpectrum([2.3, 5.0, 9.9], [1e-2] * 3),
        SelfAffineSpectrum(1e-2, 0.5, 2.3, 9.9, 9.9),
    ]
    one, two, three = (synthesize(s, square(32), np.random.default_rng(0)) for s in spectra)
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-12)
    np.testing.assert_allclose(three, one, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", [(26, 26), (26, 64), (64, 26), (1, 26)])
def test_a_grid_that_cannot_hold_the_spectrum_is_refused(shape):
    message = r"q_max = 13\.4 rad/m exceeds the Nyquist wavenumber 13 rad/m of the grid \(\d+, 26\)|\(26, \d+\)"
    with pytest.raises(ResolutionError, match=message) as error:
        synthesize(SPECTRUM, Grid(shape, (CIRCLE, CIRCLE)), np.random.default_rng(0))
    assert "refine the grid" in str(error.value)
    synthesize(SPECTRUM, square(27), np.random.default_rng(0))


def test_waves_longer_than_the_cell_are_announced():
    with pytest.warns(
        RuntimeWarning, match=r"q_min = 2\.3 rad/m lies below 3 rad/m.*enlarge the cell"
    ):
        synthesize(SPECTRUM, square(32, CIRCLE / 3), np.random.default_rng(0))
    synthesize(SPECTRUM, square(32, CIRCLE / 2.3), np.random.default_rng(0))


def test_waves_lost_in_a_narrow_cell_are_announced():
    # the cell of q = 0 reaches to q_x = 5 here, far above the lowest mode 2π/L = 1
    with pytest.warns(RuntimeWarning, match=r"q_min = 2\.3 rad/m lies below 5\.025 rad/m"):
        synthesize(SPECTRUM, Grid((32, 32), (CIRCLE / 10, CIRCLE)), np.random.default_rng(0))


def test_waves_that_are_their_own_mirror_images_have_either_sign_equally_often():
    grid, generator = Grid((8, 8), (CIRCLE, CIRCLE)), np.random.default_rng(3)
    spectrum = SelfAffineSpectrum.from_rms_height(1.0, hurst=0.8, q_min=2.3, q_max=grid.nyquist)
    waves = [np.fft.rfft2(synthesize(spectrum, grid, generator)) for _ in range(2000)]
    for own in ((4, 0), (0, 4)):
        signs = np.sign([wave[own].real for wave in waves])
        assert (signs != 0.0).all()
        assert abs(signs.mean()) < 4 / np.sqrt(2000)
