"""A run cut far below q_max: every output has the same number under the name theory, that over the whole spectrum."""

import csv
import json
import re

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

import roughsim as rs
from roughsim.charts import curves as chart
from roughsim.cli import app
from roughsim.comparison.tables import theory_dict
from roughsim.explore.content import theory_curves
from roughsim.scene import parse_scene
from roughsim.show.text import plain
from roughsim.studies.tables import study_table
from theory import flash

SPEED, SHARE, PRESSURE, GAMMA = 1.0, 0.9, 9e7, 0.4
SPECTRUM = rs.SelfAffineSpectrum.from_rms_height(9e-7, hurst=0.8, q_min=6350.0, q_max=2e5)
# μ, κ and D = κ/ρc of the body, and E* = E/(1 − ν²), as a rigid counterface does not give way
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30.0 / (7900.0 * 500.0)}
MODULUS = 200e9 / (1.0 - 0.3**2)
TEXT = f"""
title = "cut below its end"
[surface]
rms_height = 9e-7
hurst = 0.8
q_min = 6350
q_max = 2e5
[body]
youngs_modulus = 200e9
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = {PRESSURE}
friction_coefficient = 0.11
speed = {SPEED}
heat_partition = {SHARE}
duration = 1e-4
[theory]
gamma = {GAMMA}
[ensemble]
max_realizations = 3
[numerics]
lengths = [2e-3, 2e-3]
levels = [{{ column = "elastic", shape = [32, 32], q_max = 2e4 }}]
"""


def by_the_formula(q_max):
    """T_flash of the moving body, K, straight from Eq. (4) over C(q) up to q_max."""
    spectrum = SPECTRUM if q_max is None else SPECTRUM.truncated(q_max=q_max)
    load = {"effective_modulus": MODULUS, "nominal_pressure": PRESSURE, "gamma": GAMMA}
    return SHARE * float(flash.flash_temperature(SPEED, spectrum, **load, **HEAT))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return rs.study(
        parse_scene(TEXT),
        vary={"sliding.speed": [SPEED]},
        folder=tmp_path_factory.mktemp("cut") / "study",
    )


@pytest.fixture(scope="module")
def run(study):
    return rs.open_run(study.folder / "points" / study.points[0].name)


def printed(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.stdout


def theory_line(axes):
    """The first line of a chart over the speed, as a mapping."""
    return dict(zip(*axes.get_lines()[0].get_data(), strict=True))


def theory_of_curve(path):
    """The theory of T_flash at the speed of the scene in the numbers of a figure."""
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if row["panel"].endswith("Flash temperature")]
    (value,) = [
        row["y"] for row in rows if row["curve"].endswith(": theory") and float(row["x"]) == SPEED
    ]
    return float(value)


def in_file(path, group):
    with h5py.File(path) as whole:
        file = whole[group]
        columns = [text.decode() for text in file["column"]]
        return float(np.ravel(file["flash_temperature"][...])[columns.index("theory")])


def outputs(run, study, folder):
    """Yield the name of each output with what it has as theory of T_flash, in K."""
    comparison = rs.compare(run)
    yield "row", comparison.rows[0].theory
    yield "to_dict", comparison.to_dict()["rows"][0]["theory"]
    yield (
        "compare --json",
        json.loads(printed("compare", run.folder, "--json"))["rows"][0]["theory"],
    )
    yield "data frame", float(comparison.to_dataframe().loc["flash_temperature", "theory"])
    table = comparison.table()
    place = [column.title for column in table.columns].index("theory")
    yield "table", float(str(table.cells(place)[0]))
    yield (
        "compare",
        float(re.search(r"^ *1 +([\d.]+)", printed("compare", run.folder), re.M).group(1)),
    )
    everything = printed("compare", run.folder, "--all")
    yield (
        "compare --all",
        float(re.search(r"flash_temperature, K +1 +([\d.]+)", everything).group(1)),
    )
    several = printed("compare", study.folder)
    yield "compare STUDY", float(re.search(r"^1 +speed 1 m/s +([\d.]+)", several, re.M).group(1))
    yield "theory of Python", float(rs.theory(run.scene).flash_temperature[0])
    rs.plot(run, "flash_temperature", folder / "curve.svg", csv=folder / "curve.csv")
    yield "curve over the speed", theory_of_curve(folder / "curve.csv")
    rs.theory(run.scene).chart(folder / "theory.svg", csv=folder / "theory.csv")
    yield "figure of the theory", theory_of_curve(folder / "theory.csv")
    for ending in ("csv", "json"):
        printed("export", run.folder, "-o", folder / f"run.{ending}")
    with (folder / "run.csv").open() as file:
        kinds = [
            r
            for r in csv.DictReader(file)
            if (r["observable"], r["column"]) == ("flash_temperature", "theory")
        ]
    yield "CSV of a run", float(kinds[0]["value"])
    yield "JSON of a run", json.loads((folder / "run.json").read_text())["rows"][0]["value"]
    page = rs.report(run, folder / "run.html").read_text()
    yield (
        "report",
        float(re.search(r'<li class="theory"><span class="value">([\d.]+)', page).group(1)),
    )
    axes = Figure().subplots()
    entry = chart.Entry("run", run.scene, run, comparison.results)
    chart.draw_over_speed(axes, entry, "flash_temperature")
    yield "chart", theory_line(axes)[SPEED]
    yield (
        "theory",
        float(
            re.search(
                r"^ *1 +([\d.]+)", printed("theory", run.folder / "scene.toml", "--all"), re.M
            ).group(1)
        ),
    )
    yield (
        "theory --json",
        json.loads(printed("theory", run.folder / "scene.toml", "--json"))["flash_temperature"][0],
    )
    yield "theory in Python", theory_dict(run.scene)["flash_temperature"][0]
    speeds, values, _ = theory_curves(run)["flash_temperature"]
    yield "explore", float(np.interp(SPEED, speeds, values))
    printed("export", run.folder, "-o", folder / "run.h5")
    yield "HDF5", in_file(folder / "run.h5", "results")
    (row,) = [r for r in study.rows("flash_temperature") if r["column"] == "theory"]
    yield "tidy table of a study", row["value"]
    titles = [column.title for column in study_table(study).columns]
    yield "table of a study", float(str(study_table(study).cells(titles.index("theory, K"))[0]))
    with study.save(folder / "study.csv").open() as file:
        kinds = [
            r
            for r in csv.DictReader(file)
            if (r["observable"], r["column"]) == ("flash_temperature", "theory")
        ]
    yield "CSV of a study", float(kinds[0]["value"])
    rows = json.loads(study.save(folder / "study.json").read_text())["rows"]
    told = [
        r["value"]
        for r in rows
        if (r["observable"], r["column"]) == ("flash_temperature", "theory")
    ]
    yield "JSON of a study", told[0]
    yield "HDF5 of a study", in_file(study.save(folder / "study.h5"), "/")


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures", "drawn")
def test_every_output_has_the_same_theory_over_the_whole_spectrum(run, study, tmp_path):
    whole, cut = by_the_formula(None), by_the_formula(2e4)
    assert whole > 1.4 * cut  # else the outputs could not be told apart
    said = dict(outputs(run, study, tmp_path))
    assert len(said) == 25
    for where, value in said.items():
        assert value == pytest.approx(whole, rel=2e-3 if where == "explore" else 5e-4), (
            where
        )  # four digits are printed


def test_the_chart_of_a_study_has_the_theory_over_the_whole_spectrum(study, drawn):
    study.chart("study.svg")
    assert theory_line(drawn[0].axes[0])[SPEED] == pytest.approx(by_the_formula(None), rel=5e-4)


def test_the_ratio_is_to_the_sum_over_the_cells_own_modes_which_has_a_name_of_its_own(run):
    row = rs.compare(run).to_dict()["rows"][0]
    assert row["theory_same_modes"] == pytest.approx(
        by_the_formula(2e4), rel=0.03
    )  # modes of a finite cell
    raw = np.mean(
        [run.members[0, i].numbers["flash_temperature"][0] for i in range(3)]
    )  # all heat in the body
    ratio = row["elastic_over_theory"]["value"]
    assert ratio * row["theory_same_modes"] / SHARE == pytest.approx(raw, rel=0.01)
    frame = rs.compare(run).to_dataframe().loc["flash_temperature"]
    assert frame["theory_same_modes"] == row["theory_same_modes"]


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_no_output_has_a_third_name_for_the_theory(run, tmp_path):
    shown = [printed("compare", run.folder, "--json"), plain(str(rs.compare(run)))]
    shown.append(rs.report(run, tmp_path / "run.html").read_text())
    shown.append(" ".join(rs.compare(run).to_dataframe().columns))
    for text in shown:
        assert "full_spectrum" not in text
    names = {
        name
        for row in rs.compare(run).to_dict()["rows"]
        for name in row
        if name.startswith("theory")
    }
    assert names == {"theory", "theory_same_modes"}
