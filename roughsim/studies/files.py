"""A study as files for other programs: the tidy table, or arrays over the varied keys."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from roughsim.results.export import ENDINGS
from roughsim.results.table import Results
from roughsim.show.frame import TABLES, table_bytes
from roughsim.show.table import json_value
from roughsim.store.disk import place_bytes
from roughsim.store.member_files import write_sealed
from roughsim.studies.results import StudyResults
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import plain_value


def save_study(study: StudyResults, path: Path) -> Path:
    """Write the results of a study into a file, whole or not at all; `Study.save` describes the endings."""
    ending = path.suffix.lower()
    if ending not in (*TABLES, *ENDINGS):
        raise ValueError(f"path = {str(path)!r} must end in {', '.join((*TABLES, *ENDINGS))}")
    path.parent.mkdir(parents=True, exist_ok=True)
    if ending in TABLES:
        rows = list(study.rows())
        for name in study.keys.values():
            # one type of value in each column; lists and tables as in a scene file
            if not all(isinstance(row[name], (int, float)) for row in rows):
                rows = [row | {name: str(plain_value(row[name]))} for row in rows]
        values = partial(study_dict, study)
        place_bytes(path, table_bytes(ending, rows, values, ["point"]))
        return path
    results = study_results(study)

    def fill(file: Any) -> None:
        from roughsim.store.hdf5 import write_arrays  # loads h5py

        file.attrs.update(results.attrs)
        write_arrays(file, results.arrays())

    write_sealed(path, fill)
    return path


def study_dict(study: StudyResults) -> dict[str, Any]:
    """Return the study as JSON values: keys, number of finished points, the tidy table, and trends of T_flash."""
    return {
        "folder": str(study.folder),
        "target_error": study.target_error,
        "points": len(study.points),
        "finished": study.finished,
        "keys": {name: {"key": key} for key, name in study.keys.items()},
        "rows": json_value([*study.rows()]),
        "scene_warnings": study.warnings,
        "trends": json_value([*trends_of(study, "flash_temperature", None)]),
    }


def study_results(study: StudyResults) -> Results:
    """Return the `table` of a study with title, scene, and a description of its arrays; ValueError without results."""
    table = study.table()
    if not table:
        raise ValueError(f"{study.folder} has no point with results yet; let it run first")
    columns = (
        "theory, calibrated (the theory with a fitted stress spectrum), and the simulated columns"
    )
    readme = (
        f"A study by roughsim: {study.scene.title}. Units are SI. Each observable is an array over the varied keys, "
        f"the column it comes from ({columns}), and the speed if it depends on it. NAME_part are the parts of its 95 % "
        "error, and NAME_note marks values that are not extrapolated (at q_c) or fixed by force balance (identity). "
        "NaN: not computed yet, or not defined."
    )
    title, scene = study.scene.title or study.folder.name, study.scene.to_toml()
    return replace(table, attrs={"title": title, "README": readme, "scene": scene})
