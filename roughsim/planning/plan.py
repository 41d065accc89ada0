"""From a scene to its numerics: the cheapest grids and tolerances that meet the asked-for error, each with its reason.

`rungs` has the levels of a column, this module what they cost, how often they are solved, and what to expect.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from math import hypot, isfinite, isnan, sqrt
from typing import TYPE_CHECKING

from roughsim import prediction
from roughsim.errors import ResolutionError, number
from roughsim.estimate.cell_size import choose_lengths, size_error
from roughsim.estimate.errors import quantile
from roughsim.estimate.stop import LEAST, LEAST_FINE
from roughsim.planning import rungs
from roughsim.planning.pilot import MEMBERS, SCATTER_KNOWN, Pilot, pilot, work
from roughsim.scene.numerics import Column, Forecast, Level, Numerics, Reason
from roughsim.show import table
from roughsim.untrusted import machine_memory

if TYPE_CHECKING:
    from roughsim.scene import Scene

BYTES_PER_POINT = 120  # peak memory of a solve, measured
PACE = 1.2e-8  # CPU time of one realization over its `work` where no pilot was run, s, within a factor of two


def plan(scene: Scene, target_error: float | None = None) -> Numerics:
    """Choose the numerics of a scene by rule; keys of its [numerics] section are taken as they are.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    target_error : float, optional
        Relative error in all aimed at in T_flash; left out: what the scene's `until` asks of its statistical part, or
        1 % in all. The reasons say at which statistical error to stop the run.

    Returns
    -------
    Numerics
        With `reasons`, one for each choice.

    Raises
    ------
    ValueError
        If `target_error` is not in (0, 1).
    ResolutionError
        If the machine has too little memory for what is asked.
    """
    stop = None
    if target_error is None:
        stop = dict(scene.ensemble.until).get("flash_temperature")
        target_error = stop or 0.01
    if not 0.0 < number("target_error", target_error) < 1.0:
        raise ValueError(f"target_error = {target_error:.6g} must lie between 0 and 1")
    given = scene.numerics
    lengths, reason = choose_lengths(scene)
    reasons = [Reason("cell", _mm(lengths), reason)]
    if given.levels is not None:
        levels = tuple(Level(level.column, level.shape, level.q_max, level.every) for level in given.levels)
        reasons.append(Reason("levels", _listed(levels), "given in the scene"))
        forecast = None
    else:
        levels, forecast, more = _chosen(scene, lengths, target_error, stop)
        reasons += more
    numerics = _overridden(Numerics(levels, lengths, forecast=forecast), scene, reasons)
    _check_columns(scene, numerics)
    return replace(numerics, reasons=(*reasons, *_conductivity(scene), *_costs(numerics)))


def plan_table(reasons: Sequence[Reason]) -> table.Table:
    """Return the choices of a plan with their reasons."""
    return table.Table([table.Column(title) for title in ("choice", "value", "because")], reasons)


def _chosen(
    scene: Scene, lengths: tuple[float, float], target: float, stop: float | None
) -> tuple[tuple[Level, ...], Forecast, list[Reason]]:
    """Levels, what to expect of them, and why; `stop` is the statistical target if that is fixed."""
    column: Column = "elastic" if scene.elastic else "capped"
    q_max = scene.spectrum.breaks[-1]
    seen = pilot(scene, column, lengths, q_max if scene.elastic else min(q_max, 4.0 * rungs.scale(scene)[0]))
    build = rungs.elastic_levels if scene.elastic else rungs.capped_levels
    chosen, (bandwidth, pixel) = build(scene, lengths, target, seen)
    size = size_error(scene, lengths)
    systematic = hypot(0.0 if isnan(bandwidth) else bandwidth, pixel, size)
    goal = sqrt(max(target**2 - systematic**2, 0.1 * target**2)) if stop is None else stop
    scatter, hot, change = (0.02, 0.02, 0.003)
    if seen is not None:
        scatter, hot, change = seen.scatter, seen.hot_scatter, 0.75 * seen.change_scatter
    bare, most = [level for level, _ in chosen], scene.ensemble.max_realizations
    every = _stride(bare, scatter, change, goal, most)
    levels = _strided(bare, every)
    wanted = _realizations(scatter, change, every, goal)
    count = min(wanted, most)
    statistical = _half_width(count, hot, change, every)
    pace = PACE if seen is None else seen.pace
    forecast = Forecast(count, statistical, bandwidth, pixel, size, pace * _work(levels, count))
    why = [reason for _, reason in chosen]
    reasons = [Reason(a.column, _listed((a,)), reason) for a, reason in zip(levels, why, strict=True)]
    between = tuple(min(_realizations(f * scatter, f * change, every, goal), most) for f in SCATTER_KNOWN)
    return levels, forecast, [*reasons, _told(seen), *_expected(forecast, goal, wanted, between, scene.scanned)]


def _told(seen: Pilot | None) -> Reason:
    if seen is None:
        return Reason("pilot", "none", "a cheap solve did not converge: what is expected below is a guess")
    found = f"scatter {100 * seen.scatter:.2g} %, step {100 * seen.step:.2g} %, pixel {100 * seen.pixel:.2g} %"
    why = (
        f"cheap solves up to q_c = {seen.q_max:.3g} rad/m: how much T_flash scatters from one realization to the next, "
        "falls when q_c is doubled, and changes at half the pixel"
    )
    return Reason("pilot", found, why)


def _expected(forecast: Forecast, goal: float, wanted: int, between: tuple[int, ...], scanned: bool) -> list[Reason]:
    bandwidth = "unknown" if isnan(forecast.bandwidth) else f"{100 * forecast.bandwidth:.2g} %"
    parts = f"of the highest T_flash, expected: statistical {100 * forecast.statistical:.2g} %, bandwidth {bandwidth}, "
    parts += f"pixel {100 * forecast.pixel:.2g} %, size {100 * forecast.size:.2g} %"
    parts += ", scan unknown" if scanned else ""
    workers = os.cpu_count() or 1
    wall = forecast.wall_seconds(workers)
    until = f"--until flash_temperature={100 * goal:.3g}% stops once its statistical error (95 %) is that everywhere"
    each = f"{LEAST} at least; levels marked 1 in k are solved for every kth of them"
    if forecast.realizations < wanted:
        each = f"{each}; max_realizations ends the run before, as that takes about {wanted:.3g}"
    elif between[0] < between[-1]:
        each += (
            f"; {between[0]} to {between[-1]}, as the scatter from {MEMBERS} pilot solves is known within a factor 1.7"
        )
    return [
        Reason("realizations", f"about {forecast.realizations}", f"{until}; {each}"),
        Reason("error", _total(forecast) + (" without the scan's own error" if scanned else ""), parts),
        Reason(
            "workers",
            str(workers),
            f"one per core: {wall:.2g} s; {forecast.cpu_seconds:.2g} s of CPU for all solves, within a factor of two; "
            "starting a process takes a few seconds more",
        ),
    ]


def _total(forecast: Forecast) -> str:
    """The error in all, and what it is without."""
    without = " at q_c: what shorter waves change is unknown" if isnan(forecast.bandwidth) else ""
    return f"{100 * forecast.total:.2g} %{without}"


def _half_width(count: int, scatter: float, change: float, every: int) -> float:
    """The relative 95 % half-width after so many realizations, the fine levels solved for every few of them."""
    fine = -(-count // every)
    common, added = scatter**2 / count, change**2 / fine
    doubt = common**2 / (count - 1) + added**2 / max(fine - 1, 1)  # Satterthwaite, as in the estimate
    freedom = min((common + added) ** 2 / doubt, count - 1.0) if doubt > 0.0 else count - 1.0
    return float(quantile(freedom)) * sqrt(common + added)


def _realizations(scatter: float, change: float, every: int, goal: float) -> int:
    """How many realizations bring the half-width to the goal, with enough fine ones to tell."""
    count = max(LEAST, (LEAST_FINE - 1) * every + 1)
    while _half_width(count, scatter, change, every) > goal and count < 1_000_000_000:
        count += max(1, count // 50)
    return count


def _stride(levels: list[Level], scatter: float, change: float, goal: float, most: int) -> int:
    """Every how many realizations a fine level is solved: the cheapest power of two that gives it three at least."""
    cost: dict[int, float] = {}
    for every in (2**k for k in range(10)):
        count = _realizations(scatter, change, every, goal)  # all that the goal takes, allowed or not
        if every == 1 or 2 * every < min(count, most):
            cost[every] = _work(_strided(levels, every), count)
    return min(cost, key=cost.__getitem__)


def _strided(levels: list[Level], every: int) -> tuple[Level, ...]:
    return tuple(level if level.every == 1 else replace(level, every=every) for level in levels)


def _work(levels: tuple[Level, ...], count: int) -> float:
    """What all solves of so many realizations take."""
    return sum(work(level.shape[0] * level.shape[1]) * -(-count // level.every) for level in levels)


def _overridden(numerics: Numerics, scene: Scene, reasons: list[Reason]) -> Numerics:
    """Apply what the scene's [numerics] fixes, and say why the rest is what it is."""
    why = {
        "tolerance": "below every other error",
        "precision": "double costs little beside the solve's own transforms",
        "solver": "the package's own, elastic and capped",
        "slid_distance": "half the cell: a longer slide would meet its own periodic hot track (fields only)",
        "threads": "one per realization: realizations run side by side",
        "keep_fields": "enough to look at; every further one costs disk space",
    }
    given = {key: getattr(scene.numerics, key) for key in why if getattr(scene.numerics, key) is not None}
    numerics = replace(numerics, **given)
    for key, reason in why.items():
        value = getattr(numerics, key)
        shown = "L/2" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        reasons.append(Reason(key, shown, "given in the scene" if key in given else reason))
    reasons.append(
        Reason(
            "moments", "all speeds at once", "averaged over all sliding directions in closed form; C(q) is isotropic"
        )
    )
    return numerics


def _conductivity(scene: Scene) -> list[Reason]:
    if not isfinite(scene.temperature_range[1]):
        return []
    kappa = prediction.conduction(scene).conductivity
    shown = " … ".join(dict.fromkeys(f"{value:.4g}" for value in (kappa.max(), kappa.min())))
    return [Reason("conductivity", f"{shown} W/(m K)", "of the moving body at T₀ + 0.75 T_flash of the theory")]


def _check_columns(scene: Scene, numerics: Numerics) -> None:
    allowed = ("elastic",) if scene.elastic else ("smoothed", "capped")
    for level in numerics.levels:
        if level.column not in allowed:
            kind = "elastic" if scene.elastic else "capped"
            raise ValueError(f'column = "{level.column}" does not fit {kind} scene; use {" or ".join(allowed)}')


def _costs(numerics: Numerics) -> list[Reason]:
    points = [level.shape[0] * level.shape[1] for level in numerics.levels]
    memory, available = BYTES_PER_POINT * max(points), machine_memory()
    if memory > 0.8 * available:
        raise ResolutionError(
            f"memory = {memory / 1e9:.3g} GB for a grid of {max(points)} points exceeds 80 % of the machine's "
            f"{available / 1e9:.3g} GB; lower the levels' shape"
        )
    return [Reason("memory", f"{memory / 1e9:.2g} GB per worker", "largest grid")]


def _listed(levels: tuple[Level, ...]) -> str:
    def told(a: Level) -> str:
        seldom = f", 1 in {a.every}" if a.every > 1 else ""
        return f"{a.shape[0]} × {a.shape[1]} to q_c = {a.q_max:.3g} rad/m{seldom}"

    return "; ".join(told(level) if len(levels) == 1 else f"{level.column} {told(level)}" for level in levels)


def _mm(lengths: tuple[float, float]) -> str:
    return f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm"


__all__ = ["plan", "plan_table"]
