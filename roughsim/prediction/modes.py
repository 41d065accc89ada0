"""Theory of a scene summed over the modes of a cell, in place of the integral over C(q)."""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from math import ceil, cos, inf, isfinite, nan, pi, sin, sqrt
from typing import Any, cast

import numpy as np

import theory
from roughsim.grid import Array, Complex, Grid, modes_where
from roughsim.observables.record import TheoryOfScene
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.prediction.areas import area_fractions
from roughsim.prediction.balance import heat_history
from roughsim.prediction.bodies import Conductions, conduction, friction_coefficient
from roughsim.prediction.camera import seen_by
from roughsim.prediction.shares import AT_REST
from roughsim.prediction.stress import load_arguments, modulus_of, stress_arguments, stress_of_lay
from roughsim.prediction.theories import OVER_SPEED, over_speed
from roughsim.prediction.values import Predicted
from roughsim.scene import Scene
from roughsim.scene.bodies import Layers
from roughsim.surface.modes import check_resolved, holding, mean_over_cells, mode_variance
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum
from theory.arguments import density
from theory.picture import erfc_root
from theory.quadrature import WEIGHTS, panels_between
from theory.skin import direction_mean, even_part, layers_of, odd_part, surface_response

_NEAR = 16.0  # mode spacings above q_min up to which W is averaged over Fourier cells
# mode spacings above q_min beyond which modes lie so densely that their sum is an integral: on nine grids of six scenes
# ∇²T changed by 1e-5, T_flash by 2e-7, the first zero of g_σ by 1e-4
_DENSE = 128.0
_ANGLES = 720  # over half a turn, of waves beyond


def mode_sums(scene: Scene, spectrum: Spectrum, grid: Grid) -> Predicted:
    """Return every observable by the theory summed over the modes of a grid, those that a simulation has.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """
    return Predicted(summed_over_modes(scene, spectrum, grid), scene)


def summed_over_modes(scene: Scene, spectrum: Spectrum, grid: Grid) -> TheoryOfScene:
    """Return the theory with ∫ d²q C in Eqs. (2), (4), (7) and (9) replaced by the sum over mode variances of a grid.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """
    q, stress = _mode_stress(scene, spectrum, grid)
    speeds, sliding, bodies = np.array(scene.speeds), scene.sliding, conduction(scene)
    # the sums of Eqs. (4), (7) and (9) without μv/κσ₀, (speeds,)
    even, odd = _means_over_directions(speeds, bodies, q)
    temperature, gradient = even @ (stress / q), odd @ stress
    laplacian = -even @ (stress * q)
    if scene.lay > 1.0:
        temperature, gradient, laplacian = _sums_of_lay(scene, spectrum, grid)
    elif scene.directions:
        temperature, gradient, laplacian = _sums_of_waves(scene, spectrum, grid)
    rate = _rate(scene, speeds)
    with np.errstate(divide="ignore"):
        slope_length = temperature / np.abs(gradient)
    flash = (
        rate * temperature,
        rate * gradient,
        rate * laplacian,
        np.sqrt(-temperature / laplacian),
        slope_length,
    )
    share = np.full(speeds.shape, nan)
    if scene.counterface_conducts and not scene.directions:
        # the balance of the two bodies, both as κT σ₀/μv of the moving one
        history = heat_history(scene, q)
        resting = history.growth @ (stress / q) + history.resting
        resting *= bodies.conductivity / bodies.counter_conductivity
        both = resting + temperature + history.moving
        share = (resting + history.hotter) / both
    area = float(
        theory.persson.contact_probability(
            float(spectrum.breaks[-1]), spectrum, **load_arguments(scene)
        )
    )
    reach = 0.5 * float(np.hypot(*grid.lengths))
    temperatures = dict(zip(OVER_SPEED, flash, strict=True))
    return TheoryOfScene(
        {
            **temperatures,
            "heat_partition": share,
            **area_fractions(scene),
            "contact_fraction": area,
        },
        sliding.nominal_pressure,
        correlation_radius=(
            StressSpectrum(q, stress, reach).correlation_radius
            if scene.lay == 1.0
            else lambda _: nan
        ),
        total=lambda weight: float(stress @ weight(q)),
        seen=lambda name: seen_by(scene, name, q, stress, reach),
    )


def _means_over_directions(speeds: Array, bodies: Conductions, q: Array) -> tuple[Array, Array]:
    """Return (2/π)A and (2/π)B of Eqs. (4) and (7) at each speed and wavenumber, with the layers of the body."""
    if bodies.each[0].layers == Layers():
        even, odd = theory.flash.angular_integrals(
            speeds[:, None] / (bodies.diffusivity[:, None] * q)
        )
        return 2 / pi * even, 2 / pi * odd
    means = np.empty((2, speeds.size, q.size))
    for k, (speed, each) in enumerate(zip(speeds.tolist(), bodies.each, strict=True)):
        layers = layers_of(*each.layers, each.conductivity, each.diffusivity)
        if layers is None:
            continue
        for row, part in enumerate((even_part, odd_part)):
            means[row, k] = direction_mean(q, speed / each.diffusivity, layers, part)
    return means[0], means[1]


def _weight(scene: Scene, spectrum: Spectrum) -> Callable[[Array], Array]:
    """Return W(q) of the theory."""
    return partial(theory.persson.stress_weight, spectrum=spectrum, **stress_arguments(scene))


def _dense(spectrum: Spectrum, grid: Grid) -> float:
    """Return the wavenumber, rad/m, beyond which the sum over modes is an integral; ∞ of modes on a line."""
    coarse = 2 * pi / min(grid.lengths)  # spacing of modes
    return float(spectrum.breaks[0]) + _DENSE * coarse if min(grid.shape) > 1 else inf


def _mode_stress(scene: Scene, spectrum: Spectrum, grid: Grid) -> tuple[Array, Array]:
    """Return wavenumbers of the modes, rad/m, and their share of ⟨σ²⟩ − σ₀² in the theory, Pa².

    Beyond `_DENSE` rings, a spacing wide, stand for the modes within them.
    """
    check_resolved(spectrum, grid)
    weight, fine = _weight(scene, spectrum), 2 * pi / max(grid.lengths)
    dense, end = _dense(spectrum, grid), spectrum.breaks[-1]
    modes = spectrum if dense >= end else TruncatedSpectrum(spectrum, dense)
    (qx, qy), of_modes = _roughness_of_modes(weight, modes, grid)
    q, ring = np.unique(np.hypot(qx, qy), return_inverse=True)
    roughness = np.bincount(ring, of_modes).astype(np.float64)
    if dense < end:
        beyond, of_rings = _roughness_of_rings(weight, spectrum, dense, fine)
        q, roughness = np.concatenate((q, beyond)), np.concatenate((roughness, of_rings))
        rising = np.argsort(q)  # the last modes lie within the first ring
        q, roughness = q[rising], roughness[rising]
    return q, (0.5 * modulus_of(scene) * q) ** 2 * roughness


def _sums_of_lay(scene: Scene, spectrum: Spectrum, grid: Grid) -> Array:
    """Return T_flash, T′ and ∇²T of faces with a lay, each without μv/κσ₀, at each speed, (3, speeds).

    Contact is that of a cell with these modes, from rest over half its chord; its heat is all in the moving body.
    """
    weight, dense = _weight(scene, spectrum), _dense(spectrum, grid)
    vectors, roughness = _roughness_of_modes(weight, TruncatedSpectrum(spectrum, dense), grid)
    cell, stretch = grid.stretched(scene.lay), sqrt(scene.lay)
    sums = _directed_sums(scene, cell, (vectors[0] / stretch, vectors[1] * stretch), roughness)
    if dense >= spectrum.breaks[-1]:
        return sums
    # of the theory, whose W at long waves does not depend on shorter ones
    slow = np.array(scene.speeds)
    slow[slow == 0.0] = AT_REST
    whole, below = (
        np.array(list(over_speed(scene, slow, part, names=OVER_SPEED[:3]).values()))
        for part in (spectrum, TruncatedSpectrum(spectrum, dense))
    )
    beyond: Array = (whole - below) / _rate(scene, slow)
    return sums + beyond


def _sums_of_waves(scene: Scene, spectrum: Spectrum, grid: Grid) -> Array:
    """Return `_sums_of_lay` of scans, and of faces whose lays differ, with W in the frame of their slopes.

    Beyond the modes, nodes in ln q and angle stand for those within their rings.
    """
    theirs: Any = stress_of_lay(scene, spectrum)
    of_stress, whole = theirs.stress_spectrum, cast("Any", scene.spectrum)
    end, dense = float(spectrum.breaks[-1]), _dense(spectrum, grid)
    cut = whole.truncated(q_max=min(dense, end))
    grid = holding(cut, grid)
    variance = mode_variance(cut, grid)
    modes = modes_where(grid, variance > 0.0)
    qx, qy = (part[modes.chosen] for part in np.broadcast_arrays(*grid.wavevectors))
    roughness = modes.multiplicity * variance[modes.chosen]
    if dense < end:
        kinks = (kink for kink in whole.breaks if dense < kink < end)
        q, slope = panels_between(np.array([dense, *kinks, end])).nodes()
        angle = (np.arange(_ANGLES) + 0.5) * (pi / _ANGLES)
        of_node = (slope * WEIGHTS).ravel() * (2 * pi / _ANGLES)
        ring = q.ravel()[:, None]
        roughness = np.append(roughness, (ring * of_node[:, None]) * whole.at(ring, angle))
        qx, qy = np.append(qx, ring * np.cos(angle)), np.append(qy, ring * np.sin(angle))
    along, across = (
        cos(theirs.angle + turn) * qx + sin(theirs.angle + turn) * qy for turn in (0.0, pi / 2)
    )
    stretched = np.hypot(along * sqrt(theirs.lay), across / sqrt(theirs.lay))
    roughness = roughness * of_stress.weight(stretched)
    if not scene.elastic:  # what yielding leaves of each wave
        before = of_stress.spectrum.spectrum(stretched)
        left = of_stress.spectrum(stretched)
        roughness = roughness * np.where(before > 0.0, left / np.where(before > 0.0, before, 1), 0)
    return _directed_sums(scene, grid, (qx, qy), roughness)


def _directed_sums(
    scene: Scene, cell: Grid, vectors: tuple[Array, Array], roughness: Array
) -> Array:
    """Return the sums over waves q⃗, rad/m, of a cell with W⟨|h_q|²⟩, m², in the direction of each speed."""
    from roughsim.heat.periodic import moving  # loads the transforms

    qx, qy = vectors
    square = qx**2 + qy**2
    stress = (0.5 * scene.effective_modulus) ** 2 * square * roughness  # E*|q|h_q/2
    sums = np.zeros((3, len(scene.speeds)))
    for column, speed, heading, body in zip(
        sums.T, scene.speeds, scene.headings or (), conduction(scene).each, strict=True
    ):
        drift, time, _ = moving(cell, speed, body.diffusivity, heading)
        along = cos(heading) * qx + sin(heading) * qy
        advection = drift[0] * qx + drift[1] * qy
        root: Complex = np.sqrt(square - 1j * advection)
        response: Complex = 1.0 / root
        layers = layers_of(*body.layers, body.conductivity, body.diffusivity)
        if layers is not None:
            response = surface_response(np.sqrt(square), advection, layers) / np.sqrt(square)
        if isfinite(time):  # what the start takes off is of long waves, deeper than layers
            response = response - erfc_root(root**2 * (body.diffusivity * float(time))) / root
        column[:] = (
            stress @ response.real,
            -stress @ (along * response.imag),
            -stress @ (square * response.real),
        )
    return sums


def _rate(scene: Scene, speeds: Array) -> Array:
    """Return μv/κσ₀, the factor of the sums of Eqs. (4), (7) and (9), K/Pa² m."""
    heat = friction_coefficient(scene) * speeds
    rate: Array = heat / (conduction(scene).conductivity * scene.sliding.nominal_pressure)
    return rate


def _roughness_of_modes(
    weight: Callable[[Array], Array], spectrum: Spectrum, grid: Grid
) -> tuple[tuple[Array, Array], Array]:
    """Return the wavevectors of the modes of a grid on half the plane, rad/m, and their C in m², times W."""
    grid = holding(spectrum, grid)
    variance = mode_variance(spectrum, grid)
    modes = modes_where(grid, variance > 0.0)
    q, ring = np.unique(modes.wavenumber, return_inverse=True)
    # W at |q| of each mode, but its mean over the Fourier cell near q_min: there W falls from 1 within a mode
    weights = weight(q)[ring]
    near = grid.wavenumbers < spectrum.breaks[0] + _NEAR * 2 * pi / min(grid.lengths)
    weights[near[modes.chosen]] = mean_over_cells(weight, spectrum, grid, near & modes.chosen)
    qx, qy = (part[modes.chosen] for part in np.broadcast_arrays(*grid.wavevectors))
    return (qx, qy), modes.multiplicity * (variance[modes.chosen] * weights)


def _roughness_of_rings(
    weight: Callable[[Array], Array], spectrum: Spectrum, start: float, width: float
) -> tuple[Array, Array]:
    """Return two Gauss points of each ring beyond `start`, at most so wide, all rad/m, and their C in m², times W."""
    pieces = pairwise([start, *(kink for kink in spectrum.breaks if kink > start)])
    edges = [np.linspace(low, high, ceil((high - low) / width) + 1) for low, high in pieces]
    rings = np.unique(np.concatenate(edges))
    nodes, weights = np.polynomial.legendre.leggauss(2)
    half = 0.5 * np.diff(rings)[:, None]
    q = (rings[:-1, None] + half * (1.0 + nodes)).ravel()
    return q, 2 * pi * q * (half * weights).ravel() * density(spectrum, q) * weight(q)
