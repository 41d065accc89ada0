"""A study as a table for people, and the words for varied keys and their values."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from roughsim.estimate.asked import ABOUT
from roughsim.estimate.reactions import ELECTRONVOLT
from roughsim.observables.catalogue import UNITS
from roughsim.scene.numerics import SLIDING
from roughsim.scene.written import literal
from roughsim.show.table import Cell, Column, Number, Table, significant, with_unit
from roughsim.show.text import marked
from roughsim.studies.results import StudyResults
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import Point, key_quantity
from roughsim.table import marks_in_words

_PREFIXES = {  # SI unit of a key → factor, shown unit
    "Pa": (1e-6, "MPa"),
    "m": (1e6, "µm"),
    "rad/m": (1.0, "1/m"),
    "J": (1.0 / ELECTRONVOLT, "eV"),
}
_OF_ROWS = {
    "energy": "eV",
    "temperature": "K",
}  # of a reaction, and of the heat above a temperature
_NAMED = 4  # points that a note names
_MOST_ROWS = 60  # of the table on a terminal
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
_Rows = dict[str, dict[str, dict[str, Any]]]  # point → column → row of the tidy table


def words_of(key: str) -> tuple[str, float]:
    """Return the title of an axis of a key, and the factor from SI to its unit: ("nominal pressure, MPa", 1e-6)."""
    number = key_quantity(key)
    factor, unit = (1.0, _OF_ROWS.get(key, ""))
    if number is not None:
        factor, unit = _PREFIXES.get(number.unit, (1.0, number.unit))
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


def plain_value(value: Any) -> Any:
    """Return a number or a word unchanged, and a list or a table as in a scene file."""
    if isinstance(value, str) or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    return literal(value)


def study_table(study: StudyResults, observable: str = "flash_temperature") -> Table:
    """Return a row for each point: the varied values, theory and simulation at the highest speed, and the trend."""
    points = study.points[:_MOST_ROWS]
    shown = _rows_at_highest_speed(study, observable)
    trends = _trends_at_highest_speed(study, observable)
    slides = any(SLIDING in columns for columns in shown.values())
    sources = ["theory", "calibrated", study.column, *([SLIDING] if slides else [])]
    rows = [
        columns[source] for columns in shown.values() for source in sources if source in columns
    ]
    unknown = dict.fromkeys(part for row in rows for part in _unknown_parts(row))
    marks = {row["note"] for row in rows} - {""}
    columns = [
        *_key_columns(study, points),
        (Column("n", number=True), _counts(study, points, shown)),
        *_value_columns(points, shown, sources, observable),
        *_exponent_columns(study, points, trends),
    ]
    if marks:
        columns.append((Column("note"), [_mark(shown.get(point.name, {})) for point in points]))
    titles = [title for title, _ in columns]
    cells = zip(*(cells for _, cells in columns), strict=True)
    return Table(
        titles, list(cells), study.scene.title, _notes(study, observable, unknown, marks, trends)
    )


def asked_table(study: StudyResults) -> Table | None:
    """Return a row for each reaction at each energy, each share of hot heat, and each point; None if no scene asks."""
    rows: dict[
        tuple[str, float], dict[str, dict[str, dict[str, Any]]]
    ] = {}  # quantity → point → column → row
    for name in ABOUT:
        for row in study.rows(name):
            columns = rows.setdefault((name, row[ABOUT[name]]), {}).setdefault(row["point"], {})
            if row["column"] not in columns or row["speed"] > columns[row["column"]]["speed"]:
                columns[row["column"]] = row
    if not rows:
        return None
    shown = [
        (*place, *of_point) for place, by_point in rows.items() for of_point in by_point.items()
    ]
    known = {source for *_, columns in shown for source in columns}
    sources = [source for source in ("calibrated", study.column, SLIDING) if source in known]
    values = {point.name: point.values for point in study.points}
    cells: list[list[Cell]] = []
    for name, number, point, columns in shown[:_MOST_ROWS]:
        line: list[Cell] = [with_unit(f"{name}, {number:.4g} {_OF_ROWS[ABOUT[name]]}", UNITS[name])]
        line += [value_text(key, values[point][key]) for key in study.keys]
        line += [_number(columns[source], name) if source in columns else "–" for source in sources]
        cells.append(line)
    numbers = [*(words_of(key)[0] for key in study.keys), *sources]
    titles = [
        Column("at the highest speed", name=True),
        *(Column(title, number=True) for title in numbers),
    ]
    measured = (row for *_, columns in shown for row in columns.values())
    unknown = dict.fromkeys(part for row in measured for part in _unknown_parts(row))
    notes = [
        "± total error, 95 %; activation temperatures are absolute.",
        *marks_in_words(unknown, {}),
    ]
    if len(shown) > _MOST_ROWS:
        notes.append(f"The first {_MOST_ROWS} rows; `roughsim export` writes all.")
    return Table(titles, cells, "What reacts", notes)


def _key_columns(
    study: StudyResults, points: Sequence[Point]
) -> Iterator[tuple[Column, list[Cell]]]:
    """Yield a column for each varied key."""
    for key in study.keys:
        yield (
            Column(words_of(key)[0], number=True),
            [value_text(key, point.values[key]) for point in points],
        )


def _value_columns(
    points: Sequence[Point], shown: _Rows, sources: Sequence[str], observable: str
) -> Iterator[tuple[Column, list[Cell]]]:
    """Yield a column for each source of values."""
    for source in sources:
        title = Column(with_unit(source, UNITS[observable]), number=True)
        yield title, [_value(shown, point, source, observable) for point in points]


def _exponent_columns(
    study: StudyResults, points: Sequence[Point], trends: Mapping[tuple[str, str], dict[str, Any]]
) -> Iterator[tuple[Column, list[Cell]]]:
    """Yield a column for each key with trends."""
    paired = {name for _, name in trends}
    for name in study.keys.values():
        if name in paired:
            title = Column(f"∂ln/∂ln {name.replace('_', ' ')}", number=True)
            yield title, [_exponent(trends.get((point.name, name))) for point in points]


def _notes(
    study: StudyResults,
    observable: str,
    unknown: Collection[str],
    marks: Collection[str],
    trends: Mapping[tuple[str, str], dict[str, Any]],
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
    notes.append(f"{observable} at the highest speed of each point; ± total error, 95 %.")
    notes += marks_in_words(unknown, marks)
    if trends:
        notes.append(_PAIRED)
    return [*notes, *_missing_notes(trends.values()), *marked(study.warnings)]


def _rows_at_highest_speed(study: StudyResults, observable: str) -> _Rows:
    """Return the rows of an observable at the highest speed of each point."""
    highest: _Rows = {}
    for row in study.rows(observable):
        columns = highest.setdefault(row["point"], {})
        other = columns.get(row["column"])
        if other is None or (row["speed"] or 0.0) > (other["speed"] or 0.0):
            columns[row["column"]] = row
    return highest


def _trends_at_highest_speed(
    study: StudyResults, observable: str
) -> dict[tuple[str, str], dict[str, Any]]:
    """Return the trends by point and name of the key."""
    highest: dict[tuple[str, str], dict[str, Any]] = {}
    for trend in trends_of(study, observable, None):
        place = trend["point"], trend["key"]
        if place not in highest or (trend["speed"] or 0.0) > (highest[place]["speed"] or 0.0):
            highest[place] = trend
    return highest


def _counts(study: StudyResults, points: Iterable[Point], shown: _Rows) -> list[Cell]:
    """Return the realizations of each point, with the mark of levels that do not suit it."""
    misfits = study.misfits()
    cells: list[Cell] = []
    for point in points:
        count = "–"
        for row in shown.get(point.name, {}).values():
            count = str(row["realizations"])
        cells.append(count + _MISFIT if point.name in misfits else count)
    return cells


def _value(shown: _Rows, point: Point, source: str, observable: str) -> Cell:
    """Return the value of a point from a source with its total error."""
    row = shown.get(point.name, {}).get(source)
    if row is None:
        return "–"
    return _number(row, observable)


def _number(row: dict[str, Any], observable: str) -> Number:
    """Return the value of a row with its total error."""
    error = 0.0 if np.isnan(row["total_error"]) else row["total_error"]  # theory has none
    return Number(row["value"], UNITS[observable], error, _unknown_parts(row))


def _exponent(trend: dict[str, Any] | None) -> Cell:
    """Return the exponent of a trend with its statistical error."""
    return "" if trend is None else Number(trend["exponent"], "1", trend["exponent_error"])


def _mark(columns: dict[str, dict[str, Any]]) -> str:
    """Return the first note on the values of a point."""
    notes = [row["note"] for row in columns.values() if row["note"]]
    return notes[0] if notes else ""


def _unknown_parts(row: dict[str, Any]) -> list[str]:
    """Return the unknown parts of the error of a row."""
    return row["unknown"].split(", ") if row["unknown"] else []


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
