"""`Pressed`: an opened run folder of a measured map itself, with what its quarters show."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from roughsim.errors import RecordError
from roughsim.estimate.errors import SOURCES, Estimate, half_width, spread
from roughsim.estimate.ladder import Pair
from roughsim.estimate.levels import Values
from roughsim.estimate.rounds import Counts, Rounds, Verdict
from roughsim.grid import Array
from roughsim.results.run import Run
from roughsim.store.member_files import member_path, read_member

NOTE = (
    "the value is that of the map itself, without waves shorter than it shows; n counts its four quarters, which show "
    "the scatter"
)
# quarters of one map share its longest waves: by `experiments/pressed_maps.py` maps of 2 and 4 longest waves differ by
# 0.8 to 1.8 times what four independent quarters would; the interval has √(1 + 2/3) beside it
SHARED = 1.2
IN_DIRECTION = (
    "the mean over all directions, times the ratio to it at the highest cut-off, half the length of the map after the "
    "start from rest"
)
OF_MAP = {
    "statistical": "how far the mean over many maps of this size, from the same surface, may be: 95 %, by the scatter "
    f"of the four quarters, {SHARED:g} times as they share the longest waves; Student t of three degrees of freedom",
    "size": "how far the mean of the four quarters is from the map: they have no wave longer than themselves, and "
    "twice the edge per area",
}
DIRECTIONS = "directions"  # key in the provenance of members of the last level
OVERSHOOT = "overshoot"  # key beside it: share of the load where waves stand far above all points around
SOME_LOAD = 0.01  # beyond it the bandwidth error is unknown; without spikes the share is below 1e-4


class Quarters(Run):
    """The run of the four quarters of one map: realizations 0 … 3."""

    drawn = False
    pressed = 4  # members of each level

    @property
    def rounds(self) -> Rounds:
        """The only round: all members."""
        levels = range(len(self.numerics.levels))
        wanted, there = (self.pressed,) * len(levels), tuple(min(self.pressed, self.available(i)) for i in levels)
        verdict = Verdict(False, None, wanted, "all of the map is there", {}) if there == wanted else None
        return Rounds(there, wanted, 0, verdict)

    def pairs(self, column: str | None = None, counts: Counts | None = None) -> list[Pair]:
        """Return the levels of a column as `Run` does; all levels see the same surfaces here."""
        return [pair._replace(stream=0) for pair in super().pairs(column, counts)]


class Pressed(Quarters):
    """The run of one map: realization 0 is the map as it is, and there is no other.

    Its quarters are pressed one by one with the same pressure, in a run of their own. Their scatter gives the
    statistical error: how far the map may be from the mean over many such maps. The difference of the mean of the
    quarters from the map is the error of its size and of its edges: quarters have twice the edge per area.
    """

    pressed = 1
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

    def values(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True, counts: Counts | None = None
    ) -> Values:
        """Return the values of the map, with the scatter of its quarters: `SHARED` times theirs about their mean."""
        whole = super().values(observable, column, extrapolated=extrapolated, counts=counts)
        parts = self.quarters.values(observable, column, extrapolated=extrapolated)
        with np.errstate(all="ignore"):  # 0/0 at rest, and where nothing yields
            size = SHARED * whole.mean / parts.mean
            scatter = {stream: rows * size for stream, rows in parts.scatter.items()}
        return whole._replace(scatter={stream: np.nan_to_num(rows) for stream, rows in scatter.items()})

    def size_error(self, observable: str, column: str, values: Values) -> Array:
        """Return how far the mean of the quarters is from the map, relative to the map."""
        whole, parts = (run.values(observable, column).mean for run in (self, self.quarters))
        with np.errstate(all="ignore"):  # 0/0 at rest
            return np.asarray(np.nan_to_num(np.abs(parts / whole - 1.0), posinf=0.0))

    @property
    def angles(self) -> dict[str, float]:
        """Directions of sliding in which T_flash is known, radians: along and across the lay, and the one asked for.

        None where the map or a quarter was computed by an older version, or did not converge.
        """
        found: dict[str, float] = self._directions(self, 0).get("angles", {})
        whole = all(self._directions(self.quarters, k).get("angles") == found for k in range(4))
        return {name: found[name] for name in ("along", "across", "asked") if whole and name in found}

    @property
    def over_twin(self) -> Array | None:
        """T_flash of the map over that of its Gaussian twin, (speeds,); None in a run of an older version."""
        found: Array | None = self._directions(self, 0).get("over_twin")
        return found

    @property
    def overshoot(self) -> float:
        """Share of the load where the waves of the map stand far above its points around; NaN by an older version."""
        found = self._of_last_level(self, 0).get(OVERSHOOT, np.nan)
        return float(found) if isinstance(found, (int, float)) else np.nan

    def in_direction(self, name: str, column: str | None = None) -> Estimate:
        """Return T_flash in one of the directions `angles`: its mean over directions, times their ratio in the contact.

        The scatter of the ratio is that of the four quarters, and the difference of their mean from the map an error of
        its size. LookupError if the direction was not computed.
        """
        over = self._directions(self, 0)["over_mean"][name]
        rows = np.stack([self._directions(self.quarters, k)["over_mean"][name] for k in range(4)])
        mean = self.estimate("flash_temperature", column)
        error, freedom = spread(1.0 + SHARED * (rows / rows.mean(axis=0) - 1.0))
        budget = {part: values * over for part, values in mean.budget.items()}
        budget["statistical"] = np.hypot(budget["statistical"], mean.mean * over * half_width(error, freedom))
        budget["size"] = np.hypot(budget["size"], mean.mean * np.abs(rows.mean(axis=0) - over))
        return replace(
            mean,
            mean=mean.mean * over,
            standard_error=np.hypot(mean.standard_error * over, mean.mean * over * error),
            budget=budget,
            bias=mean.bias * over,
            notes=(*mean.notes, IN_DIRECTION),
        )

    def _of_last_level(self, run: Run, index: int) -> Mapping[str, Any]:
        """What a member of the last level says of its making; nothing if it is missing or has failed."""
        level = len(run.numerics.levels) - 1
        if (level, index) not in run.members or run.members[level, index].failure:
            return {}
        return read_member(member_path(run.folder, level, index)).provenance

    def _directions(self, run: Run, index: int) -> dict[str, Any]:
        """What a member of the last level says of directions; nothing if it is missing or of an older version."""
        path = member_path(run.folder, len(run.numerics.levels) - 1, index)
        speeds = (len(self.scene.speeds),)
        stored = self._of_last_level(run, index).get(DIRECTIONS)
        if stored is None:
            return {}
        try:
            found: dict[str, Any] = {"angles": {str(name): float(angle) for name, angle in stored["angles"].items()}}
            found["over_mean"] = {name: np.array(stored["over_mean"][name], np.float64) for name in found["angles"]}
            curves = [*found["over_mean"].values()]
            if "over_twin" in stored:
                curves.append(found.setdefault("over_twin", np.array(stored["over_twin"], np.float64)))
        except (TypeError, ValueError, LookupError, AttributeError) as error:
            raise RecordError(
                f"{path} has directions that no press writes ({error}); press into a new folder"
            ) from error
        if any(curve.shape != speeds for curve in curves):
            raise RecordError(f"{path} has directions of other speeds than the run; press into a new folder")
        return found

    def _estimate(
        self, observable: str, column: str | None, share: Values | Array, counts: Counts | None = None
    ) -> Estimate:
        """Return the estimate of the map, which says what its errors are of."""
        result = super()._estimate(observable, column, share, counts)
        if self.overshoot > SOME_LOAD:
            result = replace(result, budget={**result.budget, "bandwidth": np.full_like(result.mean, np.nan)})
        return replace(result, notes=(*result.notes, NOTE))
