"""Figures of docs/figures that are drawn from the files of docs/evidence, in one style."""

from .chain import chain
from .contact import SOLVERS, contact_cost, contact_error
from .coverage import coverage

__all__ = ["SOLVERS", "chain", "contact_cost", "contact_error", "coverage"]
