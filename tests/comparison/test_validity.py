"""The map of the theory's validity: its file, what it says of a scene, and the parts of the script that made it."""

import json
import re
import sys
from dataclasses import replace
from math import nan, sqrt
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.cli import app
from roughsim.comparison import trust as look_up
from roughsim.comparison.tables import comparison_table, trust_table
from roughsim.comparison.trust import Judgement, trust
from roughsim.errors import RecordError
from roughsim.scene import parse_scene
from roughsim.store.validity_map import Table, read_validity, write_validity
from theory import calibrated, flash, persson

sys.path.insert(0, str(Path(__file__).parents[2] / "experiments"))
from validity_map import capped, elastic, estimates, fit, members, tables

SCENE = """
[surface]
rms_slope = {slope}
hurst = {hurst}
q_min = 1e4
q_roll_off = 2e4
q_max = {q_max}
[body]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "{pressure} Pa"
friction_coefficient = 0.1
speed = [0, 0.1, 35]
[theory]
gamma = {gamma}
"""
MODULUS = 1e8 / (1 - 0.3**2)


def scene(load=0.05, hurst=0.7, bandwidth=10.0, gamma=0.45, slope=0.01):
    text = SCENE.format(slope=slope, hurst=hurst, q_max=2e4 * bandwidth, pressure=load * MODULUS * slope, gamma=gamma)
    return parse_scene(text)


def simple_map():
    """ln(measured/theory) = x + ln H + y − z of x = ln load, y = ln bandwidth, z = ln Péclet: linear."""
    quantities = (*(("flash_temperature", pe) for pe in (1e-3, 1.0, 1e3)), ("pressure_variance", nan))
    place = np.array(
        [(p, h, r, 2.0, 0.0) for p in (0.01, 0.03, 0.1) for h in (0.5, 0.8, 1.0) for r in (4.0, 16.0, 64.0)]
    )
    base = np.log(place[:, :3]).sum(axis=1)
    value = np.exp(base[:, None] - np.array([np.log(1e-3), 0.0, np.log(1e3), 0.0]))
    coordinates = ("load", "hurst", "bandwidth", "plateau", "low_exponent")
    return {"elastic": Table(coordinates, ("",) * len(place), quantities, place, value, np.full(value.shape, 0.02))}


def capped_scene(share=0.1, yields=1.0, hurst=0.8, depth=16.0, plateau=2.0, low_exponent=0.0):
    """A scene at these coordinates of the capped map; its C(q) ends at q_max = depth q_y."""
    point = capped.CappedPoint(share, yields, hurst, plateau, low_exponent)
    q_max = depth * yields
    of_slope_1 = members.spectrum_of(hurst, plateau, q_max, low_exponent)
    slope, pressure = 0.01 * sqrt(point.spectrum(1.0) / of_slope_1(1.0)), share * point.hardness * MODULUS * 0.01
    text = SCENE.format(slope=slope, hurst=hurst, q_max=2e4 * q_max, pressure=pressure, gamma=0.45)
    text = text.replace("q_min = 1e4", f"q_min = {2e4 / plateau}\nroll_off_exponent = {low_exponent}")
    text = text.replace("[sliding]", f"penetration_hardness = {point.hardness * MODULUS * 0.01}\n[sliding]")
    speeds = [pe * 2e4 * 30 / (7900 * 500) for pe in (0.01, 1.0, 100.0)]
    return parse_scene(text.replace("[0, 0.1, 35]", str(speeds)))


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
        ({"low_exponent": 1.0}, "roll_off_exponent 1, the map has only 0"),
    ],
)
def test_off_the_capped_map_no_number_is_borrowed_and_the_coordinate_is_named(place, words):
    known = trust(capped_scene(**place))
    assert (known.source, known.where, known.judgements) == ("off the map", words, ())


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
    assert known.where == ("load and C(q) within its range (off the map: q_roll_off/q_min 5, the map has only 2)")
    assert (
        known.against == "the calibrated stress spectrum up to q_max = 2e+05 rad/m, which is within 5% of simulations"
    )
    spectrum = persson.calibrated_spectrum(
        wide.spectrum, effective_modulus=MODULUS, nominal_pressure=wide.sliding.nominal_pressure
    )
    pressures = {"effective_modulus": MODULUS, "nominal_pressure": wide.sliding.nominal_pressure}
    ratio = persson.pressure_correlation(0.0, wide.spectrum, gamma=0.45, **pressures)
    ratio = float(ratio / persson.pressure_correlation(0.0, stress_spectrum=spectrum))
    (variance,) = [j for j in known.judgements if j.speed is None]
    assert variance.percent == pytest.approx(100 * (ratio - 1), rel=1e-9)
    assert variance.error == pytest.approx(100 * ratio * calibrated.ERROR_BAND, rel=1e-9)
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
    assert known.to_dict() == {"source": "off the map", "where": known.where, "against": "", "rows": [], "off": []}
    laws = "(a table, the sum of two different faces, or another law)"
    assert known.where == f"C(q) is not self-affine {laws}, and has no place on the map"


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
    assert (listed["trust"]["source"], listed["trust"]["rows"]) == ("off the map", [])


def test_a_map_is_read_back_as_it_was_written(tmp_path):
    path = tmp_path / "map.h5"
    write_validity(path, simple_map(), {"program": "test"})
    (name, back), (_, given) = *read_validity(path).items(), *simple_map().items()
    assert name == "elastic"
    for field in ("coordinates", "labels"):
        assert getattr(back, field) == getattr(given, field)
    np.testing.assert_array_equal([pe for _, pe in back.quantities], [pe for _, pe in given.quantities])
    for field in ("place", "value", "error"):
        np.testing.assert_array_equal(getattr(back, field), getattr(given, field))


def test_a_damaged_map_is_refused(tmp_path):
    path = tmp_path / "map.h5"
    write_validity(path, simple_map(), {})
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 255
    path.write_bytes(content[: len(content) - 100])
    with pytest.raises(RecordError, match=r"map\.h5 is no readable map of validity"):
        read_validity(path)


def test_the_shipped_map_has_the_points_of_the_script():
    sys.path.insert(0, str(Path(__file__).parents[2] / "experiments"))
    import validity

    shipped = read_validity()
    points = validity.whole_map()
    grid = {(p.load, p.hurst, p.bandwidth, p.plateau, p.low_exponent) for p in points if isinstance(p, elastic.Point)}
    assert set(map(tuple, shipped["elastic"].place.tolist())) == grid
    plastic = [p for p in points if isinstance(p, capped.CappedPoint)]
    expected = np.array([[p.share, p.yields, p.hurst, p.plateau, p.low_exponent] for p in plastic])
    for name in ("smoothed", "steps"):
        np.testing.assert_allclose(shipped[name].place, expected, rtol=1e-12)
    table = shipped["capped"]
    np.testing.assert_allclose(table.place[np.isinf(table.place[:, 5]), :5], expected, rtol=1e-12)
    finite = {d: (table.place[:, 5] == d).sum() for d in np.unique(table.place[:, 5])}
    assert finite[4.0] == finite[16.0] >= 30 + 3  # two q_y/q_roll_off, three H, five shares; the steels
    assert {label for label in table.labels if label} == {"steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"}


@pytest.mark.parametrize("part", ["elastic", "smoothed", "steps", "capped"])
def test_the_shipped_map_knows_what_matters_to_three_percent(part):
    table = read_validity()[part]
    limits = np.isinf(table.place[:, -1]) | (part != "capped")
    for k, (name, _) in enumerate(table.quantities):
        if name in ("flash_temperature", "pressure_variance"):
            assert table.error[limits, k].max() <= 0.03, name
            assert table.error[:, k].max() <= 0.035, name


@pytest.mark.parametrize("name", ["steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"])
def test_the_steel_scenes_are_points_of_the_capped_map(name):
    known = trust(rs.load_scene(name))
    assert known.source == "map"
    assert {j.observable for j in known.judgements} == {"flash_temperature", "pressure_variance"}


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
    assert known.where == "q_roll_off/q_min 3.15, the map has only 2"
    assert len(comparison_table(rs.compare(capped_run)).rows) > len(trust_table(known).rows) == 1


# the parts of the script


def test_functionals_of_one_wave_are_exact():
    # σ = p + a cos(qx): |σ_q|² = a²/2 at q; at rest the flash temperature is μ v q̇-like, Σ w/q
    grid = rs.Grid((64, 64), (2 * np.pi, 2 * np.pi))
    x = np.arange(64)[:, None] * grid.lengths[0] / 64
    stress = members.stress_table(2.0 + 0.3 * np.cos(3 * x) + np.zeros(grid.shape), grid)
    values = stress @ members.kernels(grid)
    assert values[members.COLUMNS["pressure_variance"]][0] == pytest.approx(0.045, rel=1e-12)
    even, odd = flash.angular_integrals(np.array([1.0 / 3.0]))
    assert values[members.COLUMNS["flash_temperature"]][3] == pytest.approx(0.045 / 3 * 2 / np.pi * even[0], rel=1e-12)
    assert values[members.COLUMNS["flash_gradient"]][3] == pytest.approx(-0.045 * 2 / np.pi * odd[0], rel=1e-12)


def test_the_tail_completes_a_stress_that_falls_as_the_fourth_power():
    # |σ_q|² = q^−4 from the plane up to any q: what the grid cuts off is put back
    point = elastic.Point(0.1, 0.8, 4.0)
    for pixels in (8, 16):
        grid = point.grid(4.0, pixels, 8.0)
        q = members.radial(grid).wavenumber
        stress = np.where(q > 1.0, members.radial(grid).count * (1 / 8.0) ** 2 * q**-4.0, 0.0)
        share, _ = elastic.TAIL[pixels]
        values, doubt = elastic.completed(stress, grid, pixels)
        beyond = np.pi / (elastic.CUT * grid.nyquist) ** 2
        kept = float(stress[q <= elastic.CUT * grid.nyquist].sum())
        assert values[members.COLUMNS["pressure_variance"]][0] - kept == pytest.approx(share * beyond, rel=0.02)
        assert (doubt >= 0).any()


def test_the_control_variate_leaves_the_mean_and_narrows_it():
    rng = np.random.default_rng(5)
    common = rng.standard_normal(400)
    own, other = common[:25] + 0.1 * rng.standard_normal(25), common
    shift, variance, _ = estimates._regressed(own, other)
    assert variance < 0.2 * own.var(ddof=1) / 25
    assert abs(own.mean() + shift) < 4 * sqrt(variance)


def test_gradients_of_the_quantities_are_their_derivatives():
    point = elastic.Point(0.1, 0.8, 4.0)
    q = np.geomspace(0.5, 20, 60)
    mean = (q**-2.0) @ members.kernel_matrix(q)
    for quantity in [("flash_temperature", 2), ("flash_width", 5), ("slope_length", 4), ("correlation_radius_50", 0)]:
        _, gradient = estimates.linear(mean, quantity)
        step = 1e-6 * mean * np.random.default_rng(1).standard_normal(mean.size)
        rise = estimates.linear(mean + step, quantity)[0] - estimates.linear(mean - step, quantity)[0]
        assert rise == pytest.approx(2 * gradient @ step, rel=1e-4, abs=1e-10)
    assert point.name


@pytest.mark.parametrize("point", [elastic.Point(0.02, 0.3, 16.0), elastic.Point(0.4, 1.0, 6.0, 1.0)])
def test_the_fit_uses_the_form_that_ships(point):
    c = calibrated.CONSTANTS
    flat = (c.later, c.present, *c.power, c.floor, *c.edge, *c.near)
    expected = fit.predicted(fit.Sample(point), flat)
    spectrum = persson.calibrated_spectrum(point.spectrum, effective_modulus=1.0, nominal_pressure=point.load)
    theory = estimates.theory_values(point.spectrum, point.load, stress_spectrum=spectrum)
    np.testing.assert_allclose([theory[q] for q in fit.SCORED], expected, atol=2e-4)


def test_full_contact_is_measured_as_the_theory_has_it():
    # W = 1: what is left of the ratio is the cell's few longest waves
    point = elastic.Point(12.0, 0.8, 4.0)
    raw = elastic.measure(point, elastic.Effort(0, 3, {8: 2}))
    row = tables.elastic_table([(point, raw)])
    which = [k for k, (name, _) in enumerate(row.quantities) if name in ("flash_temperature", "pressure_variance")]
    np.testing.assert_allclose(row.value[0, which], 1.0, atol=3e-3)


def ladder(power, scatter, seed=0, rungs=(4.0, 8.0, 16.0, 32.0, 64.0), exact=3.0):
    """Members with T_flash = exact (1 + f^-power) s at the cut-off f, s common to all rungs; few on the fine ones."""
    rng = np.random.default_rng(seed)
    common = np.exp(scatter * rng.standard_normal(256))
    own = {f: np.exp(0.02 * scatter * rng.standard_normal(256 // 2**k)) for k, f in enumerate(rungs)}
    raw = {}
    for f, noise in own.items():
        values = np.zeros((noise.size, members.FUNCTIONALS))
        values[:, members.COLUMNS["flash_temperature"]] = (exact * (1 + f**-power) * common[: noise.size] * noise)[
            :, None
        ]
        raw[f"capped{f:g}"] = values
    return raw


@pytest.mark.parametrize("power", [0.55, 1.0, 1.4])
def test_the_limit_of_a_ladder_has_the_exponent_that_the_ladder_shows(power):
    value, error = tables.limit(ladder(power, 1e-7), ("flash_temperature", 3))
    assert value == pytest.approx(np.log(3.0), abs=1e-5)
    assert error < 0.1 * (64.0**-power) * 1.1 + 1e-5  # nothing but the share of what lies beyond


@pytest.mark.parametrize("depth", capped.DEPTHS)
def test_where_c_ends_the_pixels_are_taken_off(depth):
    # T_flash is 0.3 n^-1.6 (4 q_y/q_max)^1.1 too high with n pixels per shortest wave; all rungs have two
    noise = 1.0 + 1e-4 * np.random.default_rng(3).standard_normal((8, 1))

    def rung(pixels, end):
        values = np.ones((8, members.FUNCTIONALS))
        values[:, members.COLUMNS["flash_temperature"]] += 0.3 * pixels**-1.6 * (4.0 / end) ** 1.1
        return values * noise

    raw = {f"capped{end:g}": rung(2, end) for end in capped.DEPTHS}
    raw |= {f"finer{n}-{end:g}": rung(n, end) for end, many in capped.FINER.items() for n in many}
    high = np.log(rung(2, depth)[0, 3] / noise[0, 0])
    shift, error = tables._pixels(raw, ("flash_temperature", 3), depth)
    assert abs(shift + high) <= error
    assert error <= 0.25 * high if depth <= 16.0 else error <= 0.6 * high


@pytest.mark.parametrize("top", [6, 8])
@pytest.mark.parametrize("power", [0.1, 0.2, 0.5])
def test_past_the_peclet_number_a_ladder_nears_its_limit_as_slow_sliding_does(power, top):
    # one variance per octave, q^-power; what the cut-off leaves out gathers at the cut-off, as the total is conserved
    q = 2.0 ** np.arange(60)
    share, kernel = q**-power, members.kernel_matrix(q)
    noise = np.random.default_rng(1).standard_normal((8, 1))
    raw = {
        f"capped{q[k]:g}": (share[:k] @ kernel[:k] + share[k:].sum() * kernel[k]) * np.exp(1e-9 * noise)
        for k in range(2, top + 1)
    }
    for speed, exact in enumerate(np.log((share @ kernel)[members.COLUMNS["flash_temperature"]])):
        value, error = tables.limit(raw, ("flash_temperature", speed))
        beyond = np.log(raw[f"capped{q[top]:g}"].mean(0)[speed]) - exact
        assert abs(value - exact) <= min(error, 0.11 * beyond) + 1e-6
        assert error <= 0.3 * beyond + 1e-6


def test_a_step_is_taken_from_where_the_coarse_rung_is_known_to_be():
    coarse = np.random.default_rng(2).standard_normal(6)
    step, slope, error = tables._step(coarse, 0.3 + 0.8 * coarse, 5.0)
    assert (step, slope) == (pytest.approx(0.3 - 0.2 * 5.0, rel=1e-9), pytest.approx(-0.2, rel=1e-9))
    assert error < 1e-9


def test_what_force_balance_fixes_on_the_finest_rungs_is_known_although_the_coarse_ones_scatter():
    raw = ladder(1.0, 0.2)
    column = members.COLUMNS["pressure_variance"]
    for k, rung in enumerate(raw.values()):
        rung[:, column] = 2.0 * (rung[:, [3]] / rung[:, 3].mean() if k == 0 else 1.0)
    value, error = tables.limit(raw, ("pressure_variance", 0))
    assert value == pytest.approx(np.log(2.0), abs=1e-2)
    assert error < 5e-3


def test_the_error_of_a_limit_covers_what_it_misses():
    found = [tables.limit(ladder(0.7, 0.1, seed), ("flash_temperature", 0)) for seed in range(40)]
    off = np.array([value - np.log(3.0) for value, _ in found])
    error = np.array([error for _, error in found])
    assert (abs(off) < error).mean() >= 0.9
    assert np.median(error) < 0.05


def test_every_capped_ladder_is_deep_enough_for_its_limit_to_be_tried():
    import validity

    for point in validity.whole_map():
        if isinstance(point, capped.CappedPoint):
            rungs = capped.ladder(point)
            assert len(rungs) >= (3 if point.label else 4), point.name
            assert list(rungs.values()) == sorted(rungs.values(), reverse=True)
            assert max(rungs) * point.yields <= point.spectrum.q_max


def test_where_a_capped_point_yields():
    point = capped.CappedPoint(0.1, 2.0)
    variance = persson.half_variance(2.0, point.spectrum, effective_modulus=1.0)
    from theory import plasticity

    _, left, yielded = plasticity.area_fractions(variance, 0.1 * point.hardness, point.hardness)
    assert left / (left + yielded) == pytest.approx(0.01, rel=1e-9)
    scene = rs.load_scene("steel-1.2GPa")
    assert capped.of_scene(scene).yields * 9.4e4 == pytest.approx(prediction.yield_wavenumber(scene), rel=1e-9)
