"""Every ± that is printed is the total error of the estimate, and a ratio has every error of its two columns."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction, report
from roughsim.comparison.compare import comparison_table
from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import status_lines
from roughsim.estimate import cell_size
from roughsim.estimate import errors as est
from roughsim.estimate.ladder import Values
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.scene.numerics import Level, Numerics
from roughsim.show.markup import html_table
from roughsim.show.terminal import table_text

UNITS = {"K/m": 1e-3, "K/m^2": 1e-12, "m": 1e6, "Pa^2": 1e-18}


@pytest.fixture(scope="module")
def partial(capped_run, tmp_path_factory):
    """The first four of six realizations."""
    folder = shutil.copytree(capped_run.folder, tmp_path_factory.mktemp("partial") / "run")
    for path in (folder / "realizations").glob("*-00000[45].h5"):
        path.unlink()
    return rs.open_run(folder)


def as_printed(mean, error, unknown):
    """Mean and error to the second digit of the error, by decimal arithmetic."""
    places = 1 - int(f"{error:.1e}".split("e")[1])
    digits = [f"{round(x, places):.{max(places, 0)}f}" for x in (mean, error)]
    return (" ± ≥" if unknown else " ± ").join(digits)


def expected(run, factors):
    """What is printed of each observable, column and speed, unless it takes a power of ten or is zero."""
    for name, record in OBSERVABLES.items():
        for column in run.numerics.columns:
            found, factor = run.estimate(name, column), factors.get(record.unit, 1.0)
            for k, mean in enumerate(found.mean * factor):
                error = found.total_error[k] * factor
                if 1e-3 <= max(abs(mean), error) < 1e5 and np.isfinite(error) and error > 0.0:
                    missing = any(np.isnan(part[k]) for part in found.budget.values())
                    yield as_printed(mean, error, missing)


@pytest.fixture(scope="module")
def at_rest(capped_scene, tmp_path_factory):
    """Two realizations at rest and in motion, on a grid and on one with half the pixel."""
    levels = tuple(Level("capped", (n, n), 2e4) for n in (32, 64))
    numerics = Numerics(levels, (2e-3, 2e-3))
    return rs.run(
        capped_scene, tmp_path_factory.mktemp("rest") / "run", numerics=numerics, max_realizations=2, workers=1
    )


def test_at_rest_nothing_heats_and_that_is_exact(at_rest):
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        found = at_rest.estimate(name)
        assert (found.mean[0], found.total_error[0], found.unknown_at(0)) == (0.0, 0.0, ())
        assert found.total_error[1] > 0.0
    assert at_rest.estimate("flash_temperature").explain().splitlines()[1].startswith("0 K: ")


def test_a_run_of_a_rough_surface_is_continued_with_its_own_exponent(capped_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(prediction, "yielded_fall", lambda *_: None)
    rough = replace(capped_scene, surface=replace(capped_scene.surface, hurst=0.3, q_max=1e7))
    levels = tuple(Level("capped", (n, n), 1e3 * n) for n in (48, 96))
    run = rs.run(rough, tmp_path / "run", numerics=Numerics(levels, (2e-3, 2e-3)), max_realizations=2, workers=1)
    np.testing.assert_allclose(run.values("flash_temperature").exponent, 0.3 + 1.05 * 0.3, rtol=1e-9)


def test_the_table_prints_total_errors(partial):
    cells = {str(cell) for row in comparison_table(rs.compare(partial)).rows for cell in row}
    wanted = set(expected(partial, UNITS))
    assert len(wanted) > 30
    assert wanted <= cells
    assert any("≥" in text for text in wanted)  # one cut-off tells of no pixel


def test_the_table_prints_the_total_errors_of_ratios(partial):
    comparison = rs.compare(partial)
    table = comparison_table(comparison)
    (cells,) = (table.cells(k) for k, column in enumerate(table.columns) if column.title == "capped_over_smoothed")
    student = 3.1824463 * np.sqrt(1 + 2 / 3)  # four realizations
    found = [partial.estimate("flash_temperature", column) for column in ("smoothed", "capped")]
    rows = [(n, row) for n, row in enumerate(comparison.rows) if row.observable == "flash_temperature" and row.speed]
    for n, row in rows:
        k, ratio = comparison.run.scene.speeds.index(row.speed), row.ratios["capped_over_smoothed"]
        systematic = [e.budget[part][k] / e.mean[k] for e in found for part in ("bandwidth", "pixel", "size", "solver")]
        relative = np.sqrt((student * ratio.standard_error / ratio.value) ** 2 + np.nansum(np.square(systematic)))
        assert ratio.total_error == pytest.approx(relative * ratio.value, rel=1e-6)
        assert cells[n] == as_printed(ratio.value, relative * ratio.value, np.isnan(systematic).any())


def test_the_page_prints_total_errors(partial):
    page = html_table(comparison_table(rs.compare(partial))) + report.errors_section(partial)
    shown = set(re.findall(r">([^<>]+ ± [^<>]+)</td>", page))
    assert {text.replace("-", "−") for text in expected(partial, UNITS)} <= shown


def test_status_and_the_budget_of_explore_print_total_errors(partial):
    found = partial.estimate("flash_temperature")
    moving = [as_printed(found.mean[k], found.total_error[k], found.unknown_at(k)) for k in (1, 2)]
    lines = status_lines(partial)
    budget = table_text(budget_table(partial, "capped"))
    for text in moving:
        assert any(line.startswith(f"{text} K: statistical") for line in lines)
        assert f" {text} " in budget
    assert all("±" not in line or " K: statistical" in line for line in lines)


def test_one_realization_has_an_unknown_error_and_no_infinite_one(partial, tmp_path):
    folder = shutil.copytree(partial.folder, tmp_path / "run")
    for path in (folder / "realizations").glob("*-00000[123].h5"):
        path.unlink()
    told = "\n".join(status_lines(rs.open_run(folder)))
    assert "± unknown K" in told
    assert "inf" not in told


def column(rng, mean, scatter, bandwidth, pixel, n=40):
    rows = mean * (1.0 + scatter * rng.standard_normal((n, 1)))
    none = np.zeros(n, dtype=np.intp)
    return Values(rows, rows, rows, none, np.array([np.nan]), np.array([bandwidth]), np.array([pixel]))


def test_a_ratio_has_the_errors_of_both_columns_but_for_the_scatter_that_they_share():
    rng = np.random.default_rng(8)
    below = column(rng, 4.0, 0.1, bandwidth=0.04, pixel=0.08)  # 1 and 2 %
    above = below._replace(
        **{key: 0.5 * getattr(below, key) for key in ("extrapolated", "finest", "base")},
        bandwidth=np.array([0.04]),  # 2 %
        pixel=np.array([0.0]),
    )
    found = est.quotient(above, below, size=0.003, solver=2e-4)
    mean = below.extrapolated.mean()
    assert found.mean[0] == pytest.approx(0.5)
    assert found.standard_error[0] < 1e-12
    assert found.budget["bandwidth"][0] == pytest.approx(0.5 * np.hypot(0.04 / (0.5 * mean), 0.04 / mean))
    assert found.budget["pixel"][0] == pytest.approx(0.5 * 0.08 / mean)
    assert found.budget["size"][0] == pytest.approx(0.5 * 0.003)
    assert found.budget["solver"][0] == pytest.approx(0.5 * 2e-4 * np.sqrt(2))
    parts = [found.budget[key][0] for key in ("statistical", "bandwidth", "pixel", "size", "solver")]
    assert found.total_error[0] == pytest.approx(np.sqrt(np.sum(np.square(parts))))


def test_a_ratio_to_the_theory_of_the_same_modes_has_no_bandwidth_error():
    above = column(np.random.default_rng(8), 4.0, 0.1, bandwidth=np.nan, pixel=0.08)
    found = est.quotient(above, np.array([2.0]), size=np.array([0.01]))
    assert found.budget["bandwidth"][0] == 0.0
    assert found.unknown_at(0) == ()
    assert found.budget["pixel"][0] == pytest.approx(0.04)
    assert found.budget["size"][0] == pytest.approx(0.01 * found.mean[0])


def test_what_one_column_does_not_know_the_ratio_does_not_know():
    rng = np.random.default_rng(8)
    above, below = column(rng, 4.0, 0.1, np.nan, 0.08), column(rng, 2.0, 0.1, 0.02, 0.08)
    for pair in ((above, below), (below, above)):
        assert est.quotient(*pair).unknown_at(0) == ("bandwidth",)
    assert est.quotient(below, np.ones(1), scanned=True).unknown_at(0) == ("scan",)


def test_a_ratio_to_a_sum_that_is_no_measure_of_the_theory_says_so(capped_run, monkeypatch):
    from roughsim import prediction

    true = prediction.mode_sums
    monkeypatch.setattr(prediction, "mode_sums", lambda *a: {k: 1.5 * v for k, v in true(*a).items()})
    row = [row for row in rs.compare(capped_run).rows if row.observable == "flash_temperature"][-1]
    ratio = row.ratios["smoothed_over_theory"]
    assert ratio.total_error / ratio.value > 0.45
    apart = row.theory_same_modes / row.theory_at_cut_off - 1
    size = np.hypot(apart, cell_size.size_error(capped_run.scene, capped_run.numerics.lengths))
    assert ratio.total_error / ratio.value >= size


def test_what_is_exactly_zero_or_undefined_has_no_unknown_error():
    means = np.array([0.0, 2.0, np.nan])
    found = est.Uncertain(means, means, {"statistical": np.array([0.0, 0.3, 0.0]), "scan": np.full(3, np.nan)})
    assert [found.unknown_at(k) for k in range(3)] == [(), ("scan",), ()]
    np.testing.assert_array_equal(found.total_error, [0.0, 0.3, np.nan])
