"""The figure of a lay: T_flash in all directions of sliding, and law over simulation of drawn faces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from theory.lay import error_band
from theory.yielding import ELASTIC_BANDS, ERROR_BANDS

from .style import BLUE, GREEN, ORANGE, new_figure

COLOURS = (GREEN, BLUE, ORANGE)
KINDS = {"elastic": (BLUE, "o", ELASTIC_BANDS), "yielding": (ORANGE, "^", ERROR_BANDS)}
Curve = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # angles, law, angles, simulation


def around(angles: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values from 0 to 90 degrees, and their mirror images, all around, in radians."""
    turn = np.radians(angles)
    quarters = (turn, np.pi - turn[::-1], np.pi + turn, 2 * np.pi - turn[::-1])
    return np.concatenate(quarters), np.concatenate([values, values[::-1]] * 2)


def lay(curves: dict[float, Curve], points: list[tuple[float, float, str]], path: Path) -> None:
    """Draw curves by lay, K, and points (lay, ratio, kind of contact) with the band of the law."""
    with new_figure(path, 6.2) as figure:
        upper, lower = figure.subfigures(2, 1, height_ratios=(1.6, 1.0))
        polar = upper.subplots(subplot_kw={"projection": "polar"})
        for (gamma, (angles, law, at, simulated)), colour in zip(
            curves.items(), COLOURS, strict=True
        ):
            polar.plot(*around(angles, law), color=colour, label=rf"$\gamma$ = {gamma:g}")
            polar.plot(*around(at, simulated), color=colour, marker="o", ls="")
        polar.plot([], color="0.3", label="law")
        polar.plot([], color="0.3", marker="o", ls="", label="simulation")
        polar.set(rlim=(0, 380))
        polar.set_rlabel_position(285)
        polar.set_rticks([100, 200, 300], ["100", "", "300 K"])
        polar.set_thetagrids(range(0, 360, 30))
        upper.legend(loc="outside lower center", ncols=5, columnspacing=1.2)
        axes = lower.subplots()
        edge = np.geomspace(1.0, 20.0, 60)
        for kind, (colour, marker, bands) in KINDS.items():
            shown = [point[:2] for point in points if point[2] == kind]
            gammas, ratio = np.array(shown).T
            axes.plot(gammas, ratio, ls="", marker=marker, ms=2.8, color=colour, label=kind)
            band = np.array([error_band(g, bands["flash_temperature"]) for g in edge])
            axes.plot(edge, 1 + band, color=colour, lw=0.7)
            axes.plot(edge, 1 - band, color=colour, lw=0.7)
        axes.axhline(1.0, color="0.4", lw=0.8)
        axes.set(
            xscale="log",
            xlim=(1.4, 20.5),
            xlabel=r"lay $\gamma$",
            ylabel=r"$T_\mathrm{flash}$, law / simulation",
        )
        axes.set_xticks([2, 3, 5, 10, 20], ["2", "3", "5", "10", "20"])
        axes.minorticks_off()
        lower.legend(loc="outside lower center", ncols=2)
