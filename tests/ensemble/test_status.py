"""Where a run stands: its round, the errors beside their targets, how long it will take, and why it has ended."""

import os
import re
import shutil
import socket
from dataclasses import replace

import numpy as np
import pytest
from stored_cases import member_path, split_members

import roughsim as rs
from roughsim.ensemble import status
from roughsim.estimate.rounds import Rounds, Verdict
from roughsim.results.description import read_description
from roughsim.results.run import Run
from roughsim.show.text import clock
from roughsim.store.claims import Claims

NEAR = ", flash_temperature total error 2.5 % (target 1 %)"
ERRORS = {"flash_temperature": 0.0251}


class Standing(Run):
    """A run whose progress a test sets."""

    def refresh(self):
        """Leave the rounds as they are."""


@pytest.fixture
def running(capped_run, tmp_path):
    """In the second round: six members of each level, of seven that it takes, and of ten, six and eight in the end."""
    shutil.copytree(capped_run.folder, tmp_path / "run")
    run = Standing(
        tmp_path / "run", read_description(capped_run.folder), capped_run.scene, "refuse"
    )
    Run.refresh(run)
    run.rounds = Rounds((6, 6, 6), 1, Verdict(False, (7, 7, 7), (10, 6, 8), "statistical", ERRORS))
    run.until = {"flash_temperature": 0.01}
    return run


def ended(run, *, met, why, errors=ERRORS):
    run.rounds = Rounds((6, 6, 6), 1, Verdict(met, None, (6, 6, 6), why, errors))


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.2, "0 s"),
        (59.4, "59 s"),
        (60, "1 min 00 s"),
        (185, "3 min 05 s"),
        (100_980, "28 h 03 min"),
    ],
)
def test_time_is_given_in_two_units_at_most(seconds, words):
    assert clock(seconds) == words


def test_a_run_in_progress_has_its_round_its_errors_and_the_time_left(running, soon):
    lines = str(rs.status(running)).splitlines()
    assert lines[0] == f"{running.folder}: small capped"
    left = f"about {clock(status.seconds_left(running))} of computing left"
    assert (
        lines[1]
        == f"6 realizations, round 2: 18 of 21 members{NEAR}; not being computed now, {left}"
    )
    with Claims(running.folder):
        process = f"process {os.getpid()} on {socket.gethostname()}"
        assert f"{NEAR}; being computed by {process}, {left}" in status.state_line(running)


def test_the_time_left_is_the_members_still_needed_times_the_mean_time_of_their_level(running):
    means = [running.members.seconds(level).mean() for level in range(3)]
    assert all(mean > 0 for mean in means)
    assert status.seconds_left(running) == pytest.approx(4 * means[0] + 0 * means[1] + 2 * means[2])


def test_the_time_of_a_level_without_members_follows_from_its_work(running):
    for index in range(6):
        del running.members[2, index]
    running.members.available[2], running.members.spent[2] = 0, (0, 0.0)
    means = [running.members.seconds(level).mean() for level in range(2)]
    works = [status.work(running.numerics, level) for level in range(3)]
    expected = 8 * works[2] * (means[0] + means[1]) / (works[0] + works[1])
    assert status.seconds_left(running) == pytest.approx(4 * means[0] + expected)


def test_before_the_first_round_is_complete_neither_errors_nor_the_time_left_are_known(
    quick, tmp_path
):
    run = rs.run(quick, tmp_path / "run", max_realizations=14, until={"flash_temperature": 0.01})
    member_path(split_members(run.folder), 0, 11).unlink()
    run = rs.open_run(run.folder)
    assert status.seconds_left(run) is None
    assert run.total_errors == {}
    assert run.needed == (12,)
    line = status.state_line(run)
    assert line.endswith(
        ", round 1: 11 of 12 members; not being computed now, time left not known yet"
    )
    # a lost member in the middle is said, too
    member_path(run.folder, 0, 3).unlink()
    assert any("L0-000003" in line for line in str(rs.status(rs.open_run(run.folder))).splitlines())


def test_an_error_that_is_not_known_is_called_so(running):
    verdict = running.rounds.verdict._replace(errors={"flash_temperature": np.inf})
    running.rounds = running.rounds._replace(verdict=verdict)
    assert ", flash_temperature total error unknown (target 1 %); " in status.state_line(running)
    assert rs.status(running).to_dict()["errors"] == {"flash_temperature": None}


def test_a_finished_run_says_why_it_ended(running):
    ended(running, met=True, why="the targets are met")
    assert (
        status.state_line(running)
        == f"6 realizations, 18 members; finished: the targets are met{NEAR}"
    )
    ended(running, met=False, why="out of reach: pixel errors are too large")
    assert (
        status.outcome(running)
        == f"target not reached: out of reach: pixel errors are too large{NEAR}"
    )
    running.until = {}
    ended(running, met=False, why="all", errors={})
    assert status.outcome(running) == "all"


def test_an_error_with_unknown_parts_is_a_least_one_and_names_them(running):
    ended(running, met=False, why="why")
    unknown = (
        ("flash_temperature", "scan"),
        ("contact_fraction", "pixel"),
        ("flash_temperature", "size"),
    )
    running.rounds = running.rounds._replace(
        verdict=running.rounds.verdict._replace(unknown=unknown)
    )
    said = ", flash_temperature total error ≥ 2.5 %, scan and size unknown (target 1 %)"
    assert status.outcome(running) == f"target not reached: why{said}"


def test_a_target_whose_error_has_an_unknown_part_is_not_called_reached(quick, tmp_path):
    run = rs.run(
        quick, tmp_path / "run", max_realizations=12, until={"flash_temperature": 0.9}
    )  # one grid alone
    unknown = " and ".join(run.estimate("flash_temperature").unknown)
    assert "pixel" in unknown
    line = str(rs.status(run)).splitlines()[1]
    assert re.search(
        rf"flash_temperature total error ≥ [\d.]+ %, {unknown} unknown \(target 90 %\)$", line
    )


def test_the_numbers_for_machines_are_those_of_rounds_and_estimates(running):
    found, expected = rs.status(running).to_dict(), running.estimate("flash_temperature")
    assert (found["realizations"], found["needed"], found["failed"], found["writer"]) == (
        6,
        6,
        0,
        None,
    )
    assert (found["round"], found["members"], found["wanted"]) == (2, [6, 6, 6], [7, 7, 7])
    assert found["members_needed"] == [10, 6, 8]
    assert (found["finished"], found["target_met"], found["why"]) == (False, False, "statistical")
    assert found["errors"] == ERRORS
    assert found["estimates"]["flash_temperature"]["mean"] == expected.mean.tolist()
    assert found["estimates"]["flash_temperature"]["half_width"] == expected.half_width.tolist()
    assert found["speed"] == [0.0, 0.1, 35.0]


def test_a_run_without_a_sound_member_ends_and_says_so(quick, tmp_path, failing):
    failing(lambda problem: True)
    scene = replace(quick, ensemble=replace(quick.ensemble, max_realizations=2, until=()))
    _, state, failed = str(rs.status(rs.run(scene, tmp_path / "run"))).splitlines()
    assert (
        state == "2 realizations, 2 members; finished: no contact of its lowest level has converged"
    )
    assert failed == "2 did not converge and are left out of the means"
