"""What a reaction feels, as lines for the page: quantiles of the temperature, activation temperatures, and rates."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.observables.distribution import LEVELS
from roughsim.results.reactions import ACTIVATION, RATE, Asked
from roughsim.results.run import Run

HOTTER, WARM, RATES = "hotter", ACTIVATION, RATE  # panels
Field = NDArray[Any]


class ReactionLine(NamedTuple):
    """A measured line with its total errors, 95 %, and the calibrated theory; NaN where there is none."""

    label: str
    place: Field  # % of heat or area that is hotter; E, eV; or v, m/s
    mean: Field  # temperature of the quantile, K; T_act, K; or the rate, 1/s
    error: Field
    theory: Field


def labels(run: Run) -> dict[str, list[str]]:
    """Return the labels of the lines of each panel; empty if the scene asks for no distribution of the temperature."""
    if not run.scene.distribution or not any(run.scene.speeds):
        return {}
    result = {HOTTER: ["of the heat", "of the area"]}
    if run.scene.reaction is not None:
        electronvolts = np.array(run.scene.reaction.activation_energy) / prediction.distribution.ELECTRONVOLT
        result[WARM] = [f"{run.scene.speeds[k]:g} m/s" for k in _moving(run)]
        result[RATES] = [f"{energy:.3g} eV" for energy in electronvolts]
    return result


def reaction_lines(run: Run) -> dict[str, list[ReactionLine]]:
    """Return the lines of each panel for the last column of single contacts; the run needs two sound realizations."""
    panels = labels(run)
    if not panels:
        return {}
    fast = _moving(run)
    result = {HOTTER: _quantiles(run, panels[HOTTER], int(fast[-1]))}
    if run.scene.reaction is not None:
        asked = prediction.asked_predictions(run.scene, run.heat_partition)
        theory = {one.key: one.estimate.value for one in asked}
        found = run.reactions()
        nothing = np.full(len(run.scene.speeds), np.nan)

        def table(name: str) -> tuple[Sequence[Asked], list[Field]]:
            """Return the estimates of a name, and mean, error and theory of each, (energies, speeds > 0)."""
            ones = [one for one in found if one.estimate.observable == name]
            parts = [(one.estimate.mean, one.estimate.total_error, theory.get(one.key, nothing)) for one in ones]
            return ones, [np.array(rows)[:, fast] for rows in zip(*parts, strict=True)]

        ones, parts = table(ACTIVATION)
        energies = np.array([one.energy for one in ones])
        order = np.argsort(energies)
        result[WARM] = [
            ReactionLine(label, energies[order], *(rows[order, k] for rows in parts))
            for k, label in enumerate(panels[WARM])
        ]
        ones, parts = table(RATE)
        speeds = np.array(run.scene.speeds)[fast]
        result[RATES] = [
            ReactionLine(label, speeds, *(rows[k] for rows in parts)) for k, label in enumerate(panels[RATES])
        ]
    return result


def _quantiles(run: Run, names: list[str], fastest: int) -> list[ReactionLine]:
    """Return the temperatures at the highest speed that shares of the heat and of the area do not exceed."""
    hotter = 100.0 * (1.0 - np.array([*LEVELS.values()]))
    theory, share = prediction.calibrated_predictions(run.scene), run.heat_partition[fastest]
    lines = []
    for label, of in zip(names, ("", "area_"), strict=True):
        of_levels = [f"temperature_quantile_{of}{name}" for name in LEVELS]
        found = [run.estimate(name) for name in of_levels]
        mean = np.array([one.mean[fastest] for one in found])
        error = np.array([one.total_error[fastest] for one in found])
        lines.append(
            ReactionLine(label, hotter, mean, error, np.array([share * theory[name][fastest] for name in of_levels]))
        )
    return lines


def _moving(run: Run) -> NDArray[np.intp]:
    """Return the places of the speeds above zero, slowest first."""
    speeds = np.array(run.scene.speeds)
    moving = np.flatnonzero(speeds > 0.0)
    return np.asarray(moving[np.argsort(speeds[moving])])
