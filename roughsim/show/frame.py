"""Rows as a pandas DataFrame: pandas is not among the packages that roughsim needs."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


def data_frame(rows: Sequence[Mapping[str, Any]], index: str) -> Any:
    """Return rows as a `pandas.DataFrame` with the column `index` as its index; ImportError without pandas."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise ImportError("pandas is not installed; type: pip install pandas") from None
    return pandas.DataFrame([dict(row) for row in rows]).set_index(index)
