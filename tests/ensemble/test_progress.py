"""Progress of a run: its rounds, the time left, and outputs that are full or closed."""

import errno
import io
import re
from contextlib import redirect_stderr

import pytest

import roughsim as rs
from roughsim.cli import main
from roughsim.ensemble.progress import Progress
from roughsim.ensemble.run import aimed
from roughsim.studies.progress import StudyProgress


class Broken(io.StringIO):
    """A terminal that takes no more."""

    def __init__(self, number, terminal):
        super().__init__()
        self.number, self.terminal = number, terminal

    def isatty(self):
        return self.terminal

    def write(self, text):
        raise OSError(self.number, "gone")


def run_command(scene, folder):
    (folder / "scene.toml").write_text(scene.to_toml())
    words = [folder / "scene.toml", "-o", folder / "run", "--workers", 1, "--max", 2]
    with pytest.raises(SystemExit) as ended:
        main(["run", *map(str, words)])
    assert ended.value.code == 0


def test_a_file_gets_a_line_for_each_round_with_errors_and_the_time_left(tmp_path, capsys):
    options = {"until": {"flash_temperature": 0.008}, "max_realizations": 40}
    rs.run(rs.load_scene("demo"), tmp_path / "run", observer=Progress("planning").update, **options)
    said = capsys.readouterr().err.splitlines()
    assert said
    for number, line in enumerate(said):
        words = rf"round {number + 2}: \d+ of \d+ members, flash_temperature total error [\d.]+ % \(target 0.8 %\), "
        assert re.fullmatch(words + r"about \d+ s of computing left", line)


def test_a_run_warns_in_the_form_of_every_verb(quick, tmp_path, capsys):
    run_command(quick, tmp_path)
    warned = [line for line in capsys.readouterr().err.splitlines() if "heat share" in line]
    assert [line.startswith("roughsim: warning: the heat share") for line in warned] == [True]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EPIPE])
@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_that_takes_no_more_stops_no_run(quick, tmp_path, number, terminal):
    with redirect_stderr(Broken(number, terminal)):
        run_command(quick, tmp_path)
    assert rs.open_run(tmp_path / "run").realizations == 2


def test_a_script_shows_no_bar(quick, tmp_path, capfd):
    rs.run(quick, tmp_path / "run", max_realizations=1)
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_a_notebook_prints_a_line_for_each_round_and_its_workers_need_no_guard(quick, tmp_path):
    nbformat, client = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    cell = (
        "import roughsim as rs\nrun = rs.run(rs.load_scene('scene.toml'), 'run', max_realizations=30, workers=2)\nrun"
    )
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
    client.NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = notebook.cells[0].outputs
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream")
    assert "round 2: " in printed
    assert "<table>" in outputs[-1]["data"]["text/html"]
    assert rs.open_run(tmp_path / "run").realizations == 30


def test_a_study_prints_its_finished_points(quick, tmp_path, capsys):
    short = aimed(quick, max_realizations=2)
    observer = StudyProgress(2).update
    rs.study(short, vary={"sliding.nominal_pressure": [5e7, 9e7]}, folder=tmp_path / "study", observer=observer)
    assert capsys.readouterr().err.splitlines()[-1].startswith("2 of 2 points finished; 2 realizations in ")
