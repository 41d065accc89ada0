"""`report`: a run or a study as one HTML page to send."""

from pathlib import Path

from roughsim.outputs.opened import Folder, opened
from roughsim.outputs.run_report import report_run
from roughsim.outputs.study_report import report_study
from roughsim.studies.study import Study


def report(run: Folder, path: str | Path | None = None) -> Path:
    """Write a run or a study as one HTML page to send, without scripts and requests, and return its path.

    `run` is the record or its folder; damaged members of a run are left out and named. `path` ends in .html, ValueError
    if not; left out: beside the folder, named after it. RecordError if the folder is no run and no study.
    """
    record = opened(run, "skip")
    if isinstance(record, Study):
        return report_study(record, path)
    return report_run(record, path)
