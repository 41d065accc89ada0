"""Tables of the theory, of its error and of the error budget of a run; the theory as JSON values."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.comparison.camera import seen
from roughsim.comparison.trust import Trust
from roughsim.estimate import fields
from roughsim.estimate.asked import ABOUT, asked_names
from roughsim.estimate.errors import SOURCES
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, UNITS, observables_of
from roughsim.results.row import rows_of
from roughsim.results.run import Run
from roughsim.results.theories import (
    CALIBRATED,
    CONTACT_TEMPERATURE,
    THEORIES,
    THEORY,
    joined,
    theory_columns,
)
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import Cell, Column, Number, Table, json_value, table_of, with_unit
from roughsim.table import Estimate, heads_of

_CORRELATION_POINTS = 65
_HEATED = ("flash_temperature", "flash_gradient", "flash_laplacian")
_HOTTEST = "temperature_quantile_99"
_QUANTILES = "temperature_quantile_50", _HOTTEST  # of those that a run has
_MOST_ROWS = (
    10  # of observables that a scene asks for, before they are shown at the highest speed alone
)
_OTHERS = [name for name in THEORIES if name != THEORY]  # shown by T_flash alone
_WIDTHS = ("flash_width", "slope_length")
_AREAS = ("contact_fraction", "plastic_fraction")
OF_SLIDING = "sliding, calibrated"  # the theory of the column sliding


def theory_values(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum: arrays over speed, temperatures with the share used, and areas."""
    columns = theory_columns(scene)
    names = [*_HEATED, *_WIDTHS, "heat_partition", *_AREAS, CONTACT_TEMPERATURE]
    found = joined({name: columns[name] for name in THEORIES}, names, scene.directions)

    def values(name: str, column: str = THEORY) -> Array:
        return found[name].sel(column=column).mean.ravel()

    over_speed = {name: values(name) for name in (*_HEATED, *_WIDTHS)}
    result: dict[str, Any] = {"speed": scene.speeds} | over_speed
    if "friction_coefficient" in scene.tables:
        result["friction_coefficient"] = prediction.friction_coefficient(scene)
    result["conductivity"] = prediction.conduction(scene).conductivity
    result["heat_partition"] = prediction.heat_partition(scene)
    result["heat_partition_theory"] = values("heat_partition")
    if scene.sliding.warms:
        result[CONTACT_TEMPERATURE] = values(CONTACT_TEMPERATURE)
    for name in _OTHERS:
        result[name] = values("flash_temperature", name)
    return result | {name: float(values(name)[0]) for name in _AREAS}


def theory_dict(scene: Scene) -> dict[str, Any]:
    """Return the theory over the whole spectrum as JSON values, with g_σ(r) at 0 and up to half the longest wave."""
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    distance = np.concatenate(
        [[0.0], np.geomspace(1e-3 * longest, 0.5 * longest, _CORRELATION_POINTS - 1)]
    )
    values, law = theory_values(scene), prediction.calibrated(scene)
    values["calibrated"] = {
        "flash_temperature": values["calibrated"] if law.stress_spectrum is not None else None,
        "error": law.errors["flash_temperature"],
        "range": law.range,
        "heat_partition": prediction.calibrated_share(scene),
    } | _distribution_values(scene)
    for name, by_theory, by_law in _seen(scene):
        values["calibrated"][name] = _with_errors(by_law)
        values |= {} if by_theory is None else {name: by_theory.mean}
    if scene.sliding.history == SLIDING:
        slid = prediction.sliding_prediction(scene)
        values["calibrated"]["sliding"] = (
            None if slid is None else asdict(slid) | {"error": prediction.sliding_error(scene)}
        )
    values["pressure_correlation"] = {
        "r": distance,
        "value": prediction.correlation(scene, distance),
    }
    values = by_direction(scene, values)
    if scene.directions:
        values["direction"] = scene.directions
    return {key: json_value(value) for key, value in values.items()}


def by_direction(scene: Scene, values: Any) -> Any:
    """Return values, some by name, with arrays over the `speeds` of a scene over its directions and speeds."""
    if isinstance(values, dict):
        split = {key: by_direction(scene, value) for key, value in values.items()}
        return split | ({"speed": scene.sliding.speed} if "speed" in split else {})
    over_speed = scene.directions and np.shape(values) == (len(scene.speeds),)
    return np.reshape(values, (len(scene.directions), -1)) if over_speed else values


def _distribution_values(scene: Scene) -> dict[str, Any]:
    """Return quantiles of the temperature, and reactions, if a scene asks for them; each with its errors."""
    by_law = theory_columns(scene)[CALIBRATED]
    values: dict[str, Any] = {}
    for name in (*fields.QUANTILES, *asked_names(scene)):
        found, axis = by_law(name), ABOUT.get(name)
        if found is None:
            continue
        values[name] = _with_errors(found)
        if axis is not None:
            labels = found.coords[axis].tolist()
            values[name] = [{axis: x} | _with_errors(found.sel(**{axis: x})) for x in labels]
    return values


def _seen(scene: Scene) -> Iterator[tuple[str, Estimate | None, Estimate]]:
    """Yield what the camera of a scene sees: name, by the theory if it has it, and by the calibrated law."""
    columns = theory_columns(scene)
    for name in seen(scene):
        by_theory, by_law = columns[THEORY](name), columns[CALIBRATED](name)
        known = by_theory is not None and not np.isnan(by_theory.mean).all()
        if by_law is not None:
            yield name, by_theory if known else None, by_law


def _with_errors(found: Estimate) -> dict[str, Array]:
    """Return a value of the theory with its error by the drawing of fields, one σ, and in all, 95 %."""
    return {
        "value": found.mean,
        "standard_error": found.standard_error,
        "error": found.total_error,
    }


def theory_table(scene: Scene) -> Table:
    """Return the theory of a scene, a row per speed."""
    values, own = theory_values(scene), prediction.calibrated_share(scene)
    columns: dict[str, Sequence[Number]] = {}  # numbers over speed by title
    for name in (_HEATED[0], *_OTHERS, *_HEATED[1:], *_WIDTHS):
        unit = UNITS.get(name, "K")
        columns[with_unit(name, unit)] = _numbers(values[name], unit)
    if CONTACT_TEMPERATURE in values:
        columns[with_unit("T₀ + T_flash", "K")] = _numbers(values[CONTACT_TEMPERATURE], "K")
    titles_of_tables = {"friction_coefficient": "μ", "conductivity": "κ, W/(m K)"}
    for name, title in titles_of_tables.items():  # they differ from speed to speed
        if name in scene.tables:
            columns[title] = _numbers(values[name])
    columns["share used"] = _numbers(values["heat_partition"])
    columns["share in theory"] = _numbers(values["heat_partition_theory"])
    if isinstance(scene.sliding.heat_partition, str) and not np.isnan(own).all():
        columns["share calibrated"] = _numbers(own)
    hottest = theory_columns(scene)[CALIBRATED](_HOTTEST) if scene.distribution else None
    if hottest is not None:
        columns["99 % of the heat below, K"] = [*map(hottest.number, range(len(own)))]
    for name, by_theory, by_law in _seen(scene):
        if by_theory is not None:
            columns[with_unit(name, UNITS[name])] = _numbers(by_theory.mean, UNITS[name])
        columns[with_unit(f"{name} calibrated", UNITS[name])] = [
            *map(by_law.number, range(len(own)))
        ]
    areas = (f"{name} {values[name]:.4g}" for name in _AREAS)
    notes = [", ".join(areas), calibrated_note(scene)]
    slid = prediction.sliding_prediction(scene) if scene.sliding.history == SLIDING else None
    if slid is not None:
        columns["T_flash sliding, K"] = _numbers(slid.flash_temperature, "K")
        columns["share sliding"] = _numbers(slid.heat_partition)
        notes.append(sliding_note(scene))
    rows = [
        heads_of(at) | {title: numbers[k] for title, numbers in columns.items()}
        for k, at in enumerate(scene.cases)
    ]
    return table_of(rows, scene.title, notes)


def asked_of_scene(scene: Scene, targets: Iterable[str] = ()) -> list[str]:
    """Return the observables that a scene asks for by name: `targets`, reactions, and the distribution's quantiles."""
    names, asked = [*targets, *asked_names(scene)], scene.observables
    if asked is not None and asked.temperature_distribution:
        names += _QUANTILES
    return list(dict.fromkeys(names))


def asked_table(scene: Scene, results: Mapping[str, Estimate]) -> Table:
    """Return observables by their columns, a row per speed, or at the highest alone if there are many."""
    rows, fastest = list(rows_of(results)), max(scene.speeds)
    if many := len(rows) > _MOST_ROWS:
        rows = [row for row in rows if row.speed in (None, fastest)]
    heads = [] if many else list(dict.fromkeys(title for row in rows for title in row.heads))
    cells = []
    for row in rows:
        places = {title: row.heads.get(title, "") for title in heads}
        numbers: dict[str, Cell] = {name: one.number() for name, one in row.entries.items()}
        cells.append({"observable": with_unit(row.title, row.unit)} | places | numbers)
    title = f"at {fastest:g} m/s" * many
    return table_of(cells, title, names=("observable",))


def _numbers(values: Array, unit: str = "1") -> list[Number]:
    return [Number(float(value), unit) for value in values]


def calibrated_note(scene: Scene, names: Sequence[str] = ()) -> str:
    """Return a note on the column calibrated: its accuracy, of all observables or those named, or why it is empty."""
    law = prediction.calibrated(scene)
    if law.stress_spectrum is None:
        return f"calibrated: none, as {law.range}."
    bands = ", ".join(
        f"{100 * error:.0f} % ({name})"
        for name, error in law.errors.items()
        if name in (names or law.errors)
    )
    others = "" if names else "; other values may be further off"
    if scene.distribution and scene.directions:
        others += "; no quantiles or rates, as contacts that the law draws have no lay"
    return f"calibrated: by the calibrated stress spectrum, within {bands} of simulations{others}."


def sliding_note(scene: Scene) -> str:
    """Return a note on the theory of the column sliding, with its accuracy."""
    if prediction.calibrated(scene).stress_spectrum is None:
        return f"{OF_SLIDING}: none, as {prediction.calibrated(scene).range}."
    error = prediction.sliding_error(scene)
    within = f"within {100 * error:.0f} % of slides" if error > 0.0 else "with an unknown error"
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
    names = observables_of()
    rows = [[name, *_errors_at(known, name, places)] for name in names]
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


def budget_table(
    run: Run,
    column: str,
    speeds: Collection[int] | None = None,
    observables: Sequence[str] | None = None,
) -> Table:
    """Return observables of a column, by default all, with the parts of their errors, a row per speed.

    `speeds` are places in the scene's list of speeds; all if left out. The run needs a sound realization.
    """
    estimates = [run.estimate(name, column) for name in observables or run.observables]
    parts = list(
        dict.fromkeys(part for part in SOURCES for estimate in estimates if part in estimate.budget)
    )
    # of all observables: the first may not depend on the speed
    heads = [title for one in estimates for title in one.heads((0,) * one.mean.ndim)]
    rows: list[dict[str, Cell]] = []
    for estimate in estimates:
        name = with_unit(estimate.observable, estimate.unit)
        for place in np.ndindex(estimate.mean.shape):
            if speeds is None or place[-1] in speeds or not estimate.heads(place):
                row = dict.fromkeys(heads, "") | estimate.row(place, parts)
                rows.append({"observable": name, **row})
    notes = [
        f"n = {estimates[0].n} realizations. total error: 95 %, the root of the sum of squares of the parts; "
        "≥ if one of them is unknown, as the run does not show it (–).",
        "finest − mean: the value at the finest level minus the mean.",
    ]
    return table_of(rows, f"{column} contact", notes, names=("observable",))
