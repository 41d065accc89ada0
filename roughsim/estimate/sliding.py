"""Estimates of the column "sliding": the frozen contact, times the change by the histories of both bodies.

The slide has a low cut-off and few members. But each member gives T_flash of its contacts both with their history and
as frozen contacts. The ratio scatters little and depends little on the cut-off. It multiplies the estimate of single
contacts, which includes all of C(q). A slide that is followed over a part of its distance is continued by the theory.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from roughsim.estimate.errors import half_width, spread, widened
from roughsim.estimate.levels import FLASH
from roughsim.estimate.mean import Mean, mean_of
from roughsim.grid import Array
from roughsim.observables.record import Sample, bins_of, ratio
from roughsim.prediction.sliding import WHOLE, SlidingContinuation
from roughsim.table import Estimate

SLIDING_OBSERVABLES = ("flash_temperature", "heat_partition", "contact_fraction")
# exponents of the pixel between which the error of the ratio falls, measured from 3 to 16 pixels per shortest wave
ORDERS = 1.0, 1.5
# 95 %, relative, of the ratio and of the share by the cut-off: in five scenes that yield or not, from 4 q_y to 16 q_y,
# the ratio without its error of the pixel changes by −2.9 … +0.8 %, the share by less
_UNCERTAINTY_OF_CUT_OFF = 0.03
# 95 %, of temperatures over T_flash. At twice the cut-off those above 99 % of the heat are 3 to 9 % higher, and the
# distribution about T_flash of frozen contact is as much wider. From 1e5 to 2e5 1/m on steel of 1.2 GPa this predicts
# the quantiles of 5 to 99.9 % to .04 T_flash or 2 %
HOT = "temperature_quantile_99"
UNCERTAINTY_OF_DISTRIBUTION = 0.03
_NO_LEVEL_SHOWS = (
    "size",
    "solver",
    "scan",
)  # parts of the error that a slide has as single contacts have
_UNIFORM = 0.01  # relative difference of that quantile from T_flash, below which there is no distribution to widen


def sliding_estimate(
    observable: str,
    single: Estimate,
    numbers: dict[str, Array],
    coarsening: float = 1.0,
    continued: SlidingContinuation = WHOLE,
) -> Estimate:
    """Return the estimate of an observable of two bodies that slide over one another.

    Parameters
    ----------
    observable : {"flash_temperature", "heat_partition", "contact_fraction"}
        T_flash above the background of the moving body; its share of the heat; the area of single contacts. Or a number
        of the picture of a camera, if slides have stored it.
    single : Estimate
        Estimate of single contacts, with all the heat in the moving body.
    numbers : dict of str to ndarray
        Numbers stored by slides, (members, speeds); at least one member.
    coarsening : float
        Ratio of pixels, coarser grid over own grid of a slide; 1 without a coarser grid: the error is unknown.
    continued : SlidingContinuation
        Factors from the distance that the slides are followed to their whole distance.

    Raises
    ------
    ValueError
        For another observable.
    """
    if observable not in SLIDING_OBSERVABLES and f"sliding_frozen_{observable}" not in numbers:
        raise ValueError(
            f'observable = {observable!r} is not in column "sliding"; it has {", ".join(SLIDING_OBSERVABLES)}'
        )
    if observable == "contact_fraction":
        return single
    if observable == "heat_partition":
        rows = numbers["sliding_share"] * continued.heat_partition
        share = rows.mean(axis=0)
        error, freedom = spread(rows)
        slide = np.hypot(_UNCERTAINTY_OF_CUT_OFF, continued.error) * share
        own = {"statistical": half_width(error, freedom), "slide": slide}
        beyond = {name: part for name, part in _relative(single).items() if name in _NO_LEVEL_SHOWS}
        note = f"mean over the last half of the distance that {len(rows)} members slide"
        return replace(
            single,
            mean=share,
            standard_error=error,
            budget=own | {name: share * part for name, part in beyond.items()},
            bias=np.zeros_like(share),
            n=len(rows),
            effective_n=freedom + 1.0,
            notes=(note, *_note_of(continued)),
        )
    if observable != FLASH:  # no theory continues the picture
        unknown = np.where(continued.error > 0.0, np.nan, 1.0)
        continued = WHOLE._replace(flash_temperature=unknown)
    rows, uncertainty, pixel = _change(numbers, coarsening, continued, observable)
    slid = single.times(rows.mean(axis=0))
    note = f"the frozen estimate with all heat in the moving body, times its change in {len(rows)} members that slide"
    slid = replace(
        slid,
        budget={**slid.budget, "slide": single.mean * uncertainty},
        notes=(*single.notes, note, f"the slide is {pixel}", *_note_of(continued)),
    )
    return widened(slid, rows, single.mean)


def _note_of(continued: SlidingContinuation) -> tuple[str, ...]:
    """Return a note of slides that are not followed over all of their distance."""
    flash = continued.flash_temperature
    if not continued.error.any():
        return ()
    return (
        f"the theory continues the slides to their whole distance, T_flash by the factors {flash.min():.3g} … "
        f"{flash.max():.3g}, with an error of {100 * continued.error.max():.2g} %",
    )


def _change(
    numbers: Mapping[str, Array],
    coarsening: float,
    continued: SlidingContinuation = WHOLE,
    observable: str = FLASH,
) -> tuple[Array, Array | float, str]:
    """Return the change of an observable from frozen to sliding contacts; arguments as of `sliding_estimate`.

    It is of each member, corrected for the pixel and continued to the whole distance, (members, speeds). Its error,
    95 %, is by the cut-off, the rest of the pixel and the distance, NaN if unknown; and there is the pixel in words.
    """
    rows = ratio(numbers[f"sliding_{observable}"], numbers[f"sliding_frozen_{observable}"])
    if coarsening <= 1.0:
        unknown = "not corrected for its pixel, as there is no coarser grid"
        return rows * continued.flash_temperature, np.nan, unknown
    coarser = ratio(
        numbers[f"sliding_coarser_{observable}"],
        numbers[f"sliding_coarser_frozen_{observable}"],
    )
    # the error falls with the pixel to a power within ORDERS: of the difference from the coarser slide either
    # 1/(coarsening^p − 1) is left; their mean corrects, and half of their difference is uncertainty
    first, last = (1.0 / (coarsening**order - 1.0) for order in ORDERS)
    correction = 0.5 * (first + last) * (rows - coarser)
    of_orders = 0.5 * (first - last) * np.abs((rows - coarser).mean(axis=0))
    others = np.hypot(_UNCERTAINTY_OF_CUT_OFF, continued.error)
    uncertainty = continued.flash_temperature * np.hypot(of_orders, others * rows.mean(axis=0))
    relative = 100 * correction.mean(axis=0) / rows.mean(axis=0)
    pixel = f"changed by {relative.min():+.2g} … {relative.max():+.2g} % for its pixel, by {coarsening:.3g} of it"
    return (rows + correction) * continued.flash_temperature, uncertainty, pixel


def sliding_flash(
    single: Mean, numbers: Mapping[str, Array], coarsening: float, stream: int
) -> Mean:
    """Return T_flash of the moving body above its background, K, with the scatter of each surface.

    `single` is of single contacts with all the heat in the moving body; the slides have a `stream` of surfaces of their
    own. The other arguments as of `sliding_estimate`. Slides with a distribution of the temperature, for which this is,
    are followed to their end (`prediction.sliding.continuation_fault`): nothing is continued.
    """
    rows, uncertainty, _ = _change(numbers, coarsening)
    return single * replace(mean_of(stream, rows), errors={"slide": np.asarray(uncertainty)})


def sliding_quantile(flash: Mean, rows: Array, slides: Sample, stretch: Array) -> Mean:
    """Return a quantile of the temperature over the contact of sliding bodies, K.

    It is `flash`, `sliding_flash` of the same slides, times the quantile over T_flash of the slides, whose influence
    values are `rows`. From the cut-off of the slide to the end of C(q) its difference from 1 grows by the factor
    `stretch`, (speeds,).
    """
    drawn = mean_of(slides.stream, ratio(rows, slides.numbers["sliding_flash_temperature"]))
    over_flash = (drawn - 1.0) * stretch + 1.0
    found = flash * over_flash
    uncertainty = UNCERTAINTY_OF_DISTRIBUTION * np.maximum(np.abs(over_flash.value), 1.0)
    own = flash.value * np.hypot(uncertainty, over_flash.value - drawn.value)
    errors = {**found.errors, "slide": np.hypot(found.errors["slide"], own)}
    return replace(found, finest=flash.finest * drawn.value, errors=errors)


def stretched(sample: Sample, stretch: Array) -> Sample:
    """Return slides with the differences of their bins from T_flash times a factor, (speeds,).

    The level below are the slides as they were followed.
    """
    bins = bins_of(sample)
    flash = sample.numbers[FLASH][..., None]
    temperature = flash + stretch[:, None] * (bins.temperature - flash)
    return replace(sample, bins=bins._replace(temperature=temperature), below=sample)


def stretch_of(flash: Mean, hot: Mean, lowest: Array) -> Array:
    """Return the growth of the distribution about T_flash in frozen contact, (speeds,), from its lowest level on.

    `flash` and `hot` are T_flash and the quantile `HOT` at the end of C(q); `lowest` is the quantile over T_flash.
    """
    drawn = lowest - 1.0
    with np.errstate(all="ignore"):  # of a uniform temperature
        growth = (hot.value / flash.value - 1.0) / drawn
    return np.where((drawn > _UNIFORM) & np.isfinite(growth), growth, 1.0)


def warmed(flash: Mean, warm: Array, share: Estimate) -> Mean:
    """Return T_flash with the error of a background, (speeds,), K, added to it, since the share makes both."""
    return replace(flash, errors=_added(flash.errors, warm, share))


def _added(errors: Mapping[str, Array], warm: Array, share: Estimate) -> dict[str, Array]:
    """Return errors of T_flash with those of a background, K, which has all of the share's but its scatter."""
    parts = {name: part * warm for name, part in _relative(share).items() if name != "statistical"}
    return {name: part + parts.get(name, 0.0) for name, part in errors.items()}


def _relative(found: Estimate) -> dict[str, Array]:
    """Return the parts of an error over the mean; none where the mean is undefined."""
    defined = np.isfinite(found.mean)
    return {name: np.where(defined, part / found.mean, 0.0) for name, part in found.budget.items()}


def with_background(
    flash: Estimate, rows: Array, share: Estimate, continued: SlidingContinuation = WHOLE
) -> Estimate:
    """Return T₀ + T_flash of the moving body: `rows`, (members, speeds), are T₀ at the end of each slide, K.

    T₀ depends on the slide only by the `share` of the heat, and has its relative error. A larger share warms both
    parts, so these errors add.
    """
    rows = rows * continued.background
    warm = rows.mean(axis=0)
    note = f"with the background after the duration, a mean of {len(rows)} members that slide"
    heated = replace(
        flash,
        mean=flash.mean + warm,
        budget=_added(flash.budget, warm, share),
        notes=(*flash.notes, note),
    )
    return widened(heated, rows)
