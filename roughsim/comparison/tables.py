"""Theory, its trust and comparisons as tables for people, and the theory as JSON values for programs."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.comparison.compare import CONTACT_TEMPERATURE, Comparison
from roughsim.comparison.trust import Trust
from roughsim.observables.catalogue import OBSERVABLES, UNITS
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.show.table import Column, Number, Row, Table, json_value, with_unit

CORRELATION_POINTS = 65
HEATED = ("flash_temperature", "flash_gradient", "flash_laplacian")
WIDTHS = ("flash_width", "slope_length")


def theory_values(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum: arrays over speed, temperatures with the share used, and areas."""
    values, share = prediction.predictions(scene), prediction.heat_partition(scene)
    result: dict[str, Any] = {"speed": scene.speeds} | {name: values[name] * share for name in HEATED}
    result |= {name: values[name] for name in WIDTHS}
    if "friction_coefficient" in scene.tables:
        result["friction_coefficient"] = prediction.friction_coefficient(scene)
    result |= {"conductivity": prediction.conduction(scene).conductivity, "heat_partition": share}
    result["heat_partition_theory"] = values["heat_partition"]
    if scene.sliding.duration is not None:
        result[CONTACT_TEMPERATURE] = result["flash_temperature"] + share * prediction.background(scene)
    law = prediction.calibrated_over_speed(scene, np.array(scene.speeds))
    result["calibrated"] = law["flash_temperature"] * share
    return result | {name: float(values[name][0]) for name in ("contact_fraction", "plastic_fraction")}


def theory_dict(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum as JSON values, with g_σ(r) at 0 and up to half the longest wave."""
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    distance = np.concatenate([[0.0], np.geomspace(1e-3 * longest, 0.5 * longest, CORRELATION_POINTS - 1)])
    correlation = {"r": distance, "value": prediction.correlation(scene, distance)}
    values, law = theory_values(scene), prediction.calibrated(scene)
    temperature = values["calibrated"] if law.stress_spectrum is not None else None
    band = law.errors["flash_temperature"]
    values["calibrated"] = {"flash_temperature": temperature, "error": band, "range": law.range}
    return {key: json_value(value) for key, value in (values | {"pressure_correlation": correlation}).items()}


def theory_table(scene: Scene) -> Table:
    """Return the theory of a scene, a row per speed."""
    values = theory_values(scene)
    units = UNITS | dict.fromkeys(("calibrated", CONTACT_TEMPERATURE), UNITS["flash_temperature"])
    columns = {name: with_unit(name, units[name]) for name in (HEATED[0], "calibrated", *HEATED[1:], *WIDTHS)}
    if CONTACT_TEMPERATURE in values:
        columns[CONTACT_TEMPERATURE] = with_unit("T₀ + T_flash", units[CONTACT_TEMPERATURE])
    titles_of_tables = {"friction_coefficient": "μ", "conductivity": "κ, W/(m K)"}  # they differ from speed to speed
    columns |= {name: title for name, title in titles_of_tables.items() if name in scene.tables}
    columns |= {"heat_partition": "share used", "heat_partition_theory": "share in theory"}
    rows: list[Row] = [
        (f"{speed:g}", *(Number(float(values[name][k]), units.get(name, "1")) for name in columns))
        for k, speed in enumerate(scene.speeds)
    ]
    areas = (f"{name} {values[name]:.4g}" for name in ("contact_fraction", "plastic_fraction"))
    titles = ("speed, m/s", *columns.values())
    notes = [", ".join(areas), calibrated_note(scene)]
    return Table([Column(title, number=True) for title in titles], rows, scene.title, notes)


def calibrated_note(scene: Scene) -> str:
    """Return a note on the column calibrated: its accuracy, or why it is empty."""
    law = prediction.calibrated(scene)
    if law.stress_spectrum is None:
        return f"calibrated: none, as {law.range}."
    bands = ", ".join(f"{error:.0%} ({name})" for name, error in law.errors.items())
    by = "calibrated: by the calibrated stress spectrum"
    return f"{by}, within {bands} of simulations; other values may be further off."


def trust_table(known: Trust) -> Table:
    """Return how far the theory is known to be off, a row per observable; off the map only the reason."""
    title = "How far the theory is off"
    if not known.judgements:
        return Table([Column("")], [[f"unknown, off the map: {known.where}"]], title)
    where = {"map": "Place on the map", "calibrated": "By the calibrated stress spectrum"}[known.source]
    speeds = sorted({j.speed for j in known.judgements if j.speed is not None})
    rows: list[Row] = []
    for name in dict.fromkeys(j.observable for j in known.judgements):
        words = {j.speed: str(j) for j in known.judgements if j.observable == name}
        # what has no speed stands in the first column
        cells = [words[None], *[""] * len(speeds[1:])] if None in words else [words.get(v, "") for v in speeds]
        rows.append([name, *cells])
    notes = [
        f"high, low: of the theory against {known.against}.",
        f"{where}: {known.where}.",
        *(f"{speed:g} m/s is off the map: {why}." for speed, why in known.off),
        "± total error, 95 %; for steady sliding, all heat in the body, the scene's gamma.",
    ]
    headings = [f"{speed:g} m/s" for speed in speeds] or [""]
    return Table([Column("observable"), *(Column(x, number=True) for x in headings)], rows, title, notes)


def comparison_table(comparison: Comparison) -> Table:
    """Return the comparison, a row per observable and speed."""
    first, run, title = comparison.rows[0], comparison.run, comparison.run.scene.title
    ratios = (name.replace("_over_", "/") + " (same modes)" * name.endswith("_over_theory") for name in first.ratios)
    columns = [Column("observable", name=True)]
    columns += [Column(title, number=True) for title in ("m/s", "theory", "calibrated", *first.columns, *ratios)]
    rows: list[Row] = [
        (
            with_unit(row.observable, row.unit),
            "" if row.speed is None else f"{row.speed:g}",
            Number(row.theory_full_spectrum, row.unit),
            Number(row.calibrated, row.unit),
            *(Number(cell.mean, row.unit, cell.total_error, cell.unknown) for cell in row.columns.values()),
            *(Number(ratio.value, "1", ratio.total_error, ratio.unknown) for ratio in row.ratios.values()),
            row.note,
        )
        for row in comparison.rows
    ]
    count = f"{run.realizations} realizations" + (f", {run.failed} failed and left out" if run.failed else "")
    title = f"{title}: {count}" if title else count
    return Table([*columns, Column("note")], rows, title, [*meanings(comparison), *comparison.notes()])


def meanings(comparison: Comparison) -> Iterator[str]:
    """Yield notes: the slopes of the stress spectrum, and the meaning of columns and marks."""
    for slope in comparison.slopes:
        band = f"slope of |σ_q|² from {slope.low:.3g} to {slope.high:.3g} rad/m"
        measured = Number(slope.measured, error=slope.error)
        yield f"{band}: {slope.column} {measured} (statistical, 95 %), theory {slope.theory:.2f}"
    yield (
        "± total error, 95 %. theory: over the whole spectrum. The ratio to theory is over the same modes: those of "
        "the cell, up to q_c."
    )
    yield calibrated_note(comparison.run.scene)
    if comparison.run.numerics.march is not None:
        yield (
            "sliding: both faces move over one another, and the bodies share the heat point by point. T_flash is that "
            "above the background of the moving body, mean over the last half of the slid distance."
        )
    if comparison.unknown:
        yield f"≥: a part of the error is unknown, as no level of the run shows it ({', '.join(comparison.unknown)})."
    if any(row.observable == CONTACT_TEMPERATURE for row in comparison.rows):
        yield (
            f"{CONTACT_TEMPERATURE}: T₀ + T_flash of the moving body after the duration, above its temperature when "
            "sliding began. T₀ is that of the theory of heat, not simulated."
        )
    marks = {row.note for row in comparison.rows}
    if "identity" in marks:
        yield "identity: fixed by force balance, no agreement."
    if "at q_c" in marks:
        yield "at q_c: no limit in the cut-off, or none that the run shows; no agreement."


def budget_table(run: Run, column: str, speeds: Sequence[int] | None = None) -> Table:
    """Return every observable of a column with the parts of its error, a row per speed.

    `speeds` are places in the scene's list of speeds; all if left out. The run needs a sound realization.
    """
    estimates = [run.estimate(name, column) for name in OBSERVABLES]
    parts = list(estimates[0].budget)
    titles = ("m/s", "mean ± total error", *parts, "finest − mean")
    rows: list[Row] = []
    for estimate in estimates:
        unit, name = estimate.unit, with_unit(estimate.observable, estimate.unit)
        per_speed = OBSERVABLES[estimate.observable].per_speed
        for k in (range(len(run.scene.speeds)) if speeds is None else speeds) if per_speed else (0,):
            errors = (estimate.budget[part][k] for part in parts)
            small = [Number(float(x), unit, digits=2) for x in (*errors, estimate.bias[k])]
            rows.append([name, f"{run.scene.speeds[k]:g}" if per_speed else "", estimate.number(k), *small])
    notes = [
        f"n = {estimates[0].n} realizations. total error: 95 %, the root of the sum of squares of the parts; "
        "≥ where one of them is unknown, as no level of the run shows it (–).",
        "finest − mean: the value at the finest level minus the mean.",
    ]
    columns = [Column("observable", name=True), *(Column(title, number=True) for title in titles)]
    return Table(columns, rows, f"{column} contact", notes)
