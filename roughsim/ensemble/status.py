"""The state of a run in words and as JSON: rounds, targets, processes at work, time left, and lost members."""

from math import isfinite
from typing import Any

from roughsim.estimate.rounds import Counts, work
from roughsim.results.folder import left_out
from roughsim.results.run import Run
from roughsim.show.table import json_value
from roughsim.show.text import clock
from roughsim.store.claims import writer
from roughsim.store.member_files import member_name


def status_dict(run: Run) -> dict[str, Any]:
    """Return the state of a run as JSON values: counts, targets, means at all speeds, seconds left.

    `members`, `wanted` and `members_needed` are by level: those that count, of the round in progress, and to the end.
    """
    process = at_work(run)
    missing, rounds = run.missing, run.rounds
    result: dict[str, Any] = {
        "folder": str(run.folder),
        "writer": process,
        "realizations": run.realizations,
        "failed": run.failed,
        "missing": missing,
        "lost": [] if process else missing,  # those that no process computes now
        "damaged": [member_name(*key) for key in run.damaged],
        "round": rounds.number + 1,
        "members": list(run.counts),
        "wanted": list(rounds.wanted),
        "needed": realizations_needed(run),
        "members_needed": list(needed(run)),
        "finished": run.finished,
        "target_met": run.target_met,
        "why": rounds.verdict.why if rounds.verdict else "",
        "errors": {name: json_value(error) for name, error in total_errors(run).items()},
        "seconds_left": seconds_left(run),
        "until": run.until,
        "max_realizations": run.max_realizations,
        "speed": list(run.scene.speeds),
        "estimates": {},
    }
    parts = ("mean", "half_width", "total_error", "unknown", "bias")
    for name in reported_observables(run):
        estimate = run.estimate(name)
        result["estimates"][name] = {part: json_value(getattr(estimate, part)) for part in parts}
    return result


def status_lines(run: Run) -> list[str]:
    """Return the state of a run as lines for people."""
    at_work(run)
    lines = [f"{run.folder}: {run.scene.title or 'untitled'}", state_line(run), *losses(run)]
    return lines + [line for name in reported_observables(run) for line in run.estimate(name).explain().splitlines()]


def at_work(run: Run) -> str | None:
    """Return the processes that compute a run now, as `writer`; where there is none, read what the last one has stored.

    It may have ended since the run was opened, and what it stored would count as missing.
    """
    process = writer(run.folder)
    if process is None:
        run.refresh()
    return process


def reported_observables(run: Run) -> list[str]:
    """Return the observables of the targets and the flash temperature; none before the first sound member."""
    return list(dict.fromkeys((*run.until, "flash_temperature"))) if run.independent else []


def losses(run: Run) -> list[str]:
    """Return a line each on the members that failed, are missing or damaged; empty for a whole run."""
    lines = [f"{run.failed} did not converge and are left out of the means"] if run.failed else []
    march = run.numerics.march
    if march is not None and (failed := len(run.members.failed(march, run.counts[march]))):
        lines.append(f"{failed} members that slide did not converge and are left out of the column sliding")
    return lines + left_out(run)


def state_line(run: Run) -> str:
    """Return in one line how far a run is, the errors beside their targets, and whether more members are coming."""
    if run.finished:
        return f"{run.extent}, {sum(run.counts)} members; finished: {outcome(run)}"
    process = writer(run.folder)
    now = f"being computed by {process}" if process else "not being computed now"
    return f"{run.extent}, {round_text(run)}; {now}, {time_left(seconds_left(run))}"


def outcome(run: Run) -> str:
    """Return why a run has ended, with the errors beside their targets."""
    why = run.rounds.verdict.why if run.rounds.verdict else ""
    return ("target not reached: " if run.until and not run.target_met else "") + why + errors_text(run)


def total_errors(run: Run) -> dict[str, float]:
    """Return the relative total error, 95 %, of each target, after the last complete round; empty before the first."""
    return run.rounds.verdict.errors if run.rounds.verdict else {}


def errors_text(run: Run) -> str:
    """Return the total errors beside their targets, in words that follow others; empty while there are none."""
    words = ""
    for name, error in total_errors(run).items():
        size = f"{100 * error:.2g} %" if isfinite(error) else "unknown"
        words += f", {name} total error {size} (target {100 * run.until[name]:g} %)"
    return words


def needed(run: Run) -> Counts:
    """Return about how many members of each level there will be in the end; before that is known, of the round."""
    return run.rounds.verdict.needed if run.rounds.verdict else run.rounds.wanted


def realizations_needed(run: Run) -> int:
    """Return about how many realizations of the lowest level there will be in the end."""
    return needed(run)[run.numerics.of_column(run.column(None))[0]]


def round_text(run: Run) -> str:
    """Return the round in progress, how many of its members are there, and the errors after the last one."""
    wanted = run.rounds.wanted
    there = sum(min(run.members.available[level], count) for level, count in enumerate(wanted))
    return f"round {run.rounds.number + 1}: {there} of {sum(wanted)} members{errors_text(run)}"


def seconds_left(run: Run) -> float | None:
    """Return how long one process takes for the members that are still needed, s; None while that is unknown.

    A level without members takes as long as the others for its modelled work.
    """
    if run.rounds.verdict is None:
        return None
    seconds = [run.members.seconds(level) for level in range(len(run.numerics.levels))]
    works = [work(run.numerics, level) for level in range(len(seconds))]
    pace = sum(times.sum() for times in seconds) / sum(len(t) * w for t, w in zip(seconds, works, strict=True))
    left = 0.0
    for level, count in enumerate(needed(run)):
        mean = seconds[level].mean() if len(seconds[level]) else works[level] * pace
        left += max(count - run.members.available[level], 0) * float(mean)
    return left


def time_left(seconds: float | None) -> str:
    """Return the time left in words."""
    return "time left not known yet" if seconds is None else f"about {clock(seconds)} of computing left"
