"""`report`: a run or a study as one HTML page to send."""

from pathlib import Path

from roughsim.outputs import run_report, study_report
from roughsim.outputs.opened import Folder, opened
from roughsim.store.disk import place_bytes
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
    folder = record.folder.resolve()
    place = folder.with_name(f"{folder.name}.html") if path is None else Path(path)
    if place.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"path = {str(place)!r} of a report must end in .html")
    place.parent.mkdir(parents=True, exist_ok=True)
    page = study_report.page(record) if isinstance(record, Study) else run_report.page(record)
    place_bytes(place, page.encode())
    return place
