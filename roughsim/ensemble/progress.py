"""The progress of a run on a terminal: its plan, its rounds, and its end."""

import time
from contextlib import suppress
from pathlib import Path

from roughsim.ensemble.bar import PatientConsole, Progress
from roughsim.ensemble.run import carry_out
from roughsim.ensemble.status import losses, outcome
from roughsim.ensemble.workforce import Workforce
from roughsim.planning.limits import judge
from roughsim.planning.realization import march_problem
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.show.text import clock, warn


def run_shown(scene: Scene, folder: Path, workers: int | None, *, began: float | None = None) -> Run:
    """Plan and run a scene as `roughsim.run` does, showing plan, progress and end; None: as many workers as fit.

    `began` is when the command was given, s by `time.monotonic`; now if left out. The last line has the time since.
    """
    began = time.monotonic() if began is None else began
    console = PatientConsole(stderr=True)
    progress = Progress(console)

    def show_plan(numerics: Numerics) -> None:
        plan = (reason.value for reason in numerics.reasons if reason.choice in ("smoothed", "capped", "elastic"))
        console.print_lines(*plan, style="dim")
        if numerics.march is not None:
            steps = march_problem(scene, numerics).steps
            words = f"sliding: {steps} contacts in turn for each member; one that is broken off begins again"
            console.print_lines(words, style="dim")
        for line in judge(scene, numerics).warnings:
            warn(line)

    try:
        with suppress(OSError):
            progress.bar.start()
        result = carry_out(scene, folder, Workforce(workers, None), planned=show_plan, observer=progress.update)
    finally:
        with suppress(OSError):
            progress.bar.stop()
    console.print_lines(f"{result.extent} in {result.folder}, {clock(time.monotonic() - began)}; {outcome(result)}")
    console.print_lines(*losses(result))
    return result
