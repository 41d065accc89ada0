"""The skewness of long waves: exact for cosines in phase, odd, blind to short waves, and zero in the mean."""

from math import pi

import numpy as np
import pytest

import roughsim as rs
from roughsim.surface.skewness import long_wave_skewness

# ⟨(cos x + cos 2x)³⟩ = 3⟨cos² x cos 2x⟩ = ¾, ⟨(cos x + cos 2x)²⟩ = 1
IN_PHASE = 0.75


def cosines(grid, axis, *waves):
    """Waves along an axis, so many per side."""
    phase = 2 * pi * np.arange(grid.shape[axis]) / grid.shape[axis]
    line = sum(np.cos(number * phase) for number in waves)
    return np.broadcast_to(line[:, None] if axis == 0 else line[None, :], grid.shape).copy()


@pytest.mark.parametrize("shape", [(64, 64), (96, 128), (256, 512), (1000, 1024), (1536, 75)])
@pytest.mark.parametrize("axis", [0, 1])
def test_cosines_in_phase_have_the_exact_skewness(shape, axis):
    grid = rs.Grid(shape, (2e-3, 2e-3))
    heights = 3e-7 * cosines(grid, axis, 5, 10)
    assert long_wave_skewness(heights, grid) == pytest.approx(IN_PHASE, rel=1e-9)
    assert long_wave_skewness(-heights, grid) == -long_wave_skewness(heights, grid)


def test_a_fourth_root_of_the_variance_would_not_be_free_of_the_amplitude():
    # unequal amplitudes: ⟨(cos x + a cos 2x)³⟩ = ¾a, ⟨(…)²⟩ = (1 + a²)/2
    grid = rs.Grid((64, 64), (1.0, 1.0))
    for a in (0.3, 2.0):
        heights = 1e-6 * (cosines(grid, 0, 4) + a * cosines(grid, 0, 8))
        assert long_wave_skewness(heights, grid) == pytest.approx(0.75 * a / (0.5 + 0.5 * a * a) ** 1.5, rel=1e-9)


def test_thirty_two_waves_per_side_count_and_shorter_ones_do_not():
    grid = rs.Grid((512, 512), (1.0, 1.0))
    assert long_wave_skewness(cosines(grid, 0, 16, 32), grid) == pytest.approx(IN_PHASE, rel=1e-9)
    assert long_wave_skewness(cosines(grid, 0, 11, 22, 33), grid) == pytest.approx(IN_PHASE, rel=1e-9)
    assert long_wave_skewness(cosines(grid, 0, 17, 34), grid) == pytest.approx(0.0, abs=1e-12)
    mixed = cosines(grid, 0, 5, 10) + 0.8 * cosines(grid, 1, 40, 80)
    assert long_wave_skewness(mixed, grid) == pytest.approx(IN_PHASE, rel=1e-9)


def test_the_longest_side_says_which_waves_are_long():
    grid = rs.Grid((256, 128), (2.0, 1.0))  # 16 waves along the short side are as long as 32 along the other
    assert long_wave_skewness(cosines(grid, 1, 8, 16), grid) == pytest.approx(IN_PHASE, rel=1e-9)
    assert long_wave_skewness(cosines(grid, 1, 9, 18), grid) == pytest.approx(0.0, abs=1e-12)


def test_a_surface_without_long_waves_has_none():
    grid = rs.Grid((512, 512), (1.0, 1.0))
    assert long_wave_skewness(np.zeros(grid.shape), grid) == 0.0
    assert long_wave_skewness(1e-7 * cosines(grid, 0, 40, 80), grid) == 0.0
    assert long_wave_skewness(np.full(grid.shape, 3.0), grid) == 0.0  # a mean height is no wave


def test_heights_are_not_changed_and_may_be_views():
    grid = rs.Grid((64, 64), (1.0, 1.0))
    heights = cosines(grid, 0, 3, 6)
    before = heights.copy()
    assert long_wave_skewness(heights[::-1], grid) == pytest.approx(IN_PHASE, rel=1e-9)
    np.testing.assert_array_equal(heights, before)


@pytest.mark.statistical
@pytest.mark.parametrize("amplitudes", ["fixed", "gaussian"])
def test_its_mean_over_surfaces_is_zero_and_all_grids_agree(amplitudes):
    spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=4 * 2 * pi, q_max=30 * 2 * pi)
    grids = [rs.Grid((64, 64), (1.0, 1.0)), rs.Grid((144, 144), (1.0, 1.0))]
    draws = np.array(
        [
            [
                long_wave_skewness(rs.synthesize(spectrum, grid, np.random.default_rng(k), amplitudes=amplitudes), grid)
                for grid in grids
            ]
            for k in range(400)
        ]
    )
    np.testing.assert_allclose(draws[:, 0], draws[:, 1], atol=0.05 * draws.std())  # 64 points alias three waves
    assert abs(draws[:, 1].mean()) < 4 * draws[:, 1].std() / 20
    assert draws.std() > 0.01
