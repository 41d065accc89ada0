"""The contact solvers that a scene can name: `[numerics] solver = "..."`.

A package outside adds one by an entry point of the group "roughsim.solvers": NAME = "package.module:function".
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import cast

from roughsim.contact import Contact

# entry points inside and outside alike: whoever reads the names alone imports no compiled code
DEFAULT, GROUP = "active_set", "roughsim.solvers"
INSIDE = EntryPoint(DEFAULT, "roughsim.contact.active_set:solve_contact", GROUP)
SOLVERS = {entry.name: entry for entry in (*entry_points(group=GROUP), INSIDE)}
NAMES = tuple(sorted(SOLVERS))


def solver(name: str) -> Callable[..., Contact]:
    """Return the solver of a name among `NAMES`, to be called as `solve_contact`, the limit of iterations left out."""
    return cast(Callable[..., Contact], SOLVERS[name].load())
