"""A study as a table for people, and as files for other programs.

`study` is a `roughsim.Study` everywhere; its methods call these functions.
"""

import csv
import io
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.observables.catalogue import OBSERVABLES, UNITS
from roughsim.results.answers import TAILS, marked
from roughsim.results.arrays import Labelled, to_dataset
from roughsim.results.marks import meanings, unknown_words
from roughsim.scene.numerics import SLIDING
from roughsim.scene.schema import literal
from roughsim.show.frame import data_frame
from roughsim.show.table import Column, Number, Row, Table, significant, with_unit
from roughsim.store.disk import place_bytes
from roughsim.studies.vary import key_quantity

PREFIXES = {"Pa": (1e-6, "MPa"), "m": (1e6, "µm"), "rad/m": (1.0, "1/m")}  # units of keys that people read
ENDINGS = (".csv", ".json", ".parquet", ".h5", ".hdf5", ".nc")
NAMED = 4  # points that a note names
MOST_ROWS = 60  # of the table on a terminal
MARK = " *"  # of a point whose levels do not suit it
LONGEST = 40  # letters of a value in a table
OTHER_KIND = (
    "∂ln/∂ln: – between values of different kind: one extrapolated and the other at q_c, or with other parts of their "
    "errors unknown."
)
NO_LOGARITHM = "∂ln/∂ln: – where a value of the key is not above 0, for it has no logarithm."


def words_of(key: str) -> tuple[str, float]:
    """Return what an axis of a key is called, and the factor from SI to its unit: ("nominal pressure, MPa", 1e-6)."""
    number = key_quantity(key)
    factor, unit = PREFIXES.get(number.unit, (1.0, number.unit)) if number is not None else (1.0, "")
    text = key.partition(".")[2].replace("_", " ") or key
    return (f"{text}, {unit}" if unit else text), factor


def study_table(study: Any, observable: str = "flash_temperature") -> Table:
    """Return a row for each point: the varied values, theory and simulation at the highest speed, and the trend."""
    keys = study.keys
    told: dict[str, dict[str, Any]] = {}
    for row in study.rows(observable):
        of_point = told.setdefault(row["point"], {})
        shown_before = of_point.get(row["column"])
        if shown_before is None or row["speed"] is None or row["speed"] > shown_before["speed"]:
            of_point[row["column"]] = row
    slides = any(SLIDING in of_point for of_point in told.values())
    columns = ["theory", "calibrated", study.column, *([SLIDING] if slides else [])]
    trends: dict[tuple[str, str], dict[str, Any]] = {}
    for trend in sorted(study.trends(observable), key=lambda trend: trend["speed"] or 0.0):
        trends[trend["point"], trend["key"]] = trend  # that of the highest speed stays
    titles = [Column(words_of(key)[0], number=True) for key in keys]
    titles += [Column(title, number=True) for title in ("n", *(with_unit(name, UNITS[observable]) for name in columns))]
    paired = {along for _, along in trends}
    numeric = [keys[key] for key in study.numeric_keys if keys[key] in paired]
    titles += [Column(f"∂ln/∂ln {name.replace('_', ' ')}", number=True) for name in numeric]
    shown_rows = [of_point[name] for of_point in told.values() for name in columns if name in of_point]
    unknown = dict.fromkeys(part for row in shown_rows for part in parts_of(row))
    marks = {row["note"] for row in shown_rows} - {""}
    titles += [Column("note")] if marks else []
    misfits = study.misfits()
    rows: list[Row] = []
    for point in study.points[:MOST_ROWS]:
        of_point = told.get(point.name, {})
        cells: list[Any] = [value_text(key, value) for key, value in point.values.items()]
        count = next((row["realizations"] for row in of_point.values()), "–")
        cells.append(f"{count}{MARK * (point.name in misfits)}")
        cells += [number_of(of_point[column], observable) if column in of_point else "–" for column in columns]
        for name in numeric:
            slope = trends.get((point.name, name))
            exponent = Number(slope["exponent"], "1", slope["exponent_error"]) if slope else ""
            cells.append(exponent)
        if marks:
            cells.append(next((row["note"] for row in of_point.values() if row["note"]), ""))
        rows.append(cells)
    notes = [f"{study.finished} of {len(study.points)} points finished.", *target_note(study), *level_notes(study)]
    if len(study.points) > MOST_ROWS:
        notes.append(f"The first {MOST_ROWS} points; `roughsim export` writes all, with all observables and speeds.")
    notes.append(f"{observable} at the highest speed of each point; ± total error, 95 %.")
    notes += meanings(unknown, marks)
    if numeric:
        notes.append(
            "∂ln/∂ln: exponent from the point before, of paired surfaces: its ± is statistical, 95 %, and does not "
            "have the errors that both points share, known or not."
        )
    notes += missing_notes(trends.values())
    return Table(titles, rows, study.scene.title, notes)


def missing_notes(trends: Iterable[dict[str, Any]]) -> list[str]:
    """Say why exponents are missing."""
    lowest = [min(trend["from"], trend["to"]) for trend in trends if np.isnan(trend["exponent"])]
    notes = [OTHER_KIND] if any(value > 0.0 for value in lowest) else []
    return notes + ([NO_LOGARITHM] if any(value <= 0.0 for value in lowest) else [])


def target_note(study: Any) -> list[str]:
    """Say how many points are within the total error that was asked for; nothing where none was.

    A point of which a part of the error is unknown, at some speed, is not within it.
    """
    totals: dict[str, float] = {}
    unknown: dict[str, tuple[str, ...]] = {}
    for point, run in study.results if study.target_error is not None else ():
        estimate = run.estimate("flash_temperature")
        relative = estimate.total_error[estimate.mean != 0.0] / np.abs(estimate.mean[estimate.mean != 0.0])
        totals[point.name] = float(relative.max(initial=0.0))
        if estimate.unknown:
            unknown[point.name] = estimate.unknown
    if not totals:
        return []
    within = sum(total <= study.target_error for name, total in totals.items() if name not in unknown)
    text = f"Total error of T_flash at most {100 * study.target_error:.3g} % at every speed: {within} points"
    if unknown:
        parts = unknown_words(list(dict.fromkeys(part for each in unknown.values() for part in each)))
        text += f"; at {len(unknown)} points a part of it is unknown ({parts})"
    worst = max(totals, key=totals.__getitem__)
    at_least = "≥" * (worst in unknown)
    return [f"{text}; the largest is {at_least}{100 * totals[worst]:.3g} %, at {worst}."]


def level_notes(study: Any) -> list[str]:
    """Say which points have the levels of others, and whose levels or cell do not suit them."""
    notes = []
    if later := study.later:
        named = f"{', '.join(later[:NAMED])}{', …' * (len(later) > NAMED)}"
        notes.append(f"{len(later)} points came later and have the levels planned for the others: {named}.")
    if misfits := study.misfits():
        worst = max(misfits, key=lambda name: misfits[name][1])
        part, error = misfits[worst]
        notes.append(
            f"*: the levels or the cell do not suit {len(misfits)} points: bandwidth, last step, pixel or size alone "
            f"exceeds the error asked for; the largest is {part} {100 * error:.3g} %, at {worst}. A study of these in "
            "a folder of its own plans for them, as far as grids and cells allow."
        )
    return notes


def number_of(row: dict[str, Any], observable: str) -> Number:
    """Return the value of a row with its error, if it has one."""
    error = 0.0 if np.isnan(row["total_error"]) else row["total_error"]
    return Number(row["value"], UNITS[observable], error, parts_of(row))


def parts_of(row: dict[str, Any]) -> list[str]:
    """Return the unknown parts of the error of a row."""
    return row["unknown"].split(", ") if row["unknown"] else []


def value_text(key: str, value: Any) -> str:
    """Return a varied value in the unit that people read; lists and tables as a scene file writes them, but short."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return significant(float(value) * words_of(key)[1], 5)
    if isinstance(value, (list, tuple)):
        text = f"[{', '.join(value_text(key, entry) for entry in value)}]"
    else:
        text = plain_value(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 14]} … {text[-11:]}"


def plain_value(value: Any) -> Any:
    """Return a number or a word as it is, and a list or a table as a scene file writes it."""
    if isinstance(value, str) or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    return literal(value)


def draw_study(study: Any, path: Path, observable: str) -> None:
    """Draw a study; see `Study.chart`."""
    from roughsim.charts.study import study_chart

    if observable not in OBSERVABLES:
        raise ValueError(f"observable = {observable!r} is unknown; choose one of {', '.join(OBSERVABLES)}")
    keys = {study.keys[key]: words_of(key) for key in study.numeric_keys[:2]}
    rows = list(study.rows(observable))
    title = f"{study.scene.title}: {study.finished} of {len(study.points)} points"
    for axis in study.axes:  # those that are not drawn have the values of the first result
        names = [study.keys[key] for key in axis.keys]
        if keys and rows and names[0] not in keys:
            rows = [row for row in rows if all(row[name] == rows[0][name] for name in names)]
            for key, name in zip(axis.keys, names, strict=True):
                words, _, unit = words_of(key)[0].partition(", ")
                title += f"; {words} {value_text(key, rows[0][name])} {unit}".rstrip()
    study_chart(rows, keys, study.column, observable, path, title=title)


def save_study(study: Any, path: str | Path) -> Path:
    """Write the results of a study: the tidy table as .csv, .json or .parquet, or arrays over the varied keys as .h5.

    The arrays are netCDF-4, for xarray: every observable over the varied keys, the column and the speed. ValueError for
    another ending, or if the points do not make arrays; ImportError without pyarrow or pandas for .parquet. The file is
    whole or not there.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join(ENDINGS)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    if ending == ".json":
        content: Any = (json.dumps(study.to_dict(), indent=1) + "\n").encode()
    elif ending == ".csv":
        content = csv_text(study).encode()
    elif ending == ".parquet":
        buffer = io.BytesIO()
        data_frame(flat_rows(study)).to_parquet(buffer)
        content = buffer.getvalue()
    else:
        from roughsim.store.hdf5 import hdf5_bytes  # loads h5py

        content = hdf5_bytes(lambda file: fill(file, study))
    place_bytes(path, content)
    return path


def csv_text(study: Any) -> str:
    """Return the tidy table as CSV, with the unit of each row in its own column."""
    rows = flat_rows(study)
    file = io.StringIO()
    writer = csv.DictWriter(file, list(rows[0]) if rows else ["point"], lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: "" if value is None else value for name, value in row.items()} for row in rows)
    return file.getvalue()


def flat_rows(study: Any) -> list[dict[str, Any]]:
    """Return the tidy table with one kind of value in each column; lists and tables as a scene file writes them."""
    rows = list(study.rows())
    texts = {name for name in study.keys.values() if not all(isinstance(row[name], (int, float)) for row in rows)}
    return [row | {name: str(plain_value(row[name])) for name in texts} for row in rows]


def fill(file: Any, study: Any) -> None:
    """Write the arrays of a study into an HDF5 file, with dimension scales."""
    from roughsim.results.export import write_arrays

    file.attrs.update(attributes(study))
    write_arrays(file, list(arrays(study)), None)


def attributes(study: Any) -> dict[str, Any]:
    """Return the attributes of the arrays: title, scene, and what is in them in words."""
    columns = "theory, calibrated (the theory with a fitted stress spectrum), and the simulated columns"
    words = (
        f"A study by roughsim: {study.scene.title}. Units are SI. Each observable is an array over the varied keys, "
        f"the column it comes from ({columns}), and the speed where it depends on it. {TAILS} NaN: not computed yet, "
        "or not defined."
    )
    return {"title": study.scene.title or study.folder.name, "README": words, "scene": study.scene.to_toml()}


def dataset(study: Any) -> Any:
    """Return the arrays of a study as an `xarray.Dataset`; ImportError without xarray."""
    return to_dataset(list(arrays(study)), attributes(study))


def arrays(study: Any) -> Iterator[Labelled]:
    """Yield the axes of a study, and each observable with its error over them, the column, and the speed.

    An axis of several keys has the first as its coordinate, and the others beside it. ValueError if no point has a
    result, or the points have lists of other speeds.
    """
    rows = list(study.rows())
    if not rows:
        raise ValueError(f"{study.folder} has no point with results yet; let it run first")
    keys = study.keys
    axes = [keys[axis.keys[0]] for axis in study.axes]
    for axis in study.axes:
        for i, key in enumerate(axis.keys):
            values = np.array([plain_value(row[i]) for row in axis.values])
            number = key_quantity(key)
            unit = {"units": number.unit or "1"} if number is not None and values.dtype.kind != "U" else {}
            yield Labelled(keys[key], (keys[axis.keys[0]],), values, unit | {"key": key})
    columns = list(dict.fromkeys(row["column"] for row in rows))
    yield Labelled("column", ("column",), np.array(columns), {"description": "what a value comes from"})
    speeds = study.common_speeds()
    if speeds is not None:
        yield Labelled("speed", ("speed",), np.array(speeds), {"units": "m/s"})
    places = {point.name: np.unravel_index(i, study.shape) for i, point in enumerate(study.points)}
    for name in dict.fromkeys(row["observable"] for row in rows):
        over_speed = OBSERVABLES[name].per_speed and speeds is not None
        shape = (*study.shape, len(columns), *([len(speeds)] if over_speed and speeds else []))
        value, error = np.full(shape, np.nan), np.full(shape, np.nan)
        unknown, note = np.full(shape, "", object), np.full(shape, "", object)
        for row in rows:
            if row["observable"] == name:
                place: tuple[Any, ...] = (*places[row["point"]], columns.index(row["column"]))
                place += (speeds.index(row["speed"]),) if over_speed and speeds else ()
                value[place], error[place] = row["value"], row["total_error"]
                unknown[place], note[place] = row["unknown"], row["note"]
        names = (*axes, "column", *(["speed"] if over_speed else []))
        yield from marked(name, names, value, error, unknown.astype(str), note.astype(str))
