"""What a reaction feels, as lines to draw: quantiles of the temperature, activation temperatures, rates over speed."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate import fields
from roughsim.estimate.asked import ACTIVATION, Asked
from roughsim.estimate.errors import Estimate
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING

Theory = Mapping[
    tuple[str, float | None, float | None], Array
]  # values over speed, by the key of an estimate


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


def theory_of(run: Run, column: str) -> Theory:
    """Return the calibrated theory of what the scene asks for; empty for the column sliding: it takes seconds."""
    if column == SLIDING:
        return {}
    return {one.key: one.estimate.mean for one in fields.asked(run.scene)}


def quantile_lines(run: Run, column: str, place: int) -> list[ReactionLine]:
    """Return the temperatures at one speed that shares of the heat, and of the contact area, do not exceed."""
    hotter = 100.0 * (1.0 - np.array([*LEVELS.values()]))
    nothing = np.full(hotter.shape, np.nan)
    theory = {} if column == SLIDING else fields.calibrated_predictions(run.scene)
    lines = []
    for of, label in (("", "of the heat"), ("area_", "of the area")):
        names = [f"temperature_quantile_{of}{name}" for name in LEVELS]
        found = [run.estimate(name, column) for name in names]
        mean, error = (
            np.array([values[place] for values in rows]) for rows in _of_estimates(found)
        )
        drawn = np.array([theory[name][place] for name in names]) if theory else nothing
        lines.append(
            ReactionLine(
                label, hotter, mean, error, prediction.calibrated_share(run.scene)[place] * drawn
            )
        )
    return lines


def activation_lines(run: Run, found: list[Asked], theory: Theory) -> list[ReactionLine]:
    """Return the activation temperatures over the energy, a line for each speed above zero."""
    warm = [one for one in found if one.estimate.observable == ACTIVATION]
    energies = np.array([one.energy for one in warm])
    order = np.argsort(energies)
    nothing = np.full(len(run.scene.speeds), np.nan)
    rows = (
        *_of_estimates([one.estimate for one in warm]),
        [theory.get(one.key, nothing) for one in warm],
    )
    mean, error, drawn = (np.array(values)[order] for values in rows)
    return [
        ReactionLine(
            speed_label(run.scene.speeds[k]), energies[order], mean[:, k], error[:, k], drawn[:, k]
        )
        for k in moving_places(run)
    ]


def lines_over_speed(run: Run, name: str, found: list[Asked], theory: Theory) -> list[ReactionLine]:
    """Return an observable of `found` over the speeds above zero, a line for each energy or temperature."""
    fast = moving_places(run)
    speeds = np.array(run.scene.speeds)
    nothing = np.full(speeds.shape, np.nan)
    return [
        ReactionLine(
            energy_label(one.energy) if one.energy is not None else f"{one.temperature:g} K",
            speeds[fast],
            one.estimate.mean[fast],
            one.estimate.total_error[fast],
            theory.get(one.key, nothing)[fast],
        )
        for one in found
        if one.estimate.observable == name
    ]


def _of_estimates(found: list[Estimate]) -> tuple[list[Array], list[Array]]:
    """Return the means and the total errors."""
    return [one.mean for one in found], [one.total_error for one in found]
