"""What a pressed map stores beside its means: T_flash by direction, and load on waves that overshoot."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from roughsim.errors import RecordError
from roughsim.estimate.errors import widened
from roughsim.grid import Array
from roughsim.results.members import Members
from roughsim.scene.numerics import QUADRANTS
from roughsim.show.remarks import Remark
from roughsim.store.member_files import member_name
from roughsim.table import Estimate

PARTS = 4  # quadrants of a map
# factor on the scatter of quadrants, which share the longest waves of their map: by `experiments/pressed_maps.py` maps
# of 2 and 4 longest waves scatter 0.8 to 1.8 times as much as independent quadrants; the interval also has √(1 + 2/3)
SHARED = 1.2
_IN_DIRECTION = (
    "the mean over all directions, times the ratio to it at the highest cut-off, half the length of the map after the "
    "start from rest"
)
DIRECTIONS = "directions"  # key in the provenance of members of the last level
OVERSHOOT = "overshoot"  # key beside it: share of the load on waves far above all points around
SOME_LOAD = 0.01  # beyond it the bandwidth error is unknown; without spikes the share is below 1e-4


class Directions(NamedTuple):
    """T_flash of one contact by the direction of sliding."""

    angles: dict[str, float]  # radians
    over_mean: dict[str, Array]  # T_flash over its mean over all directions, (speeds,)
    # T_flash over T_flash of the phase-randomized surrogate, (speeds,), of the map alone
    over_twin: Array | None


def whole(members: Members) -> bool:
    """Return whether all members of the four quadrants are there, and sound."""
    levels = members.numerics.of_column(QUADRANTS)
    return all(len(members.sound(level)) == PARTS for level in levels)


def remarks(members: Members) -> list[Remark]:
    """Return warnings of lost quadrants, and of waves of the map that overshoot next to spikes and carry load there."""
    found = []
    if members.sound(0) and not whole(members):
        text = (
            f"Quadrants of the map in {members.folder} are lost or damaged: the statistical error is the scatter of "
            "the others, too low, and the error by the size of the map is unknown; repeat `roughsim press`."
        )
        found.append(Remark("caution", QUADRANTS, text))
    share = overshoot(members)
    if share > SOME_LOAD:
        text = (
            f"{100 * share:.2g} % of the load is on heights that the map does not have: its waves "
            "overshoot beside spikes or steps. How much this changes is unknown; take the spikes out of the map: "
            "write nan for their heights."
        )
        found.append(Remark("caution", OVERSHOOT, text))
    return found


def overshoot(members: Members) -> float:
    """Return the share of the load on waves of the map far above its points around; NaN while it is missing."""
    column, *_ = members.numerics.columns
    return float(_of_last_level(members, column, 0).get(OVERSHOOT, np.nan))


def directions(members: Members) -> list[Directions]:
    """Return T_flash by direction of the map and of its four quadrants, of those that are there.

    None of drawn surfaces. RecordError if one is forged.
    """
    column, *_ = members.numerics.columns
    contacts = [(column, 0), *((QUADRANTS, part) for part in range(PARTS))]
    found = []
    for where in contacts:
        about = _of_last_level(members, *where)
        if DIRECTIONS in about:
            found.append(_read_directions(members, *where, about[DIRECTIONS]))
    return found


def needed_size(estimate: Estimate, goal: float, speeds: tuple[float, ...]) -> list[str]:
    """Return a line on the map whose statistical error of T_flash is the target; empty if this map suffices.

    The variance of a mean over a map is in inverse proportion to its area.
    """
    moving = [k for k, mean in enumerate(estimate.mean) if np.isfinite(mean) and mean > 0.0]
    shares = {k: float(estimate.budget["statistical"][k] / estimate.mean[k]) for k in moving}
    k = max(shares, key=shares.__getitem__, default=None)
    if k is None or not shares[k] > goal:
        return []
    error = f"{100 * shares[k]:.2g} % at {speeds[k]:g} m/s"
    return [
        f"size of the map: the statistical error of T_flash, {error}, falls as 1/side; the target of "
        f"{100 * goal:.3g} % needs a map {shares[k] / goal:.2g} times as long and as wide"
    ]


def in_direction(mean: Estimate, found: list[Directions], name: str) -> Estimate:
    """Return T_flash in a direction: its `mean` over directions, times their ratio in the contact.

    The scatter of the ratio is from the four quadrants; the difference of their mean from the map is an error of its
    size. LookupError if the direction was not computed.
    """
    over, *parts = (each.over_mean[name] for each in found)
    rows = np.stack(parts)
    directed = mean.times(over)
    size = np.hypot(directed.budget["size"], mean.mean * np.abs(rows.mean(axis=0) - over))
    directed = replace(
        directed,
        budget={**directed.budget, "size": size},
        notes=(*mean.notes, _IN_DIRECTION),
    )
    scatter = 1.0 + SHARED * (rows / rows.mean(axis=0) - 1.0)
    return widened(directed, scatter, directed.mean)


def _of_last_level(members: Members, column: str, index: int) -> dict[str, Any]:
    """Return the provenance of a member of the last level of a column; empty if it is missing or has failed."""
    level = max(members.numerics.of_column(column), default=-1)
    member = members.get((level, index))
    return {} if member is None or member.failure else member.provenance


def _read_directions(members: Members, column: str, index: int, stored: Any) -> Directions:
    """Return T_flash by direction as a member has stored it; RecordError if it is forged."""
    speeds = len(members.speeds)

    def over_speed(values: Any) -> Array:
        return np.reshape(np.array(values, float), speeds)

    try:
        angles = {str(name): float(angle) for name, angle in stored["angles"].items()}
        over_mean = {name: over_speed(stored["over_mean"][name]) for name in angles}
        twin = over_speed(stored["over_twin"]) if "over_twin" in stored else None
    except (TypeError, ValueError, LookupError, AttributeError) as error:
        name = member_name(max(members.numerics.of_column(column)), index)
        raise RecordError(
            f"{name} of {members.folder} has directions that no press writes ({error}); press into a new folder"
        ) from error
    return Directions(angles, over_mean, twin)
