"""`compare`: one run with the theory, or several runs, or the points of a study, side by side."""

from itertools import starmap
from pathlib import Path
from typing import overload

from roughsim.comparison.compare import Comparison
from roughsim.comparison.several import Comparisons
from roughsim.outputs.opened import Folder, opened
from roughsim.results.run import Run
from roughsim.studies.study import Study
from roughsim.studies.tables import key_text


@overload
def compare(run: Run) -> Comparison: ...
@overload
def compare(run: Study) -> Comparisons: ...
@overload
def compare(run: str | Path) -> Comparison | Comparisons: ...
@overload
def compare(run: Folder, /, *others: Folder) -> Comparison | Comparisons: ...
def compare(run: Folder, *others: Folder) -> Comparison | Comparisons:
    """Compare a run with the theory; several runs, or the points of a study, side by side.

    Parameters
    ----------
    run, *others : Run, Study, str or Path
        Runs from `run` or `open_run`, studies, or their folders. A run needs two sound realizations.

    Returns
    -------
    Comparison or Comparisons
        Of one run the comparison: `rows`, `to_dict()` and `chart(path)`. Of several, and of a study, all of them with a
        label each: the name of the folder, or the values of the varied keys.

    Raises
    ------
    ValueError
        If a run has fewer than two sound realizations, or a study no point with two: there is no error to compare with.
    RecordError
        As from `open_run`.
    """
    records = [opened(each) for each in (run, *others)]
    if len(records) == 1 and isinstance(records[0], Run):
        return Comparison(records[0])
    labels: list[str] = []
    runs: list[Run] = []
    for record in records:
        if isinstance(record, Study):
            results = record.results
            if not results:
                raise ValueError(
                    f"{record.folder} has no point with two sound realizations yet; let it run on"
                )
            runs += [run for _, run in results]
            labels += [", ".join(starmap(key_text, point.values.items())) for point, _ in results]
        else:
            runs.append(record)
            labels.append(record.folder.resolve().name)
    if len(set(labels)) < len(labels):
        labels = [str(run.folder) for run in runs]
    return Comparisons(labels, [*map(Comparison, runs)])
