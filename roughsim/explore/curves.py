"""The curves under the maps: g_σ(r), T_flash(v), D_flash(v) and d_flash(v), measured and in the theory."""

from __future__ import annotations

from math import ceil, floor, isinf, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.style import half_width
from roughsim.observables.catalogue import OBSERVABLES

if TYPE_CHECKING:
    from roughsim.results.run import Run
    from roughsim.scene import Scene

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
