"""Figures as a journal wants them: size, pixels, no title, and a file of the numbers that are drawn."""

import csv
from itertools import pairwise

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure
from some_rows import some

import roughsim as rs
from roughsim.charts import style
from roughsim.charts.numbers import bare
from roughsim.charts.plot import CURVES, plot_run
from roughsim.charts.style import Look, new_figure, plain_ticks
from roughsim.cli import main
from roughsim.estimate.asked import ABOUT
from roughsim.estimate.errors import quantile


@pytest.mark.slow
def test_the_size_and_the_pixels_are_those_asked_for(capped_run, tmp_path):
    path = plot_run(capped_run, "pressure", tmp_path / "a.png", look=Look(size=(3.4, 2.6), dpi=300))
    assert matplotlib.image.imread(path).shape[:2] == (780, 1020)


def test_one_drawing_is_that_of_savefig(tmp_path, monkeypatch):
    for name in ("a.png", "b.png"):
        with new_figure(tmp_path / name, (6.0, 4.0), "a title") as figure:
            curves, field = figure.subplots(1, 2)
            curves.loglog([1.0, 1e5], [1e-3, 1e2], label="curve")
            curves.set(title="curves", xlabel="$x$", ylabel="a long label")
            curves.legend()
            figure.colorbar(field.imshow(np.eye(9)), ax=field)
        # which draws twice, first for the layout
        monkeypatch.setattr(style, "save", lambda figure, path: figure.savefig(path, dpi="figure"))
    a, b = (matplotlib.image.imread(tmp_path / name) for name in ("a.png", "b.png"))
    np.testing.assert_array_equal(a, b)


def test_a_figure_has_no_title_if_none_is_wanted(capped_run, drawn):
    plot_run(capped_run, "temperature", look=Look(title=False))
    plot_run(capped_run, "temperature")
    assert [bool(figure.get_suptitle()) for figure in drawn] == [False, True]


def test_the_points_of_a_map_are_written_with_their_places(capped_run, tmp_path):
    plot_run(capped_run, "heights", tmp_path / "a.svg", look=Look(csv=tmp_path / "a.csv"))
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "# h (µm); x (mm) in the first column; y (mm) in the first line"
    table = np.genfromtxt(lines[1:], delimiter=",")
    heights = next(capped_run.fields("heights"))[1]
    np.testing.assert_allclose(table[0, 1:], np.arange(128) * 2.0 / 128, rtol=1e-6)
    np.testing.assert_allclose(table[1:, 0], np.arange(128) * 2.0 / 128, rtol=1e-6)
    np.testing.assert_allclose(table[1:, 1:], heights * 1e6, rtol=1e-6)


def rows_of(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.usefixtures("drawn")
def test_a_curve_is_written_with_its_error_and_the_theory(capped_run, tmp_path):
    plot_run(capped_run, "correlation", tmp_path / "a.svg", look=Look(csv=tmp_path / "a.csv"))
    rows = rows_of(tmp_path / "a.csv")
    measured = [row for row in rows if row["curve"] == "measured"]
    assert {row["y_axis"] for row in rows} == {"g_σ (GPa²)"}
    assert {row["curve"] for row in rows} == {"measured", "theory, γ = 0.3"}
    r = np.array([float(row["x"]) for row in measured]) * 1e-6
    g, error = capped_run.correlation(r)
    np.testing.assert_allclose(
        [float(row["y"]) for row in measured], g * 1e-18, rtol=1e-5, atol=1e-8
    )
    student = np.array([float(row["error"]) for row in measured]) / (error * 1e-18)
    # six members of each of two levels: 5 to 10 degrees of freedom; x has 7 digits
    assert np.all(
        (student >= quantile(10.0) * (1 - 1e-4)) & (student <= quantile(5.0) * (1 + 1e-4))
    )


@pytest.mark.parametrize(
    "curve",
    some([name for name in CURVES if name not in ("snapshots", "sliding", "reaction", *ABOUT)], 2),
)
@pytest.mark.usefixtures("drawn")
def test_every_curve_has_numbers_and_names_of_its_axes(capped_run, tmp_path, curve):
    plot_run(capped_run, curve, tmp_path / "a.svg", look=Look(csv=tmp_path / "a.csv"))
    rows = rows_of(tmp_path / "a.csv")
    assert len(rows) > 100
    for row in rows:
        assert row["x_axis"]
        assert row["y_axis"]
        assert not set(row["x_axis"] + row["y_axis"] + row["curve"]) & set("$\\{}")


def test_formulas_become_plain_words():
    assert bare(r"$T_\mathrm{flash}$ (K)") == "T_flash (K)"
    assert bare(r"$\langle T\sigma\rangle/\langle\sigma\rangle$ (K)") == "⟨Tσ⟩/⟨σ⟩ (K)"


@pytest.mark.slow
def test_the_command_line_takes_them(capped_run, tmp_path, capsys):
    folder, picture, numbers = str(capped_run.folder), tmp_path / "a.png", tmp_path / "a.csv"
    words = [
        "plot",
        folder,
        "pressure",
        "-o",
        str(picture),
        "--no-title",
        "--size",
        "3.4x2.6",
        "--dpi",
        "100",
    ]
    with pytest.raises(SystemExit) as ended:
        main([*words, "--csv", str(numbers)])
    assert ended.value.code == 0
    assert matplotlib.image.imread(picture).shape[:2] == (260, 340)
    assert numbers.exists()
    for wrong, message in (
        (["--size", "wide"], "write width x height in inches"),
        (["--csv", "a.txt"], "end in .csv"),
    ):
        with pytest.raises(SystemExit) as ended:
            main([*words, *wrong])
        assert ended.value.code == 1
        assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("lowest", "ticks"), [(0.1, [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50]), (0.01, [0.01, 0.1, 1, 10])]
)
def test_the_ticks_of_more_than_three_decades_are_powers_of_ten(lowest, ticks):
    axes = Figure().subplots()
    axes.set(xscale="log", xlim=(lowest, 60.0))
    plain_ticks(axes.xaxis)
    places = axes.xaxis.get_majorticklocs()
    assert places[(places > 0.99 * lowest) & (places < 60.0)] == pytest.approx(ticks)


@pytest.mark.parametrize(("word", "speed"), [("9", 9.0), ("9 m/s", 9.0), ("36km/h", 10.0)])
def test_a_speed_on_the_command_line_may_have_a_unit(
    capped_run, tmp_path, monkeypatch, word, speed
):
    drawn = []
    monkeypatch.setattr(rs, "plot", lambda *words, **options: drawn.append(options["speed"]))
    with pytest.raises(SystemExit) as ended:
        main(["plot", str(capped_run.folder), "temperature", "--speed", word])
    assert ended.value.code == 0
    assert drawn == [speed]


@pytest.mark.parametrize(
    ("quantity", "count"),
    [
        pytest.param("correlation", 2, marks=pytest.mark.slow),
        pytest.param("spectrum", 2, marks=pytest.mark.slow),
        pytest.param("distribution", 3, marks=pytest.mark.slow),
    ],
)
def test_panels_of_a_narrow_figure_stand_below_one_another(capped_run, drawn, quantity, count):
    plot_run(capped_run, quantity, look=Look(size=(3.4, 2.6)))
    (figure,) = drawn
    assert tuple(figure.get_size_inches()) == (3.4, pytest.approx(2.6 * count))
    figure.draw_without_rendering()
    boxes = [axes.get_position() for axes in figure.axes[:count]]
    assert all(above.y0 > below.y1 for above, below in pairwise(boxes))
    assert all(box.width > 0.4 for box in boxes)
    assert max(map(len, figure.get_suptitle().splitlines())) < 90
