"""Which levels a scene gets: cut-offs, grids and the systematic errors to expect of them.

The rules, measured on steel: what yields plastically needs no resolution of its own, so the yield wavenumber q_y sets
the scale, not q_max. Bandwidth, not pixels, is the error of capped contact, so it is solved up to three cut-offs, the
lower two also at half the pixel, and extrapolated; contact on the smoothed spectrum C_sm converges by itself. A scene
whose C(q) no grid holds is solved up to three cut-offs as well, and continued with the theory's shape.
"""

from __future__ import annotations

from math import hypot, inf, isfinite, nan, pi
from typing import TYPE_CHECKING

import numpy as np

from roughsim import prediction
from roughsim.estimate.ladder import DOUBT_OF_SHAPE
from roughsim.planning.pilot import Pilot
from roughsim.scene.numerics import Column, Level, fast_size

if TYPE_CHECKING:
    from roughsim.scene import Scene

ELASTIC_LIMIT = 2048  # points per side up to which an elastic scene is resolved; beyond, C(q) is cut
CAPPED_LIMIT = 4096
_TOPS = (8, 16, 32)  # cut-offs of capped contact, in q_y
_SYSTEMATIC = 0.6  # share of the target that bandwidth and pixel may take
Chosen = tuple[list[tuple[Level, str]], tuple[float, float]]
_SLOW = 0.75  # the exponent below which three rungs do not tell it well: H = 0.43
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


def elastic_levels(scene: Scene, lengths: tuple[float, float], target: float, seen: Pilot | None) -> Chosen:
    """One cut-off on two grids, the coarse one always, the fine one for the pixel; or a ladder where C(q) is cut."""
    q_max = scene.spectrum.breaks[-1]
    if q_max > _cut(lengths) / 2:
        why = f"the whole of C(q), to {q_max:.3g} rad/m, is more than a grid holds"
        return _cut_ladder(scene, "elastic", lengths, why), _cut_errors(scene, "elastic", lengths, seen)
    change = 0.01 if seen is None else seen.pixel
    pixels = 4 if change / 3 <= _SYSTEMATIC * target else 8  # second order: a third of the change is left
    left = change / 3 if pixels == 4 else change / 12
    return _pair("elastic", q_max, pixels, lengths, f"{pixels} pixels per shortest wave"), (0.0, left)


def _cut(lengths: tuple[float, float]) -> float:
    """The highest cut-off of a scene that no grid holds, rad/m: 4 pixels per wave on the finest grid."""
    return ELASTIC_LIMIT * 2 * pi / (4 * max(lengths))


def _cut_ladder(scene: Scene, column: Column, lengths: tuple[float, float], why: str) -> list[tuple[Level, str]]:
    """Three cut-offs, the lowest also with half the pixel: their steps continue with the theory's shape."""
    q_max = scene.spectrum.breaks[-1]
    top = min(_cut(lengths), q_max)
    last = f"C(q) cut at q_c = {top:.3g} rad/m (q_max = {q_max:.3g})" if top < q_max else "all of C(q)"
    return [
        (_level(column, top / 4, 4, lengths), f"{why}; 4 pixels per shortest wave"),
        (_level(column, top / 4, 8, lengths, _FINE), _FINER + " and takes it off"),
        (_level(column, top / 2, 4, lengths, _FINE), "twice the q_c: what shorter waves change"),
        (_level(column, top, 4, lengths, _FINE), f"{last}: {_continued(scene, column, top)}"),
    ]


def _continued(scene: Scene, column: Column, top: float) -> str:
    """How a ladder goes on beyond its top."""
    if top >= scene.spectrum.breaks[-1]:
        return "nothing is left out"
    if prediction.follows_theory(scene, column, top):
        return "what is left to q_max follows the theory's shape, scaled by the last step"
    return "what is left to q_max is unknown: the contact yields at shorter waves than any grid holds"


def _cut_errors(scene: Scene, column: Column, lengths: tuple[float, float], seen: Pilot | None) -> tuple[float, float]:
    """Bandwidth and pixel error to expect of T_flash at the hottest speed; NaN for a bandwidth that nothing tells."""
    top, end = _cut(lengths), scene.spectrum.breaks[-1]
    pixel = 0.003 if seen is None else seen.pixel / 3
    if top >= end:
        return 0.0, pixel
    if not prediction.follows_theory(scene, column, top):
        return nan, pixel
    temperatures = prediction.predictions(scene, inf)["flash_temperature"]
    hottest = int(np.argmax(temperatures))
    if not temperatures[hottest]:  # at rest, at every speed of the scene
        return 0.0, pixel

    def theory(q: float) -> float:
        return float(prediction.predictions(scene, q)["flash_temperature"][hottest])

    remainder = theory(inf) / theory(top) - 1.0
    if seen is not None:  # as much more than in the theory as the pilot's step
        step = theory(seen.q_max) - theory(seen.q_max / 2)
        remainder = seen.step * (theory(inf) - theory(top)) / step
    return DOUBT_OF_SHAPE * remainder, pixel


def scale(scene: Scene) -> tuple[float, str]:
    """q_y, or q_max where the theory's contact does not yield before, and what to call it."""
    q_yield = prediction.yield_wavenumber(scene)
    if isfinite(q_yield):
        return q_yield, f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    q_max = scene.spectrum.breaks[-1]
    return q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"


def capped_levels(scene: Scene, lengths: tuple[float, float], target: float, seen: Pilot | None) -> Chosen:
    """The smoothed surface on two grids, and a ladder of capped contact up to some q_y."""
    q_max = scene.spectrum.breaks[-1]
    q_yield, where = scale(scene)
    smooth = min(1.5 * q_yield, q_max)
    limit = CAPPED_LIMIT * 2 * pi / (4 * max(lengths))
    if smooth > limit / 2:
        return _unyielding_levels(scene, lengths, seen, where)
    smoothed = _pair("smoothed", smooth, 4, lengths, f"1.5 × {where}; 4 pixels per shortest wave")
    for factor in _TOPS:
        top = min(factor * q_yield, q_max, limit)
        exponent = prediction.usual_exponent(scene, top)
        doubt = 1.0 if factor < 16 else 0.12 if exponent > _SLOW else 0.5
        errors = _capped_errors(top, top < q_max, seen, exponent, doubt)
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
    """Both columns up to the same cut-offs: the grids that reach them show too little yielding to fall as q_c^(−p)."""
    why = f"yields beyond any grid ({where})"
    columns: tuple[Column, Column] = ("smoothed", "capped")
    levels = [level for column in columns for level in _cut_ladder(scene, column, lengths, why)]
    return levels, _cut_errors(scene, "capped", lengths, seen)


def _capped_errors(
    top: float, extrapolated: bool, seen: Pilot | None, exponent: float, doubt: float
) -> tuple[float, float]:
    """Bandwidth and pixel error to expect of capped T_flash up to a cut-off; shares measured on steel.

    T_flash falls as q_c^(−exponent). `doubt` is the share of the remainder that three rungs leave: small once the
    lowest stands at 4 q_y; below, or where the fall is slow, they tell no exponent.
    """
    if seen is None:
        return (0.005, 0.002)
    if not extrapolated:
        return (0.0, 0.6 * seen.pixel * min(seen.q_max / top, 1.0) ** 0.5)
    remainder = seen.step / (2.0**exponent - 1.0) * (seen.q_max / top) ** exponent
    return (doubt * remainder, seen.pixel * seen.q_max / top)


def _level(column: Column, q_max: float, pixels: int, lengths: tuple[float, float], every: int = 1) -> Level:
    shape = fast_size(pixels * q_max * lengths[0] / (2 * pi)), fast_size(pixels * q_max * lengths[1] / (2 * pi))
    return Level(column, shape, q_max, every)


__all__ = ["CAPPED_LIMIT", "ELASTIC_LIMIT", "capped_levels", "elastic_levels", "scale"]
