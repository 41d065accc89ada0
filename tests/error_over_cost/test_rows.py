"""Rows of a long computation: they come back as they were, are not computed again, and other files are refused."""

import sys
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from roughsim.errors import RecordError

sys.path.append(str(Path(__file__).parents[2] / "experiments"))
from script import Rows


def test_rows_come_back_as_they_were_and_are_not_computed_again(tmp_path):
    rows = Rows(tmp_path / "deep" / "data.json")
    first = rows.once("maps", "σ/E* = 1", lambda: {"error": 1e-3, "why": ""})
    rows.once("maps", "failed", lambda: {"error": nan, "why": "stalled", "more": inf})
    again = Rows(tmp_path / "deep" / "data.json", resume=True)
    assert (
        again.once("maps", "σ/E* = 1", lambda: pytest.fail("computed again"))
        == first
        == {"error": 1e-3, "why": ""}
    )
    assert list(again["maps"]) == ["σ/E* = 1", "failed"]
    assert again["maps"]["failed"]["why"] == "stalled"
    assert np.isnan(again["maps"]["failed"]["error"])
    assert again["maps"]["failed"]["more"] == inf
    assert [path.name for path in (tmp_path / "deep").iterdir()] == [
        "data.json"
    ]  # nothing half-written beside it
    assert not Rows(tmp_path / "deep" / "data.json")["maps"]  # written anew without resume


def test_a_row_that_fails_leaves_the_others_whole(tmp_path):
    rows = Rows(tmp_path / "data.json")
    rows.once("maps", "one", lambda: {"error": 1.0})
    with pytest.raises(ZeroDivisionError):
        rows.once("maps", "two", lambda: {"error": 1 / 0})
    assert list(Rows(tmp_path / "data.json", resume=True)["maps"]) == ["one"]


def test_files_that_hold_no_rows_are_refused(tmp_path):
    for content in ('{"x": 1.0}', '{"rows of roughsim": 1.0}', "[]", "no JSON", "\x89HDF"):
        (tmp_path / "other").write_text(content, "latin-1")
        with pytest.raises(RecordError, match="holds no rows"):
            Rows(tmp_path / "other", resume=True)
