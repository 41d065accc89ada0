"""Limit of a ladder of cut-offs or pixels, by regression over the members that its rungs share, with its errors.

Beyond the last rung each step is a share of the one before, from the last two steps. For fast sliding that share goes
over to its slow value where q_c/q_r passes the Péclet number. The error has the scatter of every rung, the change by
the last one, and a part of the steps beyond.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import t as student

LONGEST, SHORTEST = (
    0.2,
    0.8,
)  # bounds of a step of the ladder over the one before: exponents 2.3 ... 0.3
REST_DOUBT = 0.1  # of what lies beyond the ladder, beside what its last rung changed of the limit
CROSSED = 5.0  # q_c/q_r over the Péclet number at which the share of a step is halfway to that of slow sliding
OCTAVES = 80  # that are followed
UNTRIED = 0.5  # of it with three rungs: no limit without the last one is there


class LadderEnd(NamedTuple):
    """Where a ladder goes to: ln Q, its 95 % errors from the scatter of each rung, its doubt, ln Q of the last rung."""

    value: float
    scatter: Any
    doubt: float
    last: float


def ladder_end(levels: list[Any], slow: list[Any] | None = None, place: float = 0.0) -> LadderEnd:
    """Return the end of a ladder from ln Q of the members of each rung; `slow`: T_flash at rest, `place` as `_end`."""
    first, steps, scatter = chain(levels)
    resting = steps if slow is None else chain(slow)[1]
    value = _end(steps, resting, place)
    slopes = (
        np.array(
            [
                _end(steps + unit, resting + unit, place) - value
                for unit in 1e-5 * np.eye(steps.size)
            ]
        )
        / 1e-5
    )
    total = scatter[0] + slopes @ np.diff(scatter, axis=0)
    rest = value - steps.sum()
    doubt = UNTRIED * rest
    if steps.size > 2:
        doubt = np.hypot(value - _end(steps[:-1], resting[:-1], place / 2), REST_DOUBT * rest)
    return LadderEnd(first + value, total, float(abs(doubt)), first + float(steps.sum()))


def chain(levels: list[Any]) -> tuple[float, Any, Any]:
    """Return ln Q of the first rung, the steps to the others, and their 95 % errors by independent causes."""
    steps, scatter = np.empty(len(levels) - 1), np.zeros((len(levels), len(levels)))
    first = here = float(levels[0].mean())
    scatter[0, 0] = half_width(levels[0])
    for k, (coarse, fine) in enumerate(pairwise(levels)):
        steps[k], slope, own = _step(coarse[: fine.size], fine, here)
        scatter[k + 1] = (1.0 + slope) * scatter[k]
        here, scatter[k + 1, k + 1] = here + steps[k], own
    return first, steps, scatter


def _step(coarse: Any, fine: Any, level: float) -> tuple[float, float, float]:
    """Return the step between rungs where the coarse one is `level`, how it goes with it, and its own 95 % error."""
    change, n = fine - coarse, fine.size
    slope = (
        float(np.cov(change, coarse)[0, 1] / coarse.var(ddof=1)) if coarse.std() > 1e-12 else 0.0
    )
    rest = change - slope * (coarse - level)
    return (
        float(rest.mean()),
        slope,
        float(student.ppf(0.975, n - 2) * rest.std(ddof=2) / np.sqrt(n)),
    )


def _end(steps: Any, slow: Any, place: float) -> float:
    """Return ln of the limit over the first rung; `slow`: steps at rest, `place`: q_c/q_r over the Péclet number."""
    (last, share), (_, least) = _last(steps), _last(slow)
    total, share_now = 0.0, last
    for octave in range(1, OCTAVES):
        over = (1.0 + (place / CROSSED) ** 2) / (1.0 + (place * 2.0**octave / CROSSED) ** 2)
        share_now *= least + (share - least) * over
        total += share_now
    return float(np.log(np.exp(steps.sum()) + total))


def _last(steps: Any) -> tuple[float, float]:
    """Return the last step of Q itself, and its share of the one before."""
    q = np.exp(np.concatenate([[0.0], np.cumsum(steps)]))
    last, before = q[-1] - q[-2], q[-2] - q[-3]
    return float(last), float(
        np.clip(last / before, LONGEST, SHORTEST)
    ) if before != 0.0 else LONGEST


def half_width(members: Any) -> float:
    return float(student.ppf(0.975, members.size - 1) * members.std(ddof=1) / np.sqrt(members.size))
