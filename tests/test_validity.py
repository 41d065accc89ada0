"""The map of the theory's validity: its file, what it says of a scene, and the parts of the script that made it."""

import json
import sys
from dataclasses import replace
from math import nan, sqrt
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import roughsim as rs
from roughsim import analytic
from roughsim.cli import app
from roughsim.errors import RecordError
from roughsim.record.validity import Table, read_validity, write_validity
from roughsim.scene import parse_scene
from roughsim.tables import comparison_table, trust_table
from roughsim.trust import Judgement, known, trust
from theory import calibrated, flash, persson

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))
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
    """ln(measured/theory) = x + H + y − z of x = ln load, y = ln bandwidth, z = ln Péclet: linear."""
    quantities = (*(("flash_temperature", pe) for pe in (1e-3, 1.0, 1e3)), ("pressure_variance", nan))
    place = np.array([(p, h, r, 2.0, 0.0) for p in (0.01, 0.1) for h in (0.5, 1.0) for r in (4.0, 16.0, 64.0)])
    base = np.log(place[:, 0]) + place[:, 1] + np.log(place[:, 2])
    value = np.exp(base[:, None] - np.array([np.log(1e-3), 0.0, np.log(1e3), 0.0]))
    coordinates = ("load", "hurst", "bandwidth", "plateau", "low_exponent")
    return {"elastic": Table(coordinates, ("",) * len(place), quantities, place, value, np.full(value.shape, 0.02))}


def test_between_its_points_the_map_is_interpolated_in_logarithms():
    known = trust(scene(0.05, 0.7, 10.0), simple_map())
    assert known.source == "map"
    flash_at = {j.speed: j for j in known.judgements if j.observable == "flash_temperature"}
    assert set(flash_at) == {0.1, 35.0}  # at rest there is no heat to judge
    diffusivity = 30 / (7900 * 500)
    for speed, judgement in flash_at.items():
        ratio = np.exp(np.log(0.05) + 0.7 + np.log(10.0)) / (speed / diffusivity / 2e4)
        assert judgement.percent == pytest.approx(100 * (1 / ratio - 1), rel=1e-9)
        assert judgement.error == pytest.approx(100 / ratio * np.hypot(0.02, 0.01), rel=1e-9)


def test_gamma_is_put_right_by_the_theory_itself():
    soft, base = scene(gamma=0.3), scene(gamma=0.45)
    (a,), (b,) = ([j for j in trust(s, simple_map()).judgements if j.speed is None] for s in (soft, base))
    change = analytic.predictions(soft)["pressure_variance"][0] / analytic.predictions(base)["pressure_variance"][0]
    assert (100 + a.percent) / (100 + b.percent) == pytest.approx(change, rel=1e-9)


def test_outside_the_map_the_nearest_point_is_named():
    known = trust(scene(load=0.001, hurst=0.95, bandwidth=20.0), simple_map())
    assert known.source == "nearest"
    assert known.where.startswith("load p/(E*h') 0.01, H 1, q_max/q_roll_off 16")
    (variance,) = [j for j in known.judgements if j.speed is None]
    assert variance.percent == pytest.approx(100 * (1 / (0.01 * np.e * 16) - 1), rel=1e-9)


def test_speeds_beyond_the_map_have_reached_its_limits():
    slow = replace(scene(), sliding=replace(scene().sliding, speed=(1e-9, 1e-8)))
    a, b, *_ = trust(slow, simple_map()).judgements
    assert a.percent == b.percent


def test_off_the_map_but_in_its_range_the_calibrated_spectrum_speaks():
    wide = scene(load=0.05, hurst=0.7, bandwidth=10.0)
    wide = replace(wide, surface=replace(wide.surface, q_min=4e3))
    known = trust(wide, simple_map())
    assert known.source == "calibrated"
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
    with pytest.raises(ValueError, match="only a self-affine one has a place on the map"):
        trust(tabled)
    assert known(tabled) is None


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
    sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))
    import validity

    shipped = read_validity()
    points = validity.whole_map()
    grid = {(p.load, p.hurst, p.bandwidth, p.plateau, p.low_exponent) for p in points if isinstance(p, elastic.Point)}
    assert set(map(tuple, shipped["elastic"].place.tolist())) == grid
    plastic = [p for p in points if isinstance(p, capped.CappedPoint)]
    np.testing.assert_allclose(shipped["capped"].place[:, 0], [p.share for p in plastic], rtol=1e-12)
    assert [label for label in shipped["capped"].labels if label] == ["steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"]


@pytest.mark.parametrize("part", ["elastic", "smoothed", "steps", "capped"])
def test_the_shipped_map_knows_what_matters_to_three_percent(part):
    table = read_validity()[part]
    for k, (name, _) in enumerate(table.quantities):
        if name in ("flash_temperature", "pressure_variance"):
            assert table.error[:, k].max() <= 0.03, name


@pytest.mark.parametrize("name", ["steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"])
def test_the_steel_scenes_are_points_of_the_capped_map(name):
    known = trust(rs.load_scene(name))
    assert known.source == "map"
    assert {j.observable for j in known.judgements} == {"flash_temperature", "pressure_variance"}


def test_the_command_says_what_is_known():
    shown = CliRunner().invoke(app, ["theory", "steel-1.2GPa", "--trust"])
    assert shown.exit_code == 0
    assert "flash_temperature" in shown.stdout
    assert "% high" in shown.stdout
    assert "% low" in shown.stdout
    listed = json.loads(CliRunner().invoke(app, ["theory", "steel-1.2GPa", "--trust", "--json"]).stdout)
    assert listed["trust"]["source"] == "map"
    assert {"observable", "speed", "percent", "error"} == set(listed["trust"]["rows"][0])


def test_a_comparison_may_be_followed_by_what_is_known(capped_run):
    known = trust(capped_run.scene)
    assert comparison_table(rs.compare(capped_run)).row_count > trust_table(known).row_count == 2


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
    assert capped.of_scene(scene).yields * 9.4e4 == pytest.approx(analytic.yield_wavenumber(scene), rel=1e-9)
