"""All steps of a slide of two bodies, and maps of a few of its positions."""

from collections.abc import Iterator, Sequence
from math import atan
from typing import NamedTuple, Protocol

import numpy as np

from roughsim.contact import Contact
from roughsim.grid import Array, Grid
from roughsim.observables.moments import HeatSource, spectrum_and_sums
from roughsim.sliding.correlation import StressCorrelation
from roughsim.sliding.path import Path, slope
from roughsim.sliding.spots import SpotLives, survival
from roughsim.sliding.stepping import NUMBERS, Motion, Step, walk

LAST = 0.5  # share of a slid distance, at its end, over which means are taken


class Watcher(Protocol):
    """Takes what it needs of the steps of a slide."""

    def add(self, n: int, step: Step) -> None:
        """Take step n, from 1 on."""


class SlideHistory(NamedTuple):
    """Observables of two sliding bodies over the slid distance."""

    curves: dict[str, Array]  # as `Slide` names them, (steps,), or (speeds, steps)
    spectrum: Array  # of the stress, Pa², mean over the last half of the distance
    contact: Contact  # the last one


def follow(
    contacts: Iterator[Contact],
    grid: Grid,
    path: Path,
    motions: Sequence[Motion],
    watchers: Sequence[Watcher] = (),
    *,
    directed: bool = False,
) -> SlideHistory:
    """Slide along a path and record every step.

    Each of the `watchers` takes the steps that it needs. Frozen contact slides in all directions alike, or, `directed`,
    along the path, from rest over half the chord of the cell: of faces with a lay.
    """
    sliding = HeatSource(
        speeds=[motion.speed for motion in motions],
        friction_coefficient=[motion.friction_coefficient for motion in motions],
        conductivity=[motion.moving.conductivity for motion in motions],
        diffusivity=[motion.moving.diffusivity for motion in motions],
        skin=motions[0].moving.skin,
        heat_depth=motions[0].moving.heat_depth,
        direction=atan(slope(grid)) if directed else None,
        from_rest=directed,
    )
    correlation = StressCorrelation(grid, path.steps + 1)
    spots = SpotLives()
    rows = []
    fractions = []
    frozen = []
    before = None
    late = np.zeros(())  # sum of the spectra over the last steps
    for n, step in enumerate(walk(contacts, grid, path, motions)):
        correlation.add(step.stress)
        if step.contact is not before:  # over a flat it stays
            spots.add(step.slid_distance, step.contact.pressure > 0.0)
            before = step.contact
        if n == 0:
            continue
        rows.append(step.numbers)
        fractions.append((step.contact.contact_fraction, step.contact.plastic_fraction))
        spectrum, sums = spectrum_and_sums(step.stress, grid, sliding)
        frozen.append(sums[0])
        for watcher in watchers:
            watcher.add(n, step)
        if n > LAST * path.steps:
            late = late + spectrum.variance
    heating = np.asarray(sliding.friction_coefficient) * np.array(sliding.speeds)
    factor = heating / (np.asarray(sliding.conductivity) * step.stress[0, 0].real)
    area, yielded = np.array(fractions).T
    curves = {
        "slid_distance": path.distance[1:],
        **dict(zip(NUMBERS, np.array(rows).transpose(1, 2, 0), strict=True)),
        "frozen_flash_temperature": (factor * np.array(frozen)).T,
        "contact_fraction": area,
        "plastic_fraction": yielded,
        "stress_correlation": correlation.mean(),
        "spot_survival": survival(spots.lives(), path.distance[1:]),
    }
    return SlideHistory(curves, late / (path.steps - int(LAST * path.steps)), step.contact)
