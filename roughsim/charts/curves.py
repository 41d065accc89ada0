"""Curves of scenes and runs beside one another: C(q), g_σ(r), and observables over the speed."""

from collections.abc import Mapping, Sequence
from math import degrees
from pathlib import Path
from textwrap import fill, wrap
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from roughsim import prediction
from roughsim.charts.numbers import MARKS
from roughsim.charts.spectra import draw_correlation, draw_cut_offs, draw_psd
from roughsim.charts.style import (
    CALIBRATED,
    COLOURS,
    DASHES,
    MARKERS,
    THEORY,
    USUAL,
    Look,
    band,
    log_values,
    new_figure,
    no_formula,
    on_axis,
    scale_colours,
)
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.theories import OVER_SPEED as DENSE
from roughsim.results.columns import UP_TO_CUT_OFF, is_simulated
from roughsim.results.row import NOTICED
from roughsim.results.run import Run
from roughsim.results.theories import THEORIES, theory_columns
from roughsim.scene import Scene
from roughsim.show.table import shown, with_unit
from roughsim.show.text import plain
from roughsim.table import AT_CUT_OFF, Estimate, unknown_parts

PSD, CORRELATION, RATIO = "psd", "correlation", "ratio"
ALL = (PSD, CORRELATION, "flash_temperature", RATIO, "flash_width", "slope_length")
_DRAWN = tuple(name for name in ALL if name in OBSERVABLES)
# observables over the speed with a symbol; others are named in words
_SYMBOLS = {
    "flash_temperature": r"$T_\mathrm{flash}$",
    "flash_gradient": r"$T'_\mathrm{flash}$",
    "flash_laplacian": r"$\nabla^2 T_\mathrm{flash}$",
    "flash_width": r"$D_\mathrm{flash}$",
    "slope_length": r"$d_\mathrm{flash}$",
}
# colour of a theory, its dashes, and its place above others
_SOURCES: dict[str, Any] = dict.fromkeys(THEORIES, ("0.5", ":", 2))
_SOURCES |= {"theory": (THEORY, "-", 2), "calibrated": (CALIBRATED, DASHES, 3)}
_WORDS = {"flash_width": "hot-spot width"}  # where they differ from the name
OVER_SPEED = tuple(name for name, record in OBSERVABLES.items() if record.per_speed)
_ONE, _MANY = (5.4, 3.8), (9.6, 6.6)  # sizes of a figure of one panel and of all, inches
_LETTERS, _WIDE = 46, 125  # of a line of text in the legend, and below all panels


class Entry(NamedTuple):
    """A scene with a label, and its run with results of it if there is one."""

    label: str
    scene: Scene
    run: Run | None = None
    results: Mapping[str, Estimate] = MappingProxyType({})

    def columns(self) -> list[str]:
        """Return the simulated columns of the results."""
        first = next(iter(self.results.values()), None)
        columns = [] if first is None else first.coords["column"].tolist()
        return [column for column in columns if is_simulated(column)]

    def by_direction(self) -> "list[Entry]":
        """Return an entry for each direction of sliding with results of its own; itself if there is none."""
        return [
            Entry(
                f"{self.label}, {degrees(angle):.4g}°",
                self.scene.towards(angle),
                self.run,
                {name: one.sel(direction=angle) for name, one in self.results.items()},
            )
            for angle in self.scene.directions
        ] or [self]

    def in_motion(self, observable: str, column: str) -> Estimate:
        """Return an observable of a column at the speeds above rest."""
        found = self.results[observable].sel(column=column)
        return found.sel(speed=[speed for speed in found.coords["speed"] if speed > 0.0])


def curves_chart(
    path: str | Path | None,
    entries: Sequence[Entry],
    quantities: Sequence[str] = ALL,
    title: str = "",
    look: Look = USUAL,
) -> None:
    """Draw each quantity in a panel: PSD, CORRELATION, RATIO, or an observable over the speed, of all entries.

    RATIO is T_flash over that of the theory. Over the speed each direction with results of its own is an entry.
    One entry has a colour for each source: theories and columns. Several have a colour each, and sources differ by
    lines and markers; words beside the legend of a single run name its bands and the share of the heat. ValueError if a
    quantity has no curve for these entries; one run at rest has panels without axes.
    """
    several, one_run = len(quantities) > 1, len(entries) == 1 and entries[0].run is not None
    whole, entries = entries, [part for entry in entries for part in entry.by_direction()]
    at_rest = any(_speeds(entry.scene).size == 0 for entry in entries)
    for quantity in quantities:
        if quantity not in (PSD, CORRELATION) and at_rest and not (several and one_run):
            raise ValueError(
                f"{quantity} is over the speed, and no speed is above 0 m/s; add one to sliding.speed"
            )
    size = _MANY if several else _ONE
    with new_figure(path, size, no_formula(title), look) as figure:
        panels: list[Axes] = list(figure.subplots(2, 3).ravel()) if several else [figure.subplots()]
        # a single one has a colour for each source
        colours = [None] if len(entries) == 1 else scale_colours(len(entries))
        for axes, quantity in zip(panels, quantities, strict=False):
            if at_rest and quantity not in (PSD, CORRELATION):
                axes.set_axis_off()
                continue
            alike = quantity in (PSD, CORRELATION) and len(whole) == 1
            for entry, colour in zip(whole if alike else entries, colours, strict=not alike):
                _draw(axes, entry, quantity, None if alike else colour)
            _name_axes(axes, entries, quantity)
        handles = _handles(panels, entries, colours, quantities)
        if several:
            about = _about_run(entries[0]) if one_run else None
            place: dict[str, Any] = {"loc": "outside lower left", "ncols": 3, "alignment": "left"}
            figure.legend(handles=handles, title=about, fontsize=9, title_fontsize=9, **place)
        else:
            panels[0].legend(handles=handles, loc="best")


def _speeds(scene: Scene) -> Array:
    """Return the speeds of a scene above 0, m/s."""
    return np.array([speed for speed in scene.speeds if speed > 0.0])


def _draw(axes: Axes, entry: Entry, quantity: str, colour: str | None) -> None:
    """Draw a quantity of an entry; `colour` is None for the colours of the sources."""
    if quantity == PSD:
        draw_psd(axes, entry.scene, 1.4, colour or THEORY)
        if entry.run is not None:
            draw_cut_offs(axes, entry.run, colour)
    elif quantity == CORRELATION:
        _draw_correlation(axes, entry, colour)
    elif quantity == RATIO:
        _draw_ratios(axes, entry, colour)
    else:
        draw_over_speed(axes, entry, quantity, colour)


def _draw_correlation(axes: Axes, entry: Entry, colour: str | None) -> None:
    """Draw g_σ(r) by both theories, and measured."""
    r = distances(entry.scene)
    theory = prediction.correlation(entry.scene, r) * 1e-18
    law = prediction.calibrated_correlation(entry.scene, r) * 1e-18
    _line(axes, r * 1e6, theory, entry, "theory", colour)
    _line(axes, r * 1e6, law, entry, "calibrated", colour)
    if entry.run is not None:
        for column in entry.run.numerics.columns:
            draw_correlation(axes, entry.run, column, r, colour, f"{entry.label}: {column}")


def distances(scene: Scene) -> Array:
    """Return the distances at which g_σ is drawn, m: up to 0.4 of the longest wave, dense at 0, where it is steep."""
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    return np.asarray(0.4 * longest * np.linspace(0.0, 1.0, 100) ** 3)


def _line(axes: Axes, x: Array, y: Array, entry: Entry, source: str, colour: str | None) -> None:
    """Draw a line of a theory, unless it has no value."""
    if np.isnan(y).all():
        return
    usual, dashes, order = _SOURCES[source]
    # the gid names the curve in the file of the numbers
    style: dict[str, Any] = {"ls": dashes, "zorder": order, "gid": f"{entry.label}: {source}"}
    axes.plot(x, y, color=colour or usual, lw=1.2, **style)


def draw_over_speed(axes: Axes, entry: Entry, observable: str, colour: str | None = None) -> None:
    """Draw an observable by all theories and in each measured column over the speed."""
    factor = shown(OBSERVABLES[observable].unit)[1] * _sign(observable)
    for source, (speed, values) in theories(entry.scene, observable).items():
        _line(axes, speed, values * factor, entry, source, colour)
    if observable not in entry.results:
        return
    if colour is None and _is_cut(entry, observable):
        cut = entry.in_motion(observable, UP_TO_CUT_OFF)
        axes.plot(
            cut.coords["speed"], cut.mean * factor, color=THEORY, lw=1.2, ls="--", gid=UP_TO_CUT_OFF
        )
    for column in entry.columns():
        found = entry.in_motion(observable, column)
        if np.isnan(found.mean).all():  # a slide lacks some observables
            continue
        speed, mean, error = found.coords["speed"], found.mean * factor, found.total_error
        of_column = colour or COLOURS[column]
        band(axes, speed, mean, error * abs(factor), of_column, f"{entry.label}: {column}")
        marks = _marks_of(column, colour)
        axes.plot(speed, mean, ls="", ms=3.5, gid=MARKS, **marks)


def _draw_ratios(axes: Axes, entry: Entry, colour: str | None) -> None:
    """Draw T_flash of each other theory and of each measured column over T_flash of the theory."""
    others = theories(entry.scene, "flash_temperature")
    speed, theory = others.pop("theory")
    for source, (at, values) in others.items():
        _line(axes, at, values / np.interp(at, speed, theory), entry, source, colour)
    for column in entry.columns():
        found, below = (entry.in_motion("flash_temperature", name) for name in (column, "theory"))
        ratio, of_column = found.mean / below.mean, colour or COLOURS[column]
        error, name = found.total_error / below.mean, f"{entry.label}: {column}"
        band(axes, found.coords["speed"], ratio, error, of_column, name)
        axes.plot(
            found.coords["speed"], ratio, ls="", ms=3.5, gid=MARKS, **_marks_of(column, colour)
        )


def _marks_of(column: str, colour: str | None) -> dict[str, Any]:
    """Return the markers of a column in a colour, or its own; if columns share a colour one of them is hollow."""
    own = colour or COLOURS[column]
    face = "white" if colour and column == "smoothed" else own
    return {"marker": MARKERS[column], "color": own, "mfc": face}


def _is_cut(entry: Entry, observable: str) -> bool:
    """Return whether the theory up to q_c differs noticeably from the theory over the whole spectrum."""
    cut, whole = (entry.in_motion(observable, column).mean for column in (UP_TO_CUT_OFF, "theory"))
    return bool(np.any(np.abs(cut - whole) > NOTICED * np.abs(whole)))


def theories(scene: Scene, observable: str) -> dict[str, tuple[Array, Array]]:
    """Return speeds, m/s, and values there of each theory with the share of the heat; SI.

    The speeds are dense where a theory gives any speed, else the speeds of the scene.
    """
    speed, found = _speeds(scene), {}
    if observable in DENSE:
        # a table over temperature may end at the highest speed
        beyond = 1.5 if np.isinf(scene.temperature_range[1]) else 1.0
        speed = np.union1d(np.geomspace(speed.min() / 1.5, speed.max() * beyond, 60), speed)
        theory = prediction.over_speed(scene, speed)[observable]
        law = prediction.calibrated_over_speed(scene, speed)[observable]
        if OBSERVABLES[observable].heated:
            theory = theory * prediction.heat_partition(scene, speed)
            law = law * prediction.calibrated_share(scene, speed)
        found = {"theory": (speed, theory), "calibrated": (speed, law)}
    moving, columns = np.array(scene.speeds) > 0.0, theory_columns(scene)
    for name in THEORIES:
        one = None if name in found else columns[name](observable)
        if one is not None:
            found[name] = _speeds(scene), one.mean[moving]
    return found


def _sign(observable: str) -> float:
    """Return −1 for gradient and Laplacian, which are negative where the contact is hot."""
    return -1.0 if observable in ("flash_gradient", "flash_laplacian") else 1.0


def _name_axes(axes: Axes, entries: Sequence[Entry], quantity: str) -> None:
    """Set titles, labels and scales of a panel."""
    if quantity == PSD:
        title = r"$C(q)$ solid, $C_\mathrm{sm}(q)$ dashed"
        if any(entry.run for entry in entries):
            title += ", $q_c$ dotted"
        axes.set(xlabel="$q$ (rad/m)", ylabel="$C$ (m⁴)", title=title)
        return
    if quantity == CORRELATION:
        axes.axhline(0.0, color="0.7", lw=0.6, zorder=0)
        axes.set(
            xlabel="$r$ (µm)",
            ylabel=r"$g_\sigma$ (GPa²)",
            title="Stress correlation",
            xlim=(0, None),
        )
        if all(_falls_early(line) for line in axes.lines if line.get_gid()):
            end = distances(entries[0].scene)[-1] * 1e6
            axes.set(xscale="log", xlim=(1e-4 * end, end))
        return
    if quantity == RATIO and not axes.lines:  # neither a law nor a run
        axes.set_axis_off()
        return
    if quantity == RATIO:
        axes.axhline(1.0, color=THEORY, lw=1.2, zorder=0)
        label = r"$T_\mathrm{flash}$ over the theory"
        axes.set(xscale="log", xlabel="$v$ (m/s)", ylabel=label, title="Ratio to the theory")
        return
    words = _WORDS.get(quantity, quantity.replace("_", " "))
    symbol = ("−" if _sign(quantity) < 0.0 else "") + _SYMBOLS.get(quantity, words)
    label = on_axis(with_unit(symbol, OBSERVABLES[quantity].unit))
    axes.set(xscale="log", xlabel="$v$ (m/s)", ylabel=label)
    cut = dict.fromkeys(_column_at_cut_off(entry, quantity) for entry in entries)
    columns = ", ".join(column for column in cut if column)
    axes.set_title(words[0].upper() + words[1:] + (f" ({columns}: at $q_c$)" if columns else ""))
    if all(np.nanmin(line.get_ydata(), initial=np.inf) > 0.0 for line in axes.lines):
        log_values(axes)


def _falls_early(line: Line2D) -> bool:
    """Return whether a line from x = 0 has fallen to a tenth within a tenth of its axis."""
    x, y = np.transpose(line.get_xydata())
    return bool(y[np.searchsorted(x, 0.1 * x[-1])] < 0.1 * y[0])


def _column_at_cut_off(entry: Entry, observable: str) -> str:
    """Return the column whose values of an observable are marked to be at q_c: the main one of a run; "" if none is."""
    if entry.run is None or observable not in entry.results:
        return ""
    notes = [entry.in_motion(observable, column).note for column in entry.columns()]
    marked = any((note == AT_CUT_OFF).any() for note in notes)
    return entry.run.numerics.columns[-1] if marked else ""


def _handles(
    panels: Sequence[Axes],
    entries: Sequence[Entry],
    colours: Sequence[Any],
    quantities: Sequence[str],
) -> list[Any]:
    """Return the entries of the legend: scenes by colour, then sources by line and marker."""
    handles: list[Any] = []
    if colours[0]:
        for entry, colour in zip(entries, colours, strict=True):
            label = fill(plain(entry.label), _LETTERS)
            handles.append(Line2D([], [], color=colour, lw=3.0, label=label))
    if tuple(quantities) == (PSD,):
        return handles
    gammas = {f"{entry.scene.theory.gamma:g}" for entry in entries}
    words = {"calibrated": "calibrated stress spectrum"}
    words["theory"] = rf"theory, $\gamma$ = {gammas.pop()}" if len(gammas) == 1 else "theory"
    lines = [str(line.get_gid()) for axes in panels for line in axes.lines]
    for name, (own, dashes, _) in _SOURCES.items():
        if name == "theory" or any(line.endswith(f": {name}") for line in lines):
            colour, label = THEORY if colours[0] else own, words.get(name, name)
            handles.append(Line2D([], [], color=colour, lw=1.2, ls=dashes, label=label))
    if UP_TO_CUT_OFF in lines:
        label = "theory up to $q_c$"
        handles.append(Line2D([], [], color=THEORY, lw=1.2, ls="--", label=label))
    for name in dict.fromkeys(column for entry in entries for column in entry.columns()):
        marks = _marks_of(name, colours[0] and THEORY)
        label = f"{name}, ± total error, 95 %"
        handles.append(Line2D([], [], ms=4, lw=1.0, label=label, **marks))
    return handles


def _about_run(entry: Entry) -> str:
    """Return lines on a run, its bands and the share of its heat, which a figure shows as they are."""
    run = entry.run
    assert run is not None
    drawn = [entry.in_motion(name, column) for name in _DRAWN for column in entry.columns()]
    # bandwidth is in the titles as "at q_c"
    unknown = [part for part in unknown_parts(drawn) if part != "bandwidth"]
    lines = [
        f"{plain(run.scene.title)}; {run.extent}; heat share in the body: {run.share_text()}",
        "bands: total error, 95 %; of the stress correlation: statistical, 95 %",
        f"at least, as these parts of the error are unknown: {', '.join(unknown)}" * bool(unknown),
    ]
    return "\n".join(no_formula(part) for line in lines for part in wrap(line, _WIDE))
