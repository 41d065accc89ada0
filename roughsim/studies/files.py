"""A study as files for other programs: the tidy table, or arrays over the varied keys."""

import hashlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.observables.catalogue import UNITS
from roughsim.results.answers import NOTE, TAIL, TAILS, UNKNOWN, marked
from roughsim.results.arrays import Labelled, to_dataset
from roughsim.results.reactions import asked_names
from roughsim.show.frame import csv_bytes, parquet_bytes
from roughsim.show.table import json_value
from roughsim.store.disk import place_bytes, seal
from roughsim.studies.results import StudyResults
from roughsim.studies.tables import plain_value
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import key_quantity


def save_study(study: StudyResults, path: Path) -> Path:
    """Write the results of a study into a file, whole or not at all; `Study.save` describes the endings."""
    writers: dict[str, Callable[[StudyResults], bytes]]
    writers = {
        ".csv": _csv,
        ".json": _json,
        ".parquet": _parquet,
        ".h5": _hdf5,
        ".hdf5": _hdf5,
        ".nc": _hdf5,
    }
    writer = writers.get(path.suffix.lower())
    if writer is None:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join(writers)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    content = writer(study)
    last_line = seal(path.name, hashlib.sha256(content)) if writer is _hdf5 else b""
    place_bytes(path, content, last_line)
    return path


def study_dict(study: StudyResults) -> dict[str, Any]:
    """Return the study as JSON values: keys, number of finished points, the tidy table, and trends of T_flash."""
    return {
        "folder": str(study.folder),
        "target_error": study.target_error,
        "points": len(study.points),
        "finished": study.finished,
        "keys": {name: {"key": key} for key, name in study.keys.items()},
        "rows": [json_value(row) for row in study.rows()],
        "scene_warnings": study.warnings,
        "trends": [json_value(trend) for trend in trends_of(study, "flash_temperature", None)],
    }


def _csv(study: StudyResults) -> bytes:
    """Return the tidy table as CSV, with the unit of each row in a column."""
    return csv_bytes(_plain_rows(study), ["point"])


def _json(study: StudyResults) -> bytes:
    """Return the study as JSON."""
    return (json.dumps(study_dict(study), indent=1) + "\n").encode()


def _parquet(study: StudyResults) -> bytes:
    """Return the tidy table as Parquet; ImportError without pandas or pyarrow."""
    return parquet_bytes(_plain_rows(study))


def _hdf5(study: StudyResults) -> bytes:
    """Return the arrays of a study as an HDF5 file with dimension scales, which is netCDF-4."""
    from roughsim.store.hdf5 import hdf5_bytes, write_arrays  # loads h5py

    def fill(file: Any) -> None:
        file.attrs.update(_attributes(study))
        write_arrays(file, _arrays(study))

    return hdf5_bytes(fill)


def _plain_rows(study: StudyResults) -> list[dict[str, Any]]:
    """Return the tidy table with one type of value in each column; lists and tables as in a scene file."""
    rows = list(study.rows())
    texts = [
        name
        for name in study.keys.values()
        if not all(isinstance(row[name], (int, float)) for row in rows)
    ]
    for row in rows:
        row |= {name: str(plain_value(row[name])) for name in texts}
    return rows


def dataset(study: StudyResults) -> Any:
    """Return the arrays of a study as an `xarray.Dataset`; ImportError without xarray."""
    return to_dataset(list(_arrays(study)), _attributes(study))


def _attributes(study: StudyResults) -> dict[str, str]:
    """Return title and scene of a study, and a description of its arrays."""
    columns = (
        "theory, calibrated (the theory with a fitted stress spectrum), and the simulated columns"
    )
    readme = (
        f"A study by roughsim: {study.scene.title}. Units are SI. Each observable is an array over the varied keys, "
        f"the column it comes from ({columns}), and the speed if it depends on it. {TAILS} NaN: not computed yet, "
        "or not defined."
    )
    return {
        "title": study.scene.title or study.folder.name,
        "README": readme,
        "scene": study.scene.to_toml(),
    }


def _arrays(study: StudyResults) -> Iterator[Labelled]:
    """Yield the axes of a study, and each observable with its error over them, the column, and the speed.

    An axis of several keys has the first as its coordinate, and the others beside it. ValueError without results, or
    for points with lists of other speeds.
    """
    tables = {
        point.name: study.answers(point, run, [*run.observables, *asked_names(run.scene)])
        for point, run in study.results
    }
    if not tables:
        raise ValueError(f"{study.folder} has no point with results yet; let it run first")
    for axis in study.axes:
        for i, key in enumerate(axis.keys):
            values = np.array([plain_value(row[i]) for row in axis.values])
            number = key_quantity(key)
            unit = (
                {"units": number.unit or "1"}
                if number is not None and values.dtype.kind != "U"
                else {}
            )
            yield Labelled(
                study.keys[key], (study.keys[axis.keys[0]],), values, unit | {"key": key}
            )
    columns = list(
        dict.fromkeys(
            column for table in tables.values() for column in table["column"].data.tolist()
        )
    )
    yield Labelled("column", ("column",), np.array(columns), {"description": "source of a value"})
    speeds = study.common_speeds()
    if speeds is not None:
        yield Labelled("speed", ("speed",), np.array(speeds), {"units": "m/s"})
    about: dict[str, list[float]] = {}
    for name, of_row in (("energy", "eV"), ("heat_above", "K")):
        about[name] = sorted(
            {x for table in tables.values() if name in table for x in table[name].data.tolist()}
        )
        if about[name]:
            yield Labelled(name, (name,), np.array(about[name]), {"units": of_row})
    for name in (name for name in UNITS if all(name in table for table in tables.values())):
        yield from _over_the_grid(study, tables, columns, speeds, about, name)


def _over_the_grid(
    study: StudyResults,
    tables: dict[str, dict[str, Labelled]],
    columns: list[str],
    speeds: list[float] | None,
    about: dict[str, list[float]],
    name: str,
) -> Iterator[Labelled]:
    """Yield an observable with its error and marks over the grid of points, the columns and the speeds.

    Reactions are over the energies, and the share of hot heat over the temperatures, of `about` all points, too.
    """
    axes_of_one = next(iter(tables.values()))[name].axes[1:]
    inner = [axis for axis in axes_of_one if axis != "speed" or speeds is not None]
    sizes = {axis: len(numbers) for axis, numbers in about.items()} | {"speed": len(speeds or ())}
    shape = (*study.shape, len(columns), *(sizes[axis] for axis in inner))
    parts = {
        "": np.full(shape, np.nan),
        TAIL: np.full(shape, np.nan),
        UNKNOWN: np.full(shape, "", object),
        NOTE: np.full(shape, "", object),
    }
    for place, point in zip(np.ndindex(study.shape), study.points, strict=True):
        table = tables.get(point.name, {})
        for i, column in enumerate(table["column"].data.tolist() if table else []):
            at: tuple[Any, ...] = (*place, columns.index(column))
            for axis in (axis for axis in inner if axis in about):
                at = (*at, [about[axis].index(number) for number in table[axis].data.tolist()])
            for tail, array in parts.items():
                entry = table[name + tail].data[i]
                array[at] = (
                    entry if entry.ndim == len(inner) else entry[..., 0]
                )  # of the only speed of each point
    value, error, unknown, note = parts.values()
    missing = np.isnan(value)
    if missing.all():
        return
    unknown[missing] = note[missing] = ""
    axes = [study.keys[axis.keys[0]] for axis in study.axes]
    names = (*axes, "column", *inner)
    yield from marked(
        name, names, value, np.where(missing, np.nan, error), unknown.astype(str), note.astype(str)
    )
