"""Curves of runs beside one another: values, errors, colours, and the file of their numbers."""

import csv

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.charts.style import CALIBRATED, COLOURS, THEORY


def curves(path):
    """The points of each curve by panel and name."""
    found = {}
    with path.open() as file:
        for row in csv.DictReader(file):
            point = (float(row["x"]), float(row["y"]), float(row["error"] or "nan"))
            found.setdefault((row["panel"], row["curve"]), []).append(point)
    return {name: np.array(points).T for name, points in found.items()}


@pytest.mark.parametrize(
    "observable", ["flash_temperature", "flash_gradient", "flash_laplacian", "heat_partition"]
)
@pytest.mark.usefixtures("drawn")
def test_a_curve_over_the_speed_has_the_means_with_their_errors(capped_run, tmp_path, observable):
    rs.plot(capped_run, observable, tmp_path / "a.svg", csv=tmp_path / "a.csv")
    found = curves(tmp_path / "a.csv")
    estimate = capped_run.estimate(observable, "capped")
    # shown in K, K/mm, K/µm² and 1; gradient and Laplacian with the other sign
    factor = {"flash_gradient": -1e-3, "flash_laplacian": -1e-12}.get(observable, 1.0)
    moving = np.array(capped_run.scene.speeds) > 0.0
    (name,) = [name for name in found if name[1] == f"{capped_run.folder.name}: capped"]
    speed, mean, error = found[name]
    np.testing.assert_allclose(speed, np.array(capped_run.scene.speeds)[moving])
    np.testing.assert_allclose(mean, factor * estimate.mean[moving], rtol=1e-6)
    np.testing.assert_allclose(error, abs(factor) * estimate.total_error[moving], rtol=1e-6)


def test_the_theories_of_one_run_have_their_colours_and_the_share(capped_run, drawn):
    rs.plot(capped_run, "flash_temperature", "a.png")
    (axes,) = drawn[0].axes
    colours = [line.get_color() for line in axes.lines]
    assert colours[:2] == [THEORY, CALIBRATED]
    assert {COLOURS["smoothed"], COLOURS["capped"]} <= set(colours[2:])
    speed, theory = axes.lines[0].get_data()
    exact = (
        0.9 * prediction.predictions(capped_run.scene)["flash_temperature"]
    )  # the share of the scene
    at = [list(speed).index(v) for v in capped_run.scene.speeds if v > 0.0]
    np.testing.assert_allclose(
        theory[at], exact[np.array(capped_run.scene.speeds) > 0.0], rtol=1e-12
    )


@pytest.fixture(scope="module")
def both(capped_run, sliding_run):
    return rs.compare(capped_run, sliding_run)


@pytest.mark.slow
def test_runs_side_by_side_have_a_colour_each(both, capped_run, sliding_run, drawn):
    both.chart("a.png")
    axes = drawn[0].axes[2]
    names = {line.get_gid(): line.get_color() for line in axes.lines if line.get_gid() != "marks"}
    own = {
        str(colour)
        for name, colour in names.items()
        if name.startswith(f"{capped_run.folder.name}:")
    }
    other = {
        str(colour)
        for name, colour in names.items()
        if name.startswith(f"{sliding_run.folder.name}:")
    }
    assert len(own) == len(other) == 1
    assert own != other
    assert (
        drawn[0].axes[4].get_title("left") == "(e) Hot-spot width (capped: at $q_c$)"
    )  # smoothed has its limit
    words = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert words[:2] == [capped_run.folder.name, sliding_run.folder.name]


@pytest.mark.slow
def test_the_table_of_several_runs_has_the_values_of_each(both, capped_run, sliding_run):
    table = both.table()
    titles = [column.title for column in table.columns]
    for run in (capped_run, sliding_run):
        for k, speed in enumerate(run.scene.speeds):
            (row,) = [row for row in table.rows if list(row[:2]) == [f"{speed:g}", run.folder.name]]
            assert str(row[titles.index("capped")]) == str(
                run.estimate("flash_temperature", "capped").number(k)
            )
    assert [run["run"] for run in both.to_dict()["runs"]] == [
        capped_run.folder.name,
        sliding_run.folder.name,
    ]
    frame = both.to_dataframe()
    assert set(frame["run"]) == {capped_run.folder.name, sliding_run.folder.name}


def test_the_cut_offs_of_a_run_stand_in_its_spectra(capped_run, drawn):
    rs.plot(capped_run, "psd", "a.png")
    (axes,) = drawn[0].axes
    cuts = {line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == ":"}
    assert cuts == {level.q_max for level in capped_run.numerics.levels}
    q, c = axes.lines[0].get_data()
    np.testing.assert_allclose(c, capped_run.scene.spectrum(q))
