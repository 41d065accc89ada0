"""The comparison: exact in full contact, complete, and honest about what it compares."""

import json
import warnings
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.levels import values_of
from roughsim.observables.catalogue import OBSERVABLES, UNITS, observables_of
from roughsim.observables.record import Observable
from roughsim.results.columns import columns_of
from roughsim.results.row import deviation
from roughsim.table import Estimate, concat

HEADINGS = {
    "observable",
    "speed",
    "theory",
    "theory_same_modes",
    "calibrated",
    "smoothed",
    "capped",
    "note",
}


@pytest.fixture(scope="module")
def table(capped_run):
    return rs.compare(capped_run)


def test_full_contact_is_exact_through_the_whole_chain(full_scene, tmp_path):
    # W = 1 and fixed amplitudes: every moment equals its mode sum, for every draw
    run = rs.run(full_scene, tmp_path / "full")
    checked = 0
    for row in rs.compare(run).rows:
        cell, ratio = row.columns["elastic"], row.ratios["elastic_over_theory"]
        if np.isnan(ratio.mean):  # 0/0: at rest, or no plastic area; or the theory says nothing
            assert row.speed == 0.0 or row.observable == "plastic_fraction" or np.isnan(row.theory)
            continue
        assert ratio.mean == pytest.approx(1.0, abs=1e-12), (row.observable, row.speed)
        assert cell.standard_error == 0.0
        assert deviation(ratio) == 0.0
        checked += 1
    assert checked >= 25


def test_two_realizations_are_enough_to_compare_and_one_is_not(full_scene, tmp_path):
    with pytest.raises(ValueError, match="has 1 sound realizations; a comparison needs at least 2"):
        rs.compare(rs.run(full_scene, tmp_path / "few", max_realizations=1))
    assert rs.compare(rs.run(full_scene, tmp_path / "few", max_realizations=2)).rows


def test_the_total_share_measured_in_full_contact_is_the_theory_to_rounding(full_scene, tmp_path):
    shares = {}
    for duration in (1e-6, 1e-3):
        sliding = replace(full_scene.sliding, heat_partition="total", duration=duration)
        scene = replace(full_scene, sliding=sliding)
        rows = [
            r
            for r in rs.compare(rs.run(scene, tmp_path / str(duration))).rows
            if r.observable == "heat_partition"
        ]
        for row in rows:
            assert row.columns["elastic"].mean == pytest.approx(
                row.theories["theory_same_modes"], rel=1e-10
            )
            assert row.ratios["elastic_over_theory"].mean == pytest.approx(1.0, abs=1e-10)
        shares[duration] = [row.theories["theory_same_modes"] for row in rows]
        told = [row.theory for row in rows]
        np.testing.assert_allclose(prediction.heat_partition(scene), told, rtol=1e-12)
    # long after the start the two backgrounds dominate: effusivities share the heat, κ₁ρ₁c₁ = 2 κ₂ρ₂c₂
    np.testing.assert_allclose(shares[1e-3], np.sqrt(2) / (1 + np.sqrt(2)), rtol=1e-2)
    assert max(shares[1e-6]) < 0.6  # without the backgrounds it is 2/3 at rest and more at speed


def test_at_rest_there_is_no_heat_but_a_width_and_a_share(table):
    resting = {row.observable: row for row in table.rows if row.speed == 0.0}
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        assert resting[name].columns["capped"].mean == resting[name].theory == 0.0
        assert np.isnan(resting[name].ratios["smoothed_over_theory"].mean)
    assert (
        resting["slope_length"].columns["capped"].mean == resting["slope_length"].theory == np.inf
    )
    assert resting["heat_partition"].columns["smoothed"].mean == pytest.approx(0.5)  # equal bodies
    assert 1e-6 < resting["flash_width"].columns["smoothed"].mean < 1e-4


def test_the_table_has_every_observable_at_every_speed(table, capped_scene):
    per_speed = {
        "flash_temperature",
        "flash_gradient",
        "flash_laplacian",
        "flash_width",
        "slope_length",
        "heat_partition",
    }
    names = observables_of()
    expected = [
        (name, speed)
        for name in names
        for speed in (capped_scene.speeds if name in per_speed else (None,))
    ]
    assert [(row.observable, row.speed) for row in table.rows] == expected


def test_its_json_has_the_keys_programs_rely_on(table):
    told = json.loads(json.dumps(table.to_dict()))
    assert (told["realizations"], told["failed"]) == (6, 0)
    for row in told["rows"]:
        assert set(row) == HEADINGS | {"smoothed_over_theory", "capped_over_smoothed"}
        assert set(row["capped"]) == {"mean", "standard_error", "bias", "total_error", "unknown"}
        assert set(row["smoothed_over_theory"]) == {
            "value",
            "standard_error",
            "z",
            "total_error",
            "unknown",
        }
        assert row["note"] in ("", "identity", "at q_c")


def test_what_has_no_limit_is_marked(table):
    notes = {row.observable: row.note for row in table.rows}
    assert notes["flash_laplacian"] == notes["flash_width"] == notes["slope_length"] == "at q_c"
    assert notes["flash_temperature"] == ""


def test_force_balance_is_marked_where_all_has_yielded(tmp_path):
    from dataclasses import replace

    scene = rs.load_scene("demo")
    small = replace(
        scene,
        numerics=replace(
            scene.numerics,
            lengths=(2e-3, 2e-3),
            levels=(
                {"column": "smoothed", "shape": [32, 32], "q_max": 4e4},
                {"column": "capped", "shape": [64, 64], "q_max": 9e4},
            ),
        ),
    )
    table = rs.compare(rs.run(small, tmp_path / "run", max_realizations=3, until={}))
    notes = {row.observable: row.note for row in table.rows}
    assert (
        notes["contact_fraction"]
        == notes["plastic_fraction"]
        == notes["pressure_variance"]
        == "identity"
    )


def test_temperatures_carry_the_share_and_ratios_do_not(table, capped_run):
    row = next(r for r in table.rows if r.observable == "flash_temperature" and r.speed == 35.0)
    assert row.ratios["smoothed_over_theory"].mean == pytest.approx(
        row.columns["smoothed"].mean / row.theories["theory_same_modes"],
        rel=1e-4,  # the theory sees some 1e-5 of C_sm beyond the cut-off
    )
    assert row.columns["capped"].mean == pytest.approx(
        capped_run.estimate("flash_temperature").mean[2]
    )
    lowest, step = capped_run.samples("capped")
    fine, coarse, first = (
        sample.numbers["flash_temperature"].mean(axis=0)[2] for sample in (step, step.below, lowest)
    )
    assert row.columns["capped"].bias == pytest.approx(
        0.9 * first * fine / coarse - row.columns["capped"].mean
    )


def without(level, stream, i):
    """A level without its i-th surface, if they are of this stream."""

    def rest(sample):
        numbers = {name: np.delete(rows, i, axis=0) for name, rows in sample.numbers.items()}
        return replace(sample, rows=np.delete(sample.rows, i), numbers=numbers)

    if level.stream != stream:
        return level
    return replace(rest(level), below=level.below and rest(level.below))


def test_ratios_keep_the_pairing(table, capped_run):
    # each surface left out in turn, of the columns that have it; the variances of the two streams add
    def ratio(stream=None, i=0):
        samples = [
            [without(level, stream, i) for level in capped_run.samples(name)]
            for name in ("capped", "smoothed")
        ]
        scene = capped_run.scene
        above, below = (
            values_of(scene, name, "flash_temperature", of_column).value[2]
            for name, of_column in zip(("capped", "smoothed"), samples, strict=True)
        )
        return above / below

    streams = {level.stream: len(level.rows) for level in capped_run.samples("capped")}
    variance = sum(
        (n - 1) * np.var([ratio(stream, i) for i in range(n)]) for stream, n in streams.items()
    )
    row = next(r for r in table.rows if r.observable == "flash_temperature" and r.speed == 35.0)
    assert row.ratios["capped_over_smoothed"].mean == pytest.approx(ratio(), rel=1e-12)
    assert row.ratios["capped_over_smoothed"].standard_error == pytest.approx(
        np.sqrt(variance), rel=0.1
    )


def test_the_cell_makes_both_columns_of_a_ratio_uncertain(capped_run):
    both = [capped_run.estimate("flash_temperature", column) for column in ("capped", "smoothed")]
    relative = [
        estimate.budget["size"][1:] / estimate.mean[1:] for estimate in both
    ]  # the first speed is rest
    ratio = columns_of(capped_run)["capped_over_smoothed"]("flash_temperature")
    assert np.min(relative) > 0.0
    np.testing.assert_allclose(
        ratio.budget["size"][1:] / ratio.mean[1:], np.hypot(*relative), rtol=1e-9
    )


def test_theory_stands_beside_the_whole_spectrum(table):
    from theory import flash, plasticity

    scene = table.run.scene
    smooth = plasticity.smoothed_spectrum(
        scene.spectrum,
        effective_modulus=1.0 / (2 * 0.91 / 200e9),
        nominal_pressure=9e7,
        penetration_hardness=1e9,
    )
    whole = flash.flash_temperature(
        35.0,
        smooth,
        effective_modulus=1.0 / (2 * 0.91 / 200e9),
        nominal_pressure=9e7,
        friction_coefficient=0.11,
        conductivity=30.0,
        diffusivity=30.0 / (7900 * 500),
        gamma=0.3,
    )
    row = next(r for r in table.rows if r.observable == "flash_temperature" and r.speed == 35.0)
    assert row.theory == pytest.approx(0.9 * whole, rel=1e-9)
    assert row.theories["theory_same_modes"] == pytest.approx(
        row.theory, rel=0.02
    )  # modes of a finite cell


def with_theories(table, **theories):
    """Return a comparison with other theories of T_flash, each over the speeds of its run."""
    speeds = {"speed": np.array(table.run.scene.speeds)}
    values = {
        name: Estimate.of("flash_temperature", "K", np.broadcast_to(x, 3), speeds)
        for name, x in theories.items()
    }
    pieces = {(k,): one for k, one in enumerate(values.values())}

    class WithTheories(type(table)):
        flash = concat(pieces, {"column": np.array([*values])})

    return WithTheories(table.run)


def test_what_measured_values_and_theory_do_not_have_in_common_is_told_with_its_cause(table):
    def notes(summed, cut, whole):
        theories = {"theory": whole, "theory_same_modes": summed, "theory_at_cut_off": cut}
        return with_theories(table, **{name: (0.0, 0.0, x) for name, x in theories.items()}).notes()

    assert notes(1.0, 1.0, 1.019) == notes(1.019, 1.0, 1.0) == ()
    (cut,) = notes(0.7, 0.7, 1.0)
    assert "C(q) is cut at q_c = 5e+04 rad/m, below q_max = 2e+05 rad/m" in cut
    assert "Up to q_c the theory is 0.7 instead of 1 K (flash_temperature at 35 m/s)" in cut
    assert "waves" not in cut  # the cell is not to blame
    (short,) = notes(1.48, 1.0, 1.0)
    assert "too few long waves" in short
    assert "1.48 instead of 1 K" in short
    assert len(notes(1.48, 0.7, 1.0)) == 2
    assert (
        notes(0.0, 0.0, 0.0) == notes(np.nan, np.nan, np.nan) == ()
    )  # at rest, or without a theory


def test_the_speed_at_which_two_theories_differ_most_is_named(table):
    for speed, whole in ((35.0, (1.0, 1.25, 2.0)), (0.1, (1.0, 2.0, 1.25))):
        theories = {"theory": whole, "theory_same_modes": 1.0, "theory_at_cut_off": 1.0}
        (note,) = with_theories(table, **theories).notes()
        assert f"1 instead of 2 K (flash_temperature at {speed:g} m/s)" in note


def test_z_counts_standard_errors_from_one():
    def z(value, error):
        exact = Estimate.of("flash_temperature", "K", value, {})
        return deviation(replace(exact, standard_error=np.array(error)))

    assert z(1.3, 0.1) == pytest.approx(3.0)
    assert z(1.0, 0.0) == 0.0
    assert z(1.1, 0.0) == float("inf")


def test_one_realization_is_not_compared(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    with pytest.raises(ValueError, match="has 1 sound realizations; a comparison needs at least 2"):
        rs.compare(run)


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
@pytest.mark.slow
def test_the_chart_is_drawn(table, tmp_path, ending):
    path = tmp_path / f"chart{ending}"
    table.chart(path)
    assert path.stat().st_size > 10_000


def test_the_short_table_says_over_which_modes_its_ratio_to_the_theory_is(table):
    words = " ".join(str(table).split())
    assert "The ratio to theory is over the modes of the cell, up to q_c." in words


@pytest.mark.parametrize(("lengths", "warned"), [(None, False), ((2e-4, 2e-4), True)])
def test_a_cell_without_the_longest_waves_is_warned_of_if_the_plan_did_not_choose_it(
    capped_run, lengths, warned
):
    run = copy(capped_run)
    run.scene = replace(run.scene, numerics=replace(run.scene.numerics, lengths=lengths))
    run.numerics = replace(run.numerics, lengths=(2e-4, 2e-4))
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        rs.compare(run).summary()
    assert any("q_min = " in str(one.message) for one in found) == warned


def test_other_endings_are_refused(table, tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.png, \.pdf, \.svg"):
        table.chart(tmp_path / "chart.bmp")


def test_the_calibrated_law_stands_after_theory_where_it_was_compared_with_contacts(table):
    from theory import flash, plasticity

    law = plasticity.stress_spectrum(
        table.run.scene.spectrum,
        effective_modulus=1.0 / (2 * 0.91 / 200e9),
        nominal_pressure=9e7,
        penetration_hardness=1e9,
    )
    heat = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500)}
    expected = 0.9 * flash.flash_temperature(
        35.0, stress_spectrum=law, nominal_pressure=9e7, **heat
    )
    told = {(row["observable"], row["speed"]): row["calibrated"] for row in table.to_dict()["rows"]}
    assert told["flash_temperature", 35.0] == pytest.approx(expected, rel=1e-9)
    assert told["plastic_fraction", None] == pytest.approx(law.plastic_fraction, rel=1e-9)
    nothing = {name for (name, _), value in told.items() if value is None}
    assert nothing == {
        *("flash_gradient", "flash_laplacian", "flash_width", "slope_length"),
        *("correlation_radius_10", "correlation_radius_0"),
    }
    shown = table.table()
    titles = [column.title for column in shown.columns]
    assert titles[2:6] == ["theory", "calibrated", "smoothed", "capped"]
    assert shown.cells(3)[2] == f"{expected:.4g}"
    # g_σ at the calibrated radius has fallen to half
    r = told["correlation_radius_50", None]
    near, far = prediction.calibrated_correlation(table.run.scene, np.array([0.0, r]))
    assert near == pytest.approx(told["pressure_variance", None], rel=1e-9)
    assert far == pytest.approx(0.5 * near, rel=1e-6)


def test_what_no_member_has_carries_no_note(capped_run, monkeypatch):
    """As an observable that is younger than the run."""
    younger = Observable(
        "younger", "1", values=lambda sample: np.full((len(sample.rows), 1), np.nan), limit=False
    )
    monkeypatch.setitem(OBSERVABLES, "younger", younger)
    monkeypatch.setitem(UNITS, "younger", "1")
    run = rs.open_run(capped_run.folder)
    run.scene = replace(
        run.scene, theory=replace(run.scene.theory, gamma=0.31)
    )  # one that nothing is remembered of
    (row,) = (row for row in rs.compare(run).rows if row.observable == "younger")
    assert all(np.isnan(cell.mean) for cell in row.columns.values())
    assert row.note == ""
