"""From scene and numerics to the contact problem of each member."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from roughsim import prediction
from roughsim.contact import Solid
from roughsim.observables.moments import Sliding
from roughsim.pipeline import Problem, Solution, linear_algebra, solve_problem
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum

_AT_REST = 1e-150  # m/s, in place of zero: at rest D_flash and the heat share are limits of ratios of moments


def realize(scene: Scene, numerics: Numerics, *, seed: int, level: int = 0, index: int = 0) -> Solution:
    """Compute one member of an ensemble.

    Parameters
    ----------
    scene : Scene
        What is computed.
    numerics : Numerics
        How accurately; its `levels[level]` has the column, grid and cut-off.
    seed : int
        Of the ensemble, ≥ 0.
    level, index : int
        Which member.

    Returns
    -------
    Solution
        The surface, its contact, and what was measured of it at the scene's speeds.

    Raises
    ------
    ConvergenceError
        If the contact does not reach the tolerance.
    ValueError
        If `seed`, `level` or `index` is no whole number, or out of range.
    """
    limits = {"seed": (seed, np.inf), "level": (level, len(numerics.levels)), "index": (index, np.inf)}
    for name, (value, limit) in limits.items():
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < limit:
            raise ValueError(f"{name} = {value!r} must be a whole number from 0 to below {limit:g}")
    return solve_problem(replace(level_problem(scene, numerics, level), seed=seed, index=index))


@lru_cache(maxsize=16)
def level_problem(scene: Scene, numerics: Numerics, level: int) -> Problem:
    """Return the contact problem of a level for realization 0, with the seed of the scene."""
    with linear_algebra().limit(limits=numerics.threads):
        column, q_max = numerics.levels[level].column, numerics.levels[level].q_max
        if column == "smoothed":  # elastic contact of the surface that yielding leaves
            spectrum: Spectrum = TruncatedSpectrum(prediction.smoothed_spectrum(scene), q_max)
        else:
            spectrum = scene.spectrum.truncated(q_max=q_max)
        bodies = prediction.conduction(scene)
        return Problem(
            spectrum=spectrum,
            grid=numerics.grid(level),
            solid=Solid(scene.effective_modulus, scene.penetration_hardness if column == "capped" else np.inf),
            nominal_pressure=scene.sliding.nominal_pressure,
            sliding=Sliding(
                speeds=[speed or _AT_REST for speed in scene.speeds],
                friction_coefficient=prediction.friction_coefficient(scene).tolist(),
                conductivity=bodies.conductivity.tolist(),
                diffusivity=bodies.diffusivity.tolist(),
            ),
            tolerance=numerics.tolerance,
            precision=numerics.precision,
            solver=numerics.solver,
            seed=scene.ensemble.seed,
            stream=numerics.stream(level),
            threads=numerics.threads,
        )
