"""How far the theory can be trusted: interpolation on the map, its error, and what lies off the map."""

import json
import re
from dataclasses import replace
from math import nan

import numpy as np
import pytest
from typer.testing import CliRunner
from validity_cases import MODULUS, capped_scene, scene, simple_map
from validity_map import tables

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison import trust as look_up
from roughsim.comparison.compare import comparison_table
from roughsim.comparison.tables import trust_table
from roughsim.comparison.trust import Judgement, trust
from roughsim.comparison.validity_map import Table, read_validity
from theory import flash, persson, yielding


def test_between_its_points_the_map_is_interpolated_in_logarithms():
    known = trust(scene(0.05, 0.7, 10.0), simple_map())
    assert known.source == "map"
    flash_at = {j.speed: j for j in known.judgements if j.observable == "flash_temperature"}
    assert set(flash_at) == {0.1, 35.0}  # at rest there is no heat to judge
    diffusivity = 30 / (7900 * 500)
    for speed, judgement in flash_at.items():
        ratio = 0.05 * 0.7 * 10.0 / (speed / diffusivity / 2e4)
        assert judgement.percent == pytest.approx(100 * (1 / ratio - 1), rel=1e-9)
        assert judgement.error == pytest.approx(100 / ratio * 0.02, rel=1e-9)  # straight: nothing is missed between


@pytest.mark.parametrize(("column", "at"), [(0, 0.05), (1, 0.7), (2, 10.0)])
def test_a_bend_of_the_map_is_followed_and_its_error_is_half_of_what_a_straight_line_misses(column, at):
    # ln(measured/theory) = 0.3 x² in one of load, H and bandwidth: the line misses 0.3 (x - a)(b - x)
    tables = simple_map()
    table = tables["elastic"]
    place = np.array(
        [(p, h, r, 2.0, 0.0) for p in (0.01, 0.1, 0.4) for h in (0.5, 0.8, 1.0) for r in (4.0, 16.0, 64.0)]
    )
    x = np.log(place[:, column])
    value = np.exp(0.3 * x**2)[:, None] * np.ones(len(table.quantities))
    bent = replace(table, labels=("",) * len(place), place=place, value=value, error=np.full(value.shape, 1e-6))
    nodes, target = np.unique(x), np.log(at)
    a, b = nodes[nodes <= target][-1], nodes[nodes > target][0]
    missed = 0.3 * (target - a) * (b - target)
    for judgement in trust(scene(0.05, 0.7, 10.0), {"elastic": bent}).judgements:
        assert judgement.percent == pytest.approx(100 * np.expm1(-0.3 * target**2), rel=1e-9)
        assert judgement.error == pytest.approx((100 + judgement.percent) * missed / 2, rel=1e-6)


def test_the_error_holds_all_that_a_straight_line_over_the_peclet_number_misses():
    tables = simple_map()
    x = np.log([1e-3, 1.0, 1e3])
    value = np.ones((27, 1)) * np.exp(1e-3 * np.append(x, 0.0) ** 2)
    bent = replace(tables["elastic"], value=value)
    (slow, fast) = (j for j in trust(scene(), {"elastic": bent}).judgements if j.speed)
    for judgement, (a, b) in ((slow, x[:2]), (fast, x[1:])):
        here = np.log(judgement.speed * 7900 * 500 / 30 / 2e4)
        low, high = min(a, here), max(b, here)
        assert low < here < high
        missed = 1e-3 * (here - low) * (high - here)
        assert judgement.error == pytest.approx((100 + judgement.percent) * np.hypot(0.02, missed), rel=1e-6)


def test_the_maps_own_error_is_taken_at_the_peclet_number_of_each_speed():
    table = simple_map()["elastic"]
    flat = replace(table, value=np.ones(table.value.shape), error=np.ones((27, 1)) * [0.01, 0.02, 0.05, 0.07])
    known = {judgement.speed: judgement for judgement in trust(scene(), {"elastic": flat}).judgements}
    assert known[None].error == pytest.approx(7.0, rel=1e-9)
    for speed, first, second, low in ((0.1, 0.01, 0.02, -3), (35.0, 0.02, 0.05, 0)):
        place = (np.log10(speed * 7900 * 500 / 30 / 2e4) - low) / 3  # between two of 10^-3, 1 and 10^3
        assert 0.05 < place < 0.95
        assert known[speed].error == pytest.approx(100 * (first + place * (second - first)), rel=1e-9)


def test_a_scene_beside_what_the_map_has_at_one_value_only_pays_for_the_step():
    near = scene(0.05, 0.7, 10.0)
    near = replace(near, surface=replace(near.surface, q_min=2e4 / 2.1))  # q_roll_off/q_min = 2.1 where the map has 2
    (variance,) = [j for j in trust(near, simple_map()).judgements if j.speed is None]
    step = np.log(2.1 / 2) / np.log(2)  # a factor of two may change the ratio by 20 %
    assert variance.error == pytest.approx((100 + variance.percent) * np.hypot(0.02, 0.2 * step), rel=1e-6)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_the_limit_is_neared_as_a_power_of_q_max_that_grows_with_h(hurst):
    # ln(measured/theory) = q_max^-(0.3 + 1.05 H): straight in the coordinate of the map, also up to infinity
    depth = np.array([4.0, 16.0, 64.0, np.inf])
    place = np.array([(0.1, 1.0, hurst, 2.0, 0.0, d) for d in depth])
    value = np.exp(depth ** -(0.3 + 1.05 * hurst))[:, None]
    quantities = (("pressure_variance", nan), *(("flash_temperature", pe) for pe in (1e-3, 1.0, 1e3)))
    one = Table((*tables.CAPPED, "depth"), ("",) * 4, quantities, place, value * np.ones(4), np.full((4, 4), 0.01))
    for judgement in trust(capped_scene(hurst=hurst, depth=200.0), {"capped": one}).judgements:
        assert judgement.percent == pytest.approx(100 * np.expm1(-(200.0 ** -(0.3 + 1.05 * hurst))), rel=1e-6)
        assert judgement.error == pytest.approx((100 + judgement.percent) * 0.01, rel=1e-3)


def test_gamma_is_put_right_by_the_theory_itself():
    soft, base = scene(gamma=0.3), scene(gamma=0.45)
    (a,), (b,) = ([j for j in trust(s, simple_map()).judgements if j.speed is None] for s in (soft, base))
    change = prediction.predictions(soft)["pressure_variance"][0] / prediction.predictions(base)["pressure_variance"][0]
    assert (100 + a.percent) / (100 + b.percent) == pytest.approx(change, rel=1e-9)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ({"load": 0.001}, r"load p/\(E\*h'\) 0.001 below 0.002 \(map: 0.002 to 0.6\)"),
        ({"load": 5.0, "bandwidth": 200.0}, r"load p/\(E\*h'\) 5 above 0.6 .*; q_max/q_roll_off 200 above 64"),
        ({"hurst": 0.05, "bandwidth": 500.0}, r"H 0.05 below 0.3 .*; q_max/q_roll_off 500 above 64"),
    ],
)
def test_off_the_elastic_map_no_number_is_borrowed_and_the_coordinate_is_named(place, words):
    known = trust(scene(**place))
    assert (known.source, known.judgements) == ("off the map", ())
    assert re.match(words, known.where)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ({"share": 0.7}, "pressure/hardness 0.7 above 0.5 (map: 0.01 to 0.5)"),
        ({"yields": 3.0}, "q_y/q_roll_off 3 above 2 (map: 1 to 2)"),
        ({"hurst": 0.9}, "H 0.9 above 0.8 (map: 0.3 to 0.8)"),
        ({"depth": 3.0}, "q_max/q_y 3 below 4 (map: 4 to inf)"),
        ({"plateau": 4.0}, "q_roll_off/q_min 4, the map has only 2"),
        ({"plateau": 2.2}, "q_roll_off/q_min 2.2, the map has only 2"),  # 0.14 steps: more than is near
        ({"low_exponent": 1.0}, "roll_off_exponent 1, the map has only 0"),
    ],
)
def test_off_the_capped_map_no_number_is_borrowed_and_the_coordinate_is_named(place, words):
    known = trust(capped_scene(**place))
    assert known.source == ("off the map" if "share" in place else "calibrated")
    assert words in known.where
    assert {j.observable for j in known.judgements} <= set(yielding.ERROR_BANDS)
    if "share" in place:
        assert known.judgements == ()
        assert "calibrated spectrum: nominal_pressure/penetration_hardness = 0.7 lies outside" in known.where


def test_a_surface_that_hardly_yields_is_off_the_capped_map():
    known = trust(rs.load_scene("granite"))
    assert known.source == "off the map"
    assert "q_y beyond q_max, less than 99 % of the contact yields" in known.where
    assert "pressure/hardness 0.0005 below 0.01" in known.where


@pytest.mark.parametrize("source", ["map", "calibrated"])
def test_a_speed_beyond_the_map_is_named_and_gets_no_number(source):
    base = scene() if source == "map" else replace(scene(), surface=replace(scene().surface, q_min=4e3))
    unit = 2e4 * 30 / (7900 * 500)  # of speed, for a Péclet number of 1
    fast = replace(base, sliding=replace(base.sliding, speed=(1e-4 * unit, 0.1 * unit, 3200 * unit)))
    known = trust(fast)
    assert known.source == source
    assert [why for _, why in known.off] == [
        "Péclet number 0.0001 below 0.001 (map: 0.001 to 1000 of v/(D q_roll_off))",
        "Péclet number 3200 above 1000 (map: 0.001 to 1000 of v/(D q_roll_off))",
    ]
    assert {j.speed for j in known.judgements} == {None, 0.1 * unit}
    table = trust_table(known)
    assert any("486.076 m/s is off the map: Péclet number 3200 above 1000" in note for note in table.notes)
    assert [off["speed"] for off in known.to_dict()["off"]] == [1e-4 * unit, 3200 * unit]


def test_the_peclet_number_of_a_table_is_that_of_its_mean_wavenumber():
    # C constant from 1e4 to 3e4 rad/m: ∫ q C dq / ∫ C dq = 2e4 rad/m
    base, unit = scene(), 2e4 * 30 / (7900 * 500)
    surface = type(base.surface)(psd=((1e4, 1e-26), (3e4, 1e-26)), psd_convention="persson")
    fast = replace(base, surface=surface, sliding=replace(base.sliding, speed=(0.1 * unit, 3200 * unit)))
    off, within = look_up.split_speeds(fast, read_validity()["elastic"])
    assert [why for _, why in off] == ["Péclet number 3200 above 1000 (map: 0.001 to 1000 of v/(D q_roll_off))"]
    assert within == {0: pytest.approx(0.1, rel=1e-5)}


# found by ensembles on ladders up to q_max with up to 16 pixels per shortest wave: theory/measured - 1 in %, T_flash
@pytest.mark.parametrize(("hurst", "found"), [(0.3, (149, 124, 53)), (0.5, (115, 96, 41)), (0.8, (84, 69, 28))])
def test_where_a_capped_surface_ends_is_a_coordinate_of_the_map(hurst, found):
    known = trust(capped_scene(share=0.15, yields=1.5, hurst=hurst, depth=8.0))
    judged = [j for j in known.judgements if j.observable == "flash_temperature"]
    for judgement, percent in zip(judged, found, strict=True):
        assert abs(judgement.percent - percent) <= np.hypot(judgement.error, 2.0)
        assert judgement.error < 9.0


def test_the_scene_demo_is_judged_where_its_surface_ends():
    judged = [j for j in trust(rs.load_scene("demo")).judgements if j.observable == "flash_temperature"]
    for judgement, percent in zip(judged, (167, 78, 54), strict=True):
        assert abs(judgement.percent - percent) <= np.hypot(judgement.error, 2.0)
        assert judgement.error < 7.0


def test_a_surface_without_end_is_judged_by_the_limit():
    table = read_validity()["capped"]
    (row,) = np.flatnonzero((table.place[:, :3] == (0.1, 1.0, 0.55)).all(axis=1) & np.isinf(table.place[:, 5]))
    far = [j for j in trust(capped_scene(0.1, 1.0, 0.55, 1e9)).judgements if j.observable == "flash_temperature"]
    (slow,) = [k for k, (name, pe) in enumerate(table.quantities) if (name, pe) == ("flash_temperature", 0.01)]
    assert far[0].percent == pytest.approx(100 * (1 / table.value[row, slow] - 1), rel=1e-4)


def test_what_the_map_misses_between_its_two_yield_wavenumbers_is_what_a_third_one_shows():
    # for H = 0.8 the map has q_y/q_roll_off = 1, 2 and 4: leaving out the 2 misses four times what lies halfway to it
    table, missed = read_validity()["capped"], []
    for share in np.unique(table.place[:25, 0]):
        logs = [
            np.log(table.value[(table.place == (share, y, 0.8, 2.0, 0.0, np.inf)).all(axis=1)]) for y in (1.0, 2.0, 4.0)
        ]
        if all(len(log) for log in logs):
            missed.append(np.abs(logs[1] - (logs[0] + logs[2]) / 2).max() / 4)
    assert len(missed) == 5
    assert max(missed) <= look_up.UNSEEN <= 2 * max(missed)


def test_off_the_map_but_in_its_range_the_calibrated_spectrum_speaks():
    wide = scene(load=0.05, hurst=0.7, bandwidth=10.0)
    wide = replace(wide, surface=replace(wide.surface, q_min=4e3))
    known = trust(wide, simple_map())
    assert known.source == "calibrated"
    assert known.where == ("pressures and C(q) within its range (off the map: q_roll_off/q_min 5, the map has only 2)")
    assert known.against == (
        "the calibrated stress spectrum up to q_max = 2e+05 rad/m, within the error given of simulations"
    )
    spectrum = persson.calibrated_spectrum(
        wide.spectrum, effective_modulus=MODULUS, nominal_pressure=wide.sliding.nominal_pressure
    )
    pressures = {"effective_modulus": MODULUS, "nominal_pressure": wide.sliding.nominal_pressure}
    ratio = persson.pressure_correlation(0.0, wide.spectrum, gamma=0.45, **pressures)
    ratio = float(ratio / persson.pressure_correlation(0.0, stress_spectrum=spectrum))
    (variance,) = [j for j in known.judgements if j.speed is None]
    assert variance.percent == pytest.approx(100 * (ratio - 1), rel=1e-9)
    for judgement in known.judgements:
        band = 0.07 if judgement.observable == "flash_gradient" else 0.05
        assert judgement.error == pytest.approx((100 + judgement.percent) * band, rel=1e-9)
    assert {j.speed for j in known.judgements} == {None, 0.1, 35.0}
    (warm,) = [j for j in known.judgements if (j.observable, j.speed) == ("flash_temperature", 35.0)]
    heat = {"friction_coefficient": 0.1, "conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500)}
    heat["nominal_pressure"] = wide.sliding.nominal_pressure
    true = flash.flash_temperature(35.0, stress_spectrum=spectrum, **heat)
    own = flash.flash_temperature(35.0, wide.spectrum, effective_modulus=MODULUS, gamma=0.45, **heat)
    assert warm.percent == pytest.approx(100 * (own / true - 1), rel=1e-9)


def test_the_words_have_the_right_sign():
    assert str(Judgement("flash_temperature", 1.0, 12.4, 2.2)) == "12 ± 2 % high"
    assert str(Judgement("flash_temperature", 1.0, -12.4, 0.2)) == "12 ± 1 % low"


def test_a_table_with_a_hardness_has_no_place_on_the_map():
    base = rs.load_scene("steel-1.2GPa")
    rows = ((1e4, 1e-26), (1e5, 1e-30))
    tabled = replace(base, surface=type(base.surface)(psd=rows, psd_convention="persson"))
    known = trust(tabled)
    assert known.source == "calibrated"  # no pressure reaches the hardness
    laws = "(a table, the sum of two different faces, or another law)"
    assert f"off the map: C(q) is not self-affine {laws}, and has no place on the map" in known.where


def test_two_different_faces_get_their_theory_and_the_reason_why_no_map_places_them(tmp_path):
    text = rs.scene.scene_text("demo")
    body = text[text.index("[surface]") : text.index("[counterface]")].replace("[surface]", "").replace("[body]", "")
    path = tmp_path / "two.toml"
    path.write_text(text.replace('like = "body"', body.replace("0.90 um", "0.30 um")))
    shown = CliRunner().invoke(app, ["theory", str(path), "--trust"])
    assert shown.exit_code == 0, shown.output
    assert "flash_temperature," in shown.stdout
    assert "off the map: C(q) is not self-affine (a table, the sum of two different faces, or another law)" in " ".join(
        shown.stdout.split()
    )
    listed = json.loads(CliRunner().invoke(app, ["theory", str(path), "--trust", "--json"]).stdout)
    assert listed["flash_temperature"][0] > 0
    assert listed["trust"]["source"] == "calibrated"


def test_the_command_says_what_is_known():
    shown = CliRunner().invoke(app, ["theory", "demo", "--trust"])
    assert shown.exit_code == 0
    assert "flash_temperature" in shown.stdout
    assert "% high" in shown.stdout
    assert "% low" in shown.stdout
    assert shown.stdout.count("the simulation extrapolated to q_max = 2e+05 rad/m") == 1  # once for all lines
    listed = json.loads(CliRunner().invoke(app, ["theory", "steel-1.2GPa", "--trust", "--json"]).stdout)
    assert listed["trust"]["source"] == "map"
    assert listed["trust"]["against"] == "the simulation extrapolated to q_max = 4.15e+07 rad/m"
    assert {"observable", "speed", "percent", "error"} == set(listed["trust"]["rows"][0])


def test_a_comparison_is_followed_by_why_the_map_knows_nothing_of_its_scene(capped_run):
    known = trust(capped_run.scene)
    assert "off the map: q_roll_off/q_min 3.15, the map has only 2" in known.where
    # each quantity has the band that was found for it
    bands = {"flash_temperature": 0.07, "pressure_variance": 0.09, "contact_fraction": 0.13, "plastic_fraction": 0.5}
    assert {j.observable for j in known.judgements} == set(bands)
    for judgement in known.judgements:
        assert judgement.error == pytest.approx((100 + judgement.percent) * bands[judgement.observable], rel=1e-9)
    rows = {row[0] for row in trust_table(known).rows}
    assert rows == set(bands)
    assert len(comparison_table(rs.compare(capped_run)).rows) > len(rows)
