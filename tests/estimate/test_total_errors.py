"""Every ± that is printed is the total error of the estimate, and a ratio has every error of its two columns."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from stored_cases import split_members

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.tables import budget_table
from roughsim.estimate import cell_size
from roughsim.outputs import run_report as report
from roughsim.scene.numerics import Level, Numerics
from roughsim.show.markup import html_table
from roughsim.show.table import table_text

UNITS = {"K/m": 1e-3, "K/m^2": 1e-12, "m": 1e6, "Pa^2": 1e-18}


@pytest.fixture(scope="module")
def partial(capped_run, tmp_path_factory):
    """The first four of six realizations."""
    folder = shutil.copytree(capped_run.folder, tmp_path_factory.mktemp("partial") / "run")
    for path in (split_members(folder) / "members").glob("*-00000[45].h5"):
        path.unlink()
    return rs.open_run(folder)


def as_printed(mean, error, unknown):
    """Mean and error to the second digit of the error, by decimal arithmetic."""
    places = 1 - int(f"{error:.1e}".split("e")[1])
    digits = [f"{round(x, places):.{max(places, 0)}f}" for x in (mean, error)]
    return (" ± ≥" if unknown else " ± ").join(digits)


def expected(run, factors):
    """What is printed of each observable, column and speed, unless it takes a power of ten or is zero."""
    for name, record in run.observables.items():
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
        capped_scene,
        tmp_path_factory.mktemp("rest") / "run",
        numerics=numerics,
        max_realizations=2,
        workers=1,
    )


def test_at_rest_nothing_heats_and_that_is_exact(at_rest):
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian"):
        found = at_rest.estimate(name)
        assert (found.mean[0], found.total_error[0], found.unknown_at(0)) == (0.0, 0.0, ())
        assert found.total_error[1] > 0.0
    assert at_rest.estimate("flash_temperature").explain().splitlines()[1].startswith("0 K: ")


def test_a_run_of_a_rough_surface_is_continued_with_its_own_exponent(
    capped_scene, tmp_path, foretold
):
    foretold.exponent = None
    rough = replace(capped_scene, surface=replace(capped_scene.surface, hurst=0.3, q_max=1e7))
    levels = tuple(Level("capped", (n, n), 1e3 * n) for n in (48, 96))
    run = rs.run(
        rough,
        tmp_path / "run",
        numerics=Numerics(levels, (2e-3, 2e-3)),
        max_realizations=2,
        workers=1,
    )
    assert (
        f"p = {0.3 + 1.05 * 0.3:.2f}" in run.estimate("flash_temperature").explain()
    )  # 0.3 + 1.05 H


@pytest.mark.slow
def test_the_table_prints_total_errors(partial):
    cells = {str(cell) for row in rs.compare(partial).table().rows for cell in row}
    wanted = set(expected(partial, UNITS))
    assert len(wanted) > 30
    assert wanted <= cells
    assert any("≥" in text for text in wanted)  # one cut-off tells of no pixel


def test_the_table_prints_the_total_errors_of_ratios(partial):
    comparison = rs.compare(partial)
    table = comparison.table()
    (cells,) = (
        table.cells(k)
        for k, column in enumerate(table.columns)
        if column.title == "capped_over_smoothed"
    )
    found = [partial.estimate("flash_temperature", column) for column in ("smoothed", "capped")]
    rows = [
        (n, row)
        for n, row in enumerate(comparison.rows)
        if row.observable == "flash_temperature" and row.speed
    ]
    # four realizations of the lowest levels, paired, and four of a step: from 3 to 6 degrees of freedom
    most, least = 3.1824463 * np.sqrt(1 + 2 / 3), 2.4469119 * np.sqrt(1 + 2 / 6)
    for n, row in rows:
        k, ratio = comparison.run.scene.speeds.index(row.speed), row.ratios["capped_over_smoothed"]
        systematic = [
            e.budget[part][k] / e.mean[k]
            for e in found
            for part in ("bandwidth", "pixel", "size", "solver")
        ]
        statistical = np.sqrt(
            ratio.total_error**2 - np.nansum(np.square(systematic)) * ratio.mean**2
        )
        assert least < statistical / ratio.standard_error < most
        assert cells[n] == as_printed(ratio.mean, ratio.total_error, np.isnan(systematic).any())


def test_the_page_prints_total_errors(partial):
    page = html_table(rs.compare(partial).table()) + report.errors_section(partial)
    shown = set(re.findall(r">([^<>]+ ± [^<>]+)</td>", page))
    assert {text.replace("-", "−") for text in expected(partial, UNITS)} <= shown


def test_status_and_the_budget_of_explore_print_total_errors(partial):
    found = partial.estimate("flash_temperature")
    moving = [as_printed(found.mean[k], found.total_error[k], found.unknown_at(k)) for k in (1, 2)]
    lines = str(rs.status(partial)).splitlines()
    budget = table_text(budget_table(partial, "capped"))
    shares = found.total_error[1:] / found.mean[1:]
    assert shares[0] != shares[1]
    for text, share in zip(moving, shares, strict=True):
        assert any(text in line for line in lines) == (share == shares.max())
        assert f" {text} " in budget
    titled = [*moving, "mean ± total"]
    assert all("±" not in line or any(text in line for text in titled) for line in lines)


def test_one_realization_has_an_unknown_error_and_no_infinite_one(partial, tmp_path):
    folder = shutil.copytree(partial.folder, tmp_path / "run")
    for path in (folder / "members").glob("*-00000[123].h5"):
        path.unlink()
    told = str(rs.status(rs.open_run(folder)))
    assert "± unknown" in told
    assert "inf" not in told


def test_a_ratio_to_a_sum_that_is_no_measure_of_the_theory_says_so(capped_run, monkeypatch):

    true = prediction.mode_sums
    monkeypatch.setattr(
        prediction, "mode_sums", lambda *a: {k: 1.5 * v for k, v in true(*a).items()}
    )
    row = [row for row in rs.compare(capped_run).rows if row.observable == "flash_temperature"][-1]
    ratio = row.ratios["smoothed_over_theory"]
    assert ratio.total_error / ratio.mean > 0.45
    apart = row.theories["theory_same_modes"] / row.theories["theory_at_cut_off"] - 1
    size = np.hypot(apart, cell_size.size_error(capped_run.scene, capped_run.numerics.lengths))
    assert ratio.total_error / ratio.mean >= size
