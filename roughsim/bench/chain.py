"""The whole chain: error of the ensemble's estimates over their cost, for every split of the same members.

All levels are solved for the same few realizations. Scatter and bias found there give the error of any number n of
realizations, of single grids, and of ladders with few fine members: error² = bias² + variance/n + doubt². The bias is
against all levels and members; the doubt is what their extrapolation and their pixels leave.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from math import hypot, nan, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.charts.error_over_cost import Point
from roughsim.estimate.ladder import Values, observe
from roughsim.observables.record import Sample
from roughsim.realization import Realization, realize
from roughsim.scene.numerics import Level, Numerics

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
_SEED = 21
KNOWN = "doubt"  # the method of a point that says how well the limit itself is known
COUNTS = (4, 8, 16, 32, 64, 128, 256)
OBSERVABLES = ("T_flash, fastest", "T_flash, slowest", "contact area", "pressure variance", "r at g = 0.1 g(0)")
_NAMES = ("flash_temperature", "flash_temperature", "contact_fraction", "pressure_variance", "correlation_radius_10")


class _Way(NamedTuple):
    """A choice of levels, each solved for every `every`-th realization."""

    method: str
    levels: tuple[int, ...]
    every: int
    chosen: bool = False

    def counts(self, realizations: int) -> list[tuple[int, int]]:
        """How many members each level has."""
        return [(i, -(-realizations // (1 if i == self.levels[0] else self.every))) for i in self.levels]


class _Member(NamedTuple):
    numbers: dict[str, Array]
    wavenumber: Array
    spectrum: Array
    seconds: float


def chain(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Every observable that has a limit in the cut-off, over the splits of the cost that a ladder allows."""
    column = "elastic" if scene.elastic else "capped"
    given = [numerics.levels[i] for i in numerics.of_column(column)]
    solved = replace(numerics, levels=tuple(replace(level, every=1) for level in given))
    members: dict[int, list[_Member]] = {}
    for level in range(len(given)):
        realize(scene, solved, seed=_SEED, level=level, index=realizations)  # plans and kernels
        members[level] = []
        for index in range(realizations):
            start = time.process_time()
            one = realize(scene, solved, seed=_SEED, level=level, index=index)
            members[level].append(_kept(one, time.process_time() - start))
    reach, end = 0.5 * float(np.hypot(*numerics.lengths)), scene.spectrum.breaks[-1]
    fastest, slowest = int(np.argmax(scene.speeds)), int(np.argmin(scene.speeds))
    for observable, name in zip(OBSERVABLES, _NAMES, strict=True):
        if name == "pressure_variance" and not scene.elastic:
            continue  # fixed by force balance
        if observable == "T_flash, slowest" and not 0.0 < scene.speeds[slowest] < scene.speeds[fastest]:
            continue
        speed = {"T_flash, fastest": fastest, "T_flash, slowest": slowest}.get(observable, 0)
        found = _Found(given, members, reach, name, speed, not scene.elastic, end)
        yield from _curves(found, numerics, observable)


def _kept(one: Realization, seconds: float) -> _Member:
    seen = one.observables
    numbers = {
        "flash_temperature": seen.flash_temperature,
        "contact_fraction": np.array([one.contact.contact_fraction]),
        "pressure_variance": np.array([seen.pressure_variance]),
    }
    return _Member(numbers, seen.stress_spectrum.wavenumber, seen.stress_spectrum.variance, seconds)


def _ways(given: list[Level]) -> list[_Way]:
    """Each grid alone, each ladder from the first rung up, and the whole ladder with few fine members."""
    if len(given) == 1:
        return [_Way("the plan's level", (0,), 1, True)]
    cuts = sorted({level.q_max for level in given})
    coarsest = [next(i for i, level in enumerate(given) if level.q_max == cut) for cut in cuts]
    ways = [_Way(f"one grid, {_told(level, given[0])}", (i,), 1) for i, level in enumerate(given)]
    ways += [_Way(f"{k} cut-offs, all levels", tuple(coarsest[:k]), 1) for k in range(2, len(cuts) + 1)]
    planned = given[-1].every
    for every in sorted({1, 2, 4, planned}):
        name = "the plan's levels" + (f", fine ones 1 in {every}" if every > 1 else ", all of them")
        ways.append(_Way(name, tuple(range(len(given))), every, every == planned))
    return ways


def _told(level: Level, base: Level) -> str:
    return f"{level.q_max / base.q_max:.3g}× q_c, {level.shape[0]}²"


class _Found(NamedTuple):
    """What all members tell of one observable at one speed."""

    given: list[Level]
    members: dict[int, list[_Member]]
    reach: float
    name: str
    speed: int
    capped: bool
    end: float

    def values(self, levels: tuple[int, ...]) -> Values:
        samples = [_sample(self.given[i], self.members[i], self.reach) for i in levels]
        return observe(self.name, samples, capped=self.capped, end=self.end)

    def rows(self, levels: tuple[int, ...]) -> Array:
        rows: Array = self.values(levels).extrapolated[:, self.speed]
        return rows

    def variance(self, way: _Way) -> float:
        """Of the mean, times the realizations: few fine members scatter more, ⟨T₀⟩ over all + ⟨T − T₀⟩ over few."""
        base, rest = self.rows(way.levels[:1]), self.rows(way.levels)
        rest = rest - base
        (own, shared), (_, change) = np.cov(base, rest)
        return float(own + 2 * shared + way.every * change)

    def cost(self, way: _Way, realizations: int) -> float:
        """CPU seconds of so many realizations."""
        each = {i: float(np.median([m.seconds for m in self.members[i]])) for i in way.levels}
        return sum(count * each[i] for i, count in way.counts(realizations))


def _curves(found: _Found, numerics: Numerics, observable: str) -> Iterator[Point]:
    """A curve over the number of realizations for each way; the truth is that of all levels and realizations."""
    whole = found.values(tuple(found.members))
    truth = float(whole.extrapolated[:, found.speed].mean())
    doubt = float(np.hypot(*np.nan_to_num([whole.bandwidth[found.speed], whole.pixel[found.speed]])))
    yield Point("chain", observable, KNOWN, "", doubt / abs(truth), nan)
    for way in _ways(found.given):
        variance, bias = found.variance(way), float(found.rows(way.levels).mean()) - truth
        planned = numerics.forecast.realizations if numerics.forecast is not None and way.chosen else 0
        for n in sorted({*(k for k in COUNTS if k >= 2 * way.every), planned} - {0}):
            error = hypot(bias, sqrt(variance / n), doubt) / abs(truth)
            setting = f"{n} realizations"
            yield Point("chain", observable, way.method, setting, error, found.cost(way, n), n == planned)


def _sample(level: Level, members: list[_Member], reach: float) -> Sample:
    numbers = {name: np.stack([m.numbers[name] for m in members]) for name in members[0].numbers}
    spectrum, rows = np.stack([m.spectrum for m in members]), np.arange(len(members), dtype=np.intp)
    return Sample(level.q_max, float(level.shape[0]), rows, numbers, members[0].wavenumber, spectrum, reach)
