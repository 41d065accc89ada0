"""A run in words: where it stands, what is wrong with it, its scene and its error budget. Plain text."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from roughsim.ensemble.status import clock, count_text, reached, seconds_left
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.gaps import gap
from roughsim.show.units import shown, written
from roughsim.store.claims import writer

if TYPE_CHECKING:
    from roughsim.estimate.errors import Estimate
    from roughsim.results.run import Run


def state_of(run: Run) -> str:
    """Return in one line how many realizations there are and whether more are being computed."""
    by = writer(run.folder)
    sound = len(run.sound(run.realizations))
    if not sound:
        return f"no realization yet; {f'being computed by {by}' if by else 'not being computed now'}"
    finished = run.target_met or run.realizations >= run.max_realizations
    parts = [f"{sound} realizations" if finished else count_text(run)]
    parts[0] += reached(run)
    left = seconds_left(run)
    if by:
        parts.append(f"being computed by {by}" + (f", {clock(left)} left" if left else ""))
    else:
        parts.append("finished" if finished else "not being computed now")
    return "; ".join(parts)


def problems_of(run: Run) -> list[str]:
    """Return a line for each damaged file, and one each for members that are missing or did not converge."""
    lines = [f"{text}. The other realizations are shown." for text in run.damaged.values()] + gap(run)
    if run.failed:
        lines.append(f"{run.failed} realizations did not converge and are left out of the means")
    return lines


def scene_of(run: Run) -> str:
    """Return the scene file and the grids of the run."""
    grids = [
        f"# L{number}: {level.column}, {level.shape[0]} × {level.shape[1]} points, q_c = {level.q_max:.4g} rad/m"
        for number, level in enumerate(run.numerics.levels)
    ]
    sides = " × ".join(f"{1e3 * length:.4g}" for length in run.numerics.lengths)
    return "\n".join([run.scene.to_toml().strip(), "", f"# cell {sides} mm, seed {run.seed}", *grids])


def budget_of(run: Run, column: str) -> str:
    """Return every observable of a column with the parts of its error, a row per speed; units as in all tables."""
    if not run.sound(run.realizations):
        return "No realization yet: there is no error to speak of."
    found = [run.estimate(name, column) for name in OBSERVABLES]
    parts = list(found[0].budget)
    lines = [
        f"{column} contact, n = {found[0].n} realizations. ± all: total error, 95 %, the root of the sum",
        "of squares of the parts; ≥ where no level of the run tells one of them (–). finest: the value at the finest",
        "level minus the mean.",
        "",
        f"{'':24}{'m/s':>7}{'mean':>12}{'± all':>10}" + "".join(f"{part:>12}" for part in parts) + f"{'finest':>9}",
    ]
    for one in found:
        lines += _rows(run, one, parts)
    return "\n".join(lines)


def _rows(run: Run, found: Estimate, parts: list[str]) -> list[str]:
    unit, factor = shown(found.unit)
    speeds = [f"{v:g}" for v in run.scene.speeds] if OBSERVABLES[found.observable].per_speed else [""]
    title = f"{found.observable}{f', {unit}' if unit else ''}"
    lines = []
    for k, speed in enumerate(speeds):
        mean, total, power = written(found.mean[k] * factor, found.total_error[k] * factor, found.unknown_at(k))
        ten = f"e{power}" if power else ""
        cells = [f"{mean + ten:>12}", f"{total + ten if total else '–':>10}"]
        errors = [float(found.budget[part][k]) * factor for part in parts]
        cells += [f"{error:>12.2g}" if isfinite(error) else f"{'–':>12}" for error in errors]
        lines.append(f"{title if k == 0 else '':<26}{speed:>5}{''.join(cells)}{found.bias[k] * factor:>+9.2g}")
    return lines
