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
# 95 %, relative. On steel of 1.2 GPa the ratio rises by 2 to 3 % when the pixel, and with it the step, is halved from 4
# pixels per shortest wave, and as much again may follow; twice the cut-off at the same pixels per wave: −1 to +2 %
DOUBT_OF_RATIO = 0.06
DOUBT_OF_SHARE = 0.02  # the same of the share


def sliding_estimate(observable: str, single: Estimate, numbers: dict[str, Array]) -> Estimate:
    """Return the estimate of an observable of two bodies that slide over one another.

    Parameters
    ----------
    observable : {"flash_temperature", "heat_partition", "contact_fraction"}
        T_flash above the background of the moving body; its share of the heat; the area, that of single contacts.
    single : Estimate
        That of single contacts, with all the heat in the moving body.
    numbers : dict of str to ndarray
        Those that marches store, (members, speeds); at least one member.

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
    change, error, scatter, _ = _mean_of(rows)
    value = single.mean * change
    budget = {name: part * change for name, part in single.budget.items()}
    budget["statistical"] = np.hypot(budget["statistical"], single.mean * scatter)
    told = f"the frozen estimate with all heat in the moving body, times its change in {len(rows)} members that slide"
    return replace(
        single,
        mean=value,
        standard_error=np.hypot(single.standard_error * change, single.mean * error),
        budget=budget | {"march": DOUBT_OF_RATIO * value},
        bias=single.bias * change,
        notes=(*single.notes, told),
    )


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
