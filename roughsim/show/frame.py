"""Rows as a pandas DataFrame: pandas is not among the packages that roughsim needs."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


def data_frame(rows: Sequence[Mapping[str, Any]], index: str | None = None) -> Any:
    """Return rows as a `pandas.DataFrame`, with a column as its index if one is named; ImportError without pandas."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise ImportError("pandas is not installed; type: pip install pandas") from None
    frame = pandas.DataFrame([dict(row) for row in rows])
    return frame if index is None else frame.set_index(index)
