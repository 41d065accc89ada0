"""The members of a run in memory: each file is read once, and kept without its fields."""

from collections.abc import Iterable, Sequence

import numpy as np

from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.record import Sample
from roughsim.scene.numerics import Numerics
from roughsim.store.member_files import FIELDS, Member, Moments

Key = tuple[int, int]  # level and index


class Members(dict[Key, Member]):
    """Members by level and index, as one table for each level.

    `numerics` gives the levels, `speeds` are those of the numbers, m/s.
    """

    def __init__(self, numerics: Numerics, speeds: Sequence[float]):
        super().__init__()
        self.numerics, self.speeds = numerics, speeds
        self._streams = {level: numerics.stream(level) for level in numerics.single}

    def failed(self, level: int, count: int) -> list[int]:
        """Return the indices below `count` at which a level has a member without numbers."""
        return [i for i in range(count) if (level, i) in self and self[level, i].failure]

    def sound(self, level: int, count: int) -> list[int]:
        """Return the indices below `count` at which a level has numbers, and no level of the same surfaces failed."""
        alike = [other for other in self._streams if self._streams[other] == self._streams.get(level)]
        lost = {i for other in {*alike, level} for i in self.failed(other, count)}
        return [i for i in range(count) if i not in lost and (level, i) in self]

    def kept(self, level: int, name: str, indices: Iterable[int]) -> list[int]:
        """Return those of the members that store a field, or the pressure, which gives all other fields."""
        stored = name if name in FIELDS else "pressure"
        return [i for i in indices if stored in self[level, i].kept]

    def numbers(self, level: int, name: str, indices: Iterable[int], below: bool = False) -> Array:
        """Return a number of members of a level, or of the level below; (n, speeds) or (n, 1), NaN where it is not."""
        nothing = np.full(len(self.speeds) if NUMBERS[name].per_speed else 1, np.nan)
        rows = [one.numbers.get(name, nothing) if one else nothing for one in self._moments(level, indices, below)]
        return np.array(rows).reshape(-1, len(nothing))

    def spectra(self, level: int, indices: Iterable[int], below: bool = False) -> tuple[Array, Array]:
        """Return wavenumbers, rad/m, and stress spectra of members of a level, Pa²; NaN where there is none."""
        found = self._moments(level, indices, below)
        wavenumber = next((one.wavenumber for one in found if one), np.empty(0))
        nothing = np.full(len(wavenumber), np.nan)
        rows = [one.spectrum if one else nothing for one in found]
        return wavenumber, np.array(rows).reshape(len(rows), len(wavenumber))

    def sample(self, level: int, indices: list[int], below: bool = False) -> Sample:
        """Return the sample of sound members of a level, or what they have of the level below on the same surfaces."""
        numerics = self.numerics
        of_level, grid = numerics.levels[level], numerics.grid(level)
        if below:
            of_level, grid = numerics.levels[numerics.below(level) or 0], numerics.grid_below(level)
        return Sample(
            of_level.q_max,
            float(grid.shape[0]),
            np.array(indices, np.intp),
            {name: self.numbers(level, name, indices, below) for name in NUMBERS},
            *self.spectra(level, indices, below),
            0.5 * float(np.hypot(*grid.lengths)),
            numerics.levels[level].parts > 1,
        )

    def seconds(self, level: int) -> Array:
        """Return how long each member of a level took to compute, s."""
        members = [member for (of_level, _), member in self.items() if of_level == level]
        return np.array([sum(member.provenance["seconds"].values()) for member in members])

    def _moments(self, level: int, indices: Iterable[int], below: bool) -> list[Moments | None]:
        """Return what was measured of each member; None where it is not there or has failed."""
        found = (self[level, i].moments if (level, i) in self else [] for i in indices)
        return [moments[below] if len(moments) > below else None for moments in found]
