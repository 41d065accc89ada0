"""Contact solvers that scenes can name: one file each, found by being in this folder.

The file NAME.py has a function `solve` with the arguments of `Solver`.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roughsim.contact import Contact, Solid
    from roughsim.grid import Grid

NAMES = tuple(sorted(module.name for module in iter_modules(__path__)))
DEFAULT = "active_set"


class Solver(Protocol):
    """What a realization asks for; `roughsim.solve_contact` says what the arguments are."""

    def __call__(
        self,
        heights: NDArray[Any],
        grid: Grid,
        solid: Solid,
        *,
        nominal_pressure: float,
        tolerance: float,
        precision: Literal["double", "single"],
    ) -> Contact:
        """Return the contact under the nominal pressure; ConvergenceError if the tolerance is not met."""


def solver(name: str) -> Solver:
    """Return the solver of a name among `NAMES`."""
    found: Solver = import_module(f"{__name__}.{name}").solve
    return found
