"""The figures of the elastic part: ratios over load and speed, the stress spectrum, and the calibrated form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

from theory import persson
from theory.calibrated import LIGHTEST
from validity_map import elastic, report

mpl.use("Agg")
mpl.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
mpl.rcParams.update({"figure.constrained_layout.use": True, "savefig.dpi": 130, "savefig.bbox": "tight"})
mpl.rcParams.update({"axes.grid": True, "grid.alpha": 0.25, "lines.linewidth": 1.3})

COLOURS = {0.3: "#0072b2", 0.55: "#009e73", 0.8: "#e69f00", 1.0: "#d55e00"}
LOAD = r"load  $p/(E^*h')$"
PANELS = (
    ("flash_temperature", 1e-3, r"$T_\mathrm{flash}$, slow (Pe 0.001)"),
    ("flash_temperature", 1e3, r"$T_\mathrm{flash}$, fast (Pe 1000)"),
    ("pressure_variance", np.nan, r"$g_\sigma(0)$"),
    ("flash_width", 1.0, r"$D_\mathrm{flash}$ (Pe 1)"),
    ("slope_length", 1e3, r"$d_\mathrm{flash}$, fast (Pe 1000)"),
    ("contact_fraction", np.nan, "contact area"),
)


def draw(tables: Any, results: dict[str, list[Any]], folder: Path) -> None:
    """Draw all figures of the elastic part into `folder`."""
    over_load(tables["elastic"], folder / "validity_elastic.png")
    over_speed(tables["elastic"], folder / "validity_speed.png")
    spectra(results["grid"], folder / "validity_spectrum.png")
    calibrated(results, folder / "validity_calibrated.png")


def column(table: Any, name: str, peclet: float) -> int:
    """Return the place of a quantity in a table."""
    return next(
        k
        for k, (other, pe) in enumerate(table.quantities)
        if other == name and (np.isnan(peclet) or np.isclose(pe, peclet))
    )


def over_load(table: Any, path: Path) -> None:
    """Measured/theory over load: colours are H, the line is the middle bandwidth, the band all of them."""
    figure = Figure(figsize=(9.0, 5.4))
    for axes, (name, peclet, title) in zip(figure.subplots(2, 3).flat, PANELS, strict=True):
        k = column(table, name, peclet)
        for hurst in np.unique(table.place[:, 1]):
            _family(axes, table, k, hurst)
        axes.axhline(1.0, color="0.3", lw=0.8)
        axes.set(xscale="log", title=title, xlabel=LOAD)
        axes.margins(x=0.03)
    figure.axes[0].set_ylabel("simulated / theory")
    figure.axes[3].set_ylabel("simulated / theory")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    figure.savefig(path)


def _family(axes: Any, table: Any, k: int, hurst: float) -> None:
    rows = table.place[:, 1] == hurst
    loads = np.unique(table.place[rows, 0])
    at = [table.value[rows & (table.place[:, 0] == p), k] for p in loads]
    widths = np.unique(table.place[rows, 2])
    middle = widths[widths.size // 2]
    line = rows & (table.place[:, 2] == middle)
    order = np.argsort(table.place[line, 0])
    x, y, error = (v[line][order] for v in (table.place[:, 0], table.value[:, k], table.error[:, k]))
    colour = COLOURS.get(float(hurst), "0.5")
    axes.fill_between(loads, [v.min() for v in at], [v.max() for v in at], color=colour, alpha=0.15, lw=0)
    axes.errorbar(x, y, y * error, color=colour, marker="o", ms=3, capsize=2, label=f"H = {hurst:g}")


def over_speed(table: Any, path: Path) -> None:
    """T_flash measured/theory over the Péclet number for some loads, at both ends of H."""
    figure = Figure(figsize=(7.2, 3.2))
    columns = [k for k, (name, _) in enumerate(table.quantities) if name == "flash_temperature"]
    peclet = [table.quantities[k][1] for k in columns]
    loads = np.unique(table.place[:, 0])
    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, loads.size))
    hursts = np.unique(table.place[:, 1])
    panels = figure.subplots(1, 2, sharey=True)
    for axes, hurst in zip(panels, (hursts[0], hursts[-1]), strict=True):
        width = np.unique(table.place[:, 2])
        middle = width[width.size // 2]
        for load, shade in zip(loads, shades, strict=True):
            row = np.flatnonzero((table.place[:, :3] == (load, hurst, middle)).all(axis=1))[0]
            y, error = table.value[row, columns], table.error[row, columns]
            axes.errorbar(peclet, y, y * error, color=shade, marker="o", ms=3, capsize=2, label=f"{load:g}")
        axes.axhline(1.0, color="0.3", lw=0.8)
        axes.set(xscale="log", title=rf"H = {hurst:g}, $q_1/q_r$ = {middle:g}", xlabel=r"Péclet number  $v/(D q_r)$")
        axes.xaxis.set_minor_locator(NullLocator())
    panels[0].set_ylabel(r"$T_\mathrm{flash}$, simulated / theory")
    panels[1].legend(title=LOAD, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path)


def spectra(results: list[Any], path: Path) -> None:
    """W/P in band against the published form and the calibrated one, and |σ_q|² q⁴ beyond q₁."""
    chosen = [
        (p, raw) for p, raw in results if p.bandwidth == max(q.bandwidth for q, _ in results if q.bandwidth <= 16)
    ]
    loads = sorted({p.load for p, _ in chosen if p.load >= LIGHTEST})
    picked = [loads[0], loads[len(loads) // 2], loads[-1]] if len(loads) > 2 else loads
    hursts = sorted({p.hurst for p, _ in chosen})
    figure = Figure(figsize=(8.0, 6.0))
    panels = figure.subplots(2, 2, sharex="row", sharey="row")
    for (top, bottom), hurst in zip(panels.T, (hursts[0], hursts[-1]), strict=True):
        shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.8, len(picked)))
        for load, shade in zip(picked, shades, strict=True):
            point, raw = next((p, r) for p, r in chosen if p.load == load and p.hurst == hurst)
            _weights(top, point, raw, shade)
            _tail(bottom, point, raw, shade)
        top.set(xscale="log", title=f"H = {hurst:g}", xlabel=r"$q/q_r$")
        top.xaxis.set_major_locator(FixedLocator([0.5, 1, 2, 4, 8, 16]))
        top.xaxis.set_major_formatter(ScalarFormatter())
        top.xaxis.set_minor_locator(NullLocator())
        bottom.set(xscale="log", yscale="log", xlabel=r"$q/q_1$")
        bottom.xaxis.set_major_locator(FixedLocator([0.5, 1, 2, 4]))
        bottom.xaxis.set_major_formatter(ScalarFormatter())
        bottom.xaxis.set_minor_locator(NullLocator())
    panels[0, 0].set_ylabel("W/P")
    panels[0, 0].legend(title=LOAD)
    panels[1, 0].set_ylabel(r"$|\sigma_q|^2 q^4$ / its full-contact value at $q_1$")
    lines = [mpl.lines.Line2D([], [], color="0.4", ls=style) for style in ("", "-", ":")]
    lines[0].set(marker="o", ms=3)
    panels[0, 1].legend(lines, ["simulated", "calibrated", "published, γ = 0.45"])
    figure.savefig(path)


def _form(point: elastic.Point) -> Any:
    return persson.calibrated_spectrum(point.spectrum, effective_modulus=1.0, nominal_pressure=point.load)


def _weights(axes: Any, point: elastic.Point, raw: Any, shade: Any) -> None:
    edges, full = elastic.EDGES, raw["full_bands"]
    inside = (full > 0.0) & (edges[:-1] > 1.02 / point.plateau) & (edges[1:] <= point.bandwidth * 1.001)
    q = np.sqrt(edges[1:] * edges[:-1])[inside]
    pressures = {"effective_modulus": 1.0, "nominal_pressure": point.load}
    share = persson.contact_probability(q, point.spectrum, **pressures)
    ratio = raw["bands"][:, inside] / full[inside] / share
    error = ratio.std(axis=0, ddof=1) / np.sqrt(ratio.shape[0])
    axes.errorbar(q, ratio.mean(axis=0), 2 * error, fmt="o", ms=2.5, lw=0.8, color=shade, label=f"{point.load:g}")
    fine = np.geomspace(1.001 / point.plateau, point.bandwidth, 200)
    probability = persson.contact_probability(fine, point.spectrum, **pressures)
    axes.plot(fine, _form(point).weight(fine) / probability, color=shade)
    axes.plot(fine, 0.45 + 0.55 * probability**2, color=shade, ls=":")


def _tail(axes: Any, point: elastic.Point, raw: Any, shade: Any) -> None:
    pixels = max(k for k in (8, 16) if f"bands{k}" in raw)
    edges, sums = elastic.EDGES, raw[f"bands{pixels}"].mean(axis=0)
    end = point.bandwidth
    there = (edges[:-1] > 0.5 * end) & (edges[1:] < elastic.CUT * pixels / 2 * end) & (sums > 0.0)
    q = np.sqrt(edges[1:] * edges[:-1])[there]
    density = (sums / (np.pi * (edges[1:] ** 2 - edges[:-1] ** 2)))[there]
    unit = (end / 2) ** 2 * float(point.spectrum(end)) * end**4
    axes.plot(q / end, density * q**4 / unit, "o", ms=2.5, color=shade)
    fine = np.geomspace(0.5 * end, 6 * end, 200)
    axes.plot(fine / end, _form(point)(fine) * fine**4 / unit, color=shade)


def calibrated(results: dict[str, list[Any]], path: Path) -> None:
    """Form/measured of every scored quantity: the fitted half, the other half, other long waves, fresh points."""
    figure = Figure(figsize=(8.0, 3.4))
    left, right = figure.subplots(1, 2, width_ratios=(1, 2))
    names = {
        "fitted": "fitted",
        "judged": "rest of the grid",
        "families": "other long waves",
        "fresh": "fresh, off the grid",
    }
    place = 0
    for k, (key, title) in enumerate(names.items()):
        points = [pair for pair in results.get(key, []) if pair[0].load >= LIGHTEST]
        if not points:
            continue
        error = np.concatenate([report.misses(*pair)[0] for pair in points])
        jitter = np.random.default_rng(k).uniform(-0.3, 0.3, error.size)
        right.plot(place + jitter, 100 * error, ".", ms=3, color=f"C{k}", alpha=0.7)
        label = f"{title}\n{len(points)} points\nrms {100 * np.sqrt((error**2).mean()):.1f} %"
        right.annotate(label, (place, 1.0), xycoords=("data", "axes fraction"), ha="center", fontsize=8)
        place += 1
    right.axhspan(-5, 5, color="0.9", lw=0)
    right.set(xticks=[], ylabel="calibrated / simulated − 1, %", ylim=(-12, 12))
    everything = [pair for key in names for pair in results.get(key, []) if pair[0].load >= LIGHTEST]
    published = np.concatenate([report.misses(*pair, gamma=0.45)[0] for pair in everything])
    left.hist(100 * np.expm1(published), bins=40, color="0.6")
    left.set(xlabel="published (γ = 0.45) / simulated − 1, %", ylabel="quantities")
    figure.savefig(path)
