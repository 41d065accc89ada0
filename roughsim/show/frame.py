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

    A .csv without rows has the columns `empty`.
    """
    if ending == ".json":
        return (json.dumps(values(), indent=1) + "\n").encode()
    return csv_bytes(rows, empty) if ending == ".csv" else parquet_bytes(rows)


def data_frame(rows: Sequence[Mapping[str, Any]], index: str | None = None) -> Any:
    """Return rows as a `pandas.DataFrame`, with a column as its index if one is named; ImportError without pandas."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise ImportError("pandas is not installed; type: pip install pandas") from None
    frame = pandas.DataFrame([dict(row) for row in rows])
    return frame if index is None else frame.set_index(index)


def csv_bytes(rows: Sequence[Mapping[str, Any]], empty: Sequence[str] = ()) -> bytes:
    """Return rows as CSV, with all their keys, or those of `empty` without rows; None or no value is an empty cell."""
    names = dict.fromkeys(name for row in rows for name in row) or dict.fromkeys(empty)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(names), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def parquet_bytes(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return rows as Parquet; ImportError without pandas or pyarrow."""
    buffer = io.BytesIO()
    try:
        data_frame(rows).to_parquet(buffer)
    except ImportError:
        raise ImportError(
            "a .parquet needs pandas and pyarrow; type: pip install pandas pyarrow"
        ) from None
    return buffer.getvalue()
