"""Where a run stands: how many realizations the targets take, how long that is, and what people are told."""

import os
import shutil
import time
from dataclasses import replace
from math import inf

import numpy as np
import pytest

import roughsim as rs
from roughsim.ensemble import status
from roughsim.estimate.errors import relative_half_width
from roughsim.show.text import clock
from roughsim.store.member_files import member_path


def opened(folder):
    run = rs.open_run(folder)
    run.max_realizations = 10
    return run


@pytest.fixture
def running(capped_run, tmp_path):
    """Six realizations of ten, each member ten seconds after the last one; nobody writes."""
    shutil.copytree(capped_run.folder, tmp_path / "run")
    run = rs.open_run(tmp_path / "run")
    now = time.time()
    paths = [member_path(run.folder, level, index) for level, index in sorted(run.members, key=lambda m: m[1])]
    for k, path in enumerate(reversed(paths)):
        os.utime(path, (now - 30 - 10 * k,) * 2)
    return opened(run.folder)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.2, "0 s"), (59.4, "59 s"), (60, "1 min 00 s"), (185, "3 min 05 s"), (7200, "120 min 00 s")],
)
def test_time_is_told_in_minutes_and_seconds(seconds, words):
    assert clock(seconds) == words


def test_without_a_target_all_realizations_are_needed(running):
    assert status.realizations_needed(running) == 10


def test_a_third_of_the_half_width_takes_nine_times_the_realizations(running):
    running.max_realizations = 1000
    width = relative_half_width(running.values("flash_temperature"))
    running.until = {"flash_temperature": width / 3}
    assert status.realizations_needed(running) == 54
    running.until = {"flash_temperature": width / 3, "contact_fraction": 10.0}  # the harder one counts
    assert status.realizations_needed(running) == 54
    running.max_realizations = 40
    assert status.realizations_needed(running) == 40
    running.until = {"flash_temperature": 2 * width}
    assert status.realizations_needed(running) == 12  # fewer are no estimate


def test_a_half_width_that_nothing_is_known_of_asks_for_a_first_estimate(running, monkeypatch):
    running.until = {"flash_temperature": 0.01}
    monkeypatch.setattr(status, "relative_half_width", lambda _: inf)
    running.max_realizations = 1000
    assert status.realizations_needed(running) == 12
    assert status.reached(running) == ""


def test_before_the_fourth_realization_twelve_are_expected(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=2, until={"flash_temperature": 0.01})
    run.max_realizations = 100
    assert status.realizations_needed(run) == 12
    assert status.reached(run) == ""


def test_the_time_left_is_the_pace_of_the_latest_members_times_those_missing(running):
    levels = len(running.numerics.levels)
    assert status.seconds_left(running) == pytest.approx(10 * levels * 4, rel=1e-3)


def test_there_is_no_pace_where_all_members_are_of_one_moment(running):
    for path in (running.folder / "realizations").iterdir():
        os.utime(path, (1e9, 1e9))
    running = opened(running.folder)
    assert status.seconds_left(running) is None
    assert not any("latest pace" in line for line in status.status_lines(running))


def test_a_running_run_tells_the_time_left_and_how_near_the_target_is(running, monkeypatch):
    monkeypatch.setattr(status, "writer", lambda _: "process 1 on here")
    width = relative_half_width(running.values("flash_temperature"))
    running.until = {"flash_temperature": width / 3}
    lines = status.status_lines(running)
    assert lines[0] == f"{running.folder}: small capped"
    near = f"flash_temperature statistical error {100 * width:.2g} % (target {100 * width / 3:g} %)"
    assert lines[1].startswith(f"6 of about 10 realizations: {near}; being computed by process 1 on here, ")
    assert lines[1].endswith(f"{clock(status.seconds_left(running))} left at the latest pace")
    monkeypatch.setattr(status, "writer", lambda _: None)
    assert f"{near}; not being computed now, " in status.state_line(running)


def test_a_finished_run_says_why_it_ended(running, monkeypatch):
    running.max_realizations = 6
    assert status.ended(running).startswith("all realizations are there")
    monkeypatch.setattr(type(running), "target_met", True)
    assert status.status_lines(running)[1] == f"6 realizations; finished: {status.ended(running)}"
    assert status.ended(running).startswith("the target of the statistical error is met")


def test_a_target_that_is_met_does_not_hide_what_is_unknown(running, monkeypatch):
    monkeypatch.setattr(type(running), "target_met", True)
    open_parts = {"bandwidth": np.full(3, np.nan), "pixel": np.full(3, np.nan)}
    found = running.estimate("flash_temperature")
    running.until = {"flash_temperature": 0.1}
    for parts, end in (({}, "is met"), (open_parts, "is met; the error by bandwidth, pixel is unknown")):
        known = replace(found, budget={"statistical": found.half_width} | parts)
        monkeypatch.setattr(type(running), "estimate", lambda _, name, known=known: known)
        assert status.ended(running).endswith(end)


def test_the_numbers_for_machines_are_those_of_the_estimates(running):
    told = status.status_dict(running)
    found = running.estimate("flash_temperature")
    assert (told["realizations"], told["needed"], told["failed"], told["writer"]) == (6, 10, 0, None)
    assert told["estimates"]["flash_temperature"]["mean"] == found.mean.tolist()
    assert told["estimates"]["flash_temperature"]["half_width"] == found.half_width.tolist()
    assert told["speed"] == [0.0, 0.1, 35.0]
