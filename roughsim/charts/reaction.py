"""What a reaction feels: quantiles of the temperature, activation temperatures and rates over speed."""

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
    new_figure,
    on_axis,
    row_of_panels,
    scale_colours,
    under_title,
)
from roughsim.estimate.asked import ACTIVATION, RATE
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.results import columns, theories
from roughsim.results.run import Run
from roughsim.results.table import Results
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import with_unit
from roughsim.table import Estimate, concat

HOTTER, WARM, RATES = "hotter", ACTIVATION, RATE  # panels
_LABELS = {"energy": "{:.3g} eV", "temperature": "{:g} K"}
Lines = dict[str, Estimate]  # by their labels, over the column and one other axis
_WIDTH = 2.7  # of a panel, inches
_POINTS: dict[str, Any] = {"marker": "o", "ms": 3}
_THEORY = "calibrated theory"
_TITLES = {WARM: "Activation temperature", RATES: "Rate per nominal area"}
_DASHED: Any = {"color": CALIBRATED, "lw": 1.0, "ls": DASHES}


def reaction_lines(run: Run, column: str, direction: float | None = None) -> dict[str, Lines]:
    """Return the lines of each panel: temperatures, K, over the share that is hotter, %, and T_act, K, and rates over
    v, m/s, for each energy, in a direction, radians, by default the first; the run needs two sound realizations.

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
        WARM: _lines(found[ACTIVATION]),
        RATES: _lines(found[RATE]),
    }


def _results(
    run: Run, observables: list[str], column: str, direction: float | None = None
) -> Results:
    """Return observables of a column in a direction, by default the first, and of the calibrated theory.

    That is not beside the column sliding: it takes seconds.
    """
    shown = [column] if column == SLIDING else [column, theories.CALIBRATED]
    chosen = {name: one for name, one in columns.columns_of(run).items() if name in shown}
    at = run.scene.first_direction if direction is None else {"direction": direction}
    return columns.results_of(run, observables, chosen).sel(**at)


def _lines(found: Estimate) -> Lines:
    """Return an estimate over the speeds above zero, ascending: a line for each energy or temperature."""
    speeds = found.coords["speed"]
    found = found.sel(speed=np.sort(speeds[speeds > 0.0]))
    (other,) = {*found.dims} - {"column", "speed"}
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
    """Draw the share of contact that is hotter than T, and of a reaction T_act and the rate over the speed.

    Means over all realizations with their total errors, 95 %; the calibrated theory, which is not drawn for the
    column sliding, is dashed. ValueError if the run has no distribution of the temperature, or no speed above zero.
    """
    if not subject.run.scene.distribution:
        raise subject.run.not_asked("distribution of the temperature")
    _check_motion(subject)
    lines = reaction_lines(subject.run, subject.column)
    size = _WIDTH * (len(lines) + 1), 3.0
    with new_figure(path, size, _title(subject), subject.look) as figure:
        hotter, *others, key = row_of_panels(figure, len(lines) + 1)
        handles = _draw_hotter(hotter, subject, lines[HOTTER])
        for axes, (name, title) in zip(others, _TITLES.items(), strict=False):
            handles |= _draw_over_speed(axes, subject.column, lines[name])
            axes.set_title(title)
        key.set_axis_off()
        key.legend(handles.values(), handles.keys(), loc="center left")


def over_speed_chart(name: str, subject: Subject, path: Path) -> None:
    """Draw a row that a scene asks for, as "reaction_rate", over the speed: a line for each energy or temperature.

    Errors and theory as of `reaction_chart`. ValueError if the scene does not ask for it, or has no speed above zero.
    """
    found = _results(subject.run, [name], subject.column)
    if name not in found:
        raise subject.run.not_asked(name)
    _check_motion(subject)
    with new_figure(path, (4.4, 3.9), _title(subject), subject.look) as figure:
        axes = figure.subplots()
        handles = _draw_over_speed(axes, subject.column, _lines(found[name]))
        axes.legend(handles.values(), handles.keys())


def _check_motion(subject: Subject) -> None:
    """Raise ValueError if no speed is above zero."""
    if not any(subject.run.scene.speeds):
        raise ValueError(
            "speed = 0 m/s makes no heat to draw; give the scene a speed, for example 1"
        )


def _title(subject: Subject) -> str:
    angles = subject.run.scene.first_direction.values()
    at = "".join(f", sliding at {degrees(angle):.4g}°" for angle in angles)
    words = f"{subject.column} contact{at}, total errors 95 %"
    return under_title(subject.run.scene.title, words)


def _draw_hotter(axes: Axes, subject: Subject, lines: Lines) -> dict[str, Any]:
    """Draw the shares of heat and contact area hotter than T at the highest speed; return what the legend names."""
    shares, _, theory = points_of(lines["of the heat"], subject.column)
    colour = COLOURS[subject.column]
    handles: dict[str, Any] = {}
    for (label, line), own in zip(lines.items(), (colour, "0.5"), strict=True):
        one = line.sel(column=subject.column)
        style = _POINTS | {"capsize": 2, "color": own, "lw": 1.2, "label": label}
        handles[label] = axes.errorbar(one.mean, shares, xerr=one.total_error, **style)
    if theory is not None:
        (handles[_THEORY],) = axes.plot(theory, shares, label=f"of the heat, {_THEORY}", **_DASHED)
    speed = max(subject.run.scene.speeds)
    flash = subject.run.estimate("flash_temperature", subject.column)
    flash = flash.sel(speed=speed, **subject.run.scene.first_direction)
    handles[r"$T_\mathrm{flash}$"] = axes.axvline(float(flash.mean), color=colour, lw=1.0, ls=":")
    title = f"Share that is hotter, {speed:g} m/s"
    axes.set(yscale="log", xlabel="$T$ (K)", ylabel="% hotter than $T$", title=title)
    return handles


def _draw_over_speed(axes: Axes, column: str, lines: Lines) -> dict[str, Any]:
    """Draw estimates of an observable over the speed for each energy or temperature; return what the legend names."""
    handles, dashed = {}, {}
    for (label, line), colour in zip(lines.items(), scale_colours(len(lines)), strict=True):
        speeds, one, theory = points_of(line, column)
        band(axes, speeds, one.mean, one.total_error, colour, label)
        handles[label] = axes.lines[-1]
        axes.lines[-1].set(label=label, **_POINTS)
        if theory is not None:
            (dashed[_THEORY],) = axes.plot(speeds, theory, gid=f"{label}: {_THEORY}", **_DASHED)
    words = one.observable.replace("_", " ")
    axes.set(xscale="log", xlabel="$v$ (m/s)", ylabel=on_axis(with_unit(words, one.unit)))
    if one.observable == RATE:
        axes.set_yscale("log")
    return handles | dashed
