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
        rows, doubt = numbers["sliding_share"], DOUBT_OF_SHARE
    else:
        rows, doubt = (
            ratio(numbers["sliding_flash_temperature"], numbers["sliding_frozen_flash_temperature"]),
            DOUBT_OF_RATIO,
        )
    mean, (error, freedom) = rows.mean(axis=0), spread(rows)
    scatter, count = half_width(error, freedom), len(rows)
    if observable == "heat_partition":
        zero = np.zeros_like(mean)
        budget = {"statistical": scatter, "march": doubt * mean}
        notes = (f"mean over the last half of the distance that {count} members slide",)
        return replace(
            single,
            mean=mean,
            standard_error=error,
            budget=budget,
            bias=zero,
            n=count,
            effective_n=freedom + 1.0,
            notes=notes,
        )
    notes = (f"the frozen estimate with all heat in the moving body, times its change in {count} members that slide",)
    value = single.mean * mean
    budget = {name: part * mean for name, part in single.budget.items()}
    budget["statistical"] = np.hypot(budget["statistical"], single.mean * scatter)
    return replace(
        single,
        mean=value,
        standard_error=np.hypot(single.standard_error * mean, single.mean * error),
        budget=budget | {"march": doubt * value},
        bias=single.bias * mean,
        notes=(*single.notes, *notes),
    )
