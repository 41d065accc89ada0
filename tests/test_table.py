"""`Estimate` and `Results`: labels stay at their values, through selecting, joining and writing."""

import json
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim.results.table import Results
from roughsim.table import Estimate, concat

NAN = np.nan
SPEEDS = [1.0, 35.0]


def over_speed(mean, **budget):
    parts = {name: np.array(part) for name, part in budget.items()}
    return Estimate.of("flash_temperature", "K", mean, {"speed": np.array(SPEEDS)}, parts)


@pytest.fixture
def flash():
    """T_flash over column and speed: a theory without errors, and a simulation with two parts."""
    pieces = {
        (0,): over_speed([10.0, 20.0]),
        (1,): over_speed([11.0, 22.0], statistical=[3.0, 6.0], bandwidth=[4.0, NAN]),
    }
    return concat(pieces, {"column": np.array(["theory", "capped"])})


def test_joined_columns_stay_at_their_labels(flash):
    assert flash.dims == ("column", "speed")
    np.testing.assert_array_equal(flash.sel(column="theory").mean, [10.0, 20.0])
    np.testing.assert_array_equal(flash.sel(column="capped").mean, [11.0, 22.0])
    np.testing.assert_array_equal(flash.sel(speed=35).mean, [20.0, 22.0])
    assert flash.sel(column="capped", speed=1.0).mean == 11.0


def test_several_labels_stay_in_their_order(flash):
    turned = flash.sel(speed=[35.0, 1.0], column=["capped"])
    np.testing.assert_array_equal(turned.mean, [[22.0, 11.0]])
    np.testing.assert_array_equal(turned.coords["speed"], [35.0, 1.0])
    np.testing.assert_array_equal(turned.budget["statistical"], [[6.0, 3.0]])


def test_a_label_that_is_not_there_is_an_error(flash):
    with pytest.raises(KeyError):
        flash.sel(speed=2.0)
    assert flash.sel(energy=1.0).dims == flash.dims  # an axis that it lacks


def test_total_is_the_root_of_squares_of_the_known_parts(flash):
    np.testing.assert_array_equal(flash.total_error, [[NAN, NAN], [5.0, 6.0]])
    assert flash.unknown == ("bandwidth",)
    assert flash.unknown_at(1, 1) == ("bandwidth",)
    assert flash.unknown_at(1, 0) == flash.unknown_at(0, 1) == ()  # a theory states no error


def test_a_part_that_a_piece_lacks_is_zero_and_without_any_error_unknown():
    law, scan = over_speed([1.0, 1.0], law=[2.0, 2.0]), over_speed([1.0, 1.0], scan=[3.0, 3.0])
    pieces = {(0,): law, (1,): scan, (2,): over_speed([1.0, 1.0])}
    joined = concat(pieces, {"column": np.array(["a", "b", "c"])})
    np.testing.assert_array_equal(joined.budget["law"][:, 0], [2.0, 0.0, NAN])
    np.testing.assert_array_equal(joined.budget["scan"][:, 0], [0.0, 3.0, NAN])
    np.testing.assert_array_equal(joined.total_error[:, 0], [2.0, 3.0, NAN])


def test_axes_are_column_then_keys_then_speed():
    # two loads by three lengths, of which one point is missing; the value has load, length, column and speed as digits
    loads, lengths, columns = [10.0, 20.0], ["short", "long", "whole"], ["theory", "capped"]
    pieces = {}
    for i, j in np.ndindex(2, 3):
        if (i, j) == (1, 2):
            continue
        mean = [1000.0 * i + 100.0 * j + np.arange(2.0) + 10.0 * k for k in (0, 1)]
        coords = {"column": np.array(columns), "speed": np.array(SPEEDS)}
        pieces[i, j] = Estimate.of("flash_temperature", "K", mean, coords)
    whole = concat(pieces, {"load": np.array(loads), "length": np.array(lengths)})
    assert whole.dims == ("column", "load", "length", "speed")
    assert whole.mean.shape == (2, 2, 3, 2)
    assert whole.sel(load=20.0, length="long", column="capped", speed=35.0).mean == 1111.0
    assert whole.sel(load=10.0, length="whole", column="theory", speed=1.0).mean == 200.0
    np.testing.assert_array_equal(whole.sel(load=20.0, length="whole").mean, np.full((2, 2), NAN))


def test_speeds_of_pieces_are_united():
    one = Estimate.of("flash_width", "m", [1.0, 2.0], {"speed": np.array([0.5, 3.0])})
    other = Estimate.of("flash_width", "m", [3.0, 4.0], {"speed": np.array([3.0, 7.0])})
    joined = concat({(0,): one, (1,): other}, {"load": np.array([10.0, 20.0])})
    np.testing.assert_array_equal(joined.coords["speed"], [0.5, 3.0, 7.0])
    np.testing.assert_array_equal(joined.mean, [[1.0, 2.0, NAN], [NAN, 3.0, 4.0]])


def test_rows_have_the_labels_of_each_defined_value(flash):
    rows = list(Results({"flash_temperature": flash.sel(column=["capped"])}).rows())
    head = {"observable": "flash_temperature", "unit": "K", "column": "capped"}
    first = {"speed": 1.0, "value": 11.0, "total_error": 5.0, "unknown": "", "note": ""}
    second = {"speed": 35.0, "value": 22.0, "total_error": 6.0, "unknown": "bandwidth", "note": ""}
    assert rows == [head | first, head | second]
    area = Estimate.of("contact_fraction", "1", [0.1], {"speed": np.array([NAN])})
    assert [row["speed"] for row in area.rows()] == [None]
    assert list(Estimate.of("flash_width", "m", [NAN], {"speed": np.array([1.0])}).rows()) == []


def test_arrays_have_the_parts_first_and_no_axis_of_speed_without_speeds(flash):
    area = Estimate.of(
        "contact_fraction", "1", [[0.1], [0.2]], {**flash.coords, "speed": np.array([NAN])}
    )
    found = {name: rest for name, *rest in Results({"T": flash, "A": area}).arrays()}
    assert found["part"][1].tolist() == ["statistical", "bandwidth"]
    assert found["speed"][1].tolist() == SPEEDS
    assert found["speed"][2] == {"units": "m/s"}
    dims, values, about = found["T_part"]
    assert dims == ("part", "column", "speed")
    np.testing.assert_array_equal(values, [[[NAN, NAN], [3.0, 6.0]], [[NAN, NAN], [4.0, NAN]]])
    assert about["units"] == "K"
    assert found["A"][0] == ("column",)
    np.testing.assert_array_equal(found["A"][1], [0.1, 0.2])
    assert found["T_total_error"][1][1].tolist() == [5.0, 6.0]


def test_the_dataset_of_a_comparison_is_its_json(capped_run):
    pytest.importorskip("xarray")
    comparison = rs.compare(capped_run)
    data = comparison.to_xarray()
    assert data.flash_temperature.dims == ("column", "speed")
    rows = json.loads(json.dumps(comparison.to_dict()))["rows"]
    checked = 0
    for row in rows:
        entry = data[row["observable"]]
        if row["speed"] is not None:
            entry = entry.sel(speed=row["speed"])
        for column in set(data.column.values) & set(row):
            value, found = row[column], float(entry.sel(column=column))
            value = value.get("mean", value.get("value")) if isinstance(value, dict) else value
            assert found == value or (not np.isfinite(found) and value is None), (row, column)
            checked += np.isfinite(found)
    assert checked > 100


def full():
    """Two values with an error, a bias, and a mark each, of three realizations."""
    return replace(
        over_speed([10.0, -20.0], statistical=[3.0, 6.0], pixel=[1.0, NAN]),
        standard_error=np.array([1.0, 2.0]),
        bias=np.array([0.5, -0.25]),
        n=3,
        effective_n=np.array([2.0, 3.0]),
        note=np.array(["identity", "at q_c"], object),
    )


def test_a_multiple_has_the_multiple_of_all_errors_and_none_is_negative():
    found = full().times(-2.0)
    np.testing.assert_array_equal(found.mean, [-20.0, 40.0])
    np.testing.assert_array_equal(found.bias, [-1.0, 0.5])
    np.testing.assert_array_equal(found.standard_error, [2.0, 4.0])
    np.testing.assert_array_equal(found.budget["statistical"], [6.0, 12.0])
    np.testing.assert_array_equal(found.budget["pixel"], [2.0, NAN])
    np.testing.assert_array_equal(found.effective_n, [2.0, 3.0])


def test_each_entry_of_joined_estimates_keeps_what_it_had():
    other = replace(over_speed([1.0, 2.0], statistical=[0.0, 0.0], bandwidth=[7.0, 8.0]), n=12)
    joined = concat({(0,): full(), (1,): other}, {"column": np.array(["a", "b"])})
    assert joined.n == 12
    assert joined.note.tolist() == [["identity", "at q_c"], ["", ""]]
    for name in ("mean", "standard_error", "bias", "effective_n"):
        np.testing.assert_array_equal(getattr(joined.sel(column="a"), name), getattr(full(), name))
    # parts stand in the order that each piece has
    third = over_speed([1.0, 2.0], statistical=[1.0, 1.0], bandwidth=[1.0, 1.0], pixel=[1.0, 1.0])
    joined = concat({(0,): full(), (1,): third}, {"column": np.array(["a", "b"])})
    assert list(joined.budget) == ["statistical", "bandwidth", "pixel"]


def test_arrays_have_scatter_and_bias_under_their_own_names(flash):
    found = {name: values for name, _, values, _ in Results({"T": full(), "A": flash}).arrays()}
    np.testing.assert_array_equal(found["T_standard_error"], [1.0, 2.0])
    np.testing.assert_array_equal(found["T_bias"], [0.5, -0.25])
    assert found["T_note"].tolist() == ["identity", "at q_c"]
    # a part that a value lacks is 0, and unknown where no error is stated
    place = found["part"].tolist().index("bandwidth")
    np.testing.assert_array_equal(found["T_part"][place], [0.0, 0.0])
    place = found["part"].tolist().index("pixel")
    np.testing.assert_array_equal(found["A_part"][place], [[NAN, NAN], [0.0, 0.0]])


def test_a_value_without_a_stated_error_is_shown_without_one(flash):
    assert (flash.number(0, 1).error, flash.number(1, 0).error) == (0.0, 5.0)
    assert flash.number(1, 1).unknown == ("bandwidth",)
