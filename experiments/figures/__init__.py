"""Figures of docs/figures that are drawn from the files of docs/evidence, in one style."""

from .accuracy import one_contact
from .camera import camera, camera_law
from .chain import chain
from .contact import SOLVERS, contact_cost, contact_error
from .coverage import coverage
from .finite import finite_contact
from .heat import heat
from .lay import lay
from .limits import limits_of_heat, limits_of_pixel, limits_of_solvers, limits_of_theory

__all__ = [
    "SOLVERS",
    "camera",
    "camera_law",
    "chain",
    "contact_cost",
    "contact_error",
    "coverage",
    "finite_contact",
    "heat",
    "lay",
    "limits_of_heat",
    "limits_of_pixel",
    "limits_of_solvers",
    "limits_of_theory",
    "one_contact",
]
