"""Which levels a scene gets: cut-offs that double, and their grids, each with its reason.

A column begins with a cheap level, and climbs to the end of its C(q), or to the largest grids of a plan. The lowest two
cut-offs have a partner with half the pixel, the end of C(q) two. All are candidates: a run solves those that its
target needs. The rules:

- Contact that yields needs no resolution of its own: the yield wavenumber q_y sets the scale, not q_max.
- Contact on the smoothed spectrum C_sm ends a little above q_y.
- Capped contact begins at 4 q_y and is followed far beyond: its T_flash falls as a power of the cut-off.
- Where no grid reaches q_y, both columns climb the same cut-offs, as elastic contact does.
"""

from math import ceil, isinf, log2, pi
from typing import Final, Literal, NamedTuple

from roughsim import prediction
from roughsim.estimate.cell_size import parts_of
from roughsim.scene import Scene
from roughsim.scene.numerics import Column, Level

Lengths = tuple[float, float]  # of the cell, m

PIXELS = 4  # per shortest wave of a level; its partner has twice as many
# points per side of the largest grids: of elastic contact, of capped contact, and of that in a part of the cell
ELASTIC_SIDE, CAPPED_SIDE, PART_SIDE = 2048, 4096, 6144
# points per side of the lowest level, at most, but half as many again at 4 q_y, and for cells that are long for C(q):
# on seven scenes 512 took least time, or next to least
BASE_SIDE = 512
PART_POINTS = 256  # per side of a level in a part of the cell, at least: of a smaller one the grid is not the cost
SMOOTHED_TOP, CAPPED_BASE = 1.5, 4.0  # q_y: the end of C_sm, and the lowest cut-off of capped contact
PART: Final[dict[int, Literal["half", "quarter"] | None]] = {1: None, 2: "half", 4: "quarter"}


class Rung(NamedTuple):
    """A level, and why it is there."""

    level: Level
    reason: str


class Grids(NamedTuple):
    """The grids of a column: sides of the run's cell, m, and the most points per side of its levels.

    Higher levels lie in a cell whose sides go at most `parts` times into those of the run's.
    """

    column: Column
    lengths: Lengths
    parts: int
    side: int
    part_side: int

    def level(self, q_max: float, pixels: int, parts: int) -> Level | None:
        """Return the level of a cut-off with so many pixels per shortest wave; None where it has too many points.

        Its points divide by the parts of all levels, as those above it are solved with its pixel, too.
        """
        x, y = (self.parts * fast_size(pixels * q_max * side / (2 * pi) / self.parts) for side in self.lengths)
        most = self.side if parts == 1 else self.part_side
        return None if max(x, y) > parts * most else Level(self.column, (x // parts, y // parts), q_max, PART[parts])

    def correction(self, q_max: float, pixels: int) -> Level | None:
        """Return the level that corrects at a cut-off, in the smallest cell that it may have with `PART_POINTS`."""
        points = pixels / PIXELS * self.side_of(q_max)
        parts = next((n for n in (4, 2) if n <= self.parts and points >= 0.98 * n * PART_POINTS), 1)
        return self.level(q_max, pixels, parts)

    def side_of(self, q_max: float) -> float:
        """Return the points per side of the run's cell at a cut-off, rad/m."""
        return PIXELS * q_max * max(self.lengths) / (2 * pi)

    def cut_off(self, side: float) -> float:
        """Return the cut-off of so many points per side of the run's cell, rad/m."""
        return side * 2 * pi / (PIXELS * max(self.lengths))

    @property
    def highest(self) -> float:
        """The highest cut-off that a level may have, rad/m."""
        return self.cut_off(max(self.side, self.parts * self.part_side * (self.parts > 1)))


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    least = max(8, ceil(0.98 * points))
    return min(k << a for a in range(1, least.bit_length()) for k in (4, 5, 6) if k << a >= least)


def levels_of(scene: Scene, lengths: Lengths) -> list[Rung]:
    """Return the levels of a scene in a cell of these sides, m, by column, the smoothed one first."""
    q_min, q_max = scene.spectrum.breaks[0], scene.spectrum.breaks[-1]
    parts = parts_of(scene, lengths)
    if scene.elastic:
        grids = Grids("elastic", lengths, parts, ELASTIC_SIDE, ELASTIC_SIDE)
        return climb(grids, base(grids, q_min, q_max), q_max, q_max)
    smoothed = Grids("smoothed", lengths, 1, ELASTIC_SIDE, ELASTIC_SIDE)
    q_yield = prediction.yield_wavenumber(scene)
    end = min(SMOOTHED_TOP * q_yield, q_max)
    if isinf(q_yield) or end > smoothed.highest:
        start = base(smoothed, q_min, q_max)
        columns: tuple[Column, ...] = "smoothed", "capped"
        return [rung for column in columns for rung in climb(smoothed._replace(column=column), start, q_max, q_max)]
    capped = Grids("capped", lengths, parts, CAPPED_SIDE, PART_SIDE)
    return [
        *climb(smoothed, base(smoothed, q_min, end), end, q_max, q_yield),
        *climb(capped, capped_base(capped, q_yield, q_max), q_max, q_max, q_yield),
    ]


def base(grids: Grids, q_min: float, end: float) -> float:
    """Return the lowest cut-off, rad/m, from which doubling leads to the end of C(q), or to the highest one.

    Its grid has at most `BASE_SIDE` points per side, but in a cell of more than 8 longest waves as many per wave.
    """
    top = min(end, grids.highest)
    side = max(BASE_SIDE, BASE_SIDE / 8 * max(grids.lengths) * q_min / (2 * pi))
    side = min(side, grids.side / 2)  # so that a grid is left that shows the pixel
    return float(top / 2 ** max(ceil(log2(grids.side_of(top) / (1.02 * side))), 0))


def capped_base(grids: Grids, q_yield: float, q_max: float) -> float:
    """Return the lowest cut-off of capped contact, rad/m, from which doubling leads to q_max, where a grid holds that.

    It is 4 q_y, or the nearest such one, doubled while its grid has at most `BASE_SIDE` points per side, and halved
    where that has more than half as many again.
    """
    lowest = CAPPED_BASE * q_yield
    if q_max <= grids.highest or q_max < lowest:
        lowest = q_max / 2 ** max(round(log2(q_max / lowest)), 0)
    while grids.side_of(2 * lowest) <= 1.02 * BASE_SIDE and 2 * lowest <= 1.02 * q_max:
        lowest *= 2
    return float(lowest / 2 ** max(ceil(log2(grids.side_of(lowest) / (1.02 * 1.5 * BASE_SIDE))), 0))


def climb(grids: Grids, lowest: float, end: float, q_max: float, q_yield: float = 0.0) -> list[Rung]:
    """Return the levels of a column from its lowest cut-off to the end of its spectrum, each with its partner.

    Cut-offs are in rad/m. `q_max` is the end of C(q), `q_yield` is q_y where that sets the scale.
    """
    count = 1 + int(log2(1.02 * min(end, grids.highest) / lowest))
    rungs = []
    for k in range(count):
        cut = end if k == count - 1 and lowest * 2**k > 0.98 * end else lowest * 2**k
        level = grids.correction(cut, PIXELS) if k else grids.level(cut, PIXELS, 1)
        if level is None:
            break
        rungs.append(Rung(level, reason_of(cut, k, end, q_max, q_yield, last=k == count - 1)))
        # a change by the pixel is carried to the end of C(q) from below, and seen best there
        finer = (2, 4) if cut == end else (2,) if k < 2 else ()
        partners = [grids.correction(cut, times * PIXELS) for times in finer]
        why = "half the pixel of the level before: what the pixel changes"
        rungs += (Rung(partner, why) for partner in partners if partner is not None)
    return rungs


def reason_of(cut: float, k: int, end: float, q_max: float, q_yield: float, *, last: bool) -> str:
    """Return why a column has its cut-off k, in words; arguments as of `climb`."""
    times = f"{cut / q_yield:.3g} q_y; " if q_yield else ""
    if k == 0:
        why = f"{times}{PIXELS} pixels per shortest wave: the lowest level, whose members are cheap"
    else:
        why = f"{times}twice the q_c: what shorter waves change"
    if cut == end == q_max:
        return f"{why}; all of C(q)"
    if cut == end:
        return f"{why}; beyond, C_sm is next to nothing"
    return f"{why}; the largest grid of a plan, C(q) goes on to {q_max:.3g} rad/m" if last else why
