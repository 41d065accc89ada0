"""What a reaction feels: quantiles of the temperature, activation temperatures over energy, rates over speed."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.sliding import speed_colours
from roughsim.charts.style import CALIBRATED, COLOURS, Subject, band, new_figure
from roughsim.observables.distribution import LEVELS
from roughsim.results.reactions import ACTIVATION, RATE
from roughsim.scene.numerics import SLIDING
from roughsim.show.text import plain

_WIDTH = 4.4  # of a panel, inches


def reaction_chart(subject: Subject, path: Path) -> None:
    """Draw the share of contact that is hotter than T, and of a reaction T_act over E and the rate over the speed.

    Means over all realizations with their total errors, 95 %; the calibrated theory, which the column sliding does not
    have, is dashed. ValueError if the run
    has no distribution of the temperature, or no speed above zero.
    """
    run = subject.run
    if not run.scene.distribution:
        raise ValueError(f"{run.folder} has no distribution of the temperature: its scene has no [reaction]")
    speeds = np.array(run.scene.speeds)
    moving = np.flatnonzero(speeds > 0.0)
    if not moving.size:
        raise ValueError("speed = 0 m/s makes no heat to draw; give the scene a speed, for example 1")
    reacts = run.scene.reaction is not None
    scene = plain(run.scene.title).replace("$", r"\$")
    dashed = "" if subject.column == SLIDING else "; dashed: calibrated theory"
    title = "\n".join(line for line in (scene, f"{subject.column} contact, total errors 95 %{dashed}") if line)
    with new_figure(path, (_WIDTH * (3 if reacts else 1), 3.9), title, subject.look) as figure:
        panels = figure.subplots(1, 3 if reacts else 1, squeeze=False)[0]
        _draw_hotter(panels[0], subject, int(moving[np.argmax(speeds[moving])]))
        if reacts:
            _draw_reaction(panels[1], panels[2], subject, moving)


def _draw_hotter(axes: Axes, subject: Subject, fastest: int) -> None:
    """Draw the shares of the heat and of the contact area that are hotter than T at the highest speed."""
    share = 100.0 * (1.0 - np.array([*LEVELS.values()]))
    if subject.column != SLIDING:
        theory, heat = prediction.calibrated_predictions(subject.run.scene), subject.run.heat_partition[fastest]
        drawn = [heat * theory[f"temperature_quantile_{name}"][fastest] for name in LEVELS]
        axes.plot(drawn, share, color=CALIBRATED, lw=1.0, ls=(0, (4, 2)), label="of the heat, calibrated theory")
    for of, colour, words in (("", COLOURS[subject.column], "of the heat"), ("area_", "0.5", "of the area")):
        found = [subject.run.estimate(f"temperature_quantile_{of}{name}", subject.column) for name in LEVELS]
        mean = np.array([estimate.mean[fastest] for estimate in found])
        error = np.array([estimate.total_error[fastest] for estimate in found])
        axes.errorbar(mean, share, xerr=error, color=colour, lw=1.2, marker="o", ms=3, capsize=2, label=words)
    flash = subject.run.estimate("flash_temperature", subject.column).mean[fastest]
    axes.axvline(flash, color=COLOURS[subject.column], lw=1.0, ls="--")
    speed = subject.run.scene.speeds[fastest]
    axes.set(yscale="log", xlabel="$T$, K", ylabel="% hotter than $T$", title=f"Share that is hotter, {speed:g} m/s")
    axes.legend(loc="lower left")


def _draw_reaction(temperatures: Axes, rates: Axes, subject: Subject, moving: NDArray[np.intp]) -> None:
    """Draw activation temperatures over the energy, a line per speed, and rates over the speed, a line per energy."""
    speeds = np.array(subject.run.scene.speeds)
    found = subject.run.reactions(subject.column)
    theory = {}
    if subject.column != SLIDING:
        asked = prediction.asked_predictions(subject.run.scene, subject.run.heat_partition)
        theory = {one.key: one.estimate.value for one in asked}
    nothing = np.full(speeds.shape, np.nan)
    warm = [one for one in found if one.estimate.observable == ACTIVATION]
    energies = np.array([one.energy for one in warm])
    order = np.argsort(energies)
    for k, colour in zip(moving, speed_colours(moving.size), strict=True):
        mean = np.array([one.estimate.mean[k] for one in warm])[order]
        error = np.array([one.estimate.total_error[k] for one in warm])[order]
        label = f"{speeds[k]:g} m/s"
        temperatures.errorbar(energies[order], mean, yerr=error, color=colour, marker="o", ms=3, capsize=2, label=label)
        drawn = np.array([theory.get(one.key, nothing)[k] for one in warm])[order]
        temperatures.plot(energies[order], drawn, color=colour, lw=1.0, ls=(0, (4, 2)))
    temperatures.set(xlabel="$E$, eV", ylabel=r"$T_\mathrm{act}$, K", title="Activation temperature")
    temperatures.legend(loc="best", title="$v$")
    fast = moving[np.argsort(speeds[moving])]
    of_rate = [one for one in found if one.estimate.observable == RATE]
    for one, colour in zip(of_rate, speed_colours(len(of_rate)), strict=True):
        band(rates, speeds[fast], one.estimate.mean[fast], one.estimate.total_error[fast], colour)
        rates.lines[-1].set_label(f"{one.energy:.3g} eV")
        rates.plot(speeds[fast], theory.get(one.key, nothing)[fast], color=colour, lw=1.0, ls=(0, (4, 2)))
    rates.set(xscale="log", yscale="log", xlabel="$v$, m/s", ylabel="rate, 1/s", title="Rate per nominal area")
    rates.legend(loc="best", title="$E$")
