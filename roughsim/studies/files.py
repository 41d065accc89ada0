"""A study as files for other programs: the tidy table, or arrays over the varied keys."""

import hashlib
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from roughsim.results.export import ENDINGS
from roughsim.show.frame import TABLES, table_bytes
from roughsim.show.table import json_value
from roughsim.store.disk import place_bytes, seal
from roughsim.studies.results import StudyResults
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import plain_value
from roughsim.table import Results


def save_study(study: StudyResults, path: Path) -> Path:
    """Write the results of a study into a file, whole or not at all; `Study.save` describes the endings."""
    ending = path.suffix.lower()
    if ending not in (*TABLES, *ENDINGS):
        raise ValueError(f"path = {str(path)!r} must end in {', '.join((*TABLES, *ENDINGS))}")
    path.parent.mkdir(parents=True, exist_ok=True)
    if ending in TABLES:
        values = partial(study_dict, study)
        place_bytes(path, table_bytes(ending, _plain_rows(study), values, ["point"]))
    else:
        content = _hdf5(study)
        place_bytes(path, content, seal(path.name, hashlib.sha256(content)))
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


def _hdf5(study: StudyResults) -> bytes:
    """Return the arrays of a study as an HDF5 file with dimension scales, which is netCDF-4."""
    from roughsim.store.hdf5 import hdf5_bytes, write_arrays  # loads h5py

    def fill(file: Any) -> None:
        file.attrs.update(_attributes(study))
        write_arrays(file, study_results(study).arrays())

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


def _attributes(study: StudyResults) -> dict[str, str]:
    """Return title and scene of a study, and a description of its arrays."""
    columns = (
        "theory, calibrated (the theory with a fitted stress spectrum), and the simulated columns"
    )
    readme = (
        f"A study by roughsim: {study.scene.title}. Units are SI. Each observable is an array over the varied keys, "
        f"the column it comes from ({columns}), and the speed if it depends on it. NAME_part are the parts of its 95 % "
        "error, and NAME_note marks values that are not extrapolated (at q_c) or fixed by force balance (identity). "
        "NaN: not computed yet, or not defined."
    )
    return {
        "title": study.scene.title or study.folder.name,
        "README": readme,
        "scene": study.scene.to_toml(),
    }


def study_results(study: StudyResults) -> Results:
    """Return the `table` of a study with its attributes; ValueError without results."""
    table = study.table()
    if not table:
        raise ValueError(f"{study.folder} has no point with results yet; let it run first")
    return replace(table, attrs=_attributes(study))
