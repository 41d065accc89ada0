"""Reactions and the heat above temperatures in a study: rows, files, tables, pictures and pages."""

import csv
import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

import roughsim as rs
from roughsim.estimate.asked import ABOUT
from roughsim.outputs.study_report import page
from roughsim.show.table import table_text
from roughsim.studies.figure import curves_of, usual_choice
from roughsim.studies.results import SPEED
from roughsim.studies.tables import asked_table

pytestmark = pytest.mark.usefixtures("few_fields")
LOADS = [5e7, 1e8]
ENERGIES = [0.0, 1.0]  # eV
ASKS = {
    "sliding.background_temperature": 500.0,
    "surface.q_roll_off": 3e4,
    "surface.q_max": 8e4,
    "sliding.speed": [1.0, 10.0],
    "sliding.heat_partition": 0.5,
    "observables.heat_above": [520.0, 560.0],
    "reaction.activation_energy": [f"{energy} eV" for energy in ENERGIES],
    "reaction.prefactor": 1e13,
    "ensemble.until": {},
    "ensemble.max_realizations": 4,
    "numerics.lengths": [2e-3, 2e-3],
    "numerics.levels": [{"column": "capped", "shape": [48, 48], "q_max": 4e4}],
}


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    scene = rs.load_scene("steel-1.2GPa", ASKS)
    vary = {"sliding.nominal_pressure": LOADS}
    return rs.study(scene, vary=vary, folder=tmp_path_factory.mktemp("asked") / "loads")


@pytest.mark.slow
def test_rows_have_the_estimates_of_each_run_at_each_energy_and_temperature(asked):
    found = {}
    for row in asked.rows():
        if row["observable"] in ABOUT and row["column"] == "capped":
            key = (
                row["point"],
                row["observable"],
                row.get("energy"),
                row.get("temperature"),
                row["speed"],
            )
            assert key not in found
            found[key] = row["value"], row["total_error"]
    expected = {}
    for point, run in asked.results:
        for name, one in run.reactions().items():
            labels = one.coords[ABOUT[name]]
            for i, k in np.ndindex(one.mean.shape):
                about = (labels[i], None) if ABOUT[name] == "energy" else (None, labels[i])
                if not np.isnan(one.mean[i, k]):  # the activation temperature without a barrier
                    key = (point.name, name, *about, run.scene.speeds[k])
                    expected[key] = one.mean[i, k], one.total_error[i, k]
    assert found.keys() == expected.keys()
    for key, both in expected.items():
        np.testing.assert_array_equal(found[key], both)


def test_a_rate_without_a_barrier_is_the_prefactor_times_the_area_at_each_point(asked):
    for point, run in asked.results:
        area = run.estimate("contact_fraction").mean[0]
        rows = [
            row
            for row in asked.rows("reaction_rate")
            if row["point"] == point.name and row["energy"] == 0.0
        ]
        measured = [row["value"] for row in rows if row["column"] == "capped"]
        np.testing.assert_allclose(measured, [1e13 * area] * 2, rtol=1e-9)


def test_files_have_energy_and_temperature_beside_the_values(asked, tmp_path):
    (point, run), _ = asked.results
    rate = run.reactions()["reaction_rate"].sel(energy=1.0)
    hot = run.reactions()["heat_share_above"].sel(temperature=560.0)
    with asked.save(tmp_path / "t.csv").open() as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if row["point"] == point.name and row["column"] == "capped"
        ]
    values = [
        float(row["value"])
        for row in rows
        if row["observable"] == "reaction_rate" and row["energy"] == "1.0"
    ]
    assert values == list(rate.mean)
    values = [float(row["value"]) for row in rows if row["temperature"] == "560.0"]
    assert values == list(hot.mean)
    assert {row["energy"] for row in rows if row["observable"] == "flash_temperature"} == {""}
    stored = json.loads(asked.save(tmp_path / "t.json").read_text())["rows"]
    values = [
        row["value"]
        for row in stored
        if row.get("temperature") == 560.0 and row["column"] == "capped"
    ]
    assert values[:2] == list(hot.mean)
    with h5py.File(asked.save(tmp_path / "t.h5")) as file:
        place = [name.decode() for name in file["column"][()]].index("capped")
        assert list(file["energy"]) == ENERGIES
        assert list(file["temperature"]) == [520.0, 560.0]
        names = [file["reaction_rate"].dims[k][0].name for k in range(4)]
        assert names == ["/column", "/nominal_pressure", "/energy", "/speed"]
        assert list(file["reaction_rate"][place, 0, 1]) == list(rate.mean)
        assert list(file["heat_share_above"][place, 0, 1]) == list(hot.mean)
        assert file["reaction_rate"].attrs["units"] == "1/s"


def test_a_table_of_a_run_has_the_same_rows(asked, tmp_path):
    (point, run), _ = asked.results
    rs.export(run, tmp_path / "t.csv")
    with (tmp_path / "t.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["observable"] in ABOUT]
    of_study = [
        row for row in asked.rows() if row["point"] == point.name and row["observable"] in ABOUT
    ]
    assert [float(row["value"]) for row in rows] == [row["value"] for row in of_study]


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_tables_have_a_row_for_each_point_at_each_energy(asked):
    table = asked_table(asked)
    heads = [(row[0], row[1]) for row in table.rows]
    expected = [
        "reaction_rate, 0 eV, 1/s",
        "reaction_rate, 1 eV, 1/s",
        "activation_temperature, 1 eV, K",
    ]
    expected += ["heat_share_above, 520 K", "heat_share_above, 560 K"]
    assert heads == [(name, load) for name in expected for load in ("50", "100")]
    (_, first), (_, second) = asked.results
    warm = [run.reactions()["activation_temperature"].sel(energy=1.0) for run in (first, second)]
    assert [row[-1].value for row in table.rows[4:6]] == [
        estimate.mean[1] for estimate in warm
    ]  # the highest speed
    both = table_text(rs.compare(asked).table(None))
    for name in expected:
        assert name.replace("above,", "above") in both
    shown = page(asked)
    assert "activation_temperature, 1 eV, K" in shown
    assert "Rate of reaction" in shown


@pytest.mark.slow
def test_a_chart_has_a_curve_for_each_energy_or_the_energy_along_its_axis(asked, tmp_path):
    usual = usual_choice(asked, "reaction_rate")
    assert (usual.x, usual.family) == ("nominal_pressure", "energy")
    curves = curves_of(asked, usual).values()
    assert [one.known("energy").tolist() for one in curves] == [[energy] for energy in ENERGIES]
    assert all(one.known("speed").tolist() == [10.0] for one in curves)
    over_speed = usual_choice(asked, "reaction_rate", SPEED)
    assert (over_speed.x, over_speed.family) == (SPEED, "nominal_pressure")
    curves = curves_of(asked, over_speed).values()
    assert all(one.known("energy").tolist() == [0.0] for one in curves)  # one energy, the first
    assert usual_choice(asked, "heat_share_above").family == "temperature"
    assert usual_choice(asked, "flash_temperature").family == SPEED
    with pytest.raises(ValueError, match="over = 'energy' is no axis of"):
        usual_choice(asked, "flash_temperature", "energy")
    drawn = {"reaction_rate": None, "heat_share_above": None, "activation_temperature": "energy"}
    for name, over in drawn.items():
        path = rs.plot(asked, name, tmp_path / f"{name}.svg", over=over)
        assert (
            "energy (eV)" if name != "heat_share_above" else "temperature (K)"
        ) in path.read_text()


@pytest.mark.slow
def test_a_study_that_does_not_ask_has_none_of_it(asked, tmp_path):
    sliding = replace(asked.scene.sliding, background_temperature=None)
    quiet = replace(asked.scene, reaction=None, observables=None, sliding=sliding)
    study = rs.study(quiet, vary={"sliding.nominal_pressure": [1e8]}, folder=tmp_path / "quiet")
    assert asked_table(study) is None
    assert not {"energy", "temperature"} & {key for row in study.rows() for key in row}
    assert "Rate of reaction" not in page(study)


def test_without_a_barrier_there_is_no_activation_temperature_to_draw(tmp_path):
    asks = ASKS | {"reaction.activation_energy": ["0 eV"], "ensemble.max_realizations": 2}
    vary = {"sliding.nominal_pressure": [1e8]}
    study = rs.study(rs.load_scene("steel-1.2GPa", asks), vary=vary, folder=tmp_path / "study")
    with pytest.raises(ValueError, match="nothing to draw: no point has activation_temperature"):
        rs.plot(study, "activation_temperature", tmp_path / "a.svg")
