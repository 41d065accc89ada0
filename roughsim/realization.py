"""One member of an ensemble: synthesis, contact and moments."""

from __future__ import annotations

import platform
import time
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from roughsim import fourier, prediction
from roughsim.contact import Contact, Solid, solvers
from roughsim.grid import Grid
from roughsim.observables.moments import Observables, Sliding, measure
from roughsim.scene.numerics import Numerics
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum
from roughsim.surface.synthesis import synthesize

if TYPE_CHECKING:
    from roughsim.scene import Scene

_AT_REST = 1e-150  # a speed of zero is measured at this one, m/s: the limits D_flash and s need a ratio of moments


@dataclass(frozen=True, slots=True, eq=False)
class Realization:
    """One member: a surface, its contact, and what was measured of it (all heat in the moving body).

    Attributes
    ----------
    level, index, seed : int
        Which member it is.
    grid : Grid
        Its cell.
    heights : ndarray
        Composite heights, m.
    contact : Contact
        The solved contact.
    observables : Observables
        Moments at the scene's speeds, averaged over directions.
    seconds : dict of str to float
        Time spent in each stage.
    """

    level: int
    index: int
    seed: int
    grid: Grid
    heights: NDArray[np.float64]
    contact: Contact
    observables: Observables
    seconds: dict[str, float]


def realize(scene: Scene, numerics: Numerics, *, seed: int, level: int = 0, index: int = 0) -> Realization:
    """Compute one member of an ensemble.

    Parameters
    ----------
    scene : Scene
        What is computed.
    numerics : Numerics
        How well; its `levels[level]` says which contact, grid and cut-off.
    seed : int
        Of the ensemble, ≥ 0.
    level, index : int
        Which member.

    Returns
    -------
    Realization
        The fields and what was measured.

    Raises
    ------
    ConvergenceError
        If the contact does not reach the tolerance.
    ValueError
        If `seed`, `level` or `index` do not exist.
    """
    for name, value, limit in (
        ("seed", seed, np.inf),
        ("level", level, len(numerics.levels)),
        ("index", index, np.inf),
    ):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < limit:
            raise ValueError(f"{name} = {value!r} must be a whole number from 0 to below {limit:g}")
    with _linear_algebra().limit(limits=numerics.threads):  # its sums depend on the number of threads
        return _realize(scene, numerics, seed, level, index)


@lru_cache(maxsize=1)
def _linear_algebra() -> ThreadpoolController:
    """Look for thread pools once: they are loaded by now, and the search takes milliseconds."""
    return ThreadpoolController()


def _realize(scene: Scene, numerics: Numerics, seed: int, level: int, index: int) -> Realization:
    grid = numerics.grid(level)
    stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(numerics.stream, index)))
    marks = [time.perf_counter()]
    heights = synthesize(level_spectrum(scene, numerics, level), grid, stream)
    marks.append(time.perf_counter())
    contact = solvers.solver(numerics.solver)(
        heights,
        grid,
        solid_of(scene, numerics.levels[level].column),
        nominal_pressure=scene.sliding.nominal_pressure,
        tolerance=numerics.tolerance,
        precision=numerics.precision,
    )
    marks.append(time.perf_counter())
    observables = measure(contact, grid, _sliding(scene))
    marks.append(time.perf_counter())
    seconds = dict(zip(("surface", "contact", "observables"), np.diff(marks).tolist(), strict=True))
    return Realization(level, index, seed, grid, heights, contact, observables, seconds)


@lru_cache(maxsize=16)
def level_spectrum(scene: Scene, numerics: Numerics, level: int) -> Spectrum:
    """Return the spectrum that a level's surfaces are drawn from: C, or C_sm for "smoothed", cut at its q_max."""
    wanted = numerics.levels[level]
    if wanted.column == "smoothed":
        return TruncatedSpectrum(prediction.smoothed_spectrum(scene), wanted.q_max)
    return scene.spectrum.truncated(q_max=wanted.q_max)


def solid_of(scene: Scene, column: str) -> Solid:
    """Return the solid of a column: with the hardness only where it is "capped"."""
    if column == "capped":
        return Solid(scene.effective_modulus, scene.penetration_hardness)
    return Solid(scene.effective_modulus)


def _sliding(scene: Scene) -> Sliding:
    bodies = prediction.conduction(scene)
    return Sliding(
        speeds=[speed or _AT_REST for speed in scene.speeds],
        friction_coefficient=scene.sliding.friction_coefficient,
        conductivity=bodies.conductivity.tolist(),
        diffusivity=bodies.diffusivity.tolist(),
    )


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Return the versions that the bits of a result may depend on."""
    found = {"python": platform.python_version(), "fft": fourier.backend()}
    for package in ("roughsim", "numpy", "scipy", "numba", "h5py"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found
