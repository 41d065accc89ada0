"""The distribution of the temperature of a run: stored, estimated and compared where the scene asks, else not."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from damage_cases import forged
from stored_cases import member_path, read_member, split_members, write_member
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.charts.plot import plot_run
from roughsim.charts.style import Look
from roughsim.cli import app
from roughsim.errors import RecordError
from roughsim.observables.catalogue import observables_of, pooled
from roughsim.observables.distribution import BIN_AREAS, LEVELS
from roughsim.results.export import export_run
from roughsim.results.simulated import Single
from roughsim.show.table import table_text
from roughsim.store.member_files import BINS
from roughsim.store.parts import read_part

pytestmark = pytest.mark.usefixtures("few_fields")
ASKS = {
    "sliding.background_temperature": 500.0,
    "surface.q_roll_off": 3e4,
    "surface.q_max": 8e4,
    "sliding.speed": [0.0, 10.0],
    "sliding.heat_partition": 0.5,
    "observables.heat_above": [560.0],
    "reaction.activation_energy": ["0 eV", "1 eV"],
    "reaction.prefactor": 1e13,
    "reaction.contact_length": 1e-3,
    "ensemble.until": {},
    "numerics.lengths": [2e-3, 2e-3],
    "numerics.levels": [
        {"column": "capped", "shape": [48, 48], "q_max": 4e4},
        {"column": "capped", "shape": [96, 96], "q_max": 8e4},
    ],
}
NAMES = [f"temperature_quantile_{of}{name}" for of in ("", "area_") for name in LEVELS]


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    scene = rs.load_scene("steel-1.2GPa", ASKS)
    return rs.run(scene, tmp_path_factory.mktemp("asked") / "run", max_realizations=5)


def test_members_store_quantiles_and_bins_of_both_levels(asked):
    member = read_member(asked.folder, 1, 0)
    for moments in member.moments:
        assert {*NAMES} < {*moments.numbers}
        assert moments.bins.temperature.shape == (2, BIN_AREAS.size)
        heat = (
            BIN_AREAS * moments.bins.pressure
        )  # T_flash is the mean weighted by the heat, up to the width of bins
        flash = (heat * moments.bins.temperature).sum(axis=1) / heat.sum(axis=1)
        np.testing.assert_allclose(flash, moments.numbers["flash_temperature"], rtol=0.02)
        # heat is set free where the pressure is high and hot
        assert np.all(
            moments.numbers["temperature_quantile_area_50"]
            < moments.numbers["temperature_quantile_50"]
        )
    with h5py.File(asked.folder / "members.h5", "r") as whole:
        file = whole["L1"]
        assert file["bin_temperature"].dims[3].keys() == ["contact_area"]
        np.testing.assert_array_equal(file["contact_area"], BIN_AREAS)
        assert [file[name].attrs["units"] for name in BINS] == ["K", "Pa", "Pa", "1"]


def test_a_scene_that_does_not_ask_stores_and_estimates_nothing_of_it(tmp_path, asked):
    quiet = {
        key: value
        for key, value in ASKS.items()
        if key.split(".")[0] not in ("reaction", "observables")
    }
    del quiet["sliding.background_temperature"]
    run = rs.run(rs.load_scene("steel-1.2GPa", quiet), tmp_path / "run", max_realizations=2)
    member, loud = (read_member(one.folder, 1, 0) for one in (run, asked))
    assert member.moments[0].bins is None
    assert not {*NAMES} & {*member.numbers}
    assert {*loud.numbers} == {*member.numbers} | {*NAMES}
    np.testing.assert_array_equal(
        member.numbers["flash_temperature"], loud.numbers["flash_temperature"]
    )
    assert {*run.estimates()} == {*observables_of()} == {*asked.estimates()} - {*NAMES}
    with pytest.raises(
        ValueError, match=r"is not in this run, whose scene lacks \[observables\] temp"
    ):
        run.estimate("temperature_quantile_99")
    assert run.reactions() == {}


def test_quantiles_ascend_and_bracket_the_flash_temperature(asked):
    for of in ("", "area_"):
        means = np.array(
            [asked.estimate(f"temperature_quantile_{of}{name}").mean for name in LEVELS]
        )
        assert np.all(means[:, 0] == 0.0)
        assert np.all(np.diff(means[:, 1]) > 0.0)
    flash = asked.estimate("flash_temperature")
    quantile = asked.estimate("temperature_quantile_50")
    assert quantile.mean[1] == pytest.approx(flash.mean[1], rel=0.1)
    assert quantile.unit == "K"
    assert quantile.total_error[1] > 0.0
    assert {*quantile.budget} >= {"statistical", "bandwidth", "pixel", "size", "solver"}


def test_the_scatter_of_a_quantile_is_unknown_where_too_few_contacts_are_hotter(asked):
    sample = asked.samples()[0]
    known = {name: bool(pooled(sample, name).known[1]) for name in NAMES}
    for name in NAMES:
        unknown = ["statistical" in asked.estimate(name).unknown_at(k) for k in (0, 1)]
        assert unknown == [False, not known[name]]
    assert known["temperature_quantile_50"]
    assert not known["temperature_quantile_area_999"]  # of five contacts


def test_rows_of_a_reaction_have_their_energy_in_ev(asked):
    table = rs.compare(asked)
    rows = json.loads(json.dumps(table.to_dict()))["rows"]
    about = [(row["observable"], row["energy"], row["speed"]) for row in rows if "energy" in row]
    of_reaction = ("reaction_rate", "activation_temperature", "conversion")
    assert about == [
        (name, energy, speed) for name in of_reaction for energy in (0.0, 1.0) for speed in (0, 10)
    ]
    (still, moving) = [row for row in rows if row["observable"] == "heat_share_above"]
    assert still["temperature"] == moving["temperature"] == 560.0
    assert still["capped"]["mean"] == 0.0
    assert 0.0 < moving["capped"]["mean"] < 1.0
    # without --all, too: all that the scene asks for, by the law and by contact
    short = table.asked()
    assert [c.title for c in short.columns] == ["observable", "calibrated", "capped"]
    assert {row[0].partition(",")[0] for row in short.rows} >= {
        *of_reaction,
        "heat_share_above 560 K",
    }
    assert str(short) in str(table)
    whole = table_text(table.table())
    assert "reaction_rate, 1 eV, 1/s" in whole
    assert "heat_share_above 560 K" in whole


def test_first_screen_of_a_comparison_is_short(asked, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = CliRunner().invoke(app, ["compare", str(asked.folder)]).stdout.splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    (left,) = re.findall(r"--all prints (\d+) more rows, ", lines[-1])
    rows = [row[0] for row in rs.compare(asked).asked().rows]
    shown = rows[: len(rows) - int(left)]
    assert 0 < len(shown) < len(rows)
    assert lines[-1 - len(shown)].split("  ")[0] == shown[0]
    assert lines[-2].split("  ")[0] == shown[-1]


def found(run, name, energy):
    return run.reactions()[name].sel(energy=energy)


def test_without_a_barrier_the_rate_is_that_of_the_contact_area(asked):
    area = asked.estimate("contact_fraction")
    rate = found(asked, "reaction_rate", 0.0)
    np.testing.assert_allclose(rate.mean, 1e13 * area.mean[0], rtol=1e-9)
    np.testing.assert_allclose(rate.standard_error, 1e13 * area.standard_error[0], rtol=1e-6)


def test_at_rest_the_contact_reacts_at_the_background_temperature(asked):
    warm, rate = found(asked, "activation_temperature", 1.0), found(asked, "reaction_rate", 1.0)
    assert warm.mean[0] == pytest.approx(500.0, rel=1e-9)
    area = asked.estimate("contact_fraction").mean[0]
    arrhenius = 1e13 * np.exp(-1.602176634e-19 / (1.380649e-23 * warm.mean))  # the definition
    assert rate.mean[0] / area == pytest.approx(arrhenius[0], rel=1e-6)
    assert rate.mean[1] / area == pytest.approx(arrhenius[1], rel=0.05)  # of levels by their ratios
    # Jensen: the rate exceeds that at the mean temperature, so its temperature exceeds T₀ + s T_flash
    assert warm.mean[1] > 500.0 + asked.estimate("flash_temperature").mean[1]
    assert (
        warm.mean[1] < 500.0 + asked.estimate("temperature_quantile_90").mean[1]
    )  # with half of the heat
    assert warm.unit == "K"
    # errors of the rate and of its temperature belong together: dT = k T² d ln rate / E
    slope = 1.380649e-23 * warm.mean[1] ** 2 / 1.602176634e-19
    assert warm.standard_error[1] == pytest.approx(
        slope * rate.standard_error[1] / rate.mean[1], rel=0.5
    )


def test_errors_of_solver_and_cell_count_by_what_a_change_of_all_temperatures_does_to_a_rate(asked):
    warm, rate = (
        found(asked, "activation_temperature", 1.0).mean[1],
        found(asked, "reaction_rate", 1.0),
    )
    by_temperatures = (
        1.602176634e-19 * (warm - 500.0) / (1.380649e-23 * warm**2)
    )  # d ln k/d ln(T − T₀)
    flash, area = asked.estimate("flash_temperature"), asked.estimate("contact_fraction")
    of_flash = {
        "solver": 2.0 * asked.numerics.tolerance,
        "size": flash.budget["size"][1] / flash.mean[1],
    }
    without = found(asked, "reaction_rate", 0.0)  # the rate is in proportion to the area
    for part, relative in of_flash.items():
        of_area = area.budget[part][0] / area.mean[0]
        assert rate.budget[part][1] / rate.mean[1] - of_area == pytest.approx(
            by_temperatures * relative, rel=0.3
        )
        np.testing.assert_allclose(without.budget[part], of_area * without.mean, rtol=1e-9)


def test_the_conversion_in_a_pass_follows_from_the_rate(asked):
    rate, conversion = found(asked, "reaction_rate", 1.0), found(asked, "conversion", 1.0)
    assert conversion.mean[0] == 1.0  # a pass at rest never ends
    assert conversion.mean[1] == pytest.approx(-np.expm1(-rate.mean[1] * 1e-3 / 10.0), rel=1e-9)
    left = 1.0 - conversion.mean[1]
    assert conversion.standard_error[1] == pytest.approx(
        rate.standard_error[1] * 1e-4 * left, rel=1e-6
    )


def test_a_mean_that_one_member_carries_has_an_unknown_scatter(asked):
    steep = rs.open_run(asked.folder)
    steep.scene = steep.scene.with_("reaction.activation_energy", ["1 eV", "20 eV"])
    easy, hard = (found(steep, "reaction_rate", energy) for energy in (1.0, 20.0))
    assert "statistical" not in easy.unknown_at(1)
    assert "statistical" in hard.unknown_at(1)
    assert hard.mean[1] > 0.0


def test_the_background_is_absolute_and_warms_with_the_share_of_the_heat():
    changes = {
        "sliding.background_temperature": 400.0,
        "sliding.speed": [2.0, 5.0],
        "sliding.duration": 1e-3,
    }
    scene = rs.load_scene("steel-1.2GPa", changes | {"observables.heat_above": [600.0]})
    # 2q̇√(t/(πκρc)) of a uniform flux q̇ = μσ₀v
    warming = (
        2.0 * 0.11 * 90e6 * np.array([2.0, 5.0]) * np.sqrt(1e-3 / (np.pi * 30.0 * 7900.0 * 500.0))
    )
    for share in (1.0, 0.25):
        column = SimpleNamespace(scene=scene, share=np.full(2, share))
        warm = Single.background.fget(column)
        np.testing.assert_allclose(warm, 400.0 + share * warming, rtol=1e-12)


def test_the_theory_of_a_reaction_is_in_the_column_calibrated(asked):
    rows = rs.compare(asked).rows
    of_theory = {
        (row.observable, row.about.get("energy"), row.speed): row.calibrated for row in rows
    }
    for name in NAMES:
        assert of_theory[name, None, 0.0] == 0.0
    flash = of_theory["flash_temperature", None, 10.0]
    assert of_theory["temperature_quantile_50", None, 10.0] == pytest.approx(flash, rel=0.15)
    assert of_theory["temperature_quantile_99", None, 10.0] > 1.5 * flash
    law = prediction.calibrated(asked.scene).stress_spectrum
    assert of_theory["reaction_rate", 0.0, 10.0] == pytest.approx(
        1e13 * law.contact_fraction, rel=1e-9
    )
    assert of_theory["activation_temperature", 1.0, 0.0] == pytest.approx(500.0, rel=1e-9)
    hottest = of_theory["temperature_quantile_90", None, 10.0]  # with half of the heat, as T_flash
    assert 500.0 + flash < of_theory["activation_temperature", 1.0, 10.0] < 500.0 + hottest
    rate = of_theory["reaction_rate", 1.0, 10.0]
    assert of_theory["conversion", 1.0, 10.0] == pytest.approx(-np.expm1(-rate * 1e-4), rel=1e-9)
    assert np.isnan(of_theory["activation_temperature", 0.0, 10.0])


def test_an_export_has_the_rates_over_column_energy_and_speed(asked, tmp_path):
    with h5py.File(export_run(asked, tmp_path / "run.h5"), "r") as whole:
        file = whole["results"]
        columns = [name.decode() for name in file["column"]]
        np.testing.assert_allclose(file["energy"], [0.0, 1.0])
        np.testing.assert_allclose(file["temperature"], [560.0])
        rate = file["reaction_rate"]
        assert rate.attrs["units"] == "1/s"
        assert [axis.keys()[0] for axis in rate.dims] == ["column", "energy", "speed"]
        estimate = found(asked, "reaction_rate", 1.0)
        np.testing.assert_allclose(rate[columns.index("capped"), 1], estimate.mean)
        np.testing.assert_allclose(
            file["reaction_rate_total_error"][columns.index("capped"), 1], estimate.total_error
        )
        assert np.isfinite(rate[columns.index("calibrated")]).all()
        assert np.isnan(rate[columns.index("theory")]).all()
        assert file["heat_share_above"].shape == (len(columns), 1, 2)
        assert file["temperature_quantile_99"].shape == (len(columns), 2)


@pytest.mark.slow
def test_the_picture_has_the_numbers_of_the_run(asked, tmp_path):
    numbers = tmp_path / "numbers.csv"
    plot_run(asked, "reaction", tmp_path / "reaction.svg", look=Look(csv=numbers))
    values = [
        float(word)
        for word in re.split(r"[,\n]", numbers.read_text())
        if re.fullmatch(r"-?[0-9.]+(e[-+]?\d+)?", word)
    ]
    for name in ("temperature_quantile_99", "temperature_quantile_area_50"):
        assert min(abs(np.array(values) / asked.estimate(name).mean[1] - 1.0)) < 1e-4
    assert (
        min(abs(np.array(values) / found(asked, "activation_temperature", 1.0).mean[1] - 1.0))
        < 1e-4
    )
    assert min(abs(np.array(values) / found(asked, "reaction_rate", 1.0).mean[1] - 1.0)) < 1e-4
    with pytest.raises(ValueError, match="leave it out"):
        plot_run(asked, "reaction", tmp_path / "reaction.svg", speed=10.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "reaction_rate",
        "activation_temperature",
        "conversion",
        "heat_share_above",
    ],
)
def test_each_row_that_is_asked_is_drawn_over_the_speed_with_its_errors(asked, tmp_path, name):
    numbers = tmp_path / "numbers.csv"
    rs.plot(asked, name, tmp_path / "one.svg", csv=numbers)
    drawn = [line.rsplit(",", 3) for line in numbers.read_text().splitlines()[1:]]
    measured = [(float(value), float(error)) for _, speed, value, error in drawn if error]
    assert {float(speed) for _, speed, _, _ in drawn} == {10.0}  # not at rest
    estimate = asked.reactions()[name].sel(speed=10.0)
    both = zip(estimate.mean, estimate.total_error, strict=True)
    expected = [(mean, error) for mean, error in both if np.isfinite(mean)]
    np.testing.assert_allclose(measured, expected, rtol=1e-5)
    theory = [float(value) for _, _, value, error in drawn if not error and value]
    rows = [row for row in rs.compare(asked).rows if row.observable == name and row.speed == 10.0]
    calibrated = [row.calibrated for row in rows if np.isfinite(row.calibrated)]
    assert len(calibrated) == len(expected)
    np.testing.assert_allclose(theory, calibrated, rtol=1e-5)


def test_a_rate_that_the_scene_does_not_ask_for_is_not_drawn(asked):
    quiet = rs.open_run(asked.folder)
    quiet.scene = replace(quiet.scene, reaction=None)
    words = r"has no reaction_rate: .* add \[reaction\] with activation_energy and prefactor and run it again"
    with pytest.raises(ValueError, match=words):
        rs.plot(quiet, "reaction_rate", "one.svg")


def test_bins_of_another_size_are_damage(tmp_path, asked):
    path = Path(shutil.copy(asked.folder / "members.h5", tmp_path))
    with forged(path) as file:
        bins = file["L0/bin_pressure"][..., :7]
        del file["L0/bin_pressure"]
        file["L0"].create_dataset("bin_pressure", data=bins, chunks=bins.shape)
    with pytest.raises(RecordError, match="is damaged"):
        read_part(path)


@pytest.fixture(scope="module")
def unlike(asked, tmp_path_factory):
    """A run in which T_flash of the field of one member, at the second speed, is another one than in all directions."""
    folder = shutil.copytree(asked.folder, tmp_path_factory.mktemp("unlike") / "run")
    member = read_member(folder, 0, 2)
    (own,) = member.moments
    numbers = {name: values.copy() for name, values in own.numbers.items()}
    for name in NAMES:
        numbers[name][1] = np.nan
    temperature = own.bins.temperature.copy()
    temperature[1] = np.nan
    moments = own._replace(numbers=numbers, bins=own.bins._replace(temperature=temperature))
    member_path(split_members(folder), 0, 2).unlink()
    write_member(folder, replace(member, moments=(moments,)))
    return rs.open_run(folder)


def test_what_one_field_does_not_show_is_unknown(unlike, asked):
    for name in NAMES:
        estimate = unlike.estimate(name)
        assert np.isfinite(estimate.mean[0])
        assert np.isnan(estimate.mean[1])
        assert (
            "unknown where T_flash of the field of one direction lies too far from the mean"
            in estimate.explain()
        )
        assert "unknown where" not in asked.estimate(name).explain()
    for name, estimate in unlike.reactions().items():
        barred = estimate.sel(energy=[1.0])
        assert np.isnan(barred.mean[:, 1]).all(), name
        assert np.isfinite(barred.mean[:, 0]).all(), name
    rows = [row for row in rs.compare(unlike).rows if row.observable == "temperature_quantile_99"]
    assert [np.isnan(row.columns["capped"].mean) for row in rows] == [False, True]
    assert (
        unlike.estimate("flash_temperature").mean[1] == asked.estimate("flash_temperature").mean[1]
    )
