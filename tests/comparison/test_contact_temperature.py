"""The temperature of the contact in a scene with a duration: T₀(t) + T_flash, exact in its first part."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.tables import theory_dict, theory_table

TIME = 3e-5  # s


def warming(scene):
    """(2μσ₀v/κ) √(Dt/π), K, with all the heat in the moving body."""
    sliding, speed = scene.sliding, np.array(scene.speeds)
    kappa, diffusivity = scene.conduction()[:2]
    flux = sliding.friction_coefficient * sliding.nominal_pressure * speed
    return 2 * flux / kappa * np.sqrt(diffusivity * TIME / np.pi)


def lasting(scene, **sliding):
    return replace(
        scene, sliding=replace(scene.sliding, **{"duration": TIME, "heat_partition": 0.8} | sliding)
    )


@pytest.fixture(scope="module")
def runs(capped_scene, tmp_path_factory):
    """The comparison of a scene of both columns that lasts, and that of the same scene without end."""
    folder = tmp_path_factory.mktemp("lasting")
    steady = lasting(capped_scene, duration=None)
    return [
        rs.compare(rs.run(s, folder / str(k)))
        for k, s in enumerate((lasting(capped_scene), steady))
    ]


def of(table, name):
    return [row for row in table.rows if row.observable == name]


def test_without_a_duration_nothing_changes(runs):
    with_duration, steady = runs
    assert of(steady, "contact_temperature") == []
    assert "contact_temperature" not in theory_dict(steady.run.scene)
    before = [row for row in with_duration.rows if row.observable != "contact_temperature"]
    for row, other in zip(before, steady.rows, strict=True):
        np.testing.assert_equal(row.to_dict(), other.to_dict())


def test_the_row_is_the_flash_temperature_and_an_exact_warming(runs):
    table, scene = runs[0], runs[0].run.scene
    rows, flash, warm = (
        of(table, "contact_temperature"),
        of(table, "flash_temperature"),
        warming(scene),
    )
    assert [row.speed for row in rows] == list(scene.speeds)
    assert warm[-1] > 100.0
    for k, (row, part) in enumerate(zip(rows, flash, strict=True)):
        added = 0.8 * warm[k]
        for name in ("theory", "theory_at_cut_off", "theory_same_modes", "calibrated"):
            expected = pytest.approx(part.theories[name] + added, rel=1e-12, nan_ok=True)
            assert row.theories[name] == expected
        for name, cell in row.columns.items():
            flash = part.columns[name]
            assert cell.mean == pytest.approx(flash.mean + added, rel=1e-12)
            for name_of_part, error in cell.budget.items():  # T₀ has none
                np.testing.assert_array_equal(error, flash.budget[name_of_part])
            assert (cell.standard_error, cell.bias) == (flash.standard_error, flash.bias)
        assert (row.unit, row.note) == ("K", part.note)
    told = theory_dict(scene)
    expected = np.array(told["flash_temperature"]) + 0.8 * warm
    np.testing.assert_allclose(told["contact_temperature"], expected, rtol=1e-12)
    assert "T₀ + T_flash, K" in [column.title for column in theory_table(scene).columns]
    assert any(note.startswith("contact_temperature: T₀ + T_flash") for note in table.table().notes)


def test_the_ratios_are_those_of_the_sums(runs):
    table, warm = runs[0], warming(runs[0].run.scene)
    values = {
        name: table.run.values("flash_temperature", name).value for name in ("smoothed", "capped")
    }
    rows, flash = of(table, "contact_temperature"), of(table, "flash_temperature")
    for k, (row, part) in enumerate(zip(rows, flash, strict=True)):
        if row.speed == 0.0:
            assert np.isnan(row.ratios["smoothed_over_theory"].mean)
            continue
        theory = part.theories["theory_same_modes"] / 0.8
        mine, his = row.ratios["smoothed_over_theory"], part.ratios["smoothed_over_theory"]
        assert mine.mean == pytest.approx(
            (his.mean * theory + warm[k]) / (theory + warm[k]), rel=1e-12
        )
        assert mine.standard_error == pytest.approx(
            his.standard_error * theory / (theory + warm[k]), rel=1e-9
        )
        assert mine.total_error < his.total_error
        both = row.ratios["capped_over_smoothed"]
        assert both.mean == pytest.approx(
            (values["capped"][k] + warm[k]) / (values["smoothed"][k] + warm[k]), rel=2e-3
        )
        alone = part.ratios["capped_over_smoothed"]
        assert both.standard_error / both.mean < alone.standard_error / alone.mean


def test_full_contact_is_exact_with_its_warming(full_scene, tmp_path):
    scene = lasting(full_scene, heat_partition="total")
    rows = of(rs.compare(rs.run(scene, tmp_path / "full")), "contact_temperature")
    share, warm = prediction.heat_partition(scene), warming(scene)
    for k, row in enumerate(rows):
        alone = prediction.predictions(scene)["flash_temperature"][k]
        assert row.theory == pytest.approx(share[k] * (alone + warm[k]), rel=1e-12)
        if row.speed:
            assert row.ratios["elastic_over_theory"].mean == pytest.approx(1.0, abs=1e-12)
            # the share of the column is its own, by sums over its modes; that of the theory is by integrals
            assert row.columns["elastic"].mean == pytest.approx(
                row.theories["theory_same_modes"], rel=1e-8
            )
