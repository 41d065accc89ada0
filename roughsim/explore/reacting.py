"""What a reaction feels on the page of a run: the lines of each panel, and their labels before there are any."""

from roughsim.charts.reaction_lines import (
    ReactionLine,
    activation_lines,
    energy_label,
    lines_over_speed,
    moving_places,
    quantile_lines,
    speed_label,
    theory_of,
)
from roughsim.estimate.asked import ACTIVATION, RATE
from roughsim.estimate.reactions import ELECTRONVOLT
from roughsim.results.run import Run

HOTTER, WARM, RATES = "hotter", ACTIVATION, RATE  # panels


def labels(run: Run) -> dict[str, list[str]]:
    """Return the labels of the lines of each panel; empty if the scene asks for no distribution of the temperature."""
    if not run.scene.distribution or not any(run.scene.speeds):
        return {}
    result = {HOTTER: ["of the heat", "of the area"]}
    if run.scene.reaction is not None:
        result[WARM] = [speed_label(run.scene.speeds[k]) for k in moving_places(run)]
        result[RATES] = [
            energy_label(energy / ELECTRONVOLT) for energy in run.scene.reaction.activation_energy
        ]
    return result


def reaction_lines(run: Run) -> dict[str, list[ReactionLine]]:
    """Return the lines of each panel for the last column of single contacts; the run needs two sound realizations."""
    if not labels(run):
        return {}
    column = run.column(None)
    result = {HOTTER: quantile_lines(run, column, int(moving_places(run)[-1]))}
    if run.scene.reaction is not None:
        found, theory = run.reactions(column), theory_of(run, column)
        result[WARM] = activation_lines(run, found[ACTIVATION], theory.get(ACTIVATION))
        result[RATES] = lines_over_speed(run, found[RATE], theory.get(RATE))
    return result
