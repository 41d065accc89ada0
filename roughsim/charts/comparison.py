"""A comparison as a figure: measured bands over theory lines."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from roughsim import prediction
from roughsim.charts.curves import distances, theories
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
    new_figure,
    plain_ticks,
)
from roughsim.results.row import Row
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.show.table import shown
from roughsim.show.text import plain
from roughsim.table import AT_CUT_OFF

# observables drawn over speed → title, symbol, and SI unit
_DRAWN = {
    "flash_temperature": ("Flash temperature", r"$T_\mathrm{flash}$", "K"),
    "flash_width": ("Hot-spot width", r"$D_\mathrm{flash}$", "m"),
    "slope_length": ("Slope length", r"$d_\mathrm{flash}$", "m"),
}


def comparison_chart(run: Run, rows: Sequence[Row], path: Path | None, look: Look = USUAL) -> None:
    """Draw C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v) and d_flash(v); `rows` as of `roughsim.compare`."""
    with new_figure(path, (9.6, 5.8), look=look) as figure:
        psd, correlation, *over_speed, words = figure.subplots(2, 3).ravel()
        draw_psd(psd, run.scene, 1.4)
        if not run.scene.elastic:
            note = r"$C(q)$ solid" + "\n" + r"$C_\mathrm{sm}(q)$ dashed"
            box = {
                "facecolor": psd.get_facecolor(),
                "edgecolor": "none",
                "pad": 1.0,
            }  # over the lines of the cut-offs
            psd.text(
                0.97,
                0.96,
                note,
                transform=psd.transAxes,
                fontsize=8,
                ha="right",
                va="top",
                bbox=box,
            )
        r = distances(run.scene)
        correlation.plot(
            r * 1e6, prediction.correlation(run.scene, r) * 1e-18, color=THEORY, lw=1.4
        )
        law = prediction.calibrated_correlation(run.scene, r) * 1e-18
        correlation.plot(r * 1e6, law, color=CALIBRATED, lw=1.4, ls=DASHES, zorder=3)
        for column in run.numerics.columns:
            draw_correlation(correlation, run, column, r)
        draw_cut_offs(psd, run)
        psd.set(xlabel="$q$, rad/m", ylabel="$C$, m⁴", title=r"Roughness; dotted: cut-offs $q_c$")
        correlation.axhline(0.0, color="0.7", lw=0.6, zorder=0)
        correlation.set(
            xlabel="$r$, µm",
            ylabel=r"$g_\sigma$, GPa²",
            title="Stress correlation",
            xlim=(0, r[-1] * 1e6),
        )
        for axes, observable in zip(over_speed, _DRAWN, strict=True):
            draw_over_speed(axes, run, rows, observable)
        _draw_legend(words, run, [row for row in rows if row.observable in _DRAWN and row.speed])


def draw_over_speed(axes: Axes, run: Run, rows: Sequence[Row], observable: str) -> None:
    """Draw an observable over the speed: both theories, the theory up to q_c if it differs, and each column."""
    rows = [row for row in rows if row.observable == observable and row.speed]
    speed = np.array([row.speed for row in rows])
    if speed.size == 0:  # only at rest
        axes.set_axis_off()
        return
    words, label, si = _DRAWN[observable]
    unit, factor = shown(si)
    _draw_theory(axes, run.scene, observable, factor)
    if any(row.cut for row in rows):
        axes.plot(
            speed,
            [row.theories["theory_at_cut_off"] * factor for row in rows],
            color=THEORY,
            lw=1.2,
            ls="--",
        )
    for column in rows[0].columns:
        _draw_measured(axes, rows, column, factor)
    if any(row.note == AT_CUT_OFF for row in rows):
        words += f" ({run.numerics.columns[-1]}: at $q_c$)"
    axes.set(xscale="log", yscale="log", xlabel="$v$, m/s", ylabel=f"{label}, {unit}", title=words)
    low, high = axes.get_ylim()
    if high / low < 100.0:  # 20, 50, 100 on an axis of less than two decades
        plain_ticks(axes.yaxis)


def _draw_theory(axes: Axes, scene: Scene, observable: str, factor: float) -> None:
    """Draw an observable over and a little beyond the speeds, by the theory and by the calibrated law."""
    dense, by = theories(scene, observable)
    axes.plot(dense, by["theory"] * factor, color=THEORY, lw=1.4)
    axes.plot(dense, by["calibrated"] * factor, color=CALIBRATED, lw=1.4, ls=DASHES, zorder=3)


def _draw_measured(axes: Axes, rows: Sequence[Row], column: str, factor: float) -> None:
    """Draw the values of a column over the speed with their errors; nothing for observables that a slide lacks."""
    speed = np.array([row.speed for row in rows])
    mean = np.array([row.columns[column].mean for row in rows]) * factor
    error = np.array([row.columns[column].total_error for row in rows]) * factor
    if not np.isnan(mean).all():
        band(axes, speed, mean, error, COLOURS[column])
        axes.plot(speed, mean, ls="", marker=MARKERS[column], ms=3.5, color=COLOURS[column])


def _draw_legend(axes: Axes, run: Run, drawn: Sequence[Row]) -> None:
    """Draw the legend of lines and bands, and lines of text about the run."""
    axes.set_axis_off()
    meanings = {
        "smoothed": r"smoothed: elastic contact on $C_\mathrm{sm}$",
        "capped": r"capped: contact with $p \leq \sigma_P$",
        "elastic": "elastic contact",
        "sliding": "sliding: both faces move (own heat share)",
    }
    label = rf"theory, $\gamma$ = {run.scene.theory.gamma:g}, whole spectrum"
    handles: list[Any] = [Line2D([], [], color=THEORY, lw=1.4, label=label)]
    if np.isfinite([row.calibrated for row in drawn]).any():
        error = prediction.calibrated(run.scene).errors["flash_temperature"]
        label = rf"calibrated stress spectrum: $T_\mathrm{{flash}}$ ± {100 * error:.0f} %"
        handles.append(Line2D([], [], color=CALIBRATED, lw=1.4, ls=DASHES, label=label))
    if any(row.cut for row in drawn):
        handles.append(Line2D([], [], color=THEORY, lw=1.2, ls="--", label="theory up to $q_c$"))
    for column in drawn[0].columns if drawn else run.numerics.columns:
        style: Any = {"color": COLOURS[column], "marker": MARKERS[column], "ms": 4, "lw": 1.0}
        handles.append(Line2D([], [], label=meanings[column], **style))
    axes.legend(handles=handles, loc="upper left", borderaxespad=0)
    text = _text_of_run(run, drawn)
    axes.text(
        0,
        0.6,
        text,
        transform=axes.transAxes,
        va="top",
        fontsize=8,
        linespacing=1.4,
        parse_math=False,
    )


def _text_of_run(run: Run, drawn: Sequence[Row]) -> str:
    """Return lines on the run, the bands and the heat share."""
    unknown = dict.fromkeys(part for row in drawn for part in row.unknown)
    unknown.pop("bandwidth", None)  # in the titles as "at q_c"
    lines = [
        plain(run.scene.title),
        run.extent,
        "bands: total error, 95 %; of the stress correlation: statistical, 95 %",
        f"at least, as these parts of the error are unknown: {', '.join(unknown)}"
        if unknown
        else "",
        f"heat share in the body: {run.share_text()}",
    ]
    return "\n".join(fill(line, 50) for line in lines if line)
