"""Contacts that the calibrated law draws, without a solver: a source of members, measured by the stages of members.

Clipped Gaussian fields (`theory.clipped`) have the distribution and the power of the pressure of the law. They give
T/T_flash; T_flash itself is that of the law. Fields for frozen contact come on two grids, with the same long waves, so
that temperatures are continued to all of C(q) as along the levels of a run. `theory.at_rest` has those at rest over all
of C(q), and corrects the fields at any speed by what it changes of theirs at rest, but where C(q) has gaps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

import theory
from roughsim.contact import Contact
from roughsim.errors import ConvergenceError
from roughsim.grid import Array, Field, Grid
from roughsim.observables.catalogue import quantiles_of
from roughsim.observables.distribution import Bins, Distribution
from roughsim.observables.record import Sample
from roughsim.prediction.bodies import conduction, friction_coefficient, heat_source
from roughsim.prediction.camera import camera_of
from roughsim.prediction.law import calibrated
from roughsim.prediction.sliding import moving_roughness
from roughsim.prediction.stress import law_arguments
from roughsim.scene import Scene
from roughsim.scene.bodies import Layers
from roughsim.scene.numerics import SLIDING
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum

if TYPE_CHECKING:  # slow to import, as the stages below
    from roughsim.observables.moments import HeatSource
    from roughsim.sliding.stepping import Motion
    from theory.at_rest import AtRest

# longest waves and points along a side of frozen contact, pixels along its shortest wave, and number of fields
_WAVES, _POINTS, _PIXELS, _FIELDS = 4, 512, 4, 8
# of two faces: long waves leave few short ones room, and many are slow. With 4 pixels, and steps of one, the coldest
# twentieth is .05 T_flash hotter
_SLID_WAVES, _SLID_POINTS, _SLID_PIXELS, _SLID_FIELDS = (2.0, 8.0), 160, 5, 6
_FINEST, _LEAST_STEPS = 640, 4  # points of slides that are short, and pixels of these
_FURTHEST = 4.0  # lengths of the cell that are slid: further counts as that
Load = dict[str, Any]  # E*, σ₀ and σ_P, as `law_arguments`


class FrozenFields(NamedTuple):
    """Drawn contacts up to one cut-off, or two on the same surfaces, and T_flash of the law."""

    samples: tuple[Sample, ...]  # lowest cut-off first
    flash: Array  # K, up to each cut-off and over all of C(q), (samples + 1, speeds)
    walked: bool = False  # whether corrected at rest


@lru_cache(maxsize=16)  # 1 s at three speeds, in each table of a comparison
def frozen_fields(scene: Scene, *, walk: bool = True) -> FrozenFields | None:
    """Return drawn contacts of a scene that slide frozen, as they are or corrected at rest.

    None where a scene does not ask for the distribution of the temperature, the moving body has a skin or is heated in
    depth, or the calibrated law does not hold for all of C(q) and for its part in the fields.
    """
    if not _has_fields(scene, 0):
        return None
    try:
        slid = scene.numerics.slid_distance
        load, source = law_arguments(scene), heat_source(scene)
        return draw_frozen(scene.spectrum, load, source, slid, walk=walk)
    except ValueError:  # the law does not hold for C(q) up to the shortest wave of the fields
        return None


@lru_cache(maxsize=4)  # seconds at each speed
def slid_fields(scene: Scene) -> Sample | None:
    """Return drawn pairs of faces of a scene that slide over one another, with the temperatures of the moving body.

    None as for `frozen_fields`, here of both bodies, or if the scene does not slide or slides less than a few pixels.
    """
    if scene.sliding.history != SLIDING or not (_has_fields(scene, 0) and _has_fields(scene, 1)):
        return None
    from roughsim.heat.body import Body
    from roughsim.sliding.stepping import Motion

    constants = np.array([friction_coefficient(scene), *conduction(scene)[1:]]).T.tolist()
    motions = [
        Motion(speed, friction, Body(kappa, diffusivity), Body(*resting), distance)
        for speed, distance, (friction, kappa, diffusivity, *resting) in zip(
            scene.speeds, scene.sliding.distances, constants, strict=True
        )
    ]
    try:
        return draw_slides(scene.spectrum, law_arguments(scene), motions, moving_roughness(scene))
    except (ValueError, ConvergenceError):  # as above, or the bodies do not come to one temperature
        return None


def _has_fields(scene: Scene, body: int) -> bool:
    """Whether a scene asks for fields, and the law and a bare body allow them."""
    asks = scene.distribution and calibrated(scene).stress_spectrum is not None
    return asks and scene.layers[body] == Layers() and not scene.directions


def draw_frozen(
    spectrum: Spectrum,
    load: Load,
    source: HeatSource,
    slid_distance: float | None = None,
    *,
    points: int = _POINTS,
    fields: int = _FIELDS,
    seed: int = 0,
    walk: bool = True,
) -> FrozenFields:
    """Draw contacts of C(q) up to waves of four pixels, and the same up to half of that if C(q) goes on beyond it.

    They slide from rest over `slid_distance`, m, at most half of the cell: older heat is even, and left out. `walk`
    corrects them at rest, if C(q) has no gaps. ValueError where the law does not hold.
    """
    length = 2 * pi * _WAVES / float(spectrum.breaks[0])
    slid = min(slid_distance or inf, length / 2)
    of_law = theory.clipped.law_of(spectrum, **load)
    walks = walk and theory.at_rest.holds(of_law)
    resting = theory.at_rest.at_rest(of_law, length) if walks else None
    samples, laws = [], []
    for cut, count, contacts in _up_to_cut_offs(spectrum, load, length, points, fields, seed):
        rows = [measured(pressure, length, source, slid, resting) for pressure in contacts]
        samples.append(sample_of(cut.breaks[-1], count, rows))
        laws.append(cut)
    flash = [_flash_of_law(law, load, source) for law in (*laws, spectrum)]
    return FrozenFields(tuple(samples), np.array(flash), walks)


def _up_to_cut_offs(
    spectrum: Spectrum, load: Load, length: float, points: int, fields: int, seed: int
) -> Iterator[tuple[TruncatedSpectrum, int, Iterator[Array]]]:
    """Yield one or two cut-offs as C(q) up to them, lowest first, points along a side, and the drawn pressures."""
    longest, end = float(spectrum.breaks[0]), float(spectrum.breaks[-1])
    rng = np.random.default_rng(seed)
    white = [rng.standard_normal((points, points)) for _ in range(fields)]
    for count in (points // 2, points):
        q_max = longest * count / (_WAVES * _PIXELS)
        if count < points and q_max >= end:
            continue
        cut = TruncatedSpectrum(spectrum, min(q_max, end))
        noise = white if count == points else [theory.clipped.halved(waves) for waves in white]
        yield cut, count, _contacts(cut, load, noise, length)


@lru_cache(maxsize=16)  # seconds
def drawn_pictures(scene: Scene) -> tuple[Array, ...]:
    """Return what 1 % of the picture of drawn contacts exceeds, over the rms of the picture, (fields, speeds).

    One array for each cut-off, lowest first. None without a camera, with a lay, which drawn contacts do not have, or
    where the calibrated law does not hold.
    """
    camera, law = camera_of(scene), calibrated(scene).stress_spectrum
    if camera is None or camera.directed or law is None:
        return ()
    from roughsim.observables.camera import hottest_over_rms

    spectrum, source = scene.spectrum, heat_source(scene)
    length = 2 * pi * _WAVES / float(spectrum.breaks[0])
    slid = min(scene.numerics.slid_distance or inf, length / 2)
    camera, found = camera._replace(direction=0.0, slid_distance=slid), []
    try:
        drawn = _up_to_cut_offs(spectrum, law_arguments(scene), length, _POINTS, _FIELDS, 0)
        for _, count, contacts in drawn:
            grid = Grid((count, count), (length, length))
            found.append(
                np.array([hottest_over_rms(each, grid, source, camera) for each in contacts])
            )
    except ValueError:  # the law does not hold for C(q) up to the shortest wave of the fields
        return ()
    return tuple(found)


def _contacts(
    spectrum: Spectrum, load: Load, white: Sequence[Array], length: float
) -> Iterator[Array]:
    """Yield the pressure of drawn contacts in a cell of this side, m, for each field of white noise."""
    field = theory.clipped.clipped_field(spectrum, **load)
    points = white[0].shape[0]
    amplitude, _ = theory.clipped.amplitudes(field, points, length)
    ascending = field.ascending(points**2)
    for noise in white:
        yield theory.clipped.ranked(theory.clipped.heights(amplitude, noise), ascending)


def measured(
    pressure: Array,
    length: float,
    source: HeatSource,
    slid_distance: float,
    walk: AtRest | None = None,
) -> tuple[Array, Distribution]:
    """Return T_flash of a contact by its own field of temperature, K, and the distribution about it.

    The `walk` of its temperature at rest corrects that of a drawn contact.
    """
    from roughsim.observables.moments import HeatSource
    from roughsim.observables.temperatures import (
        SlideFromRest,
        contact_fields,
        distribution_of,
        own_flash,
    )

    grid = Grid((len(pressure), len(pressure)), (length, length))
    slide = SlideFromRest(slid_distance=slid_distance)
    hot = contact_fields(pressure, grid, source, slide)
    heat = pressure[pressure > 0.0]
    flash = own_flash(hot, heat, float(pressure.mean()), source)
    if walk is not None:
        at_rest = HeatSource((0.0,), 1.0, 1.0, 1.0)
        hot = walked(hot, contact_fields(pressure, grid, at_rest, slide)[0], heat, walk)
    return flash, distribution_of(hot, [heat] * len(hot), flash)


def walked(moving: Sequence[Field], resting: Field, heat: Array, walk: AtRest) -> list[Array]:
    """Return temperatures of drawn contact over their means by heat, with what the `walk` changes of those at rest.

    r_v + ρ b (r̂₀ − r₀), r̂₀ of the walk at the rank of r₀ by heat, b the regression of r_v on r₀ by heat, and ρ their
    correlation: in units of its deviation r_v takes the share ρ² of the change, which r₀ explains of its variance.
    """
    share = heat / heat.sum(dtype=float)
    still = resting / (resting @ share)
    order = np.argsort(still)
    ranked = share[order]
    change = -still
    change[order] += walk.over_flash(np.cumsum(ranked) - ranked / 2)
    apart = share * (still - 1.0)
    variance = apart @ still
    found = []
    for field in moving:
        over = field / (field @ share)
        slope = apart @ over / variance
        explained = slope**2 * variance
        whole = max(share @ (over - 1.0) ** 2, explained)
        if explained > 0.0:
            over = over + slope * sqrt(explained / whole) * change
        found.append(over / (over @ share))
    return found


def _flash_of_law(spectrum: Spectrum, load: Load, source: HeatSource) -> Array:
    """Return T_flash of the calibrated law, K, (speeds,)."""
    law = theory.clipped.law_of(spectrum, **load)
    constants = source.friction_coefficient, source.conductivity, source.diffusivity
    return np.array(
        [
            theory.flash.flash_temperature(
                speed,
                stress_spectrum=law,
                nominal_pressure=load["nominal_pressure"],
                friction_coefficient=friction,
                conductivity=conductivity,
                diffusivity=diffusivity,
            )
            for speed, friction, conductivity, diffusivity in np.broadcast(
                source.speeds, *constants
            )
        ]
    )


def draw_slides(
    spectrum: Spectrum,
    load: Load,
    motions: Sequence[Motion],
    moving_part: float,
    *,
    points: int = _SLID_POINTS,
    fields: int = _SLID_FIELDS,
    seed: int = 0,
) -> Sample:
    """Draw pairs of faces, and slide one over the other as members slide, but with contacts that are drawn.

    z = √(1 − f) z₁(x) + √f z₂(x + s), f the `moving_part` of C(q), s the slid distance. C(q) is drawn up to 16 q_min.
    ValueError where the law does not hold, or if a slide is too short; ConvergenceError as a member.
    """
    from roughsim.sliding.distribution import Sampler
    from roughsim.sliding.history import LAST
    from roughsim.sliding.path import oblique_path, pixel_of_path
    from roughsim.sliding.stepping import walk

    longest, end = float(spectrum.breaks[0]), float(spectrum.breaks[-1])
    waves = min(max(points / _SLID_PIXELS * longest / end, _SLID_WAVES[0]), _SLID_WAVES[1])
    length = 2 * pi * waves / longest
    cut = TruncatedSpectrum(spectrum, min(longest * points / (_SLID_PIXELS * waves), end))
    distances = np.minimum([motion.slid_distance for motion in motions], _FURTHEST * length)
    grid = Grid((points, points), (length, length))
    while distances.min() < _LEAST_STEPS * pixel_of_path(grid):
        if grid.shape[0] >= _FINEST:
            raise ValueError(f"slid_distance = {distances.min():.4g} m is too short")
        grid = Grid((2 * grid.shape[0], 2 * grid.shape[1]), grid.lengths)
    path = oblique_path(grid, float(distances.max()))
    field = theory.clipped.clipped_field(cut, **load)
    amplitude, _ = theory.clipped.amplitudes(field, grid.shape[0], length)
    ascending = field.ascending(grid.points)
    rng, rows = np.random.default_rng(seed), []
    for _ in range(fields):
        still, riding = (
            theory.clipped.heights(amplitude, rng.standard_normal(grid.shape)) for _ in range(2)
        )
        contacts = _along(
            path.offsets, sqrt(1 - moving_part) * still, sqrt(moving_part) * riding, ascending
        )
        sampler = Sampler(grid, path.steps_to(distances), LAST)
        for n, step in enumerate(walk(contacts, grid, path, motions)):
            if n > 0:
                sampler.add(n, step)
        rows.append((sampler.flash_temperature, sampler.together(sampler.flash_temperature)))
    return sample_of(cut.breaks[-1], grid.shape[0], rows, "sliding_")


def _along(offsets: ArrayLike, still: Array, riding: Array, ascending: Array) -> Iterator[Contact]:
    """Yield the drawn contact at each position of a face that rides over one that is still."""
    contact = None
    for offset in np.asarray(offsets):
        if contact is None or riding.any():
            z = still + np.roll(riding, -offset, axis=(0, 1))
            pressure = theory.clipped.ranked(z, ascending)
            share = float((pressure > 0.0).mean())
            contact = Contact(pressure, np.zeros_like(pressure), share, 0.0, 0.0, 0, 0.0)
        yield contact


def sample_of(
    q_max: float, points: int, rows: Sequence[tuple[Array, Distribution]], prefix: str = ""
) -> Sample:
    """Return what members would have stored: their T_flash, quantiles and bins; no stress spectra."""
    stored = [
        dict.fromkeys(("flash_temperature", f"{prefix}flash_temperature"), flash)
        | quantiles_of(distribution, prefix)
        for flash, distribution in rows
    ]
    bins = zip(*(distribution.bins for _, distribution in rows), strict=True)
    return Sample(
        q_max,
        float(points),
        np.arange(len(rows)),
        {name: np.array([row[name] for row in stored]) for name in stored[0]},
        np.empty(0),
        np.empty((len(rows), 0)),
        0.0,
        bins=Bins(*map(np.array, bins)),
    )
