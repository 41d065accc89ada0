"""Estimates of the column "sliding": that of frozen contact, times what two histories change of it.

The march is of low cut-off and few members. But on the contacts of each member T_flash is known both ways, and their
ratio scatters little and depends little on the cut-off. It is put onto the estimate of single contacts, which has all
of C(q).
"""

from dataclasses import replace

import numpy as np

from roughsim.estimate.errors import Estimate, half_width, spread
from roughsim.grid import Array
from roughsim.observables.record import ratio

OF_MARCH = ("flash_temperature", "heat_partition", "contact_fraction")
# exponents of the pixel between which the error of the ratio falls, measured from 3 to 16 pixels per shortest wave
ORDERS = 1.0, 1.5
# 95 %, relative: what the cut-off leaves. In five scenes that yield or not, from 4 q_y to 16 q_y, the ratio without its
# error of the pixel changes by −2.9 … +0.8 %
DOUBT_OF_CUT_OFF = 0.03
# of a ratio that is not corrected: it was low by 0.1 to 5.4 %, never high, in the same scenes at 4 pixels per wave
MOST_UNCORRECTED = 0.07
DOUBT_OF_SHARE = 0.02  # the same of the share


def sliding_estimate(observable: str, single: Estimate, numbers: dict[str, Array], coarsening: float = 1.0) -> Estimate:
    """Return the estimate of an observable of two bodies that slide over one another.

    Parameters
    ----------
    observable : {"flash_temperature", "heat_partition", "contact_fraction"}
        T_flash above the background of the moving body; its share of the heat; the area, that of single contacts.
    single : Estimate
        That of single contacts, with all the heat in the moving body.
    numbers : dict of str to ndarray
        Those that marches store, (members, speeds); at least one member.
    coarsening : float
        Pixel of the coarser grid of each march over that of its own, above 1; 1 without a coarser one.

    Raises
    ------
    ValueError
        For another observable.
    """
    if observable not in OF_MARCH:
        raise ValueError(f'observable = {observable!r} is not in column "sliding"; it has {", ".join(OF_MARCH)}')
    if observable == "contact_fraction":
        return single
    if observable == "heat_partition":
        share, error, scatter, freedom = _mean_of(numbers["sliding_share"])
        count = len(numbers["sliding_share"])
        return replace(
            single,
            mean=share,
            standard_error=error,
            budget={"statistical": scatter, "march": DOUBT_OF_SHARE * share},
            bias=np.zeros_like(share),
            n=count,
            effective_n=freedom + 1.0,
            notes=(f"mean over the last half of the distance that {count} members slide",),
        )
    rows = ratio(numbers["sliding_flash_temperature"], numbers["sliding_frozen_flash_temperature"])
    correction, doubt, note = pixel_correction(rows, numbers, coarsening)
    change, error, scatter, _ = _mean_of(rows + correction)
    value = single.mean * change
    budget = {name: part * change for name, part in single.budget.items()}
    budget["statistical"] = np.hypot(budget["statistical"], single.mean * scatter)
    told = f"the frozen estimate with all heat in the moving body, times its change in {len(rows)} members that slide"
    return replace(
        single,
        mean=value,
        standard_error=np.hypot(single.standard_error * change, single.mean * error),
        budget=budget | {"march": single.mean * doubt},
        bias=single.bias * change,
        notes=(*single.notes, told, note),
    )


def pixel_correction(rows: Array, numbers: dict[str, Array], coarsening: float) -> tuple[Array, Array, str]:
    """Return what finer pixels add to each ratio, (members, speeds), the doubt of the mean ratio, and a note.

    The error falls with the pixel to a power within `ORDERS`. So the difference from the coarser march, times
    1/(coarsening^p − 1), is what is left. Both are taken: their mean corrects, and half of their difference is doubt.
    """
    mean = rows.mean(axis=0)
    coarser = numbers["sliding_coarser_flash_temperature"]  # NaN in members of an older version
    if coarsening <= 1.0 or np.isnan(coarser).any():
        most = f"{100 * MOST_UNCORRECTED:g}"
        note = (
            f"low by up to {most} % and not high: pixel and cut-off of the march, not corrected without a coarser one"
        )
        return np.zeros_like(rows), MOST_UNCORRECTED * mean, note
    difference = rows - ratio(coarser, numbers["sliding_coarser_frozen_flash_temperature"])
    first, last = (1.0 / (coarsening**order - 1.0) for order in ORDERS)
    correction = 0.5 * (first + last) * difference
    spread_of_orders = 0.5 * (first - last) * np.abs(difference.mean(axis=0))
    relative = 100 * correction.mean(axis=0) / mean
    note = (
        f"changed by {relative.min():+.2g} … {relative.max():+.2g} % for the pixel of the march, from marches with "
        f"{coarsening:.3g} of the pixel"
    )
    return correction, np.hypot(spread_of_orders, DOUBT_OF_CUT_OFF * mean), note


def with_background(flash: Estimate, rows: Array) -> Estimate:
    """Return T₀ + T_flash of the moving body: `rows`, (members, speeds), are T₀ at the end of each march, K.

    T₀ depends on the march only by the share of the heat, so its doubt is that of the share. A larger share warms both
    parts, so the doubts add.
    """
    warm, error, scatter, _ = _mean_of(rows)
    budget = flash.budget | {
        "statistical": np.hypot(flash.budget["statistical"], scatter),
        "march": flash.budget["march"] + DOUBT_OF_SHARE * warm,
    }
    told = f"with the background after the duration, a mean of {len(rows)} members that slide"
    return replace(
        flash,
        mean=flash.mean + warm,
        standard_error=np.hypot(flash.standard_error, error),
        budget=budget,
        notes=(*flash.notes, told),
    )


def _mean_of(rows: Array) -> tuple[Array, Array, Array, Array]:
    """Return the mean of rows, its standard error, its 95 % half-width, and the degrees of freedom."""
    error, freedom = spread(rows)
    return rows.mean(axis=0), error, half_width(error, freedom), freedom
