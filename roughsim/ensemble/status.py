"""State of a run in words: rounds, targets, processes, time left, and lost members."""

from math import inf, isfinite

from roughsim.estimate.rounds import WORK_SECONDS, work
from roughsim.results.folder import left_out
from roughsim.results.run import Run
from roughsim.show.text import clock
from roughsim.store.claims import writer


def losses(run: Run) -> list[str]:
    """Return a line each on failed, missing and damaged members; empty for a whole run."""
    lines = [f"{run.failed} did not converge and are left out of the means"] if run.failed else []
    slide = run.numerics.slide
    if slide is not None and (failed := len(run.members.failed(slide))):
        lines.append(
            f"{failed} members that slide did not converge and are left out of the column sliding"
        )
    return lines + left_out(run)


def state_line(run: Run) -> str:
    """Return one line: progress of a run, the errors with their targets, and the processes that compute it."""
    if run.finished:
        return f"{run.extent}, {sum(run.counts)} members; finished: {outcome(run)}"
    wanted = run.rounds.wanted
    there = sum(min(run.members.available[level], count) for level, count in enumerate(wanted))
    current = f"round {run.rounds.number + 1}: {there} of {sum(wanted)} members{_errors_text(run)}"
    seconds = seconds_left(run)
    left = (
        "time left not known yet"
        if seconds is None
        else f"about {clock(seconds)} of computing left"
    )
    return f"{run.extent}, {current}; {at_work(writer(run.folder))}, {left}"


def at_work(process: str | None) -> str:
    """Return in words whether a run or a study is being computed, by the processes that `writer` names."""
    return f"being computed by {process}" if process else "not being computed now"


def outcome(run: Run) -> str:
    """Return the reason of the end of a run, with the errors and their targets."""
    missed = "target not reached: " if run.until and not run.target_met else ""
    return missed + run.rounds.verdict.why + _errors_text(run)


def _errors_text(run: Run) -> str:
    """Return the total errors with their targets, as the end of a line; empty before the first estimate."""
    text = ""
    for name, error in run.total_errors.items():
        unknown = run.unknown_parts(name)
        size = f"{'≥ ' * bool(unknown)}{100 * error:.2g} %" if isfinite(error) else "unknown"
        named = f", {' and '.join(unknown)} unknown" if unknown else ""
        text += f", {name} total error {size}{named} (target {100 * run.until[name]:g} %)"
    return text


def seconds_left(run: Run) -> float | None:
    """Return the expected time for the members still needed, s, in one process; None in the first round.

    A level without members takes as long as the others for its modelled work.
    """
    if not (run.rounds.number or run.finished):
        return None
    spent = run.members.spent
    works = [work(run.numerics, level) for level in range(len(spent))]
    done = sum(count * each for (count, _), each in zip(spent, works, strict=True))
    pace = sum(seconds for _, seconds in spent) / done
    left = 0.0
    for level, (count, seconds) in enumerate(spent):
        mean = seconds / count if count else works[level] * pace
        left += max(run.needed[level] - run.members.available[level], 0) * mean
    return left


def expected_seconds(run: Run) -> float:
    """Return the expected time for the members still needed, s, in one process; in the first round by the plan.

    inf in the first round of a run with slides.
    """
    measured = seconds_left(run)
    if measured is not None:
        return measured
    if run.numerics.slide is not None:
        return inf
    left = [
        max(count - there, 0)
        for count, there in zip(run.rounds.wanted, run.members.available, strict=True)
    ]
    return WORK_SECONDS * sum(count * work(run.numerics, level) for level, count in enumerate(left))
