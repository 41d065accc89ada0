"""`plan`: from a scene to the cheapest numerics that meet a target error, each choice with its reason.

`levels` chooses cut-offs and grids. This module chooses how many realizations there are, and for how many of them the
fine levels are solved. Numerics that the scene states are taken as they are.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import hypot, inf, isnan, sqrt
from typing import NamedTuple

from roughsim import prediction
from roughsim.errors import number
from roughsim.estimate.cell_size import choose_lengths, size_error_of_sum
from roughsim.estimate.errors import LEAST, LEAST_FINE, quantile
from roughsim.estimate.regression import CONTROLS, LEAST_FITTED
from roughsim.machine import PROCESS
from roughsim.planning.levels import Ladder, ladders_of
from roughsim.planning.march import march_reasons, with_march
from roughsim.planning.pilot import HALF_SCATTER, SCATTER_KNOWN, SOLVES, Lengths, Pilot, work
from roughsim.planning.realization import largest_member
from roughsim.planning.reasons import at_speeds, forecast_reasons, level_text, workers_reason
from roughsim.prediction.scans import scan_of_hottest
from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_REASONS, Forecast, Level, Numerics, Reason

TARGET = 0.01  # relative total error where neither the caller nor the scene states one
LEAST_SHARE = 0.1  # of the squared total error, kept for the statistical one however large the systematic errors are
# scatter of the first correction over that of the changes in the pilot, in capped contact × the pilot's over its own
# cut-off; at the hottest speed, and at that where they scatter most: 0.26 … 0.48 and 0.18 … 0.32 on the steels
CORRECTIONS, WIDEST_CORRECTIONS = 0.4, 0.25
MEMBER = 5e5  # `work` of what a member takes whatever its grid, a few milliseconds: handing out, file, reading
STRIDES = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512]  # powers of two, so that all fine levels share their realizations


def plan(scene: Scene, target_error: float | None = None) -> Numerics:
    """Choose the numerics of a scene by rule; keys of its [numerics] section are taken as they are.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    target_error : float, optional
        Relative total error of T_flash to aim at. Left out: the statistical error of T_flash that the scene's `until`
        asks for, or a total of 1 %. The reasons say at which statistical error to stop the run.

    Returns
    -------
    Numerics
        With `reasons`, one for each choice.

    Raises
    ------
    ValueError
        If `target_error` is not in (0, 1).
    ResolutionError
        If the machine has too little memory for the largest grid.
    """
    stop = None  # the statistical error that the scene itself stops at
    if target_error is None:
        stop = dict(scene.ensemble.until).get("flash_temperature")
        target_error = stop or TARGET
    if not 0.0 < number("target_error", target_error) < 1.0:
        raise ValueError(f"target_error = {target_error:.6g} must lie between 0 and 1; 0.01 is 1 %")
    lengths, reason = chosen_cell(scene, target_error, stop)
    reasons = [Reason("cell", f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm", reason)]
    if scene.numerics.levels is not None:
        numerics = Numerics(scene.numerics.levels, lengths)
        if not scene.elastic and "elastic" in numerics.columns:
            raise ValueError('column = "elastic" does not fit a scene with a hardness; use "smoothed" or "capped"')
        reasons.append(Reason("levels", level_text(numerics.levels), "given in the scene"))
    else:
        numerics = chosen_levels(scene, lengths, target_error, stop)
        reasons += numerics.reasons
    # the scene's own numerics replace the defaults
    stated = {key: getattr(scene.numerics, key) for key in DEFAULT_REASONS if getattr(scene.numerics, key) is not None}
    numerics = with_march(scene, replace(numerics, **stated))
    for key, reason in DEFAULT_REASONS.items():
        value = getattr(numerics, key)
        text = "L/2" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        reasons.append(Reason(key, text, "given in the scene" if key in stated else reason))
    averaged = "averaged over all sliding directions in closed form; drawn surfaces are isotropic"
    reasons.append(Reason("moments", "all speeds at once", averaged))
    if "conductivity" in scene.tables:
        text = f"{at_speeds(prediction.conduction(scene).conductivity)} W/(m K)"
        reasons.append(Reason("conductivity", text, "of the moving body at T₀ + 0.75 T_flash of the theory"))
    if "friction_coefficient" in scene.tables:
        text = at_speeds(prediction.friction_coefficient(scene))
        reasons.append(Reason("friction_coefficient", text, "at T₀ + T_flash of the theory, speed by speed"))
    member, why = largest_member(scene, numerics)
    workers = workers_reason(numerics, member, why)  # before the march is timed
    memory = Reason("memory", f"{(member + PROCESS) / 1e9:.2g} GB per worker", f"{member / 1e9:.2g} GB for {why}")
    return replace(numerics, reasons=(*reasons, *march_reasons(scene, numerics), workers, memory))


def chosen_cell(scene: Scene, target: float, stop: float | None) -> tuple[Lengths, str]:
    """Return the sides of the cell, m, and the reason: not twice those that suffice where that leaves more errors.

    On as many points cut-offs are half as high in it, which may leave more to the bandwidth than it takes off the size.
    """
    lengths, reason = choose_lengths(scene, target)
    shorter, why = choose_lengths(scene)
    if shorter == lengths or scene.numerics.levels is not None:
        return lengths, reason
    forecasts = (chosen_levels(scene, cell, target, stop).forecast for cell in (lengths, shorter))
    long, short = (forecast._replace(statistical=0.0).total for forecast in forecasts if forecast)
    if long <= max(short, target):
        return lengths, reason
    return shorter, f"{why}; one of twice the sides would leave larger errors in all, as grids reach half as far in it"


def chosen_levels(scene: Scene, lengths: Lengths, target: float, stop: float | None) -> Numerics:
    """Return levels and forecast with their reasons; `stop` is the statistical target, None if free."""
    ladders, seen = ladders_of(scene, lengths, target, lowest=stop is not None)  # higher ones leave more to the scatter
    most = scene.ensemble.max_realizations
    ways = []
    for ladder in ladders:
        in_whole = split_of(scene, lengths, ladder, seen, target, stop, in_part=False)
        in_part = split_of(scene, lengths, ladder, seen, target, stop, in_part=True) if ladder.correction else in_whole
        cheaper = in_part if ladder.only_part else min(in_whole, in_part, key=lambda split: split.cost)
        ways.append((cheaper, ladder, in_whole, in_part))
    chosen, ladder, in_whole, in_part = min(ways, key=lambda way: way[0].cost)
    size, goal, strides, needed = chosen.size, chosen.goal, chosen.strides, chosen.needed
    rungs, changes = ladder.divided(*strides, in_part=chosen.in_part), corrections(ladder, strides, chosen.change)
    levels, count = tuple(rung.level for rung in rungs), min(needed, most)
    statistical = half_width(count, seen.hot_scatter, changes)
    cpu_seconds = seen.pace * total_work(levels, count)
    forecast = Forecast(count, statistical, ladder.bandwidth, ladder.pixel, size, cpu_seconds)
    # the scatter of a few pilot solves is uncertain, and so is the count
    fewest, largest = (min(chosen.realizations(ladder, seen, times=f), most) for f in SCATTER_KNOWN)
    per_cent = f"{100 * goal:.3g}"
    why = (
        f"--until flash_temperature={per_cent}% stops once its statistical error (95 %) is {per_cent} % at every "
        f"speed; {LEAST} at least; levels marked 1 in k are solved for every k-th realization"
    )
    if count < needed:
        why += f"; max_realizations ends the run before, as that takes about {needed:.3g}"
    elif fewest < largest:
        why += f"; {fewest} to {largest}, as the scatter from {SOLVES} pilot solves is known within a factor 1.8"
    text, explanation = "none", "a cheap solve did not converge: the errors expected below are a guess"
    if seen.measured:
        text = f"scatter {100 * seen.scatter:.2g} %, step {100 * seen.step:.2g} %, pixel {100 * seen.pixel:.2g} %"
        explanation = (
            f"cheap solves up to q_c = {seen.q_max:.3g} rad/m: how much T_flash scatters from one realization to the "
            f"next ({100 * seen.raw_scatter:.2g} % before its regression on the peak volume of the surface), falls "
            "when q_c is doubled, and changes at half the pixel"
        )
    reasons = [
        *(Reason(rung.level.column, level_text((rung.level,)), rung.reason) for rung in rungs),
        *cell_reasons(ladder, chosen, in_whole, in_part),
        Reason("pilot", text, explanation),
        Reason("realizations", f"about {count}", why),
        *forecast_reasons(forecast, scan_of_hottest(scene), target if stop is None and chosen.excess > 1.0 else None),
    ]
    return Numerics(levels, lengths, forecast=forecast, reasons=tuple(reasons))


Strides = tuple[int, int]  # of the first correction of each column, and of those by finer levels


class Split(NamedTuple):
    """A way to share the work among levels, by the number of realizations that it needs.

    `goal` and `size` are relative errors: the statistical one to reach, and that of the cell. `change` and `widest` are
    the relative scatter of the first correction at the hottest speed, and at that where it scatters most. `excess` is
    the squared systematic error over what the target leaves of it, 1 at least.
    """

    in_part: bool
    strides: Strides
    goal: float
    size: float
    change: float
    widest: float
    excess: float = 1.0
    needed: int = 0
    work: float = 0.0

    @property
    def cost(self) -> float:
        """Its work; where the target is out of reach, as much more as the squared error is too large.

        Squared once more, as it needs so many fewer realizations for its own, larger goal.
        """
        return self.work * self.excess**2

    def realizations(self, ladder: Ladder, seen: Pilot, *, times: float = 1.0) -> int:
        """Return how many meet the goal, at the speed that scatters most and at the hottest one.

        Where the coarsest level scatters less, few fine realizations count with fewer degrees of freedom, and the
        interval may be wider. `times` multiplies all scatter.
        """
        speeds = {(seen.hot_scatter, self.change), (seen.scatter, self.widest)}
        return max(
            realizations_for(self.goal, times * scatter, corrections(ladder, self.strides, times * change))
            for scatter, change in speeds
        )


def split_of(
    scene: Scene, lengths: Lengths, ladder: Ladder, seen: Pilot, target: float, stop: float | None, *, in_part: bool
) -> Split:
    """Return the cheapest split with the corrections in the run's cell, or, with `in_part`, in a part of it.

    At least three realizations have the finest levels, unless fewer are computed.
    """
    from_part, parts = (ladder.correction, ladder.parts) if in_part else (0.0, 1)
    size = float(size_error_of_sum(scene, lengths, parts, "flash_temperature", "", from_part))
    # the statistical error may take the rest of the target that the systematic errors leave
    systematic = hypot(0.0 if isnan(ladder.bandwidth) else ladder.bandwidth, ladder.pixel, size)
    goal = statistical_target(target, systematic) if stop is None else stop
    factor, most = HALF_SCATTER ** (parts // 2) * ladder.fallen(seen), scene.ensemble.max_realizations
    change = factor * CORRECTIONS * seen.change_scatter
    widest = max(change, factor * WIDEST_CORRECTIONS * seen.widest_change_scatter)
    excess = max(systematic**2 / ((1.0 - LEAST_SHARE) * target**2), 1.0)
    splits = []
    for strides in ((every, seldom) for every in STRIDES for seldom in STRIDES if seldom >= every):
        split = Split(in_part, strides, goal, size, change, widest, excess)
        needed = split.realizations(ladder, seen)
        if strides == (1, 1) or (LEAST_FINE - 1) * strides[1] < min(needed, most):
            splits.append(
                split._replace(needed=needed, work=total_work(ladder.levels(*strides, in_part=in_part), needed))
            )
    return min(splits, key=lambda split: split.work)


def statistical_target(target: float, systematic: float) -> float:
    """Return the relative statistical error that a total of `target` leaves beside the systematic one.

    Where that leaves less than the least share, or nothing, the statistical error is that share of what both are then.
    """
    return sqrt(max(target**2 - systematic**2, LEAST_SHARE / (1.0 - LEAST_SHARE) * systematic**2))


def corrections(ladder: Ladder, strides: Strides, change: float) -> list[tuple[float, int]]:
    """Return scatter and stride of each correction of the last column, of which the first scatters by `change`."""
    column = ladder.rungs[-1].level.column
    rungs = [rung for rung in ladder.divided(*strides, in_part=False) if rung.level.column == column]
    return [(rung.scatter * change, rung.level.every) for rung in rungs if rung.scatter]


def cell_reasons(ladder: Ladder, chosen: Split, in_whole: Split, in_part: Split) -> list[Reason]:
    """Return in which cell the corrections are computed, and why; nothing where no part of the cell may serve."""
    if not ladder.correction:
        return []
    part = "half the cell" if ladder.parts == 2 else "a quarter of the cell"
    names, other = {True: part, False: "the run's cell"}, in_whole if chosen.in_part else in_part
    size = f"{100 * sqrt(max(in_part.size**2 - in_whole.size**2, 0.0)):.1g}"
    why = (
        f"takes {chosen.work / other.work:.2g} of the work that {names[other.in_part]} takes; {part} has the same "
        f"corrections within {size} % of T_flash, which is in the size error, and {ladder.parts:g} times their scatter"
    )
    return [Reason("corrections", f"in {names[chosen.in_part]}", why)]


def half_width(count: int, scatter: float, changes: Sequence[tuple[float, int]]) -> float:
    """Return the relative 95 % half-width of a mean after `count` realizations.

    `scatter` is the relative standard deviation that the regression leaves of the coarsest level. `changes` has that of
    each correction by finer levels, and its stride.
    """
    if count == 1:
        return inf  # one realization shows no scatter
    slopes = len(CONTROLS) if count >= LEAST_FITTED else 0
    most = count - 1.0 - slopes
    # what slopes fitted to the other rows add to the variance of a row, for normal numbers
    uncertain = slopes / max(most - 2.0, 1.0)
    parts = [((1.0 + uncertain) * scatter**2 / count, most)]
    for change, every in changes:
        fine = -(-count // every)
        parts.append((change**2 / fine, max(fine - 1, 1)))
    variance = sum(part for part, _ in parts)
    doubt = sum(part**2 / freedom for part, freedom in parts)  # Satterthwaite, as in the estimate
    freedom = min(variance**2 / doubt, most) if doubt > 0.0 else most
    return float(quantile(freedom)) * sqrt(variance)


def realizations_for(goal: float, scatter: float, changes: Sequence[tuple[float, int]]) -> int:
    """Return how many realizations bring the half-width down to the goal; above 50 in steps of 2 %."""
    # fewer do not suffice: an interval is wider than 1.96 standard errors, and three fine realizations are the least
    variance = scatter**2 + sum(change**2 * every * 2 / 3 for change, every in changes)
    count = max(LEAST, int((1.96 / goal) ** 2 * variance), *((LEAST_FINE - 1) * every + 1 for _, every in changes))
    while half_width(count, scatter, changes) > goal and count < 1_000_000_000:
        count += max(1, count // 50)
    return count


def total_work(levels: Iterable[Level], count: int) -> float:
    """Return the `work` of all members of so many realizations."""
    return sum((work(level.shape[0] * level.shape[1]) + MEMBER) * -(-count // level.every) for level in levels)
