"""A study as a table for people, and the words for varied keys and their values."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from itertools import product
from math import pi
from typing import Any

import numpy as np

from roughsim.estimate.asked import ABOUT, ASKED
from roughsim.estimate.levels import FLASH
from roughsim.estimate.reactions import ELECTRONVOLT
from roughsim.observables.catalogue import UNITS
from roughsim.results.theories import THEORIES
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import Cell, Number, Table, significant, table_of, with_unit
from roughsim.show.text import marked
from roughsim.studies.results import StudyResults
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import Point, key_quantity, plain_value
from roughsim.table import AXES, Estimate, marks_in_words

_PREFIXES = {  # SI unit of a key → factor, shown unit
    "Pa": (1e-6, "MPa"),
    "m": (1e6, "µm"),
    "rad/m": (1.0, "1/m"),
    "J": (1.0 / ELECTRONVOLT, "eV"),
    "rad": (180.0 / pi, "°"),
}
DIRECTION = "direction"  # axis of the results
_NAMED = 4  # points that a note names
_MOST_ROWS = 60  # of the table on a terminal
_QUANTITY = "at the highest speed"  # title
_MISFIT = " *"  # mark of a point whose levels do not suit it
_LONGEST = 40  # letters of a value in a table
_PAIRED = (
    "∂ln/∂ln: exponent from the point before, of paired surfaces: its ± is statistical, 95 %, and does not "
    "have the errors that both points share, known or not."
)
_OTHER_KIND = (
    "∂ln/∂ln: – between values of different kind: one extrapolated and the other at q_c, or with other parts of their "
    "errors unknown."
)
_NO_LOGARITHM = "∂ln/∂ln: – at values of the key that are not above 0, which have no logarithm."


def words_of(key: str) -> tuple[str, float]:
    """Return the title of an axis, and the factor from SI to its unit: ("nominal pressure, MPa", 1e-6).

    `key` is a key of the scene or an axis of the results, as "speed".
    """
    number = key_quantity(key)
    factor, unit = 1.0, AXES.get(key, "")
    if number is not None or key == DIRECTION:
        unit = "rad" if number is None else number.unit
        factor, unit = _PREFIXES.get(unit, (1.0, unit))
    text = key.partition(".")[2].replace("_", " ") or key
    return (f"{text}, {unit}" if unit else text), factor


def value_text(key: str, value: Any) -> str:
    """Return a varied value in its shown unit; lists and tables as in a scene file, shortened."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return significant(float(value) * words_of(key)[1], 5)
    if isinstance(value, (list, tuple)):
        text = f"[{', '.join(value_text(key, entry) for entry in value)}]"
    else:
        text = plain_value(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 14]} … {text[-11:]}"


def key_text(key: str, value: Any) -> str:
    """Return a varied key with its value in words: "nominal pressure 5 MPa"."""
    words, _, unit = words_of(key)[0].partition(", ")
    return f"{words} {value_text(key, value)} {unit}".rstrip()


def study_table(study: StudyResults) -> Table:
    """Return a row for each point: the varied values, T_flash at the highest speed, and its trend."""
    by_column = _at_highest_speed(study, FLASH)
    each = sorted(trends_of(study, FLASH, None), key=lambda trend: trend["speed"] or 0.0)
    trends = {(one["point"], one["key"], one.get(DIRECTION)): one for one in each}
    sources = [*THEORIES, study.column, *([SLIDING] if SLIDING in by_column else [])]
    shown = [by_column[source] for source in sources if source in by_column]
    marks = {str(mark) for one in shown for mark in one.note[~np.isnan(one.mean)] if mark}
    paired = [name for name in study.keys.values() if any(name == key for _, key, _ in trends)]
    counts = _counts(study)
    lines = [*product(study.points, _by_direction(by_column).items())]
    rows = []
    for point, (angle, values) in lines[:_MOST_ROWS]:
        row = _heads(study, point) | _direction(angle) | {"n": counts[point.name]}
        for source in sources:
            row[with_unit(source, UNITS[FLASH])] = _cell(values.get(source), point.place)
        for name in paired:
            trend = trends.get((point.name, name, angle))
            exponent = Number(trend["exponent"], "1", trend["exponent_error"]) if trend else ""
            row[f"∂ln/∂ln {name.replace('_', ' ')}"] = exponent
        rows.append(row | ({"note": _mark(values.values(), point.place)} if marks else {}))
    notes = _notes(study, shown, marks, trends.values())
    table = table_of(rows, study.scene.title, notes, texts=("note",))
    return replace(table, heads=len(study.keys))


def asked_table(study: StudyResults) -> Table | None:
    """Return a row for each reaction at each energy, each share of hot heat, and each point; None if no scene asks."""
    found = _asked(study)
    if not found:
        return None
    known = {source for by_column in found.values() for source in by_column}
    sources = [source for source in (*THEORIES, study.column, SLIDING) if source in known]
    lines = [
        (title, point)
        for title, by_column in found.items()
        for point in study.points
        if not all(np.isnan(one.mean[point.place]) for one in by_column.values())
    ]
    rows = []
    for title, point in lines[:_MOST_ROWS]:
        numbers = {source: _cell(found[title].get(source), point.place) for source in sources}
        rows.append({_QUANTITY: title} | _heads(study, point) | numbers)
    shown = (one for by_column in found.values() for one in by_column.values())
    notes = ["± total error, 95 %; activation temperatures are absolute.", *marks_in_words(shown)]
    if len(lines) > _MOST_ROWS:
        notes.append(f"The first {_MOST_ROWS} rows; `roughsim export` writes all.")
    return table_of(rows, "What reacts", notes, names=(_QUANTITY,))


def _asked(study: StudyResults) -> dict[str, dict[str, Estimate]]:
    """Return what scenes ask for at the highest speed of each point, by its title and column."""
    found: dict[str, dict[str, Estimate]] = {}
    for name, about in ABOUT.items():
        by_column = _at_highest_speed(study, name)
        labels = dict.fromkeys(x for one in by_column.values() for x in one.coords[about].tolist())
        for number, (angle, values) in product(labels, _by_direction(by_column).items()):
            at = "".join(f", {cell}°" for cell in _direction(angle).values())
            title = with_unit(f"{name}, {number:.4g} {AXES[about]}{at}", ASKED[name].unit)
            found[title] = {source: one.sel(**{about: number}) for source, one in values.items()}
    return found


def _at_highest_speed(study: StudyResults, observable: str) -> dict[str, Estimate]:
    """Return an observable at the highest speed of each point by the columns that have values."""
    found = study.table([observable], highest_speed=True).values()
    return {name: one.sel(column=name) for one in found for name in one.known("column").tolist()}


def _by_direction(
    by_column: Mapping[str, Estimate],
) -> dict[float | None, dict[str, Estimate]]:
    """Return values by column in each direction of sliding, radians; by None where nothing depends on it."""
    found = (one.coords[DIRECTION].tolist() for one in by_column.values() if DIRECTION in one.dims)
    return {
        angle: {name: one.sel(**{DIRECTION: angle}) for name, one in by_column.items()}
        for angle in next(found, [None])
    }


def _direction(angle: float | None) -> dict[str, Cell]:
    """Return a direction of sliding, if there is one, by its title."""
    return {} if angle is None else {words_of(DIRECTION)[0]: value_text(DIRECTION, angle)}


def _heads(study: StudyResults, point: Point) -> dict[str, Cell]:
    """Return the value of each varied key at a point by its title, with the section where two have the same words."""
    titles = {key: words_of(key)[0] for key in study.keys}
    heads: dict[str, Cell] = {}
    for key, title in titles.items():
        alike = [*titles.values()].count(title) > 1
        heads[f"{key.partition('.')[0]} " * alike + title] = value_text(key, point.values[key])
    return heads


def _notes(
    study: StudyResults,
    shown: Iterable[Estimate],
    marks: Collection[str],
    trends: Collection[dict[str, Any]],
) -> list[str]:
    """Return the sentences below the table."""
    notes = [
        f"{study.finished} of {len(study.points)} points finished.",
        *target_note(study),
        *_level_notes(study),
    ]
    if len(study.points) > _MOST_ROWS:
        notes.append(
            f"The first {_MOST_ROWS} points; `roughsim export` writes all, with all observables and speeds."
        )
    notes.append(f"{FLASH} at the highest speed of each point; ± total error, 95 %.")
    notes += marks_in_words(shown, marks)
    if trends:
        notes.append(_PAIRED)
    return [*notes, *_missing_notes(trends), *marked(study.warnings)]


def _counts(study: StudyResults) -> dict[str, str]:
    """Return the realizations of each point, with the mark of levels that do not suit it."""
    counts = dict.fromkeys((point.name for point in study.points), "–")
    counts |= {point.name: str(run.realizations) for point, run in study.results}
    return counts | {name: counts[name] + _MISFIT for name in study.misfits()}


def _cell(estimate: Estimate | None, place: tuple[int, ...]) -> Cell:
    """Return the value of a point with its total error."""
    return "–" if estimate is None else estimate.number(*place)


def _mark(estimates: Iterable[Estimate], place: tuple[int, ...]) -> str:
    """Return the first note on the values of a point."""
    marks = (str(one.note[place]) for one in estimates if not np.isnan(one.mean[place]))
    return next(filter(None, marks), "")


def _missing_notes(trends: Iterable[dict[str, Any]]) -> list[str]:
    """Return the reasons for missing exponents."""
    lowest = [min(trend["from"], trend["to"]) for trend in trends if np.isnan(trend["exponent"])]
    notes = []
    if any(value > 0.0 for value in lowest):
        notes.append(_OTHER_KIND)
    if any(value <= 0.0 for value in lowest):
        notes.append(_NO_LOGARITHM)
    return notes


def target_note(study: StudyResults) -> list[str]:
    """Return a sentence on the points within the target error; none if the study has no target.

    A point with an unknown part of its error, at any speed, does not count as within.
    """
    if study.target_error is None or not study.results:
        return []
    totals: dict[str, float] = {}
    unknown: dict[str, tuple[str, ...]] = {}
    for point, run in study.results:
        estimate = run.estimate("flash_temperature")
        hot = estimate.mean != 0.0
        relative = estimate.total_error[hot] / np.abs(estimate.mean[hot])
        totals[point.name] = float(relative.max(initial=0.0))
        if estimate.unknown:
            unknown[point.name] = estimate.unknown
    within = sum(
        total <= study.target_error for name, total in totals.items() if name not in unknown
    )
    text = f"Total error of T_flash at most {100 * study.target_error:.3g} % at every speed: {within} points"
    if unknown:
        parts = ", ".join(dict.fromkeys(part for each in unknown.values() for part in each))
        text += f"; at {len(unknown)} points a part of it is unknown ({parts})"
    worst = max(totals, key=totals.__getitem__)
    at_least = "≥" if worst in unknown else ""
    return [f"{text}; the largest is {at_least}{100 * totals[worst]:.3g} %, at {worst}."]


def _level_notes(study: StudyResults) -> list[str]:
    """Return sentences on points with the levels of others, and on points with unsuitable levels or cell."""
    notes = []
    later = study.later
    if later:
        names = ", ".join(later[:_NAMED]) + ", …" * (len(later) > _NAMED)
        notes.append(
            f"{len(later)} points came later and have the levels planned for the others: {names}."
        )
    misfits = study.misfits()
    if misfits:
        worst = max(misfits, key=lambda name: misfits[name][1])
        part, error = misfits[worst]
        notes.append(
            f"*: the levels or the cell do not suit {len(misfits)} points: bandwidth, last step, pixel or size alone "
            f"exceeds the error asked for; the largest is {part} {100 * error:.3g} %, at {worst}. A study of these in "
            "a folder of its own plans for them, as far as grids and cells allow."
        )
    return notes
