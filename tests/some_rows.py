"""Rows of a table that test the same thing: some of them by default, all of them in the slow tests."""

import pytest


def some(rows, each=3, *, pairs=False):
    """Return every third row, or every `each`, as it is, and the others marked slow; `pairs` are one value each."""
    return [row if k % each == 0 else _slow(row, pairs) for k, row in enumerate(rows)]


def _slow(row, pairs):
    if hasattr(row, "marks"):  # of pytest.param
        return pytest.param(*row.values, marks=(*row.marks, pytest.mark.slow), id=row.id)
    values = row if isinstance(row, tuple) and not pairs else (row,)
    return pytest.param(*values, marks=pytest.mark.slow)
