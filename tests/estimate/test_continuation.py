"""Beyond the highest cut-off: values that follow the theory are continued with its shape to the end of C(q)."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import NAME, level

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.ladder import observe
from roughsim.scene.numerics import Level, Numerics

THEORY = np.array([[2.0], [2.8], [3.2], [4.0]])  # up to three cut-offs, and over the whole spectrum


def shaped(count, theory=THEORY, slope=1.5, **names):
    """Levels whose T_flash is 1 + slope × theory, at the highest of the cut-offs of the theory."""
    chosen = list(zip((1.0, 2.0, 4.0), 1.0 + slope * THEORY[:3, 0], strict=True))[-count:]
    samples = [level(np.full((13, 1), value), q_max=q, side=64.0 * q) for q, value in chosen]
    return observe(NAME, samples, capped=False, end=100.0, theory=theory[-count - 1 :], **names)


@pytest.mark.parametrize("count", [2, 3])
def test_a_value_that_goes_with_the_theory_is_continued_by_its_last_step_over_that_of_the_theory(count):
    values = shaped(count)
    assert values.extrapolated.mean() == pytest.approx(1.0 + 1.5 * 4.0, rel=1e-12)
    assert values.finest.mean() == pytest.approx(1.0 + 1.5 * 3.2, rel=1e-12)
    # the remainder is 1.5 × 0.8 by the steps and 5.8 × 0.8/3.2 by the values
    assert values.bandwidth[0] == pytest.approx(max(1.45 - 1.2, 1.2 / 4), rel=1e-12)
    assert shaped(count, slope=0.5).bandwidth[0] == pytest.approx(2.6 / 4 - 0.4, rel=1e-9)
    assert np.isnan(values.exponent[0])


def test_one_cut_off_is_continued_in_proportion_to_the_theory_and_doubted_as_much():
    values = shaped(1)
    assert values.extrapolated.mean() == pytest.approx(5.8 * 4.0 / 3.2, rel=1e-12)
    assert values.bandwidth[0] == pytest.approx(5.8 * 0.25, rel=1e-12)


def test_what_the_theory_leaves_above_half_of_the_value_or_does_not_say_is_unknown():
    beyond = np.vstack([THEORY[:3], [[3.2 + 3.0]]])  # 1.5 × 3 exceeds half of 5.8
    for theory in (beyond, np.full_like(THEORY, np.nan)):
        values = shaped(3, theory)
        assert values.extrapolated.mean() == pytest.approx(5.8, rel=1e-12)
        assert np.isnan(values.bandwidth[0])
    settled = np.vstack([THEORY[:3], THEORY[2:3]])
    assert shaped(3, settled).bandwidth[0] == 0.0


def test_the_scatter_of_the_last_step_passes_into_what_is_continued():
    rng = np.random.default_rng(7)
    low = 10.0 + rng.standard_normal((40, 1))
    high = low + 1.0 + 0.2 * rng.standard_normal((40, 1))
    samples = [level(low, q_max=1.0), level(high, q_max=2.0)]
    values = observe(NAME, samples, capped=False, end=9.0, theory=np.array([[1.0], [1.5], [2.5]]))
    np.testing.assert_allclose(values.extrapolated, high + 2.0 * (high - low), rtol=1e-12)


@pytest.fixture(scope="module")
def cut_run(capped_scene, tmp_path_factory):
    """Elastic contact on two of the four octaves of C(q) above the first, 12 realizations."""
    levels = (
        {"column": "elastic", "shape": [64, 64], "q_max": 5e4},
        {"column": "elastic", "shape": [128, 128], "q_max": 1e5},
    )
    scene = replace(
        capped_scene,
        body=replace(capped_scene.body, penetration_hardness=None),
        surface=replace(capped_scene.surface, q_max=4e5),
        numerics=replace(capped_scene.numerics, levels=levels),
        ensemble=replace(capped_scene.ensemble, max_realizations=12),
    )
    return rs.run(scene, tmp_path_factory.mktemp("cut") / "run")


def test_a_cut_elastic_scene_is_continued_to_what_a_grid_that_holds_it_finds(cut_run):
    scene, found = cut_run.scene, cut_run.estimate("flash_temperature")
    whole = Numerics((Level("elastic", (128, 128), 1e5), Level("elastic", (512, 512), 4e5)), cut_run.numerics.lengths)
    rows = np.array(
        [
            [rs.realize(scene, whole, seed=5, level=k, index=i).observables.flash_temperature for k in (0, 1)]
            for i in range(4)
        ]
    )
    rises = (rows[:, 1] - rows[:, 0]).mean(axis=0)[1:] / rows[:, 0].mean(axis=0)[1:]
    assert np.all(rises > 0.02)
    top = cut_run.values("flash_temperature").finest.mean(axis=0)[1:] * cut_run.heat_partition[1:]
    assert np.all(np.abs(found.mean[1:] - top * (1 + rises)) < found.budget["bandwidth"][1:])
    assert np.all(found.budget["bandwidth"][1:] < 1.1 * top * rises)
    assert found.budget["bandwidth"][0] == 0.0  # at rest
    assert "continued from q_c to q_max with the shape of the theory" in found.explain()
    assert "does not converge" not in found.explain()


def test_what_rises_without_bound_is_told_at_the_highest_cut_off(cut_run):
    found = cut_run.estimate("flash_laplacian")
    assert found.unknown == ("bandwidth", "pixel")
    np.testing.assert_array_equal(found.bias, 0.0)
    assert "the value of the highest q_c" in found.explain()


def test_the_ratio_to_the_theory_is_of_the_same_modes_though_the_mean_goes_on_to_q_max(cut_run):
    row = next(r for r in rs.compare(cut_run).rows if r.observable == "flash_temperature" and r.speed == 35.0)
    top = cut_run.values("flash_temperature").finest.mean(axis=0)[-1]
    drawn = cut_run.scene.spectrum.truncated(q_max=1e5)
    modes = prediction.mode_sums(cut_run.scene, drawn, cut_run.numerics.grid(1))["flash_temperature"][-1]
    assert row.ratios["elastic_over_theory"].value == pytest.approx(top / modes, rel=1e-9)
    assert row.columns["elastic"].mean > 1.05 * top * cut_run.heat_partition[-1]
