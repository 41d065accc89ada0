"""What a study varies: axes, their values in SI, and the names of the points."""

import re

import numpy as np
import pytest

from roughsim.studies.tables import value_text
from roughsim.studies.vary import NAME, points_of, read_axes


def test_a_grid_has_all_combinations_and_the_last_key_varies_fastest():
    axes = read_axes(
        {
            "sliding.nominal_pressure": ["1 MPa", "5 MPa"],
            "body.penetration_hardness": ["1 GPa", "2 GPa"],
        }
    )
    values = [tuple(point.values.values()) for point in points_of(axes)]
    assert values == [(1e6, 1e9), (1e6, 2e9), (5e6, 1e9), (5e6, 2e9)]


def test_first_last_and_count_stand_for_a_list():
    (axis,) = read_axes({"sliding.nominal_pressure": {"logspace": ["1 MPa", "100 MPa", 5]}})
    ratios = np.diff(np.log([value for (value,) in axis.values]))
    assert len(axis.values) == 5
    assert np.allclose(ratios, np.log(100.0) / 4, rtol=1e-7)
    (axis,) = read_axes({"surface.hurst": {"linspace": [0.6, 0.9, 4]}})
    assert [value for (value,) in axis.values] == pytest.approx([0.6, 0.7, 0.8, 0.9])


def test_words_and_numbers_may_mix_and_so_may_keys():
    read_axes({"sliding.heat_partition": ["mean", 0.5]})
    read_axes(
        {"sliding.nominal_pressure, sliding.friction_coefficient": [["1 MPa", 0.1], ["2 MPa", 0.2]]}
    )


def test_a_count_may_come_from_numpy():
    (axis,) = read_axes({"sliding.speed": {"linspace": [1.0, 2.0, np.int64(3)]}})
    assert axis.values == ((1.0,), (1.5,), (2.0,))


def test_lists_and_tables_are_written_as_a_scene_file_has_them_and_short():
    table = {"temperature": ["300 K", "900 K"], "value": [50, 30]}
    assert value_text("body.conductivity", table).startswith('{ temperature = ["300 K", ')
    assert value_text("body.conductivity", table).endswith("[50, 30] }")
    assert len(value_text("body.conductivity", table)) <= 40
    assert value_text("numerics.lengths", [1e-3, 2e-3]) == "[1000, 2000]"
    assert value_text("body.conductivity", {"value": [50, 30]}) == "{ value = [50, 30] }"


def test_whole_numbers_may_be_spaced_and_lists_have_units_and_names():
    assert read_axes({"ensemble.seed": {"linspace": [1, 5, 3]}})[0].values == ((1,), (3,), (5,))
    (axis,) = read_axes({"numerics.lengths": [[1e-3, 9e-4], np.array([2e-3, 1e-3])]})
    assert axis.values == (((1e-3, 9e-4),), ((2e-3, 1e-3),))
    assert [point.name for point in points_of([axis])] == [
        "lengths=0.001-0.0009",
        "lengths=0.002-0.001",
    ]
    assert value_text("numerics.lengths", (1e-3, 9e-4)) == "[1000, 900]"  # µm


def test_keys_that_change_together_share_an_axis():
    together = {
        "sliding.friction_coefficient, body.conductivity": [
            [0.1, "20 W/(m K)"],
            [0.2, "40 W/(m K)"],
        ]
    }
    points = points_of(read_axes(together))
    assert [point.values for point in points] == [
        {"sliding.friction_coefficient": 0.1, "body.conductivity": 20.0},
        {"sliding.friction_coefficient": 0.2, "body.conductivity": 40.0},
    ]


def test_names_of_points_are_folders_that_no_pattern_mistakes():
    vary = {
        "sliding.nominal_pressure": ["1 MPa", "1.234567891 MPa"],
        "sliding.speed": [["1 m/s", "2 m/s"], "3 m/s"],
        "sliding.heat_partition": ["mean", "all", 0.5],
    }
    names = [point.name for point in points_of(read_axes(vary))]
    assert len(set(names)) == 12
    assert all(NAME.fullmatch(name) and not re.search(r"[*?\[\]/\\ ]", name) for name in names)
    assert names[-1] == "nominal_pressure=1234567.89,sliding_speed=3,sliding_heat_partition=0.5"


def test_long_values_have_names_of_their_own():
    words = ["x" * 70 + "a", "x" * 70 + "b", "größe" * 30]
    names = [point.name for point in points_of(read_axes({"title": words}))]
    assert len(set(names)) == 3
    assert all(NAME.fullmatch(name) and name.isascii() for name in names)
