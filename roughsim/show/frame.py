"""Rows as a pandas DataFrame, CSV or Parquet: pandas is not among the packages that roughsim needs."""

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

TABLES = (".csv", ".json", ".parquet")


def table_bytes(
    ending: str,
    rows: Sequence[Mapping[str, Any]],
    values: Callable[[], dict[str, Any]],
    empty: Sequence[str] = (),
) -> bytes:
    """Return a file of rows by its ending in `TABLES`: of .json it has `values`, which describe and hold the rows.

    A .csv has all keys of the rows, or those of `empty` without rows; None or no value is an empty cell. ImportError
    for .parquet without pandas or pyarrow.
    """
    if ending == ".json":
        return (json.dumps(values(), indent=1) + "\n").encode()
    if ending == ".csv":
        names = dict.fromkeys(name for row in rows for name in row) or dict.fromkeys(empty)
        text = io.StringIO()
        writer = csv.DictWriter(text, list(names), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue().encode()
    buffer = io.BytesIO()
    try:
        data_frame(rows).to_parquet(buffer)
    except ImportError:
        message = "a .parquet needs pandas and pyarrow; type: pip install pandas pyarrow"
        raise ImportError(message) from None
    return buffer.getvalue()


def data_frame(rows: Sequence[Mapping[str, Any]], index: str | None = None) -> Any:
    """Return rows as a `pandas.DataFrame`, with a column as its index if one is named; ImportError without pandas."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise ImportError("pandas is not installed; type: pip install pandas") from None
    frame = pandas.DataFrame([dict(row) for row in rows])
    return frame if index is None else frame.set_index(index)
