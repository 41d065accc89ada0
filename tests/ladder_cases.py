"""Levels made by hand: a T_flash and nothing else."""

import numpy as np

from roughsim.estimate.ladder import Values
from roughsim.observables.record import Sample

NAME = "flash_temperature"


def level(values, *, q_max=1.0, side=64.0, rows=None):
    """A level that has only a T_flash: values (n, speeds) at the given realizations."""
    rows = np.arange(len(values)) if rows is None else rows
    return Sample(q_max, side, rows, {NAME: values}, np.ones(1), np.ones((len(values), 1)), 1.0)


def seldom(values, every, **names):
    rows = np.arange(0, len(values), every)
    return level(values[rows], rows=rows, **names)


def power_law(cutoffs, exponent, limit=7.0, c=3.0, **names):
    return [level(np.full((13, 1), limit + c * q**-exponent), q_max=q, side=64.0 * q, **names) for q in cutoffs]


def values_of(rows):
    """Values of rows that need no extrapolation."""
    none = np.zeros(rows.shape[1:])
    return Values(rows, rows, rows, np.zeros(len(rows), dtype=int), none, none, none)
