"""`status`: the state of a run or a study, in words and as JSON values."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import at_work, losses, seconds_left, state_line
from roughsim.outputs.opened import Folder, opened
from roughsim.results.run import Run
from roughsim.show.table import json_value
from roughsim.show.text import plain_lines
from roughsim.store.claims import writer
from roughsim.studies.study import Study


@dataclass(frozen=True, slots=True, repr=False)
class Status:
    """The state of a run or a study; ``str()`` has it in words."""

    text: str
    values: dict[str, Any]

    def __str__(self) -> str:
        return plain_lines(self.text)

    def __repr__(self) -> str:
        return f"<Status of {self.values['folder']}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the state as JSON values."""
        return self.values


def status(run: Folder) -> Status:
    """Return the state of a run or a study: errors, failures, time left. It may still be computed.

    Parameters
    ----------
    run : Run, Study, str or Path
        The run, the study, or its folder; damaged members are left out.

    Returns
    -------
    Status
        ``str()`` is the text of the command line, `to_dict()` the same as JSON values.

    Raises
    ------
    RecordError
        If the folder is no run and no study.
    """
    record = opened(run, "skip")
    if isinstance(record, Study):
        return Status("\n".join([str(record), *_at_work(record)]), record.to_dict())
    values = _values(record)
    lines = [
        f"{record.folder}: {record.scene.title or 'untitled'}",
        state_line(record),
        *losses(record),
    ]
    if record.independent:  # there is a sound member
        worst = {}  # speeds at which targets are judged, by observable
        for name in dict.fromkeys((*record.until, "flash_temperature")):
            estimate = record.estimate(name)
            scale = np.where(estimate.mean == 0.0, np.inf, np.abs(estimate.mean))
            error = np.nan_to_num(estimate.total_error, posinf=0.0) / scale
            worst[name] = int(np.unravel_index(error.argmax(), error.shape)[-1])
            parts = ("mean", "half_width", "total_error", "unknown", "bias")
            values["estimates"][name] = {
                part: json_value(getattr(estimate, part)) for part in parts
            }
        table = budget_table(record, record.column(None), {*worst.values()}, [*worst])
        lines += [
            *str(table).splitlines(),
            "Of several speeds the worst; explain() of an estimate has all.",
        ]
        lines += [note for note in estimate.notes if not note.startswith("speeds ")]
        lines += record.needed_size()
    return Status("\n".join(lines), values)


def _values(run: Run) -> dict[str, Any]:
    """Return the state of a run as JSON values: counts, targets, seconds left.

    `members`, `wanted` and `members_needed` are by level: those that count, of the current round, and to the end.
    """
    process = writer(run.folder)
    if process is None:
        run.refresh()  # it may have ended since the run was opened: new members would count as missing
    missing = run.missing
    rounds = run.rounds
    return {
        "folder": str(run.folder),
        "writer": process,
        "realizations": run.realizations,
        "failed": run.failed,
        "missing": missing,
        "lost": [] if process else missing,  # no process computes them now
        "damaged": [*run.damaged],
        "round": rounds.number + 1,
        "members": list(run.counts),
        "wanted": list(rounds.wanted),
        "needed": run.needed[run.numerics.of_column(run.column(None))[0]],
        "members_needed": list(run.needed),
        "finished": run.finished,
        "target_met": run.target_met,
        "why": rounds.verdict.why,
        "errors": json_value(run.total_errors),
        "seconds_left": seconds_left(run),
        "until": run.until,
        "max_realizations": run.max_realizations,
        "speed": list(run.scene.sliding.speed),
        "direction": list(run.scene.directions),
        "estimates": {},
    }


def _at_work(study: Study) -> list[str]:
    """Return a line on the processes that compute a study; none for a finished one."""
    if study.finished == len(study.points):
        return []
    process = writer(study.folder)
    return [at_work(process) + ("" if process else "; repeat its command to go on")]
