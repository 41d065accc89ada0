"""Multilevel Monte Carlo mean of the levels of a column (Giles, Acta Numerica 24, 259, 2015).

Level l has the cut-off q_l = q_0·2^l at a fixed number of pixels per shortest wave, and surfaces of its own, each
solved at l and at the level below. The mean is T = ⟨T₀⟩ Π ⟨T_l⟩/⟨T_(l−1)⟩. Levels are independent: variances add.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.limit import ContinuedMean, by_bound, by_law, by_power, by_shape, by_steps
from roughsim.estimate.mean import Influence, Mean
from roughsim.estimate.telescoping import LevelMean, Pair, change_by_pixel, telescoped
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.scene import Scene
from roughsim.scene.numerics import SAME, Numerics

# exponent with which the relative change by a pixel of a fixed part of the shortest wave falls with the cut-off, by
# column: .5 to 1.4 on three steels and two rocks from 4 to 32 q_y; elastic T_flash 0 to .6 and g_σ(0) 0 to .3 on three
# surfaces
PIXEL_FALL = {"capped": 0.75, "smoothed": 0.3, "elastic": 0.3}
FLASH = "flash_temperature"
RESTING = "resting_flash_temperature"
# side of its exact bound on which an observable by force balance lies in capped contact
_TOWARDS_BOUND = {
    "contact_fraction": np.maximum,
    "plastic_fraction": np.minimum,
    "pressure_variance": np.minimum,
}


class Values(NamedTuple):
    """One observable of a column, (speeds,) or (1,), with its scatter as in `Mean`, and its other errors, 95 %.

    `mean` is extrapolated to the end of C(q) and to a vanishing pixel, if such a limit exists; `finest` is the mean at
    the highest cut-off on its finest grid. `way` describes the extrapolation in words.
    """

    mean: Array
    finest: Array
    influence: Influence
    # all parts of the error but the statistical one, so that whatever follows from the values has each of them.
    # "bandwidth" and "pixel", NaN if no level shows them, and "last step": the change by the last rise of q_c if a
    # limit exists and no extrapolation reaches it, else 0. `with_errors` adds those that no level shows
    errors: dict[str, Array]
    way: str = ""

    @property
    def sampled(self) -> Mean:
        """The mean with its scatter alone."""
        return Mean(self.mean, self.influence)

    def through(self, mean: Array, finest: Array, slope: Array) -> "Values":
        """Return a function of these values, whose `slope` there carries their scatter and errors (delta method)."""
        influence = {stream: rows * slope for stream, rows in self.influence.items()}
        errors = {name: np.abs(slope) * part for name, part in self.errors.items()}
        return Values(mean, finest, influence, errors, self.way)


def values_of(
    scene: Scene,
    column: str,
    observable: str,
    pairs: list[Pair],
    *,
    extrapolated: bool = True,
    continued: bool = True,
) -> Values:
    """Return the values of an observable from the levels of a column, lowest first, with all heat in the moving body.

    `extrapolated` to the end of C(q), or up to the highest cut-off. Without `continued` only the pixel is extrapolated,
    and the change by shorter waves is unknown.
    """
    if observable == "heat_partition":
        return _share_of(scene, column, pairs, extrapolated=extrapolated, continued=continued)
    record = OBSERVABLES[observable]
    levels = telescoped(record.of_level, pairs)
    is_temperature = observable == FLASH or record.as_flash
    slow = telescoped(partial(number, name=RESTING), pairs) if is_temperature else None
    values = _continued_to_the_end(scene, column, observable, levels, slow, extrapolated, continued)
    return values if record.at_rest is None else at_rest(values, record.at_rest, scene)


def _continued_to_the_end(
    scene: Scene,
    column: str,
    observable: str,
    levels: list[LevelMean],
    slow: list[LevelMean] | None,
    extrapolated: bool,
    continued: bool,
) -> Values:
    """Return the values of the levels of an observable; others as of `values_of`.

    A temperature of the contact comes with `slow`, the levels of T_flash of slow contact, or of the resting body.
    """
    record, capped = OBSERVABLES[observable], column == "capped"
    q_c, top, finer, *_ = levels[-1]
    nothing = np.zeros(top.value.shape)
    limit, has_limit = ContinuedMean(Mean(nothing, {}), nothing, ""), record.limit or not capped
    end = scene.spectrum.breaks[-1] if extrapolated else q_c
    if q_c < end * (1 - SAME):
        limit = limit._replace(error=np.full_like(nothing, np.nan))
        if continued and has_limit:
            limit = continuation(scene, column, observable, levels, limit)
    # the continued levels have the same pixels per shortest wave: their effect at the end is corrected
    end = end if limit.way else q_c
    with np.errstate(all="ignore"):  # infinite at rest
        finest = top.value if finer is None else top.value * (1.0 + finer.value)
        change, error = change_by_pixel(
            levels, record.pixel_orders[capped], PIXEL_FALL[column], end, slow
        )
        mean = top + limit.rest
        pixel = np.abs(mean.value) * error
        if has_limit:
            mean *= change + 1.0
        else:  # the change is the error, and nothing is corrected
            mean = replace(mean, value=finest)
            pixel = np.abs(finest) * np.hypot(error, change.value)
        bandwidth = limit.error
        if capped and record.by_force_balance:
            mean, nearest = _bounded(scene, observable, mean, limit.rest.value)
            # on a map that is cut off they may lie further from the bound, but not if nothing yields
            on_this_side = continued | (mean.value == 0.0)
            bandwidth = np.where(on_this_side, np.fmin(bandwidth, nearest), bandwidth)
        step = np.abs(top.value - levels[-2].mean.value) if len(levels) > 1 else nothing
        last_step = np.where(np.isnan(bandwidth) & has_limit, np.nan_to_num(step), 0.0)
    errors = {"bandwidth": bandwidth, "pixel": pixel, "last step": last_step}
    return Values(mean.value, finest, mean.influence, errors, limit.way)


def with_errors(values: Values, **relative: Array | float) -> Values:
    """Return values with further parts of the error, relative to the mean; what is exactly zero has none of them."""
    with np.errstate(invalid="ignore"):  # infinite at rest
        size = np.abs(values.mean)
        parts = {name: np.where(size == 0.0, 0.0, size * part) for name, part in relative.items()}
    return values._replace(errors=values.errors | parts)


def number(sample: Sample, name: str) -> Array:
    """Return a stored number of a sample, (n, speeds)."""
    return sample.numbers[name]


def _share_of(
    scene: Scene, column: str, pairs: list[Pair], *, extrapolated: bool, continued: bool
) -> Values:
    """Return the share of the heat that the moving body takes up; arguments as of `values_of`.

    It is 1/(1 + T/T'), T of the moving and T' of the resting body, each with all the heat, continued by itself: T' as
    the temperature of slow sliding.
    """
    balanced = [pair.of(partial(prediction.balanced, scene)) for pair in pairs]
    slow = telescoped(partial(number, name=RESTING), balanced)
    of_bodies = (
        (prediction.in_motion(scene), telescoped(partial(number, name=FLASH), balanced)),
        (prediction.slow(scene), slow),
    )
    body, resting = (
        _continued_to_the_end(of_body, column, FLASH, levels, slow, extrapolated, continued)
        for of_body, levels in of_bodies
    )
    warm, resting_warm = prediction.backgrounds(scene, pairs[0].sample)
    with np.errstate(all="ignore"):  # a body that does not conduct
        above, below = body.sampled + warm, resting.sampled + resting_warm
        ratio = above / below
        share = 1.0 / (1.0 + ratio.value)
        moving, still = body.finest + warm, resting.finest + resting_warm
        errors = {}
        for name, part in body.errors.items():
            relative = np.hypot(part / above.value, resting.errors[name] / below.value)
            errors[name] = ratio.value * share**2 * relative
        influence = (ratio * -(share**2)).influence
        finest = still / (moving + still)
    return Values(share, finest, influence, errors, body.way)


def continuation(
    scene: Scene, column: str, observable: str, levels: list[LevelMean], unknown: ContinuedMean
) -> ContinuedMean:
    """Return the rest beyond the highest cut-off; `unknown` if no rule holds.

    Contact that does not yield rises with the shape of the theory. Contact that has yielded follows its law in its
    range, else a power of the cut-off, as far as C(q) is one; its areas and g_σ(0) tend to their bounds. All of the
    rest is uncertain where C(q) falls more steeply. A distance shorter than the shortest wave follows no power.
    Temperatures of the contact other than T_flash follow its law by steps.
    """
    q = tuple(level.q_max for level in levels)
    record = OBSERVABLES[observable]
    followed = FLASH if record.as_flash else observable
    theory = prediction.continuation(scene, column, q, followed)
    if theory is not None:
        return by_shape(levels, theory, yields=column == "capped")
    law = prediction.yielded_fall(scene, q[-2:]) if followed == FLASH else None
    if law is not None:
        return by_steps(levels, law) if record.as_flash else by_law(levels, law)
    alike = prediction.follows_power(scene, q)
    if len(levels) < 2 or alike is None:
        return unknown
    top, end = levels[-1].mean.value, scene.spectrum.breaks[-1]
    if record.distance and top.mean() * q[-1] < 4.0 * np.pi:
        return unknown._replace(error=np.abs(top - levels[-2].mean.value))
    if record.by_force_balance:
        limit = by_bound(levels, end, _bound(scene, observable))
    else:
        limit = by_power(levels, end, prediction.usual_exponent(scene, q[-1]))
    return (
        limit if alike else limit._replace(error=np.maximum(limit.error, np.abs(limit.rest.value)))
    )


def _bound(scene: Scene, observable: str) -> float:
    """Return the bound of an area or g_σ(0): A_pl ≤ σ₀/σ_P ≤ A, ⟨σ²⟩ − σ₀² ≤ σ₀(σ_P − σ₀), as 0 ≤ σ ≤ σ_P."""
    load, hardness = scene.sliding.nominal_pressure, scene.penetration_hardness
    return load * (hardness - load) if observable == "pressure_variance" else load / hardness


def _bounded(scene: Scene, observable: str, mean: Mean, rest: Array) -> tuple[Mean, Array]:
    """Return an area or g_σ(0) within the exact bound that it tends to, and its largest error by the cut-off.

    `rest` was added beyond the highest cut-off: the true value of a drawn surface lies between that at this cut-off and
    the bound. On a map whose plateaus are cut off at a wavenumber it may lie on the other side.
    """
    bound = _bound(scene, observable)
    value = _TOWARDS_BOUND[observable](mean.value, bound)
    within = np.maximum(np.abs(value - (mean.value - rest)), np.abs(value - bound))
    return replace(mean, value=value), within


def at_rest(values: Values, limit: float, scene: Scene) -> Values:
    """Return values with their exact limit at speed zero; members at rest are measured at a tiny speed instead."""
    moving = np.array(scene.speeds) > 0.0
    if moving.all():
        return values
    mean = values.sampled.where(moving, Mean(np.full(moving.shape, limit), {}))
    finest = np.where(moving, values.finest, limit)
    errors = {name: np.where(moving, part, 0.0) for name, part in values.errors.items()}
    return Values(mean.value, finest, mean.influence, errors, values.way)


def product(first: Values, second: Values) -> Values:
    """Return the product of two observables of a column; their other errors add, as they have the same causes."""
    both = first.sampled * second.sampled
    errors = {}
    with np.errstate(invalid="ignore"):  # a product of zero has no error
        for name in first.errors | second.errors:
            of_first, of_second = first.errors.get(name, 0.0), second.errors.get(name, 0.0)
            part = np.abs(first.mean) * of_second + np.abs(second.mean) * of_first
            errors[name] = np.where(both.value == 0.0, 0.0, part)
    return Values(both.value, first.finest * second.finest, both.influence, errors, first.way)


def scaled(values: Values, factor: Array) -> Values:
    """Return values times an exact number at each speed."""
    return values.through(values.mean * factor, values.finest * factor, factor)


def notes_of(
    scene: Scene, numerics: Numerics, column: str, observable: str, values: Values
) -> tuple[str, ...]:
    """Return notes on values: their levels, the way they were continued to the end of C(q), and the speeds."""
    with_members = [
        numerics.levels[i]
        for i in numerics.of_column(column)
        if numerics.stream(i) in values.influence
    ]
    grids = ", ".join(
        f"{level.shape[0]} × {level.shape[1]} to {level.q_max:.3g} rad/m" + level.where
        for level in with_members
    )
    notes = [
        f"{column} contact, levels with members: {grids}; solver tolerance {numerics.tolerance:.1g}"
    ]
    if values.way:
        notes.append(f"continued beyond the highest cut-off {values.way}")
    if column == "capped" and not OBSERVABLES[observable].limit:
        notes.append(
            "does not converge with the grid: the value of the finest level, not extrapolated"
        )
    elif np.any(np.isnan(values.errors["bandwidth"])):
        last = (
            ", and the change by the last step to it is part of the error"
            if np.any(values.errors["last step"])
            else ""
        )
        notes.append(f"the bandwidth error is unknown: value of the highest q_c{last}")
    if OBSERVABLES[observable].as_flash and np.any(np.isnan(values.mean)):
        notes.append(
            "unknown where T_flash of the field of one direction lies too far from the mean over directions: take a "
            "cell of more waves, or layers that heat has passed"
        )
    if OBSERVABLES[observable].per_speed:
        notes.append(f"speeds {', '.join(f'{v:g}' for v in scene.speeds)} m/s")
    return tuple(notes)
