"""Spectra, contact solvers and observables by name, of roughsim and of packages that extend it.

Other packages add them by entry points: NAME = "package.module:object" in the group "roughsim.spectra",
"roughsim.solvers" or "roughsim.observables".
"""

from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

# of roughsim itself; its observables are the rows of `observables.catalogue.TABLE`
INSIDE = {
    "spectra": {"k_correlation": "roughsim.scene.spectra.k_correlation:Spectrum"},
    "solvers": {"active_set": "roughsim.contact.active_set:solve_contact"},
    "observables": {},
}


@lru_cache  # 8 ms, .5 ms when the packages are known
def installed() -> Any:  # a class of its own in Python 3.11
    """Return the entry points of all packages, to `select` from."""
    return entry_points()


def extensions(kind: str) -> dict[str, EntryPoint]:
    """Return the entry points of a kind by name; no other package can replace one of roughsim's own.

    Nothing is imported: listing the names loads no compiled code.
    """
    group = f"roughsim.{kind}"
    ours = [EntryPoint(name, target, group) for name, target in INSIDE[kind].items()]
    return {entry.name: entry for entry in (*sorted(installed().select(group=group)), *ours)}


def loaded(kind: str, name: str) -> Any:
    """Import the object of an entry point: a spectrum's record, a solver called as `solve_contact`, or observables."""
    return extensions(kind)[name].load()
