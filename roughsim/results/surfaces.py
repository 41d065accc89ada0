"""Surfaces of a run as files that other contact programs start from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from roughsim.results.fields import kept, member_field, not_kept
from roughsim.store.disk import place_bytes
from roughsim.surface.topography import ENDINGS, encoded

if TYPE_CHECKING:
    from roughsim.results.run import Run


def export_surface(run: Run, path: str | Path, realization: int = 0, column: str | None = None) -> Path:
    """Write the composite heights of one kept realization for SurfaceTopography, ContactMechanics or tamaas.

    Parameters
    ----------
    run : Run
        From `run` or `open_run`.
    path : str or Path
        Of the file: .nc (with sizes and unit) or .npy (the bare array, m); written anew if it is there.
    realization : int, optional
        Which kept one.
    column : str, optional
        As in `Run.estimate`; its finest level is written.

    Returns
    -------
    Path
        Where the file is.

    Raises
    ------
    ValueError
        If the ending is none of these, or the fields of the realization were not kept.
    RecordError
        If its file is damaged.
    OSError
        If the disk refuses, naming the path.
    """
    place = Path(path)
    if place.suffix.lower() not in ENDINGS:
        raise ValueError(f"path = {str(place)!r} of a surface must end in {' or '.join(ENDINGS)}")
    level = run.numerics.of_column(run.column(column))[-1]
    if realization not in kept(run, level):
        raise not_kept(run, level, realization)
    heights = member_field(run, level, realization, "heights")
    content = encoded(heights, run.numerics.grid(level), place.suffix.lower())
    place.parent.mkdir(parents=True, exist_ok=True)
    place_bytes(place, content)
    return place
