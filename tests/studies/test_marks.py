"""What a study says of values that are not extrapolated, or whose error lacks a part."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from study_cases import LOADS

import roughsim as rs
from roughsim.results.run import Run
from roughsim.studies.tables import study_table, target_note
from roughsim.table import AT_CUT_OFF, IDENTITY

HEAVY = LOADS[-1]  # the load whose bandwidth is unknown


@pytest.fixture
def with_unknown_bandwidth(done, monkeypatch):
    """Opens the finished study as if nothing showed the bandwidth at some loads, and all else of the errors known."""
    estimate = Run.estimate

    def open_with(loads, *, else_known=True):
        def changed(run, observable, column=None):
            found = estimate(run, observable, column)
            budget = dict(found.budget)
            if else_known:
                budget = {
                    name: np.where(np.isnan(part), 0.0, part) for name, part in budget.items()
                }
            if run.scene.sliding.nominal_pressure in loads:
                budget["bandwidth"] = np.full_like(found.mean, np.nan)
            cut = np.where(np.isnan(budget["bandwidth"]), AT_CUT_OFF, "")
            note = np.where(found.note == IDENTITY, IDENTITY, cut).astype(object)
            return replace(found, budget=budget, note=note)

        monkeypatch.setattr(Run, "estimate", changed)
        return rs.open_study(done.folder)

    return open_with


@pytest.fixture
def mixed(with_unknown_bandwidth):
    """The finished study; the bandwidth at the heaviest load is unknown."""
    return with_unknown_bandwidth([HEAVY])


@pytest.fixture
def known(with_unknown_bandwidth):
    """The finished study with all parts of the errors known."""
    return with_unknown_bandwidth([])


def test_the_tidy_table_names_the_unknown_parts_of_each_error_and_values_at_q_c(mixed):
    rows = [row for row in mixed.rows("flash_temperature") if row["speed"]]
    for row in rows:
        marked = row["nominal_pressure"] == HEAVY and row["column"] == "capped"
        assert (row["unknown"], row["note"]) == (("bandwidth", "at q_c") if marked else ("", ""))
    assert any(row["unknown"] for row in rows)


@pytest.mark.slow
def test_the_marks_of_a_study_are_those_of_the_comparison_of_each_run(done):
    marks = {
        (row["point"], row["observable"], row["speed"]): (row["unknown"], row["note"])
        for row in done.rows()
        if row["column"] == "capped"
    }
    assert {note for _, note in marks.values()} == {"", "at q_c", "identity"}
    for point, run in done.results:
        for row in rs.compare(run).rows:
            if (point.name, row.observable, row.speed) in marks:
                unknown, note = marks[point.name, row.observable, row.speed]
                assert unknown == ", ".join(row.columns["capped"].unknown)
                assert note == row.note


def test_the_table_for_people_has_a_lower_bound_and_a_note_as_that_of_a_run(mixed):
    table = study_table(mixed)
    titles = [column.title for column in table.columns]
    cells = [str(row[titles.index("capped, K")]) for row in table.rows]
    assert ["≥" in cell for cell in cells] == [False] * 4 + [True] * 2
    assert [row[titles.index("note")] for row in table.rows] == [""] * 4 + ["at q_c"] * 2
    assert any(
        note.startswith("≥: a part of the error is unknown") and "(bandwidth)" in note
        for note in table.notes
    )
    assert any(note.startswith("at q_c: ") for note in table.notes)


def test_without_marks_the_table_has_no_column_for_them(known):
    table = study_table(known)
    assert "note" not in [column.title for column in table.columns]
    assert "≥" not in str(known)


def test_a_target_is_met_where_all_parts_of_the_error_are_known(known):
    known.target_error = 0.9
    assert "at most 90 % at every speed: 6 points; the largest is " in target_note(known)[0]
    assert "≥" not in target_note(known)[0]


def test_a_target_is_not_met_where_a_part_of_the_error_is_unknown(mixed):
    mixed.target_error = 0.9
    words = "at most 90 % at every speed: 4 points; at 2 points a part of it is unknown (bandwidth); the largest is "
    assert words in target_note(mixed)[0]


def test_the_largest_error_is_a_lower_bound_where_a_part_of_it_is_unknown(done):
    # no run of this study shows the error of the pixel
    study = rs.open_study(done.folder)
    study.target_error = 0.9
    assert (
        ": 0 points; at 6 points a part of it is unknown (pixel); the largest is ≥"
        in target_note(study)[0]
    )


def test_there_is_no_exponent_between_values_of_different_kind(mixed):
    trends = [trend for trend in mixed.trends() if trend["key"] == "nominal_pressure"]
    assert {trend["to"] for trend in trends} == set(LOADS[1:])
    for trend in trends:
        assert np.isnan(trend["exponent"]) == (trend["to"] == HEAVY)
        assert np.isnan(trend["exponent_error"]) == (trend["to"] == HEAVY)
    # both at q_c: exactly proportional to friction
    same = [trend for trend in mixed.trends() if trend["key"] == "friction_coefficient"]
    assert [trend["exponent"] for trend in same] == pytest.approx([1.0] * len(same), rel=1e-9)
    assert "– between values of different kind" in " ".join(study_table(mixed).notes)
    assert any("–" in str(row[-3]) for row in study_table(mixed).rows)


def test_values_that_all_lack_a_part_are_not_said_to_have_all_parts_known(with_unknown_bandwidth):
    study = with_unknown_bandwidth([HEAVY], else_known=False)
    found = {
        row["unknown"]
        for row in study.rows("flash_temperature")
        if row["column"] == "capped" and row["speed"]
    }
    assert "" not in found
    (note,) = [note for note in study_table(study).notes if "different kind" in note]
    assert "known," not in note
    assert "other parts of their errors unknown" in note


def test_an_exponent_that_a_value_of_zero_lacks_has_a_note(quick, tmp_path):
    quick = replace(quick, ensemble=replace(quick.ensemble, max_realizations=2))
    notes = study_table(
        rs.study(quick, vary={"surface.hurst": [0.0, 0.8]}, folder=tmp_path / "s")
    ).notes
    assert any("– at values of the key that are not above 0" in note for note in notes)
    assert not any("different kind" in note for note in notes)


def test_the_ratio_of_two_points_names_the_parts_that_its_error_lacks(done):
    trends = list(done.trends())
    assert trends
    assert {trend["unknown"] for trend in trends} == {"pixel"}
    assert all(np.isfinite(trend["exponent"]) for trend in trends)  # both of one kind


@pytest.mark.slow
def test_files_of_a_study_have_the_marks(mixed, tmp_path):
    rows = list(mixed.rows())
    marks = [(row["unknown"], row["note"]) for row in rows]
    assert ("bandwidth", "at q_c") in marks
    with mixed.save(tmp_path / "t.csv").open() as file:
        assert [(row["unknown"], row["note"]) for row in csv.DictReader(file)] == marks
    stored = json.loads(mixed.save(tmp_path / "t.json").read_text())["rows"]
    assert [(row["unknown"], row["note"]) for row in stored] == marks
    import h5py

    with h5py.File(mixed.save(tmp_path / "t.h5")) as file:
        column = [name.decode() for name in file["column"]].index("capped")
        part = [name.decode() for name in file["part"]].index("bandwidth")
        assert np.isnan(file["flash_temperature_part"][part, column, 2, 1, -1])
        assert file["flash_temperature_note"].asstr()[column, 2, 1, -1] == "at q_c"
        assert np.isfinite(file["flash_temperature_part"][part, column, 0, 0, -1])
        words = "total error of the mean, 95 %: root of the squares of its known parts"
        assert file["flash_temperature_total_error"].attrs["description"] == words
        beside = file["flash_temperature"].attrs["ancillary_variables"].split()
        assert all(
            f"flash_temperature_{part}" in beside for part in ("total_error", "part", "note")
        )


@pytest.mark.slow
def test_arrays_and_data_frames_of_a_study_have_the_marks(mixed, tmp_path):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    place = {
        "nominal_pressure": HEAVY,
        "friction_coefficient": 0.2,
        "column": "capped",
        "speed": 35.0,
    }
    with xarray.open_dataset(mixed.save(tmp_path / "s.nc"), engine="h5netcdf") as stored:
        for data in (stored, mixed.to_xarray()):
            parts = data.flash_temperature_part.sel(place)
            assert parts.part[np.isnan(parts)].values.tolist() == ["bandwidth"]
            assert data.flash_temperature_note.sel(place).item() == "at q_c"
    frame = mixed.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    marks = [(row["unknown"], row["note"]) for row in mixed.rows()]
    assert list(zip(frame["unknown"], frame["note"], strict=True)) == marks


def test_a_chart_has_hollow_markers_without_a_line_where_a_value_is_marked(mixed, drawn):
    mixed.chart("s.svg")
    axes = drawn[0].axes[0]
    circles = [line for line in axes.lines if line.get_marker() == "o"]
    white = to_rgba("white")
    hollow = {
        load
        for line in circles
        if to_rgba(line.get_markerfacecolor()) == white
        for load in line.get_xdata()
    }
    filled = {
        load
        for line in circles
        if to_rgba(line.get_markerfacecolor()) != white
        for load in line.get_xdata()
    }
    assert (filled, hollow) == ({100.0, 120.0}, {300.0})  # MPa
    for line in axes.lines:
        if line.get_gid() == "measured":
            assert np.array_equal(np.isnan(line.get_ydata()), [False, False, True])
    assert "hollow: at" in axes.get_legend().get_texts()[-1].get_text()


@pytest.mark.slow
def test_a_chart_without_marks_has_no_hollow_points(known, tmp_path):
    known.chart(tmp_path / "s.svg")
    assert "hollow" not in (tmp_path / "s.svg").read_text()


@pytest.mark.slow
def test_the_report_of_a_study_has_the_marks(mixed, tmp_path):
    text = rs.report(mixed, tmp_path / "s.html").read_text()
    assert "± ≥" in text
    assert "at q_c" in text
