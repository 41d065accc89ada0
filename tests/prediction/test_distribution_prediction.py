"""The theory of the temperature distribution for a scene: the column calibrated beside quantiles and reactions."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison.tables import theory_dict, theory_table
from roughsim.observables.distribution import LEVELS
from roughsim.results.answers import answers
from theory import clipped

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
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30 / (7900 * 500)}
MODULUS = 1.0 / (2 * 0.91 / 200e9)


@pytest.fixture(scope="module")
def scene():
    return rs.load_scene("steel-1.2GPa", ASKS)


@pytest.fixture(scope="module")
def fields(scene):
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 90e6, "penetration_hardness": 1.2e9}
    return clipped.temperature_distribution([0.0, 1.0, 35.0], scene.spectrum, **solid, **HEAT)


def test_quantiles_are_those_of_the_drawn_fields(scene, fields):
    law = prediction.calibrated_predictions(scene)
    for weight, of in (("heat", ""), ("area", "area_")):
        expected = fields.quantiles([*LEVELS.values()], by=weight).value
        for k, name in enumerate(LEVELS):
            assert law[f"temperature_quantile_{of}{name}"] == pytest.approx(
                expected[k], rel=1e-9, abs=1e-9
            )


def test_reactions_have_the_share_and_the_background_of_the_scene(scene, fields):
    share = np.array([0.5, 0.6, 0.7])
    asked = {each.key: each.estimate.value for each in prediction.asked_predictions(scene, share)}
    conditions = {
        "background_temperature": 500.0,
        "heat_partition": share,
        "activation_volume": 4e-30,
    }
    rate = fields.reaction_rate([0.0, EV], prefactor=1e13, **conditions).value
    for k, energy in enumerate((0.0, 1.0)):
        assert asked["reaction_rate", energy, None] == pytest.approx(rate[k], rel=1e-9)
    kelvin = fields.activation_temperature([EV], **conditions).value[0]
    assert asked["activation_temperature", 1.0, None] == pytest.approx(kelvin, rel=1e-9)
    # 1 cm pass by in 10 ms at 1 m/s, and never at rest
    assert asked["conversion", 1.0, None][1:] == pytest.approx(
        -np.expm1(-rate[1, 1:] * 0.01 / np.array([1, 35]))
    )
    assert asked["conversion", 1.0, None][0] == 1.0
    done = {each.key: each.estimate for each in prediction.asked_predictions(scene, share)}[
        "conversion", 1.0, None
    ]
    error = fields.reaction_rate([EV], prefactor=1e13, **conditions).standard_error[0]
    time = np.array([0.01, 0.01 / 35])
    assert done.standard_error == pytest.approx(
        [0.0, *(np.exp(-rate[1, 1:] * time) * time * error[1:])], rel=1e-6
    )
    above = fields.share_above(200.0 / share).value
    assert asked["heat_share_above", None, 700.0] == pytest.approx(above, abs=1e-12)
    assert 0.2 < above[2] < 0.4
    assert above[0] == 0.0
    assert len(asked) == 7


def test_errors_are_by_drawing_form_and_law(scene, fields):
    share = np.array([0.5, 0.6, 0.7])
    given = {"background_temperature": 500.0, "heat_partition": share, "activation_volume": 4e-30}
    varied = [*fields.doubted(), replace(fields, flash_temperature=1.07 * fields.flash_temperature)]

    def of_quantile(one):
        return one.quantiles([0.99])

    def of_rate(one):
        return one.reaction_rate([EV], prefactor=1e13, **given)

    asked = {each.key: each.estimate for each in prediction.asked_predictions(scene, share)}
    hot = prediction.quantile_predictions(scene)["temperature_quantile_99"]
    rate = asked["reaction_rate", 1.0, None]
    for found, of, law in (
        (hot, of_quantile, 0.0),
        (rate, of_rate, 0.13),
    ):  # a rate is in proportion to the area
        plain = of(fields)
        parts = [1.96 * plain.standard_error[0], law * plain.value[0]]
        parts += [of(one).value[0] - plain.value[0] for one in varied]
        assert found.error == pytest.approx(np.linalg.norm(parts, axis=0), rel=1e-6)
    assert (hot.error[1:] > 0.07 * hot.value[1:]).all()
    kelvin = asked["activation_temperature", 1.0, None]
    assert (kelvin.error[1:] > 10.0 * kelvin.standard_error[1:]).all()


def test_after_a_duration_the_contact_has_warmed():
    changes = {key: value for key, value in ASKS.items() if key != "observables.heat_above"}
    scene = rs.load_scene(
        "steel-1.2GPa", changes | {"sliding.duration": "10 us", "sliding.speed": 35.0}
    )
    share = np.array([0.5])
    warm = {each.key: each.estimate.value for each in prediction.asked_predictions(scene, share)}
    rise = 0.5 * 2 * 0.11 * 90e6 * 35.0 / 30.0 * np.sqrt(HEAT["diffusivity"] * 1e-5 / np.pi)
    ((_, drawn),) = prediction.distribution.temperature_distributions(scene)
    given = {
        "background_temperature": 500.0 + rise,
        "heat_partition": 0.5,
        "activation_volume": 4e-30,
    }
    rate = drawn.reaction_rate([EV], prefactor=1e13, **given).value[0]
    assert warm["reaction_rate", 1.0, None] == pytest.approx(rate, rel=1e-6)


def test_json_and_table_have_what_the_scene_asks_for(scene):
    found = theory_dict(scene)["calibrated"]
    quantile = prediction.quantile_predictions(scene)["temperature_quantile_99"]
    assert found["temperature_quantile_99"]["value"] == pytest.approx(
        (0.5 * quantile.value).tolist()
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
    assert table.rows[2][place].value == pytest.approx(0.5 * quantile.value[2])
    assert table.rows[2][place].error == pytest.approx(0.5 * quantile.error[2])
    assert found["temperature_quantile_99"]["error"] == pytest.approx(
        (0.5 * quantile.error).tolist()
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
        (row.observable, row.speed, row.energy, row.temperature): row
        for row in rs.compare(run).rows
    }
    quantiles = prediction.quantile_predictions(run.scene)
    for name, estimate in quantiles.items():
        for k, speed in enumerate(run.scene.speeds):
            assert rows[name, speed, None, None].calibrated == pytest.approx(
                0.5 * estimate.value[k], rel=1e-12
            )
    for asked in prediction.asked_predictions(run.scene, np.full(3, 0.5)):
        for k, speed in enumerate(run.scene.speeds):
            row = rows[asked.observable, speed, asked.energy, asked.temperature]
            assert row.calibrated == pytest.approx(
                float(asked.estimate.value[k]), rel=1e-12, nan_ok=True
            )
    written = {
        one.name: one.data for one in answers(run, ["temperature_quantile_99", "reaction_rate"])
    }
    error = written["temperature_quantile_99_total_error"][1]
    assert error == pytest.approx(0.5 * quantiles["temperature_quantile_99"].error)
    rates = [one.estimate.error for one in prediction.asked_predictions(run.scene, np.full(3, 0.5))]
    assert written["reaction_rate_total_error"][1, 0] == pytest.approx(rates[0], rel=1e-9)
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
    assert prediction.quantile_predictions(scene) == {}
    assert prediction.asked_predictions(scene, np.ones(len(scene.speeds))) == []
    assert np.isnan(prediction.calibrated_predictions(scene)["temperature_quantile_50"]).all()
    assert "temperature_quantile_50" not in theory_dict(scene)["calibrated"]
