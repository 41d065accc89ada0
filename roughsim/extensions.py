"""Spectra, contact solvers and observables by name, of roughsim and of packages that extend it.

Other packages add them by entry points: NAME = "package.module:object" in the group "roughsim.spectra",
"roughsim.solvers" or "roughsim.observables".
"""

from importlib.metadata import EntryPoint, entry_points
from typing import Any

# of roughsim itself; its observables are the rows of `observables.catalogue.TABLE`
INSIDE = {
    "spectra": {"k_correlation": "roughsim.scene.spectra.k_correlation:Spectrum"},
    "solvers": {"active_set": "roughsim.contact.active_set:solve_contact"},
    "observables": {},
}


def extensions(kind: str) -> dict[str, EntryPoint]:
    """Return the entry points of a kind by name; no other package can replace one of roughsim's own.

    Nothing is imported: listing the names loads no compiled code.
    """
    return {
        entry.name: entry for entry in (*sorted(entry_points(group=_group(kind))), *_ours(kind))
    }


def loaded(kind: str, name: str) -> Any:
    """Import the object of an entry point: a spectrum's record, a solver called as `solve_contact`, or observables."""
    for entry in _ours(kind):
        if entry.name == name:
            return entry.load()  # without a look at all installed packages, which takes 8 ms
    return extensions(kind)[name].load()


def _ours(kind: str) -> list[EntryPoint]:
    return [EntryPoint(name, target, _group(kind)) for name, target in INSIDE[kind].items()]


def _group(kind: str) -> str:
    return f"roughsim.{kind}"
