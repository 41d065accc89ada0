"""`Member`: the numbers, curves and fields of one realization of one level, whatever computed it."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array
from roughsim.observables.distribution import Bins


class StoredMoments(NamedTuple):
    """StoredMoments of one contact; temperatures with all heat in the moving body."""

    numbers: dict[str, Array]  # (speeds,) or (1,)
    wavenumber: Array  # rad/m
    spectrum: Array  # radial stress spectrum: shares of the pressure variance, Pa²
    bins: Bins | None = None  # of the contact area, (speeds, bins), if the scene asks for them


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """One realization of one level, as it is stored."""

    level: int
    index: int  # of the realization
    failure: str = ""  # why there are no numbers; empty for a sound member
    moments: tuple[
        StoredMoments, ...
    ] = ()  # of its level, and of the level below on the same surface; none of a failure
    curves: dict[str, Array] = field(
        default_factory=dict
    )  # over the slid distance, of the column "sliding" only
    # heights, m, and pressure, Pa, or the snapshots of a slide, if they are kept
    fields: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    lengths: tuple[float, float] = (1.0, 1.0)  # sides of the cell, m
    speeds: tuple[float, ...] = ()  # of the arrays over speed, m/s
    provenance: dict[str, Any] = field(
        default_factory=dict
    )  # scene, numerics, versions, residual, times
    kept: dict[str, tuple[int, ...]] = field(
        default_factory=dict
    )  # shapes of the fields in its file, by name

    @property
    def numbers(self) -> dict[str, Array]:
        """The numbers of its level; none of a failure."""
        return self.moments[0].numbers if self.moments else {}
