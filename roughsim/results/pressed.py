"""`Pressed`: an opened run folder of a measured map itself, with what its quarters show."""

from dataclasses import replace
from typing import Any

import numpy as np

from roughsim.estimate.errors import Estimate
from roughsim.estimate.ladder import Values
from roughsim.grid import Array
from roughsim.results.run import Run

NOTE = "the map itself; statistical: the scatter of its four quarters; size: how far their mean is from the map"
QUARTERS = "quarters"  # folder, within that of the map, of the run of its four quarters
PRESS = "press"  # key in run.json: "of" the map or its quarters, how it was made periodic, its checksum


class Pressed(Run):
    """The run of one map: realization 0 is the map as it is, and there is no other.

    Its quarters are pressed one by one with the same pressure, in a run of their own. Their scatter gives the
    statistical error of the map, which is four of them. The difference of their mean from the map is the error of its
    size and of its edges: quarters have twice the edge per area.
    """

    drawn = False
    quarters: Run  # realizations 0 … 3

    def refresh(self) -> None:
        """Read what has come since, here and of the quarters."""
        super().refresh()
        if hasattr(self, "quarters"):
            self.quarters.refresh()

    @property
    def extent(self) -> str:
        """What was computed, in words."""
        return "the map itself" if self.realizations else "nothing of the map yet"

    @property
    def independent(self) -> int:
        """How many sound quarters show the scatter."""
        return self.quarters.independent

    def values(self, observable: str, column: str | None = None, *, extrapolated: bool = True) -> Values:
        """Return the values of the map, with the scatter of its quarters about them: a row for each quarter."""
        whole = super().values(observable, column, extrapolated=extrapolated)
        parts = self.quarters.values(observable, column, extrapolated=extrapolated)

        def about(name: str) -> Array:
            """Rows that scatter as those of the quarters, relative to their mean, and have the mean of the map."""
            value, rows = getattr(whole, name).mean(axis=0), getattr(parts, name)
            with np.errstate(all="ignore"):  # 0/0 at rest, and where nothing yields
                relative = rows / rows.mean(axis=0)
            return np.asarray(np.where(np.isfinite(relative), relative, 1.0) * value)

        return whole._replace(
            extrapolated=about("extrapolated"), finest=about("finest"), base=about("base"), group=parts.group
        )

    def size_error(self, observable: str, column: str, values: Values) -> Array:
        """Return how far the mean of the quarters is from the map, relative to the map."""
        whole, parts = (run.values(observable, column).extrapolated.mean(axis=0) for run in (self, self.quarters))
        with np.errstate(all="ignore"):  # 0/0 at rest
            return np.asarray(np.nan_to_num(np.abs(parts / whole - 1.0), posinf=0.0))

    def _estimate(self, observable: str, column: str | None, share: Array) -> Estimate:
        """Return the estimate of the map, which says what its errors are of."""
        result = super()._estimate(observable, column, share)
        return replace(result, notes=(*result.notes, NOTE))

    def _made_by(self) -> dict[str, Any]:
        """What estimates follow from: the quarters too."""
        return {**super()._made_by(), QUARTERS: self.quarters._made_by()}
