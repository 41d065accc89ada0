"""One member of the column "sliding": from C(q) of both faces to temperatures over the slid distance.

    surface.synthesize, both faces  →  contact, and temperatures of both bodies, at each step  →  means and curves

Beside the slide stands the frozen T_flash of the same contacts, with all the heat in the moving body. So the ratio of
the two scatters little from member to member. A second slide of the same faces on a coarser grid shows how the ratio
depends on the pixel, and on the step, which is one pixel.
"""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughsim.contact import Contact, Solid
from roughsim.grid import Array, Grid
from roughsim.heat.body import Body
from roughsim.observables.catalogue import CURVES, NUMBERS, quantiles_of
from roughsim.observables.member import Member, StoredMoments
from roughsim.observables.moments import HeatSource
from roughsim.observables.stress_spectrum import StressSpectrum, uniform_nodes
from roughsim.pipeline import linear_algebra
from roughsim.sliding.distribution import POSITIONS, Sampler
from roughsim.sliding.history import LAST, SlideHistory, Watcher, follow
from roughsim.sliding.path import Path, coarser_grid, oblique_path
from roughsim.sliding.pictures import Pictures, Shutter
from roughsim.sliding.snapshots import Projector
from roughsim.sliding.stepping import Motion, contacts
from roughsim.surface.spectrum import Spectrum as Roughness
from roughsim.surface.synthesis import synthesize

# bytes per point at the peak of a slide, measured: of the contact, of each speed, and of each exponential that a body
# remembers, whose weights are those of all modes if it is bare, and of each mode with a skin or heat in depth
BYTES_OF_CONTACT = 420.0
BYTES_OF_SPEED = 85.0
BYTES_OF_TERM = {"bare": 8.0, "layered": 12.0}
BYTES_OF_PICTURE = 8.0  # of a camera, at each speed
BYTES_OF_STEP = 2000.0  # of the numbers and the ended spots of a step
POINTS = 64  # distances, in geometric sequence, at which the curves are stored
FRAMES = 32  # positions of snapshots, at most


@dataclass(frozen=True, slots=True)
class SlideProblem:
    """All inputs of one slide; `replace(problem, index=7)` is another realization.

    The random streams are SeedSequence(seed, spawn_key=(stream, index)) for the face at rest, and that with a further
    1 for the one that moves.
    """

    resting_spectrum: Roughness  # C(q) of the face at rest, m⁴, up to the cut-off of the level
    moving_spectrum: Roughness | None  # of the face that rides with the moving body; None is a flat
    grid: Grid  # that the faces are drawn on, before their lay stretches them
    solid: Solid
    nominal_pressure: float  # σ₀, Pa
    sliding: HeatSource  # speeds, friction and the moving body
    resting: tuple[Body, ...]  # the resting body at each speed
    distances: tuple[float, ...]  # slid at each speed, m
    tolerance: float  # of the contact solves
    seed: int  # of the ensemble
    stream: int  # number of the level
    index: int = 0  # of the realization
    threads: int = 1
    distribution: bool = (
        False  # whether the distribution of the temperature is taken at the last positions
    )
    shutter: Shutter | None = None  # of a camera that takes a picture at the end of each speed
    # of both faces, γ if they slide along their grooves, 1/γ across: the slide is along x
    lay: float = 1.0

    @property
    def cell(self) -> Grid:
        """The grid of the contact."""
        return self.grid.stretched(self.lay)

    @property
    def steps(self) -> int:
        """How many there are, each of one pixel."""
        return oblique_path(self.cell, max(self.distances)).steps

    @property
    def memory(self) -> float:
        """The peak memory of the slide, bytes: both bodies remember their heat, at each speed."""
        decades = math.log10(max(self.steps, 2))
        # the usual numbers of exponentials, within 2 from 24 to 10⁴ steps
        bare = BYTES_OF_TERM["bare"] * (4 + 3 * decades)
        layered = BYTES_OF_TERM["layered"] * (1 + 8 * decades)
        bodies = [body for motion in self.motions for body in (motion.moving, motion.resting)]
        heat = sum(bare if body.layers is None else layered for body in bodies)
        each = BYTES_OF_SPEED
        if self.distribution:  # pressures and temperatures in single precision, and their order
            each += 8 * POSITIONS + 40
        if self.shutter is not None:
            each += BYTES_OF_PICTURE
        of_fields = self.grid.points * (BYTES_OF_CONTACT + each * len(self.distances) + heat)
        return of_fields + BYTES_OF_STEP * self.steps

    @property
    def coarser(self) -> "SlideProblem | None":
        """The same faces on the `coarser_grid`; None if it does not resolve all of their waves."""
        faces = [face for face in (self.resting_spectrum, self.moving_spectrum) if face is not None]
        grid = coarser_grid(self.grid, max(face.breaks[-1] for face in faces))
        return None if grid is None else replace(self, grid=grid)

    @property
    def motions(self) -> list[Motion]:
        """The contact's motion at each speed."""
        sliding = self.sliding
        friction = np.broadcast_to(sliding.friction_coefficient, len(self.resting)).tolist()
        columns = sliding.speeds, friction, sliding.bodies, self.resting, self.distances
        return list(map(Motion, *columns))


def solve_slide(problem: SlideProblem, *, snapshots: bool = False) -> Member:
    """Draw both faces, slide one over the other and measure; ConvergenceError if a contact or a share is not found.

    With `snapshots` the maps of some positions are kept, too. The level of the member is 0.
    """
    grid = problem.cell
    with linear_algebra().limit(limits=problem.threads):
        begin = time.perf_counter()
        path, contacts_along = _sliding_contacts(problem)
        drawn = time.perf_counter()
        pictured = snapshot_steps(path) if snapshots else ()
        projector = Projector(grid, len(problem.distances), pictured)
        watchers: list[Watcher] = [projector]
        samples = None
        if problem.distribution:
            samples = Sampler(grid, path.steps_to(problem.distances), LAST)
            watchers.append(samples)
        history, numbers = _followed(problem, path, contacts_along, watchers)
        coarser = _coarser_means(problem.coarser) if problem.coarser else {}
        solved = time.perf_counter()
    bins = None
    if samples is not None:
        distribution = samples.together(numbers["sliding_flash_temperature"])
        numbers |= quantiles_of(distribution, "sliding_")
        bins = distribution.bins
    wavenumber = uniform_nodes(grid).entries
    return Member(
        0,
        problem.index,
        moments=(StoredMoments(numbers | coarser, wavenumber, history.spectrum, bins),),
        curves=_curves_of(history.curves, path),
        fields=projector.fields(path),
        provenance={
            "residual": float(np.nanmax(history.curves["residual"])),
            "iterations": path.steps,
            "seconds": {"surface": drawn - begin, "contact": solved - drawn},
        },
    )


def _followed(
    problem: SlideProblem,
    path: Path,
    contacts_along: Iterator[Contact],
    watchers: Sequence[Watcher] = (),
) -> tuple[SlideHistory, dict[str, Array]]:
    """Slide; return the history, and the numbers to store, those of `_means_of` and of the picture of a camera."""
    grid = problem.cell
    ends = path.steps_to(problem.distances)
    pictures = None
    if problem.shutter is not None:
        pictures = Pictures(grid, path, ends, problem.shutter)
        watchers = [*watchers, pictures]
    directed = problem.lay != 1.0
    history = follow(contacts_along, grid, path, problem.motions, watchers, directed=directed)
    numbers = _means_of(history.curves, ends)
    if pictures is not None:
        stress = StressSpectrum(
            uniform_nodes(grid).entries, history.spectrum, 0.5 * math.hypot(*grid.lengths)
        )
        numbers |= pictures.numbers(stress, history.contact, problem.sliding)
    return history, numbers


def _coarser_means(problem: SlideProblem) -> dict[str, Array]:
    """Return the numbers of a slide on the coarser grid that a member stores, by their stored names."""
    _, numbers = _followed(problem, *_sliding_contacts(problem))
    coarser = {name.replace("sliding_", "sliding_coarser_"): one for name, one in numbers.items()}
    return {name: one for name, one in coarser.items() if name in NUMBERS}


def _sliding_contacts(problem: SlideProblem) -> tuple[Path, Iterator[Contact]]:
    """Draw both faces; return the path, and the contacts along it, each solved on demand."""
    path = oblique_path(problem.cell, max(problem.distances))
    load = problem.nominal_pressure
    tolerance = problem.tolerance
    return path, contacts(*faces(problem), problem.cell, problem.solid, load, path, tolerance)


def faces(problem: SlideProblem) -> tuple[Array, Array | None]:
    """Draw the face at rest and the one that rides with the moving body, m; None is a flat."""
    key = (problem.stream, problem.index)
    moving = problem.moving_spectrum
    heights = synthesize(problem.resting_spectrum, problem.grid, _stream_of(problem.seed, *key))
    if moving is None:
        return heights, None
    return heights, synthesize(moving, problem.grid, _stream_of(problem.seed, *key, 1))


def _stream_of(seed: int, *key: int) -> np.random.Generator:
    """Return the random stream of a face."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def _means_of(curves: dict[str, Array], ends: list[int]) -> dict[str, Array]:
    """Return the stored numbers: means over the last half of the steps at each speed, and T₀ at its end."""
    steps = np.arange(1, curves["slid_distance"].size + 1)
    last = np.array(ends)[:, None]
    late = (steps <= last) & (steps > LAST * last)
    names = {
        "sliding_flash_temperature": "flash_temperature",
        "sliding_share": "moving_share",
        "sliding_frozen_flash_temperature": "frozen_flash_temperature",
    }
    means = {stored: np.mean(curves[name], axis=1, where=late) for stored, name in names.items()}
    end = np.take_along_axis(curves["background"], last - 1, axis=1)[:, 0]
    return means | {"sliding_background": end}


def _curves_of(curves: dict[str, Array], path: Path) -> dict[str, Array]:
    """Return the stored curves, at the `_chosen_steps`."""
    chosen = _chosen_steps(path) - 1
    return {
        name: np.ascontiguousarray(curves[name.removeprefix("slide_")][..., chosen])
        for name in CURVES
    }


def _chosen_steps(path: Path) -> NDArray[np.intp]:
    """Return the steps of the curves: up to `POINTS` in geometric sequence, from the first to the last."""
    return np.unique(np.rint(np.geomspace(1, path.steps, POINTS)).astype(np.intp))


def snapshot_steps(path: Path) -> list[int]:
    """Return the steps of snapshots: every so many of the `_chosen_steps`, the last among them."""
    chosen = _chosen_steps(path)
    return chosen[:: -math.ceil(chosen.size / FRAMES)][::-1].tolist()
