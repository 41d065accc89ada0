"""What follows beyond the highest cut-off: by a law, with the shape of the theory, or as a power of the cut-off.

Each way has a rest, to be added to the value at the top, and a doubt: how badly it foretold the last step, and never
less than a share of the rest that was measured.
"""

from typing import NamedTuple

import numpy as np

from roughsim.estimate.ladder import Rung
from roughsim.estimate.mean import Mean
from roughsim.grid import Array

# least share of the rest that is in doubt: by the law for contact that yields, with the theory's shape, by a power
OF_LAW, OF_SHAPE, OF_POWER = 0.07, 0.25, 0.2
MOST_OF_SHAPE = 0.5  # of the value: a larger rest with the theory's shape was not tried
USUAL_SCATTER = 0.3  # how far exponents lie from the usual one


class Limit(NamedTuple):
    """What follows beyond the highest cut-off, to be added, and its error, 95 %, (speeds,); NaN: unknown."""

    rest: Mean
    error: Array
    way: str


def by_law(rungs: list[Rung], law: Array) -> Limit:
    """Return what follows where measured/law is constant; `law` has its values at the upper two cut-offs and the end.

    With one rung nothing has tested the law: all of the rest is in doubt.
    """
    top = rungs[-1].mean
    with np.errstate(all="ignore"):  # 0/0 at rest
        rest = top.times(np.nan_to_num(law[-1] / law[-2] - 1.0))
        doubt = np.ones_like(top.value)
        if len(rungs) > 1:
            foretold = law[-2] / law[-3]
            missed = np.abs(top.value / rungs[-2].mean.value - foretold) / np.abs(1.0 - foretold)
            doubt = np.clip(np.nan_to_num(missed), OF_LAW, 1.0)
    return Limit(rest, np.abs(doubt * rest.value), "by the law for contact that yields")


def by_shape(rungs: list[Rung], theory: Array) -> Limit:
    """Return what follows with the theory's shape: as much of it as the last step was of the theory's.

    `theory` has its values at all cut-offs and at the end, (rungs + 1, speeds); NaN where it is not known to hold.
    """
    top = rungs[-1].mean
    with np.errstate(all="ignore"):
        follows = np.where(theory[-1] == theory[-2], 0.0, theory[-1] - theory[-2])  # both infinite at rest
        alike = top.times(np.where(follows == 0.0, 0.0, follows / theory[-2]))
        rest, error = alike, np.abs(alike.value)
        if len(rungs) > 1:
            share = np.where(follows == 0.0, 0.0, follows / (theory[-2] - theory[-3]))
            rest = top.plus(rungs[-2].mean.times(-1.0)).times(share)
            error = np.maximum(np.abs(rest.value - alike.value), OF_SHAPE * np.abs(rest.value))
        tried = np.abs(rest.value) <= MOST_OF_SHAPE * np.abs(top.value)
        nothing = Mean(np.zeros_like(rest.value), {})
        way = "with the shape of the theory" if np.any(tried & (rest.value != 0.0)) else ""
        return Limit(rest.where(tried, nothing), np.where(tried, error, np.nan), way)


def by_power(rungs: list[Rung], end: float, usual: float) -> Limit:
    """Return what follows where T falls as T∞ + c q_c^(−p) up to `end`, rad/m; p by the last two steps, else `usual`.

    The less the steps show of p, by their scatter, the more it is drawn to the usual one. One rung shows no step: what
    follows is unknown.
    """
    top = rungs[-1].mean
    if len(rungs) < 2:
        nothing = np.zeros_like(top.value)
        return Limit(top.times(0.0)._replace(value=nothing), np.full_like(nothing, np.nan), "")
    q = [rung.q_max for rung in rungs[-3:]]
    step = top.plus(rungs[-2].mean.times(-1.0))

    def rest_per_step(p: Array) -> Array:
        return np.asarray((1.0 - (q[-1] / end) ** p) / ((q[-1] / q[-2]) ** p - 1.0))

    exponent, doubt = np.full(top.value.shape, usual), np.full(top.value.shape, USUAL_SCATTER)
    if len(rungs) > 2:
        before = rungs[-2].mean.plus(rungs[-3].mean.times(-1.0))
        with np.errstate(all="ignore"):
            quotient = before.over(step)  # (q₂/q₁)^p, where q₁/q₀ is the same
            rise = np.log(q[-1] / q[-2])
            fitted = np.log(quotient.value) / rise
            scatter = np.sqrt(sum(quotient.variance.values())) / (rise * quotient.value)
            fits = np.isfinite(fitted) & np.isfinite(scatter)
            trust = np.where(fits, 1.0 / (1.0 + (scatter / USUAL_SCATTER) ** 2), 0.0)
            fitted = np.clip(np.where(fits, fitted, usual), 0.3, 3.0)
        exponent = usual + trust * (fitted - usual)
        doubt = np.sqrt(1.0 - trust) * USUAL_SCATTER
    per_step = rest_per_step(exponent)
    rest = step.times(per_step)
    wider = rest_per_step(np.maximum(exponent - doubt, 0.2)) - per_step
    error = np.abs(rest.value) * np.maximum(OF_POWER, wider / per_step)
    return Limit(rest, error, "as q_c^(−p) with p = " + ", ".join(dict.fromkeys(f"{p:.2f}" for p in exponent)))
