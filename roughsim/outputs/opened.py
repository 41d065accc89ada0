"""What the verbs take: the record of a run or a study, or the path of its folder."""

from pathlib import Path

from roughsim.results.folder import open_run
from roughsim.results.members import Damaged
from roughsim.results.run import Run
from roughsim.studies.folder import is_study
from roughsim.studies.study import Study, open_study

Folder = Run | Study | str | Path


def opened(what: Folder, damaged: Damaged = "refuse") -> Run | Study:
    """Return a run or a study as it is, or open its folder; `damaged` and errors as of `open_run`."""
    if isinstance(what, (Run, Study)):
        return what
    if not isinstance(what, (str, Path)):
        raise TypeError(f"{what!r} must be a run, a study, or the path of a folder of one")
    return open_study(what) if is_study(Path(what)) else open_run(what, damaged=damaged)
