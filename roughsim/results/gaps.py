"""What a run lacks, in words: members that are missing in the middle, and damaged ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughsim.store.member_files import member_path

if TYPE_CHECKING:
    from roughsim.results.run import Run

_NAMED = 5  # of many members; the others are counted


def left_out(run: Run) -> list[str]:
    """Return a line each on what is missing and on what is damaged, with what follows; empty for a whole run."""
    lines = gap(run)
    if damaged := damaged_names(run):
        lines.append(f"damaged and left out of the means: {_listed(damaged)}; run the scene again to have them")
    return lines


def gap(run: Run) -> list[str]:
    """Return a line on the members that are missing although later ones are there; empty where none is."""
    missing = run.missing
    if not missing:
        return []
    return [
        f"not there: {_listed(missing)}, lost or being computed now; only the {run.realizations} realizations before "
        f"count; run the scene again to have them"
    ]


def damaged_names(run: Run) -> list[str]:
    """Return the names, as "L0-000003", of the files that could not be used."""
    return [member_path(run.folder, *key).stem for key in run.damaged]


def _listed(names: list[str]) -> str:
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
