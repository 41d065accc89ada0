"""What a reaction feels: quantiles of the temperature, activation temperatures over energy, rates over speed."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.sliding import speed_colours
from roughsim.charts.style import CALIBRATED, COLOURS, Subject, band, new_figure
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.results.reactions import ACTIVATION, RATE, Asked, not_asked
from roughsim.scene.numerics import SLIDING
from roughsim.show.text import plain

_WIDTH = 4.4  # of a panel, inches
_DASHES = (0, (4, 2))  # of the calibrated theory
Theory = Mapping[tuple[str, float | None, float | None], Array]  # values over speed, by the key of an estimate


def reaction_chart(subject: Subject, path: Path) -> None:
    """Draw the share of contact that is hotter than T, and of a reaction T_act over E and the rate over the speed.

    Means over all realizations with their total errors, 95 %; the calibrated theory, which the column sliding does not
    have, is dashed. ValueError if the run
    has no distribution of the temperature, or no speed above zero.
    """
    run = subject.run
    if not run.scene.distribution:
        raise not_asked(run, "distribution of the temperature")
    fast = _moving(subject)
    reacts = run.scene.reaction is not None
    with new_figure(path, (_WIDTH * (3 if reacts else 1), 3.9), _title(subject), subject.look) as figure:
        panels = figure.subplots(1, 3 if reacts else 1, squeeze=False)[0]
        _draw_hotter(panels[0], subject, int(fast[-1]))
        if reacts:
            found, theory = run.reactions(subject.column), _theory(subject)
            warm = [one for one in found if one.estimate.observable == ACTIVATION]
            _draw_temperatures(panels[1], warm, theory, np.array(run.scene.speeds), fast)
            rates = [one for one in found if one.estimate.observable == RATE]
            _draw_over_speed(panels[2], rates, theory, np.array(run.scene.speeds), fast)
            panels[2].set_title("Rate per nominal area")


def over_speed_chart(name: str, subject: Subject, path: Path) -> None:
    """Draw a row that a scene asks for, as "reaction_rate", over the speed: a line for each energy or temperature.

    Errors and theory as of `reaction_chart`. ValueError if the scene does not ask for it, or has no speed above zero.
    """
    run = subject.run
    found = [one for one in run.reactions(subject.column) if one.estimate.observable == name]
    if not found:
        raise not_asked(run, name)
    fast = _moving(subject)
    with new_figure(path, (_WIDTH, 3.9), _title(subject), subject.look) as figure:
        _draw_over_speed(figure.subplots(), found, _theory(subject), np.array(run.scene.speeds), fast)


def _moving(subject: Subject) -> NDArray[np.intp]:
    """Return the places of the speeds above zero, slowest first; ValueError if there is none."""
    speeds = np.array(subject.run.scene.speeds)
    moving = np.flatnonzero(speeds > 0.0)
    if not moving.size:
        raise ValueError("speed = 0 m/s makes no heat to draw; give the scene a speed, for example 1")
    return np.asarray(moving[np.argsort(speeds[moving])])


def _title(subject: Subject) -> str:
    scene = plain(subject.run.scene.title).replace("$", r"\$")
    dashed = "" if subject.column == SLIDING else "; dashed: calibrated theory"
    return "\n".join(line for line in (scene, f"{subject.column} contact, total errors 95 %{dashed}") if line)


def _theory(subject: Subject) -> Theory:
    """Return the calibrated theory of what the scene asks for; empty for the column sliding, which has none."""
    if subject.column == SLIDING:
        return {}
    asked = prediction.asked_predictions(subject.run.scene, subject.run.heat_partition)
    return {one.key: one.estimate.value for one in asked}


def _draw_hotter(axes: Axes, subject: Subject, fastest: int) -> None:
    """Draw the shares of the heat and of the contact area that are hotter than T at the highest speed."""
    share = 100.0 * (1.0 - np.array([*LEVELS.values()]))
    if subject.column != SLIDING:
        theory, heat = prediction.calibrated_predictions(subject.run.scene), subject.run.heat_partition[fastest]
        drawn = [heat * theory[f"temperature_quantile_{name}"][fastest] for name in LEVELS]
        axes.plot(drawn, share, color=CALIBRATED, lw=1.0, ls=_DASHES, label="of the heat, calibrated theory")
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


def _draw_temperatures(axes: Axes, found: list[Asked], theory: Theory, speeds: Array, fast: NDArray[np.intp]) -> None:
    """Draw activation temperatures over the energy, a line for each speed."""
    energies = np.array([one.energy for one in found])
    order = np.argsort(energies)
    nothing = np.full(speeds.shape, np.nan)
    for k, colour in zip(fast, speed_colours(fast.size), strict=True):
        mean = np.array([one.estimate.mean[k] for one in found])[order]
        error = np.array([one.estimate.total_error[k] for one in found])[order]
        label = f"{speeds[k]:g} m/s"
        axes.errorbar(energies[order], mean, yerr=error, color=colour, marker="o", ms=3, capsize=2, label=label)
        drawn = np.array([theory.get(one.key, nothing)[k] for one in found])[order]
        axes.plot(energies[order], drawn, color=colour, lw=1.0, ls=_DASHES)
    axes.set(xlabel="$E$, eV", ylabel=r"$T_\mathrm{act}$, K", title="Activation temperature")
    axes.legend(loc="best", title="$v$")


def _draw_over_speed(axes: Axes, found: list[Asked], theory: Theory, speeds: Array, fast: NDArray[np.intp]) -> None:
    """Draw estimates of one observable over the speed, a line for each energy or temperature."""
    for one, colour in zip(found, speed_colours(len(found)), strict=True):
        about = f"{one.temperature:g} K" if one.energy is None else f"{one.energy:.3g} eV"
        band(axes, speeds[fast], one.estimate.mean[fast], one.estimate.total_error[fast], colour, about)
        axes.lines[-1].set(label=about, marker="o", ms=3)
        if one.key in theory:
            drawn = theory[one.key][fast]
            axes.plot(speeds[fast], drawn, color=colour, lw=1.0, ls=_DASHES, gid=f"{about}: calibrated theory")
    name, unit = found[0].estimate.observable, found[0].estimate.unit
    words = name.replace("_", " ")
    axes.set(xscale="log", xlabel="$v$, m/s", ylabel=words if unit == "1" else f"{words}, {unit}")
    if name == RATE:
        axes.set_yscale("log")
    axes.legend(loc="best", title="$T$" if found[0].energy is None else "$E$")
