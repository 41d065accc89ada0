"""The temperature of contact at rest: a walk over the magnifications, against moments, full contact and drawn walks."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ndtr

import roughsim as rs
from roughsim.observables.moments import HeatSource
from roughsim.observables.temperatures import SlideFromRest, contact_fields
from theory import clipped
from theory.at_rest import at_rest
from theory.interface import diffuse
from theory.scattering import shares_of

SHARES = np.array([0.05, 0.25, 0.5, 0.75, 0.9, 0.99])
SPECTRUM = rs.SelfAffineSpectrum(1e-23, 0.7, 6e3, 1.2e4, 1e5)
SOLID = {"effective_modulus": 1.1e11, "nominal_pressure": 1e7}
HARD = {"elastic": None, "yielded in part": 1.5e8}
LENGTH = 1.2 * 2 * pi / 6e3


def law_of(hardness=None, spectrum=SPECTRUM, **changes):
    return clipped.law_of(spectrum, **SOLID | changes, penetration_hardness=hardness)


def shells(law, **steps):
    modulus, hardness = law.effective_modulus, law.penetration_hardness
    diffusion = diffuse(law.spectrum, modulus, law.nominal_pressure, hardness, **steps)
    return diffusion, shares_of(diffusion, modulus)


@pytest.mark.parametrize("hardness", HARD.values(), ids=HARD)
def test_mean_temperature_by_heat_is_that_of_the_law(hardness):
    law = law_of(hardness)
    found = at_rest(law, inf, spacing=0.2)
    temperature, joint = found.joint()
    assert joint.sum() == pytest.approx(1.0, rel=1e-12)
    assert found.pressure @ joint.sum(axis=1) == pytest.approx(1e7, rel=1e-9)
    assert joint.sum(axis=0) @ temperature == pytest.approx(0.0, abs=1e-6 * temperature[-1])
    q = np.geomspace(law.breaks[0], law.breaks[-1], 40_001)
    # |σ_q|²/q over the plane, without what was smoothed and moved beyond q_max
    flash = 2 * pi * np.trapezoid(q * law(q), np.log(q))
    assert found.pressure @ joint @ temperature == pytest.approx(flash, rel=5e-3)


def test_in_full_contact_pressure_and_temperature_are_jointly_normal():
    modulus, pressure = 1e9, 1e7
    law = law_of(effective_modulus=modulus, nominal_pressure=pressure)
    ends = np.log([6e3, 1e5])
    square, flash = (
        2
        * pi
        * (modulus / 2) ** 2
        * quad(lambda x, n=n: np.exp(n * x) * SPECTRUM(np.exp(x)), *ends, points=[np.log(1.2e4)])[0]
        for n in (2, 3)
    )
    off = []
    for step in (0.5, 0.25):
        found = at_rest(law, inf, step=step)
        temperature, joint = found.joint()
        off.append(joint.sum(axis=0) @ temperature**2 / square - 1)
        assert found.pressure @ joint @ temperature == pytest.approx(flash, rel=0.012 * step**2)
    assert off[1] / off[0] == pytest.approx(0.25, abs=0.01)  # second order
    # heat tilts the normal density of T/s by 1 + T ⟨σT⟩/(σ₀ s²)
    tilt = flash / pressure / sqrt(square)
    wanted = [
        brentq(lambda x, p=p: ndtr(x) - tilt * np.exp(-(x**2) / 2) / sqrt(2 * pi) - p, -6, 6)
        for p in SHARES
    ]
    assert found.over_flash(SHARES) * tilt == pytest.approx(wanted, abs=0.03)


def steps_of(law):
    """Nodes .2 apart, and by shell chances from each to each, β and the noise, before all shells and in each."""
    diffusion, shares = shells(law)
    least = 2 * sqrt(pi) / LENGTH
    nodes = diffusion.pressure.size
    gap = np.diff(diffusion.pressure)
    through = []
    for growth in diffusion.growth:
        rate = np.zeros((nodes, nodes))
        for m in range(1, nodes - 1):
            lower, higher = gap[m - 1 : m + 1]
            rate[m, m + 1] = growth[m] / (higher * (lower + higher))
            rate[m, m - 1] = growth[m] / (lower * (lower + higher))
            rate[m, m] = -rate[m, m + 1] - rate[m, m - 1]
        through.append(expm(rate))
    edges, q = diffusion.wavenumber, np.exp(shares.place)
    slope, noise = [], np.zeros((q.size + 1, nodes))
    for i, kept in enumerate(shares.kept / shares.grown):
        parts = [(q[i], kept), *zip(np.exp(shares.grid), shares.beside[i], strict=True)]
        parts = [(k, s) for k, s in parts if k > least]
        slope.append(sum(s / k for k, s in parts))
        later = {i: diffusion.growth[i]}
        for j in range(i - 1, -1, -1):
            later[j] = through[j] @ later[j + 1]
        for k, s in parts:
            shell = i if k >= q[i] else int(np.searchsorted(edges, k, side="right")) - 1
            noise[shell + 1] += s * (1 / k - slope[i]) ** 2 * later[max(shell, 0)]
    return diffusion, through, slope, noise


@pytest.mark.parametrize("hardness", HARD.values(), ids=HARD)
def test_higher_moments_by_heat_are_those_of_a_chain(hardness):
    law = law_of(hardness)
    diffusion, through, slope, noise = steps_of(law)
    pressure = diffusion.pressure - 1e7
    moments = [diffusion.probability[0], *np.zeros((3, pressure.size))]  # ⟨T^k; σ⟩

    def moved(by, spread):
        """Moments of T + `by` + noise of this variance."""
        zero, one, two, three = moments
        square = by**2 + spread
        cube = by**3 + 3 * by * spread
        return [
            zero,
            one + by * zero,
            two + 2 * by * one + square * zero,
            three + 3 * by * two + 3 * square * one + cube * zero,
        ]

    moments = moved(0.0, noise[0])
    for chance, beta, added in zip(through, slope, noise[1:], strict=True):
        moments = moved(-beta * pressure, added / 2)
        moments = [each @ chance for each in moments]
        moments = moved(beta * pressure, added / 2)
    found = at_rest(law, LENGTH, spacing=0.2)
    temperature, joint = found.joint()
    heat = found.pressure @ joint
    assert heat @ temperature == pytest.approx(diffusion.pressure @ moments[1], rel=3e-4)
    assert heat @ temperature**2 == pytest.approx(diffusion.pressure @ moments[2], rel=3e-4)
    assert heat @ temperature**3 == pytest.approx(diffusion.pressure @ moments[3], rel=3e-4)


@pytest.mark.slow
@pytest.mark.parametrize("hardness", HARD.values(), ids=HARD)
def test_quantiles_are_those_of_walks_by_chance(hardness):
    law = law_of(hardness)
    diffusion, through, slope, noise = steps_of(law)
    pressure, count = diffusion.pressure, 400_000
    rng = np.random.default_rng(1)
    place = np.full(count, np.flatnonzero(diffusion.probability[0])[0])
    temperature = np.sqrt(noise[0, place]) * rng.standard_normal(count)
    for chance, beta, added in zip(through, slope, noise[1:], strict=True):
        rising = np.cumsum(chance, axis=1)
        rising /= rising[:, -1:]
        rows = (rising + np.arange(pressure.size)[:, None]).ravel()
        before = place
        place = np.searchsorted(rows, before + rng.uniform(size=count) * (1 - 1e-12))
        place -= before * pressure.size
        temperature += beta * (pressure[place] - pressure[before])
        strength = (added[before] + added[place]) / 2
        temperature += np.sqrt(strength) * rng.standard_normal(count)
    order = np.argsort(temperature)
    heat = np.cumsum(pressure[place][order]) / pressure[place].sum()
    flash = pressure[place] @ temperature / pressure[place].sum()
    walks = np.interp(SHARES, heat, temperature[order]) / flash
    found = at_rest(law, LENGTH, spacing=0.2).over_flash(SHARES)
    assert found[:5] == pytest.approx(walks[:5], abs=0.02)
    assert found[5] == pytest.approx(walks[5], abs=0.06)


ROUGH = rs.SelfAffineSpectrum(1e-23, 0.7, 2.4e4, 4.8e4, 1.92e5)
CELL = rs.Grid((128, 128), (8 * pi / 2.4e4, 8 * pi / 2.4e4))  # four pixels along the shortest wave
HEAT = HeatSource([0.0], 1.0, 1.0, 1.0)


def pressed(load, members):
    """Heights, m, and pressures over their mean of elastic contacts at load = σ₀/(E* h′)."""
    pressure = load * 1.1e11 * ROUGH.rms_slope
    for seed in range(members):
        heights = rs.synthesize(ROUGH, CELL, np.random.default_rng(seed))
        contact = rs.solve_contact(
            heights, CELL, rs.Solid(1.1e11), nominal_pressure=pressure, tolerance=1e-6
        )
        yield heights * 1.1e11 / (2 * pressure), contact.pressure / pressure


@pytest.mark.parametrize("load", [0.03, 0.3, 3.0])
def test_wherever_elastic_contact_touches_it_is_as_hot_as_high(load):
    # T = μv E*/2κ (h − D): a wave of pressure makes 2/(E*q) of displacement and μv/κq of temperature
    for height, heat in pressed(load, 1):
        touches = heat > 0.0
        hot = contact_fields(heat, CELL, HEAT, SlideFromRest())[0]
        over_plane = height[touches]
        assert touches.all() == (load == 3.0)
        assert hot - hot.mean() == pytest.approx(
            over_plane - over_plane.mean(), abs=1e-5 * np.ptp(over_plane)
        )


@pytest.mark.parametrize("load", [0.1, 0.3])
def test_the_walk_is_as_hot_as_solved_elastic_contact_is_high(load):
    heights, heats = map(np.array, zip(*pressed(load, 16), strict=True))
    q = np.hypot(*np.meshgrid(*[np.fft.fftfreq(128, CELL.lengths[0] / 128 / 2 / pi)] * 2))
    power = np.abs(np.fft.fft2(heats) / 128**2) ** 2
    flash = np.divide(power, q, out=power, where=q > 0.0)  # ⟨σT⟩ of each wave, but q = 0
    flash[:, 0, 0] = 0.0
    plane = (heats * heights).mean(axis=(1, 2)) - flash.sum(axis=(1, 2))
    temperature, heat = (heights - plane[:, None, None])[heats > 0.0], heats[heats > 0.0]
    order = np.argsort(temperature)
    below = np.cumsum(heat[order]) / heat.sum()
    solved = np.interp(SHARES, below, temperature[order]) / (heat @ temperature / heat.sum())
    law = law_of(spectrum=ROUGH, nominal_pressure=load * 1.1e11 * ROUGH.rms_slope)
    found = at_rest(law, CELL.lengths[0]).over_flash(SHARES)
    assert found[:5] == pytest.approx(solved[:5], abs=0.03)
    assert found[5] == pytest.approx(solved[5], abs=0.07)
