"""Surfaces drawn from C(q⃗) that depends on the direction of the wave."""

import math

import numpy as np
import pytest

import roughsim as rs
from roughsim.surface.directions import (
    DirectedSpectrum,
    Directions,
    measured_directions,
    with_lays,
)
from roughsim.surface.modes import mode_variance

SIDE = 1e-3
Q = 2 * math.pi / SIDE
LAW = rs.SelfAffineSpectrum.from_rms_height(
    1e-6, hurst=0.8, q_min=4 * Q, q_roll_off=8 * Q, q_max=20.3 * Q
)
GRID = rs.Grid((64, 64), (SIDE, SIDE))


def table(rng, rows=5, angles=45):
    """A random table of M over the band of `LAW`."""
    values = rng.uniform(0.2, 2.0, (rows, angles))
    return Directions(
        tuple(np.geomspace(3 * Q, 21 * Q, rows).tolist()),
        tuple(tuple(row) for row in values.tolist()),
    )


def integral(spectrum, mode, points=400):
    """∫ C(q⃗) d²q over the Fourier cell of a mode by many points."""
    steps = (np.arange(points) + 0.5) / points - 0.5
    qx, qy = (mode[0] + steps[:, None]) * Q, (mode[1] + steps) * Q
    q, angle = np.hypot(qx, qy), np.arctan2(qy, qx)
    return float(np.mean(spectrum.at(q, angle))) * Q**2


def test_factor_has_mean_1_and_the_period_of_half_a_turn():
    factor = table(np.random.default_rng(1))
    angle = np.arange(45 * 64) * (math.pi / 45 / 64)
    for q in (2 * Q, 5.3 * Q, 11 * Q, 40 * Q):
        found = factor(np.full(angle.shape, q), angle)
        assert found.mean() == pytest.approx(1.0, rel=1e-12)
        np.testing.assert_allclose(
            factor(np.full(angle.shape, q), angle + math.pi), found, rtol=1e-9
        )


def test_factor_is_linear_between_rows_and_angles():
    rows = ((1.0, 3.0, 2.0, 2.0), (1.0, 1.0, 1.0, 5.0))
    factor = Directions((Q, 4 * Q), rows)
    first, second = np.array(rows[0]) / 2.0, np.array(rows[1]) / 2.0
    assert factor(Q, math.pi / 4) == pytest.approx(first[1])
    assert factor(2 * Q, 3 * math.pi / 8) == pytest.approx(
        0.25 * (first[1] + first[2] + second[1] + second[2])
    )
    # between the last angle and half a turn, and beyond the rows
    assert factor(9 * Q, 7 * math.pi / 8) == pytest.approx(0.5 * (second[3] + second[0]))


@pytest.mark.parametrize("kind", ["table", "lays"])
def test_mode_variance_of_directions_is_the_integral(kind):
    if kind == "table":
        spectrum = DirectedSpectrum(LAW, table(np.random.default_rng(2)))
    else:
        gentle = rs.SelfAffineSpectrum.from_rms_height(
            1e-6, hurst=0.8, q_min=3 * Q, q_roll_off=3 * Q, q_max=12 * Q
        )
        spectrum = with_lays([(gentle, 3.0, 0.5), (gentle.scaled(0.3), 2.0, 1.9)])
    variance = mode_variance(spectrum, GRID)
    for mode in [(4, 0), (0, 5), (3, 4), (-3, 4), (-7, 7), (12, 5), (-18, 9), (20, 2), (-4, 1)]:
        # Gauss points in a cell over which C(q⃗) has kinks or ends
        expected = pytest.approx(integral(spectrum, mode), rel=0.02, abs=2e-3 * variance.max())
        assert variance[mode] == expected


def test_directions_keep_the_rms_height():
    isotropic = mode_variance(LAW, GRID)
    directed = mode_variance(DirectedSpectrum(LAW, table(np.random.default_rng(3))), GRID)
    total = np.sum(isotropic * GRID.multiplicity)
    assert np.sum(directed * GRID.multiplicity) == pytest.approx(total, rel=1e-12, abs=0.0)
    assert np.max(directed) > 1.1 * np.max(isotropic)


@pytest.mark.parametrize(("ratio", "most"), [(1.0, 3e-3), (3.0, 5e-3)])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_lay_has_the_slope_of_the_stretched_cell(ratio, most, angle):
    face = rs.SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=0.6, q_min=6 * Q, q_roll_off=9 * Q, q_max=20 * Q
    )
    grid = rs.Grid((128, 128), (SIDE, SIDE))
    spectrum = with_lays([(face, ratio, angle)])
    variance = mode_variance(spectrum, grid) * grid.multiplicity
    assert variance.sum() == pytest.approx(face.moment(0), rel=1e-3, abs=0.0)
    slopes = face.moment(2) * 0.5 * (ratio + 1 / ratio)
    assert np.sum(variance * grid.wavenumbers**2) == pytest.approx(slopes, rel=most)
    qx, qy = np.broadcast_arrays(*grid.wavevectors)
    along = qx * math.cos(angle) + qy * math.sin(angle)
    assert np.sum(variance * along**2) == pytest.approx(face.moment(2) / 2 / ratio, rel=0.01)


def test_directions_without_effect_give_the_bits_of_isotropy():
    plain = Directions((Q, 9 * Q), ((1.0,) * 45, (1.0,) * 45))
    directed = DirectedSpectrum(LAW, plain)
    np.testing.assert_array_equal(mode_variance(directed, GRID), mode_variance(LAW, GRID))
    drawn = [rs.synthesize(one, GRID, np.random.default_rng(4)) for one in (directed, LAW)]
    np.testing.assert_array_equal(*drawn)


def test_directions_keep_the_phase_of_each_mode():
    sharp = Directions((Q,), ((1.0, *(0.0,) * 44),))
    for grid in (GRID, rs.Grid((96, 96), (SIDE, SIDE))):
        spectra = [
            np.fft.rfft2(rs.synthesize(one, grid, np.random.default_rng(5)))
            for one in (DirectedSpectrum(LAW, sharp), LAW)
        ]
        strong = np.abs(spectra[0]) > 1e-3 * np.abs(spectra[0]).max()
        turn = np.angle(spectra[0][strong] / spectra[1][strong])
        assert np.abs(turn).max() < 1e-6
        assert 10 < strong.sum() < (np.abs(spectra[1]) > 1e-12 * np.abs(spectra[1]).max()).sum() / 4


def test_a_sum_of_faces_has_the_directions_of_each():
    first = DirectedSpectrum(LAW, table(np.random.default_rng(6)))
    both = first + LAW
    expected = mode_variance(first, GRID) + mode_variance(LAW, GRID)
    largest = expected.max()
    np.testing.assert_allclose(mode_variance(both, GRID), expected, rtol=1e-3, atol=1e-6 * largest)
    assert both.rms_height == pytest.approx(math.sqrt(2) * LAW.rms_height, rel=1e-12)
    cut = first.scaled(2.0).truncated(q_max=10 * Q)
    assert cut.directed
    assert cut.moment(2) == pytest.approx(2 * LAW.truncated(q_max=10 * Q).moment(2), rel=1e-12)


def test_a_nyquist_mode_has_both_directions():
    law = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=4 * Q, q_max=32 * Q)
    spectrum = DirectedSpectrum(law, table(np.random.default_rng(7)))
    found = mode_variance(spectrum, GRID)
    for mode in ((32, 5), (3, 32)):
        other = (-mode[0], mode[1]) if mode[0] == 32 else (mode[0], -mode[1])
        expected = integral(spectrum, mode) + integral(spectrum, other)
        assert found[mode] == pytest.approx(expected, rel=0.05, abs=0.0)  # a part of a cell


@pytest.mark.statistical
def test_measured_directions_are_those_of_the_drawn_map():
    rows = tuple(
        tuple(1.0 + a * np.cos(2 * np.arange(45) * math.pi / 45 - 1.0)) for a in (0.2, 0.9)
    )
    drawn = Directions((8 * Q, 60 * Q), rows)
    law = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=4 * Q, q_max=100 * Q)
    grid = rs.Grid((256, 256), (SIDE, SIDE))
    heights = rs.synthesize(DirectedSpectrum(law, drawn), grid, np.random.default_rng(8))
    found = measured_directions(np.abs(np.fft.rfft2(heights)) ** 2, grid, grid.nyquist)
    assert len(found.q) * len(found.rows[0]) <= 3000
    assert found.q[0] == pytest.approx(Q, rel=1e-5)
    q, angle = 50 * Q, np.linspace(0, math.pi, 30)
    np.testing.assert_allclose(found(q, angle), drawn(q, angle), atol=0.1)  # fixed amplitudes


def test_measured_directions_of_white_heights_scatter_about_1():
    grid = rs.Grid((128, 128), (SIDE, SIDE))
    power = np.random.default_rng(9).exponential(size=grid.half_shape)
    found = measured_directions(power, grid, grid.nyquist)
    fine = np.array(found.rows)[-10:]
    # modes in a kernel of .12 in ln q and 4°: 4π·.12·.07 q²/(2Q²), q of 30 to 60
    assert fine.std() < 0.3
    assert fine.mean() == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("q", "rows"),
    [
        ((), ()),
        ((1.0, 1.0), ((1.0,), (1.0,))),
        ((0.0,), ((1.0,),)),
        ((1.0,), ((1.0,), (1.0,))),
        ((1.0,), ((-1.0, 2.0),)),
        ((1.0,), ((0.0, 0.0),)),
        ((1.0,), ((math.nan, 1.0),)),
        ((1.0, 2.0), ((1.0,), (1.0, 1.0))),
    ],
)
def test_bad_directions_are_refused(q, rows):
    with pytest.raises(ValueError, match="directions need"):
        Directions(q, rows)


@pytest.mark.parametrize(("ratio", "angle"), [(0.5, 0.0), (math.inf, 0.0), (2.0, math.nan)])
def test_bad_lays_are_refused(ratio, angle):
    with pytest.raises(ValueError, match="≥ 1 and finite"):
        with_lays([(LAW, ratio, angle)])
