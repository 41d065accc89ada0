"""`Pressed`: an opened run folder of a pressed map; its four quarters give the scatter."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from roughsim.errors import RecordError
from roughsim.estimate.errors import SOURCES, Estimate, half_width, spread
from roughsim.estimate.ladder import Pair
from roughsim.estimate.levels import Values, with_errors
from roughsim.estimate.rounds import Rounds, Verdict
from roughsim.grid import Array
from roughsim.results.description import QUARTERS
from roughsim.results.run import Run
from roughsim.show.remarks import Remark
from roughsim.store.member_files import member_path

NOTE = (
    "value of the map itself, without waves shorter than its pixels resolve; n counts its four quarters, which give "
    "the scatter"
)
# factor on the scatter of quarters, which share the longest waves of their map: by `experiments/pressed_maps.py` maps
# of 2 and 4 longest waves scatter 0.8 to 1.8 times as much as independent quarters; the interval also has √(1 + 2/3)
_SHARED = 1.2
_IN_DIRECTION = (
    "the mean over all directions, times the ratio to it at the highest cut-off, half the length of the map after the "
    "start from rest"
)
_OF_MAP = {
    "statistical": "95 % error of the mean over many maps of this size from the same surface, by the scatter of the "
    f"four quarters, {_SHARED:g} times as they share the longest waves; Student t of three degrees of freedom",
    "size": "difference of the mean of the four quarters from the map: they have no wave longer than themselves, and "
    "twice the edge per area",
}
DIRECTIONS = "directions"  # key in the provenance of members of the last level
OVERSHOOT = "overshoot"  # key beside it: share of the load on waves far above all points around
SOME_LOAD = 0.01  # beyond it the bandwidth error is unknown; without spikes the share is below 1e-4


class Directions(NamedTuple):
    """T_flash of one contact by the direction of sliding."""

    angles: dict[str, float]  # radians
    over_mean: dict[str, Array]  # T_flash over its mean over all directions, (speeds,)
    over_twin: (
        Array | None
    )  # T_flash over T_flash of the Gaussian twin, (speeds,), of the map alone


class Quarters(Run):
    """The run of the four quarters of one map: realizations 0 … 3."""

    drawn = False
    pressed = 4  # members of each level

    def _replayed(self) -> Rounds:
        """Return the only round: all members."""
        wanted = (self.pressed,) * len(self.numerics.levels)
        there = tuple(min(self.pressed, count) for count in self.members.available)
        verdict = (
            Verdict(False, None, wanted, "all of the map is there", {}) if there == wanted else None
        )
        return Rounds(there, wanted, 0, verdict)

    def pairs(self, column: str | None = None) -> list[Pair]:
        """Return the levels of a column as `Run` does; all levels see the same surfaces here."""
        return [pair._replace(stream=0) for pair in super().pairs(column)]


class Pressed(Quarters):
    """The run of one map, its only realization.

    Its quarters are pressed one by one with the same pressure, in a run of their own. Their scatter gives the
    statistical error, the deviation of the map from the mean over many such maps. The difference of the mean of the
    quarters from the map is the error of its size and of its edges: quarters have twice the edge per area.
    """

    pressed = 1
    sources: Mapping[str, str] = MappingProxyType({**SOURCES, **_OF_MAP})
    quarters: Run  # realizations 0 … 3

    def refresh(self) -> None:
        """Read the new members of the map and of its quarters."""
        super().refresh()
        self.quarters.refresh()

    @property
    def extent(self) -> str:
        """The number of pressed maps, in words."""
        return "the map itself" if self.realizations else "nothing of the map yet"

    @property
    def independent(self) -> int:
        """Number of sound quarters."""
        return self.quarters.independent

    @property
    def quartered(self) -> bool:
        """Whether all members of the four quarters are there, and sound."""
        levels = range(len(self.quarters.numerics.levels))
        return all(len(self.quarters.members.sound(level)) == Quarters.pressed for level in levels)

    def values(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True
    ) -> Values:
        """Return the values of the map, with `_SHARED` times the scatter of its quarters about their mean."""
        whole = super().values(observable, column, extrapolated=extrapolated)
        if self.overshoot > SOME_LOAD:
            whole = with_errors(whole, bandwidth=np.nan)
        parts = self.quarters.of_levels(observable, column, extrapolated=extrapolated)
        with np.errstate(all="ignore"):  # 0/0 at rest, and without yielding
            size = _SHARED * whole.mean / parts.mean
            scatter = {stream: rows * size for stream, rows in parts.scatter.items()}
        return whole._replace(
            scatter={stream: np.nan_to_num(rows) for stream, rows in scatter.items()}
        )

    def size_error(self, observable: str, column: str) -> Array:
        """Return the relative difference of the mean of the quarters from the map; unknown unless all are there."""
        if not self.quartered:
            return np.array(np.nan)
        whole, parts = (run.of_levels(observable, column).mean for run in (self, self.quarters))
        with np.errstate(all="ignore"):  # 0/0 at rest
            return np.asarray(np.nan_to_num(np.abs(parts / whole - 1.0), posinf=0.0))

    def _directions(self) -> list[Directions]:
        """Return T_flash by direction of the map and of its four quarters, of those that are there."""
        contacts = [(self, 0), *((self.quarters, part) for part in range(4))]
        return [
            _directions_of(*contact)
            for contact in contacts
            if DIRECTIONS in _of_last_level(*contact)
        ]

    @property
    def angles(self) -> dict[str, float]:
        """Directions of sliding with their own T_flash, radians: along and across the lay of the map, and "asked".

        Empty while the map or a quarter is missing.
        """
        found = self._directions()
        return found[0].angles if len(found) == 5 else {}

    @property
    def over_twin(self) -> Array | None:
        """Ratio of T_flash of the map and of its Gaussian twin, (speeds,); None while the map is missing."""
        return next(
            (found.over_twin for found in self._directions() if found.over_twin is not None), None
        )

    @property
    def overshoot(self) -> float:
        """Share of the load on waves of the map far above its points around; NaN while it is missing."""
        return float(_of_last_level(self, 0).get(OVERSHOOT, np.nan))

    @property
    def remarks(self) -> list[Remark]:
        """As of `Run`, of lost quarters, and of waves of the map that overshoot next to spikes and carry load there."""
        remarks = super().remarks
        if self.finished and not self.quartered:
            text = (
                f"Members of {self.folder / QUARTERS} are lost or damaged: the statistical error is the scatter of the "
                "others, too low, and the error by the size of the map is unknown; repeat `roughsim press`."
            )
            remarks.append(Remark("caution", "quarters", text))
        if self.overshoot > SOME_LOAD:
            text = (
                f"{100 * self.overshoot:.2g} % of the load is on heights that the map does not have: its waves "
                "overshoot beside spikes or steps. How much this changes is unknown; take the spikes out of the map: "
                "write nan for their heights."
            )
            remarks.append(Remark("caution", "overshoot", text))
        return remarks

    def needed_size(self) -> list[str]:
        """Return a line on the map whose statistical error of T_flash is the target; empty if this map suffices.

        The variance of a mean over a map is in inverse proportion to its area.
        """
        goal = dict(self.scene.ensemble.until).get("flash_temperature", np.inf)
        found = self.estimate("flash_temperature")
        moving = [k for k, mean in enumerate(found.mean) if np.isfinite(mean) and mean > 0.0]
        shares = {k: float(found.budget["statistical"][k] / found.mean[k]) for k in moving}
        k = max(shares, key=shares.__getitem__, default=None)
        if k is None or not shares[k] > goal:
            return []
        error = f"{100 * shares[k]:.2g} % at {self.scene.speeds[k]:g} m/s"
        return [
            f"size of the map: the statistical error of T_flash, {error}, falls as 1/side; the target of "
            f"{100 * goal:.3g} % needs a map {shares[k] / goal:.2g} times as long and as wide"
        ]

    def in_direction(self, name: str, column: str | None = None) -> Estimate:
        """Return T_flash in one of the directions `angles`: its mean over directions, times their ratio in the contact.

        The scatter of the ratio is from the four quarters; the difference of their mean from the map is an error of its
        size. LookupError if the direction was not computed.
        """
        over, *parts = (found.over_mean[name] for found in self._directions())
        rows = np.stack(parts)
        mean = self.estimate("flash_temperature", column)
        error, freedom = spread(1.0 + _SHARED * (rows / rows.mean(axis=0) - 1.0))
        budget = {part: values * over for part, values in mean.budget.items()}
        budget["statistical"] = np.hypot(
            budget["statistical"], mean.mean * over * half_width(error, freedom)
        )
        budget["size"] = np.hypot(budget["size"], mean.mean * np.abs(rows.mean(axis=0) - over))
        return replace(
            mean,
            mean=mean.mean * over,
            standard_error=np.hypot(mean.standard_error * over, mean.mean * over * error),
            budget=budget,
            bias=mean.bias * over,
            notes=(*mean.notes, _IN_DIRECTION),
        )

    def estimate(self, observable: str, column: str | None = None) -> Estimate:
        """Return the estimate of the map as `Run` does, with a note on its errors."""
        result = super().estimate(observable, column)
        return replace(result, notes=(*result.notes, NOTE))


def _of_last_level(run: Run, index: int) -> dict[str, Any]:
    """Return the provenance of a member of the last level; empty if it is missing or has failed."""
    member = run.members.get((len(run.numerics.levels) - 1, index))
    return {} if member is None or member.failure else member.provenance


def _directions_of(run: Run, index: int) -> Directions:
    """Return T_flash of a member of the last level by direction; RecordError if it is forged."""
    stored, speeds = _of_last_level(run, index)[DIRECTIONS], len(run.scene.speeds)
    try:
        angles = {str(name): float(angle) for name, angle in stored["angles"].items()}
        over_mean = {
            name: np.reshape(np.array(stored["over_mean"][name], float), speeds) for name in angles
        }
        twin = (
            np.reshape(np.array(stored["over_twin"], float), speeds)
            if "over_twin" in stored
            else None
        )
    except (TypeError, ValueError, LookupError, AttributeError) as error:
        path = member_path(run.folder, len(run.numerics.levels) - 1, index)
        raise RecordError(
            f"{path} has directions that no press writes ({error}); press into a new folder"
        ) from error
    return Directions(angles, over_mean, twin)
