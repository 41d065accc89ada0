"""Progress of a study: the finished points, and the current one."""

from pathlib import Path

from roughsim.ensemble.progress import Progress
from roughsim.results.run import Run

_LINES = 5  # printed at most without a terminal


class StudyProgress(Progress):
    """Progress over the points of a study."""

    def __init__(self, points: int):
        super().__init__(f"planning {points} points")
        self._points = points
        self._shares: dict[Path, float] = {}  # finished share of the work of each point

    def update(self, run: Run) -> None:
        """Show the number of finished points, and the current one."""
        share = min(len(run.members) / max(sum(run.needed), 1), 0.99)
        self._shares[run.folder] = 1.0 if run.finished else share
        finished = sum(share == 1.0 for share in self._shares.values())
        text = f"{finished} of {self._points} points finished; {run.realizations} realizations in {run.folder.name}"
        self.show(
            text, sum(self._shares.values()) / self._points, finished * _LINES // self._points
        )
