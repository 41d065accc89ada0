"""`report`: a run or a study as one HTML page to send."""

from pathlib import Path

from roughsim.outputs.opened import Folder, opened
from roughsim.outputs.run_report import report_run
from roughsim.outputs.study_report import report_study
from roughsim.studies.study import Study


def report(run: Folder, path: str | Path | None = None) -> Path:
    """Write a run or a study as one HTML page to send, without scripts and requests.

    Parameters
    ----------
    run : Run, Study, str or Path
        The run, the study, or its folder; damaged members of a run are left out and named.
    path : str or Path, optional
        Ends in .html. Default: beside the folder, named after it.

    Returns
    -------
    Path
        The path of the page.

    Raises
    ------
    ValueError
        For another ending.
    RecordError
        If the folder is no run and no study.
    """
    record = opened(run, "skip")
    if isinstance(record, Study):
        return report_study(record, path)
    return report_run(record, path)
