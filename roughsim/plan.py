"""From a scene to its numerics: the cheapest grids and tolerances that meet the asked-for error, each with its reason.

The rules, measured on steel: what yields plastically needs no resolution of its own, so the yield wavenumber q_y sets
the scale, not q_max. Bandwidth, not pixels, is the error of capped contact, so it is solved up to two cut-offs and
extrapolated; contact on the smoothed spectrum C_sm converges by itself.
"""

from __future__ import annotations

import os
from dataclasses import replace
from math import ceil, inf, isfinite, pi
from typing import TYPE_CHECKING

from roughsim import analytic
from roughsim.errors import ResolutionError, number
from roughsim.numerics import Column, Level, Numerics, Reason

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.sections import CounterfaceSection, SurfaceSection

ELASTIC_LIMIT = 2048  # points per side up to which an elastic scene is resolved; beyond, C(q) is cut
CAPPED_LIMIT = 4096
BYTES_PER_POINT = 120  # peak memory of a solve, measured
SECONDS_PER_POINT = 4.0e-7  # time of one realization per grid point, one thread, within a factor of two


def plan(scene: Scene, target_error: float | None = None) -> Numerics:
    """Choose the numerics of a scene by rule; keys of its [numerics] section are taken as they are.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    target_error : float, optional
        Relative error aimed at in T_flash; left out: what the scene's `until` asks of it, or 1 %.

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
    if target_error is None:
        target_error = dict(scene.ensemble.until).get("flash_temperature", 0.01)
    if not 0.0 < number("target_error", target_error) < 1.0:
        raise ValueError(f"target_error = {target_error:.6g} must lie between 0 and 1")
    given = scene.numerics
    lengths, reasons = _lengths(scene)
    if given.levels is not None:
        levels = tuple(Level(level.column, level.shape, level.q_max, level.every) for level in given.levels)
        reasons.append(Reason("levels", _listed(levels), "given in the scene"))
    else:
        chosen = _elastic_levels(scene, lengths) if scene.elastic else _capped_levels(scene, lengths, target_error)
        levels = tuple(level for level, _ in chosen)
        reasons += [reason for _, reason in chosen]
    numerics = _overridden(Numerics(levels, lengths), scene, reasons)
    _check_columns(scene, numerics)
    return replace(numerics, reasons=(*reasons, *_costs(numerics)))


def _lengths(scene: Scene) -> tuple[tuple[float, float], list[Reason]]:
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, [Reason("cell", _mm(scene.numerics.lengths), "given in the scene")]
    spectrum = scene.spectrum
    longest = 2 * pi / spectrum.breaks[0]
    length, reason = 4 * longest, "4 longest waves (2π/q_min) per side; more change T_flash by less than its error"
    plateau = _plateau_end(scene)
    if plateau is not None:
        wave = 2 * pi / plateau
        length = max(8 * wave, min(4 * longest, 16 * wave))
        reason = f"{length / wave:.3g} roll-off waves (2π/q_roll_off) per side: C(q) is flat below q_roll_off"
    return (length, length), [Reason("cell", _mm((length, length)), reason)]


def _plateau_end(scene: Scene) -> float | None:
    """q_roll_off where every rough face is flat (m < 1) below it, else None."""
    faces: list[SurfaceSection | CounterfaceSection] = [scene.surface]
    if scene.counterface is not None and scene.counterface.rough:
        faces.append(scene.counterface)
    ends = []
    for face in faces:
        kink, flat = face.q_roll_off, (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)


def _elastic_levels(scene: Scene, lengths: tuple[float, float]) -> list[tuple[Level, Reason]]:
    q_max = scene.spectrum.breaks[-1]
    limit = ELASTIC_LIMIT * 2 * pi / (8 * max(lengths))
    reason = "8 pixels per shortest wave"
    if q_max > limit:
        reason += f"; C(q) cut at q_c = {limit:.3g} rad/m (q_max = {q_max:.3g}): theory is summed over the same modes"
    return [_level("elastic", min(q_max, limit), 8, lengths, reason)]


def _capped_levels(scene: Scene, lengths: tuple[float, float], target_error: float) -> list[tuple[Level, Reason]]:
    q_max = scene.spectrum.breaks[-1]
    q_yield = analytic.yield_wavenumber(scene)
    where = f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    if not isfinite(q_yield):
        q_yield, where = q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"
    smooth = min(1.5 * q_yield, q_max)
    chosen = [_level("smoothed", smooth, 8, lengths, f"1.5 × {where}; 8 pixels per shortest wave: converged")]
    finest = 16 if target_error <= 0.02 else 8
    limit = CAPPED_LIMIT * 2 * pi / (4 * max(lengths))
    top = min(finest * q_yield, q_max, limit)
    if top < q_max:
        chosen.append(_level("capped", top / 2, 4, lengths, "half of the finest q_c, to extrapolate as 1/q_c"))
    reason = f"{top / q_yield:.3g} q_y at 4 pixels per shortest wave"
    if top == limit:
        reason += f"; cut by the limit of {CAPPED_LIMIT} points per side"
    return [*chosen, _level("capped", top, 4, lengths, reason)]


def _level(
    column: Column, q_max: float, pixels: int, lengths: tuple[float, float], reason: str
) -> tuple[Level, Reason]:
    shape = fast_size(pixels * q_max * lengths[0] / (2 * pi)), fast_size(pixels * q_max * lengths[1] / (2 * pi))
    level = Level(column, shape, q_max)
    return level, Reason(column, _listed((level,)), reason)


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    wanted = max(8, ceil(0.98 * points))
    power = 1
    while 8 * power < wanted:
        power *= 2
    return min(k * power for k in (4, 5, 6, 8) if k * power >= wanted)


def _overridden(numerics: Numerics, scene: Scene, reasons: list[Reason]) -> Numerics:
    """Apply what the scene's [numerics] fixes, and say why the rest is what it is."""
    why = {
        "tolerance": "below every other error",
        "precision": "double costs little beside the solve's own transforms",
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


def _check_columns(scene: Scene, numerics: Numerics) -> None:
    allowed = ("elastic",) if scene.elastic else ("smoothed", "capped")
    for level in numerics.levels:
        if level.column not in allowed:
            kind = "elastic" if scene.elastic else "capped"
            raise ValueError(f'column = "{level.column}" does not fit {kind} scene; use {" or ".join(allowed)}')


def _costs(numerics: Numerics) -> list[Reason]:
    points = [level.shape[0] * level.shape[1] for level in numerics.levels]
    memory, available = BYTES_PER_POINT * max(points), _memory()
    if memory > 0.8 * available:
        raise ResolutionError(
            f"memory = {memory / 1e9:.3g} GB for a grid of {max(points)} points exceeds 80 % of the machine's "
            f"{available / 1e9:.3g} GB; lower the levels' shape"
        )
    seconds = SECONDS_PER_POINT * sum(points)
    return [
        Reason("memory", f"{memory / 1e9:.2g} GB per worker", "largest grid"),
        Reason("time", f"about {seconds:.2g} s per realization", "one thread, within a factor of two"),
    ]


def _memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return inf  # unknown on this system


def _listed(levels: tuple[Level, ...]) -> str:
    return ", ".join(f"{a.column} {a.shape[0]} × {a.shape[1]} to q_c = {a.q_max:.3g} rad/m" for a in levels)


def _mm(lengths: tuple[float, float]) -> str:
    return f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm"


__all__ = ["fast_size", "plan"]
