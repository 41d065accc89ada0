"""Under the rules "mean" and "total" a run reports its temperatures with the share of its own contacts."""

import json
import tomllib
from dataclasses import replace
from itertools import pairwise

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import special
from small_scene import CAPPED
from typer.testing import CliRunner

import roughsim as rs
from roughsim import prediction
from roughsim.charts import curves as chart
from roughsim.cli import app
from roughsim.estimate import fields
from roughsim.explore.content import load_fields, measured_curves
from roughsim.observables.distribution import LEVELS
from roughsim.outputs import run_report as report
from roughsim.scene import parse_scene
from theory import background, plasticity

SPEEDS = (0.0, 0.1, 1.0, 35.0)
COLUMNS = ("smoothed", "capped")
# κ, and D = κ/ρc, of the moving and of the resting body
KAPPA, OTHER_KAPPA = 30.0, 60.0
D, OTHER_D = KAPPA / (7900 * 500), OTHER_KAPPA / (7900 * 500)
BRASS = "youngs_modulus = 100e9\npoisson_ratio = 0.3\nconductivity = 60\ndensity = 7900\nheat_capacity = 500"


def scene_with(rule, count=6, q_max=5e4, duration=2e-6):
    text = CAPPED.replace("heat_partition = 0.9", f'heat_partition = "{rule}"').replace(
        'like = "body"', BRASS
    )
    text = text.replace("[0, 0.1, 35]", str(list(SPEEDS))).replace(
        "q_max = 2e5", f"q_max = {q_max}"
    )
    if rule == "total":
        text = text.replace("[theory]", f"duration = {duration}\n[theory]")
    # one level a column, up to the end of C(q): what its members store is what is averaged
    levels = [f'{{ column = "{name}", shape = [64, 64], q_max = 5e4 }}' for name in COLUMNS]
    text = f"{text[: text.index('levels =')]}keep_fields = 1\nlevels = [{', '.join(levels)}]"
    return parse_scene(text.replace("max_realizations = 6", f"max_realizations = {count}"))


@pytest.fixture(scope="module", params=["mean", "total"])
def run(request, tmp_path_factory):
    return rs.run(scene_with(request.param), tmp_path_factory.mktemp("own") / request.param)


@pytest.fixture(scope="module")
def mean_run(tmp_path_factory):
    return rs.run(scene_with("mean"), tmp_path_factory.mktemp("own") / "run")


def moments(run, level):
    """⟨Tσ⟩/⟨σ⟩ with all the heat in the moving body, and in the resting one, of each member, (members, speeds)."""
    members = [run.members[level, index].numbers for index in range(run.realizations)]
    moving, resting = (
        np.array([m[name] for m in members])
        for name in ("flash_temperature", "resting_flash_temperature")
    )
    return moving, resting * KAPPA / OTHER_KAPPA


def by_hand(moving, resting):
    """The share that makes both temperatures equal, and the temperature itself, of the means over members."""
    moving, resting = moving.mean(axis=0), resting.mean(axis=0)
    return resting / (resting + moving), moving * resting / (resting + moving)


@pytest.mark.parametrize("level", [0, 1])
def test_the_share_is_that_of_the_runs_own_members_and_temperatures_carry_it(mean_run, level):
    run, column = mean_run, COLUMNS[level]
    share, temperature = by_hand(*moments(run, level))
    moving = np.array(SPEEDS) > 0.0
    np.testing.assert_allclose(run.share(column), share, rtol=1e-12)
    np.testing.assert_allclose(run.estimate("heat_partition", column).mean, share, rtol=1e-12)
    np.testing.assert_allclose(
        run.estimate("flash_temperature", column).mean[moving], temperature[moving], rtol=1e-12
    )
    assert run.estimate("flash_temperature", column).mean[0] == 0.0
    # the theory's share would have made another number, beyond the statistical error
    theory = prediction.heat_partition(run.scene)[2]
    apart = abs(theory / share[2] - 1.0)
    estimate = run.estimate("flash_temperature", column)
    assert apart > 0.03
    for name in ("flash_gradient", "flash_laplacian"):
        plain = np.array(
            [run.members[level, index].numbers[name] for index in range(run.realizations)]
        ).mean(axis=0)
        found = run.estimate(name, column).mean
        np.testing.assert_allclose(found[moving], (share * plain)[moving], rtol=1e-12)
    assert any("both bodies in this contact" in note for note in estimate.notes)


@pytest.mark.parametrize("level", [0, 1])
def test_the_error_of_the_share_is_in_that_of_the_temperature_with_their_correlation(
    mean_run, level
):
    # leave one member out: the usual error of a function of two means, to second order in the scatter
    values = moments(mean_run, level)
    count = len(values[0])
    left_out = [
        by_hand(*(np.delete(rows, index, axis=0) for rows in values))[1] for index in range(count)
    ]
    jackknife = np.sqrt((count - 1) * np.var(left_out, axis=0))
    error = mean_run.estimate("flash_temperature", COLUMNS[level]).standard_error
    np.testing.assert_allclose(error[1:], jackknife[1:], rtol=0.03)
    # without the share the error would be another one
    alone = by_hand(*values)[0] * values[0].std(axis=0, ddof=1) / np.sqrt(count)
    assert np.max(np.abs(alone[1:] / jackknife[1:] - 1.0)) > 0.02


def test_by_the_rule_total_the_backgrounds_are_in_the_balance(tmp_path):
    # long after the start the two backgrounds dominate: effusivities share the heat
    scene = scene_with("total", duration=1e3).with_("sliding.speed", [35.0])
    run = rs.run(scene, tmp_path / "long", max_realizations=2)
    effusivity = KAPPA / np.sqrt(D), OTHER_KAPPA / np.sqrt(OTHER_D)
    for column in COLUMNS:
        np.testing.assert_allclose(run.share(column), effusivity[0] / sum(effusivity), rtol=0.01)
        alone = np.mean(
            [run.members[COLUMNS.index(column), k].numbers["flash_temperature"] for k in (0, 1)]
        )
        assert run.estimate("flash_temperature", column).mean == pytest.approx(
            run.share(column) * alone, rel=1e-12
        )


def test_other_parts_of_the_error_of_the_share_add_to_those_of_the_temperature(tmp_path):
    levels = [
        {"column": "elastic", "shape": [32, 32], "q_max": 2.5e4},
        {"column": "elastic", "shape": [64, 64], "q_max": 5e4},
        {"column": "elastic", "shape": [128, 128], "q_max": 5e4},
    ]
    scene = scene_with("mean", q_max=2e5)
    soft, numerics = (
        replace(scene.body, penetration_hardness=None),
        replace(scene.numerics, levels=tuple(levels)),
    )
    run = rs.run(replace(scene, body=soft, numerics=numerics), tmp_path / "run")
    all_heat = run.simulated("elastic").estimate("flash_temperature", all_heat=True)
    share, found = (
        run.estimate("heat_partition", "elastic"),
        run.estimate("flash_temperature", "elastic"),
    )
    np.testing.assert_allclose(found.mean, share.mean * all_heat.mean, rtol=1e-12)
    for part in ("bandwidth", "pixel"):
        expected = share.mean * all_heat.budget[part] + np.abs(all_heat.mean) * share.budget[part]
        assert np.all(expected[1:] > 0.0)
        np.testing.assert_allclose(found.budget[part][1:], expected[1:], rtol=1e-12)
        assert found.budget[part][0] == 0.0  # at rest nothing heats


def test_the_error_by_the_scan_has_that_of_the_share(mean_run, monkeypatch):
    parts = {"flash_temperature": 0.1, "heat_partition": 0.02}
    errors = {name: np.full(len(SPEEDS), error) for name, error in parts.items()}
    monkeypatch.setattr("roughsim.results.means.scan_error", lambda _: errors)
    monkeypatch.setattr(type(mean_run.scene), "scanned", True)
    found = mean_run.simulated("capped").estimate("flash_temperature")
    np.testing.assert_allclose(found.budget["scan"], 0.12 * found.mean, rtol=1e-12)


def test_the_theory_keeps_its_own_share_and_ratios_have_none(run):
    scene, rows = run.scene, rs.compare(run).rows
    share = prediction.heat_partition(scene)
    for k, speed in enumerate(SPEEDS[1:], 1):
        row = next(r for r in rows if (r.observable, r.speed) == ("flash_temperature", speed))
        assert row.theory == pytest.approx(
            share[k] * prediction.predictions(scene)["flash_temperature"][k], rel=1e-12
        )
        alone = [moments(run, level)[0].mean(axis=0)[k] for level in (0, 1)]
        assert row.ratios["capped_over_smoothed"].mean == pytest.approx(
            alone[1] / alone[0], rel=1e-12
        )
        theory = row.theories["theory_same_modes"] / share[k]
        # the first ratio is at the grid of the level, as the column is
        assert row.ratios["smoothed_over_theory"].mean == pytest.approx(
            alone[0] / theory, rel=1e-12
        )


def calibrated_by_hand(scene):
    """Share and T_flash of the calibrated law at each speed, by trapezia over ln q of its stress spectrum, Eq. (4)."""
    solid = {
        "effective_modulus": scene.effective_modulus,
        "nominal_pressure": 90e6,
        "penetration_hardness": 1e9,
    }
    law = plasticity.stress_spectrum(scene.spectrum, **solid)
    ends = np.array(law.breaks)
    q = np.concatenate(
        [np.geomspace(a * (1 + 1e-12), b * (1 - 1e-12), 4000) for a, b in pairwise(ends)]
    )
    weight = 2 * np.pi * q * law(q)  # times dq/q: the integrand over ln q of ∫ 2π q |σ_q|² (1/q) dq
    time = scene.sliding.duration
    grown = 1.0 if time is None else special.erf(q * np.sqrt(OTHER_D * time))
    tau = [0.0 if time is None else 2 * 90e6**2 * np.sqrt(d * time / np.pi) for d in (D, OTHER_D)]
    cold = (np.trapezoid(weight * grown, np.log(q)) + tau[1]) / OTHER_KAPPA
    share, flash = [], []
    for speed in SPEEDS:
        square = 1 + (speed / (D * q)) ** 2
        angles = square**-0.25 * special.ellipk((1 - square**-0.5) / 2) * 2 / np.pi
        rise = np.trapezoid(weight * angles, np.log(q))
        share.append(cold / (cold + (rise + tau[0]) / KAPPA))
        flash.append(share[-1] * 0.11 * speed / (KAPPA * 90e6) * rise)
    return np.array(share), np.array(flash)


def calibrated_outputs(run, folder):
    """Yield the name of each output with what it has as the calibrated T_flash at 1 m/s, K."""
    comparison, scene = rs.compare(run), run.scene
    row = next(r for r in comparison.rows if (r.observable, r.speed) == ("flash_temperature", 1.0))
    yield "row", row.calibrated
    frame = comparison.to_dataframe().loc["flash_temperature"]
    yield "data frame", float(frame[frame.speed == 1.0]["calibrated"].iloc[0])
    yield "theory", float(rs.theory(scene).calibrated[2])
    told = json.loads(json.dumps(rs.theory(scene).to_dict()))["calibrated"]
    yield "JSON of theory", told["flash_temperature"][2]
    all_heat = prediction.calibrated_predictions(scene)["flash_temperature"][2]
    yield "share in JSON", told["heat_partition"][2] * all_heat
    table = rs.theory(scene).table()
    place = [column.title for column in table.columns].index("share calibrated")
    yield "share in the table", table.rows[2][place].value * all_heat
    share = next(r for r in comparison.rows if (r.observable, r.speed) == ("heat_partition", 1.0))
    yield "row of the share", share.calibrated * all_heat
    with h5py.File(rs.results.export.export_run(run, folder / "run.h5")) as whole:
        file = whole["results"]
        place = [text.decode() for text in file["column"]].index("calibrated")
        yield "HDF5", file["flash_temperature"][place, 2]
        yield "share in HDF5", file["heat_share_used"][place, 2] * all_heat
    axes = Figure().subplots()
    entry = chart.Entry("run", run.scene, run, comparison.results)
    chart.draw_over_speed(axes, entry, "flash_temperature")
    x, line = axes.get_lines()[1].get_data()
    yield "chart", line[np.argmin(np.abs(x - 1.0))]
    if scene.sliding.duration is not None:
        warm = next(
            r for r in comparison.rows if (r.observable, r.speed) == ("contact_temperature", 1.0)
        )
        rise = (
            share.calibrated * 2 * 0.11 * 90e6 / KAPPA * np.sqrt(D * scene.sliding.duration / np.pi)
        )
        yield "contact temperature", warm.calibrated - rise


def test_the_calibrated_law_has_the_share_of_its_own_temperatures(run, tmp_path):
    share, flash = calibrated_by_hand(run.scene)
    assert np.all(np.abs(prediction.heat_partition(run.scene) / share - 1.0)[2:] > 0.03)
    found = prediction.calibrated_predictions(run.scene)
    np.testing.assert_allclose(found["heat_partition"], share, rtol=1e-5)
    for where, value in calibrated_outputs(run, tmp_path):
        assert value == pytest.approx(flash[2], rel=1e-5), where


@pytest.mark.slow
def test_what_reacts_by_the_calibrated_law_has_its_share():
    asks = {"sliding.background_temperature": 1.0, "observables.heat_above": [50.0]}
    scene = rs.load_scene(tomllib.loads(scene_with("mean").to_toml()), asks)
    share = calibrated_by_hand(scene)[0][2]
    told = rs.theory(scene).to_dict()["calibrated"]
    drawn = fields.quantiles(scene)
    hottest = drawn["temperature_quantile_99"].mean[2]
    assert told["temperature_quantile_99"]["value"][2] == pytest.approx(share * hottest, rel=1e-5)
    # the share of the heat above 49 K of the body's own part lies between the levels of the quantiles around it
    heat = [share * drawn[f"temperature_quantile_{name}"].mean[2] for name in LEVELS]
    expected = 1.0 - np.interp(49.0, heat, [*LEVELS.values()])
    assert told["heat_share_above"][0]["value"][2] == pytest.approx(expected, abs=0.03)


def test_without_the_law_its_share_is_unknown():
    granite = {
        rule: rs.load_scene("granite", {"sliding.heat_partition": rule}) for rule in ("mean", 0.7)
    }
    assert np.isnan(prediction.calibrated_share(granite["mean"])).all()
    np.testing.assert_array_equal(prediction.calibrated_share(granite[0.7]), 0.7)


def outputs(run, column, folder):
    """Yield the name of each output with what it has as T_flash of a column at 1 m/s, K."""
    comparison = rs.compare(run)
    row = next(r for r in comparison.rows if (r.observable, r.speed) == ("flash_temperature", 1.0))
    yield "row", row.columns[column].mean
    told = json.loads(CliRunner().invoke(app, ["compare", str(run.folder), "--json"]).stdout)[
        "rows"
    ]
    yield (
        "JSON",
        next(r for r in told if (r["observable"], r["speed"]) == ("flash_temperature", 1.0))[
            column
        ]["mean"],
    )
    frame = comparison.to_dataframe().loc["flash_temperature"]
    yield "data frame", float(frame[frame.speed == 1.0][column].iloc[0])
    curve = measured_curves(run, column)["flash_temperature"]
    yield "explore", float(curve.sel(speed=1.0).mean)
    with h5py.File(rs.results.export.export_run(run, folder / "run.h5")) as whole:
        file = whole["results"]
        place = [text.decode() for text in file["column"]].index(column)
        yield "HDF5", file["flash_temperature"][place, 2]
        level = COLUMNS.index(column)
        yield "level in HDF5", whole["members/flash_temperature"][level, :, 2].mean()
        moving = moments(run, level)[0].mean(axis=0)[2]
        yield "share in HDF5", file["heat_share_used"][place, 2] * moving
    data = run.to_xarray()
    yield "xarray", float(data.flash_temperature.isel(level=level, speed=2).mean())
    yield "share in xarray", float(data.heat_partition.isel(level=level, speed=2)) * moving
    axes = Figure().subplots()
    entry = chart.Entry("run", run.scene, run, comparison.results)
    chart.draw_over_speed(axes, entry, "flash_temperature")
    bands = [line for line in axes.get_lines() if hasattr(line, "half_width")]
    x, mean = bands[level].get_data()
    yield "chart", mean[list(x).index(1.0)]
    again = rs.open_run(run.folder)
    yield "opened again", again.estimate("flash_temperature", column).mean[2]


@pytest.mark.slow
@pytest.mark.parametrize("column", [pytest.param("smoothed", marks=pytest.mark.slow), "capped"])
def test_all_outputs_have_the_temperature_of_that_share(mean_run, column, tmp_path):
    _, temperature = by_hand(*moments(mean_run, COLUMNS.index(column)))
    said = dict(outputs(mean_run, column, tmp_path))
    assert len(said) == 11
    for where, value in said.items():
        assert value == pytest.approx(temperature[2], rel=1e-9), where


def test_fields_have_the_share_of_their_column(mean_run):
    for level, column in enumerate(COLUMNS):
        share, _ = by_hand(*moments(mean_run, level))
        (_, field) = next(mean_run.fields("temperature", column, speed=1.0))
        flux = next(mean_run.fields("heat_flux", column, speed=1.0))[1]
        grid = mean_run.numerics.grid(level)
        slid = mean_run.numerics.slid_distance
        heat = {"speed": 1.0, "conductivity": KAPPA, "diffusivity": D, "slid_distance": slid}
        alone = rs.sliding_temperature(flux, grid, **heat)
        np.testing.assert_allclose(field, share[2] * alone, rtol=1e-5, atol=1e-5 * alone.max())
        drawn = load_fields(mean_run, level, 0).temperature(1.0, 0.0).field
        np.testing.assert_allclose(drawn, field, rtol=1e-4, atol=1e-5 * alone.max())


def test_the_share_at_other_speeds_passes_through_those_of_the_run_and_ends_at_rest(mean_run):
    shares = mean_run.share("capped")
    for speed, share in zip(SPEEDS, shares, strict=True):
        assert mean_run.heat_share(-speed, "capped") == share
        if speed:
            assert mean_run.heat_share(speed * (1 + 1e-9), "capped") == pytest.approx(
                share, rel=1e-7
            )
    assert mean_run.heat_share(1e-9, "capped") == pytest.approx(
        KAPPA / (KAPPA + OTHER_KAPPA), rel=1e-4
    )
    curve = [mean_run.heat_share(v, "capped") for v in np.geomspace(1e-3, 1e3, 40)]
    assert np.all(np.diff(curve) > 0.0)
    assert curve[-1] < 1.0


def test_the_rounds_count_the_error_of_what_is_reported(tmp_path):
    scene = scene_with("mean", count=12)  # a whole first round
    run = rs.run(scene, tmp_path / "run")
    alone = run.simulated().estimate("flash_temperature", all_heat=True)
    errors = [
        np.max(found.total_error[1:] / found.mean[1:])
        for found in (run.estimate("flash_temperature"), alone)
    ]
    assert abs(errors[0] / errors[1] - 1.0) > 0.02
    between = float(np.sqrt(errors[0] * errors[1]))
    run = rs.run(scene, tmp_path / "run", until={"flash_temperature": between})
    assert run.target_met == (errors[0] < errors[1])
    assert run.rounds.verdict.errors["flash_temperature"] == pytest.approx(errors[0], rel=1e-9)


def test_a_contact_temperature_has_the_background_of_the_same_share(tmp_path):
    scene = scene_with("mean").with_("sliding.duration", 1e-5)
    run = rs.run(scene, tmp_path / "run", max_realizations=3)
    rows = rs.compare(run).rows
    for k, speed in enumerate(SPEEDS[1:], 1):
        warm = background.temperature(
            1e-5, heat_flux=0.11 * 9e7 * speed, conductivity=KAPPA, diffusivity=D
        )
        row = next(r for r in rows if (r.observable, r.speed) == ("contact_temperature", speed))
        for level, column in enumerate(COLUMNS):
            share, temperature = by_hand(*moments(run, level))
            assert row.columns[column].mean == pytest.approx(
                temperature[k] + share[k] * warm, rel=1e-9
            )
            flash, of_share = (
                run.estimate(name, column) for name in ("flash_temperature", "heat_partition")
            )
            for part, error in flash.budget.items():
                if np.isfinite(error[k]):
                    found = run.contact_temperature(column).budget[part][k]
                    assert found == pytest.approx(
                        error[k] + float(warm) * of_share.budget[part][k], rel=1e-9
                    )


def test_the_page_names_the_share_of_each_column(mean_run, no_pictures):
    page = report.answer(rs.compare(mean_run))
    for name, share in {
        "theory": mean_run.heat_partition,
        **{c: mean_run.share(c) for c in COLUMNS},
    }.items():
        assert f"{share.min():.3g} to {share.max():.3g} ({name})" in page


def test_a_stated_share_is_that_of_all_columns(capped_run):
    for share in (
        capped_run.heat_partition,
        capped_run.share("smoothed"),
        capped_run.share("capped"),
    ):
        np.testing.assert_array_equal(share, 0.9)
    assert capped_run.share_text() == "0.9"
    assert not any(
        "both bodies in this contact" in note
        for note in capped_run.estimate("flash_temperature").notes
    )
