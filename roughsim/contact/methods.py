"""The contact solvers that a scene can name: `[numerics] solver = "..."`.

A package outside adds one by an entry point of the group "roughsim.solvers": NAME = "package.module:function".
"""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import Any, Literal, Protocol, cast

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


# entry points inside and outside alike: whoever reads the names alone imports no compiled code
DEFAULT, GROUP = "active_set", "roughsim.solvers"
INSIDE = EntryPoint(DEFAULT, "roughsim.contact.active_set:solve_contact", GROUP)
SOLVERS = {entry.name: entry for entry in (*entry_points(group=GROUP), INSIDE)}
NAMES = tuple(sorted(SOLVERS))


def solver(name: str) -> Solver:
    """Return the solver of a name among `NAMES`."""
    return cast(Solver, SOLVERS[name].load())
