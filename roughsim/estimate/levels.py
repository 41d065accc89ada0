"""Multilevel Monte Carlo mean of the levels of a column (Giles, Acta Numerica 24, 259, 2015).

Level l has the cut-off q_l = q_0·2^l at a fixed number of pixels per shortest wave, and surfaces of its own, each
solved at l and at the level below. The mean is T = ⟨T₀⟩ Π ⟨T_l⟩/⟨T_(l−1)⟩. Levels are independent: variances add.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import degrees

import numpy as np

from roughsim import prediction
from roughsim.estimate.limit import OF_SHAPE, by_bound, by_law, by_power, by_shape, by_steps
from roughsim.estimate.mean import Mean, exact
from roughsim.estimate.telescoping import LevelMean, change_by_pixel, telescoped
from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS, OBSERVABLES
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


def values_of(
    scene: Scene,
    column: str,
    observable: str,
    samples: Sequence[Sample],
    *,
    extrapolated: bool = True,
    continued: bool = True,
) -> Mean:
    """Return the mean of an observable from the levels of a column, lowest first, with all heat in the moving body.

    `extrapolated` to the end of C(q), or up to the highest cut-off. Without `continued` only the pixel is extrapolated,
    and the change by shorter waves is unknown.
    """
    end = scene.spectrum.breaks[-1] if extrapolated else 0.0
    if observable == "heat_partition":
        return _share_of(scene, column, samples, end, continued)
    record = OBSERVABLES[observable]
    is_temperature = observable == FLASH or record.as_flash
    slow = telescoped(NUMBERS[RESTING].of_level, samples) if is_temperature else None
    levels = telescoped(partial(prediction.of_level, scene, record), samples)
    values = _continued_to_the_end(scene, column, observable, levels, slow, end, continued)
    moving = np.array(scene.speeds) > 0.0
    if record.at_rest is None or moving.all():
        return values
    # realizations at rest are measured at a tiny speed, but the limit at speed zero is exact
    return values.where(moving, exact(np.full(moving.shape, record.at_rest)))


def _continued_to_the_end(
    scene: Scene,
    column: str,
    observable: str,
    levels: list[LevelMean],
    slow: list[LevelMean] | None,
    end: float,
    continued: bool,
) -> Mean:
    """Return the mean of the levels of an observable, continued up to the cut-off `end`, rad/m, if it is above them.

    A temperature of the contact comes with `slow`, the levels of T_flash of slow contact, or of the resting body.
    Others as of `values_of`.
    """
    record = OBSERVABLES[observable]
    capped = column == "capped"
    q_c, top, finer, *_ = levels[-1]
    nothing = np.zeros(top.value.shape)
    rest = exact(nothing)
    has_limit = record.limit or not capped
    bandwidth = nothing
    if q_c < end * (1 - SAME):
        bandwidth = np.full_like(nothing, np.nan)
        if continued and has_limit:
            rest = continuation(scene, column, observable, levels)
            bandwidth = rest.errors.get("bandwidth", bandwidth)
    # the continued levels have the same pixels per shortest wave: their effect at the end is corrected
    end = end if rest.way else q_c
    with np.errstate(all="ignore"):  # infinite at rest
        finest = top.value if finer is None else top.value * (1.0 + finer.value)
        order = record.pixel_orders[capped]
        change = change_by_pixel(levels, order, PIXEL_FALL[column], end, slow)
        mean = top + rest
        pixel = np.abs(mean.value) * change.errors["pixel"]
        if has_limit:
            mean *= change + 1.0
        else:  # the change is the error, and nothing is corrected
            mean = replace(mean, value=finest)
            pixel = np.abs(finest) * np.hypot(change.errors["pixel"], change.value)
        if capped and record.by_force_balance:
            mean, nearest = _bounded(scene, observable, mean, rest.value)
            # on a map that is cut off they may lie further from the bound, but not if nothing yields
            on_this_side = continued | (mean.value == 0.0)
            bandwidth = np.where(on_this_side, np.fmin(bandwidth, nearest), bandwidth)
        step = np.abs(top.value - levels[-2].mean.value) if len(levels) > 1 else nothing
        last_step = np.where(np.isnan(bandwidth) & has_limit, np.nan_to_num(step), 0.0)
    errors = {"bandwidth": bandwidth, "pixel": pixel, "last step": last_step}
    return replace(mean, finest=finest, errors=errors, way=rest.way)


def _share_of(
    scene: Scene, column: str, samples: Sequence[Sample], end: float, continued: bool
) -> Mean:
    """Return the share of the heat that the moving body takes up; arguments as of `_continued_to_the_end`.

    It is 1/(1 + T/T'), T of the moving and T' of the resting body, each with all the heat, continued by itself: T' as
    the temperature of slow sliding.
    """
    balanced = [prediction.balanced(scene, sample) for sample in samples]
    moving, slow = (telescoped(NUMBERS[name].of_level, balanced) for name in (FLASH, RESTING))
    bodies = (prediction.in_motion(scene), moving), (prediction.slow(scene), slow)
    body, resting = (
        _continued_to_the_end(of_body, column, FLASH, levels, slow, end, continued)
        for of_body, levels in bodies
    )
    warm, resting_warm = prediction.backgrounds(scene, samples[0])
    with np.errstate(all="ignore"):  # a body that does not conduct
        above = body + warm
        below = resting + resting_warm
        ratio = above / below
        share = 1.0 / (1.0 + ratio.value)
        errors = {}
        for name, part in above.errors.items():
            relative = np.hypot(part / above.value, below.errors[name] / below.value)
            errors[name] = ratio.value * share**2 * relative
        finest = below.finest / (above.finest + below.finest)
        even = replace(ratio.through(share, finest, -(share**2)), errors=errors)
        if not scene.temperature_difference:
            return even
        total = above + below  # the hotter resting body gives off heat, ΔT/(T + T')
        given_off = total.through(1 / total.value, 1 / total.finest, -1 / total.value**2)
        return even + given_off * scene.temperature_difference


def continuation(scene: Scene, column: str, observable: str, levels: list[LevelMean]) -> Mean:
    """Return the rest beyond the highest cut-off, with its error "bandwidth"; zero without one if no rule holds.

    Contact that does not yield rises with the shape of the theory. Contact that has yielded follows its law in its
    range, else a power of the cut-off, as far as C(q) is one; its areas and g_σ(0) tend to their bounds. All of the
    rest is uncertain where C(q) falls more steeply. A distance shorter than the shortest wave follows no power.
    Temperatures of the contact other than T_flash follow its law by steps.
    """
    q = tuple(level.q_max for level in levels)
    record = OBSERVABLES[observable]
    followed = FLASH if record.as_flash else record.follows or observable
    law = prediction.calibrated_flash(scene, column, q) if followed == FLASH else None
    if law is not None:
        return by_steps(levels, law) if record.as_flash else by_law(levels, law, scene.elastic)
    theory = prediction.continuation(scene, column, q, followed)
    if theory is not None:  # of capped contact a part may yield
        least = 1.0 if column == "capped" else OF_SHAPE if followed == FLASH else 0.0
        return by_shape(levels, theory, least)
    alike = prediction.follows_power(scene, q)
    top = levels[-1].mean.value
    end = scene.spectrum.breaks[-1]
    nothing = exact(np.zeros_like(top))
    if len(levels) < 2 or alike is None:
        return nothing
    if record.distance and top.mean() * q[-1] < 4.0 * np.pi:
        return replace(nothing, errors={"bandwidth": np.abs(top - levels[-2].mean.value)})
    if record.by_force_balance:
        limit = by_bound(levels, end, _bound(scene, observable))
    else:
        limit = by_power(levels, end, prediction.usual_exponent(scene, q[-1]))
    if alike:
        return limit
    error = np.maximum(limit.errors["bandwidth"], np.abs(limit.value))
    return replace(limit, errors={"bandwidth": error})


def _bound(scene: Scene, observable: str) -> float:
    """Return the bound of an area or g_σ(0): A_pl ≤ σ₀/σ_P ≤ A, ⟨σ²⟩ − σ₀² ≤ σ₀(σ_P − σ₀), as 0 ≤ σ ≤ σ_P."""
    load = scene.sliding.nominal_pressure
    hardness = scene.penetration_hardness
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


def notes_of(
    scene: Scene, numerics: Numerics, column: str, observable: str, values: Mean
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
    if OBSERVABLES[observable].as_flash and np.any(np.isnan(values.value)):
        notes.append(
            "unknown where T_flash of the field of one direction lies too far from the mean over directions: take a "
            "cell of more waves, or layers that heat has passed"
        )
    if OBSERVABLES[observable].per_speed:
        along = ", ".join(f"{degrees(angle):.4g}" for angle in scene.directions)
        towards = f", at each of the directions {along}°" * bool(along)
        notes.append(f"speeds {', '.join(f'{v:g}' for v in scene.sliding.speed)} m/s{towards}")
    return tuple(notes)
