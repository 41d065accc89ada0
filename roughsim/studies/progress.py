"""The progress of a study on a terminal: points finished, the point at work, and the end."""

import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from roughsim.ensemble.bar import PatientConsole
from roughsim.show.text import clock
from roughsim.studies.bar import StudyProgress
from roughsim.studies.study import Study
from roughsim.studies.vary import points_of, read_axes
from roughsim.studies.work import study


def study_shown(content: dict[str, Any], folder: Path, workers: int | None, *, began: float | None = None) -> Study:
    """Compute a study as `roughsim.study` does, showing progress and end.

    `content` has its scene, vary and target_error. `began` is when the command was given, s by `time.monotonic`.
    """
    began = time.monotonic() if began is None else began
    console = PatientConsole(stderr=True)
    points = len(points_of(read_axes(content["vary"])))  # their scenes are made once, by `study`
    progress = StudyProgress(console, points)
    try:
        with suppress(OSError):
            progress.bar.start()
        result = study(
            content["scene"],
            vary=content["vary"],
            folder=folder,
            target_error=content.get("target_error"),
            workers=workers,
            observer=progress.update,
        )
    finally:
        with suppress(OSError):
            progress.bar.stop()
    console.print_lines(f"{result.finished} of {points} points finished in {folder}, {clock(time.monotonic() - began)}")
    return result
