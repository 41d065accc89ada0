"""One contact problem, from the spectrum of its surface to the moments of its temperature: numbers in, numbers out.

    surface.synthesize  →  contact.solver  →  observables.measure

A worker of an ensemble needs no scene: `planning.realization` has turned the scene into a `Problem` before.
"""

import platform
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from typing import Literal

import numpy as np
from threadpoolctl import ThreadpoolController

from roughsim import fourier
from roughsim.contact import Contact, Solid
from roughsim.extensions import INSIDE, loaded
from roughsim.grid import Field, Grid
from roughsim.machine import BYTES_PER_POINT
from roughsim.observables.camera import Camera, correlations_of, hottest_of
from roughsim.observables.moments import HeatSource, measure
from roughsim.observables.record import Measured
from roughsim.observables.temperatures import SlideFromRest, temperature_distribution
from roughsim.surface.peak_volume import peak_volume
from roughsim.surface.spectrum import Spectrum
from roughsim.surface.synthesis import synthesize

# fields of a problem that do not concern the contact, and those that do not concern the surface
_HEAT_KEYS = ("sliding", "distribution", "camera")
_CONTACT_KEYS = ("solid", "nominal_pressure", "tolerance", "precision", "solver", *_HEAT_KEYS)


@dataclass(frozen=True, slots=True)
class Problem:
    """Everything that decides the bits of one member; `replace(problem, index=7)` is another realization.

    The random stream is SeedSequence(seed, spawn_key=(stream, index)). Problems with the same stream, index and cell
    see the same modes, up to their cut-offs.
    """

    spectrum: Spectrum  # C(q) that the surface is drawn from, m⁴, up to the cut-off of the level
    grid: Grid  # that the surface is drawn on, before its lay stretches it
    solid: Solid
    nominal_pressure: float  # σ₀, Pa
    sliding: HeatSource  # speeds, friction and the moving body, which takes up all the heat
    tolerance: float  # of the contact solve
    precision: Literal["double", "single"]  # of the fields of the contact
    solver: str  # a name among the extensions
    seed: int  # of the ensemble
    stream: int  # number of the level that names the random stream
    index: int = 0  # of the realization
    threads: int = 1  # of the linear algebra: the last bits of its sums depend on it
    with_peaks: bool = False  # whether the peak volume of the surface is computed
    distribution: SlideFromRest | None = (
        None  # after which the distribution of the temperature is taken; None: it is not
    )
    camera: Camera | None = None  # that looks at the temperature
    lay: float = 1.0  # of the surface; its grooves run along x

    @property
    def cell(self) -> Grid:
        """The grid of the surface, its contact and its temperature."""
        return self.grid.stretched(self.lay)

    @property
    def memory(self) -> float:
        """The peak memory of the member, bytes."""
        return BYTES_PER_POINT * self.grid.points

    @property
    def takes_start(self) -> bool:
        """Whether its solver begins from another contact: those of other packages may not know the argument."""
        return self.solver in INSIDE["solvers"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Solution(Measured):
    """A surface, its contact, and its observables with all heat in the moving body."""

    seconds: dict[str, float]  # spent in each stage: surface, contact, observables


Solved = tuple[Problem, Solution]


def solve_problem(
    problem: Problem,
    before: Solved | None = None,
    heights: Field | None = None,
    start: Contact | None = None,
) -> Solution:
    """Draw the surface, solve its contact and measure it; ConvergenceError if the contact misses the tolerance.

    A surface of one's own may take the place of the drawn one: `heights`, m, on the grid of the problem. `start` is the
    contact of the level below on the same surface, from which our own solver begins: it takes some 20 % less time.
    Surface and contact are taken from the solution `before` where they are equal, with the same bits if it had the same
    start.
    """
    with linear_algebra().limit(limits=problem.threads):
        began, cell = time.perf_counter(), problem.cell
        peaks = 0.0
        if heights is None:
            if before is not None and _same_but(problem, before[0], _CONTACT_KEYS):
                heights = before[1].heights
            else:
                heights = synthesize(problem.spectrum, problem.grid, generator(problem))
            if problem.with_peaks:
                modulus = problem.solid.effective_modulus
                ratios = (
                    problem.nominal_pressure / modulus,
                    problem.solid.penetration_hardness / modulus,
                )
                peaks = peak_volume(problem.spectrum, problem.grid, heights, *ratios)
        drawn = time.perf_counter()
        if before is not None and _same_but(problem, before[0], _HEAT_KEYS):
            contact = before[1].contact
        else:
            contact = loaded("solvers", problem.solver)(
                heights,
                cell,
                problem.solid,
                nominal_pressure=problem.nominal_pressure,
                tolerance=problem.tolerance,
                precision=problem.precision,
                **({"start": start} if problem.takes_start else {}),
            )
        solved = time.perf_counter()
        moments = measure(contact, cell, problem.sliding)
        distribution = None
        if problem.distribution is not None:
            distribution = temperature_distribution(
                contact.pressure,
                cell,
                problem.sliding,
                moments.flash_temperature,
                problem.distribution,
            )
        seen, correlations = None, None
        if problem.camera is not None:
            pressure, spectrum = contact.pressure, moments.stress_spectrum
            seen = hottest_of(pressure, cell, spectrum, problem.sliding, problem.camera)
            if problem.camera.directed:
                correlations = correlations_of(pressure, cell, problem.camera)
        measured = time.perf_counter()
    return Solution(
        grid=cell,
        heights=heights,
        contact=contact,
        observables=moments,
        peak_volume=peaks,
        distribution=distribution,
        seen_99=seen,
        seen_correlations=correlations,
        seconds={
            "surface": drawn - began,
            "contact": solved - drawn,
            "observables": measured - solved,
        },
    )


def generator(problem: Problem) -> np.random.Generator:
    """Return the random stream that draws the surface of a problem, at its beginning."""
    key = problem.stream, problem.index
    return np.random.default_rng(np.random.SeedSequence(problem.seed, spawn_key=key))


def _same_but(problem: Problem, other: Problem, names: tuple[str, ...]) -> bool:
    """Whether two problems are equal in all but some of their fields."""
    changed = {name: getattr(other, name) for name in names}
    return replace(problem, **changed) == other


@lru_cache(maxsize=1)  # 8 ms for each member
def linear_algebra() -> ThreadpoolController:
    """Return the thread pools of the linear algebra."""
    return ThreadpoolController()


@lru_cache(maxsize=1)  # 6 ms for each member
def versions() -> dict[str, str]:
    """Return the versions that the bits of a result may depend on."""
    result = {"python": platform.python_version(), "fft": fourier.backend()}
    for package in ("roughsim", "numpy", "scipy", "numba", "h5py"):
        try:
            result[package] = version(package)
        except PackageNotFoundError:
            result[package] = "unknown"
    return result
