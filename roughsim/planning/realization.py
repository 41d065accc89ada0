"""From scene and numerics to the contact problem of each member."""

from dataclasses import replace
from math import atan

import numpy as np

from roughsim import prediction
from roughsim.contact import Solid
from roughsim.errors import ResolutionError
from roughsim.grid import Grid
from roughsim.heat.body import Body
from roughsim.observables.temperatures import SlideFromRest
from roughsim.pipeline import Problem, Solution, linear_algebra, solve_problem
from roughsim.scene import Scene, SceneLike, as_scene
from roughsim.scene.checks import check_levels
from roughsim.scene.numerics import Numerics
from roughsim.sliding.member import SlideProblem
from roughsim.sliding.path import oblique_path, pixel_of_path, slope
from roughsim.sliding.pictures import Shutter
from roughsim.surface.directions import directed_as
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum

_LEAST_STEPS = 4  # of a slide: the last half has means


def realize(
    scene: SceneLike, numerics: Numerics, *, seed: int, level: int = 0, index: int = 0
) -> Solution:
    """Compute one member of an ensemble.

    Parameters
    ----------
    scene : Scene, str, path or dict
        Scene to compute, or an argument of `load_scene`.
    numerics : Numerics
        Numerical parameters; `levels[level]` has the column, grid and cut-off.
    seed : int
        Seed of the ensemble, ≥ 0.
    level, index : int
        Level and number of the member.

    Returns
    -------
    Solution
        The surface, its contact, and the observables at the scene's speeds.

    Raises
    ------
    ConvergenceError
        If the contact, or that of the level below, from which it begins, does not reach the tolerance.
    ValueError
        If `seed`, `level` or `index` is no whole number, or out of range, or the scene lacks the column of a level.
    """
    scene = as_scene(scene)
    check_levels(scene, numerics.levels)
    limits = {
        "seed": (seed, 2**63),
        "level": (level, len(numerics.levels)),
        "index": (index, 2**63),
    }
    for name, (value, limit) in limits.items():
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, np.integer))
            or not 0 <= value < limit
        ):
            raise ValueError(f"{name} = {value!r} must be a whole number from 0 to below {limit:g}")
    if level == numerics.slide:
        raise ValueError(
            f"level = {level} is the slide of one body over the other, which is no single contact; choose another "
            "level, or use roughsim.slide"
        )
    scene = scene_of(scene, numerics)
    problem, below = level_problem(scene, numerics, level), below_problem(scene, numerics, level)
    start = None
    if below is not None and problem.takes_start:
        start = solve_problem(
            replace(below, seed=seed, index=index)
        ).contact  # as in a run: for the same bits
    return solve_problem(replace(problem, seed=seed, index=index), start=start)


def scene_of(scene: Scene, numerics: Numerics) -> Scene:
    """Return the scene that is computed: without a hardness that is never reached, unless a column needs it."""
    return scene if {"smoothed", "capped"} & {*numerics.columns} else prediction.computed(scene)


def slide_problem(scene: Scene, numerics: Numerics) -> SlideProblem:
    """Return the slide of realization 0, with the seed of the scene; `numerics.slide` is its level."""
    number = numerics.slide or 0
    level, lay = numerics.levels[number], scene.lay_along_slide
    grid = numerics.grid(number)
    cell = grid.stretched(lay)
    prediction.check_continuation(scene, level.followed, cell.lengths[0])
    distances = tuple(
        min(distance, level.followed or np.inf) for distance in scene.sliding.distances
    )
    if min(distances) < _LEAST_STEPS * (step := pixel_of_path(cell)) * (1 - 1e-9):
        k = int(np.argmin(distances))
        if distances[k] == level.followed:
            raise ResolutionError(
                f"followed = {level.followed:.4g} m is under {_LEAST_STEPS} pixels of {step:.4g} m on the grid "
                f"{level.shape}; follow the slide further, or refine the last of numerics.levels"
            )
        raise ResolutionError(
            f"slid distance = {distances[k]:.4g} m at {scene.speeds[k]:g} m/s is under {_LEAST_STEPS} "
            f"pixels of {step:.4g} m on the grid {level.shape}; slide further, leave out the slow speeds, or refine "
            "the last of numerics.levels"
        )
    oblique_path(cell, max(distances))  # refuses too many steps
    resting, moving = scene.sliding_faces
    bodies = prediction.conduction(scene)
    return SlideProblem(
        resting_spectrum=resting.truncated(q_max=level.q_max),
        moving_spectrum=None if moving is None else moving.truncated(q_max=level.q_max),
        grid=grid,
        solid=Solid(scene.effective_modulus, scene.penetration_hardness),
        nominal_pressure=scene.sliding.nominal_pressure,
        sliding=prediction.heat_source(scene),
        resting=tuple(
            Body(kappa, diffusivity, **scene.layers[1]._asdict())
            for kappa, diffusivity in zip(
                bodies.counter_conductivity, bodies.counter_diffusivity, strict=True
            )
        ),
        distances=distances,
        tolerance=numerics.tolerance,
        seed=scene.ensemble.seed,
        stream=numerics.stream(number),
        threads=numerics.threads,
        distribution=scene.distribution,
        shutter=_shutter(scene, cell),
        lay=lay,
    )


def _shutter(scene: Scene, grid: Grid) -> Shutter | None:
    """Return the camera of a slide; None without one, or on a line behind the contact, which is not followed."""
    camera = scene.camera
    if camera is None or camera.behind is not None:
        return None
    return Shutter(
        prediction.camera_of(scene)._replace(direction=atan(slope(grid))),
        tuple(speed * camera.exposure for speed in scene.speeds),
        camera.fixed_to == "body",
    )


def level_problem(scene: Scene, numerics: Numerics, level: int) -> Problem:
    """Return the contact problem of a level for realization 0, with the seed of the scene."""
    return _problem(scene, numerics, level, numerics.levels[level].q_max, numerics.grid(level))


def below_problem(scene: Scene, numerics: Numerics, level: int) -> Problem | None:
    """Return the contact problem of the level below on the surfaces of `level`; None for the lowest of a column."""
    below = numerics.below(level)
    if below is None:
        return None
    return _problem(
        scene, numerics, level, numerics.levels[below].q_max, numerics.grid_below(level)
    )


def _problem(scene: Scene, numerics: Numerics, level: int, q_max: float, grid: Grid) -> Problem:
    """Return the contact problem of the surfaces of a level, up to a cut-off and on a grid."""
    with linear_algebra().limit(limits=numerics.threads):
        elastic = numerics.levels[level].column in ("smoothed", "elastic")
        spectrum: Spectrum = scene.spectrum.truncated(q_max=q_max)
        if (
            numerics.levels[level].column == "smoothed"
        ):  # elastic contact of the surface that yielding leaves
            smoothed = TruncatedSpectrum(prediction.smoothed_spectrum(scene), q_max)
            spectrum = directed_as(scene.spectrum, smoothed)
        return Problem(
            spectrum=spectrum,
            grid=grid,
            solid=Solid(scene.effective_modulus, np.inf if elastic else scene.penetration_hardness),
            nominal_pressure=scene.sliding.nominal_pressure,
            sliding=prediction.heat_source(scene),
            tolerance=numerics.tolerance,
            precision=numerics.precision,
            solver=numerics.solver,
            seed=scene.ensemble.seed,
            stream=numerics.stream(level),
            threads=numerics.threads,
            with_peaks=numerics.below(level) is None,  # control variates of the lowest level alone
            distribution=SlideFromRest(prediction.headings_of_fields(scene), numerics.slid_distance)
            if scene.distribution
            else None,
            camera=prediction.camera_of(scene),
            lay=scene.lay,
        )
