"""`export`: the results of a run or a study in one file for other programs."""

from pathlib import Path

from roughsim.outputs.opened import Folder, opened
from roughsim.results.columns import estimated_columns, results_of
from roughsim.results.export import ENDINGS, export_run, export_surface
from roughsim.results.run import Run
from roughsim.show.frame import TABLES, table_bytes
from roughsim.show.table import json_value
from roughsim.show.text import note
from roughsim.store.disk import place_bytes
from roughsim.studies.study import Study


def export(
    run: Folder, path: str | Path, *, bits: int | None = None, surface: int | None = None
) -> Path:
    """Write the results of a run or a study into one file, and return its path.

    Parameters
    ----------
    run : Run, Study, str or Path
        The run, the study, or its folder.
    path : str or Path
        .h5, .hdf5 and .nc (netCDF-4) hold every observable as an array with its error; of a run also the numbers of all
        members and the kept fields. .csv, .json and .parquet (with pandas and pyarrow) hold one table: a row for each
        observable, column and speed, of a study also for each point. With `surface`: .nc or .npy.
    bits : int, optional
        Mantissa bits that fields of a run keep in .h5 and .nc, 1 to 23. Default: all.
    surface : int, optional
        Write only the heights of this realization, for other contact programs.

    Raises
    ------
    ValueError
        For another ending, arguments that do not fit, or without a sound realization.
    RecordError
        If the folder is no run and no study, or a file of it is damaged.
    OSError
        Naming the path, if the disk refuses; no half-written file stays.
    """
    path = Path(path)
    record = opened(run)
    if surface is not None and bits is not None:
        raise ValueError(
            "bits does not go with surface, which keeps all digits; leave one of them out"
        )
    table = path.suffix.lower() in TABLES
    if (isinstance(record, Study) or table) and surface is None and bits is not None:
        raise ValueError(f"bits is for fields, and {path.name} holds none; leave it out")
    if isinstance(record, Study):
        if surface is not None:
            raise ValueError("surface is for runs; name the folder of a point of the study")
        return record.save(path)
    if surface is not None:
        return export_surface(record, path, surface)
    if not table and path.suffix.lower() not in ENDINGS:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join((*ENDINGS, *TABLES))}")
    note(f"reading {len(record.members)} members of {record.folder}")
    return _save_table(record, path) if table else export_run(record, path, bits)


def _save_table(run: Run, path: Path) -> Path:
    """Write a row for each observable, column and speed of a run, in SI, as `Study.rows`, whole or not at all.

    ImportError for .parquet without pandas or pyarrow.
    """
    results, count = results_of(run, columns=estimated_columns(run)), run.realizations
    rows = [row | {"realizations": count} for row in results.rows()]
    values = {
        "title": run.scene.title,
        "folder": str(run.folder),
        "realizations": count,
        "failed": run.failed,
        "rows": json_value(rows),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    place_bytes(path, table_bytes(path.suffix.lower(), rows, lambda: values))
    return path
