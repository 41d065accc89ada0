"""`Pressed`: an opened run folder of a measured map itself, with what its quarters show."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from roughsim.estimate.errors import SOURCES, Estimate
from roughsim.estimate.ladder import Values
from roughsim.grid import Array
from roughsim.results.run import Run
from roughsim.store.kinds import QUARTERS

NOTE = "the value is that of the map itself; n counts its four quarters, which show the scatter"
# quarters of one map share its longest waves: by `experiments/pressed_maps.py` maps of 2 and 4 longest waves differ by
# 0.8 to 1.8 times what four independent quarters would; the interval has √(1 + 2/3) beside it
SHARED = 1.2
OF_MAP = {
    "statistical": "how far the mean over many maps of this size, from the same surface, may be: 95 %, by the scatter "
    f"of the four quarters, {SHARED:g} times as they share the longest waves; Student t of three degrees of freedom",
    "size": "how far the mean of the four quarters is from the map: they have no wave longer than themselves, and "
    "twice the edge per area",
}


class Quarters(Run):
    """The run of the four quarters of one map: realizations 0 … 3."""

    drawn = False


class Pressed(Run):
    """The run of one map: realization 0 is the map as it is, and there is no other.

    Its quarters are pressed one by one with the same pressure, in a run of their own. Their scatter gives the
    statistical error: how far the map may be from the mean over many such maps. The difference of the mean of the
    quarters from the map is the error of its size and of its edges: quarters have twice the edge per area.
    """

    drawn = False
    sources: Mapping[str, str] = MappingProxyType({**SOURCES, **OF_MAP})
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
            """Rows that scatter `SHARED` times as the quarters do about their mean, and have the mean of the map."""
            value, rows = getattr(whole, name).mean(axis=0), getattr(parts, name)
            with np.errstate(all="ignore"):  # 0/0 at rest, and where nothing yields
                apart = SHARED * (rows / rows.mean(axis=0) - 1.0)
            return np.asarray((1.0 + np.where(np.isfinite(apart), apart, 0.0)) * value)

        return whole._replace(
            extrapolated=about("extrapolated"), finest=about("finest"), base=about("base"), group=parts.group
        )

    def size_error(self, observable: str, column: str, values: Values) -> Array:
        """Return how far the mean of the quarters is from the map, relative to the map."""
        whole, parts = (run.values(observable, column).extrapolated.mean(axis=0) for run in (self, self.quarters))
        with np.errstate(all="ignore"):  # 0/0 at rest
            return np.asarray(np.nan_to_num(np.abs(parts / whole - 1.0), posinf=0.0))

    def _estimate(self, observable: str, column: str | None, share: Values | Array) -> Estimate:
        """Return the estimate of the map, which says what its errors are of."""
        result = super()._estimate(observable, column, share)
        return replace(result, notes=(*result.notes, NOTE))

    def _made_by(self) -> dict[str, Any]:
        """What estimates follow from: the quarters too."""
        return {**super()._made_by(), QUARTERS: self.quarters._made_by()}
