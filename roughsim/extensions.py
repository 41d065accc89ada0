"""What a scene or a run can name, and other packages add by entry points: spectra, contact solvers and observables.

An entry point is NAME = "package.module:object" in the group "roughsim.spectra", "roughsim.solvers" or
"roughsim.observables".
"""

from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

# of roughsim itself; its observables are rows of a table
INSIDE = {
    "spectra": {"k_correlation": "roughsim.scene.spectra.k_correlation:Spectrum"},
    "solvers": {"active_set": "roughsim.contact.active_set:solve_contact"},
    "observables": {},
}


def extensions(kind: str) -> dict[str, EntryPoint]:
    """Return the entries of a kind by name, those of roughsim among them: no other package replaces one.

    Nothing is imported for it: whoever reads the names alone loads no compiled code.
    """
    group = f"roughsim.{kind}"
    ours = [EntryPoint(name, target, group) for name, target in INSIDE[kind].items()]
    return {entry.name: entry for entry in (*sorted(entry_points(group=group)), *ours)}


@lru_cache
def loaded(kind: str, name: str) -> Any:
    """Return the object of an entry: the record of a spectrum, a solver called as `solve_contact`, or observables."""
    return extensions(kind)[name].load()
