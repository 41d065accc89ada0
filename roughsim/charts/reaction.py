"""What a reaction feels: quantiles of the temperature, activation temperatures over energy, rates over speed."""

from math import degrees
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from roughsim.charts.style import (
    CALIBRATED,
    COLOURS,
    DASHES,
    Subject,
    band,
    legend_below,
    new_figure,
    on_axis,
    row_of_panels,
    scale_colours,
    under_title,
)
from roughsim.estimate.asked import ABOUT, ACTIVATION, RATE
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.results import columns, theories
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import with_unit
from roughsim.table import Estimate, Results, concat

HOTTER, WARM, RATES = "hotter", ACTIVATION, RATE  # panels
_LABELS = {"energy": "{:.3g} eV", "temperature": "{:g} K", "speed": "{:g} m/s"}
Lines = dict[str, Estimate]  # by their labels, over the column and one other axis
_WIDTH = 4.4  # of a panel, inches
_POINTS: dict[str, Any] = {"marker": "o", "ms": 3}
_ERRORS = _POINTS | {"capsize": 2}


def reaction_lines(run: Run, column: str, direction: float | None = None) -> dict[str, Lines]:
    """Return the lines of each panel: temperatures, K, over the share that is hotter, %, and T_act, K, over E, eV, and
    rates over v, m/s, in a direction, radians, by default the first; the run needs two sound realizations.

    There are none if the scene asks for no distribution of the temperature, or has no speed above zero.
    """
    if not (run.scene.distribution and any(run.scene.speeds)):
        return {}
    kinds = {"of the heat": "temperature_quantile_", "of the area": "temperature_quantile_area_"}
    quantiles = [kind + level for kind in kinds.values() for level in LEVELS]
    found = _results(run, [*quantiles, ACTIVATION, RATE], column, direction)
    hotter, shares = {}, 100.0 * (1.0 - np.array([*LEVELS.values()]))
    for label, kind in kinds.items():
        pieces = {(k,): found[kind + level] for k, level in enumerate(LEVELS)}
        joined = concat(pieces, {"share": shares})
        hotter[label] = joined.sel(speed=joined.coords["speed"].max())
    if run.scene.reaction is None:
        return {HOTTER: hotter}
    return {
        HOTTER: hotter,
        WARM: _lines(found[ACTIVATION], "energy"),
        RATES: _lines(found[RATE], "speed"),
    }


def _results(
    run: Run, observables: list[str], column: str, direction: float | None = None
) -> Results:
    """Return observables of a column in a direction, by default the first, and of the calibrated theory.

    That is not beside the column sliding: it takes seconds.
    """
    chosen = [column] if column == SLIDING else [column, theories.CALIBRATED]
    at = run.scene.first_direction if direction is None else {"direction": direction}
    return columns.results_of(run, observables, chosen).sel(**at)


def _lines(found: Estimate, along: str) -> Lines:
    """Return an estimate in motion along one of its axes, ascending: a line for each label of the other axis."""
    speeds = found.coords["speed"]
    found = found.sel(speed=np.sort(speeds[speeds > 0.0]))
    if along == "energy":
        found = found.sel(energy=np.sort(found.coords[along]))
    (other,) = {*found.dims} - {"column", along}
    labels = found.coords[other].tolist()
    return {_LABELS[other].format(label): found.sel(**{other: label}) for label in labels}


def points_of(line: Estimate, column: str) -> tuple[Array, Estimate, Array | None]:
    """Return the places of a line, a column of it, and the calibrated theory; None where there is none."""
    one, theory = line.sel(column=column), None
    if theories.CALIBRATED in line.coords["column"]:
        found = line.sel(column=theories.CALIBRATED).mean
        theory = found if np.isfinite(found).any() else None
    (places,) = one.coords.values()
    return places, one, theory


def reaction_chart(subject: Subject, path: Path) -> None:
    """Draw the share of contact that is hotter than T, and of a reaction T_act over E and the rate over the speed.

    Means over all realizations with their total errors, 95 %; the calibrated theory, which is not drawn for the
    column sliding, is dashed. ValueError if the run has no distribution of the temperature, or no speed above zero.
    """
    if not subject.run.scene.distribution:
        raise subject.run.not_asked("distribution of the temperature")
    _check_motion(subject)
    lines = reaction_lines(subject.run, subject.column)
    size = _WIDTH * len(lines), 3.9
    with new_figure(path, size, _title(subject), subject.look) as figure:
        panels = row_of_panels(figure, len(lines))
        _draw_hotter(panels[0], subject, lines[HOTTER])
        if WARM in lines:
            _draw_temperatures(panels[1], subject.column, lines[WARM])
            _draw_over_speed(panels[2], subject.column, lines[RATES])
            panels[2].set_title("Rate per nominal area")


def over_speed_chart(name: str, subject: Subject, path: Path) -> None:
    """Draw a row that a scene asks for, as "reaction_rate", over the speed: a line for each energy or temperature.

    Errors and theory as of `reaction_chart`. ValueError if the scene does not ask for it, or has no speed above zero.
    """
    found = _results(subject.run, [name], subject.column)
    if name not in found:
        raise subject.run.not_asked(name)
    _check_motion(subject)
    with new_figure(path, (_WIDTH, 3.9), _title(subject), subject.look) as figure:
        _draw_over_speed(figure.subplots(), subject.column, _lines(found[name], "speed"))


def _check_motion(subject: Subject) -> None:
    """Raise ValueError if no speed is above zero."""
    if not any(subject.run.scene.speeds):
        raise ValueError(
            "speed = 0 m/s makes no heat to draw; give the scene a speed, for example 1"
        )


def _title(subject: Subject) -> str:
    angles = subject.run.scene.first_direction.values()
    none = subject.column == SLIDING or angles  # no theory, as of faces with a lay
    dashed = "" if none else "; dashed: calibrated theory"
    at = "".join(f", sliding at {degrees(angle):.4g}°" for angle in angles)
    words = f"{subject.column} contact{at}, total errors 95 %{dashed}"
    return under_title(subject.run.scene.title, words)


def _draw_hotter(axes: Axes, subject: Subject, lines: Lines) -> None:
    """Draw the shares of the heat and of the contact area that are hotter than T at the highest speed."""
    shares, _, theory = points_of(lines["of the heat"], subject.column)
    if theory is not None:
        label = "of the heat, calibrated theory"
        axes.plot(theory, shares, color=CALIBRATED, lw=1.0, ls=DASHES, label=label)
    colour = COLOURS[subject.column]
    for (label, line), own in zip(lines.items(), (colour, "0.5"), strict=True):
        one = line.sel(column=subject.column)
        style = _ERRORS | {"color": own, "lw": 1.2, "label": label}
        axes.errorbar(one.mean, shares, xerr=one.total_error, **style)
    speed = max(subject.run.scene.speeds)
    flash = subject.run.estimate("flash_temperature", subject.column)
    flash = flash.sel(speed=speed, **subject.run.scene.first_direction)
    axes.axvline(float(flash.mean), color=colour, lw=1.0, ls="--")
    title = f"Share that is hotter, {speed:g} m/s"
    axes.set(yscale="log", xlabel="$T$ (K)", ylabel="% hotter than $T$", title=title)
    legend_below(axes)


def _draw_temperatures(axes: Axes, column: str, lines: Lines) -> None:
    """Draw activation temperatures over the energy, a line for each speed."""
    for (label, line), colour in zip(lines.items(), scale_colours(len(lines)), strict=True):
        energies, one, theory = points_of(line, column)
        style = _ERRORS | {"color": colour, "label": label}
        axes.errorbar(energies, one.mean, yerr=one.total_error, **style)
        if theory is not None:
            axes.plot(energies, theory, color=colour, lw=1.0, ls=DASHES)
    axes.set(xlabel="$E$ (eV)", ylabel=r"$T_\mathrm{act}$ (K)", title="Activation temperature")
    legend_below(axes, title="$v$", columns=2)


def _draw_over_speed(axes: Axes, column: str, lines: Lines) -> None:
    """Draw estimates of one observable over the speed, a line for each energy or temperature."""
    for (label, line), colour in zip(lines.items(), scale_colours(len(lines)), strict=True):
        speeds, one, theory = points_of(line, column)
        band(axes, speeds, one.mean, one.total_error, colour, label)
        axes.lines[-1].set(label=label, **_POINTS)
        if theory is not None:
            gid = f"{label}: calibrated theory"
            axes.plot(speeds, theory, color=colour, lw=1.0, ls=DASHES, gid=gid)
    name = one.observable
    axes.set(
        xscale="log",
        xlabel="$v$ (m/s)",
        ylabel=on_axis(with_unit(name.replace("_", " "), one.unit)),
    )
    if name == RATE:
        axes.set_yscale("log")
    legend_below(axes, title="$E$" if ABOUT[name] == "energy" else "$T$", columns=2)
