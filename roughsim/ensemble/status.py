"""The state of a run in words and as JSON: realizations, targets, processes at work, time left, and lost members."""

from math import isfinite
from typing import Any

from roughsim.estimate.errors import LEAST, LEAST_FINE, relative_half_width
from roughsim.results.folder import left_out
from roughsim.results.run import Run
from roughsim.show.table import json_value
from roughsim.show.text import clock
from roughsim.store.claims import writer
from roughsim.store.member_files import member_name

RECENT = 20  # members over which the pace is measured


def status_dict(run: Run) -> dict[str, Any]:
    """Return the state of a run as JSON values: counts, targets, means at all speeds, seconds left."""
    process = at_work(run)
    missing = run.missing
    result: dict[str, Any] = {
        "folder": str(run.folder),
        "writer": process,
        "realizations": run.realizations,
        "failed": run.failed,
        "missing": missing,
        "lost": [] if process else missing,  # those that no process computes now
        "damaged": [member_name(*key) for key in run.damaged],
        "needed": realizations_needed(run),
        "target_met": run.target_met,
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
    """Return the observables of the targets and the flash temperature; none before the first sound realization."""
    return list(dict.fromkeys((*run.until, "flash_temperature"))) if run.sound(run.realizations) else []


def losses(run: Run) -> list[str]:
    """Return a line each on the realizations that failed, are missing or damaged; empty for a whole run."""
    lines = [f"{run.failed} did not converge and are left out of the means"] if run.failed else []
    march = run.numerics.march
    if march is not None and (failed := len(run.members.failed(march, run.realizations))):
        lines.append(f"{failed} members that slide did not converge and are left out of the column sliding")
    return lines + left_out(run)


def state_line(run: Run) -> str:
    """Return in one line the number of realizations, the errors beside their targets, and whether more are coming."""
    if run.target_met or run.realizations >= run.max_realizations:
        return f"{run.extent}{reached(run)}; finished: {ended(run)}"
    process, left = writer(run.folder), seconds_left(run)
    now = f"being computed by {process}" if process else "not being computed now"
    pace = f", {clock(left)} left at the latest pace" if left is not None else ""
    return f"{count_text(run)}{reached(run)}; {now}{pace}"


def ended(run: Run) -> str:
    """Return why a run has ended, and which parts of the error of its targets are unknown."""
    why = "the target of the statistical error is met" if run.target_met else "all realizations are there"
    sound = run.sound(run.realizations)
    unknown = dict.fromkeys(part for name in run.until if sound for part in run.estimate(name).unknown)
    return why + (f"; the error by {', '.join(unknown)} is unknown" if unknown else "")


def statistical_errors(run: Run) -> dict[str, float]:
    """Return the relative 95 % half-width of each target; empty while there is none, or one is unknown."""
    if len(run.sound(run.realizations)) < 4:
        return {}
    widths = {name: relative_half_width(run.reported(name)) for name in run.until}
    return widths if all(map(isfinite, widths.values())) else {}


def realizations_needed(run: Run) -> int:
    """Return how many realizations the targets will take: the half-width falls as 1/√n."""
    if not run.until:
        return run.max_realizations
    worst = max((width / run.until[name] for name, width in statistical_errors(run).items()), default=0.0)
    # a level that is solved for every k-th realization needs a few solves too
    seldom = max(level.every for level in run.numerics.levels)
    by_scatter = round(len(run.sound(run.realizations)) * worst**2)
    return min(max(LEAST, (LEAST_FINE - 1) * seldom + 1, by_scatter, run.realizations), run.max_realizations)


def count_text(run: Run) -> str:
    """Return how many realizations are there, and how many the targets take, once that is known."""
    if end_known(run):
        return f"{run.realizations} of about {realizations_needed(run)} realizations"
    return f"{run.realizations} realizations; how many the target takes shows after {realizations_needed(run)}"


def end_known(run: Run) -> bool:
    """Whether there are enough realizations to say how many the targets take."""
    if not run.until or run.max_realizations <= LEAST:
        return True
    return len(run.sound(run.realizations)) >= LEAST and bool(statistical_errors(run))


def seconds_left(run: Run) -> float | None:
    """Return the time left at the pace of the latest members, s; None while the pace or the end is unknown."""
    if not end_known(run):
        return None
    written = run.members.latest(RECENT)
    if len(written) < 2 or written[-1] <= written[0]:
        return None
    missing = max(run.numerics.members(realizations_needed(run)) - len(run.members), 0)
    return missing * (written[-1] - written[0]) / (len(written) - 1)


def reached(run: Run) -> str:
    """Return the statistical errors beside their targets, in words that follow a count; empty while unknown."""
    words = (
        f"{name} statistical error {100 * width:.2g} % (target {100 * run.until[name]:g} %)"
        for name, width in statistical_errors(run).items()
    )
    return f": {text}" if (text := ", ".join(words)) else ""
