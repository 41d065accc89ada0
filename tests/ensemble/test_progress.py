"""The progress of a run: no time left before it can be told, and a reader that is gone stops nothing."""

import builtins
import errno
import io
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import roughsim as rs
from roughsim.ensemble import bar, progress
from roughsim.ensemble.bar import PatientConsole, Progress
from roughsim.ensemble.run import aimed


class Broken(io.StringIO):
    """A terminal that takes no more."""

    def __init__(self, number):
        super().__init__()
        self.number = number

    def write(self, text):
        raise OSError(self.number, "gone")


def lines(scene, folder, **options):
    console, said = PatientConsole(stderr=True), io.StringIO()
    console.file = said
    rs.run(scene, folder, observer=Progress(console).update, **options)
    return said.getvalue().splitlines()


def test_a_file_gets_a_line_for_each_round_with_errors_and_the_time_left(tmp_path):
    said = lines(rs.load_scene("demo"), tmp_path / "run", until={"flash_temperature": 0.008}, max_realizations=40)
    assert said
    for number, line in enumerate(said):
        words = rf"round {number + 2}: \d+ of \d+ members, flash_temperature total error [\d.]+ % \(target 0.8 %\), "
        assert re.fullmatch(words + r"about \d+ s of computing left", line)


def test_a_bar_that_was_drawn_just_now_is_not_drawn_again(quick, tmp_path, monkeypatch):
    console, drawn = PatientConsole(stderr=True), []
    console.quiet = True
    shown = Progress(console)
    monkeypatch.setattr(shown.bar, "update", lambda *_, **values: drawn.append(values["description"]))
    clock = iter(np.arange(0.0, 10.0, 0.06))
    monkeypatch.setattr(bar.time, "monotonic", lambda: next(clock))
    run = rs.run(quick, tmp_path / "run", max_realizations=2, until={})
    for _ in range(4):
        shown.update(run)
    assert len(drawn) == 2


def test_a_run_warns_in_the_form_of_every_verb(quick, tmp_path, capsys):
    progress.run_shown(aimed(quick, max_realizations=1), tmp_path / "run", 1)
    warned = [line for line in capsys.readouterr().err.splitlines() if "heat share" in line]
    assert [line.startswith("roughsim: warning: the heat share") for line in warned] == [True]


@pytest.mark.parametrize(
    ("number", "terminal"), [(errno.ENOSPC, True), (errno.ENOSPC, False), (errno.EPIPE, True), (errno.EPIPE, False)]
)
def test_a_terminal_that_takes_no_more_stops_no_run(quick, tmp_path, monkeypatch, number, terminal):
    console = PatientConsole(stderr=True)
    console.file = Broken(number)
    monkeypatch.setattr(PatientConsole, "is_terminal", terminal)
    monkeypatch.setattr(progress, "PatientConsole", lambda **_: console)
    run = progress.run_shown(aimed(quick, max_realizations=2), tmp_path / "run", 1)
    assert run.realizations == 2


class Cell:
    """Stands for what IPython shows below a cell of a notebook."""

    def __init__(self):
        self.shown = []

    def display(self, thing, display_id):
        assert display_id
        self.update(thing)
        return self

    def update(self, thing):
        self.shown.append(thing._repr_mimebundle_({}, {})["text/html"])


def test_a_notebook_shows_one_bar_and_still_calls_the_observer(quick, tmp_path, monkeypatch):
    cell, seen = Cell(), []
    monkeypatch.setattr(builtins, "get_ipython", lambda: SimpleNamespace(kernel=object()), raising=False)
    monkeypatch.setitem(sys.modules, "IPython.display", cell)
    rs.run(quick, tmp_path / "run", max_realizations=3, observer=lambda run: seen.append(run.realizations))
    assert seen == [1, 2, 3]
    assert "planning" in cell.shown[0]
    assert re.search(r"round 1: \d of 3 members", cell.shown[1])


def test_a_script_shows_no_bar(quick, tmp_path, capfd):
    rs.run(quick, tmp_path / "run", max_realizations=1)
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_workers_in_a_notebook_need_no_guard(quick, tmp_path):
    nbformat, client = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    cell = "import roughsim as rs\nrun = rs.run(rs.load_scene('scene.toml'), 'run', max_realizations=4, workers=2)\nrun"
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
    client.NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown, result = notebook.cells[0].outputs
    assert "round 1: " in shown["data"]["text/plain"]
    assert "<table>" in result["data"]["text/html"]
    assert rs.open_run(tmp_path / "run").realizations == 4


def test_a_notebook_shows_one_bar_over_the_points_of_a_study(quick, tmp_path, monkeypatch, capfd):
    cell = Cell()
    monkeypatch.setattr(builtins, "get_ipython", lambda: SimpleNamespace(kernel=object()), raising=False)
    monkeypatch.setitem(sys.modules, "IPython.display", cell)
    short = aimed(quick, max_realizations=2)
    rs.study(short, vary={"sliding.nominal_pressure": [5e7, 9e7]}, folder=tmp_path / "study")
    assert "planning 2 points" in cell.shown[0]
    assert "2 of 2 points finished" in cell.shown[-1]
    assert capfd.readouterr() == ("", "")  # all is in the cell
