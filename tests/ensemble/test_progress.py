"""The progress of a run: no time left before it can be told, and a reader that is gone stops nothing."""

import errno
import io
import re
import sys
from types import SimpleNamespace

import pytest

import roughsim as rs
from roughsim.ensemble import progress, status
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


def test_the_time_left_is_told_from_the_twelfth_realization_on(quick, tmp_path):
    told = lines(quick, tmp_path / "run", until={"flash_temperature": 0.001}, max_realizations=15)
    counts = [int(line.split()[0]) for line in told]
    assert min(counts) < 12 < max(counts)
    for count, line in zip(counts, told, strict=True):
        if count < 12:
            assert line.endswith("time left not known yet")
            assert "how many the target takes shows after" in line
            assert not re.search(r"\d s left", line)
        else:
            assert re.search(r"of about 15 realizations.*, \d+ s left$", line)


def test_a_run_warns_in_the_form_of_every_verb(quick, tmp_path, capsys):
    progress.run_shown(aimed(quick, max_realizations=1), tmp_path / "run", 1)
    warned = [line for line in capsys.readouterr().err.splitlines() if "heat share" in line]
    assert [line.startswith("roughsim: warning: the heat share") for line in warned] == [True]


def test_without_a_target_the_time_left_is_told_at_once(quick, tmp_path):
    told = lines(quick, tmp_path / "run", until={}, max_realizations=5)
    assert all(re.fullmatch(r"\d of about 5 realizations, \d+ s left", line) for line in told)


def test_no_line_says_infinity(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(status, "relative_half_width", lambda _: float("inf"))
    told = lines(quick, tmp_path / "run", until={"flash_temperature": 0.001}, max_realizations=15)
    assert told
    assert not any("inf" in line or re.search(r"\d s left", line) for line in told)
    assert all(line.endswith("time left not known yet") for line in told)


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
    kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    monkeypatch.setitem(sys.modules, "IPython.display", cell)
    rs.run(quick, tmp_path / "run", max_realizations=3, observer=lambda run: seen.append(run.realizations))
    assert seen == [1, 2, 3]
    assert "planning" in cell.shown[0]
    assert [re.search(r"(\d) of about 3 realizations", html)[1] for html in cell.shown[1:]] == ["1", "2", "3"]


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
    bar, result = notebook.cells[0].outputs
    assert "4 of about 4 realizations" in bar["data"]["text/plain"]
    assert "<table>" in result["data"]["text/html"]
    assert rs.open_run(tmp_path / "run").realizations == 4


def test_a_notebook_shows_one_bar_over_the_points_of_a_study(quick, tmp_path, monkeypatch, capfd):
    cell = Cell()
    kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    monkeypatch.setitem(sys.modules, "IPython.display", cell)
    short = aimed(quick, max_realizations=2)
    rs.study(short, vary={"sliding.nominal_pressure": [5e7, 9e7]}, folder=tmp_path / "study")
    assert "planning 2 points" in cell.shown[0]
    assert "2 of 2 points finished" in cell.shown[-1]
    assert capfd.readouterr() == ("", "")  # all is in the cell
