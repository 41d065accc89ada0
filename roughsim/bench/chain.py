"""The whole chain: error of the ensemble's estimates over their cost, for every split of the same members.

All levels are solved for the same few realizations. Scatter and bias found there give the error of any number of
realizations, of single grids, and of ladders with few fine members: error² = bias² + standard error² · found/n +
doubt². The bias is against all levels and members; the doubt is what their extrapolation and their pixels leave.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from math import hypot, nan, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.bench.point import Point
from roughsim.estimate import standard_error
from roughsim.ladder import Values, observe
from roughsim.means import Sample
from roughsim.numerics import Level, Numerics
from roughsim.realization import Realization, realize

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
    ways = _ways(given, realizations)
    for observable, name in zip(OBSERVABLES, _NAMES, strict=True):
        if name == "pressure_variance" and not scene.elastic:
            continue  # fixed by force balance
        slowest = observable.endswith("slowest")
        speed = int(np.argmin(scene.speeds)) if slowest else int(np.argmax(scene.speeds)) if "fast" in observable else 0
        if slowest and min(scene.speeds) == max(scene.speeds):
            continue
        yield from _curves(scene, given, members, ways, numerics, (observable, name, speed))


def _kept(one: Realization, seconds: float) -> _Member:
    seen = one.observables
    numbers = {
        "flash_temperature": seen.flash_temperature,
        "contact_fraction": np.array([one.contact.contact_fraction]),
        "pressure_variance": np.array([seen.pressure_variance]),
    }
    return _Member(numbers, seen.stress_spectrum.wavenumber, seen.stress_spectrum.variance, seconds)


def _ways(given: list[Level], realizations: int) -> list[_Way]:
    """Each grid alone, each ladder from the first rung up, and the whole ladder with few fine members."""
    cuts = sorted({level.q_max for level in given})
    rungs = [[i for i, level in enumerate(given) if level.q_max == cut] for cut in cuts]
    coarsest = [rung[0] for rung in rungs]
    ways = [_Way(f"one grid, {_told(level, given[0])}", (i,), 1) for i, level in enumerate(given)]
    ways += [_Way(f"{k} cut-offs, all levels", tuple(coarsest[:k]), 1) for k in range(2, len(cuts) + 1)]
    everything, planned = tuple(range(len(given))), given[-1].every
    strides = sorted({1, 2, 4, planned}) if len(given) > 1 else [1]
    for every in strides:
        if realizations // every >= 2:
            name = "the plan's levels" + (f", fine ones 1 in {every}" if every > 1 else ", all of them")
            ways.append(_Way(name, everything, every, every == planned))
    return [way for way in ways if len(way.levels) > 1 or len(given) > 1 or way is ways[0]]


def _told(level: Level, base: Level) -> str:
    return f"{level.q_max / base.q_max:.3g}× q_c, {level.shape[0]}²"


def _curves(
    scene: Scene,
    given: list[Level],
    members: dict[int, list[_Member]],
    ways: list[_Way],
    numerics: Numerics,
    what: tuple[str, str, int],
) -> Iterator[Point]:
    """A curve over the number of realizations for each way; the truth is that of all levels and realizations."""
    observable, name, speed = what
    capped, end = not scene.elastic, scene.spectrum.breaks[-1]
    reach = 0.5 * float(np.hypot(*numerics.lengths))

    def values_of(way: _Way) -> Values:
        first = way.levels[0]
        samples = [_sample(given[i], members[i], 1 if i == first else way.every, reach) for i in way.levels]
        return observe(name, samples, capped=capped, end=end)

    whole = values_of(_Way("", tuple(members), 1))
    truth, count = float(whole.extrapolated[:, speed].mean()), len(members[0])
    doubt = float(np.hypot(*np.nan_to_num([whole.bandwidth[speed], whole.pixel[speed]])))
    yield Point("chain", observable, KNOWN, "", doubt / abs(truth), nan)
    for way in ways:
        found = values_of(way)
        rows = found.extrapolated[:, speed]
        error, bias = float(standard_error(rows[:, None], found.group)[0]), float(rows.mean()) - truth
        planned = numerics.forecast.realizations if numerics.forecast is not None and way.chosen else 0
        for n in sorted({*(k for k in COUNTS if k >= 2 * way.every), planned} - {0}):
            relative = hypot(bias, error * sqrt(count / n), doubt) / abs(truth)
            cost = float(sum(n_of * np.median([m.seconds for m in members[i]]) for i, n_of in way.counts(n)))
            yield Point("chain", observable, way.method, f"{n} realizations", relative, cost, n == planned)


def _sample(level: Level, members: list[_Member], every: int, reach: float) -> Sample:
    there = np.arange(0, len(members), every, dtype=np.intp)
    chosen = [members[i] for i in there]
    numbers = {name: np.stack([m.numbers[name] for m in chosen]) for name in chosen[0].numbers}
    spectrum = np.stack([m.spectrum for m in chosen])
    return Sample(level.q_max, float(level.shape[0]), there, numbers, chosen[0].wavenumber, spectrum, reach)
