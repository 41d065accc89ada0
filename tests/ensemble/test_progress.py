"""Progress of a run: its rounds, the time left, and outputs that are full or closed."""

import errno
import io
import re
import time
from contextlib import redirect_stderr
from dataclasses import replace
from types import SimpleNamespace

import pytest
from some_rows import some

import roughsim as rs
from roughsim.cli import main
from roughsim.ensemble.progress import Progress, StudyProgress, progress_text


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


@pytest.mark.slow
def test_a_file_gets_a_line_for_each_round_with_errors_and_the_time_left(tmp_path, capsys):
    options = {"until": {"flash_temperature": 0.008}, "max_realizations": 24}
    rs.run(rs.load_scene("demo"), tmp_path / "run", observer=Progress("planning").update, **options)
    said = capsys.readouterr().err.splitlines()
    assert said
    for number, line in enumerate(said):
        words = rf"0:00:\d\d round {number + 2}: \d+/\d+ members, error [\d.]+ % \(target 0.8 %\), \d+ s left"
        assert re.fullmatch(words, line)


@pytest.fixture(scope="module")
def long_run(tmp_path_factory):
    """A stand-in with the longest numbers of a run of days, and three targets."""
    members = SimpleNamespace(
        available=(1234, 56),
        spent=[(1234, 1234 * 90.0), (56, 56 * 90.0)],
        __len__=lambda: 1290,
    )
    return SimpleNamespace(
        members=members,
        needed=(2345, 67),
        total_errors={
            "flash_temperature": 0.011,
            "correlation_radius_10": 0.052,
            "contact_fraction": 0.06,
        },
        until={"flash_temperature": 0.01, "correlation_radius_10": 0.005, "contact_fraction": 0.05},
        rounds=SimpleNamespace(number=11, wanted=(2345, 67), verdict=object()),
        unknown_parts=lambda name: ["scan"] if name == "correlation_radius_10" else [],
        numerics=SimpleNamespace(levels=(None, None)),
    )


def test_the_line_of_a_long_run_fits_80_columns_beside_its_bar(long_run, monkeypatch):
    monkeypatch.setattr("roughsim.ensemble.status.work", lambda numerics, level: 1.0)
    text = progress_text(long_run)
    # the error most above its target, and (1111 + 11) members of 90 s
    assert text == "round 12: 1290/2412 members, error ≥5.2 % (target 0.5 %), 28 h 03 min left"
    assert len(text) < 75  # and a short bar


def test_a_run_warns_in_the_form_of_every_verb(quick, tmp_path, capsys):
    run_command(replace(quick, sliding=replace(quick.sliding, heat_partition="all")), tmp_path)
    warned = [line for line in capsys.readouterr().err.splitlines() if "heat_partition" in line]
    assert [line.startswith("roughsim: warning: sliding.heat_partition") for line in warned] == [
        True
    ]


@pytest.mark.parametrize("number", some([errno.ENOSPC, errno.EPIPE]))
@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_that_takes_no_more_stops_no_run(quick, tmp_path, number, terminal):
    with redirect_stderr(Broken(number, terminal)):
        run_command(quick, tmp_path)
    assert rs.open_run(tmp_path / "run").realizations == 2


def test_a_script_shows_no_bar(quick, tmp_path, capfd):
    rs.run(quick, tmp_path / "run", max_realizations=1, progress=False)
    assert capfd.readouterr() == ("", "")


def test_a_script_prints_a_line_after_each_silence_which_grows(monkeypatch, capsys):
    monkeypatch.setattr("roughsim.ensemble.progress.SILENCE", 0.1)
    with Progress("planning") as progress:  # without a count there is no line
        time.sleep(0.15)
        progress.show("0/4 members", 0.0, 0)
        time.sleep(0.85)  # lines after 0.1 s, 0.3 s and 0.7 s; the next would follow after 1.5 s
    said = capsys.readouterr().err.splitlines()
    assert said == ["0:00:00 0/4 members", "0:00:01 0/4 members"]
    time.sleep(0.7)
    assert capsys.readouterr().err == ""  # nothing after the end


@pytest.mark.slow
def test_a_run_of_a_script_is_not_silent(quick, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("roughsim.ensemble.progress.SILENCE", 0.01)
    rs.run(quick, tmp_path / "run", max_realizations=2)
    short = replace(quick, ensemble=replace(quick.ensemble, max_realizations=1))
    rs.study(short, vary={"sliding.nominal_pressure": [5e7]}, folder=tmp_path / "study")
    said = capsys.readouterr().err
    assert re.search(r"(?m)^0:00:\d\d round 1: \d+/\d+ members", said)
    rs.bench(quick, stages=["contact"], realizations=4)
    assert re.search(r"(?m)^0:00:\d\d contact: .* precision, tolerance ", capsys.readouterr().err)
    assert re.search(r"(?m)^0:00:\d\d (planning 1 points|0 of 1 points finished.*)$", said)


def test_a_target_error_is_that_of_the_flash_temperature(quick, tmp_path):
    changes = {"sliding.nominal_pressure": "80 MPa"}
    run = rs.run(
        quick,
        tmp_path / "run",
        changes=changes,
        target_error="30 %",
        max_realizations=2,
        progress=False,
    )
    assert run.until == {"flash_temperature": 0.3}
    assert run.scene.sliding.nominal_pressure == 8e7
    assert rs.plan(quick, "2 %").reasons == rs.plan(quick, 0.02).reasons


@pytest.mark.slow
def test_a_notebook_prints_a_line_for_each_round_and_its_workers_need_no_guard(quick, tmp_path):
    nbformat, client = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    cell = "import roughsim as rs\nrun = rs.run(rs.load_scene('scene.toml'), 'run', max_realizations=30, workers=2)\nrun"
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
    client.NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = notebook.cells[0].outputs
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream")
    assert "round 2: " in printed
    assert "<table>" in outputs[-1]["data"]["text/html"]
    assert rs.open_run(tmp_path / "run").realizations == 30


def test_a_study_prints_its_finished_points(quick, tmp_path, capsys):
    short = replace(quick, ensemble=replace(quick.ensemble, max_realizations=2))
    observer = StudyProgress(2).update
    rs.study(
        short,
        vary={"sliding.nominal_pressure": [5e7, 9e7]},
        folder=tmp_path / "study",
        observer=observer,
    )
    assert (
        capsys.readouterr()
        .err.splitlines()[-1][8:]
        .startswith("2 of 2 points finished; 2 realizations in ")
    )
