"""`plan`: from a scene to its numerics by rule, each choice with its reason.

Nothing is solved: the cell, the levels and the cost follow from C(q), the load and the theory. How many members each
level gets is decided by the run itself, round by round. Numerics that the scene states are taken as they are.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import isnan, pi, sqrt

from roughsim import prediction
from roughsim.errors import number
from roughsim.estimate.cell_size import choose_lengths
from roughsim.machine import PROCESS
from roughsim.planning.levels import levels_of
from roughsim.planning.march import march_reasons, with_march
from roughsim.planning.realization import largest_member
from roughsim.planning.reasons import at_speeds, level_text, span, workers_reason
from roughsim.prediction.scans import scan_of_hottest
from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_REASONS, Numerics, Reason

TARGET = 0.01  # relative total error of T_flash where neither the caller nor the scene states one
# relative standard deviation of T_flash over the members of a lowest level, × longest waves per side × √(contact area
# of the theory there): the least and the largest of 20 scenes, elastic and capped, contact on .0005 … .25 of the area
SCATTER = 0.012, 0.046
LEAST_AREA = 1e-6  # of contact: below, no cell of a plan holds a spot
FIRST_MEMBERS = 6  # of each level that a run begins
MEMBER, POINT = 4e-3, 4e-9  # s of CPU time of a member, and of a solve over (points)^1.25 from 512² to 4096² points


def plan(scene: Scene, target_error: float | None = None) -> Numerics:
    """Choose the numerics of a scene by rule; keys of its [numerics] section are taken as they are.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    target_error : float, optional
        Relative total error of T_flash to aim at. Left out: that of the scene's `until`, or 1 %.

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
    target = dict(scene.ensemble.until).get("flash_temperature", TARGET) if target_error is None else target_error
    if not 0.0 < number("target_error", target) < 1.0:
        raise ValueError(f"target_error = {target:.6g} must lie between 0 and 1; 0.01 is 1 %")
    stated, scene = scene, prediction.computed(scene)
    reasons = []
    if scene != stated:
        why = "in theory next to nothing of the contact reaches it: the contact is elastic"
        reasons.append(Reason("hardness", f"{stated.penetration_hardness / 1e9:.3g} GPa left out", why))
    lengths, why = choose_lengths(scene, target)
    reasons.append(Reason("cell", f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm", why))
    if scene.numerics.levels is not None:
        levels = scene.numerics.levels
        reasons.append(Reason("levels", level_text(levels), "given in the scene"))
    else:
        rungs = levels_of(scene, lengths)
        levels = tuple(rung.level for rung in rungs)
        reasons += (Reason(rung.level.column, level_text((rung.level,)), rung.reason) for rung in rungs)
    keys = {key: getattr(scene.numerics, key) for key in DEFAULT_REASONS}
    keys = {key: value for key, value in keys.items() if value is not None}
    numerics = with_march(scene, Numerics(levels, lengths, **keys))
    if not scene.elastic and "elastic" in numerics.columns:
        raise ValueError('column = "elastic" does not fit a scene with a hardness; use "smoothed" or "capped"')
    reasons += heat_reasons(scene)
    for key, why in DEFAULT_REASONS.items():
        value = getattr(numerics, key)
        text = "L/2" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        reasons.append(Reason(key, text, "given in the scene" if key in keys else why))
    member, why = largest_member(scene, numerics)
    return replace(
        numerics,
        reasons=(
            *reasons,
            *march_reasons(scene, numerics),
            cost_reason(scene, numerics, target),
            workers_reason(numerics, member, why),
            Reason("memory", f"{(member + PROCESS) / 1e9:.2g} GB per worker", f"{member / 1e9:.2g} GB for {why}"),
        ),
    )


def heat_reasons(scene: Scene) -> Iterator[Reason]:
    """Yield over what moments are averaged, the constants that stand for tables, and the error of a measured C(q)."""
    averaged = "averaged over all sliding directions in closed form; drawn surfaces are isotropic"
    yield Reason("moments", "all speeds at once", averaged)
    if "conductivity" in scene.tables:
        text = f"{at_speeds(prediction.conduction(scene).conductivity)} W/(m K)"
        yield Reason("conductivity", text, "of the moving body at T₀ + 0.75 T_flash of the theory")
    if "friction_coefficient" in scene.tables:
        text = at_speeds(prediction.friction_coefficient(scene))
        yield Reason("friction_coefficient", text, "at T₀ + T_flash of the theory, speed by speed")
    scan = scan_of_hottest(scene)
    if scan is not None:
        text = "unknown" if isnan(scan) else f"{100 * scan:.2g} % of the highest T_flash"
        yield Reason("scan", text, "the error of the scan that C(q) was measured on; no member lowers it")


def cost_reason(scene: Scene, numerics: Numerics, target: float) -> Reason:
    """Return about how much CPU time a run takes to a relative total 95 % error of T_flash.

    At least the first round, and two cut-offs of the column that the target concerns; at most all of all columns.
    """
    ladders = [numerics.rungs(column) for column in numerics.columns]
    begun = {i for column in numerics.columns for i in numerics.of_column(column)[:3]}
    least, most = (FIRST_MEMBERS * sum(member_seconds(numerics, i) for i in some) for some in (begun, numerics.single))
    low = max(least, seconds_of(scene, numerics, ladders[-1][:2], target, SCATTER[0]))
    high = most + sum(seconds_of(scene, numerics, ladder, target, SCATTER[1]) for ladder in ladders)
    why = (
        f"to a total error of {100 * target:.3g} %, by how T_flash scattered on other scenes; the more of it where "
        "all levels are needed. After the first round `roughsim status` shows the time left, as it was measured"
    )
    return Reason("CPU time", f"{span(low)} to {span(high)}", why)


def seconds_of(scene: Scene, numerics: Numerics, rungs: Sequence[int], target: float, scatter: float) -> float:
    """Return the CPU time by which the scatter of levels falls to a relative error, s; `scatter` as in `SCATTER`.

    The least for independent levels: (2/error)² (Σ √(variance × time of a member))². The scatter of what a level
    corrects halves from one cut-off to the next.
    """
    lowest = numerics.levels[rungs[0]].q_max
    area = max(prediction.area_fractions(scene, lowest)["contact_fraction"], LEAST_AREA)
    waves = min(numerics.lengths) * scene.spectrum.breaks[0] / (2 * pi)
    scatters = [scatter / (waves * sqrt(area)) * numerics.levels[i].parts / 2.0**k for k, i in enumerate(rungs)]
    times = [member_seconds(numerics, i) for i in rungs]
    total = 2.0 / target * sum(each * sqrt(time) for each, time in zip(scatters, times, strict=True))
    members = 2.0 / target * total * scatters[0] / sqrt(times[0])  # of the lowest level
    return total**2 * min(scene.ensemble.max_realizations / members, 1.0)


def member_seconds(numerics: Numerics, level: int) -> float:
    """Return the CPU time of a member, s: of its own solve and of that at the level below."""
    grids = [numerics.grid(level)]
    if numerics.below(level) is not None:
        grids.append(numerics.grid_below(level))
    return MEMBER + POINT * float(sum(grid.points**1.25 for grid in grids))
