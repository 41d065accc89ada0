"""Extrapolation of a mean beyond the highest cut-off: by a law, by the theory, or as a power of the cut-off.

Each returns the rest beyond the highest cut-off, to be added, with its error "bandwidth", NaN if unknown, and gives a
shape over the cut-off. The mean is proportional to the shape, or its steps to the steps of the shape. The
error is the difference of the two results, and at least a share of the rest, the change beyond the highest cut-off. By
the law the two add as squares: by chance of few members the difference may vanish. Towards a bound the error is by the
exponent alone.
"""

from dataclasses import replace
from math import log

import numpy as np

from roughsim.estimate.mean import Mean, exact
from roughsim.estimate.telescoping import LevelMean
from roughsim.grid import Array
from roughsim.scene.numerics import SAME

# share of the rest that is uncertain, as measured: by the law for contact that yields, and at least by steps
_OF_LAW = 0.1
_OF_STEPS = 0.25
# of T_flash, by the law of elastic contact: what slow sliding gains an octave is so small a difference that the law
# misses .1 to .3 % of T_flash in it, the most at light loads; its splines, of knots e-folds apart, jump by .1 %
_OF_ELASTIC = 0.004
# of T_flash by the theory's shape: steps over those of the theory fall by a fifth an octave in wide spectra, so that .6
# to 1 of the rest by its steps follows
OF_SHAPE = 0.5
_STEP = 1e-4  # of an exponent, for slopes
_MOST_BY_STEPS = 0.5  # of the value: a larger rest with the theory's shape was not tried
_USUAL_SCATTER, _LEAST_EXPONENT = (
    0.3,
    0.2,
)  # how far exponents lie from the usual one, and the least of them


def by_law(levels: list[LevelMean], law: Array, elastic: bool = False) -> Mean:
    """Return the rest in proportion to a law; `law` has its values at the upper two cut-offs and at the end.

    The error is the uncertainty of any law, and how badly it predicted the last step, as squares. One level tests no
    law: its error is all of the rest. Of `elastic` contact what the law does not resolve adds as squares.
    """
    rest = _in_proportion(levels, law)
    size = np.abs(rest.value)
    error = size
    if len(levels) > 1:
        apart = np.nan_to_num(np.abs(rest.value - _by_steps(levels, law).value))
        error = np.minimum(np.hypot(apart, _OF_LAW * size), size)
    if elastic:
        error = np.hypot(error, _OF_ELASTIC * levels[-1].mean.value)
    return replace(rest, errors={"bandwidth": error}, way="by the calibrated law")


def by_shape(levels: list[LevelMean], theory: Array, least: float = 0.0) -> Mean:
    """Return the rest by steps of the theory; after one step half of it is uncertain, and the share `least` or more.

    What is zero up to here, as where nothing yields yet, may rise as much as the theory.
    `theory` has its values at all cut-offs and at the end, (levels + 1, speeds); NaN outside its known range.
    """
    rest = alike = _in_proportion(levels, theory)
    error = np.abs(alike.value)
    if len(levels) > 1:
        rest = _by_steps(levels, theory)
        share = max(least, _OF_STEPS, 0.5 ** (len(levels) - 1))
        error = np.maximum(np.abs(rest.value - alike.value), share * np.abs(rest.value))
    top = levels[-1].mean.value
    with np.errstate(invalid="ignore"):  # infinite at rest
        rise = np.abs(theory[-1] - theory[-2])
        error = np.where(top == 0.0, rise, error)
    tried = np.abs(rest.value) <= _MOST_BY_STEPS * np.abs(top)
    has_rest = np.any(tried & (rest.value != 0.0))
    way = "with the shape of the theory" if has_rest else ""
    rest = rest.where(tried, exact(np.zeros_like(rest.value)))
    return replace(rest, errors={"bandwidth": np.where(tried, error, np.nan)}, way=way)


def by_steps(levels: list[LevelMean], law: Array) -> Mean:
    """Return the rest by steps of a law that a part of the mean alone follows; `law` as of `by_law`.

    One level shows no step: it is continued in proportion, and all of the rest is its error.
    """
    rest = alike = _in_proportion(levels, law)
    error = np.abs(alike.value)
    if len(levels) > 1:
        rest = _by_steps(levels, law)
        size = np.abs(rest.value)
        error = np.clip(np.abs(rest.value - alike.value), _OF_STEPS * size, size)
    way = "by steps of T_flash by the calibrated law"
    return replace(rest, errors={"bandwidth": error}, way=way)


def by_power(levels: list[LevelMean], end: float, usual: float) -> Mean:
    """Return the rest of T∞ + c q_c^(−p) up to `end`, rad/m, from two levels or more.

    p is the mean of the usual exponent and the exponent of the last two steps, weighted by their inverse variances.
    Steps that hardly shrink, grow or turn have the least exponent. As exponents rise to the usual one along the levels,
    the error reaches up to it, and as far below p as its scatter. At least a share of the rest is uncertain: all of it
    after one step, which shows no exponent; the more the steps show, the closer to half of it after two and to
    `_OF_STEPS` after more. What the realizations scatter in p stays with them.
    """
    q = np.array([level.q_max for level in levels[-2:]] + [end])[:, None]
    shape = levels[-1].mean.value.shape
    power = exact(np.full(shape, usual))
    weight = np.zeros(shape)
    if len(levels) > 2:
        low, middle, top = (level.mean for level in levels[-3:])
        with np.errstate(all="ignore"):
            quotient = (middle - low) / (top - middle)  # (q₂/q₁)^p
        power, weight = _exponent(quotient, q[1] / q[0], usual, _LEAST_EXPONENT)
    exponent = power.value
    slower = np.maximum(exponent - np.sqrt(1.0 - weight) * _USUAL_SCATTER, _LEAST_EXPONENT)
    faster = np.maximum(exponent, usual)
    near = exponent - _STEP, exponent + _STEP
    rest, below, above, *others = (
        _by_steps(levels, q**-p) for p in (exponent, *near, slower, faster)
    )
    apart = [np.abs(other.value - rest.value) for other in others]
    shown = max(_OF_STEPS, 0.5 ** (len(levels) - 2))
    least = 1.0 + weight * (shown - 1.0)
    error = np.maximum.reduce([*apart, least * np.abs(rest.value)])
    way = f"as q_c^(−p) with p = {_in_words(exponent)}"
    nothing = np.zeros(shape)
    rest += power.through(nothing, nothing, (above.value - below.value) / (2.0 * _STEP))
    return replace(rest, errors={"bandwidth": error}, way=way)


def by_bound(levels: list[LevelMean], end: float, bound: float) -> Mean:
    """Return the rest of a mean whose distance to an exact bound falls as q_c^(−p) up to `end`, rad/m, from two levels.

    p is the mean of 1 and the exponent of the last two distances, weighted by their inverse variances, and not below
    0. The error is by an exponent that is `_USUAL_SCATTER` off; what the realizations scatter in p stays with them.
    """
    low, high = (level.mean - bound for level in levels[-2:])
    step, further = levels[-1].q_max / levels[-2].q_max, end / levels[-1].q_max
    power, _ = _exponent(low / high, step, 1.0, -np.inf)
    exponent = np.maximum(power.value, 0.0)
    off = np.maximum(exponent + np.array([[0.0], [-_USUAL_SCATTER], [_USUAL_SCATTER]]), 0.0)
    left, slower, faster = further**-off
    error = np.abs(high.value) * np.maximum(slower - left, left - faster)
    way = f"towards its bound as q_c^(−p) with p = {_in_words(exponent)}"
    nothing = np.zeros_like(left)
    with np.errstate(invalid="ignore"):
        slope = np.where(exponent * left > 0.0, -high.value * left * log(further), 0.0)
    rest = high * (left - 1.0) + power.through(nothing, nothing, slope)
    return replace(rest, errors={"bandwidth": error}, way=way)


def _exponent(
    quotient: Mean, ratio: Array | float, usual: float, least: float
) -> tuple[Mean, Array]:
    """Return p ≥ `least` of a quotient `ratio`^p, drawn to the usual one by its scatter, and its weight."""
    with np.errstate(all="ignore"):
        shown = np.maximum(quotient.value, ratio**least)
        fitted = np.log(shown) / np.log(ratio)
        own = np.sqrt(sum(quotient.variance.values())) / (np.log(ratio) * shown)
        weight = np.nan_to_num(1.0 / (1.0 + (own / _USUAL_SCATTER) ** 2))
        value = np.where(weight > 0.0, usual + weight * (fitted - usual), usual)
        free = (weight > 0.0) & (quotient.value > shown * (1 - SAME))
        power = quotient.through(value, value, weight / (np.log(ratio) * shown))
    return power.where(free, exact(value)), weight


def _in_words(exponent: Array) -> str:
    """Return the exponents of all speeds, each once."""
    return ", ".join(dict.fromkeys(f"{p:.2f}" for p in exponent))


def _in_proportion(levels: list[LevelMean], shape: Array) -> Mean:
    """Return the rest of a mean that stays in proportion to the shape."""
    with np.errstate(invalid="ignore"):  # zero up to here, of a shape that begins to rise
        return levels[-1].mean * _follows(shape, shape[-2])


def _by_steps(levels: list[LevelMean], shape: Array) -> Mean:
    """Return the rest of a mean whose steps stay in proportion to the steps of the shape."""
    with np.errstate(invalid="ignore"):  # infinite at rest
        step = levels[-1].mean - levels[-2].mean
        return step * _follows(shape, shape[-2] - shape[-3])


def _follows(shape: Array, over: Array) -> Array:
    """Return the step of a shape to its end, over another number; zero if both ends are equal, finite or not."""
    with np.errstate(all="ignore"):
        return np.where(shape[-1] == shape[-2], 0.0, (shape[-1] - shape[-2]) / over)
