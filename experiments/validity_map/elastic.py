"""Elastic points of the map: many coarse members, fewer with all roughness, a few on fine grids.

A point is a load p/(E*h'), a Hurst exponent and a bandwidth q_1/q_r; C(q) has a plateau from q_r/2, the cell is eight
waves of q_r wide. Levels, on shared random streams (the same modes): "coarse" (q_c = 8 q_r, many), "main" (q_1 at 4
pixels per shortest wave), "fine" (8 and 16 pixels). Coarse members are a control variate of the main ones; fine ones
give the pixel error, and the tail beyond q_1, which goes on as q^-4 and is completed beyond their grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from scipy.fft import next_fast_len

import roughsim as rs
from validity_map import members
from validity_map.members import kernel_matrix, radial

EDGES = np.concatenate([np.geomspace(0.45, 1.0, 9), np.geomspace(1.0, 4096.0, 97)[1:]])  # bands of q/q_r: 8 an octave
COARSE_END = 8.0
CUT = 0.6  # of the Nyquist wavenumber: above, the grid distorts the stress
TAIL = {8: (0.77, 0.10), 16: (0.97, 0.03)}  # what the tail falls by beyond the grid, and how uncertain that is


@dataclass(frozen=True)
class Point:
    """Where on the map: load in units of E*h', H, q_1/q_r, and how long the plateau is."""

    load: float
    hurst: float
    bandwidth: float
    plateau: float = 2.0
    seed: int = 1
    low_exponent: float = 0.0

    @property
    def name(self) -> str:
        """Name of its file."""
        low = f"-m{self.low_exponent:g}" if self.low_exponent else ""
        return f"p{self.load:g}-H{self.hurst:g}-r{self.bandwidth:g}-k{self.plateau:g}{low}-s{self.seed}"

    @property
    def spectrum(self) -> rs.SelfAffineSpectrum:
        """C(q) with rms slope 1 and q_r = 1."""
        return members.spectrum_of(self.hurst, self.plateau, self.bandwidth, self.low_exponent)

    @property
    def periods(self) -> float:
        """Waves of q_r along a side: four of the longest; twice that under light loads, which need it."""
        return self.short_side * (2.0 if self.load < 0.01 else 1.0)

    @property
    def short_side(self) -> float:
        """Waves of q_r along a side of the fine grids: enough for what the pixels change."""
        return max(8.0, 4.0 * self.plateau)

    def grid(self, q_max: float, pixels: float, periods: float) -> rs.Grid:
        """Return the grid with so many pixels per shortest wave."""
        points = 2 * next_fast_len(round(0.5 * periods * pixels * q_max), real=True)
        return rs.Grid((points, points), (periods * 2 * pi,) * 2)


@dataclass(frozen=True)
class Effort:
    """How many members a point has at each level."""

    coarse: int
    main: int
    fine: dict[int, int]


def effort(point: Point) -> Effort:
    """Return the numbers of members: light contact is a few spots and scatters most; large cells hold more spots."""
    steps = ((0.003, 80), (0.01, 48), (0.03, 80), (0.1, 40), (np.inf, 24))
    coarse = next(n for limit, n in steps if point.load < limit)
    coarse = max(round(coarse * (8.0 / point.short_side) ** 2), 12)
    largest = point.short_side * point.bandwidth  # of the fine grids, at one pixel per wave
    if point.bandwidth <= 12:
        return Effort(0, coarse, {8: 4, 16: 4} if largest < 130 else {8: 2, 16: 2})
    if largest <= 320:
        return Effort(coarse, max(coarse // (4 if point.bandwidth <= 24 else 6), 12), {8: 2, 16: 2})
    return Effort(coarse, 6, {8: 1})


def measure(point: Point, work: Effort | None = None) -> dict[str, Any]:
    """Solve all members of a point and return what `estimate` needs, as arrays."""
    work = work or effort(point)
    whole, cut = point.spectrum, point.spectrum.truncated(q_max=COARSE_END)
    seeds = [np.random.SeedSequence(point.seed, spawn_key=(k,)) for k in range(max(work.main, work.coarse))]
    main_grid = point.grid(point.bandwidth, 4, point.periods)
    main = [members.solve(whole, main_grid, point.load, seed) for seed in seeds[: work.main]]
    result = {
        "main": np.array([m.functionals for m in main]),
        "main_area": np.array([m.corrected for m in main]),
        "bands": np.array([bands(m.stress, main_grid) for m in main]),
        "full_bands": bands(full_contact(point, main_grid), main_grid),
    }
    if work.coarse:
        grid = point.grid(COARSE_END, 4, point.periods)
        coarse = [members.solve(cut, grid, point.load, seed) for seed in seeds[: work.coarse]]
        result["coarse"] = np.array([m.functionals for m in coarse])
        result["coarse_area"] = np.array([m.corrected for m in coarse])
    return result | _fine(point, work, seeds)


def _fine(point: Point, work: Effort, seeds: list[Any]) -> dict[str, Any]:
    """Return the same modes on finer grids, and on the grid of the main members in a cell of the same size."""
    reference = point.grid(point.bandwidth, 4, point.short_side)
    same = [members.solve(point.spectrum, reference, point.load, seed) for seed in seeds[: max(work.fine.values())]]
    result = {
        "reference": np.array([m.functionals for m in same]),
        "reference_area": np.array([m.corrected for m in same]),
        "reference_bands": np.array([bands(m.stress, reference) for m in same]),
    }
    for pixels, count in work.fine.items():
        grid = point.grid(point.bandwidth, pixels, point.short_side)
        fine = [members.solve(point.spectrum, grid, point.load, seed) for seed in seeds[:count]]
        done = [completed(m.stress, grid, pixels) for m in fine]
        result[f"fine{pixels}"] = np.array([values for values, _ in done])
        result[f"doubt{pixels}"] = np.array([doubt for _, doubt in done])
        result[f"area{pixels}"] = np.array([m.corrected for m in fine])
        result[f"bands{pixels}"] = np.array([bands(m.stress, grid) for m in fine])
    return result


def full_contact(point: Point, grid: rs.Grid) -> Any:
    """Return the variance of the stress in full contact by bin: what any weight W multiplies."""
    return (radial(grid).wavenumber / 2) ** 2 * members.roughness(point.spectrum, grid)


def bands(stress: Any, grid: rs.Grid) -> Any:
    """Return the sum of a radial table in each band of EDGES."""
    place = np.digitize(radial(grid).wavenumber, EDGES)
    return np.bincount(place, stress, minlength=EDGES.size + 1)[1:-1]


def completed(stress: Any, grid: rs.Grid, pixels: int) -> tuple[Any, Any]:
    """Return functionals with the modes above CUT of Nyquist replaced by a tail q^-4, and what is uncertain of them."""
    q = radial(grid).wavenumber
    cut = CUT * grid.nyquist
    band = (q > 0.85 * cut) & (q <= cut)
    area = pi * cut**2 * (1 - 0.85**2)  # of the ring in the plane of q
    level = float((stress * q**4)[band].sum()) / area  # |sigma_q|^2 q^4 as a density in that plane
    share, doubt = TAIL[pixels]
    nodes, weights = np.polynomial.legendre.leggauss(200)
    t = 0.5 * (nodes + 1)
    tail_q = cut / t**4  # dq = 4 cut t^-5 dt: reaches far beyond every scale, smoothly for q^-1/2 integrands too
    density = 2 * pi * tail_q * level * tail_q**-4 * (0.5 * weights * 4 * cut * t**-5)
    beyond = density @ kernel_matrix(tail_q)
    kept = np.where(q <= cut, stress, 0.0) @ members.kernels(grid)
    return kept + share * beyond, doubt * beyond


def reduced(work: Effort, count: int) -> Effort:
    """Return an effort of at most `count` members, for a first look."""
    return Effort(min(work.coarse, 4 * count), min(work.main, count), {8: 2})
