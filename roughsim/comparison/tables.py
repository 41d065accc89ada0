"""Plans, theory and comparisons as tables for people and dicts for programs; units are chosen here."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from roughsim import prediction
from roughsim.comparison.compare import Comparison, json_number
from roughsim.observables.catalogue import UNITS
from roughsim.show.digits import plus_minus, shown

if TYPE_CHECKING:
    from roughsim.comparison.trust import Trust
    from roughsim.planning.limits import Plausibility
    from roughsim.scene import Scene
    from roughsim.scene.numerics import Numerics

CORRELATION_POINTS = 65


def plan_table(numerics: Numerics) -> Table:
    """Return the choices of a plan with their reasons."""
    table = Table(box=None, pad_edge=False)
    for title in ("choice", "value", "because"):
        table.add_column(title, overflow="fold")
    for reason in numerics.reasons:
        table.add_row(*reason)
    return table


def facts_table(judged: Plausibility) -> Table:
    """Return what follows from a scene, for readers to judge."""
    table = Table(box=None, pad_edge=False, show_header=False)
    for row in judged.facts.rows() if judged.facts else []:
        table.add_row(*row)
    return table


def bench_tables(measured: dict[str, Any]) -> list[Table]:
    """Return a table per stage and observable of what `bench_dict` gives: the front, and the choice of the plan."""
    tables: dict[tuple[str, str], Table] = {}
    for point in measured["points"]:
        key = point["stage"], point["observable"]
        if key not in tables:
            tables[key] = Table(box=None, pad_edge=False, title=": ".join(key), title_justify="left")
            for title in ("error", "CPU s", "FFT pairs", "method", "setting", ""):
                tables[key].add_column(title, justify="right" if title in ("error", "CPU s", "FFT pairs") else "left")
        if point["front"] or point["chosen"] or point["error"] is None:
            numbers = (
                f"{point[name]:.2g}" if point[name] is not None else "–" for name in ("error", "seconds", "pairs")
            )
            notes = [word for word, true in (("front", point["front"]), ("plan", point["chosen"])) if true]
            tables[key].add_row(*numbers, point["method"], point["setting"], ", ".join(notes))
    return list(tables.values())


def theory_dict(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum as JSON values, temperatures with the share used."""
    values, share = prediction.predictions(scene), prediction.heat_partition(scene)
    distance = correlation_distances(scene)
    result: dict[str, Any] = {"speed": list(scene.speeds)}
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        result[name] = _listed(values[name] * share)
    for name in ("flash_width", "slope_length"):
        result[name] = _listed(values[name])
    return result | {
        "conductivity": _listed(prediction.conduction(scene).conductivity),
        "heat_partition": _listed(share),
        "heat_partition_theory": _listed(values["heat_partition"]),
        "contact_fraction": float(values["contact_fraction"][0]),
        "plastic_fraction": float(values["plastic_fraction"][0]),
        "pressure_correlation": {
            "r": distance.tolist(),
            "value": _listed(prediction.correlation(scene, distance)),
        },
    }


def correlation_distances(scene: Scene) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the distances r at which g_σ is tabulated, m: 0, then evenly in log r up to half the longest wave."""
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    return np.concatenate([[0.0], np.geomspace(1e-3 * longest, 0.5 * longest, CORRELATION_POINTS - 1)])


def theory_table(scene: Scene) -> Table:
    """Return the theory of a scene, a row per speed."""
    values = theory_dict(scene)
    names = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length")
    table = Table(box=None, title=scene.title or None, title_justify="left")
    table.add_column("speed m/s", justify="right")
    for name in names:
        table.add_column(f"{name} {shown(UNITS[name])[0]}", justify="right")
    if varying := np.isfinite(scene.temperature_range[1]):
        table.add_column("κ W/(m K)", justify="right")
    table.add_column("share used", justify="right")
    table.add_column("share in theory", justify="right")
    for k, speed in enumerate(scene.speeds):
        cells = [_number(values[name][k], UNITS[name]) for name in names]
        shares = [_number(values[name][k], "1") for name in ("heat_partition", "heat_partition_theory")]
        cells += [_number(values["conductivity"][k], "1")] if varying else []
        table.add_row(f"{speed:g}", *cells, *shares)
    table.caption = (
        f"contact_fraction {values['contact_fraction']:.4g}, plastic_fraction {values['plastic_fraction']:.4g}"
    )
    return table


def trust_table(known: Trust) -> Table:
    """Return how far the theory is known to be off, a row per observable; off the map only why."""
    if not known.judgements:
        table = Table(box=None, show_header=False, title="Theory against simulation", title_justify="left")
        table.add_row(f"off the map: {known.where}")
        return table
    place = {"map": "here", "calibrated": "by the calibrated stress spectrum"}[known.source]
    table = Table(box=None, title=f"Theory against simulation, {place}: {known.where}", title_justify="left")
    table.caption_justify = "left"
    speeds = sorted({j.speed for j in known.judgements if j.speed is not None})
    table.add_column("theory of", no_wrap=True)
    for heading in [f"{speed:g} m/s" for speed in speeds] or [""]:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("against")
    for name in dict.fromkeys(j.observable for j in known.judgements):
        words = {j.speed: str(j) for j in known.judgements if j.observable == name}
        cells = [words[None], *[""] * len(speeds[1:])] if None in words else [words.get(v, "") for v in speeds]
        table.add_row(name, *cells, known.against)
    lines = [f"{speed:g} m/s is off the map: {why}." for speed, why in known.off]
    lines.append("± total error, 95 %; for steady sliding, all heat in the body, the scene's gamma.")
    table.caption = "\n".join(lines)
    return table


def comparison_table(comparison: Comparison) -> Table:
    """Return the comparison, a row per observable and speed."""
    first = comparison.rows[0]
    table = Table(box=None, title=_title(comparison), title_justify="left")
    for title in ("observable", "m/s", "unit", "theory", *first.columns, *(_heading(name) for name in first.ratios)):
        table.add_column(title, justify="left" if title in ("observable", "unit") else "right", no_wrap=True)
    table.add_column("note", no_wrap=True)
    previous = ""
    for row in comparison.rows:
        name = "" if row.observable == previous else row.observable
        previous = row.observable
        speed = "" if row.speed is None else f"{row.speed:g}"
        unit, factor = shown(row.unit)
        cells = [plus_minus(x.mean * factor, x.total_error * factor, x.unknown) for x in row.columns.values()]
        ratios = [plus_minus(x.value, x.total_error, x.unknown) for x in row.ratios.values()]
        table.add_row(name, speed, unit, _number(row.theory_full_spectrum, row.unit), *cells, *ratios, row.note)
    table.caption = "\n".join((*slope_lines(comparison), *comparison_caption(comparison), *comparison.notes()))
    table.caption_justify = "left"
    return table


def slope_lines(comparison: Comparison) -> list[str]:
    """Return a line for the slope of the stress spectrum in the band of each column that has one."""
    return [
        f"slope of |σ_q|² from {one.low:.3g} to {one.high:.3g} rad/m: {one.column} "
        f"{plus_minus(one.measured, one.error)} (statistical, 95 %), theory {one.theory:.2f}"
        for one in comparison.slopes
    ]


def comparison_caption(comparison: Comparison) -> tuple[str, ...]:
    """Return what the columns and marks of a comparison mean, a sentence or two each."""
    notes = {row.note for row in comparison.rows}
    told = [
        "± total error, 95 %. theory: over the whole spectrum. The ratio to theory is over the same modes: those of "
        "the cell, up to q_c.",
        f"≥: no level of the run tells the whole error ({', '.join(comparison.unknown)})."
        if comparison.unknown
        else "",
        "identity: fixed by force balance, no agreement." if "identity" in notes else "",
        "at q_c: no limit in the cut-off, or none that the run can tell; no agreement." if "at q_c" in notes else "",
    ]
    return tuple(line for line in told if line)


def _title(comparison: Comparison) -> str:
    left_out = f", {comparison.failed} failed and left out" if comparison.failed else ""
    title = comparison.run.scene.title
    return (
        f"{title}: {comparison.realizations} realizations{left_out}"
        if title
        else f"{comparison.realizations} realizations"
    )


def _heading(name: str) -> str:
    return name.replace("_over_", "/") + (" (same modes)" if name.endswith("_over_theory") else "")


def _number(value: float | None, unit: str) -> str:
    if value is None or not isfinite(value):
        return "–"
    return f"{value * shown(unit)[1] + 0.0:.4g}"  # + 0.0: no zero is negative


def _listed(values: Any) -> list[float | None]:
    return [json_number(float(value)) for value in np.ravel(values)]
