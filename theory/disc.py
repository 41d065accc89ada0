"""Mean temperature of a uniformly heated disc on a half-space: at rest, sliding straight, or round a ring track.

With lengths in the radius a, times in a²/D and temperatures in q̇a/κ, the mean over the disc after a time τ is

    U = ∫₀^τ (πt)^(−1/2) S(t, l(t)) dt,

S the part of the heat of age t that is still under the disc, l how far the disc has moved since. With C(r) =
2 arccos(r/2) − (r/2)√(4 − r²), the area that two discs have in common at the distance r,

    S = (1/π) ∫₀² C(r) (r/2t) e^(−(r² + l²)/4t) I₀(rl/2t) dr = ∫₀^∞ (2/q) J₁(q)² J₀(ql) e^(−q²t) dq.

Straight on l = Pe t and the integral over t is closed (`straight`). On a ring track of the radius ρ the disc comes back
to its own heat after each lap: l = 2ρ|sin(Pe t/2ρ)|. The first laps, and the last ones, are integrated; between them S
is replaced by its mean over a lap, with J₀(qρ)² in place of J₀(ql) (`ring`).
"""

from collections.abc import Callable
from functools import lru_cache
from math import ceil, inf, isinf, pi, sqrt

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.special import betainc, erf, erfc, erfcx, i0e, j0, j1

from theory.arguments import Array
from theory.quadrature import WEIGHTS, Panels, QuadratureError, panels_between, refine

_HEAD = 1e-13  # of the shortest length of a kernel: up to there it is constant
_REACH = 10.0  # of heat in √t: e^(−25) is left beyond
# over ±_REACH of S, and over the disc once heat has spread as far: exact to 1e-13
_POINTS, _FEW_POINTS, _OLD = leggauss(40), leggauss(12), 0.3
# laps: all are followed up to the first number; until the second the mean over a lap takes their place smoothly, with
# the derivatives up to the fifth, so that U is exact to 1e-9
_FIRST, _LAST, _SMOOTH = 3, 20, 6
_MANY = 1e9  # laps, of which the last ones change U by less than 1e-8
_STEPS, _STEP_WEIGHTS = leggauss(12)  # over the laps between the two
_SHORT = 500.0, 170.0  # q, and q τ^(1/6): waves shorter than both have 1e-8 of the mean over a lap
_ROUND = 500.0, 1000.0  # qρ, between which J₀(qρ)² gives way to its mean


@lru_cache(maxsize=1024)  # 1 to 100 ms each; tables over temperature ask for the same again
def mean_rise(time: float, peclet: float, track: float = inf) -> float:
    """Return U, in q̇a/κ, after τ = Dt/a² ≥ 0, inf steady, at Pe = va/D ≥ 0, on a track of radius ρ in a ≥ 1.

    The relative accuracy is 1e-8; QuadratureError if it is not reached.
    """
    if time == 0.0:
        return 0.0
    try:
        if peclet == 0.0 or isinf(track):
            return straight(time, peclet)
        return ring(time, peclet, track)
    except QuadratureError:
        raise QuadratureError(
            f"the mean temperature of a disc at Dt/a² = {time:.4g}, va/D = {peclet:.4g} and a track of {track:.4g} a "
            "did not reach its accuracy; check the units of the radii, the speed and the time"
        ) from None


def straight(time: float, peclet: float) -> float:
    """Return U of a disc that rests, or moves straight on.

    U = (1/π) ∫₀² C(r) k(r) dr with z = Pe r/2, x = r/2√τ, y = Pe√τ/2 and

        k = ½ I₀(z) [e^(−z) erfc(x − y) + e^z erfc(x + y)]:

    erfc(r/2√τ) at rest, e^(−z) I₀(z) of steady sliding, 1 of both.
    """
    root = sqrt(time)

    def kernel(r: Array) -> Array:
        steady: Array = i0e(0.5 * peclet * r)
        if isinf(time):
            return steady
        x, y = 0.5 * r / root, 0.5 * peclet * root
        behind = erfc(x - y) + erfcx(x + y) * np.exp(-((x - y) ** 2))
        return 0.5 * steady * np.asarray(behind)

    def integrand(angle: Array) -> Array:
        area = pi - 2 * angle - np.sin(2 * angle)  # C(r)
        return area * kernel(2 * np.sin(angle)) * 2 * np.cos(angle) / pi

    head = _HEAD * min(1.0, root, 1.0 / peclet if peclet else inf)
    return 2 * head + _integral(integrand, (head, pi / 2))


def ring(time: float, peclet: float, track: float) -> float:
    """Return U of a disc that goes round a track of radius ρ ≥ 1, from its start on."""
    lap = 2 * pi * track / peclet
    first, last = lap * _FIRST, lap * _LAST
    ends = 2 * last < time < _MANY * lap  # the last laps count by themselves

    def followed(age: Array) -> Array:
        """Return the weight of heat of an age, of which the lap is followed."""
        if time <= 2 * last:
            return np.ones_like(age)
        weight = _fading((age - first) / (last - first))
        return weight + _fading((time - age - first) / (last - first)) if ends else weight

    def heat(age: Array, moved: Array) -> Array:
        weight = np.where(age <= time, followed(age) / np.sqrt(pi * age), 0.0)
        return weight * remaining(*np.broadcast_arrays(age, moved))

    laps = np.arange(1.0, _LAST + 1)
    if time <= 2 * last:
        laps = np.arange(1.0, ceil(time / lap + 0.5))
    elif ends:
        end = np.arange(ceil((time - last) / lap - 0.5), ceil(time / lap + 0.5))
        laps = np.union1d(laps, end)
    total = _first_half_lap(heat, time, lap, track) + _later_laps(heat, laps, time, lap, track)
    if time > 2 * last:
        ages = first + (last - first) * (1 + _STEPS) / 2
        weights = _STEP_WEIGHTS * ((1 + _STEPS) * (1 - _STEPS)) ** (_SMOOTH - 1)
        total += _mean_over_laps(ages, weights / weights.sum(), time, track)
    return total


def remaining(age: Array, moved: Array) -> Array:
    """Return S, the part of the heat of an age that is under the disc after it has moved so far; (n,) or (…, n)."""
    width = _REACH * np.sqrt(age)
    near, far = np.maximum(moved - width, 0.0), np.minimum(moved + width, 2.0)
    result = np.zeros(age.shape)
    under, old = near < far, age > _OLD
    for chosen, (points, weights) in ((under & ~old, _POINTS), (under & old, _FEW_POINTS)):
        t, way = age[chosen, None], moved[chosen, None]
        low, high = (np.arcsin(r[chosen, None] / 2) for r in (near, far))
        half = (high - low) / 2
        angle = low + half * (1 + points)
        sine, cosine = np.sin(angle), np.cos(angle)
        r, area = 2 * sine, pi - 2 * angle - 2 * sine * cosine  # C(r)
        spread = r / (2 * t) * np.exp(-((r - way) ** 2) / (4 * t)) * i0e(r * way / (2 * t))
        result[chosen] = (area * spread * 2 * cosine * half) @ weights / pi
    return result


def _fading(x: Array) -> Array:
    """Return a smooth step from 1 at x ≤ 0 to 0 at x ≥ 1."""
    return np.asarray(1.0 - betainc(_SMOOTH, _SMOOTH, np.clip(x, 0.0, 1.0)))


def _first_half_lap(heat: Callable[..., Array], time: float, lap: float, track: float) -> float:
    """Return the part of U by the heat of the ages up to half a lap; S = 1 − 2√(t/π) where it begins."""
    end = min(time, lap / 2)
    speed = 2 * pi * track / lap
    start = 1e-10 * min(1.0, speed**-2, end)

    def of_age(age: Array) -> Array:
        return heat(age, 2 * track * np.sin(pi * age / lap))

    return 2 * sqrt(start / pi) - 2 * start / pi + _integral(of_age, (start, end))


def _later_laps(
    heat: Callable[..., Array], laps: Array, time: float, lap: float, track: float
) -> float:
    """Return the part of U by the heat of the ages half a lap about each of some laps."""
    if laps.size == 0:
        return 0.0
    start = 3e-4 * min(1.0, sqrt(lap) / track)  # S is constant below
    cut = abs(time / lap - round(time / lap)) if time < inf else 0.0  # where the heat begins

    def of_phase(phase: Array) -> Array:
        ages = np.concatenate([laps + phase[..., None], laps - phase[..., None]], axis=-1)
        moved = 2 * track * np.sin(pi * phase)[..., None]
        return np.asarray(lap * heat(lap * ages, moved).sum(axis=-1))

    breaks = (start, cut, 0.5) if start < cut < 0.5 else (start, 0.5)
    return start * float(of_phase(np.array(start))) + _integral(of_phase, breaks)


def _mean_over_laps(ages: Array, weights: Array, time: float, track: float) -> float:
    """Return the part of U by heat from an age on, averaged over `ages` and laps, and as long before the end.

    ∫₀^∞ (2/q²) J₁(q)² J₀(qρ)² [erf q√(τ − T) − erf q√T] dq of each age T.
    """

    def of_wave(q: Array) -> Array:
        x = track * q
        turning = _fading((x - _ROUND[0]) / (_ROUND[1] - _ROUND[0]))
        far = np.maximum(x, 1.0)
        around = turning * j0(x) ** 2 + (1 - turning) * (1 - 1 / (8 * far**2)) / (pi * far)
        early = erf(q[..., None] * np.sqrt(ages))
        late = erf(q[..., None] * np.sqrt(time - ages)) if time < inf else 1.0
        return 2 * (j1(q) / q) ** 2 * around * ((late - early) @ weights)

    start = 1e-12 * min(1.0, 1 / track, 1.0 if isinf(time) else 1 / sqrt(time))
    end = min(6.5 / sqrt(float(ages.min())), max(_SHORT[0], _SHORT[1] * time ** (-1 / 6)))
    turns = (x / track for x in _ROUND if x / track < end)
    return float(of_wave(np.array(start))) * start + _integral(of_wave, (start, *turns, end))


def _integral(integrand: Callable[[Array], Array], breaks: tuple[float, ...]) -> float:
    """Return the integral of a function ≥ 0, smooth in ln x between the breaks."""

    def of_panels(panels: Panels) -> Array:
        x, slope = panels.nodes()
        return (integrand(x) * slope)[None]

    _, values = refine(of_panels, panels_between(np.asarray(breaks)))
    return float((values @ WEIGHTS).sum())
