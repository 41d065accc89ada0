"""`Counted`: an opened run folder. It says which members count, and gives the values of observables in them."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.ladder import Values, values_of
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.results.reader import Reader, identity_of
from roughsim.results.share import at_other_speed, has_own_share, times_share
from roughsim.results.stopping import last_needed
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.sliding.path import coarser_grid


class Counted:
    """A run folder as it stands when it is opened; `refresh` reads the members that have come since.

    Its attributes are those of `roughsim.results.run.Run`.
    """

    drawn = True  # whether the surfaces are drawn from C(q); else they are a map, which ends with its own waves
    # realizations without a gap, and targets: what was computed holds until a `refresh` finds others, or damaged files
    _basis: tuple[int, dict[str, float]] | None = None

    def __init__(
        self, folder: Path, description: dict[str, Any], scene: Scene, numerics: Numerics, *, skip_damaged: bool = False
    ):
        self.folder, self.scene, self.numerics = folder, scene, numerics
        self.seed: int = description["seed"]
        self.until: dict[str, float] = description["until"]
        self.max_realizations: int = description["max_realizations"]
        self.heat_partition: Array = np.array(description["heat_partition"])
        self.reasons: list[list[str]] = description["reasons"]
        self._reader = Reader(folder, numerics, scene.speeds, identity_of(description), skip_damaged)
        self.members = self._reader.members
        self.damaged = self._reader.damaged

    @property
    def missing(self) -> list[str]:
        """Names, as "L0-000003", of members that are missing although later ones exist; none once targets are met."""
        return [] if self.target_met else self._reader.missing(self.max_realizations)

    def refresh(self) -> None:
        """Read the members that have come since, in order, up to the first gap; damaged ones again.

        RecordError if one is damaged or of another run, OSError if one cannot be read now, which is no damage.
        """
        again = bool(self.damaged)
        try:
            self._reader.refresh(self.max_realizations)
        finally:
            basis = self._reader.available, dict(self.until)
            if again or basis != self._basis:
                self._basis = basis
                self._counted: tuple[int, bool] | None = None
                self._samples: dict[tuple[str, bool], list[Sample]] = {}
                self._values: dict[tuple[str, str, bool], Values] = {}

    def take(self, level: int, index: int) -> bool:
        """Read one member now, also beyond a gap; False if its file is missing. Errors as `refresh`."""
        return self._reader.take(level, index)

    def save(self) -> None:
        """Write the summary: who opens the run next need not open the files of its members as HDF5."""
        self._reader.save()

    @property
    def realizations(self) -> int:
        """How many realizations count: the first n at which the targets are met, or all that exist without a gap."""
        return self._count()[0]

    @property
    def target_met(self) -> bool:
        """Whether the targets of `until` are met."""
        return self._count()[1]

    def _count(self) -> tuple[int, bool]:
        """How many realizations count, and whether the targets are met; computed once after each `refresh`."""
        if self._counted is None:
            last = last_needed(self._reader, self.scene, self.column(None), self.until) if self.until else None
            self._counted = (self._reader.available, False) if last is None else (last + 1, True)
        return self._counted

    @property
    def failed(self) -> int:
        """How many of the realizations that count did not converge at some level."""
        march, count = self.numerics.march, self.realizations
        damaged = {index for level, index in self.damaged if level != march and index < count}
        return self.realizations - len(self.sound(self.realizations)) - len(damaged)

    @property
    def slides(self) -> bool:
        """Whether there is a sound member of the column sliding."""
        march, count = self.numerics.march, self.realizations
        return march is not None and len(self.members.failed(march, count)) < len(
            self.numerics.levels[march].indices(count)
        )

    @property
    def coarsening(self) -> float:
        """Pixel of the coarser grid of the marches over that of their own; 1 where there is no coarser one."""
        level = self.numerics.march or 0
        grid = self.numerics.grid(level)
        coarser = coarser_grid(grid, self.numerics.levels[level].q_max)
        return 1.0 if coarser is None else coarser.spacing[0] / grid.spacing[0]

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that computed the first member, by name."""
        known: dict[str, str] = next(iter(self.members.values())).provenance["versions"]
        return known

    def sound(self, count: int) -> list[int]:
        """Return the indices below `count` of which every level of single contacts is sound."""
        return self.members.sound(count)

    def column(self, column: str | None) -> str:
        """Return the name of a column; None is the capped one, or else the elastic one. ValueError if it is missing."""
        name = self.numerics.columns[-1] if column is None else column
        if name not in self.numerics.columns:
            raise ValueError(f"column = {name!r} is not in this run; it has {', '.join(self.numerics.columns)}")
        return name

    def samples(
        self, column: str | None = None, rows: list[int] | None = None, *, spectra: bool = True
    ) -> list[Sample]:
        """Return the numbers of a column's levels, coarsest first, over the realizations that count (or `rows`).

        The stress spectra are empty without `spectra`.
        """
        key = self.column(column), spectra
        if rows is None and key not in self._samples:
            self._samples[key] = self.samples(column, self.sound(self.realizations), spectra=spectra)
        if rows is None:
            return self._samples[key]
        levels, indices = self.numerics.of_column(key[0]), np.array(rows, np.int64)
        return [self._reader.sample(level, indices, with_spectra=spectra) for level in levels]

    def values(self, observable: str, column: str | None = None, *, extrapolated: bool = True) -> Values:
        """Return the values of an observable, a row per sound realization, with all heat in the moving body.

        Not extrapolated they are those of the highest cut-off. Errors as `estimate`.
        """
        if observable not in OBSERVABLES:
            raise ValueError(f"observable = {observable!r} is unknown; choose one of {', '.join(OBSERVABLES)}")
        key = observable, self.column(column), extrapolated
        if self._sound_rows() and key not in self._values:
            samples = self.samples(column, spectra=OBSERVABLES[observable].spectra)
            self._values[key] = values_of(
                self.scene, key[1], observable, samples, extrapolated=extrapolated, continued=self.drawn
            )
        return self._values[key]

    def share_values(self, column: str | None = None) -> Values | Array:
        """Return the share of the heat that the temperatures of a column are reported with, per speed.

        Under the rules "mean" and "total" it is that of the column's own contacts, a row per sound realization. Else
        it is the one that the scene states, (speeds,). Errors as `estimate`.
        """
        if not has_own_share(self.scene):
            return self.heat_partition
        return self.values("heat_partition", column)

    def share(self, column: str | None = None) -> Array:
        """Return the mean of `share_values`, (speeds,)."""
        share = self.share_values(column)
        return share.extrapolated.mean(axis=0) if isinstance(share, Values) else share

    def shares(self) -> dict[str, Array]:
        """Return the share of the heat, (speeds,), that the theory and each measured column are reported with."""
        return {"theory": self.heat_partition} | {column: self.share(column) for column in self.numerics.columns}

    def heat_share(self, speed: float, column: str | None = None) -> float:
        """Return the share of the heat that the temperatures of a column are reported with, at any speed, m/s."""
        speed = abs(speed)
        if speed in self.scene.speeds:
            return float(self.share(column)[self.scene.speeds.index(speed)])
        theory = float(prediction.heat_partition(self.scene, (speed,))[0])
        if not has_own_share(self.scene):
            return theory
        known, own = self.heat_partition, self.share(column)
        if self.scene.sliding.heat_partition == "mean":  # at rest the conductivities alone share the heat
            at_rest = prediction.heat_partition(self.scene, (0.0,))
            known, own = np.concatenate([at_rest, known]), np.concatenate([at_rest, own])
        return at_other_speed(theory, known, own)

    def reported(self, observable: str, column: str | None = None) -> Values:
        """Return `values` as they are reported: temperatures with their share of the heat."""
        values = self.values(observable, column)
        return times_share(values, self.share_values(column)) if OBSERVABLES[observable].heated else values

    def _sound_rows(self) -> list[int]:
        """The sound realizations that count; ValueError if there is none."""
        if rows := self.sound(self.realizations):
            return rows
        raise ValueError(f"{self.folder} has no sound realization yet; let it run first")

    def spectra(self, level: int, indices: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return the wavenumbers of a level, rad/m, and the stress spectra of sound members of it, Pa²."""
        return self._reader.spectra(level, indices)
