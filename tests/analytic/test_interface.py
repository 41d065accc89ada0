"""The pressure that diffuses under roughness that yields: exact cases, another form of its equation, its order."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ndtr, ndtri
from scipy.stats import multivariate_normal

from theory.interface import between_shells, diffuse, interface_law
from theory.scattering import stiffness_variance


def bell(x):
    return np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)


@pytest.mark.parametrize("ramp", [0.1, 1.0, 6.0, 40.0])
def test_hard_walls_under_waves_of_one_length_are_a_bed_of_springs(ramp):
    # springs of pressure (h - d)/ramp between 0 and 1, h normal: c = 1/kappa - ramp, kappa the share that gives / ramp
    heights = np.linspace(-9, 9, 8001)
    weight = bell(heights) * (heights[1] - heights[0])
    z = np.arange(-3.5, 3.51, 0.5)
    gap = np.linspace(-8 - ramp, 8, 1601)
    mean = np.array([weight @ np.clip((heights - d) / ramp, 0.0, 1.0) for d in gap])
    at = np.interp(z, ndtri(mean[::-1]), gap[::-1])
    gives = ndtr(at + ramp) - ndtr(at)
    expected = ramp * (1 / gives - 1) * bell(z)
    found = interface_law(z, np.ones(1), np.full(1, ramp))[0]
    np.testing.assert_allclose(found, np.minimum(expected, 1.0), rtol=4e-3, atol=1e-9)


def burgers(level, power, least):
    """σ(η) and −∂σ/∂η at v = 1 from ∂σ/∂v = ½ σ″ + σ σ′ w′, σ_P = 1, w = level v^power, from a bed of springs."""
    eta = np.linspace(-7.0 - level, 7.0, 1501)
    step = eta[1] - eta[0]
    wide, ramp = np.sqrt(least), level * least**power

    def touched(x):
        return wide * bell(x / wide) - x * ndtr(-x / wide)

    def change(v, sigma):
        padded = np.concatenate([[1.0], sigma, [0.0]])
        first = (padded[2:] - padded[:-2]) / (2 * step)
        second = (padded[2:] - 2 * sigma + padded[:-2]) / step**2
        return second / 2 + sigma * first * level * power * v ** (power - 1)

    start = (touched(eta) - touched(eta + ramp)) / ramp
    solved = solve_ivp(
        change, (least, 1.0), start, method="LSODA", lband=1, uband=1, rtol=1e-6, atol=1e-11
    )
    sigma = solved.y[:, -1]
    return sigma, -np.gradient(sigma, step)


@pytest.mark.parametrize(("level", "power"), [(0.3, 0.6), (2.0, 0.6), (2.0, 1.2)])
def test_the_mean_gap_obeys_burgers_equation_where_the_half_space_grows_softer(level, power):
    least = 1e-2
    sigma, kappa = burgers(level, power, least)
    z = np.arange(-5.0, 5.001, 0.05)
    variance = np.geomspace(1.0, least, 300)
    law = interface_law(z, variance, level * variance**power)[0]
    inner = (sigma > 1e-3) & (sigma < 1 - 1e-3)
    at = ndtri(sigma[inner])
    expected = (1 / kappa[inner] - level) * bell(at)
    assert np.abs(np.interp(at, z, law) - expected).max() < 2e-3


def test_the_law_converges_with_the_square_of_the_step_and_of_the_spacing():
    def law(steps, spacing):
        z = spacing * np.arange(-round(4.8 / spacing), round(4.8 / spacing) + 1)
        variance = np.geomspace(1.0, 1e-2, steps + 1)
        every = round(0.8 / spacing)
        return interface_law(z, variance, 2.0 * variance**0.8)[0][::every]

    steps = [law(n, 0.2) for n in (8, 16, 32, 64)]
    errors = [np.abs(a - b)[2:-2].max() for a, b in pairwise(steps)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.3)
    spacings = [law(64, h) for h in (0.4, 0.2, 0.1, 0.05)]
    errors = [np.abs(a - b)[2:-2].max() for a, b in pairwise(spacings)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.3)


@pytest.mark.parametrize("ramp", [0.05, 3.0])
def test_a_step_of_the_law_is_rosenbrocks_with_exact_slopes(ramp):
    z, variance = np.arange(-3.1, 3.2, 0.2), np.array([1.0, 0.2])
    middle = np.append(z - 0.1, z[-1] + 0.1)
    series = (
        2.0 * ramp * bell(middle) / 0.2**0.25 / np.sqrt(2.0)
    )  # ramps 2 and 1, mean variance √.2

    def change(law):
        wide = np.concatenate([law[:1], law, law[-1:]])
        mean = (wide[1:] + wide[:-1]) / 2
        through = (np.diff(wide) / 0.2 + middle * mean) / (series + mean) ** 2
        return np.diff(through) / 0.4 - law / 2

    found = interface_law(z, variance, ramp * np.array([2.0, 1.0]))
    start, step = found[1], np.log(5.0)
    slopes = [change(start + 1e-30j * each).imag / 1e-30 for each in np.eye(z.size)]
    matrix = np.eye(z.size) - (1 - np.sqrt(0.5)) * step * np.transpose(slopes)
    first = np.linalg.solve(matrix, change(start))
    second = np.linalg.solve(matrix, change(start + step * first) - 2 * first)
    expected = start + step * (1.5 * first + 0.5 * second)
    np.testing.assert_allclose(found[0], expected, rtol=1e-9)


@pytest.mark.parametrize("power", [0.5, 1.0, -1.0, -3.0])
def test_between_two_shells_a_power_of_the_height_variance_is_exact(power):
    variance = np.geomspace(3.0, 0.2, 6)
    found = between_shells(variance**power, variance)
    upper, lower = variance[:-1], variance[1:]
    exact = (
        np.log(upper / lower)
        if power == -1
        else (upper ** (power + 1) - lower ** (power + 1)) / (power + 1)
    )
    np.testing.assert_allclose(found, exact, rtol=1e-6)


@dataclasses.dataclass(frozen=True)
class Power:
    """C = level q^(−2−2H) from 1 to 1000 rad/m: v = π level (q^(−2H) − 1000^(−2H))/H."""

    level: float = 1e-3
    hurst: float = 0.8
    breaks = (1.0, 1e3)

    def __call__(self, q):
        return self.level * np.asarray(q) ** (-2 - 2 * self.hurst)

    def variance(self, q):
        return np.pi * self.level * (q ** (-2 * self.hurst) - 1e3 ** (-2 * self.hurst)) / self.hurst


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5])
def test_under_stiff_roughness_the_pressure_diffuses_as_the_bearing_law_wants(share):
    # the gap is normal: pressures hardness Phi(z) at two places share the variance of the waves seen so far, 1 - v/v1
    spectrum, hardness = Power(), 2e6
    diffusion = diffuse(spectrum, 1e16, share * hardness, hardness)
    at = slice(1, np.searchsorted(diffusion.wavenumber, 300.0), 6)
    v, whole = spectrum.variance(diffusion.wavenumber[at]), spectrum.variance(1.0)
    start = ndtri(share)
    square = np.array(
        [
            multivariate_normal.cdf([start, start], cov=[[1.0, 1 - x], [1 - x, 1.0]])
            for x in v / whole
        ]
    )
    found = np.einsum("ij,j->i", diffusion.probability[at], (diffusion.pressure / hardness) ** 2)
    np.testing.assert_allclose(found - share**2, square - share**2, rtol=0.03)
    # kappa = hardness phi(z)/sqrt(v): its mean is kept, its square has a closed mean
    kappa = diffusion.stiffness[at] / hardness
    mean = np.einsum("ij,ij->i", diffusion.probability[at], kappa)
    np.testing.assert_allclose(mean, bell(start) / np.sqrt(whole), rtol=0.05)
    both = 2 * whole - v
    closed = np.exp(-(start**2) * whole / both) / (2 * np.pi * np.sqrt(v * both))
    np.testing.assert_allclose(
        np.einsum("ij,ij->i", diffusion.probability[at], kappa**2), closed, rtol=0.05
    )
    # so that the waves up to k make the variance <kappa²>(k) - <kappa>² of kappa at any later wavenumber
    edges = diffusion.wavenumber
    made = stiffness_variance(diffusion) / hardness**2
    both = 2 * whole - spectrum.variance(edges[:-1])
    closed = np.exp(-(start**2) * whole / both) / (2 * np.pi * np.sqrt((2 * whole - both) * both))
    for m in np.searchsorted(edges, [7.2, 52.0, 370.0]) - 1:
        expected = closed[1 : m + 1] - bell(start) ** 2 / whole
        allowed = 0.02 * expected[-1] + 0.3 * expected  # steps back are of the first order
        assert (np.abs(made[m, 1 : m + 1] - made[m, 0] - expected) < allowed).all()


def test_in_full_contact_the_pressure_is_normal_with_the_variance_of_persson():
    spectrum, modulus = Power(), 1e10
    g = np.pi / 4 * modulus**2 * spectrum.level  # ∫ q³ C dq = level (q^0.4 - 1)/0.4
    full = 2 * g * (1e3**0.4 - 1) / 0.4
    pressure = 10 * np.sqrt(full)
    diffusion = diffuse(spectrum, modulus, pressure, 30 * np.sqrt(full))
    assert diffusion.pressure[-1] == pytest.approx(pressure + 7 * np.sqrt(full), rel=1e-4)
    off = diffusion.pressure - pressure
    grown = diffusion.probability @ off**2
    expected = 2 * g * (diffusion.wavenumber**0.4 - 1) / 0.4
    np.testing.assert_allclose(grown, expected, rtol=2e-3, atol=1e-9 * full)


def test_the_walls_are_smoothed_by_the_last_waves_however_the_end_is_rounded():
    # 0.3 % of an e-fold: 0.003 · 2π q² C(q) at q_max itself; exp(ln q_max) lies beyond some of these ends
    beyond = 0
    for end in np.linspace(900.0, 1000.0, 11):
        spectrum = Ending(end)
        beyond += np.exp(np.log(end)) > end
        variance = diffuse(spectrum, 1e10, 1e6, 1e9).variance
        last = 0.003 * 2 * np.pi * spectrum.level * end**-1.6
        assert variance[-1] == pytest.approx(last, rel=1e-9)
        whole = np.pi * spectrum.level * (1.0 - end**-1.6) / 0.8
        assert variance[0] == pytest.approx(whole + last, rel=1e-6)
    assert 0 < beyond < 11


def test_walls_where_no_waves_are_left_at_the_end_are_smoothed_by_the_last_piece_of_the_table():
    # C = (end − q)/end: of 400 equal pieces in ln q the last, of width w, has 2π end² w²/2
    spectrum, width = Fading(), np.log(1e3) / 400
    variance = diffuse(spectrum, 1e10, 1e6, 1e9).variance
    assert variance[-1] == pytest.approx(0.003 * 2 * np.pi * 1e-6 * width**2 / 2, rel=0.06)


@dataclasses.dataclass(frozen=True)
class Ending:
    """C = level q^(−3.6) from 1 rad/m to an end, and nothing beyond."""

    end: float
    level: float = 1e-3

    @property
    def breaks(self):
        return 1.0, self.end

    def __call__(self, q):
        return np.where(np.asarray(q) <= self.end, self.level * np.asarray(q) ** -3.6, 0.0)


@dataclasses.dataclass(frozen=True)
class Fading:
    """C = 1e-12 (1 − q/1000) m⁴, which falls to zero at its end."""

    breaks = (1.0, 1e3)

    def __call__(self, q):
        return 1e-12 * np.maximum(1.0 - np.asarray(q) / 1e3, 0.0)
