"""The theory of the temperature distribution for a scene: the column calibrated beside quantiles and reactions."""

import json

import numpy as np
import pytest
from table_cases import by_label
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.charts.curves import theories
from roughsim.cli import app
from roughsim.comparison.tables import theory_dict, theory_table
from roughsim.estimate import fields
from roughsim.estimate.reactions import BOLTZMANN
from roughsim.observables.distribution import LEVELS
from roughsim.results.columns import results_of
from roughsim.results.theories import theory_columns

ASKS = {
    "sliding.background_temperature": 500.0,
    "sliding.speed": [0.0, 1.0, 35.0],
    "sliding.heat_partition": 0.5,
    "observables.heat_above": [700.0],
    "reaction.activation_energy": ["0 eV", "1 eV"],
    "reaction.activation_volume": "4 angstrom^3",
    "reaction.prefactor": "1e13 1/s",
    "reaction.contact_length": "1 cm",
}
EV = 1.602176634e-19
SLOW_TO_FAST = np.array([0.0, 1.0, 35.0])
DIFFUSIVITY = 30 / (7900 * 500)


@pytest.fixture(scope="module")
def scene():
    return rs.load_scene("steel-1.2GPa", ASKS)


def by_law(scene):
    quantiles = {name: one.mean for name, one in fields.quantiles(scene).items()}
    return {**prediction.calibrated_predictions(scene)} | quantiles


def asked(scene):
    return by_label(fields.asked(scene))


def test_quantiles_are_those_of_the_drawn_contacts_at_the_flash_temperature_of_the_law(scene):
    drawn = prediction.frozen_fields(scene)
    law = by_law(scene)
    fine = drawn.samples[-1].numbers
    for name in (f"temperature_quantile_{of}{level}" for of in ("", "area_") for level in LEVELS):
        ratio = fine[name].mean(axis=0) / fine["flash_temperature"].mean(axis=0)
        change = law[name][1:] / (law["flash_temperature"] * ratio)[1:] - 1.0
        # continued to waves that are not drawn: the hottest and the coldest move away from T_flash
        assert (np.abs(change) < (0.2 if name.endswith(("25", "50", "75", "90")) else 1.0)).all()
        assert law[name][0] == 0.0
    hottest = law["temperature_quantile_99"][1:] / law["flash_temperature"][1:]
    assert (hottest > 2.4).all()


def test_the_curve_of_a_quantile_has_the_column_calibrated(scene):
    speed, values = theories(scene, "temperature_quantile_99")["calibrated"]
    expected = 0.5 * fields.quantiles(scene)["temperature_quantile_99"].mean[1:]
    assert speed.tolist() == [1.0, 35.0]
    assert values == pytest.approx(expected, rel=1e-12)


def test_reactions_have_the_share_and_the_background_of_the_scene(scene):
    law, found = by_law(scene), asked(scene)
    kelvin = found["activation_temperature", 1.0, None].mean
    # half of the heat: hotter than T₀ + T_flash, as the hottest react
    at_flash = 500.0 + 0.5 * law["flash_temperature"]
    assert kelvin[0] == pytest.approx(500.0, abs=1e-6)
    assert (kelvin[1:] > at_flash[1:]).all()
    assert (kelvin < 500.0 + 0.5 * law["temperature_quantile_999"] + 1.0).all()
    area = prediction.calibrated(scene).stress_spectrum.contact_fraction
    lowered = EV - 4e-30 * 1.2e9  # all has yielded
    rate = area * 1e13 * np.exp(-lowered / (BOLTZMANN * kelvin))
    assert found["reaction_rate", 1.0, None].mean == pytest.approx(rate, rel=0.05)
    # 1 cm passes by in 10 ms at 1 m/s, and never at rest
    rate = found["reaction_rate", 1.0, None]
    done = found["conversion", 1.0, None]
    time = 0.01 / SLOW_TO_FAST[1:]
    assert done.mean[1:] == pytest.approx(-np.expm1(-rate.mean[1:] * time))
    assert done.mean[0] == 1.0
    slope = np.exp(-rate.mean[1:] * time) * time
    assert done.standard_error == pytest.approx([0.0, *(slope * rate.standard_error[1:])], rel=1e-6)
    above = found["heat_share_above", None, 700.0].mean
    # half of T is above 200 K: the share between the levels of the quantiles around 400 K
    levels = np.array([*LEVELS.values()])
    heat = [law[f"temperature_quantile_{name}"][2] for name in LEVELS]
    assert above[2] == pytest.approx(1.0 - np.interp(400.0, heat, levels), abs=0.02)
    assert above[0] == 0.0
    assert len(found) == 7


def test_errors_are_by_drawing_form_law_and_cut_off(scene):
    hot = fields.quantiles(scene)["temperature_quantile_99"]
    assert set(hot.budget) == {"statistical", "bandwidth", "form", "law"}
    assert hot.budget["law"] == pytest.approx(0.07 * hot.mean)
    assert (hot.total_error[1:] > 0.07 * hot.mean[1:]).all()
    assert (hot.budget["form"][1:] > 0.05 * hot.mean[1:]).all()
    rate, kelvin = (
        asked(scene)[name, 1.0, None] for name in ("reaction_rate", "activation_temperature")
    )
    assert set(rate.budget) == {"statistical", "bandwidth", "form", "law", "tail"}
    # a rate is in proportion to the area, which is known to 10 %, also at rest
    assert rate.budget["law"][0] == pytest.approx(0.1 * rate.mean[0], rel=1e-6)
    assert (rate.budget["law"][1:] > 0.1 * rate.mean[1:]).all()
    assert (kelvin.total_error[1:] > 5.0 * kelvin.standard_error[1:]).all()
    for estimate in (rate, kelvin, hot):
        assert estimate.unknown == ()


def test_json_and_table_have_what_the_scene_asks_for(scene):
    found = theory_dict(scene)["calibrated"]
    quantile = fields.quantiles(scene)["temperature_quantile_99"]
    assert found["temperature_quantile_99"]["value"] == pytest.approx(
        (0.5 * quantile.mean).tolist()
    )
    assert found["temperature_quantile_99"]["standard_error"] == pytest.approx(
        (0.5 * quantile.standard_error).tolist()
    )
    assert [row["energy"] for row in found["reaction_rate"]] == [0.0, 1.0]
    assert found["heat_share_above"][0]["temperature"] == 700.0
    assert (
        found["activation_temperature"][0]["value"][0] is None
    )  # σV releases what no barrier holds
    table = theory_table(scene)
    place = [column.title for column in table.columns].index("99 % of the heat below, K")
    assert table.rows[2][place].value == pytest.approx(0.5 * quantile.mean[2])
    assert table.rows[2][place].error == pytest.approx(0.5 * quantile.total_error[2])
    assert found["temperature_quantile_99"]["error"] == pytest.approx(
        (0.5 * quantile.total_error).tolist()
    )
    assert {"value", "standard_error", "error"} <= {*found["reaction_rate"][0]}
    words = [
        word for key, value in ASKS.items() for word in ("--set", f"{key}={json.dumps(value)}")
    ]
    done = CliRunner().invoke(app, ["theory", "steel-1.2GPa", "--json", *words])
    assert done.exit_code == 0, done.output
    assert (
        json.loads(done.stdout)["calibrated"]["reaction_rate"][1]["value"]
        == found["reaction_rate"][1]["value"]
    )


@pytest.mark.slow
def test_a_comparison_has_the_theory_beside_its_rows(tmp_path):
    small = {
        "surface.q_roll_off": 3e4,
        "surface.q_max": 8e4,
        "ensemble.until": {},
        "numerics.lengths": [2e-3, 2e-3],
        "numerics.levels": [{"column": "capped", "shape": [48, 48], "q_max": 4e4}],
    }
    run = rs.run(rs.load_scene("steel-1.2GPa", ASKS | small), tmp_path / "run", max_realizations=2)
    rows = {
        (row.observable, row.speed, row.about.get("energy"), row.about.get("temperature")): row
        for row in rs.compare(run).rows
    }
    quantiles = fields.quantiles(run.scene)
    for name, estimate in quantiles.items():
        for k, speed in enumerate(run.scene.speeds):
            assert rows[name, speed, None, None].calibrated == pytest.approx(
                0.5 * estimate.mean[k], rel=1e-12
            )
    known = fields.asked(run.scene)
    for name, estimate in known.items():
        for place in np.ndindex(estimate.mean.shape):
            labels = estimate.labels(place)
            row = rows[name, labels["speed"], labels.get("energy"), labels.get("temperature")]
            assert row.calibrated == pytest.approx(estimate.mean[place], rel=1e-12, nan_ok=True)
    written = results_of(run, ["temperature_quantile_99", "reaction_rate"]).sel(column="calibrated")
    error = written["temperature_quantile_99"].total_error
    assert error == pytest.approx(0.5 * quantiles["temperature_quantile_99"].total_error)
    rate = written["reaction_rate"]
    assert rate.total_error[0] == pytest.approx(known["reaction_rate"].total_error[0], rel=1e-9)
    row = rows["activation_temperature", 35.0, 1.0, None]
    assert row.calibrated == pytest.approx(row.columns["capped"].mean, rel=0.1)


@pytest.mark.parametrize(
    "changes",
    [
        {"observables.heat_above": None},
        {"body.heat_depth": "1 um"},
        {"body.penetration_hardness": "91 MPa", "sliding.nominal_pressure": "90 MPa"},
    ],
    ids=["not asked for", "heated in depth", "outside the law"],
)
def test_without_the_question_or_the_law_there_is_no_distribution(changes):
    asks = (
        {"observables.temperature_distribution": True}
        if "observables.heat_above" not in changes
        else {}
    )
    changes = {key: value for key, value in changes.items() if value is not None}
    scene = rs.load_scene("steel-1.2GPa", asks | changes)
    assert fields.quantiles(scene) == {}
    assert fields.asked(scene) == {}
    assert theory_columns(scene)["calibrated"]("temperature_quantile_50") is None
    assert "temperature_quantile_50" not in theory_dict(scene)["calibrated"]


@pytest.mark.usefixtures("few_fields")  # for all tests that follow
def test_after_a_duration_the_contact_has_warmed():
    changes = {key: value for key, value in ASKS.items() if key != "observables.heat_above"}
    cold = rs.load_scene("steel-1.2GPa", changes | {"sliding.speed": 35.0})
    warm = rs.load_scene(
        "steel-1.2GPa", changes | {"sliding.duration": "10 us", "sliding.speed": 35.0}
    )
    rise = 0.5 * 2 * 0.11 * 90e6 * 35.0 / 30.0 * np.sqrt(DIFFUSIVITY * 1e-5 / np.pi)
    start = rs.load_scene(
        "steel-1.2GPa",
        changes | {"sliding.speed": 35.0, "sliding.background_temperature": 500.0 + rise},
    )
    key = "reaction_rate", 1.0, None
    assert asked(warm)[key].mean == pytest.approx(asked(start)[key].mean, rel=1e-6)
    assert asked(warm)[key].mean > 1.1 * asked(cold)[key].mean
