"""From the levels of a column to one value: fine levels as corrections, extrapolation in q_c, and the pixel.

A ladder climbs in the cut-off q_c at fixed pixels per shortest wave. A rung is one cut-off: its level, and, where there
is one, a second level of the same q_c on a finer grid, its partner. Levels share the modes of each realization, so that
the difference between neighbours scatters little and a few realizations give it: T = ⟨T₀⟩ + ⟨T₁ − T₀⟩ + … over nested
subsets (multilevel Monte Carlo, Giles, Operations Research 56, 607, 2008). In capped contact a surface whose T₀ is high
by chance has as much higher a T₁, and ratios scatter less: T = ⟨T₀⟩ ⟨T₁⟩/⟨T₀⟩ … Along the ladder the pixel shrinks
with 1/q_c, so that T∞ + c q_c^(−p) takes most of its error along.

Levels in a part of the cell have surfaces of their own. They start from a level that repeats the highest one of the
run's cell, and only their ratios to it and to each other are used: those hardly depend on the cell.
"""

from collections.abc import Callable
from itertools import pairwise
from math import inf, isnan, nan, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.continuation import Rung, remainder_by_power, remainder_by_theory, the_surer
from roughsim.estimate.regression import at_mean_peak_volume, slopes_of
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics

# capped contact has steep edges of its plastic patches: these have no limit in q_c and are never extrapolated
NO_LIMIT = tuple(name for name, record in OBSERVABLES.items() if not record.limit)
# lengths that turn back with the pixel: beyond 8 pixels per wave they went on by 0.2 to 1.5 of the change from 4 to 8
TURNING = 1.5
LAW_TESTED = 32.0  # of `settled`: up to there it was, with four pixels per wave on all rungs
SAME = 1e-9  # relative: wavenumbers that differ by less are the same


class Values(NamedTuple):
    """One observable: a row per realization, (n, speeds), in the limit and at the finest level, with its errors.

    Rows with the same number in `group` (n,) have the same levels, those with 0 the coarsest alone. `base` has the rows
    of the coarsest level, brought to the mean of `extrapolated`: the rest of the scatter is that of finer levels.
    `exponent`, `bandwidth` and `pixel` (speeds,) are the fitted p (NaN if nothing was extrapolated), and the errors
    left in the mean by q_c and by the pixel; NaN where no pair of levels shows them. `from_part` (speeds,) is the share
    of the mean that comes from levels in a part of the cell. With `independent` all finer levels are of that kind: they
    do not scatter with the coarsest one. `slopes` is how many the regression on the peak volumes has fitted to rows.
    `last_step` (speeds,) is what the last rise of q_c has changed where nothing continues it, although there is a
    limit; else 0.
    """

    extrapolated: Array
    finest: Array
    base: Array
    group: NDArray[np.intp]
    exponent: Array
    bandwidth: Array
    pixel: Array
    from_part: Array | float = 0.0
    independent: bool = False
    slopes: int = 0
    last_step: Array | float = 0.0


def values_of(
    scene: Scene,
    column: str,
    observable: str,
    samples: list[Sample],
    *,
    extrapolated: bool = True,
    continued: bool = True,
) -> Values:
    """Return the values of an observable from the levels of a column, coarsest first, with all heat in the moving body.

    They are those in the limit that the theory or the levels show, or else, not extrapolated, of the highest cut-off.
    Not `continued`, they are extrapolated in the pixel alone, and what shorter waves change is unknown.
    """
    if observable == "heat_partition":
        samples = [prediction.balanced(scene, sample) for sample in samples]
    cut_offs = tuple(sorted({sample.q_max for sample in samples}))
    end = scene.spectrum.breaks[-1] if extrapolated else cut_offs[-1]
    theory, fall = None, dict[str, Any]()
    if cut_offs[-1] < end * (1 - SAME):
        not_known = np.full((len(cut_offs) + 1, 1), nan)
        theory = prediction.continuation(scene, column, cut_offs, observable) if continued else not_known
    if column == "capped" and theory is None:  # it has yielded, and falls as a power of the cut-off from 4 q_y on
        fall["settled"] = 4.0 * prediction.yield_wavenumber(scene)
        fall["usual"] = prediction.usual_exponent(scene, cut_offs[-1])
        if observable == "flash_temperature" and len(cut_offs) > 1 and cut_offs[-1] < end * (1 - SAME):
            fall["law"] = prediction.yielded_fall(scene, cut_offs[-2:])
    values = observe(observable, samples, capped=column == "capped", end=end, theory=theory, **fall)
    at_rest = OBSERVABLES[observable].at_rest
    if at_rest is None:
        return values
    # members are measured at a tiny speed instead of at rest: there the exact limit counts, without error
    moving = np.array(scene.speeds) > 0.0
    exact: dict[str, Any] = dict.fromkeys(("extrapolated", "finest", "base"), at_rest)
    exact |= {"bandwidth": 0.0, "pixel": 0.0, "last_step": 0.0}
    return values._replace(**{key: np.where(moving, getattr(values, key), x) for key, x in exact.items()})


def observe(
    observable: str,
    samples: list[Sample],
    *,
    capped: bool,
    end: float = inf,
    theory: Array | None = None,
    settled: float = 0.0,
    usual: float = 1.0,
    law: Array | None = None,
) -> Values:
    """Return the values of an observable from the levels of one column, by q_c, then by points.

    Those in a part of the cell come last. The first level has every realization. They are extrapolated to `end`,
    rad/m, where C(q) ends: with the shape of `theory`, which has what the theory says at each cut-off and at `end`,
    (cut-offs + 1, speeds) or of one speed, NaN where it is not known to hold; without it as a power of the cut-off.
    `settled`, rad/m, is the cut-off from which on steps show that power, as it rises on the way up; `usual` is the
    power where they do not. `law` has what the law for contact that yields says at the upper two cut-offs and at `end`,
    (3, speeds), to continue where that is surer.
    """
    record, with_ratio = OBSERVABLES[observable], have_ratios(observable, samples, capped=capped)
    ladder = climb(record.of_level, samples, with_ratio)
    first, top = ladder[0].rows, ladder[-1].rows
    has_limit = record.limit or not capped
    order = record.pixel_orders[capped]
    at_end = ladder[-1].sample.q_max >= end * (1 - SAME)
    finest, exponent = top, np.full(top.shape[1:], nan)
    if at_end or not has_limit or theory is not None or len(ladder) == 1:
        limit, finest, pixel = at_highest_cut_off(ladder, order, has_limit)
        bandwidth = np.full_like(exponent, 0.0 if at_end else nan)
        if theory is not None and has_limit and not at_end:
            remainder, bandwidth = remainder_by_theory(ladder, limit, theory)
            limit = limit + remainder
    elif record.distance and ladder[-2].rows.mean() * ladder[-2].sample.q_max < 2.0 * pi:
        # a distance shorter than the shortest wave: no power describes what follows. The value stays, and what would
        # follow at first order, the last step, is its error
        limit, pixel = top, pixel_of_limit(ladder, order)
        bandwidth = np.abs((top - ladder[-2].rows).mean(axis=0))
    else:
        exponent, remainder, bandwidth = remainder_by_power(ladder, end, settled, usual)
        if law is not None:
            exponent, remainder, bandwidth = the_surer((exponent, remainder, bandwidth), ladder, law)
        until = min(end, LAW_TESTED * settled)
        limit, pixel = top + remainder, pixel_of_limit(ladder, order, np.isnan(exponent), until)
    with np.errstate(all="ignore"):  # infinite at rest
        mean = limit.mean(axis=0)
        factor = np.divide(mean, first.mean(axis=0), out=np.ones_like(mean), where=with_ratio)
        base = mean + factor * (first - first.mean(axis=0))
        start = next((rung for rung in ladder if rung.sample.part), None)  # its rows are still those of the run's cell
        added = np.zeros_like(mean) if start is None else np.abs(mean - start.rows.mean(axis=0))
    from_part = np.divide(added, np.abs(mean), out=np.zeros_like(mean), where=added > 0.0)
    last = last_step(ladder, np.isnan(bandwidth) & has_limit)
    ties = ties_of(samples)
    return Values(limit, finest, base, group_of(samples), exponent, bandwidth, pixel, from_part, *ties, last)


def last_step(ladder: list[Rung], where: NDArray[np.bool_]) -> Array:
    """Return what the last rise of the cut-off changes, (speeds,); 0 elsewhere, and where there is one cut-off."""
    if len(ladder) < 2:
        return np.zeros(where.shape)
    with np.errstate(invalid="ignore"):  # both infinite at rest
        step = np.abs((ladder[-1].rows - ladder[-2].rows).mean(axis=0))
    return np.where(where, np.nan_to_num(step), 0.0)


def group_of(samples: list[Sample]) -> NDArray[np.intp]:
    """Return `group` of `Values`: levels are nested, so that their number is the pattern of those of a realization."""
    group = np.zeros(len(samples[0].rows), dtype=np.intp)
    for sample in samples[1:]:
        group[sample.rows] += 1
    return group


def ties_of(samples: list[Sample]) -> tuple[bool, int]:
    """Return `independent` and `slopes` of `Values`."""
    count = len(samples[0].rows)
    independent = any(sample.part for sample in samples) and all(sample.part for sample in samples[1:])
    return independent, max(slopes_of(sample.numbers, count) for sample in samples if at_mean(sample, count))


def climb(of_level: Callable[[Sample], Array], samples: list[Sample], with_ratio: NDArray[np.bool_]) -> list[Rung]:
    """Return the rungs with rows for all realizations: those of the rung below, `corrected` by what is known.

    `of_level` gives the values of a level, (n, any). Where all realizations have a level, its rows are at the mean peak
    volume; the corrections hardly follow it.
    """
    count = len(samples[0].rows)
    ladder: list[Rung] = []
    for sample in samples:
        if sample.part and not ladder[-1].sample.part:  # it repeats the rung: the differences that follow start from it
            ladder[-1] = ladder[-1]._replace(sample=sample)
            continue
        rows = of_level(sample)
        if at_mean(sample, count):
            rows = at_mean_peak_volume(rows, sample.numbers)
        else:
            below = ladder[-1]
            low = of_level(below.sample.at(sample.rows))
            rows = corrected(below.rows, low, rows, sample.rows, with_ratio)
        if ladder and sample.q_max <= ladder[-1].sample.q_max * (1 + SAME):
            below = ladder[-1]
            ladder[-1] = below._replace(partner=rows, refined=sample.side / below.sample.side)
        else:
            ladder.append(Rung(sample, rows))
    return ladder


def have_ratios(observable: str, samples: list[Sample], *, capped: bool) -> NDArray[np.bool_]:
    """Return where levels are corrected by ratios, (speeds,): in capped contact, where all values have one sign.

    In elastic contact differences may scatter less: T_flash of rubber at its highest speed by a half.
    """
    values = np.concatenate([OBSERVABLES[observable].of_level(sample) for sample in samples])
    with np.errstate(invalid="ignore"):  # infinite at rest
        return np.asarray(capped & np.all(np.isfinite(values) & (values * values[0] > 0.0), axis=0))


def corrected(rows: Array, low: Array, high: Array, indices: NDArray[np.intp], with_ratio: NDArray[np.bool_]) -> Array:
    """Return the rows of a rung for all realizations: those of the rung below, corrected from `low` to `high`.

    These are the values of both rungs for the realizations `indices`, or for others in a part of the cell. All rows are
    multiplied by ⟨high⟩/⟨low⟩, or moved by the mean difference; those that have both also by their own, as much as they
    stand for. A ratio is biased by about the squared relative scatter over their number: a small part of its error.
    """
    mean, low_mean = rows.mean(axis=0), low.mean(axis=0)
    factor, scale = (
        np.divide(above, low_mean, out=np.ones_like(mean), where=with_ratio) for above in (high.mean(axis=0), mean)
    )
    change = scale * (high - factor * low)
    moved: Array = factor * rows + change.mean(axis=0)
    moved[indices] += len(rows) / len(high) * (change - change.mean(axis=0))
    return moved


def at_mean(sample: Sample, count: int) -> bool:
    """Return whether a level is taken at the mean peak volume: that of the run's cell that all realizations have."""
    return len(sample.rows) == count and not sample.part


def at_highest_cut_off(ladder: list[Rung], order: float, has_limit: bool) -> tuple[Array, Array, Array]:
    """Return the values for a vanishing pixel, those of the finest grid, and the error of the pixel (NaN: unknown)."""
    top = ladder[-1]
    rung = next((rung for rung in reversed(ladder) if rung.partner is not None), None)
    if rung is None or rung.partner is None:
        return top.rows, top.rows, np.full(top.rows.shape[1:], nan)
    finest = rung.partner if rung is top else top.rows
    change = rung.partner - rung.rows
    left = change * (vanishing_pixel(order, rung.refined) - 1.0)
    with np.errstate(all="ignore"):
        # the change on a lower rung is carried to the top in proportion to the values
        carried = np.where(rung is top, 1.0, top.rows.mean(axis=0) / rung.rows.mean(axis=0))
        carried = np.where(np.any(change, axis=0), carried, 0.0)  # 0/0 where nothing yields
        if not has_limit:  # the relative change is the error, and nothing is corrected
            share = np.abs((change + left).mean(axis=0) / rung.rows.mean(axis=0))
            return finest, finest, share * np.abs(finest.mean(axis=0))
        if isnan(order):
            return top.rows + carried * change, finest, np.abs((carried * (change + left)).mean(axis=0))
        return top.rows + carried * (change + left), finest, np.abs((carried * left).mean(axis=0))


def vanishing_pixel(order: float, refined: float) -> float:
    """Return what a vanishing pixel changes over what a pixel so many times finer does."""
    return TURNING if isnan(order) else 1.0 / (1.0 - refined**-order)


def pixel_of_limit(ladder: list[Rung], order: float, by_law: Any = False, until: float = 0.0) -> Array:
    """Return the error of the pixel in an extrapolated value, (speeds,); NaN where no rung has a partner.

    Most of what a finer pixel changes goes with 1/q_c and is extrapolated away. Two partners on successive rungs show
    what is left; one alone is taken to fall with the root of q_c. `by_law` what falls up to `until`, rad/m, is in the
    doubt of the law already: the rest is left.
    """
    q_top = ladder[-1].sample.q_max
    highest = next((rung for rung in reversed(ladder) if rung.partner is not None), None)
    if highest is None or highest.partner is None:
        return np.full(ladder[-1].rows.shape[1:], nan)
    fallen = highest.sample.q_max / q_top
    change = vanishing_pixel(order, highest.refined) * np.abs((highest.partner - highest.rows).mean(axis=0))
    left, rest_by_law = np.sqrt(fallen) * change, highest.sample.q_max / max(q_top, until) * change
    for below, rung in reversed(list(pairwise(ladder))):
        if below.partner is not None and rung.partner is not None:
            weight = 1.0 / (rung.sample.q_max / below.sample.q_max - 1.0)
            rest = (1.0 + weight) * (rung.partner - rung.rows) - weight * (below.partner - below.rows)
            scale = rung.sample.q_max / q_top * vanishing_pixel(order, rung.refined)
            left = scale * np.abs(rest.mean(axis=0))
            break
    return np.asarray(np.where(by_law, rest_by_law, left))


def notes_of(scene: Scene, numerics: Numerics, column: str, observable: str, values: Values) -> tuple[str, ...]:
    """Return in words what values were made of: the levels, how they were continued to the end of C(q), the speeds."""
    levels = [numerics.levels[i] for i in numerics.of_column(column)]
    grids = ", ".join(
        f"{level.shape[0]} × {level.shape[1]} to {level.q_max:.3g} rad/m" + level.where for level in levels
    )
    notes = [f"{column} contact on {grids}, solver tolerance {numerics.tolerance:.1g}"]
    if np.any(np.isfinite(values.exponent)):
        exponents = ", ".join(dict.fromkeys(f"{p:.2f}" for p in values.exponent if np.isfinite(p)))
        by_law = np.any(np.isnan(values.exponent) & (values.bandwidth > 0.0))
        others = ", at other speeds by the law for contact that yields" if by_law else ""
        notes.append(f"extrapolated as q_c^(−p) with p = {exponents}{others}")
    elif column == "capped" and not OBSERVABLES[observable].limit:
        notes.append("does not converge with the grid: the value of the finest level, not extrapolated")
    elif levels[-1].q_max < scene.spectrum.breaks[-1] * (1 - SAME):
        if values.extrapolated is values.finest and np.any(values.bandwidth > 0.0):
            notes.append("shorter than a wave of the cut-offs: the value of the highest q_c, the last step is in doubt")
        elif np.any(values.bandwidth > 0.0):
            shape = prediction.follows_theory(scene, column, levels[-1].q_max) is not False
            way = "with the shape of the theory" if shape else "by the law for contact that yields"
            notes.append(f"continued from q_c to q_max {way}")
        if np.any(np.isnan(values.bandwidth)):
            last = ", and what the last step to it changed is part of the error" if np.any(values.last_step) else ""
            notes.append(f"where the bandwidth is unknown, the value of the highest q_c{last}")
    if OBSERVABLES[observable].per_speed:
        notes.append(f"speeds {', '.join(f'{v:g}' for v in scene.speeds)} m/s")
    return tuple(notes)
