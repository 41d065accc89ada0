"""A comparison as a figure: measured bands over theory lines."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.style import COLOURS, MARKERS, THEORY, band, new_figure, save, statistical
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.show.digits import shown
from roughsim.show.text import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from roughsim.comparison.compare import Comparison, Row

Array = NDArray[np.float64]
# over speed: observable → words, label, and SI unit
DRAWN = {
    "flash_temperature": ("Flash temperature", r"$T_\mathrm{flash}$", "K"),
    "flash_width": ("Hot-spot width", r"$D_\mathrm{flash}$", "m"),
    "slope_length": ("Slope length", r"$d_\mathrm{flash}$", "m"),
}


def comparison_chart(comparison: Comparison, path: Path) -> None:
    """Draw C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v) and d_flash(v) of a comparison.

    Parameters
    ----------
    comparison : Comparison
        From `roughsim.compare`.
    path : Path
        Of the picture: .png, .pdf or .svg.

    Raises
    ------
    ValueError
        If the ending is none of these.
    """
    with new_figure(path, (9.6, 5.8)) as figure:
        places = figure.subplots(2, 3).ravel()
        _spectra(places[0], comparison)
        _correlation(places[1], comparison)
        for axes, observable in zip(places[2:], DRAWN, strict=False):
            _over_speed(axes, comparison, observable)
        _legend(places[5], comparison)
        save(figure, path)


def _spectra(axes: Axes, comparison: Comparison) -> None:
    run = comparison.run
    whole, smooth = run.scene.spectrum, prediction.smoothed_spectrum(run.scene)
    q = np.geomspace(whole.breaks[0], whole.breaks[-1], 400)
    axes.loglog(q, whole(q), color=THEORY, lw=1.4)
    if not run.scene.elastic:
        values = smooth(q)
        low = float(whole(q[-1]))
        axes.loglog(q, np.where(values > 0.1 * low, values, np.nan), color=THEORY, lw=1.2, ls="--")
        note = r"$C(q)$ solid" + "\n" + r"$C_\mathrm{sm}(q)$ dashed"
        axes.text(0.98, 0.82, note, transform=axes.transAxes, fontsize=8, ha="right")
    for column in run.numerics.columns:
        for level in run.numerics.of_column(column):
            axes.axvline(run.numerics.levels[level].q_max, color=COLOURS[column], lw=1.0, ls=":")
    axes.set(xlabel="$q$, 1/m", ylabel="$C$, m⁴", title=r"Roughness; dotted: cut-offs $q_c$")


def _correlation(axes: Axes, comparison: Comparison) -> None:
    run = comparison.run
    longest = 2 * np.pi / run.scene.spectrum.breaks[0]
    r = np.linspace(0.0, 0.4 * longest, 200)
    axes.plot(r * 1e6, prediction.correlation(run.scene, r) * 1e-18, color=THEORY, lw=1.4)
    for column in run.numerics.columns:
        mean, error = run.correlation(r, column)
        band(axes, r * 1e6, mean * 1e-18, statistical(run, column, error) * 1e-18, COLOURS[column])
    axes.axhline(0.0, color="0.7", lw=0.6, zorder=0)
    axes.set(xlabel="$r$, µm", ylabel=r"$g_\sigma$, GPa²", title="Stress correlation", xlim=(0, r[-1] * 1e6))


def _over_speed(axes: Axes, comparison: Comparison, observable: str) -> None:
    rows = [row for row in comparison.rows if row.observable == observable and row.speed]
    speed = np.array([row.speed for row in rows])
    if speed.size == 0:  # only at rest
        axes.set_axis_off()
        return
    scene, (_, label, si) = comparison.run.scene, DRAWN[observable]
    unit, factor = shown(si)
    beyond = 1.5 if np.isinf(scene.temperature_range[1]) else 1.0  # a table of conductivity may end there
    dense = np.union1d(np.geomspace(speed.min() / 1.5, speed.max() * beyond, 60), speed)
    theory = prediction.over_speed(scene, dense)[observable] * factor
    if OBSERVABLES[observable].heated:
        theory *= prediction.heat_partition(scene, dense)
    axes.plot(dense, theory, color=THEORY, lw=1.4)
    if any(row.cut for row in rows):
        axes.plot(speed, [row.theory_at_cut_off * factor for row in rows], color=THEORY, lw=1.2, ls="--")
    for column in comparison.run.numerics.columns:
        mean = np.array([row.columns[column].mean for row in rows]) * factor
        error = np.array([row.columns[column].total_error for row in rows]) * factor
        band(axes, speed, mean, error, COLOURS[column])
        axes.plot(speed, mean, ls="", marker=MARKERS[column], ms=3.5, color=COLOURS[column])
    axes.set(xscale="log", yscale="log", xlabel="$v$, m/s", ylabel=f"{label}, {unit}", title=_title(rows))
    _plain_numbers(axes)


def _plain_numbers(axes: Axes) -> None:
    """Write 20, 50, 100 on a logarithmic axis of less than two decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axes.get_ylim()
    if high / low < 100.0:
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())


def _title(rows: list[Row]) -> str:
    words = DRAWN[rows[0].observable][0]
    return rf"{words} ({list(rows[0].columns)[-1]}: at $q_c$)" if any(row.note == "at q_c" for row in rows) else words


def _drawn_unknown(comparison: Comparison) -> list[str]:
    """The parts of the errors drawn over speed that no level tells; titles name what stands at q_c."""
    rows = (row for row in comparison.rows if row.observable in DRAWN and row.speed)
    parts = dict.fromkeys(part for row in rows for cell in row.columns.values() for part in cell.unknown)
    return [part for part in parts if part != "bandwidth"]


def _legend(axes: Axes, comparison: Comparison) -> None:
    from matplotlib.lines import Line2D

    axes.set_axis_off()
    run = comparison.run
    meanings = {
        "smoothed": r"smoothed: elastic contact on $C_\mathrm{sm}$",
        "capped": r"capped: contact with $p \leq \sigma_P$",
        "elastic": "elastic contact",
    }
    label = rf"theory, $\gamma$ = {run.scene.theory.gamma:g}, whole spectrum"
    handles: list[Any] = [Line2D([], [], color=THEORY, lw=1.4, label=label)]
    if any(row.cut for row in comparison.rows if row.observable in DRAWN and row.speed):
        handles.append(Line2D([], [], color=THEORY, lw=1.2, ls="--", label="theory up to $q_c$"))
    for column in run.numerics.columns:
        style: Any = {"color": COLOURS[column], "marker": MARKERS[column], "ms": 4, "lw": 1.0}
        handles.append(Line2D([], [], label=meanings[column], **style))
    axes.legend(handles=handles, loc="upper left", borderaxespad=0)
    share = run.heat_partition
    lines = [
        plain(run.scene.title),
        f"{comparison.realizations} realizations",
        "bands: total error, 95 %; of the stress correlation: statistical, 95 %",
        f"at least, since nothing tells of: {', '.join(missing)}" if (missing := _drawn_unknown(comparison)) else "",
        f"heat share in the body {share.min():.3g}" + (f"…{share.max():.3g}" if np.ptp(share) > 0 else ""),
    ]
    text = "\n".join(fill(line, 50) for line in lines if line)
    axes.text(0, 0.6, text, transform=axes.transAxes, va="top", fontsize=8, linespacing=1.4, parse_math=False)
