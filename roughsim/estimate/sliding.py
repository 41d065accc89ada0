"""Estimates of the column "sliding": the frozen contact, times the change by the histories of both bodies.

The slide has a low cut-off and few members. But each member gives T_flash of its contacts both with their history and
as frozen contacts. The ratio scatters little and depends little on the cut-off. It multiplies the estimate of single
contacts, which includes all of C(q).
"""

from dataclasses import replace

import numpy as np

from roughsim.estimate.errors import Estimate, half_width, spread
from roughsim.grid import Array
from roughsim.observables.record import ratio

SLIDING_OBSERVABLES = ("flash_temperature", "heat_partition", "contact_fraction")
# exponents of the pixel between which the error of the ratio falls, measured from 3 to 16 pixels per shortest wave
ORDERS = 1.0, 1.5
# 95 %, relative, of the ratio and of the share by the cut-off: in five scenes that yield or not, from 4 q_y to 16 q_y,
# the ratio without its error of the pixel changes by −2.9 … +0.8 %, the share by less
_DOUBT_OF_CUT_OFF = 0.03


def sliding_estimate(observable: str, single: Estimate, numbers: dict[str, Array], coarsening: float = 1.0) -> Estimate:
    """Return the estimate of an observable of two bodies that slide over one another.

    Parameters
    ----------
    observable : {"flash_temperature", "heat_partition", "contact_fraction"}
        T_flash above the background of the moving body; its share of the heat; the area of single contacts.
    single : Estimate
        Estimate of single contacts, with all the heat in the moving body.
    numbers : dict of str to ndarray
        Numbers stored by slides, (members, speeds); at least one member.
    coarsening : float
        Ratio of pixels, coarser grid over own grid of a slide; 1 without a coarser grid: the error is unknown.

    Raises
    ------
    ValueError
        For another observable.
    """
    if observable not in SLIDING_OBSERVABLES:
        raise ValueError(
            f'observable = {observable!r} is not in column "sliding"; it has {", ".join(SLIDING_OBSERVABLES)}'
        )
    if observable == "contact_fraction":
        return single
    if observable == "heat_partition":
        share, error, scatter, freedom = _mean_of(numbers["sliding_share"])
        count = len(numbers["sliding_share"])
        return replace(
            single,
            mean=share,
            standard_error=error,
            budget={"statistical": scatter, "slide": _DOUBT_OF_CUT_OFF * share},
            bias=np.zeros_like(share),
            n=count,
            effective_n=freedom + 1.0,
            notes=(f"mean over the last half of the distance that {count} members slide",),
        )
    rows = ratio(numbers["sliding_flash_temperature"], numbers["sliding_frozen_flash_temperature"])
    correction, doubt, pixel = np.zeros_like(rows), np.nan, "not corrected for its pixel, as there is no coarser grid"
    if coarsening > 1.0:
        coarser = ratio(
            numbers["sliding_coarser_flash_temperature"], numbers["sliding_coarser_frozen_flash_temperature"]
        )
        # the error falls with the pixel to a power within ORDERS: of the difference from the coarser slide either
        # 1/(coarsening^p − 1) is left; their mean corrects, and half of their difference is doubt
        first, last = (1.0 / (coarsening**order - 1.0) for order in ORDERS)
        correction = 0.5 * (first + last) * (rows - coarser)
        of_orders = 0.5 * (first - last) * np.abs((rows - coarser).mean(axis=0))
        doubt = np.hypot(of_orders, _DOUBT_OF_CUT_OFF * rows.mean(axis=0))
        relative = 100 * correction.mean(axis=0) / rows.mean(axis=0)
        pixel = f"changed by {relative.min():+.2g} … {relative.max():+.2g} % for its pixel, by {coarsening:.3g} of it"
    change, error, scatter, _ = _mean_of(rows + correction)
    budget = {name: part * change for name, part in single.budget.items()}
    budget["statistical"] = np.hypot(budget["statistical"], single.mean * scatter)
    budget["slide"] = single.mean * doubt
    note = f"the frozen estimate with all heat in the moving body, times its change in {len(rows)} members that slide"
    return replace(
        single,
        mean=single.mean * change,
        standard_error=np.hypot(single.standard_error * change, single.mean * error),
        budget=budget,
        bias=single.bias * change,
        notes=(*single.notes, note, f"the slide is {pixel}"),
    )


def with_background(flash: Estimate, rows: Array) -> Estimate:
    """Return T₀ + T_flash of the moving body: `rows`, (members, speeds), are T₀ at the end of each slide, K.

    T₀ depends on the slide only by the share of the heat, and has its relative error. A larger share warms both parts,
    so these errors add.
    """
    warm, error, scatter, _ = _mean_of(rows)
    budget = flash.budget | {
        "statistical": np.hypot(flash.budget["statistical"], scatter),
        "slide": flash.budget["slide"] + _DOUBT_OF_CUT_OFF * warm,
    }
    return replace(
        flash,
        mean=flash.mean + warm,
        standard_error=np.hypot(flash.standard_error, error),
        budget=budget,
        notes=(*flash.notes, f"with the background after the duration, a mean of {len(rows)} members that slide"),
    )


def _mean_of(rows: Array) -> tuple[Array, Array, Array, Array]:
    """Return the mean of rows, its standard error, its 95 % half-width, and the degrees of freedom."""
    error, freedom = spread(rows)
    return rows.mean(axis=0), error, half_width(error, freedom), freedom
