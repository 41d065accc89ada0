"""What a run lacks, in words: members that are missing in the middle, and damaged ones."""

from __future__ import annotations

from roughsim.results.run import Run
from roughsim.store.member_files import member_name

NAMED = 5  # of many members; the others are counted


def left_out(run: Run) -> list[str]:
    """Return a line each on what is missing and on what is damaged, with what follows; empty for a whole run."""
    lines = gap(run)
    if run.damaged:
        names = listed(damaged_names(run))
        lines.append(f"damaged and left out of the means: {names}; run the scene again to have them")
    return lines


def gap(run: Run) -> list[str]:
    """Return a line on the members that are missing although later ones exist; empty where none is."""
    if not run.missing:
        return []
    return [
        f"not there: {listed(run.missing)}, lost or being computed now; only the {run.realizations} realizations "
        f"before count; run the scene again to have them"
    ]


def damaged_names(run: Run) -> list[str]:
    """Return the names, as "L0-000003", of the files that could not be used."""
    return [member_name(level, index) for level, index in run.damaged]


def listed(names: list[str]) -> str:
    """Return the first names, and how many more there are."""
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
