"""The figure of the camera: the hole as it is seen, and the hottest track over hardness beside the measured one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from .style import BLUE, GREEN, ORANGE, PINK, SKY, new_figure

Points = list[tuple[float, float, float]]  # hardness, Pa; hottest track and its scatter, K
NAMES = {"one": "one rough face", "two": "two, half of the heat, long exposure"}
COLOURS = {"one": ORANGE, "two": BLUE}
MEASURED, MARGIN = 200.0, 0.1  # K; how well it can be read, of it


def camera(maps: dict[str, np.ndarray], hot: dict[str, Points], radius: float, path: Path) -> None:
    """Draw maps of the hole by their titles, K over the median along the rim, and the hottest tracks."""
    with new_figure(path, 7.2) as figure:
        upper, lower = figure.subfigures(2, 1, height_ratios=(2, 1.0))
        panels = upper.subplots(2, 2, sharex=True, sharey=True)
        edge = 1e3 * radius
        for panel, (title, seen) in zip(panels.flat, maps.items(), strict=True):
            extent = (-edge, edge, -edge, edge)
            look = {"cmap": "inferno", "vmin": -150, "vmax": 300, "extent": extent}
            image = panel.imshow(seen.T, origin="lower", interpolation="nearest", **look)
            panel.set(title=title, xticks=(-1, 0, 1), yticks=(-1, 0, 1))
            panel.grid(visible=False)
            panel.spines[:].set_visible(False)
            panel.tick_params(length=0)  # there is no frame that ticks could stand on
        for panel in panels[1]:
            panel.set_xlabel("along sliding (mm)")
        for panel in panels[:, 0]:
            panel.set_ylabel("across (mm)")
        upper.colorbar(image, ax=panels, label="K over the median along the rim", shrink=0.7)
        draw_hottest(lower.subplots(), hot)


def draw_hottest(axes: Axes, hot: dict[str, Points]) -> None:
    """Draw the hottest track over hardness, with its scatter between pictures."""
    low, high = (1 - MARGIN) * MEASURED, (1 + MARGIN) * MEASURED
    axes.axhspan(low, high, color="0.88", lw=0)
    axes.text(1.55, MEASURED, "measured", va="center", fontsize=8.5)
    for kind, points in hot.items():
        hardness, mean, scatter = np.array(points).T
        look = {"color": COLOURS[kind], "marker": "o", "capsize": 2.5, "label": NAMES[kind]}
        axes.errorbar(hardness / 1e9, mean, scatter, **look)
    axes.set(xscale="log", yscale="log", xlim=(0.4, 3.6), ylim=(45, 760))
    axes.set_xticks([0.5, 0.8, 1.2, 2, 3], ["0.5", "0.8", "1.2", "2", "3"])
    axes.set_yticks([50, 100, 200, 400], ["50", "100", "200", "400"])
    axes.minorticks_off()
    axes.set(xlabel="hardness (GPa)", ylabel="hottest track (K)")
    axes.legend(loc="upper left", ncols=2)


def camera_law(points: list[tuple[str, float, float, float]], path: Path) -> None:
    """Draw law/simulation over v/Dq_r by kind of picture: (kind, v/Dq_r, ratio, standard error)."""
    kinds = list(dict.fromkeys(point[0] for point in points))
    with new_figure(path, 2.8) as figure:
        axes = figure.subplots()
        colours = (BLUE, ORANGE, GREEN, PINK, SKY, PINK, SKY)
        for kind, colour in zip(kinds, colours, strict=False):
            _, speed, ratio, error = zip(*[p for p in points if p[0] == kind], strict=True)
            mark = "s" if kind.startswith("slide") else "o"
            look = {"fmt": mark, "color": colour, "capsize": 2.5}
            axes.errorbar(speed, ratio, error, label=kind.replace("camera on the ", ""), **look)
        axes.axhline(1.0, color="0.4", lw=0.8)
        axes.set(xscale="log", xlabel="speed, $v/(Dq_r)$", ylabel="rms, law / simulation")
        figure.legend(loc="outside lower center", ncols=3)
