"""From a scene to its numerics: the cheapest grids and tolerances that meet the asked-for error, each with its reason.

The rules, measured on steel: what yields plastically needs no resolution of its own, so the yield wavenumber q_y sets
the scale, not q_max. Bandwidth, not pixels, is the error of capped contact, so it is solved up to three cut-offs, the
lower two also at half the pixel, and extrapolated; contact on the smoothed spectrum C_sm converges by itself.
"""

from __future__ import annotations

import os
from dataclasses import replace
from math import hypot, inf, isfinite, pi, sqrt
from typing import TYPE_CHECKING

from roughsim import analytic
from roughsim.cell import choose_lengths, size_error
from roughsim.errors import ResolutionError, number
from roughsim.estimate import LEAST, quantile
from roughsim.numerics import Column, Forecast, Level, Numerics, Reason, fast_size
from roughsim.pilot import Pilot, pilot, work

if TYPE_CHECKING:
    from roughsim.scene import Scene

ELASTIC_LIMIT = 2048  # points per side up to which an elastic scene is resolved; beyond, C(q) is cut
CAPPED_LIMIT = 4096
BYTES_PER_POINT = 120  # peak memory of a solve, measured
PACE = 1.2e-8  # CPU time of one realization over its `work` where no pilot was run, s, within a factor of two
_TOPS = (8, 16, 32)  # cut-offs of capped contact, in q_y
_SYSTEMATIC = 0.6  # share of the target that bandwidth and pixel may take


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


def _chosen(
    scene: Scene, lengths: tuple[float, float], target: float, stop: float | None
) -> tuple[tuple[Level, ...], Forecast, list[Reason]]:
    """Levels, what to expect of them, and why; `stop` is the statistical target if that is fixed."""
    column: Column = "elastic" if scene.elastic else "capped"
    q_max = scene.spectrum.breaks[-1]
    seen = pilot(scene, column, lengths, q_max if scene.elastic else min(q_max, 4.0 * _scale(scene)[0]))
    build = _elastic_levels if scene.elastic else _capped_levels
    chosen, (bandwidth, pixel) = build(scene, lengths, target, seen)
    size = size_error(scene, lengths)
    systematic = hypot(bandwidth, pixel, size)
    goal = sqrt(max(target**2 - systematic**2, 0.1 * target**2)) if stop is None else stop
    scatter, hot, change = (0.02, 0.02, 0.003)
    if seen is not None:
        scatter, hot, change = seen.scatter, seen.hot_scatter, 0.75 * seen.change_scatter
    bare, most = [level for level, _ in chosen], scene.ensemble.max_realizations
    every = _stride(bare, scatter, change, goal, most)
    levels = _strided(bare, every)
    count = min(_realizations(hypot(scatter, sqrt(every) * change), goal), most)
    statistical = float(quantile(count - 1.0)) * hypot(hot, sqrt(every) * change) / sqrt(count)
    pace = PACE if seen is None else seen.pace
    forecast = Forecast(count, statistical, bandwidth, pixel, size, pace * _work(levels, count))
    why = [reason for _, reason in chosen]
    reasons = [Reason(a.column, _listed((a,)), reason) for a, reason in zip(levels, why, strict=True)]
    return levels, forecast, [*reasons, _told(seen), *_expected(forecast, goal)]


def _told(seen: Pilot | None) -> Reason:
    if seen is None:
        return Reason("pilot", "none", "a cheap solve did not converge: what is expected below is a guess")
    found = f"scatter {100 * seen.scatter:.2g} %, step {100 * seen.step:.2g} %, pixel {100 * seen.pixel:.2g} %"
    why = (
        f"cheap solves up to q_c = {seen.q_max:.3g} rad/m: how much T_flash scatters from one realization to the next, "
        "falls when q_c is doubled, and changes at half the pixel"
    )
    return Reason("pilot", found, why)


def _expected(forecast: Forecast, goal: float) -> list[Reason]:
    parts = f"of the highest T_flash, expected: statistical {100 * forecast.statistical:.2g} %, bandwidth "
    parts += f"{100 * forecast.bandwidth:.2g} %, pixel {100 * forecast.pixel:.2g} %, size {100 * forecast.size:.2g} %"
    workers = os.cpu_count() or 1
    wall = forecast.wall_seconds(workers)
    until = f"--until flash_temperature={100 * goal:.3g}% stops once its 95 % interval is ± that at every speed"
    each = f"{LEAST} at least; levels marked 1 in k are solved for every kth of them"
    return [
        Reason("realizations", f"about {forecast.realizations}", f"{until}; {each}"),
        Reason("error", f"{100 * forecast.total:.2g} %", parts),
        Reason(
            "workers",
            str(workers),
            f"one per core: {wall:.2g} s; {forecast.cpu_seconds:.2g} s of CPU in all, within a factor of two",
        ),
    ]


def _realizations(scatter: float, goal: float) -> int:
    """How many realizations bring the 95 % half-width to the goal."""
    count = LEAST
    while quantile(count - 1.0) * scatter / sqrt(count) > goal and count < 1_000_000_000:
        count += max(1, count // 50)
    return count


def _stride(levels: list[Level], scatter: float, change: float, goal: float, most: int) -> int:
    """Every how many realizations a fine level is solved: the cheapest power of two that gives it three at least."""
    cost: dict[int, float] = {}
    for every in (2**k for k in range(10)):
        count = _realizations(hypot(scatter, sqrt(every) * change), goal)  # all that the goal takes, allowed or not
        if every == 1 or 2 * every < min(count, most):
            cost[every] = _work(_strided(levels, every), count)
    return min(cost, key=cost.__getitem__)


def _strided(levels: list[Level], every: int) -> tuple[Level, ...]:
    return tuple(level if level.every == 1 else replace(level, every=every) for level in levels)


def _work(levels: tuple[Level, ...], count: int) -> float:
    """What all solves of so many realizations take."""
    return sum(work(level.shape[0] * level.shape[1]) * -(-count // level.every) for level in levels)


Chosen = tuple[list[tuple[Level, str]], tuple[float, float]]
_FINE = 2  # stands for the stride that is chosen later
_FINER = "half the pixel, which tells the pixel's error"


def _pair(column: Column, q_c: float, pixels: int, lengths: tuple[float, float], why: str) -> list[tuple[Level, str]]:
    """One cut-off on two grids."""
    return [
        (_level(column, q_c, pixels, lengths), why),
        (
            _level(column, q_c, 2 * pixels, lengths, _FINE),
            _FINER + " and takes it off",
        ),
    ]


def _elastic_levels(scene: Scene, lengths: tuple[float, float], target: float, seen: Pilot | None) -> Chosen:
    """One cut-off, on two grids: the coarse one always, the fine one for the pixel."""
    q_max = scene.spectrum.breaks[-1]
    limit = _elastic_cut(lengths)
    change = 0.01 if seen is None else seen.pixel
    pixels = 4 if change / 3 <= _SYSTEMATIC * target else 8  # second order: a third of the change is left
    left = change / 3 if pixels == 4 else change / 12
    cut = ""
    if q_max > limit:
        cut = "; " + _cut_words(limit, q_max)
    q_c = min(q_max, limit)
    return _pair("elastic", q_c, pixels, lengths, f"{pixels} pixels per shortest wave" + cut), (0.0, left)


def _elastic_cut(lengths: tuple[float, float]) -> float:
    """The highest cut-off that an elastic scene gets, rad/m: 8 pixels per wave on the finest grid."""
    return ELASTIC_LIMIT * 2 * pi / (8 * max(lengths))


def _cut_words(q_c: float, q_max: float) -> str:
    return f"C(q) cut at q_c = {q_c:.3g} rad/m (q_max = {q_max:.3g}): theory is summed over the same modes"


def _scale(scene: Scene) -> tuple[float, str]:
    """q_y, or q_max where the theory's contact does not yield before, and what to call it."""
    q_yield = analytic.yield_wavenumber(scene)
    if isfinite(q_yield):
        return q_yield, f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    q_max = scene.spectrum.breaks[-1]
    return q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"


def _capped_levels(scene: Scene, lengths: tuple[float, float], target: float, seen: Pilot | None) -> Chosen:
    """The smoothed surface on two grids, and a ladder of capped contact up to some q_y."""
    q_max = scene.spectrum.breaks[-1]
    q_yield, where = _scale(scene)
    smooth = min(1.5 * q_yield, q_max)
    limit = CAPPED_LIMIT * 2 * pi / (4 * max(lengths))
    if smooth > limit / 2:
        return _unyielding_levels(scene, lengths, seen, where)
    smoothed = _pair("smoothed", smooth, 4, lengths, f"1.5 × {where}; 4 pixels per shortest wave")
    for factor in _TOPS:
        top = min(factor * q_yield, q_max, limit)
        errors = _capped_errors(top, top < q_max, seen, 0.12 if factor >= 16 else 0.35)
        if hypot(*errors) <= _SYSTEMATIC * target or top < factor * q_yield:
            break
    if top >= q_max:
        all_of_it = f"all of C(q), {top / q_yield:.3g} q_y, at 4 pixels per shortest wave"
        return [*smoothed, *_pair("capped", top, 4, lengths, all_of_it)], errors
    ladder = [(_level("capped", top / 4, 4, lengths), f"{top / 4 / q_yield:.3g} q_y at 4 pixels per shortest wave")]
    ladder += [
        (
            _level("capped", top / k, 8, lengths, _FINE),
            _FINER,
        )
        for k in (4, 2)
    ]
    last = f"{top / q_yield:.3g} q_y" + (f": the limit of {CAPPED_LIMIT} points per side" if top == limit else "")
    ladder.insert(
        2,
        (_level("capped", top / 2, 4, lengths, _FINE), "twice the q_c: what shorter waves change"),
    )
    return [
        *smoothed,
        *ladder,
        (
            _level("capped", top, 4, lengths, _FINE),
            last + ": how that falls, T∞ + c q_c^(−p)",
        ),
    ], errors


def _unyielding_levels(scene: Scene, lengths: tuple[float, float], seen: Pilot | None, where: str) -> Chosen:
    """Both columns up to one cut-off: the grids that reach it show too little yielding to extrapolate from."""
    q_max, q_c = scene.spectrum.breaks[-1], _elastic_cut(lengths)
    why = f"yields beyond any grid ({where}); {_cut_words(q_c, q_max)}; 4 pixels per shortest wave"
    columns: tuple[Column, Column] = ("smoothed", "capped")
    levels = [level for column in columns for level in _pair(column, q_c, 4, lengths, why)]
    return levels, _capped_errors(q_c, False, seen, 0.0)


def _capped_errors(top: float, extrapolated: bool, seen: Pilot | None, doubt: float) -> tuple[float, float]:
    """Bandwidth and pixel error to expect of capped T_flash up to a cut-off; shares measured on steel.

    `doubt` is the share of the remainder that three rungs leave: small once the lowest stands at 4 q_y.
    """
    if seen is None:
        return (0.005, 0.002)
    if not extrapolated:
        return (0.0, 0.6 * seen.pixel * min(seen.q_max / top, 1.0) ** 0.5)
    return (doubt * seen.step * seen.q_max / top, seen.pixel * seen.q_max / top)


def _level(column: Column, q_max: float, pixels: int, lengths: tuple[float, float], every: int = 1) -> Level:
    shape = fast_size(pixels * q_max * lengths[0] / (2 * pi)), fast_size(pixels * q_max * lengths[1] / (2 * pi))
    return Level(column, shape, q_max, every)


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
    kappa = analytic.conduction(scene).conductivity
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


def machine_memory() -> float:
    """Return the machine's memory, bytes; inf where the system does not tell."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return inf


def _listed(levels: tuple[Level, ...]) -> str:
    def told(a: Level) -> str:
        seldom = f", 1 in {a.every}" if a.every > 1 else ""
        return f"{a.shape[0]} × {a.shape[1]} to q_c = {a.q_max:.3g} rad/m{seldom}"

    return "; ".join(told(level) if len(levels) == 1 else f"{level.column} {told(level)}" for level in levels)


def _mm(lengths: tuple[float, float]) -> str:
    return f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm"


__all__ = ["machine_memory", "plan"]
