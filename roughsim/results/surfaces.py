"""The two kinds of surfaces of a run: drawn from C(q), and a pressed map, whose quadrants give its scatter."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from roughsim import prediction
from roughsim.estimate import errors
from roughsim.estimate.cell_size import size_error
from roughsim.estimate.mean import Mean
from roughsim.grid import Array
from roughsim.observables.catalogue import CAMERA, OBSERVABLES
from roughsim.results.members import Members
from roughsim.results.pressed import SHARED, SOME_LOAD, overshoot, whole
from roughsim.scene.numerics import QUADRANTS

_MAP_NOTE = (
    "value of the map itself, without waves shorter than its pixels resolve; n counts its four quadrants, which give "
    "the scatter"
)
_MAP_SOURCES = {
    **errors.SOURCES,
    "statistical": "95 % error of the mean over many maps of this size from the same surface, by the scatter of the "
    f"four quadrants, {SHARED:g} times as they share the longest waves; Student t of three degrees of freedom",
    "size": "difference of the mean of the four quadrants from the map: they have no wave longer than themselves, and "
    "twice the edge per area",
}


OfColumn = Callable[[str], Mean]  # the mean of an observable by column


class Drawn:
    """Surfaces drawn from C(q), in any number."""

    drawn = True  # from C(q), so that means are continued to shorter waves
    sources = errors.SOURCES  # the parts of an error, in words
    notes: tuple[str, ...] = ()  # on each estimate

    def __init__(self, members: Members):
        self.scene, self.members, self.numerics = members.scene, members, members.numerics

    def independent(self, *beside: str) -> list[int]:
        """Return the numbers of independent surfaces: the sound members of the lowest level of each column."""
        lowest = (self.numerics.of_column(name)[0] for name in (*self.numerics.columns, *beside))
        return [len(self.members.sound(level)) for level in lowest]

    def size_error(self, observable: str, column: str, of_levels: OfColumn) -> Array | float:
        """Return the relative error of an observable by the finite cell."""
        lengths, parts = self.numerics.lengths, self.numerics.parts(column)
        error = size_error(self.scene, lengths, observable, column, parts)
        if observable in OBSERVABLES and OBSERVABLES[observable].asked == CAMERA:
            return np.hypot(error, prediction.beyond_cell(self.scene, min(lengths)))
        return error

    def scattered(self, mean: Mean, column: str, of_levels: OfColumn) -> Mean:
        """Return the mean of a column with the scatter of its surfaces."""
        return mean


class Map(Drawn):
    """A pressed map and its four quadrants."""

    drawn, sources, notes = False, _MAP_SOURCES, (_MAP_NOTE,)

    def independent(self, *beside: str) -> list[int]:
        """Return the number of sound quadrants; 0 without the map."""
        sound = super().independent(QUADRANTS)
        return [0 if 0 in sound else sound[-1]]

    def size_error(self, observable: str, column: str, of_levels: OfColumn) -> Array | float:
        """Return the relative difference of the mean of the quadrants from the map; unknown unless all are there.

        It is the error of the size of the map and of its edges: quadrants have twice the edge per area.
        """
        of_map, quadrants = of_levels(column), of_levels(QUADRANTS)
        if not whole(self.members):
            return np.array(np.nan)
        with np.errstate(all="ignore"):  # 0/0 at rest
            difference = np.abs(quadrants.value / of_map.value - 1.0)
        return np.asarray(np.nan_to_num(difference, posinf=0.0))

    def scattered(self, mean: Mean, column: str, of_levels: OfColumn) -> Mean:
        """Return the mean of the map with `SHARED` times the scatter of its quadrants about their mean.

        Its deviation from the mean over many such maps is the statistical error.
        """
        if column == QUADRANTS:
            return mean
        quadrants = of_levels(QUADRANTS)
        if overshoot(self.members) > SOME_LOAD:
            mean = mean.with_errors(bandwidth=np.nan)
        (rows,) = quadrants.influence.values()  # all levels see the same surfaces
        with np.errstate(all="ignore"):  # 0/0 at rest, and without yielding
            rows = np.nan_to_num(rows * (SHARED * mean.value / quadrants.value))
        return replace(mean, influence=dict.fromkeys(mean.influence, rows))
