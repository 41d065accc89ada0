"""The figures of the map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

mpl.use("Agg")
mpl.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
mpl.rcParams.update({"figure.constrained_layout.use": True, "savefig.dpi": 130, "savefig.bbox": "tight"})


def draw(tables: Any, elastics: list[Any], plastics: list[Any], folder: Path) -> None:
    table = tables["elastic"]
    figure = Figure(figsize=(6, 4))
    axes = figure.add_subplot()
    for k, (name, peclet) in enumerate(table.quantities):
        if name == "flash_temperature" and peclet in (1e-3, 1.0, 1e3):
            axes.errorbar(table.place[:, 0], table.value[:, k], table.value[:, k] * table.error[:, k], fmt="o", ms=3)
    axes.set_xscale("log")
    axes.set_xlabel("load p/(E*h')")
    axes.set_ylabel("measured/theory")
    figure.savefig(folder / "validity_elastic.png")
