"""The ways to compute surface, heat, moments and theory that docs/accuracy.md sets side by side."""

import sys
import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.error_over_cost import base_problem

sys.path.append(str(Path(__file__).parents[2] / "experiments"))
with mpl.rc_context():
    import accuracy_vs_cost as experiment
    from script import Rows

SCENE, NUMERICS = rs.load_scene("demo"), experiment.toy_numerics()


def points_of(stage):
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", RuntimeWarning
        )  # the errors that they warn of are what is measured
        return list(experiment.WAYS[stage](SCENE, base_problem(SCENE, NUMERICS), 4))


def test_surfaces_of_fixed_amplitudes_have_their_rms_height_and_gaussian_ones_scatter():
    points = points_of("surface")
    fixed, gaussian = (
        [p.error for p in points if p.method.startswith(kind)] for kind in ("fixed", "gaussian")
    )
    assert max(fixed) < 1e-6
    assert min(gaussian) > 1e-3
    assert [p.setting.split(",")[0] for p in points if p.chosen] == ["4.04 longest waves"]


def test_a_hertz_contact_as_wide_as_the_theory_at_the_highest_speed():
    steel = rs.load_scene("steel-1.2GPa")
    speed = max(steel.speeds)
    width = prediction.predictions(steel)["flash_width"][steel.speeds.index(speed)]
    radius, peclet, flash_temperature = experiment.hertz_like(steel)
    assert width / radius == pytest.approx(4 / 9, rel=1e-12)  # D_flash of fast Hertz contacts
    assert peclet == pytest.approx(speed * radius * 7900 * 500 / 30.0, rel=1e-12)
    assert flash_temperature == pytest.approx(0.7438575075933 / np.sqrt(peclet), rel=0.02)


@pytest.mark.slow
def test_heat_and_theory_meet_the_exact_values_of_others():
    points = points_of("heat") + points_of("theory")
    kernels = {p.method: p.error for p in points if p.setting.startswith("64 pixels")}
    assert kernels["periodic, from rest"] < 1e-3
    assert kernels["free half-space"] < 1e-3
    assert kernels["periodic, steady"] > 1.0  # hot tracks
    ours, gauss = (
        [p.error for p in points if p.method == m] for m in ("package theory", "Gauss points")
    )
    assert ours[0] < 1e-9
    assert gauss[-1] < 1e-12 < gauss[0]


def test_the_mean_over_directions_scatters_less_than_one_direction():
    points = points_of("moments")
    error = {p.method: p.error for p in points}
    assert error["mean over directions"] < error["field from rest"] < error["1 direction, steady"]
    assert error["1 direction, steady"] == pytest.approx(error["steady field"], rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["surface", "contact"])
def test_a_stage_in_the_file_is_not_measured_again(stage, tmp_path):
    first = experiment.measured(Rows(tmp_path / "data.json"), stage, SCENE, NUMERICS, 4)
    again = experiment.measured(
        Rows(tmp_path / "data.json", resume=True), stage, SCENE, NUMERICS, 4
    )
    assert again == first  # with the same times
