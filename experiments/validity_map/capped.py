"""Hardness-capped points of the map: capped contact, elastic contact on C_sm, areas by magnification, worn surface.

A point is sigma_0/sigma_P and how far the roughness must be seen for 1 % of the contact to stay elastic, q_y/q_r, with
H, the plateau and the low exponent of C(q). Units: E* = 1, q_r = 1, so that a speed is the Peclet number v/(D q_r).
Capped contact is solved on a ladder of cut-offs q_c, an octave apart, on shared random streams: many members on the
coarse rungs, few on the fine ones. The limit of the ladder is taken in tables.py. It has two pixels per shortest wave:
its limit is that of a ladder with four, and the pixels buy an octave more of roughness instead. Elastic contact on C_sm
goes up to 1.5 q_y at 8 pixels, or 16.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Any

import numpy as np
from scipy.optimize import brentq

import roughsim as rs
from roughsim.surface.spectrum import TruncatedSpectrum
from theory import persson, plasticity
from validity_map import members

LOWEST, PIXELS = 4.0, 2.0  # q_c/q_y of the first rung, and pixels per shortest wave of all
DEPTHS = (4.0, 8.0, 16.0, 32.0, 64.0)  # q_max/q_y at which the map has C(q) end, beside infinity
FINER = {4.0: (4, 8), 8.0: (4, 8), 16.0: (4,)}  # pixels per shortest wave that show what two leave out there
WORN = 8.0  # q_c/q_y of the deformed surfaces
MAGNIFICATIONS = (0.25, 0.5, 1.0, 2.0, 4.0)  # q_c/q_y at which the areas are compared
SMOOTHED = 1024  # members on C_sm under light loads: they are small, and scatter most
END = 512.0  # q_1/q_y of the whole spectrum: C_sm has vanished long before


@dataclass(frozen=True)
class CappedPoint:
    """Where on the capped map."""

    share: float
    yields: float
    hurst: float = 0.8
    plateau: float = 2.0
    low_exponent: float = 0.0
    seed: int = 1
    label: str = ""

    @property
    def name(self) -> str:
        """Name of its file."""
        where = f"s{self.share:.4g}-y{self.yields:.4g}-H{self.hurst:g}-k{self.plateau:.4g}"
        return f"capped-{where}-m{self.low_exponent:g}-s{self.seed}{self.label}"

    @cached_property
    def spectrum(self) -> rs.SelfAffineSpectrum:
        """C(q) with rms slope 1 and q_r = 1, far beyond q_y."""
        return members.spectrum_of(self.hurst, self.plateau, END * self.yields, self.low_exponent)

    @cached_property
    def hardness(self) -> float:
        """sigma_P in units of E*, from the g = G/sigma_P^2 at which 1 % of the contact is elastic."""

        def excess(log_g: float) -> float:
            _, elastic, plastic = plasticity.area_fractions(np.exp(log_g), self.share, 1.0)
            return float(elastic / (elastic + plastic)) - 0.01

        g = np.exp(brentq(excess, np.log(1e-6), np.log(10.0)))
        variance = float(persson.half_variance(self.yields, self.spectrum, effective_modulus=1.0))
        return sqrt(variance / g)

    @property
    def pressures(self) -> dict[str, float]:
        """What theory.plasticity asks for."""
        load = self.share * self.hardness
        return {"effective_modulus": 1.0, "nominal_pressure": load, "penetration_hardness": self.hardness}

    @cached_property
    def smoothed(self) -> Any:
        """C_sm(q)."""
        return plasticity.smoothed_spectrum(self.spectrum, **self.pressures)

    @property
    def periods(self) -> float:
        """Waves of q_r along a side."""
        return max(8.0, 4.0 * self.plateau)

    def grid(self, q_max: float, pixels: float) -> rs.Grid:
        """Return the grid with at least so many pixels per shortest wave."""
        least = self.periods * pixels * q_max
        points = min(n for n in _fast(least) if n >= least)
        return rs.Grid((points, points), (self.periods * 2 * pi,) * 2)


def steels() -> list[CappedPoint]:
    """Return the bundled steel scenes as points of the capped map."""
    return [of_scene(rs.load_scene(name), name) for name in ("steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa")]


def of_scene(scene: rs.Scene, label: str = "") -> CappedPoint:
    """Return where a capped scene with a self-affine surface lies on the map."""
    surface = scene.surface
    load = scene.sliding.nominal_pressure
    yields = plasticity.yield_wavenumber(
        scene.spectrum,
        effective_modulus=scene.effective_modulus,
        nominal_pressure=load,
        penetration_hardness=scene.penetration_hardness,
    )
    share, roll_off = load / scene.penetration_hardness, surface.q_roll_off
    place = (share, yields / roll_off, surface.hurst, roll_off / surface.q_min, surface.roll_off_exponent or 0.0)
    return CappedPoint(*place, label=label)


def _fast(least: float) -> list[int]:
    return sorted(
        2**a * 3**b * 5**c
        for a in range(3, 14)
        for b in range(3)
        for c in range(2)
        if 0.9 * least <= 2**a * 3**b * 5**c <= 4 * least + 64
    )


def quiet(point: CappedPoint) -> float:
    """Return the share of members that suffices: a few yielded spots scatter most; large cells average themselves."""
    if point.periods > 16.0:
        return 0.25
    if point.hurst < 0.5:
        return 1.0 if point.share < 0.05 else 0.4
    return 0.6 if point.share < 0.05 else 0.24 if point.share < 0.2 else 0.15  # little lies beyond the ladder


def ladder(point: CappedPoint) -> dict[float, int]:
    """Return how many members each cut-off q_c/q_y has: grids up to 2048, or 4096 where T_flash falls most slowly."""
    most = 4200 if point.hurst < 0.5 and point.share < 0.05 else 3300
    result, factor = {}, LOWEST
    while (points := point.grid(factor * point.yields, PIXELS).shape[0]) <= most:
        result[factor] = max(round(min(256.0, 256 * (256 / points) ** 1.25) * quiet(point)), 6)
        factor *= 2.0
    return result


def measure(point: CappedPoint, rungs: dict[float, int] | None = None) -> dict[str, Any]:
    """Solve all members of a point and return functionals, areas, and the spectra of the deformed surfaces."""
    toy = rungs is not None
    rungs = ladder(point) if rungs is None else rungs
    load, y = point.pressures["nominal_pressure"], point.yields
    count = 16 if toy else max(round(SMOOTHED * quiet(point)), 256)
    seeds = [np.random.SeedSequence(point.seed, spawn_key=(7, k)) for k in range(max(count, *rungs.values()))]
    cut = TruncatedSpectrum(point.smoothed, 1.5 * y)
    grid = point.grid(1.5 * y, 16 if point.periods * y <= 8.0 else 8)  # larger cells hold more of the edges anyway
    smoothed = [members.solve(cut, grid, load, seed) for seed in seeds[:count]]
    result: dict[str, Any] = {"smoothed": np.array([m.functionals for m in smoothed])}
    for factor, number in rungs.items():
        solved = [_capped(point, factor * y, PIXELS, seed).functionals for seed in seeds[:number]]
        result[f"capped{factor:g}"] = np.array(solved)
    few = seeds[: 2 if toy else max(round(8 * quiet(point)), 2)]
    result |= finer(point, 2 if toy else 8)
    worn = [_deformed(point, _capped(point, WORN * y, 4, seed), WORN * y) for seed in few]
    for name in worn[0]:
        result[name] = np.array([entry[name] for entry in worn])
    return result | _areas(point, few)


def finer(point: CappedPoint, count: int) -> dict[str, Any]:
    """Solve the first members of the low rungs on finer grids as well: C(q) may end there."""
    seeds = [np.random.SeedSequence(point.seed, spawn_key=(7, k)) for k in range(count)]
    return {
        f"finer{pixels}-{depth:g}": np.array(
            [_capped(point, depth * point.yields, pixels, s).functionals for s in seeds]
        )
        for depth, many in FINER.items()
        for pixels in many
    }


def finite(point: CappedPoint) -> dict[str, Any]:
    """Measure only what a C(q) that ends at DEPTHS needs."""
    result, most = {}, 2200
    for depth in DEPTHS:
        if (side := point.grid(depth * point.yields, PIXELS).shape[0]) <= most:
            count = max(round(min(256.0, 256 * (256 / side) ** 1.25) * quiet(point)), 6 if side < 2000 else 4)
            seeds = [np.random.SeedSequence(point.seed, spawn_key=(7, k)) for k in range(count)]
            solved = [_capped(point, depth * point.yields, PIXELS, seed).functionals for seed in seeds]
            result[f"capped{depth:g}"] = np.array(solved)
    return result | finer(point, 4 if point.periods > 16.0 else 8)


@dataclass(frozen=True)
class Capped:
    """A capped member: functionals, and areas (raw, corrected) of contact and of its yielded part."""

    functionals: Any
    areas: tuple[float, float, float, float]
    heights: Any
    contact: Any


def _capped(point: CappedPoint, q_max: float, pixels: float, seed: Any) -> Capped:
    grid = point.grid(q_max, pixels)
    heights = rs.synthesize(point.spectrum.truncated(q_max=q_max), grid, np.random.default_rng(seed))
    solid = rs.Solid(1.0, point.hardness)
    contact = rs.solve_contact(
        heights, grid, solid, nominal_pressure=point.pressures["nominal_pressure"], tolerance=1e-4
    )
    stress = members.stress_table(contact.pressure, grid)
    corrected, yielded = rs.corrected_fractions(contact.pressure, point.hardness)
    areas = (contact.contact_fraction, corrected, contact.plastic_fraction, yielded)
    return Capped(stress @ members.kernels(grid), areas, heights, contact)


def _areas(point: CappedPoint, seeds: list[Any]) -> dict[str, Any]:
    """Return areas at each magnification at 4 and 8 pixels per shortest wave: shape (magnifications, 2, members, 4)."""
    values = [
        [[_capped(point, factor * point.yields, pixels, seed).areas for seed in seeds] for pixels in (4, 8)]
        for factor in MAGNIFICATIONS
        if factor * point.yields > 1.5 / point.plateau
    ]
    return {"areas": np.array(values)}


def _deformed(point: CappedPoint, member: Capped, q_max: float) -> dict[str, Any]:
    """Return the spectrum of the plastically deformed surface over that of the original, and the error of a reload.

    The deformed surface is the original less its overlap with the flat where the pressure is the hardness.
    """
    grid, contact = point.grid(q_max, 4), member.contact
    gap = contact.displacement - member.heights  # up to a constant
    touching = (contact.pressure > 0.0) & (contact.pressure < point.hardness)
    level = float(gap[touching].mean()) if touching.any() else float(gap[contact.pressure == 0.0].min())
    overlap = np.where(contact.pressure >= point.hardness, np.maximum(level - gap, 0.0), 0.0)
    worn = member.heights - overlap
    load = point.pressures["nominal_pressure"]
    again = rs.solve_contact(worn, grid, rs.Solid(1.0), nominal_pressure=load, tolerance=1e-4)
    difference = float(np.linalg.norm(again.pressure - contact.pressure) / np.linalg.norm(contact.pressure))
    edges = np.geomspace(1.0 / point.plateau, q_max, 25)
    place = np.digitize(members.radial(grid).wavenumber, edges)
    before, after = (
        np.bincount(place, members.stress_table(surface, grid), minlength=26)[1:-1]
        for surface in (member.heights, worn)
    )
    with np.errstate(invalid="ignore"):
        ratio = after / before
    return {"psd_wavenumber": np.sqrt(edges[1:] * edges[:-1]), "psd_ratio": ratio, "reload": np.array(difference)}
