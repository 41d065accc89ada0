"""The figures of the hardness-capped part: the three columns, areas by magnification, and the worn surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from theory import persson, plasticity
from validity_map import capped
from validity_map.charts import column
from validity_map.tables import area_ratios, limits

STYLES = {
    "smoothed": ("#0072b2", r"elastic on $C_{sm}$ / theory"),
    "steps": ("#e69f00", r"capped / elastic on $C_{sm}$"),
}
DASHES = {0.3: "--", 0.55: ":", 0.8: "-"}  # by H
STYLES["capped"] = ("#d55e00", "capped / theory")


def draw(tables: Any, results: list[Any], folder: Path) -> None:
    """Draw all figures of the capped part into `folder`."""
    columns(tables, folder / "validity_capped.png")
    areas(results, folder / "validity_areas.png")
    worn(results, folder / "validity_worn.png")


def columns(tables: Any, path: Path) -> None:
    """The two ratios and their product over pressure/hardness, slow and fast; the steels as stars."""
    figure = Figure(figsize=(8.0, 3.4))
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (peclet, words) in zip(panels, ((1e-3, "slow (Pe 0.001)"), (1e3, "fast (Pe 1000)")), strict=True):
        for name, (colour, label) in STYLES.items():
            table = limits(tables[name])
            k = column(table, "flash_temperature", peclet)
            steel = np.array([bool(text) for text in table.labels])
            for yields in np.unique(table.place[~steel, 1]):
                for hurst in np.unique(table.place[~steel, 2]):
                    rows = ~steel & (table.place[:, 1] == yields) & (table.place[:, 2] == hurst)
                    x, y, error = table.place[rows, 0], table.value[rows, k], table.error[rows, k]
                    style = DASHES.get(float(hurst), "-")
                    axes.errorbar(x, y, y * error, color=colour, ls=style, lw=0.8, marker=".", ms=4, alpha=0.7)
            y, error = table.value[steel, k], table.error[steel, k]
            axes.errorbar(table.place[steel, 0], y, y * error, fmt="*", ms=9, color=colour, mec="k", mew=0.5)
            axes.plot([], [], color=colour, marker=".", label=label)
        axes.axhline(1.0, color="0.3", lw=0.8)
        axes.set(
            xscale="log", xlabel=r"pressure / hardness  $\sigma_0/\sigma_P$", title=rf"$T_\mathrm{{flash}}$, {words}"
        )
    panels[0].set_ylabel("ratio")
    for style, words in (
        ("-", "H = 0.8, from below: $q_y/q_r$ = 1, 2, 4"),
        (":", "H = 0.55: $q_y/q_r$ = 1, 2"),
        ("--", "H = 0.3: $q_y/q_r$ = 1, 2"),
    ):
        panels[1].plot([], [], style, color="0.5", lw=0.8, label=words)
    panels[1].plot([], [], "*", color="0.7", mec="k", mew=0.5, ms=9, label="the three steels")
    panels[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path)


def _plain_ticks(axes: Any, places: list[float]) -> None:
    axes.xaxis.set_major_locator(FixedLocator(places))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_locator(NullLocator())


def areas(results: list[Any], path: Path) -> None:
    """Total and yielded area over the magnification: theory as lines, contacts as points."""
    shares = sorted({p.share for p, _ in results if not p.label})
    picked = [s for s in (0.03, 0.1, 0.25) if s in shares] or shares
    figure = Figure(figsize=(8.4, 3.2))
    for axes, share in zip(figure.subplots(1, len(picked), squeeze=False)[0], picked, strict=True):
        point, raw = max(
            ((p, r) for p, r in results if p.share == share and not p.label and p.hurst == 0.8),
            key=lambda pair: pair[0].yields,
        )
        _areas_of(axes, point, raw)
        axes.set(xscale="log", title=rf"$\sigma_0/\sigma_P$ = {share:g}", xlabel=r"$q_c/q_y$")
        axes.set_ylim(bottom=0.0)
        _plain_ticks(axes, [0.25, 0.5, 1, 2, 4])
    figure.axes[0].set_ylabel("share of the nominal area")
    figure.axes[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path)


def _areas_of(axes: Any, point: capped.CappedPoint, raw: Any) -> None:
    rows = area_ratios(point, raw)
    x = np.array([row["factor"] for row in rows])
    fine = np.geomspace(x[0] / 1.2, x[-1] * 1.2, 100)
    variance = persson.half_variance(fine * point.yields, point.spectrum, effective_modulus=1.0)
    load = point.pressures["nominal_pressure"]
    _, left, yielded = plasticity.area_fractions(variance, load, point.hardness)
    axes.plot(fine, left + yielded, color="#0072b2", label="theory, all contact")
    axes.plot(fine, yielded, color="#d55e00", label="theory, yielded")
    raw_total = [row["raw_total"] for row in rows]
    axes.plot(x, raw_total, "x", ms=4, color="0.5", label="pixels counted, 4 per wave")
    for name, colour in (("total", "#0072b2"), ("plastic", "#d55e00")):
        y, error = ([row[key] for row in rows] for key in (name, f"{name}_error"))
        axes.errorbar(x, y, error, fmt="o", ms=4, capsize=2, color=colour)
    axes.plot([], [], "o", color="0.3", label="contacts, corrected\nand extrapolated")


def worn(results: list[Any], path: Path) -> None:
    """Spectrum of the plastically deformed surface over the original one, beside Eq. (27)."""
    figure = Figure(figsize=(6.6, 3.4))
    axes = figure.add_subplot()
    shares = sorted({p.share for p, _ in results if not p.label})
    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(shares)))
    for share, shade in zip(shares, shades, strict=True):
        point, raw = max(
            ((p, r) for p, r in results if p.share == share and not p.label and p.hurst == 0.8),
            key=lambda pair: pair[0].yields,
        )
        q, ratio = raw["psd_wavenumber"][0], raw["psd_ratio"]
        mean, count = np.nanmean(ratio, axis=0), np.isfinite(ratio).sum(axis=0)
        error = 2 * np.nanstd(ratio, axis=0, ddof=1) / np.sqrt(np.maximum(count, 1))
        axes.errorbar(q / point.yields, mean, error, fmt="o", ms=3, color=shade, label=f"{share:g}")
        fine = np.geomspace(1.001 / point.plateau, q[-1], 200)
        factor = point.smoothed(fine) / point.spectrum(fine)
        axes.plot(fine / point.yields, factor, color=shade)
    axes.set(xscale="log", xlabel=r"$q/q_y$", ylabel="C(q) after / before", ylim=(0.0, 1.05))
    _plain_ticks(axes, [0.25, 0.5, 1, 2, 4, 8])
    axes.legend(title=r"$\sigma_0/\sigma_P$", loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path)
