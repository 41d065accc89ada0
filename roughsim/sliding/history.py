"""All steps of a slide of two bodies, and maps of a few of its positions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from roughsim.contact import Contact
from roughsim.grid import Array, Grid
from roughsim.observables.moments import HeatSource, grid_responses, sums_over_directions
from roughsim.observables.stress_spectrum import stress_spectrum
from roughsim.sliding.correlation import StressCorrelation
from roughsim.sliding.distribution import Sampler
from roughsim.sliding.film import Film, Projector
from roughsim.sliding.path import Path
from roughsim.sliding.spots import SpotLives, survival
from roughsim.sliding.stepping import NUMBERS, Motion, walk

LAST = 0.5  # share of a slid distance, at its end, over which means are taken


@dataclass(frozen=True, slots=True, eq=False)
class SlideHistory:
    """Observables of two sliding bodies over the slid distance.

    Attributes
    ----------
    slid_distance : ndarray
        At the end of each step, m, shape (steps,).
    numbers : dict of str to ndarray
        `NUMBERS` at each speed, shape (speeds, steps).
    frozen_flash_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩, K, if the contact of that step slid on unchanged with all heat in the moving body; (speeds, steps).
    contact_fraction, plastic_fraction : ndarray
        Shape (steps,).
    stress_correlation : ndarray
        Of the stress with the stress at positions `slid_distance` earlier, shape (steps,).
    spot_survival : ndarray
        Share of the contact spots that live for longer than `slid_distance`, shape (steps,); NaN of a flat face.
    spectrum : ndarray
        Of the stress, Pa², mean over the last half of the distance.
    contact : Contact
        The last one.
    film : Film or None
        Maps of the selected positions.
    """

    slid_distance: Array
    numbers: dict[str, Array]
    frozen_flash_temperature: Array
    contact_fraction: Array
    plastic_fraction: Array
    stress_correlation: Array
    spot_survival: Array
    spectrum: Array
    contact: Contact
    film: Film | None


def follow(
    contacts: Iterator[Contact],
    grid: Grid,
    path: Path,
    motions: Sequence[Motion],
    filmed: Sequence[int] = (),
    sampler: Sampler | None = None,
) -> SlideHistory:
    """Slide along a path and record every step; the steps `filmed`, ascending and from 1 on, with their fields.

    A `sampler` takes the temperatures of the contact at its own positions.
    """
    sliding = HeatSource(
        speeds=[motion.speed for motion in motions],
        friction_coefficient=[motion.friction_coefficient for motion in motions],
        conductivity=[motion.moving.conductivity for motion in motions],
        diffusivity=[motion.moving.diffusivity for motion in motions],
        skin=motions[0].moving.skin,
        heat_depth=motions[0].moving.heat_depth,
    )
    responses = grid_responses(grid, tuple(sliding.rates), sliding.layers)
    correlation = StressCorrelation(grid)
    spots = SpotLives()
    projector = Projector(grid, len(motions), filmed)
    rows = []
    fractions = []
    frozen = []
    before = None
    late: Array = np.zeros(())  # sum of the spectra over the last steps
    for n, step in enumerate(walk(contacts, grid, path, motions)):
        correlation.add(step.stress)
        if step.contact is not before:  # over a flat it stays
            spots.add(step.slid_distance, step.contact.pressure > 0.0)
            before = step.contact
        if n == 0:
            continue
        rows.append(step.numbers)
        fractions.append((step.contact.contact_fraction, step.contact.plastic_fraction))
        spectrum, unseen = stress_spectrum(step.stress, grid, responses.gathering)
        frozen.append(sums_over_directions(spectrum, unseen, responses)[0])
        if sampler is not None:
            sampler.add(n, step)
        if n > LAST * path.steps:
            late = late + spectrum.variance
        projector.add(n, step)
    heating = np.asarray(sliding.friction_coefficient) * np.array(sliding.speeds)
    factor = heating / (np.asarray(sliding.conductivity) * step.stress[0, 0].real)
    area, yielded = np.array(fractions).T
    return SlideHistory(
        path.distance[1:],
        dict(zip(NUMBERS, np.array(rows).transpose(1, 2, 0), strict=True)),
        (factor * np.array(frozen)).T,
        area,
        yielded,
        correlation.mean(),
        survival(spots.lives(), path.distance[1:]),
        late / (path.steps - int(LAST * path.steps)),
        step.contact,
        projector.film(path),
    )
