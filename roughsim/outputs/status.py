"""`status`: the state of a run or a study, in words and as JSON values."""

from dataclasses import dataclass
from typing import Any

from roughsim.ensemble.status import at_work, status_dict, status_lines
from roughsim.outputs.opened import Folder, opened
from roughsim.store.claims import writer
from roughsim.studies.study import Study


@dataclass(frozen=True, slots=True, repr=False)
class Status:
    """The state of a run or a study; ``str()`` has it in words."""

    text: str
    values: dict[str, Any]

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Status of {self.values['folder']}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the state as JSON values."""
        return self.values


def status(run: Folder) -> Status:
    """Return the state of a run or a study: errors, failures, time left. It may still be computed.

    `run` is the record or its folder; damaged members are left out. RecordError if it is no run and no study.
    """
    record = opened(run, "skip")
    if isinstance(record, Study):
        return Status("\n".join([str(record), *_at_work(record)]), record.to_dict())
    values = status_dict(record)
    return Status("\n".join(status_lines(record)), values)


def _at_work(study: Study) -> list[str]:
    """Return a line on the processes that compute a study; none for a finished one."""
    if study.finished == len(study.points):
        return []
    process = writer(study.folder)
    return [at_work(process) + ("" if process else "; repeat its command to go on")]
