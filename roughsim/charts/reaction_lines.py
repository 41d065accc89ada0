"""What a reaction feels, as lines to draw: quantiles of the temperature, activation temperatures, rates over speed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate import fields
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING
from roughsim.table import Estimate


class ReactionLine(NamedTuple):
    """A measured line with its total errors, 95 %, and the calibrated theory; NaN where there is none."""

    label: str
    place: Array  # % of heat or area that is hotter; E, eV; or v, m/s
    mean: Array  # temperature of the quantile, K; T_act, K; or the observable
    error: Array
    theory: Array


def moving_places(run: Run) -> NDArray[np.intp]:
    """Return the places of the speeds above zero, slowest first."""
    speeds = np.array(run.scene.speeds)
    moving = np.flatnonzero(speeds > 0.0)
    return np.asarray(moving[np.argsort(speeds[moving])])


def energy_label(energy: float) -> str:
    """Return an energy, eV, in words."""
    return f"{energy:.3g} eV"


def speed_label(speed: float) -> str:
    """Return a speed, m/s, in words."""
    return f"{speed:g} m/s"


def theory_of(run: Run, column: str) -> dict[str, Estimate]:
    """Return the calibrated theory of what the scene asks for; empty for the column sliding: it takes seconds."""
    return {} if column == SLIDING else fields.asked(run.scene)


def quantile_lines(run: Run, column: str, place: int) -> list[ReactionLine]:
    """Return the temperatures at one speed that shares of the heat, and of the contact area, do not exceed."""
    hotter = 100.0 * (1.0 - np.array([*LEVELS.values()]))
    nothing = np.full(hotter.shape, np.nan)
    theory = {} if column == SLIDING else fields.calibrated_predictions(run.scene)
    lines = []
    for of, label in (("", "of the heat"), ("area_", "of the area")):
        names = [f"temperature_quantile_{of}{name}" for name in LEVELS]
        found = [run.estimate(name, column) for name in names]
        mean = np.array([one.mean[place] for one in found])
        error = np.array([one.total_error[place] for one in found])
        drawn = np.array([theory[name][place] for name in names]) if theory else nothing
        lines.append(
            ReactionLine(
                label, hotter, mean, error, prediction.calibrated_share(run.scene)[place] * drawn
            )
        )
    return lines


def activation_lines(run: Run, found: Estimate, theory: Estimate | None) -> list[ReactionLine]:
    """Return the activation temperatures over the energy, a line for each speed above zero."""
    energies = found.coords["energy"]
    order = np.argsort(energies)
    drawn = _values(found, theory)
    return [
        ReactionLine(
            speed_label(run.scene.speeds[k]),
            energies[order],
            found.mean[order, k],
            found.total_error[order, k],
            drawn[order, k],
        )
        for k in moving_places(run)
    ]


def lines_over_speed(run: Run, found: Estimate, theory: Estimate | None) -> list[ReactionLine]:
    """Return an observable over the speeds above zero, a line for each energy or temperature."""
    fast = moving_places(run)
    speeds = np.array(run.scene.speeds)
    axis = found.dims[0]
    label = energy_label if axis == "energy" else "{:g} K".format
    drawn = _values(found, theory)
    return [
        ReactionLine(
            label(number),
            speeds[fast],
            found.mean[k, fast],
            found.total_error[k, fast],
            drawn[k, fast],
        )
        for k, number in enumerate(found.coords[axis].tolist())
    ]


def _values(found: Estimate, theory: Estimate | None) -> Array:
    """Return the values of the theory beside an estimate; NaN without a theory."""
    return np.full(found.mean.shape, np.nan) if theory is None else theory.mean
