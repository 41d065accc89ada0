"""T_flash by a plain multilevel script, as an able user writes it on the contact and heat functions: a peer of a run.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/plain.py SCENE [--target 0.01] [--seed 1]

Multilevel Monte Carlo by the textbook (Giles, Acta Numerica 24, 2015, 259). Each level has twice the pixels per length
of the one below, and as much of C(q) as they hold. Both grids of a correction have the same surface, in a part of the
cell. Variances and CPU times share out the members; levels are added until the rest beyond them is known well enough.
Elastic or capped contact alone, with the heat share of the scene, or all heat in the moving body; the cell and its part
are those of `rs.plan`, their error does not count, and there is no file.
"""

from __future__ import annotations

import argparse
import time
from typing import Any, NamedTuple

import numpy as np

import roughsim as rs

COARSEST, FINEST = 256, 4096  # points per side, of the lowest level and of the largest grid
SMALL = 256  # points per side at least of a correction in a part of the cell
TOLERANCE = 3e-3  # of a contact, as in runs
FIRST, ADDED = (12, 6, 6), 2  # members of the first levels, and at least of an added one
REST = 0.7  # of the target, which the error of the rest may be
FALL = 0.5  # of corrections from level to level, of first order in 1/q_max
Array = np.ndarray[Any, np.dtype[np.float64]]


class Result(NamedTuple):
    """T_flash, K, and its relative 95 % errors, by speed."""

    mean: Array
    statistical: Array
    rest: Array  # of the rest beyond the highest level
    members: list[int]  # of each level

    @property
    def error(self) -> Array:
        """The total error."""
        return np.hypot(self.statistical, self.rest)


def flash_temperature(scene: rs.Scene, grid: rs.Grid, seed: list[int]) -> Array:
    """Return T_flash of one surface, K, by speed; grids of one cell and equal seeds share their waves."""
    q_max = min(scene.spectrum.breaks[-1], np.pi / grid.spacing[0])
    generator = np.random.default_rng(seed)
    contact = rs.solve_contact(
        rs.synthesize(scene.spectrum.truncated(q_max=q_max), grid, generator),
        grid,
        rs.Solid(scene.effective_modulus, scene.penetration_hardness),
        nominal_pressure=scene.sliding.nominal_pressure,
        tolerance=TOLERANCE,
    )
    body, friction = scene.conduction(), scene.friction_coefficient()
    share = scene.sliding.heat_partition
    heat = rs.HeatSource(
        scene.speeds,
        friction,
        body.conductivity,
        body.diffusivity,
        heat_partition=1.0 if isinstance(share, str) else share,
    )
    return rs.measure(contact, grid, heat).flash_temperature


def correction(scene: rs.Scene, length: float, points: int, seed: list[int]) -> Array:
    """Return the change of T_flash of one surface by half the pixel and twice the cut-off, K."""
    fine, coarse = (
        flash_temperature(scene, rs.Grid((n, n), (length, length)), seed)
        for n in (points, points // 2)
    )
    return fine - coarse


def member(scene: rs.Scene, length: float, parts: int, level: int, seed: list[int]) -> Array:
    """Return T_flash of a surface of the lowest level, or a correction in a part of the cell, K."""
    points = COARSEST << level
    if level == 0:
        return flash_temperature(scene, rs.Grid((points, points), (length, length)), seed)
    part = max(n for n in (1, 2, 4) if n == 1 or (n <= parts and points >= n * SMALL))
    return correction(scene, length / part, points // part, seed)


def fall_above(scene: rs.Scene, length: float, level: int) -> float:
    """Return the factor by which corrections fall above a level: smaller if it holds all of C(q)."""
    highest = np.pi * (COARSEST << level) / length
    return FALL if highest < scene.spectrum.breaks[-1] else FALL**2


def extrapolated(samples: list[list[Array]], falls: list[float]) -> tuple[Result, Array]:
    """Return the mean of all levels with the rest beyond them, and the variance of a member of each level in it, K².

    `falls` are the factors by which corrections fall above each level.
    """
    counts = np.array([[len(values)] for values in samples])
    means = np.array([np.mean(values, axis=0) for values in samples])
    before, rest = (
        correction * fall / (1.0 - fall)
        for correction, fall in zip(means[-2:], falls[-2:], strict=True)
    )
    mean = means.sum(axis=0) + rest
    # by how much the last level has changed the extrapolated value, and at least half of the rest
    change = means[-1] + rest - before
    of_rest = np.maximum(np.abs(change), 0.5 * np.abs(rest)) / mean
    variances = np.array([np.var(values, axis=0, ddof=1) for values in samples])
    for level in range(2, len(samples)):  # few members may show too little
        variances[level] = np.maximum(variances[level], 0.5 * FALL**2 * variances[level - 1])
    variances[-1] /= (1.0 - falls[-1]) ** 2  # it carries the rest, too
    statistical = 1.96 * np.sqrt((variances / counts).sum(axis=0)) / mean
    return Result(mean, statistical, of_rest, counts.ravel().tolist()), variances


def plain(scene: rs.Scene, target: float, seed: int = 1) -> Result:
    """Return T_flash to a relative total error, 95 %, at the worst speed, or as close as the largest grid comes."""
    plan = rs.plan(scene, target)
    length, parts = plan.lengths[0], max(level.parts for level in plan.levels)
    samples: list[list[Array]] = [[] for _ in FIRST]
    seconds, wanted = [0.0 for _ in FIRST], list(FIRST)
    while True:
        for level, count in enumerate(wanted):
            begun = time.process_time()
            for number in range(len(samples[level]), count):
                samples[level].append(member(scene, length, parts, level, [seed, level, number]))
            seconds[level] += time.process_time() - begun
        falls = [fall_above(scene, length, level) for level in range(len(samples))]
        result, variances = extrapolated(samples, falls)
        more = result.rest.max() > REST * target
        too_fine = (COARSEST << len(samples)) > parts * FINEST
        if result.error.max() <= target or (more and too_fine):
            return result
        if more:
            samples.append([])
            seconds.append(0.0)
            wanted = [*result.members, ADDED]
            continue
        # N = √(V/C) Σ √(V C) (z/goal)², of the speed with the largest
        goal = np.sqrt(target**2 - result.rest**2) * result.mean
        cost = np.array([[spent / n] for spent, n in zip(seconds, result.members, strict=True)])
        share = np.sqrt(variances / cost) * np.sqrt(variances * cost).sum(axis=0)
        needed = np.ceil(share * (1.96 / goal) ** 2).max(axis=1).astype(int)
        wanted = np.maximum(needed, result.members).tolist()


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("scene", nargs="?", default="demo")
    options.add_argument("--target", type=float, default=0.01, help="relative total error")
    options.add_argument("--seed", type=int, default=1)
    given = options.parse_args()
    scene = rs.load_scene(given.scene)
    begun = time.process_time()
    found = plain(scene, given.target, given.seed)
    for speed, mean, error in zip(scene.speeds, found.mean, found.error, strict=True):
        print(f"T_flash at {speed:g} m/s: {mean:.5g} K ± {100 * error:.2g} %")
    seconds = time.process_time() - begun
    print(f"{seconds:.2f} CPU s, members of the levels: {', '.join(map(str, found.members))}")


if __name__ == "__main__":
    main()
