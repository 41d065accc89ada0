"""Tables of the theory, of its error and of the error budget of a run; the theory as JSON values."""

from collections.abc import Sequence
from dataclasses import asdict
from math import isnan
from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.comparison.trust import Trust
from roughsim.estimate import fields
from roughsim.estimate.asked import ABOUT
from roughsim.estimate.errors import SOURCES
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, UNITS, observables_of
from roughsim.results.columns import CONTACT_TEMPERATURE
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import Column, Number, Row, Table, json_value, with_unit
from roughsim.table import Estimate

_CORRELATION_POINTS = 65
_HEATED = ("flash_temperature", "flash_gradient", "flash_laplacian")
_HOTTEST = "temperature_quantile_99"
_WIDTHS = ("flash_width", "slope_length")
OF_SLIDING = "sliding, calibrated"  # the theory of the column sliding


def theory_values(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum: arrays over speed, temperatures with the share used, and areas."""
    values, share = prediction.predictions(scene), prediction.heat_partition(scene)
    result: dict[str, Any] = {"speed": scene.speeds} | {
        name: values[name] * share for name in _HEATED
    }
    result |= {name: values[name] for name in _WIDTHS}
    if "friction_coefficient" in scene.tables:
        result["friction_coefficient"] = prediction.friction_coefficient(scene)
    result |= {"conductivity": prediction.conduction(scene).conductivity, "heat_partition": share}
    result["heat_partition_theory"] = values["heat_partition"]
    if scene.sliding.duration is not None:
        result[CONTACT_TEMPERATURE] = result["flash_temperature"] + share * prediction.background(
            scene
        )
    law = prediction.calibrated_over_speed(scene, np.array(scene.speeds))
    result["calibrated"] = law["flash_temperature"] * prediction.calibrated_share(scene)
    return result | {
        name: float(values[name][0]) for name in ("contact_fraction", "plastic_fraction")
    }


def theory_dict(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum as JSON values, with g_σ(r) at 0 and up to half the longest wave."""
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    distance = np.concatenate(
        [[0.0], np.geomspace(1e-3 * longest, 0.5 * longest, _CORRELATION_POINTS - 1)]
    )
    correlation = {"r": distance, "value": prediction.correlation(scene, distance)}
    values, law = theory_values(scene), prediction.calibrated(scene)
    temperature = values["calibrated"] if law.stress_spectrum is not None else None
    band = law.errors["flash_temperature"]
    share = prediction.calibrated_share(scene)
    values["calibrated"] = {
        "flash_temperature": temperature,
        "error": band,
        "range": law.range,
        "heat_partition": share,
    }
    values["calibrated"] |= _distribution_values(scene)
    if scene.sliding.history == SLIDING:
        slid = prediction.sliding_prediction(scene)
        values["calibrated"]["sliding"] = (
            None if slid is None else asdict(slid) | {"error": prediction.sliding_error(scene)}
        )
    return {
        key: json_value(value)
        for key, value in (values | {"pressure_correlation": correlation}).items()
    }


def _distribution_values(scene: Scene) -> dict[str, Any]:
    """Return quantiles of the temperature, and reactions, if a scene asks for them; each with its errors."""
    share = prediction.calibrated_share(scene)
    found: dict[str, Any] = {
        name: {part: number * share for part, number in _with_errors(estimate).items()}
        for name, estimate in fields.quantiles(scene).items()
    }
    for name, estimate in fields.asked(scene).items():
        axis = ABOUT[name]
        found[name] = [
            {axis: label} | _with_errors(estimate.sel(**{axis: label}))
            for label in estimate.coords[axis].tolist()
        ]
    return found


def _with_errors(found: Estimate) -> dict[str, Array]:
    """Return a value of the theory with its error by the drawing of fields, one σ, and in all, 95 %."""
    return {
        "value": found.mean,
        "standard_error": found.standard_error,
        "error": found.total_error,
    }


def theory_table(scene: Scene) -> Table:
    """Return the theory of a scene, a row per speed."""
    values = theory_values(scene)
    units = UNITS | dict.fromkeys(("calibrated", CONTACT_TEMPERATURE), UNITS["flash_temperature"])
    columns = {
        name: with_unit(name, units[name])
        for name in (_HEATED[0], "calibrated", *_HEATED[1:], *_WIDTHS)
    }
    if CONTACT_TEMPERATURE in values:
        columns[CONTACT_TEMPERATURE] = with_unit("T₀ + T_flash", units[CONTACT_TEMPERATURE])
    titles_of_tables = {
        "friction_coefficient": "μ",
        "conductivity": "κ, W/(m K)",
    }  # they differ from speed to speed
    columns |= {name: title for name, title in titles_of_tables.items() if name in scene.tables}
    columns |= {"heat_partition": "share used", "heat_partition_theory": "share in theory"}
    own = prediction.calibrated_share(scene)
    if isinstance(scene.sliding.heat_partition, str) and not np.isnan(own).all():
        values |= {"calibrated_share": own}
        columns |= {"calibrated_share": "share calibrated"}
    hottest = fields.quantiles(scene).get(_HOTTEST)
    if hottest is not None:
        values |= {_HOTTEST: hottest.mean * own}
        columns |= {_HOTTEST: "99 % of the heat below, K"}
    slid = prediction.sliding_prediction(scene) if scene.sliding.history == SLIDING else None
    if slid is not None:
        values |= {
            "sliding_flash_temperature": slid.flash_temperature,
            "sliding_share": slid.heat_partition,
        }
        units |= {"sliding_flash_temperature": "K"}
        columns |= {
            "sliding_flash_temperature": "T_flash sliding, K",
            "sliding_share": "share sliding",
        }
    errors = {} if hottest is None else {_HOTTEST: hottest.total_error * own}
    rows: list[Row] = [
        (
            f"{speed:g}",
            *(
                Number(
                    float(values[name][k]),
                    units.get(name, "1"),
                    float(errors[name][k]) if name in errors else 0.0,
                )
                for name in columns
            ),
        )
        for k, speed in enumerate(scene.speeds)
    ]
    areas = (f"{name} {values[name]:.4g}" for name in ("contact_fraction", "plastic_fraction"))
    titles = ("speed, m/s", *columns.values())
    notes = [
        ", ".join(areas),
        calibrated_note(scene),
        *([sliding_note(scene)] if slid is not None else []),
    ]
    return Table([Column(title, number=True) for title in titles], rows, scene.title, notes)


def calibrated_note(scene: Scene) -> str:
    """Return a note on the column calibrated: its accuracy, or why it is empty."""
    law = prediction.calibrated(scene)
    if law.stress_spectrum is None:
        return f"calibrated: none, as {law.range}."
    bands = ", ".join(f"{error:.0%} ({name})" for name, error in law.errors.items())
    by = "calibrated: by the calibrated stress spectrum"
    return f"{by}, within {bands} of simulations; other values may be further off."


def sliding_note(scene: Scene) -> str:
    """Return a note on the theory of the column sliding, with its accuracy."""
    if prediction.calibrated(scene).stress_spectrum is None:
        return f"{OF_SLIDING}: none, as {prediction.calibrated(scene).range}."
    error = prediction.sliding_error(scene)
    within = (
        "with an unknown error, as the bodies are unlike and the contact dense"
        if isnan(error)
        else f"within {error:.0%} of slides"
    )
    return (
        f"{OF_SLIDING}: two bodies that slide, by the calibrated stress spectrum of a clipped Gaussian field, T_flash "
        f"{within}; mean over the last half of the slid distance."
    )


def trust_table(known: Trust) -> Table:
    """Return the error of the theory, a row per observable."""
    title = "Error of the theory"
    if not known.judgements:
        return Table([Column("")], [[f"not known: {known.where}"]], title)
    speeds = sorted({j.speed for j in known.judgements if j.speed is not None})
    places: list[float | None] = [*speeds] or [None]
    names = observables_of(distribution=False)
    rows: list[Row] = [[name, *_errors_at(known, name, places)] for name in names]
    notes = [
        f"high, low: of the theory against {known.against}.",
        *(f"{speed:g} m/s: not known, {reason}." for speed, reason in known.off),
        "± error band of the calibrated stress spectrum; for steady sliding, all heat in the body, the scene's gamma.",
    ]
    columns = [Column("" if place is None else f"{place:g} m/s", number=True) for place in places]
    return Table([Column("observable"), *columns], rows, title, notes)


def _errors_at(known: Trust, name: str, places: Sequence[float | None]) -> list[str]:
    """Return the error of an observable at each speed; in the first place alone if it does not depend on the speed."""
    errors = {
        judgement.speed: str(judgement)
        for judgement in known.judgements
        if judgement.observable == name
    }
    if errors and not OBSERVABLES[name].per_speed:
        return [errors[None], *("" for _ in places[1:])]
    return [errors.get(place, "not known") for place in places]


def budget_table(run: Run, column: str, speeds: Sequence[int] | None = None) -> Table:
    """Return every observable of a column with the parts of its error, a row per speed.

    `speeds` are places in the scene's list of speeds; all if left out. The run needs a sound realization.
    """
    estimates = [run.estimate(name, column) for name in run.observables]
    parts = list(
        dict.fromkeys(part for part in SOURCES for estimate in estimates if part in estimate.budget)
    )
    titles = ("speed, m/s", "mean ± total error", *parts, "finest − mean")
    rows: list[Row] = []
    for estimate in estimates:
        name = with_unit(estimate.observable, estimate.unit)
        per_speed = OBSERVABLES[estimate.observable].per_speed
        for k in (
            (range(len(run.scene.speeds)) if speeds is None else speeds) if per_speed else (0,)
        ):
            speed = f"{run.scene.speeds[k]:g}" if per_speed else ""
            rows.append([name, speed, estimate.number(k), *estimate.parts(k, parts)])
    notes = [
        f"n = {estimates[0].n} realizations. total error: 95 %, the root of the sum of squares of the parts; "
        "≥ if one of them is unknown, as no level of the run shows it (–).",
        "finest − mean: the value at the finest level minus the mean.",
    ]
    columns = [Column("observable", name=True), *(Column(title, number=True) for title in titles)]
    return Table(columns, rows, f"{column} contact", notes)
