"""Two bodies that slide over one another: their temperatures and the share of the heat over the slid distance."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from roughsim.charts.style import (
    DASHES,
    Subject,
    new_figure,
    plain_ticks,
    scale_colours,
    scaled,
    under_title,
)
from roughsim.estimate.errors import half_width, spread
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS

# title, label, and the curves drawn: solid, and dashed
_PANELS = (
    (
        "Flash temperature; dashed: frozen, all heat",
        r"$T_\mathrm{flash}$ (K)",
        ("flash_temperature", "frozen_flash_temperature"),
    ),
    (
        "Contact, background included",
        r"$\langle T\sigma\rangle/\langle\sigma\rangle$ (K)",
        ("contact_temperature",),
    ),
    ("Background, moving body; dashed: resting", "$T$ (K)", ("background", "resting_background")),
    ("Share of the heat into the moving body", "share", ("moving_share",)),
)
_DASHES = ("-", DASHES)


def sliding_chart(subject: Subject, path: Path) -> None:
    """Draw temperatures and the share over distance, a line per speed, and the turnover of the contact.

    Means over the members that slide, with their 95 % intervals. ValueError if the run has none.
    """
    run = subject.run
    curves = run.curves()
    count, speeds = len(curves["slide_moving_share"]), run.scene.speeds
    factor, unit = scaled(float(curves[AXIS][-1]), "m")
    distance, ends = curves[AXIS] * factor, np.array(run.scene.sliding.distances) * factor
    colours = scale_colours(len(speeds))
    members = f"{count} members" if count > 1 else "one member"
    faces = f"Both faces slide; {members}"
    if run.followed is not None:
        faces += f", followed over {run.followed * factor:.3g} of {ends.max():.3g} {unit}"
    title = under_title(run.scene.title, faces)
    with new_figure(path, (11.4, 5.6), title, subject.look) as figure:
        panels = figure.subplots(2, 3, sharex=True)
        for axes, (title, label, names) in zip(panels[:, :2].ravel(), _PANELS, strict=True):
            for name, dashes in zip(names, _DASHES, strict=False):
                rows = curves[f"slide_{name}"]
                for k, colour in enumerate(colours):
                    # whole steps are a little longer or shorter
                    slid = (distance <= ends[k] * (1 + 1e-2)) & np.isfinite(rows[:, k]).all(axis=0)
                    words = f"{name.removesuffix('_temperature')}, {speeds[k]:g} m/s"
                    _draw_mean(axes, distance[slid], rows[:, k, slid], colour, dashes, words)
            axes.set(xscale="log", ylabel=label, title=title)
            if label == "share":
                axes.set_ylim(0.0, 1.0)
            else:
                axes.set_yscale("log")
            axes.margins(x=0.0)
            plain_ticks(axes.xaxis)
        _draw_turnover(panels[0, 2], distance, curves)
        panels[1, 2].axis("off")
        for axes in (*panels[1, :2], panels[0, 2]):
            axes.set_xlabel(f"slid distance ({unit})")
            axes.tick_params(labelbottom=True)
        handles = [
            Line2D([], [], color=colour, label=f"{v:g} m/s")
            for colour, v in zip(colours, speeds, strict=True)
        ]
        panels[1, 2].legend(
            handles=handles, loc="upper left", title="$v$", ncols=1 + len(handles) // 10
        )


def _draw_turnover(axes: Axes, distance: Array, curves: dict[str, Array]) -> None:
    """Draw the turnover of the contact: the share of its spots that live on, and the correlation of its stress."""
    for name, dashes in zip(("spot_survival", "stress_correlation"), _DASHES, strict=True):
        rows = curves[f"slide_{name}"]
        known = np.isfinite(rows).all(axis=0)
        _draw_mean(axes, distance[known], rows[:, known], "0.2", dashes, name)
    axes.set(
        title="Spots that live on; dashed: stress correlation", ylabel="share", ylim=(-0.02, 1.02)
    )
    axes.margins(x=0.0)


def _draw_mean(
    axes: Axes, distance: Array, rows: Array, colour: str, dashes: object, name: str
) -> None:
    """Draw the mean of rows over the distance; of several rows as solid lines with the 95 % interval."""
    mean = rows.mean(axis=0)
    (line,) = axes.plot(
        distance, mean, color=colour, lw=1.3 if dashes == "-" else 0.9, ls=dashes, label=name
    )
    if len(rows) > 1 and dashes == "-":
        half = half_width(*spread(rows))
        line.half_width = half  # type: ignore[attr-defined]  # for the file of the numbers
        axes.fill_between(distance, mean - half, mean + half, color=colour, alpha=0.18, lw=0)
