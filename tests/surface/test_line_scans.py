"""C(q) of line scans and of long maps: exact cases, what the scatter does to them, and their errors."""

import math

import numpy as np
import pytest
from scipy.special import gamma

import roughsim as rs
from roughsim.surface.topography.measured import levelled, map_spectrum
from roughsim.surface.topography.profiles import line_modes, of_surface

SIDE = 100e-6
UNIT = 2 * math.pi / SIDE


@pytest.mark.parametrize("s", [1.4, 1.8, 2.2])
def test_the_line_spectrum_of_a_known_surface_gives_its_spectrum(s):
    # C = (1 + a²q²)^(−s) has C₁ = √π Γ(s − ½)/(a Γ(s)) (1 + a²k²)^(½ − s), a known integral
    a, k = 1e-6, 1e4 * np.arange(1, 600)
    along = math.sqrt(math.pi) * gamma(s - 0.5) / (a * gamma(s)) * (1 + (a * k) ** 2) ** (0.5 - s)
    found = of_surface(k, along)
    assert found.variance == pytest.approx(2 * np.trapezoid(along, k), rel=0.02)  # of k and −k
    # within 3 % also at the end, where the waves beyond the last mode are those of its power law
    np.testing.assert_allclose(found.psd, (1 + (a * found.q) ** 2) ** -s, rtol=0.03)
    np.testing.assert_allclose(found.psd[2:-8], (1 + (a * found.q[2:-8]) ** 2) ** -s, rtol=0.016)


def test_the_line_spectrum_of_a_cosine_is_its_variance():
    # h = A cos(qx): ⟨h²⟩ = A²/2 = ∫C₁ dk over all k; under the window a wave keeps its variance on average
    x = np.arange(256) * (SIDE / 256)
    for periodic, tolerance in ((True, 1e-12), (False, 1e-9)):
        k, along, together = line_modes(3e-7 * np.cos(20 * UNIT * x + 0.3), SIDE, periodic=periodic)
        assert 2 * along.sum() * UNIT == pytest.approx(9e-14 / 2, rel=tolerance)
        assert k[0] == pytest.approx(UNIT)
        # of w = sin²: ⟨w⁴⟩ = 35/128 and ⟨w²⟩ = 3/8
        assert together == pytest.approx(1.0 if periodic else 35 / 128 / (3 / 8) ** 2)


@pytest.mark.statistical
def test_lines_across_an_isotropic_surface_have_its_spectrum():
    law = rs.SelfAffineSpectrum.from_rms_height(
        1e-7, hurst=0.8, q_min=2 * UNIT, q_roll_off=8 * UNIT, q_max=200 * UNIT
    )
    grid = rs.Grid((1024, 512), (2 * SIDE, SIDE))
    along, count = 0.0, 0
    for seed in range(6):
        heights = rs.synthesize(law, grid, np.random.default_rng(seed), amplitudes="gaussian")
        for column in range(0, 512, 16):
            k, own, together = line_modes(levelled(heights[:512, column]), SIDE, periodic=False)
            along, count = along + own, count + 1
    found = of_surface(k, along / count, together=together, lines=count)
    inside = (found.q > 15 * UNIT) & (found.q < 150 * UNIT)
    ratio = found.psd[inside] / law(found.q[inside])
    assert ratio.mean() == pytest.approx(1.0, abs=0.05)
    # each row within its error: neighbours share it, so the sum of squares is at most that of the rows
    assert np.sqrt(np.mean(((ratio - 1) / found.error[inside]) ** 2)) < 1.5


def test_the_spectrum_of_a_line_is_positive_however_it_scatters():
    k = UNIT * np.arange(1, 200)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        found = of_surface(
            k, rng.exponential(size=k.size) * (1 + (k / (9 * UNIT)) ** 2) ** -1.3, together=1.94
        )
        assert (found.psd > 0.0).all()
        assert (found.error > 0.0).all()
    with pytest.raises(ValueError, match="only 2 bins of wavenumbers"):
        of_surface(UNIT * np.arange(1.0, 2.5), np.ones(2))


@pytest.mark.statistical
def test_the_error_of_a_row_of_a_line_is_its_scatter():
    # modes of Gaussian heights, each the mean over 400 lines: neighbours are hardly put together then
    a, s, lines = 1e-6, 1.8, 400
    k = 1e4 * np.arange(1, 600)
    along = math.sqrt(math.pi) * gamma(s - 0.5) / (a * gamma(s)) * (1 + (a * k) ** 2) ** (0.5 - s)
    rng = np.random.default_rng(7)
    found = [
        of_surface(k, along * rng.gamma(lines, 1 / lines, k.size), lines=lines) for _ in range(200)
    ]
    steep = slice(
        -9, -2
    )  # below, C(q) is flat and rows are put together; beyond, the end of the line counts
    scatter = (
        np.std([one.psd for one in found], axis=0)[steep]
        / np.mean([one.psd for one in found], axis=0)[steep]
    )
    stated = np.mean([one.error for one in found], axis=0)[steep]
    np.testing.assert_allclose(scatter, stated, rtol=0.25)


@pytest.mark.statistical
@pytest.mark.parametrize(
    ("aspect", "scatter", "turned"),
    [
        *((1, 0.113, False), (4, 0.035, True)),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in ((1, 0.113, True), (4, 0.035, False), (16, 0.019, False), (16, 0.019, True))
        ),
    ],
)
def test_a_long_map_is_known_the_better_the_longer_it_is(aspect, scatter, turned):
    # many windowed discs along the strip, half over one another: their mean scatters by less, and the error says so
    law = rs.SelfAffineSpectrum.from_rms_height(
        1e-7, hurst=0.8, q_min=UNIT / 2, q_roll_off=4 * UNIT, q_max=30 * UNIT
    )
    points, wide = 64 * aspect, max(128 * aspect, 256)
    large = rs.Grid((wide, 256), (SIDE * wide / 64, 4 * SIDE))
    shape = (64, points) if turned else (points, 64)
    grid = rs.Grid(shape, (SIDE * shape[0] / 64, SIDE * shape[1] / 64))
    ratios, errors = [], []
    for seed in range(16):
        heights = rs.synthesize(law, large, np.random.default_rng(seed), amplitudes="gaussian")[
            :points, :64
        ]
        found = map_spectrum(levelled(heights.T if turned else heights), grid, periodic=False)
        inside = (found.q > 4 * UNIT) & (found.q < 25 * UNIT)
        ratios.append(np.mean(found.psd[inside] / law(found.q[inside])))
        errors.append(math.sqrt((found.error[inside] ** 2).sum()) / inside.sum())
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03 + 4 * scatter / 4)
    # of 16 maps a standard deviation is known to 18 %
    assert np.std(ratios) == pytest.approx(scatter, rel=0.6)
    assert np.mean(errors) == pytest.approx(scatter, rel=0.35)


def test_discs_along_a_strip_hold_its_ends_and_scatter_as_their_overlap_says():
    from roughsim.surface.topography.measured import discs, share_of_scatter

    parts, part = discs(rs.Grid((100, 40), (5 * SIDE, 2 * SIDE)))
    assert part.shape == (40, 40)
    assert [place[0].start for place in parts] == [0, 20, 40, 60]
    one, _ = discs(rs.Grid((40, 40), (SIDE, SIDE)))
    assert one == [(slice(0, 40), slice(None))]
    # two that are apart halve the scatter, two in one place do not change it
    weight = np.ones((4, 4))
    apart = [(slice(0, 4), slice(None)), (slice(4, 8), slice(None))]
    assert share_of_scatter(weight, apart) == pytest.approx(0.5)
    assert share_of_scatter(weight, [apart[0], apart[0]]) == pytest.approx(1.0)
    # half over one another: correlation ½, its square counts: (1 + ¼)/2
    assert share_of_scatter(weight, [apart[0], (slice(2, 6), slice(None))]) == pytest.approx(0.625)
