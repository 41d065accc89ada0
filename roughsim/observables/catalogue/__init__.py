"""The observables of every run: one file for each kin of them, found by being in this folder.

A file has a tuple `OBSERVABLES` and, for what is not stored yet, a tuple `NUMBERS`.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.record import Number, Observable, Sample

Array = NDArray[np.float64]
_FIRST = ("flash", "partition", "areas", "stress")  # in the order of all tables and files; others follow by name


def _collected(kind: str) -> dict[str, Any]:
    """The records that the files list as `kind`, by name."""
    files = sorted(module.name for module in iter_modules(__path__))
    files.sort(key=lambda name: _FIRST.index(name) if name in _FIRST else len(_FIRST))
    found = [record for name in files for record in getattr(import_module(f"{__name__}.{name}"), kind, ())]
    names = [record.name for record in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice!r} stands twice in {kind} of {__name__}; rename one of the two")
    return dict(zip(names, found, strict=True))


OBSERVABLES: dict[str, Observable] = _collected("OBSERVABLES")
NUMBERS: dict[str, Number] = _collected("NUMBERS")
UNITS = {name: record.unit for name, record in OBSERVABLES.items()}


def of_level(observable: str, sample: Sample) -> Array:
    """Return the influence values (n, speeds) of an observable at one level.

    Parameters
    ----------
    observable : str
        A key of `OBSERVABLES`.
    sample : Sample
        The level.
    """
    values = OBSERVABLES[observable].values
    return sample.numbers[observable] if values is None else values(sample)
