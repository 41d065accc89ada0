"""The contact solvers that a scene can name: `[numerics] solver = "..."`.

The package's own stand in the table below. A package outside adds one by an entry point of the group
"roughsim.solvers": NAME = "package.module:function".
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any, Literal, Protocol

from numpy.typing import NDArray

from roughsim.contact import Contact, Solid
from roughsim.grid import Grid


class Solver(Protocol):
    """What a solver is called with; `solve_contact` says what the arguments are."""

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


def active_set() -> Solver:
    """Load the package's own solver: elastic or capped, by a cascade of active sets."""
    from roughsim.contact.active_set import solve_contact

    return solve_contact


# each name with what loads its function: whoever reads the names alone imports no compiled code
SOLVERS: dict[str, Callable[[], Solver]] = {
    **{entry.name: entry.load for entry in entry_points(group="roughsim.solvers")},
    "active_set": active_set,
}
NAMES = tuple(sorted(SOLVERS))
DEFAULT = "active_set"


def solver(name: str) -> Solver:
    """Return the solver of a name among `NAMES`."""
    return SOLVERS[name]()
