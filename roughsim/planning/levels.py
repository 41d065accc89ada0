"""Which levels a scene gets: cut-offs that double, and their grids, each with its reason.

The levels of a column go from a cheap grid to the end of its C(q), or to the largest grid of a plan. Each has a refined
one with half the pixel, the end of C(q) two, if there is a grid for it. All are candidates: a run solves those that its
target needs. Those that do not fit into memory are left out, but for the lowest of a column.

- Capped contact is followed far beyond the yield wavenumber q_y: its T_flash falls as a power of the cut-off.
- Contact on the smoothed spectrum C_sm ends a little above q_y.
"""

from functools import partial
from math import ceil, floor, hypot, log2, pi, prod, sqrt
from typing import Final, Literal, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.cell_size import (
    SYSTEMATIC,
    choose_lengths,
    first_within,
    parts_of,
    size_error,
)
from roughsim.estimate.rounds import TARGET
from roughsim.machine import BYTES_PER_POINT, SHARE, available_memory, in_words
from roughsim.scene import Scene
from roughsim.scene.numerics import Column, Level

Lengths = tuple[float, float]  # of the cell, m

# per shortest wave of a level; its refined level has twice as many. 4 took 1.2 and 1.5 times as long on two sets of
# scenes
PIXELS = 3
SIDE = 4096  # points per side of the largest grid
# points per side of the lowest level, within a factor of √2, for a target of 1 % or less, and the power of a looser one
# with which they fall: of 128 to 724 points these took least time, or next to least, on ten scenes. 64 took 1.4
# to 1.7 times as long on three
BASE_SIDE, _BASE_POWER, _LEAST_BASE = 384, 1 / 3, 128
# bandwidth error over the change beyond the highest cut-off by theory: .26 to .46 in eight runs of five elastic scenes
_LEFT = 0.3
_SMOOTHED_TOP = 1.5  # q_y: the end of C_sm
_PART: Final[dict[int, Literal["half", "quarter"] | None]] = {1: None, 2: "half", 4: "quarter"}


class PlannedLevel(NamedTuple):
    """A level, and why it is there."""

    level: Level
    reason: str


class _Grids(NamedTuple):
    """The grids of a column in a cell with these sides, m; higher levels may have 1/`parts` of the sides."""

    column: Column
    lengths: Lengths
    parts: int
    side: int  # the most points per side
    base: float  # about the points per side of the lowest level

    def points(self, q_max: float) -> float:
        """Return the points along the longer side of the cell at a cut-off, rad/m."""
        return PIXELS * q_max * max(self.lengths) / (2 * pi)

    @property
    def highest(self) -> float:
        """The highest cut-off that a grid holds, rad/m."""
        return self.parts * self.side / self.points(1.0)

    def level(self, q_max: float, *, pixels: int = PIXELS, lowest: bool = False) -> Level | None:
        """Return the level of a cut-off, the lowest in the whole cell; None if its grid is too large.

        Its points divide by the parts of all levels, as those above it are solved with its pixel, too. In a part of
        the cell are at least half of `base`.
        """
        x, y = (
            self.parts * fast_size(pixels * q_max * side / (2 * pi) / self.parts)
            for side in self.lengths
        )
        small = (n for n in (4, 2) if n <= self.parts and max(x, y) >= n * self.base / 2)
        parts = 1 if lowest else next(small, 1)
        too_large = max(x, y) > parts * self.side
        return (
            None if too_large else Level(self.column, (x // parts, y // parts), q_max, _PART[parts])
        )


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    least = max(8, ceil(0.98 * points))
    return min(k << a for a in range(1, least.bit_length()) for k in (4, 5, 6) if k << a >= least)


def target_of(scene: Scene) -> float:
    """Return the relative total error of T_flash that a scene is planned for."""
    return (TARGET | dict(scene.ensemble.until))["flash_temperature"]


def cell_of(scene: Scene) -> tuple[Lengths, str]:
    """Return the sides of the cell that is planned for a scene as it is computed, m, and the reason."""
    return choose_lengths(
        scene, target_of(scene), partial(elastic_error, scene) if scene.elastic else None
    )


def elastic_error(scene: Scene, lengths: Lengths, parts: int) -> float:
    """Return the relative error of T_flash in elastic contact to be expected from its cell and its highest cut-off.

    Corrections are in a cell of 1/`parts` of the sides, m. Beyond the cut-off of the largest grid, which falls as the
    cell grows, contact follows the theory. The fastest speed counts: there short waves add most.
    """
    grids = _Grids("elastic", lengths, parts, SIDE, BASE_SIDE)
    top = min(grids.highest, scene.spectrum.breaks[-1])
    name, up_to_top = "flash_temperature", scene.spectrum.truncated(q_max=top)
    below = prediction.over_speed(scene, np.array(scene.speeds), up_to_top, names=(name,))[
        name
    ].max()
    whole = prediction.predictions(scene)[name].max()
    beyond = (whole - below) / (whole or 1.0)  # no heat at rest
    return hypot(size_error(scene, lengths, parts=parts), _LEFT * beyond)


def levels_of(scene: Scene, lengths: Lengths, target: float) -> list[PlannedLevel]:
    """Return the levels of a scene in a cell of these sides, m, for a relative error, the smoothed column first."""
    band = scene.spectrum.breaks[0], scene.spectrum.breaks[-1]
    end = band[1]
    base = BASE_SIDE * min(TARGET["flash_temperature"] / target, 1.0) ** _BASE_POWER
    base = max(base, _LEAST_BASE)
    if scene.elastic:
        parts = first_within(
            sqrt(SYSTEMATIC) * target, {n: elastic_error(scene, lengths, n) for n in (4, 2, 1)}
        )
        return _cut_offs_up_to(_Grids("elastic", lengths, parts, SIDE, base), end, band)
    q_yield = prediction.yield_wavenumber(scene)
    smoothed = _Grids("smoothed", lengths, 1, SIDE // 2, base)
    if q_yield > smoothed.highest:  # contact at the cut-offs of all grids is next to elastic
        return [
            *_cut_offs_up_to(smoothed, end, band),
            *_cut_offs_up_to(smoothed._replace(column="capped"), end, band),
        ]
    smoothed = smoothed._replace(parts=parts_of(scene, lengths, target, "smoothed"))
    capped = _Grids("capped", lengths, parts_of(scene, lengths, target), SIDE, base)
    return [
        *_cut_offs_up_to(smoothed, min(_SMOOTHED_TOP * q_yield, end), band, q_yield),
        *_cut_offs_up_to(capped, end, band, q_yield),
    ]


def _cut_offs_up_to(
    grids: _Grids, end: float, band: tuple[float, float], q_yield: float = 0.0
) -> list[PlannedLevel]:
    """Return the levels of a column up to the end of its spectrum, each with its refined.

    Cut-offs are in rad/m. `band` has both ends of C(q), `q_yield` is q_y for a scene with a hardness. The lowest level
    holds an octave of C(q), if there is one: in a cell of very many waves it has more points.
    """
    q_min, q_max = band
    top = min(end, grids.highest)
    doublings = min(round(log2(grids.points(top) / grids.base)), floor(log2(top / q_min)) - 1)
    doublings = max(doublings, ceil(log2(grids.points(top) / grids.side)), 0)
    cuts = [top / 2 ** (doublings - k) for k in range(doublings + 1)]
    planned = []
    for k, cut in enumerate(cuts):
        level = grids.level(cut, lowest=k == 0)
        if level is None:
            break
        why = "twice the q_c: the change by shorter waves"
        if k == 0:
            why = f"{PIXELS} pixels per shortest wave: the lowest level, whose members are cheap"
        if q_yield:
            why = f"{cut / q_yield:.3g} q_y; {why}"
        if cut == end:
            why += "; all of C(q)" if end == q_max else "; beyond, C_sm is next to nothing"
        elif cut == top:
            why += f"; the largest grid of a plan, C(q) goes on to {q_max:.3g} rad/m"
        planned.append(PlannedLevel(level, why))
        finer = (2, 4) if cut == end else (2,)
        why = "half the pixel of the level before: the change by the pixel"
        for times in finer:
            refined = grids.level(cut, pixels=times * PIXELS)
            # the smallest grids may have more points than they need, and a refined one then no more
            if refined is not None and refined.resolved > planned[-1].level.resolved:
                planned.append(PlannedLevel(refined, why))
    return _that_fit(planned)


def _that_fit(planned: list[PlannedLevel]) -> list[PlannedLevel]:
    """Return the levels of a column without those that do not fit into memory, which the last reason says.

    The lowest level stays: without it there is no run.
    """
    memory, needs = available_memory(), [BYTES_PER_POINT * prod(one.level.shape) for one in planned]
    fit = [k == 0 or need <= SHARE * memory.amount for k, need in enumerate(needs)]
    if all(fit):
        return planned
    *lower, last = (one for one, fits in zip(planned, fit, strict=True) if fits)
    why = (
        f"{last.reason}; levels above are left out: the next would take {needs[fit.index(False)] / 1e9:.3g} GB, more "
        f"than {100 * SHARE:.0f} % of the {in_words(memory)}"
    )
    return [*lower, last._replace(reason=why)]
