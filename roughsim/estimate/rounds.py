"""Rounds of a run: the number of members of each level, as a pure function of the members of the rounds before.

A round sets the number of members of each level. When all of them exist, `judge` ends the run or sets the next round
from these members alone. So the rounds replayed from the files of a run have the same counts for any order of the
members and any number of processes.
"""

from collections.abc import Callable, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from roughsim.estimate.cell_size import SIZE_SHARE, SYSTEMATIC
from roughsim.estimate.errors import quantile, spread_of
from roughsim.estimate.mean import Mean
from roughsim.grid import Array
from roughsim.scene.numerics import Numerics
from roughsim.table import Estimate

# members in the first round, of the lowest level and of others: fewer show too little scatter. A level that is added
# later begins with the fewest that show any: six took 1.4 and 1.5 times as long on steels with four levels and more
FIRST = 12
FIRST_STEP = 6
FIRST_ADDED = 2
_OF_LEVELS = "bandwidth", "last step", "pixel"  # errors that a higher level lowers
WORK_SECONDS = 5e-9  # s of CPU time over the `work` of a member, on one core of a server of 2020
MEMBER = 1.5e6  # `work` of a member on any grid, 8 ms: handing out, file, reading, and what a small solve takes
TARGET = {"flash_temperature": 0.01}  # for the choice of levels in a run without a target
Counts = tuple[int, ...]  # members of each level, by its number
Totals = Callable[[str, str, Counts], tuple[Mean, Estimate]]  # by observable, column and counts


class Verdict(NamedTuple):
    """Verdict on a run after a round: targets met or not, and the next round."""

    met: bool  # whether the targets are met
    next: Counts | None  # the next round; None: the run has ended
    needed: Counts  # estimated members of each level at the end of the run
    why: str  # reason of the end, or the largest part of the error
    errors: dict[
        str, float
    ]  # relative total error, 95 %, of each target at the worst speed, of the known parts
    unknown: tuple[
        tuple[str, str], ...
    ] = ()  # targets with unknown parts of their errors, and these parts


class Rounds(NamedTuple):
    """The state of a run: `counts` of the last complete round, or of the members of the first."""

    counts: Counts
    number: int  # of the round that `wanted` is
    verdict: Verdict  # on `counts`; it asks for the first round until that is complete

    @property
    def wanted(self) -> Counts:
        """Members of the round at work, or of the last one."""
        return self.verdict.next or self.counts

    @property
    def finished(self) -> bool:
        """Whether no round follows."""
        return self.verdict.next is None

    @property
    def met(self) -> bool:
        """Whether the targets are met."""
        return self.verdict.met


def replay(
    numerics: Numerics, most: int, available: Sequence[int], judged: Callable[[Counts], Verdict]
) -> Rounds:
    """Replay the rounds whose members exist; `available` counts the members of each level without a gap."""
    wanted = first_counts(numerics, most)
    number = 0
    counts = tuple(min(pair) for pair in zip(wanted, available, strict=True))
    verdict = Verdict(False, wanted, wanted, "", {})
    growing = any(level.first is None for level in numerics.levels)
    whole = Verdict(False, None, wanted, "all of the map is there", {})
    while counts == wanted:
        verdict = judged(wanted) if growing else whole
        if verdict.next is None:
            break
        wanted = verdict.next
        number = number + 1
        if any(there < asked for there, asked in zip(available, wanted, strict=True)):
            break
        counts = wanted
    return Rounds(counts, number, verdict)


def first_counts(numerics: Numerics, most: int) -> Counts:
    """Return the first round: of each column the lowest level, the step above it and its refined level.

    Levels with a number of realizations of their own have all of them.
    """
    counts = [min(level.first or most, most) for level in numerics.levels]
    for column in numerics.columns:
        lowest, *steps = numerics.coarse_levels(column)
        begun = dict.fromkeys((*steps[:1], numerics.refined(lowest)), FIRST_STEP) | {lowest: FIRST}
        for level in numerics.of_column(column):
            if numerics.levels[level].first is None:
                counts[level] = min(begun.get(level, 0), most)
    return tuple(counts)


def judge(
    numerics: Numerics, until: dict[str, float], most: int, counts: Counts, totals: Totals
) -> Verdict:
    """Return whether the members of a round meet the targets, and the round that follows if not.

    Parameters
    ----------
    numerics : Numerics
        Numerics with the levels of `counts`.
    until : dict of str to float
        Relative total 95 % error of each named observable, at the worst speed, in the main column. Empty: the run ends
        with `most` members of its lowest level.
    most : int
        Members that a level may have.
    counts : tuple of int
        Existing members of each level.
    totals : callable
        Returns values and estimate of an observable and a column from these counts.
    """
    main = numerics.columns[-1]
    needed = list(counts)
    following = list(counts)
    of_main: dict[str, Estimate] = {}
    level_follows = False  # in the main column
    for column in numerics.columns:
        for name, goal in (until or TARGET).items():
            values, found = totals(name, column, counts)
            wanted, added = _wishes(numerics, column, counts, values, found, goal)
            if column == main:
                of_main[name] = found
                level_follows |= added is not None
            if not until:  # all levels grow until the lowest has `most`
                lowest = numerics.coarse_levels(column)[0]
                times = most / max(wanted[lowest], 1)
                wanted = {
                    level: max(ceil(times * count), counts[level])
                    for level, count in wanted.items()
                }
                wanted[lowest] = most  # also without scatter
            for level, count in wanted.items():
                needed[level] = max(needed[level], min(count, most))
                following[level] = max(following[level], min(needed[level], 2 * counts[level]))
            if added is not None:
                first = min(FIRST_ADDED, most)
                needed[added] = following[added] = max(following[added], first)
    lowest_of_main = numerics.coarse_levels(main)[0]
    for column in numerics.columns[
        :-1
    ]:  # its lowest level has at most as many surfaces as the main column's
        lowest = numerics.coarse_levels(column)[0]
        following[lowest] = max(min(following[lowest], following[lowest_of_main]), counts[lowest])
    errors, largest, unknown = _standing(of_main, until)
    small = bool(until) and not largest
    if small and not unknown:
        return Verdict(True, None, counts, "the targets are met", errors)
    if (small and not level_follows) or tuple(following) == counts:
        return Verdict(
            False, None, counts, _ended(until, most, counts, largest, unknown), errors, unknown
        )
    return Verdict(False, tuple(following), tuple(needed), largest, errors, unknown)


def _standing(
    found: dict[str, Estimate], until: dict[str, float]
) -> tuple[dict[str, float], str, tuple[tuple[str, str], ...]]:
    """Return the known error of each target at its worst speed, the largest part of one above, and unknown parts.

    Scatter that is unknown, as too few realizations show it, is above.
    """
    errors = dict[str, float]()
    largest = ""
    for name, goal in until.items():
        mean = found[name].mean
        parts = _relative_parts(found[name])
        total = np.linalg.norm([*parts.values()], axis=0)
        total = np.where(
            np.isfinite(mean), total, np.inf
        )  # a mean that is not finite meets no target
        errors[name] = float(total.max())
        if errors[name] > goal:
            worst = int(np.argmax(total))
            largest = max(parts, key=lambda part: parts[part].flat[worst])
        elif "statistical" in found[name].unknown:
            largest = "statistical"
    return errors, largest, tuple((name, part) for name in until for part in found[name].unknown)


def _wishes(
    numerics: Numerics, column: str, counts: Counts, values: Mean, found: Estimate, goal: float
) -> tuple[dict[int, int], int | None]:
    """Return the members of each level that a relative total error `goal` wants, and a level to add, if any."""
    parts = _relative_parts(found)
    of_levels = np.linalg.norm([part for name, part in parts.items() if name in _OF_LEVELS], axis=0)
    systematic = np.linalg.norm(
        [part for name, part in parts.items() if name != "statistical"], axis=0
    )
    others = systematic**2 - of_levels**2
    # where the others put the goal out of reach, those by levels are lowered as far as it asks of them alone
    too_large = of_levels**2 > SYSTEMATIC * np.where(others < goal**2, goal**2 - others, goal**2)
    added = _next_level(numerics, column, counts, _relative_parts(found, unknown=np.inf), too_large)
    left = goal**2 - (
        systematic**2 if added is None else others
    )  # the added level may end the errors by levels
    left = np.maximum(
        left, SIZE_SHARE * np.maximum(systematic, goal) ** 2
    )  # as much as for the size
    return _allocation(numerics, column, values, found, counts, np.sqrt(left)), added


def _relative_parts(found: Estimate, unknown: float = 0.0) -> dict[str, Array]:
    """Return the parts of the error of an estimate relative to its mean; zero for a mean of zero, or none."""
    has_error = np.isfinite(found.mean) & (found.mean != 0.0)
    with np.errstate(all="ignore"):
        parts = {name: np.abs(part / found.mean) for name, part in found.budget.items()}
    return {
        name: np.where(has_error, np.nan_to_num(part, nan=unknown, posinf=np.inf), 0.0)
        for name, part in parts.items()
    }


def _next_level(
    numerics: Numerics, column: str, counts: Counts, parts: dict[str, Array], too_large: Array
) -> int | None:
    """Return the level that lowers the larger of the errors by q_c and by the pixel, at speeds with too large ones.

    Unknown ones are infinite, and too large.
    """
    too_large = too_large | np.isinf(parts["bandwidth"]) | np.isinf(parts["pixel"])
    if not np.any(too_large):
        return None
    levels = numerics.levels
    coarse = numerics.coarse_levels(column)
    used = [level for level in coarse if counts[level]]
    next_coarse = coarse[len(used)] if len(used) < len(coarse) else None
    highest = levels[used[-1]].q_max
    refined = [
        i for i in numerics.of_column(column) if i not in coarse and levels[i].q_max <= highest
    ]
    shown = [
        i for i in refined if levels[i].q_max == levels[refined[-1]].q_max
    ]  # the highest ones count
    next_refined = next((level for level in shown if not counts[level]), None)
    bandwidth = np.hypot(parts["bandwidth"], parts.get("last step", 0.0))
    by_cut_off = np.max(bandwidth[too_large]) >= np.max(parts["pixel"][too_large])
    choices = (next_coarse, next_refined) if by_cut_off else (next_refined, next_coarse)
    return next((level for level in choices if level is not None), None)


def _allocation(
    numerics: Numerics, column: str, values: Mean, found: Estimate, counts: Counts, goal: Array
) -> dict[int, int]:
    """Return the members by level that reach the relative statistical error `goal`, (speeds,), with the least work.

    N_l = √(V_l/C_l) Σ √(V_k C_k) z²/goal², at the speed with the largest N_l; V_l is the variance of a member, C_l its
    work. z is the quantile for the expected degrees of freedom; if it adds no member, for the present ones. Unknown
    scatter takes twice the members of the lowest level to show it.
    """
    levels = {
        numerics.stream(level): level for level in numerics.of_column(column) if counts[level]
    }
    _, freedom = spread_of(values)
    with np.errstate(all="ignore"):
        variances = {
            levels[stream]: part * len(values.influence[stream]) / values.value**2
            for stream, part in values.variance.items()
        }
        growth = (
            np.maximum(np.nan_to_num(np.abs(found.half_width / found.mean) / goal, posinf=1.0), 1.0)
            ** 2
        )
    works = {level: work(numerics, level) for level in variances}
    total = sum(np.sqrt(variances[level] * works[level]) for level in variances)
    result = dict.fromkeys(variances, 0)
    for z in quantile(freedom * growth), quantile(freedom):
        for level, variance in variances.items():
            with np.errstate(all="ignore"):
                wanted = np.sqrt(variance / works[level]) * total * (z / goal) ** 2
            wanted = np.where(
                found.mean == 0.0, 0.0, np.nan_to_num(wanted, nan=0.0, posinf=2.0 * counts[level])
            )
            result[level] = min(ceil(float(wanted.max())), 10**9)
        if any(result[level] > counts[level] for level in result):
            break
    if "statistical" in found.unknown:
        lowest = numerics.coarse_levels(column)[0]
        result[lowest] = max(result[lowest], 2 * counts[lowest])
    return result


def work(numerics: Numerics, level: int) -> float:
    """Return the modelled cost of a member: a constant, and for each solve points·√(points per side)."""
    grids = [
        numerics.grid(level),
        *([] if numerics.below(level) is None else [numerics.grid_below(level)]),
    ]
    return MEMBER + sum(float(grid.points**1.25) for grid in grids)


def _ended(
    until: dict[str, float],
    most: int,
    counts: Counts,
    largest: str,
    unknown: tuple[tuple[str, str], ...],
) -> str:
    """Return the reason of the end of a run that misses its targets."""
    if until and not largest:
        parts = " and ".join(dict.fromkeys(part for _, part in unknown))
        return f"out of reach: errors of {parts} are unknown, and no level is left that shows them"
    if not until or max(counts) >= most:
        return "all realizations are there"
    return f"out of reach: {largest} errors are too large, and no level is left that lowers them"
