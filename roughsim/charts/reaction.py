"""What a reaction feels: quantiles of the temperature, activation temperatures over energy, rates over speed."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from roughsim.charts.reaction_lines import (
    ReactionLine,
    activation_lines,
    lines_over_speed,
    moving_places,
    quantile_lines,
    speed_label,
    theory_of,
)
from roughsim.charts.sliding import speed_colours
from roughsim.charts.style import (
    CALIBRATED,
    COLOURS,
    Subject,
    band,
    legend_below,
    new_figure,
    row_of_panels,
)
from roughsim.estimate.asked import ABOUT, ACTIVATION, RATE
from roughsim.observables.catalogue import UNITS
from roughsim.results.reactions import not_asked
from roughsim.scene.numerics import SLIDING
from roughsim.show.text import plain

_WIDTH = 4.4  # of a panel, inches
_DASHES = (0, (4, 2))  # of the calibrated theory


def reaction_chart(subject: Subject, path: Path) -> None:
    """Draw the share of contact that is hotter than T, and of a reaction T_act over E and the rate over the speed.

    Means over all realizations with their total errors, 95 %; the calibrated theory, which is not drawn for the
    column sliding, is dashed. ValueError if the run has no distribution of the temperature, or no speed above zero.
    """
    run = subject.run
    if not run.scene.distribution:
        raise not_asked(run, "distribution of the temperature")
    fast = _moving(subject)
    reacts = run.scene.reaction is not None
    with new_figure(
        path, (_WIDTH * (3 if reacts else 1), 3.9), _title(subject), subject.look
    ) as figure:
        panels = row_of_panels(figure, 3 if reacts else 1)
        _draw_hotter(panels[0], subject, int(fast[-1]))
        if reacts:
            found, theory = run.reactions(subject.column), theory_of(run, subject.column)
            _draw_temperatures(
                panels[1], activation_lines(run, found[ACTIVATION], theory.get(ACTIVATION))
            )
            _draw_over_speed(
                panels[2],
                RATE,
                lines_over_speed(run, found[RATE], theory.get(RATE)),
                with_theory=bool(theory),
            )
            panels[2].set_title("Rate per nominal area")


def over_speed_chart(name: str, subject: Subject, path: Path) -> None:
    """Draw a row that a scene asks for, as "reaction_rate", over the speed: a line for each energy or temperature.

    Errors and theory as of `reaction_chart`. ValueError if the scene does not ask for it, or has no speed above zero.
    """
    run = subject.run
    found = run.reactions(subject.column)
    if name not in found:
        raise not_asked(run, name)
    _moving(subject)
    theory = theory_of(run, subject.column)
    lines = lines_over_speed(run, found[name], theory.get(name))
    with new_figure(path, (_WIDTH, 3.9), _title(subject), subject.look) as figure:
        _draw_over_speed(figure.subplots(), name, lines, with_theory=bool(theory))


def _moving(subject: Subject) -> NDArray[np.intp]:
    """Return the places of the speeds above zero, slowest first; ValueError if there is none."""
    places = moving_places(subject.run)
    if not places.size:
        raise ValueError(
            "speed = 0 m/s makes no heat to draw; give the scene a speed, for example 1"
        )
    return places


def _title(subject: Subject) -> str:
    scene = plain(subject.run.scene.title).replace("$", r"\$")
    dashed = "" if subject.column == SLIDING else "; dashed: calibrated theory"
    return "\n".join(
        line for line in (scene, f"{subject.column} contact, total errors 95 %{dashed}") if line
    )


def _draw_hotter(axes: Axes, subject: Subject, fastest: int) -> None:
    """Draw the shares of the heat and of the contact area that are hotter than T at the highest speed."""
    lines = quantile_lines(subject.run, subject.column, fastest)
    if subject.column != SLIDING:
        label = "of the heat, calibrated theory"
        axes.plot(
            lines[0].theory, lines[0].place, color=CALIBRATED, lw=1.0, ls=_DASHES, label=label
        )
    for line, colour in zip(lines, (COLOURS[subject.column], "0.5"), strict=True):
        style: dict[str, Any] = {"color": colour, "lw": 1.2, "marker": "o", "ms": 3, "capsize": 2}
        axes.errorbar(line.mean, line.place, xerr=line.error, label=line.label, **style)
    flash = subject.run.estimate("flash_temperature", subject.column).mean[fastest]
    axes.axvline(flash, color=COLOURS[subject.column], lw=1.0, ls="--")
    title = f"Share that is hotter, {speed_label(subject.run.scene.speeds[fastest])}"
    axes.set(yscale="log", xlabel="$T$, K", ylabel="% hotter than $T$", title=title)
    legend_below(axes)


def _draw_temperatures(axes: Axes, lines: list[ReactionLine]) -> None:
    """Draw activation temperatures over the energy, a line for each speed."""
    for line, colour in zip(lines, speed_colours(len(lines)), strict=True):
        style: dict[str, Any] = {"color": colour, "marker": "o", "ms": 3, "capsize": 2}
        axes.errorbar(line.place, line.mean, yerr=line.error, label=line.label, **style)
        axes.plot(line.place, line.theory, color=colour, lw=1.0, ls=_DASHES)
    axes.set(xlabel="$E$, eV", ylabel=r"$T_\mathrm{act}$, K", title="Activation temperature")
    legend_below(axes, title="$v$", columns=2)


def _draw_over_speed(
    axes: Axes, name: str, lines: list[ReactionLine], *, with_theory: bool
) -> None:
    """Draw estimates of one observable over the speed, a line for each energy or temperature."""
    for line, colour in zip(lines, speed_colours(len(lines)), strict=True):
        band(axes, line.place, line.mean, line.error, colour, line.label)
        axes.lines[-1].set(label=line.label, marker="o", ms=3)
        if with_theory:
            gid = f"{line.label}: calibrated theory"
            axes.plot(line.place, line.theory, color=colour, lw=1.0, ls=_DASHES, gid=gid)
    words, unit = name.replace("_", " "), UNITS[name]
    axes.set(xscale="log", xlabel="$v$, m/s", ylabel=words if unit == "1" else f"{words}, {unit}")
    if name == RATE:
        axes.set_yscale("log")
    legend_below(axes, title="$E$" if ABOUT[name] == "energy" else "$T$", columns=2)
