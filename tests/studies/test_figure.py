"""Figures of observables that are negative, zero or infinite at some points of a study."""

from dataclasses import replace

import pytest

import roughsim as rs


@pytest.fixture(scope="module")
def at_rest(small, tmp_path_factory):
    scene = replace(small, sliding=replace(small.sliding, speed=(0.0, 1.0)))
    folder = tmp_path_factory.mktemp("studies") / "at rest"
    return rs.study(scene, vary={"sliding.friction_coefficient": [0.1, 0.2]}, folder=folder)


@pytest.mark.filterwarnings(
    "error::RuntimeWarning", "error::UserWarning", "ignore::roughsim.show.text.SceneWarning"
)
@pytest.mark.parametrize("observable", ["slope_length", "flash_gradient"])
def test_figures_leave_out_what_is_infinite_and_have_errors_of_what_is_negative(
    at_rest, tmp_path, observable
):
    at_rest.chart(tmp_path / "chart.svg", observable)
    assert (tmp_path / "chart.svg").stat().st_size > 10_000
