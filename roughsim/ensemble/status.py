"""Where a run stands: members, mean ± error, time left, failures."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from roughsim.estimate.stop import LEAST, relative_half_width
from roughsim.results.gaps import damaged_names, left_out
from roughsim.show.units import json_number
from roughsim.store.processes import writer

if TYPE_CHECKING:
    from roughsim.results.run import Run

_RECENT = 20  # members over which the pace is measured


def status_dict(run: Run) -> dict[str, Any]:
    """Return where a run stands as JSON values: counts, targets, means at all speeds, seconds left."""
    sound = len(run.sound(run.realizations))
    result: dict[str, Any] = {
        "folder": str(run.folder),
        "writer": writer(run.folder),
        "realizations": run.realizations,
        "failed": run.failed,
        "missing": run.missing,
        "damaged": damaged_names(run),
        "needed": realizations_needed(run),
        "target_met": run.target_met,
        "seconds_left": seconds_left(run),
        "until": run.until,
        "max_realizations": run.max_realizations,
        "speed": list(run.scene.speeds),
        "estimates": {},
    }
    if sound:
        for name in dict.fromkeys((*run.until, "flash_temperature")):
            found = run.estimate(name)
            result["estimates"][name] = {
                "mean": [json_number(float(x)) for x in found.mean],
                "half_width": [json_number(float(x)) for x in found.half_width],
                "total_error": [json_number(float(x)) for x in found.total_error],
                "unknown": list(found.unknown),
                "bias": [json_number(float(x)) for x in found.bias],
            }
    return result


def status_lines(run: Run) -> list[str]:
    """Return where a run stands, for people."""
    lines = [f"{run.folder}: {run.scene.title or 'untitled'}", state_line(run)]
    if run.failed:
        lines.append(f"{run.failed} did not converge and are left out of the means")
    lines += left_out(run)
    if run.sound(run.realizations):
        for name in dict.fromkeys((*run.until, "flash_temperature")):
            lines += run.estimate(name).explain().splitlines()
    return lines


def state_line(run: Run) -> str:
    """Return in one line how many realizations there are, how near the targets are, and whether more are coming."""
    if run.target_met or run.realizations >= run.max_realizations:
        return f"{run.realizations} realizations{reached(run)}; finished: {ended(run)}"
    process, left = writer(run.folder), seconds_left(run)
    now = f"being computed by {process}" if process else "not being computed now"
    pace = f", {clock(left)} left at the latest pace" if left is not None else ""
    return f"{count_text(run)}{reached(run)}; {now}{pace}"


def ended(run: Run) -> str:
    """Return why a run has ended; a target is one of the statistical error, and what else is unknown is named."""
    why = "the target of the statistical error is met" if run.target_met else "all realizations are there"
    sound = run.sound(run.realizations)
    unknown = dict.fromkeys(part for name in run.until if sound for part in run.estimate(name).unknown)
    return why + (f"; the error by {', '.join(unknown)} is unknown" if unknown else "")


def realizations_needed(run: Run) -> int:
    """Return how many realizations the targets will take: the half-width falls as 1/√n."""
    rows = run.sound(run.realizations)
    if not run.until:
        return run.max_realizations
    if len(rows) < 4:
        return min(12, run.max_realizations)
    worst = max(relative_half_width(run.values(name)) / goal for name, goal in run.until.items())
    seldom = max(level.every for level in run.numerics.levels)
    wanted = max(12, 2 * seldom + 1, round(len(rows) * worst**2) if isfinite(worst) else 0, run.realizations)
    return min(wanted, run.max_realizations)


def count_text(run: Run) -> str:
    """Return how many realizations are there, and how many the targets take, if that can be told."""
    if end_known(run):
        return f"{run.realizations} of about {realizations_needed(run)} realizations"
    return f"{run.realizations} realizations; how many the target takes shows after {realizations_needed(run)}"


def end_known(run: Run) -> bool:
    """Whether so many realizations are there that those which the targets take can be told."""
    if not run.until or run.max_realizations <= LEAST:
        return True
    enough = len(run.sound(run.realizations)) >= LEAST
    return enough and all(isfinite(relative_half_width(run.values(name))) for name in run.until)


def seconds_left(run: Run) -> float | None:
    """Return the time left at the pace of the latest members, s; None while there is no pace or no end to tell."""
    if not end_known(run):
        return None
    written = run.members.latest(_RECENT)
    if len(written) < 2 or written[-1] <= written[0]:
        return None
    missing = max(run.numerics.members(realizations_needed(run)) - len(run.members), 0)
    return missing * (written[-1] - written[0]) / (len(written) - 1)


def reached(run: Run) -> str:
    """Return how near the targets are, in words that follow a count; empty where nothing is to be told."""
    if not run.until or len(run.sound(run.realizations)) < 4:
        return ""
    parts = (
        f"{name} statistical error {100 * relative_half_width(run.values(name)):.2g} % (target {100 * goal:g} %)"
        for name, goal in run.until.items()
    )
    told = ", ".join(parts)
    return "" if "inf" in told else ": " + told


def clock(seconds: float) -> str:
    """Return a time span in words: 12 s, 3 min 05 s."""
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s" if whole >= 60 else f"{whole} s"
