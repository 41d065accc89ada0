"""Trends of a study: ratios of neighbours on the same surfaces, with the errors of pairs."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import at_level, part_of
from study_cases import LOADS

import roughsim as rs
from roughsim.estimate.levels import values_of
from roughsim.studies.trends import paired_ratio


def test_flash_temperature_is_exactly_proportional_to_friction(done):
    trends = [t for t in done.trends() if t["key"] == "friction_coefficient" and t["speed"]]
    assert len(trends) == len(LOADS) * sum(speed > 0.0 for speed in done.scene.speeds)
    for trend in trends:
        assert trend["ratio"] == pytest.approx(2.0, rel=1e-12)
        assert trend["exponent"] == pytest.approx(1.0, rel=1e-12)
        assert trend["standard_error"] < 1e-12


def test_flash_temperature_is_exactly_proportional_to_the_share_of_the_heat(quick, tmp_path):
    scene = replace(quick, ensemble=replace(quick.ensemble, until={}, max_realizations=4))
    study = rs.study(scene, vary={"sliding.heat_partition": [0.25, 0.5]}, folder=tmp_path / "study")
    trends = list(study.trends())
    assert trends
    assert [trend["ratio"] for trend in trends] == pytest.approx([2.0] * len(trends), rel=1e-12)


def test_a_trend_is_known_better_than_its_points_for_they_see_the_same_surfaces(done):
    trends = [t for t in done.trends() if t["key"] == "nominal_pressure" and t["speed"] == 35.0]
    assert len(trends) == 4
    trends = [trend for trend in trends if trend["to"] == 1.2e8]
    by_name = {point.name: run for point, run in done.results}
    for trend in trends:
        each = [by_name[trend[end]].estimate("flash_temperature") for end in ("point", "before")]
        k = each[0].mean.size - 1
        relative = [e.standard_error[k] / e.mean[k] for e in each]
        assert trend["standard_error"] / trend["ratio"] < 0.7 * np.hypot(*relative)
        assert trend["ratio"] == pytest.approx(each[0].mean[k] / each[1].mean[k], rel=0.02)
        assert trend["exponent"] == pytest.approx(
            np.log(trend["ratio"]) / np.log(trend["to"] / trend["from"])
        )


def test_runs_with_other_surfaces_make_no_pairs(done, small, tmp_path):
    run = next(run for _, run in done.results)
    other = rs.run(replace(small, ensemble=replace(small.ensemble, seed=5)), tmp_path / "other")
    with pytest.raises(ValueError, match="their rows are no pairs"):
        paired_ratio(run, other, "flash_temperature")


def test_the_paired_error_of_a_ratio_is_that_of_the_jackknife(quick, tmp_path):
    # the ratio anew without each surface in turn; one level: nothing is fitted in q_c
    scene = replace(quick, ensemble=replace(quick.ensemble, until={}, max_realizations=40))
    study = rs.study(
        scene, vary={"sliding.nominal_pressure": [1e8, 2e8]}, folder=tmp_path / "study"
    )
    runs = [run for _, run in study.results]
    ratio, rows = paired_ratio(*runs, "flash_width"), np.arange(runs[0].realizations)
    samples = [run.samples()[0] for run in runs]

    def mean_ratio(chosen):
        above, below = (
            values_of(
                run.scene, "capped", "flash_width", [at_level(part_of(sample, chosen), 0, 0)]
            ).value[-1]
            for run, sample in zip(runs, samples, strict=True)
        )
        return above / below

    without = [mean_ratio(rows != i) for i in rows]
    jackknife = np.sqrt((len(rows) - 1) * np.var(without))
    assert ratio.mean[-1] == pytest.approx(mean_ratio(rows >= 0), rel=1e-12)
    assert ratio.standard_error[-1] == pytest.approx(jackknife, rel=0.15)


def test_points_with_other_numbers_of_members_are_paired_where_both_have_the_surface(
    quick, tmp_path
):
    runs = []
    for load, most in ((1e8, 12), (1.2e8, 20)):
        scene = quick.with_("sliding.nominal_pressure", load)
        scene = replace(scene, ensemble=replace(scene.ensemble, until={}, max_realizations=most))
        runs.append(rs.run(scene, tmp_path / f"{most}"))
    assert [run.realizations for run in runs] == [12, 20]
    ratio = paired_ratio(*runs, "flash_width")
    each = [run.estimate("flash_width") for run in runs]
    assert ratio.mean == pytest.approx(each[0].mean / each[1].mean, rel=1e-12)
    apart = np.hypot(*(one.standard_error / one.mean for one in each))
    assert np.all(ratio.standard_error / ratio.mean < apart)
