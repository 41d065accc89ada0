"""Error of the theory by the calibrated law: ratios, bands, refused scenes and speeds, and the printed table."""

import json
from dataclasses import replace

import numpy as np
import pytest
from law_cases import DIFFUSIVITY, MODULUS, scene
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison.tables import trust_table
from roughsim.comparison.trust import Judgement, trust
from theory import flash, persson, plasticity


def judged(scene, observable):
    return {j.speed: j for j in trust(scene).judgements if j.observable == observable}


def test_of_elastic_contact_theory_and_law_are_compared_at_each_speed():
    here = scene()
    pressure = here.sliding.nominal_pressure
    law = persson.calibrated_spectrum(
        here.spectrum, effective_modulus=MODULUS, nominal_pressure=pressure
    )
    heat = {
        "friction_coefficient": 0.1,
        "conductivity": 30.0,
        "diffusivity": DIFFUSIVITY,
        "nominal_pressure": pressure,
    }
    known = judged(here, "flash_temperature")
    assert set(known) == {0.1, 35.0}  # no heat at rest
    for speed, judgement in known.items():
        own = flash.flash_temperature(
            speed, here.spectrum, effective_modulus=MODULUS, gamma=0.45, **heat
        )
        ratio = own / flash.flash_temperature(speed, stress_spectrum=law, **heat)
        assert judgement.percent == pytest.approx(100 * (ratio - 1), rel=1e-9)
        assert judgement.error == pytest.approx(100 * ratio * 0.05, rel=1e-9)
    (variance,) = judged(here, "pressure_variance").values()
    whole = {"effective_modulus": MODULUS, "nominal_pressure": pressure}
    ratio = float(persson.pressure_correlation(0.0, here.spectrum, gamma=0.45, **whole))
    ratio /= float(persson.pressure_correlation(0.0, stress_spectrum=law))
    assert variance.percent == pytest.approx(100 * (ratio - 1), rel=1e-9)


def test_each_observable_has_the_band_that_was_found_for_it(capped_run):
    bands = {
        "flash_temperature": 0.07,
        "pressure_variance": 0.09,
        "contact_fraction": 0.1,
        "plastic_fraction": 0.5,
    }
    known = trust(capped_run.scene)
    assert {j.observable for j in known.judgements} == set(bands)
    for judgement in known.judgements:
        assert judgement.error == pytest.approx(
            (100 + judgement.percent) * bands[judgement.observable], rel=1e-9
        )
    bands = {
        "flash_temperature": 0.05,
        "flash_gradient": 0.07,
        "flash_width": 0.13,
        "slope_length": 0.07,
    }
    bands |= {"pressure_variance": 0.05, "contact_fraction": 0.06}
    assert {
        j.observable: j.error / (100 + j.percent) for j in trust(scene()).judgements
    } == pytest.approx(bands)


def test_the_gamma_of_the_scene_changes_the_theory_and_not_the_law():
    soft, base = scene(gamma=0.3), scene(gamma=0.45)
    (a,), (b,) = (judged(s, "pressure_variance").values() for s in (soft, base))
    change = (
        prediction.predictions(soft)["pressure_variance"][0]
        / prediction.predictions(base)["pressure_variance"][0]
    )
    assert (100 + a.percent) / (100 + b.percent) == pytest.approx(change, rel=1e-9)


# by ensembles up to q_max with up to 16 pixels per shortest wave: theory/measured − 1 in %, T_flash
def test_the_demo_has_the_error_that_its_simulation_shows():
    for judgement, percent in zip(
        judged(rs.load_scene("demo"), "flash_temperature").values(), (167, 78, 54), strict=True
    ):
        assert abs(judgement.percent - percent) <= judgement.error
        assert judgement.error < 20.0


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ({"load": 0.001}, "nominal_pressure/(E*h′) = 0.001 lies outside 0.002 … inf"),
        ({"bandwidth": 200.0}, "q_max/q_roll_off = 200 lies outside 1 … 64"),
        (
            {"hurst": 0.05},
            "Hurst exponent by the slope of C(q) from 2e+04 to 2e+05 rad/m = 0.05 lies outside 0.3 … 1",
        ),
    ],
)
def test_outside_the_range_of_the_law_nothing_is_known_and_the_reason_is_named(place, words):
    known = trust(scene(**place))
    assert (known.source, known.judgements) == ("not known", ())
    assert known.where.startswith(words)
    assert str(trust_table(known).rows[0][0]).startswith(f"not known: {words}")


def test_a_speed_beyond_the_contacts_that_were_compared_is_named():
    # C constant from 1e4 to 3e4 rad/m: ∫ q C dq / ∫ C dq = 2e4 rad/m
    base, unit = scene(), 2e4 * DIFFUSIVITY
    surface = type(base.surface)(psd=((1e4, 1e-26), (3e4, 1e-26)), psd_convention="persson")
    pressure = 2 * 0.05 * MODULUS * replace(base, surface=surface).spectrum.rms_slope
    fast = replace(
        base,
        surface=surface,
        sliding=replace(base.sliding, speed=(0.1 * unit, 3200 * unit), nominal_pressure=pressure),
    )
    tall = replace(
        fast,
        surface=type(base.surface)(psd=((1e4, 1e-26), (3.8e4, 1e-26)), psd_convention="persson"),
    )
    known = trust(tall)
    assert known.source == "calibrated"
    (off,) = known.off
    assert off[0] == 3200 * unit
    assert off[1] == "Péclet number v/(D q_roll_off) 2667 above 1000"  # 3200 · 2e4/2.4e4
    assert {j.speed for j in known.judgements} == {None, 0.1 * unit}
    assert any(
        "m/s: not known, Péclet number v/(D q_roll_off) 2667 above 1000" in note
        for note in trust_table(known).notes
    )
    assert [row["speed"] for row in known.to_dict()["off"]] == [3200 * unit]


def test_two_unlike_faces_have_the_law_of_their_composite_roughness(tmp_path):
    text = rs.scene.scene_text("demo")
    body = (
        text[text.index("[surface]") : text.index("[counterface]")]
        .replace("[surface]", "")
        .replace("[body]", "")
    )
    path = tmp_path / "two.toml"
    path.write_text(text.replace('like = "body"', body.replace("0.90 um", "0.30 um")))
    listed = json.loads(CliRunner().invoke(app, ["theory", str(path), "--trust", "--json"]).stdout)[
        "trust"
    ]
    assert listed["source"] == "calibrated"
    two = rs.load_scene(path)
    solid = {
        "effective_modulus": two.effective_modulus,
        "nominal_pressure": two.sliding.nominal_pressure,
    }
    law = plasticity.stress_spectrum(
        two.spectrum, **solid, penetration_hardness=two.penetration_hardness
    )
    (area,) = (row["percent"] for row in listed["rows"] if row["observable"] == "contact_fraction")
    own = prediction.predictions(two)["contact_fraction"][0]
    assert area == pytest.approx(100 * (own / law.contact_fraction - 1), abs=1e-9)


def test_a_judgement_is_high_or_low_with_its_error():
    assert str(Judgement("flash_temperature", 1.0, 12.4, 2.2)) == "12 ± 2 % high"
    assert str(Judgement("flash_temperature", 1.0, -12.4, 0.2)) == "12 ± 1 % low"


@pytest.mark.parametrize("percent", [0.0, 0.4, -0.4])
def test_a_judgement_of_zero_is_neither_high_nor_low(percent):
    assert str(Judgement("contact_fraction", None, percent, 13.0)) == "0 ± 13 %"


def test_the_table_has_every_observable_and_marks_those_without_a_band():
    shown = CliRunner().invoke(app, ["theory", "demo", "--trust"])
    assert shown.exit_code == 0
    assert "% high" in shown.stdout
    assert "% low" in shown.stdout
    words = " ".join(shown.stdout.split())
    assert words.count("the calibrated stress spectrum up to q_max = 2e+05 rad/m") == 1
    rows = {row[0]: row[1:] for row in trust_table(trust(rs.load_scene("demo"))).rows}
    assert set(rows) == set(prediction.predictions(rs.load_scene("demo")))
    assert set(rows["flash_width"]) == {"not known"}


@pytest.mark.slow
def test_the_json_has_the_same_keys_inside_and_outside_the_range():
    inside, outside = (
        json.loads(CliRunner().invoke(app, ["theory", name, "--trust", "--json"]).stdout)["trust"]
        for name in ("steel-1.2GPa", "granite")
    )
    assert set(inside) == set(outside) == {"source", "where", "against", "rows", "off"}
    assert inside["against"] == "the calibrated stress spectrum up to q_max = 4.15e+07 rad/m"
    assert set(inside["rows"][0]) == {"observable", "speed", "percent", "error"}
    assert outside["rows"] == []
    assert outside["where"].startswith(
        "nominal_pressure/penetration_hardness = 0.0005 lies outside 0.005 … 0.6"
    )
    assert all(np.isfinite(row["percent"]) for row in inside["rows"])
