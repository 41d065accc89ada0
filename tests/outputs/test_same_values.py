"""One run in every output: JSON, data frame, CSV, xarray, netCDF and the numbers of a figure have the same values."""

import csv
import json
import math

import numpy as np
import pytest

import roughsim as rs

RATIOS = "_over_"


@pytest.fixture(scope="module")
def in_json(capped_run):
    """Values and total errors of `compare --json` by observable, column and speed; a speed of None is NaN there."""
    found = {}
    for row in json.loads(json.dumps(rs.compare(capped_run).to_dict()))["rows"]:
        for column, cell in row.items():
            if isinstance(cell, dict):
                value = cell.get("mean", cell.get("value"))
                found[row["observable"], column, row["speed"]] = value, cell["total_error"]
            elif column in ("theory", "calibrated"):
                found[row["observable"], column, row["speed"]] = cell, None
    return found


def of_dataset(data):
    """The same of a dataset of results: NAME (column, [speed]), with the parts of its error in NAME_part."""
    found = {}
    for name, array in data.data_vars.items():
        if f"{name}_part" not in data:
            continue
        parts = data[f"{name}_part"].transpose("part", *array.dims).values
        totals = np.sqrt(np.nansum(parts**2, axis=0))
        for place in np.ndindex(array.shape):
            where = {
                axis: data[axis].values[k].item() for axis, k in zip(array.dims, place, strict=True)
            }
            known = not np.isnan(parts[(slice(None), *place)]).all()
            error = totals[place].item() if known else None
            found[name, where["column"], where.get("speed")] = array.values[place].item(), error
    return found


def check(found, in_json, columns=lambda column: True):
    """Values are the same to the last bit; total errors to rounding, where they are made of their parts."""
    wanted = {key: pair for key, pair in in_json.items() if columns(key[1]) and pair[0] is not None}
    assert len(wanted) > 60
    for key, (value, error) in wanted.items():
        assert found[key][0] == value, key
        if error is not None:
            assert found[key][1] == pytest.approx(error, rel=1e-14, abs=0.0), key


def test_arrays_of_a_comparison_have_the_values_of_its_json(capped_run, in_json):
    pytest.importorskip("xarray")
    check(of_dataset(rs.compare(capped_run).to_xarray()), in_json)


@pytest.mark.slow
def test_results_in_netcdf_have_the_values_of_the_json(capped_run, in_json, tmp_path):
    xarray = pytest.importorskip("xarray")
    path = rs.export(capped_run, tmp_path / "run.nc")
    with xarray.open_dataset(path, group="results", engine="h5netcdf") as data:
        check(of_dataset(data.load()), in_json, lambda column: RATIOS not in column)


def test_the_tidy_table_has_the_values_of_the_json(capped_run, in_json, tmp_path):
    path = rs.export(capped_run, tmp_path / "run.csv")
    with open(path, newline="") as file:
        found = {
            (row["observable"], row["column"], float(row["speed"]) if row["speed"] else None): (
                float(row["value"]),
                float(row["total_error"]) if row["total_error"] else None,
            )
            for row in csv.DictReader(file)
        }
    check(found, in_json, lambda column: RATIOS not in column)


def test_the_data_frame_has_the_values_of_the_json(capped_run, in_json):
    pytest.importorskip("pandas")
    frame = rs.compare(capped_run).to_dataframe().reset_index()
    found = {}
    for row in frame.to_dict("records"):
        speed = None if math.isnan(row["speed"]) else row["speed"]
        for _, column, _ in [key for key in in_json if key[0] == row["observable"]]:
            found[row["observable"], column, speed] = row[column], row.get(f"{column}_total_error")
    check(found, in_json)


def test_estimates_have_the_values_of_the_json(capped_run, in_json):
    speeds = capped_run.scene.speeds
    for (observable, column, speed), (value, error) in in_json.items():
        if column not in capped_run.numerics.columns or value is None:
            continue
        found, k = (
            capped_run.estimate(observable, column),
            0 if speed is None else speeds.index(speed),
        )
        assert (found.mean[k], found.total_error[k]) == (value, error)


def test_the_numbers_of_a_figure_are_those_of_the_json(capped_run, in_json, tmp_path):
    """The figure has six digits; of an observable whose theory is not drawn densely, the theories too."""
    rs.plot(capped_run, "heat_partition", tmp_path / "f.svg", csv=tmp_path / "f.csv")
    with open(tmp_path / "f.csv", newline="") as file:
        drawn = {
            (row["curve"].rpartition(": ")[2], float(row["x"])): float(row["y"])
            for row in csv.DictReader(file)
            if row["curve"].partition(": ")[0] == capped_run.folder.name
        }
    for column in ("theory", "calibrated", "smoothed", "capped"):
        for speed in (speed for speed in capped_run.scene.speeds if speed > 0.0):
            value = in_json["heat_partition", column, speed][0]
            assert drawn[column, speed] == pytest.approx(value, rel=1e-6), column
