"""The marks of a value: the unknown parts of its error, and whether it is at q_c or fixed by force balance.

Comparisons, studies and files take these marks and their words from here.
"""

from collections.abc import Collection, Iterator
from math import isfinite

import numpy as np

from roughsim import prediction
from roughsim.estimate.errors import Estimate
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING

IDENTITY, AT_CUT_OFF = "identity", "at q_c"


def notes_of(run: Run, column: str, estimate: Estimate) -> list[str]:
    """Return a note on each entry of an estimate of a column: "identity", "at q_c" or "".

    "identity": force balance alone fixes the value, as all contact has yielded. "at q_c": the value has no limit in the
    cut-off, or the levels of the run do not show it, so that it is not extrapolated.
    """
    record = OBSERVABLES[estimate.observable]
    plastic = column in ("capped", SLIDING) and not run.scene.elastic
    if plastic and record.by_force_balance and isfinite(prediction.yield_wavenumber(run.scene)):
        return [IDENTITY] * len(estimate.mean)
    no_limit = np.isnan(estimate.budget.get("bandwidth", np.zeros_like(estimate.mean)))
    no_limit |= plastic and not record.limit  # plastic patches have steep edges
    return [AT_CUT_OFF * bool(cut) for cut in no_limit & ~np.isnan(estimate.mean)]


def meanings(unknown: Collection[str], notes: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each mark that a table has; `unknown` are parts of errors, `notes` are from `notes_of`."""
    if unknown:
        yield f"≥: a part of the error is unknown, as no level of the run shows it ({', '.join(unknown)})."
    if IDENTITY in notes:
        yield "identity: fixed by force balance; its ratios test nothing."
    if AT_CUT_OFF in notes:
        yield "at q_c: no limit in the cut-off, or none that the run shows; its ratios test nothing."
