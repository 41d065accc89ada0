"""The progress of a run: no time left before it can be told, and a reader that is gone stops nothing."""

import errno
import io
import re

import pytest

import roughsim as rs
from roughsim.ensemble import progress, status
from roughsim.ensemble.progress import PatientConsole, Progress
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
