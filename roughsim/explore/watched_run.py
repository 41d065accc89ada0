"""A run folder that is watched: its state, problems, curves and error budgets as it grows."""

from __future__ import annotations

from functools import cached_property
from math import ceil, floor, isinf, log10
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.style import half_width
from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import state_line
from roughsim.errors import RecordError
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.folder import gap, open_run
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.show.terminal import table_text

Array = NDArray[np.float64]
CORRELATION = "pressure_correlation"
OVER_SPEED = ("flash_temperature", "flash_width", "slope_length")


class Curve(NamedTuple):
    """A measured curve over m/s or m: its mean, and the error of 95 %; infinite for one realization.

    The error is the total one, and of g_σ the statistical one.
    """

    x: Array
    mean: Array
    error: Array


class Summary(NamedTuple):
    """A run at one moment: problems, error budget and curves by column, sound and kept realizations by level."""

    problems: list[str]
    budget: dict[str, str]
    measured: dict[str, dict[str, Curve]]
    sound: dict[int, list[int]]
    kept: dict[int, list[int]]


class WatchedRun:
    """A run that may be empty or growing; damaged files are named and left out. RecordError if the folder is no run."""

    def __init__(self, folder: str | Path):
        self.run: Run = open_run(folder, damaged="skip")
        self._lock = Lock()
        nothing: dict[int, list[int]] = {level: [] for level in range(len(self.run.numerics.levels))}
        self._latest: tuple[Any, Summary] = None, Summary([], {}, {}, nothing, nothing)

    @cached_property
    def theory(self) -> dict[str, tuple[Any, Any]]:
        """The curves of the theory."""
        return theory_curves(self.run)

    @property
    def deleted(self) -> bool:
        """Whether the folder is there no more."""
        return not (self.run.folder / "run.json").exists()

    def state(self) -> str:
        """Return in one line how many realizations there are, and whether more are being computed."""
        with self._lock:
            return "its folder is gone" if self.deleted else state_line(self.run)

    def summary(self) -> Summary:
        """Read the members that have come since; the same object comes back as long as nothing has changed."""
        with self._lock:
            before, latest = self._latest
            if self.deleted:  # nothing of it can be read any more
                line = f"{self.run.folder} was deleted or moved; what had been read of it is still shown"
                if before != "deleted":
                    self._latest = "deleted", latest._replace(problems=[line])
                return self._latest[1]
            self.run.refresh()
            members = len(self.run.members), tuple(self.run.damaged)
            if before != members:
                try:
                    self._latest = members, summarized(self.run)
                except (RecordError, FileNotFoundError):  # a file was damaged or moved after it had been read
                    self.run = open_run(self.run.folder, damaged="skip")
                    self._latest = (len(self.run.members), tuple(self.run.damaged)), summarized(self.run)
            return self._latest[1]


def summarized(run: Run) -> Summary:
    """Return a run at this moment."""
    problems = [f"{text}. The other realizations are shown." for text in run.damaged.values()] + gap(run)
    if run.failed:
        problems.append(f"{run.failed} realizations did not converge and are left out of the means")
    sound, levels = run.sound(run.realizations), range(len(run.numerics.levels))
    none_yet = "No realization yet: there is no error to speak of."
    return Summary(
        problems,
        {c: table_text(budget_table(run, c)) if sound else none_yet for c in run.numerics.columns},
        {c: measured_curves(run, c) for c in run.numerics.columns} if sound else {},
        {level: [i for i in sound if (level, i) in run.members] for level in levels},
        {level: run.kept(level) for level in levels},
    )


def speed_range(scene: Scene) -> tuple[float, float]:
    """Return the speeds that can be chosen, m/s: a decade beyond those of the scene on either side.

    None is faster than those of the scene where a table of conductivity may end.
    """
    moving = [speed for speed in scene.speeds if speed > 0.0] or [1.0]
    highest = 10.0 ** (ceil(log10(max(moving))) + 1) if isinf(scene.temperature_range[1]) else max(moving)
    return 10.0 ** (floor(log10(min(moving))) - 1), highest


def distances(run: Run) -> Array:
    """Return the r at which g_σ is drawn, m: up to 0.4 longest waves, and never beyond half the diagonal."""
    longest = 2 * np.pi / run.scene.spectrum.breaks[0]
    return np.linspace(0.0, min(0.4 * longest, 0.5 * float(np.hypot(*run.numerics.lengths))), 160)


def theory_curves(run: Run) -> dict[str, tuple[Array, Array]]:
    """Return (x, value) of each curve over the whole spectrum; temperatures with the heat share of the scene."""
    scene, r = run.scene, distances(run)
    speeds = np.geomspace(*speed_range(scene), 121)
    # of all the heat; a temperature of the moving body is in proportion to the share that it takes
    values = prediction.over_speed(scene, speeds)
    share = prediction.heat_partition(scene, speeds)
    lines = {name: (speeds, values[name] * (share if OBSERVABLES[name].heated else 1.0)) for name in OVER_SPEED}
    return {CORRELATION: (r, prediction.correlation(scene, r)), **lines}


def measured_curves(run: Run, column: str) -> dict[str, Curve]:
    """Return the curves of a column by name; the run needs a sound realization."""
    speeds, r = np.array(run.scene.speeds), distances(run)
    moving = speeds > 0.0  # rest has no place on a logarithmic axis
    mean, error = run.correlation(r, column)
    curves = {CORRELATION: Curve(r, mean, half_width(run, column, error))}
    for name in OVER_SPEED:
        estimate = run.estimate(name, column)
        curves[name] = Curve(speeds[moving], estimate.mean[moving], estimate.total_error[moving])
    return curves
