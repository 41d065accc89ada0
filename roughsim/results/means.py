"""`Means`: the counted members of a run folder, and their means with errors."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.estimate.cell_size import size_error_of_sum
from roughsim.estimate.correlation import correlation_of
from roughsim.estimate.errors import SOURCES, Estimate, estimate
from roughsim.estimate.ladder import Pair
from roughsim.estimate.levels import Values, notes_of, values_of
from roughsim.estimate.rounds import Counts, Rounds, Verdict, judge, replay
from roughsim.estimate.sliding import SLIDING_OBSERVABLES, sliding_estimate, with_background
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, NUMBERS, OBSERVABLES
from roughsim.prediction.scans import scan_part
from roughsim.results.members import Damaged, Members, identity_of
from roughsim.results.share import NOTE, at_other_speed, has_own_share, times_share, with_warming
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING, Numerics
from roughsim.sliding.path import coarser_grid
from roughsim.store.member_files import member_path, read_member


class Means:
    """State of a run folder at the time of opening; `refresh` reads members written since.

    Attributes
    ----------
    folder : Path
        Path of the folder.
    scene : Scene
        The physics.
    numerics : Numerics
        Levels, cell and tolerances.
    seed : int
        Seed of all random streams.
    until : dict of str to float
        Relative total 95 % errors at which the run stops.
    max_realizations : int
        Largest number of members of a level.
    heat_partition : ndarray
        Share of the heat, per speed: stated by the scene, or by the theory under the rules "mean" and "total".
        Under these rules measured temperatures are reported with the share of their own column: `share`.
    reasons : list of [str, str, str]
        Choices of the plan, each with its value and reason; empty if the numerics were given.
    members : Members
        The members that were read, by level and index, without fields.
    damaged : dict of (int, int) to str
        Reasons for unusable files by level and index; empty unless opened with ``damaged="skip"``.
    """

    drawn = True  # whether the surfaces are drawn from C(q), or are a map without shorter waves
    sources: Mapping[str, str] = SOURCES  # the parts of an error, in words

    def __init__(self, folder: Path, description: dict[str, Any], scene: Scene, numerics: Numerics, treatment: Damaged):
        self.folder, self.scene, self.numerics = folder, scene, numerics
        self.seed = scene.ensemble.seed
        self.until = dict(scene.ensemble.until)
        self.max_realizations = scene.ensemble.max_realizations
        self.heat_partition = prediction.heat_partition(scene)
        self.reasons: list[list[str]] = description["reasons"]
        self.members = Members(folder, numerics, scene.speeds, identity_of(description), treatment)
        self.damaged = self.members.damaged
        self._lowest = [numerics.of_column(column)[0] for column in numerics.columns]  # levels
        # a member never changes once it is read: tables of many of them, and results that are asked for again and again
        self._pairs: dict[tuple[str, Counts], list[Pair]] = {}
        self._values: dict[tuple[str, str, bool, Counts], Values] = {}
        self._verdicts: dict[tuple[Any, ...], Verdict] = {}

    def refresh(self) -> None:
        """Read the members written since the last call, up to the first gap of each level.

        RecordError if one is damaged or of another run, OSError if one cannot be read now, which is no damage.
        """
        self.members.refresh(self.max_realizations)

    @property
    def rounds(self) -> Rounds:
        """Progress of the run: its rounds, complete up to the last one."""
        return replay(self.numerics, self.max_realizations, self.members.available, self._judged)

    @property
    def counts(self) -> Counts:
        """Number of counted members of each level: the members of the last complete round."""
        return self.rounds.counts

    @property
    def realizations(self) -> int:
        """Number of counted members of the lowest level of the main column."""
        return self.counts[self._lowest[-1]]

    @property
    def target_met(self) -> bool:
        """Whether the targets of `until` are met."""
        return self.rounds.met

    @property
    def finished(self) -> bool:
        """Whether no round follows."""
        return self.rounds.finished

    @property
    def missing(self) -> list[str]:
        """Names, as "L0-000003", of members that are missing although later ones exist; none once it has finished."""
        rounds = self.rounds
        return [] if rounds.finished else self.members.missing(rounds.wanted)

    @property
    def failed(self) -> int:
        """Number of counted members of single contacts that did not converge."""
        counts = self.counts
        failed = {(level, i) for level in self.numerics.single for i in self.members.failed(level, counts[level])}
        return len(failed - set(self.damaged))

    @property
    def slides(self) -> bool:
        """Whether the column sliding has a sound member."""
        slide = self.numerics.slide
        return slide is not None and bool(self.members.sound(slide, self.counts[slide]))

    @property
    def scanned(self) -> bool:
        """Whether the surfaces are drawn from a C(q) that was measured on maps."""
        return self.drawn and self.scene.scanned

    @property
    def extent(self) -> str:
        """The number of realizations, in words."""
        return f"{self.realizations} realizations"

    @property
    def independent(self) -> int:
        """Number of sound members of the lowest level, smallest over the columns."""
        counts = self.counts
        return min(len(self.members.sound(level, counts[level])) for level in self._lowest)

    def kept(self, level: int, name: str = "pressure") -> list[int]:
        """Return the sound counted members of a level that store this field, or the pressure to compute it from."""
        return self.members.kept(level, name, self.members.sound(level, self.counts[level]))

    def column(self, column: str | None) -> str:
        """Return the name of a column; None: capped, else elastic. ValueError if it is missing."""
        name = self.numerics.columns[-1] if column is None else column
        if name not in self.numerics.columns:
            raise ValueError(f"column = {name!r} is not in this run; it has {', '.join(self.numerics.columns)}")
        return name

    def picture(self, column: str | None = None) -> int:
        """Return the finest level of a column in the run's cell with counted members."""
        levels = [pair.level for pair in self.pairs(column)]
        return next(level for level in reversed(levels) if self.numerics.levels[level].cell is None)

    def pairs(self, column: str | None = None, counts: Counts | None = None) -> list[Pair]:
        """Return the sound members of a column's levels, lowest first; levels without any are left out.

        The counted members, or the first `counts` of each level. ValueError if there is none.
        """
        name, counts = self.column(column), counts or self.counts
        if (name, counts) not in self._pairs:
            pairs: dict[int | None, Pair] = {}
            for level in self.numerics.of_column(name):
                below, rows = self.numerics.below(level), self.members.sound(level, counts[level])
                if rows and (below is None or below in pairs):
                    lower = None if below is None else self.members.sample(level, rows, below=True)
                    stream = self.numerics.stream(level)
                    pairs[level] = Pair(level, stream, self.members.sample(level, rows), lower)
            self._pairs[name, counts] = list(pairs.values())
        if not self._pairs[name, counts]:
            raise ValueError(f"{self.folder} has no sound realization yet; let it run first")
        return self._pairs[name, counts]

    def values(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True, counts: Counts | None = None
    ) -> Values:
        """Return the values of an observable over the counted members, with all heat in the moving body.

        `extrapolated`, or at the highest cut-off. `counts` as in `pairs`, errors as `estimate`.
        """
        if observable not in OBSERVABLES:
            raise ValueError(f"observable = {observable!r} is unknown; choose one of {', '.join(OBSERVABLES)}")
        name, counts = self.column(column), counts or self.counts
        key = observable, name, extrapolated, counts
        if key not in self._values:
            pairs = self.pairs(name, counts)
            self._values[key] = values_of(
                self.scene, name, observable, pairs, extrapolated=extrapolated, continued=self.drawn
            )
        return self._values[key]

    def reported(self, observable: str, column: str | None = None, counts: Counts | None = None) -> Values:
        """Return `values` for reports: temperatures with their share of the heat."""
        values = self.values(observable, column, counts=counts)
        return times_share(values, self._share(column, counts)) if OBSERVABLES[observable].heated else values

    def _share(self, column: str | None, counts: Counts | None = None) -> Values | Array:
        """Return the share of the heat in the reported temperatures of a column, per speed.

        Under the rules "mean" and "total" it follows from the column's own contacts. Else it is given by the scene,
        (speeds,). Arguments and errors as `values`.
        """
        own = has_own_share(self.scene)
        return self.values("heat_partition", column, counts=counts) if own else self.heat_partition

    def share(self, column: str | None = None) -> Array:
        """Return the share of the heat, (speeds,), in the reported temperatures of a column."""
        share = self._share(column)
        return share.mean if isinstance(share, Values) else share

    def shares(self) -> dict[str, Array]:
        """Return the share of the heat, (speeds,), in the reported temperatures of the theory and each column."""
        return {"theory": self.heat_partition} | {column: self.share(column) for column in self.numerics.columns}

    def heat_share(self, speed: float, column: str | None = None) -> float:
        """Return the share of the heat in the reported temperatures of a column, at any speed, m/s."""
        speed = abs(speed)
        if speed in self.scene.speeds:
            return float(self.share(column)[self.scene.speeds.index(speed)])
        return at_other_speed(self.scene, speed, self.heat_partition, self.share(column))

    def size_error(self, observable: str, column: str, values: Values) -> Array:
        """Return the relative error by the finite cell, over speeds or of one entry."""
        parts = self.numerics.parts(column)
        return size_error_of_sum(self.scene, self.numerics.lengths, parts, observable, column, values.from_part)

    def estimate(self, observable: str, column: str | None = None) -> Estimate:
        """Return the mean of an observable with its errors.

        Parameters
        ----------
        observable : str
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.
        column : {"smoothed", "capped", "elastic", "sliding"}, optional
            Default: capped for a scene with a hardness, else elastic.

        Returns
        -------
        Estimate
            Arrays over speed, or of one entry. Temperatures have the heat share used (`share`), and include its errors;
            in the column sliding, the share follows from its own heat.

        ValueError if there is no such observable or column, or no realization yet.
        """
        if column == SLIDING:
            single = self._estimate(observable, all_heat=True)
            result = sliding_estimate(observable, single, self._slide_numbers(), self._coarsening())
        else:
            result = self._estimate(observable, column)
        speeds = self.scene.speeds if OBSERVABLES[observable].per_speed else ()
        return replace(result, speeds=speeds, sources=self.sources)

    def estimates(self, column: str | None = None) -> dict[str, Estimate]:
        """Return the estimates of all observables of a column, by their names; arguments and errors as `estimate`."""
        names = SLIDING_OBSERVABLES if column == SLIDING else OBSERVABLES
        return {name: self.estimate(name, column) for name in names}

    def _estimate(
        self, observable: str, column: str | None = None, counts: Counts | None = None, *, all_heat: bool = False
    ) -> Estimate:
        """Return the estimate of single contacts, with `all_heat` in the moving body or with the share of a column."""
        name = self.column(column)
        values = self.values(observable, name, counts=counts)
        record = OBSERVABLES[observable]
        notes = notes_of(self.scene, self.numerics, name, observable, values)
        factors: tuple[str, ...] = (observable,)
        if record.heated and not all_heat:
            values = self.reported(observable, name, counts)
            if has_own_share(self.scene):
                notes, factors = (*notes, NOTE), (observable, "heat_partition")
        return estimate(
            observable,
            values,
            notes,
            size=self.size_error(observable, name, values),
            solver=record.solver_share * self.numerics.tolerance,
            scan=scan_part(self.scene, *factors) if self.scanned else None,
        )

    def _judged(self, counts: Counts) -> Verdict:
        """Return the verdict on these counts of members, remembered because each round is judged repeatedly."""
        key = counts, self.max_realizations, *self.until.items()
        if key in self._verdicts:
            return self._verdicts[key]

        def totals(observable: str, column: str, counts: Counts) -> tuple[Values, Estimate]:
            return self.reported(observable, column, counts), self._estimate(observable, column, counts)

        if all(self.members.sound(level, counts[level]) for level in self._lowest):
            verdict = judge(self.numerics, self.until, self.max_realizations, counts, totals)
        else:
            verdict = Verdict(False, None, counts, "no contact of its lowest level has converged", {})
        return self._verdicts.setdefault(key, verdict)

    def contact_temperature(self, column: str, warming: Array) -> Estimate:
        """Return T₀ + T_flash of a column over speed; `warming` is T₀ of single contacts with all the heat, K."""
        flash = self.estimate("flash_temperature", column)
        if column == SLIDING:
            return with_background(flash, self._slide_numbers()["sliding_background"])
        own = has_own_share(self.scene)
        return with_warming(flash, self.estimate("heat_partition", column) if own else self.heat_partition, warming)

    def correlation(self, distance: Array, column: str | None = None) -> tuple[Array, Array]:
        """Return g_σ(r) at the highest cut-off of a column and its standard error, Pa².

        `distance` is r, m, one-dimensional; ValueError beyond half the diagonal of the cell.
        """
        pairs = self.pairs(column)
        reach = pairs[0].sample.reach
        if distance.max(initial=0.0) > reach * (1 + 1e-12):
            raise ValueError(
                f"distance = {distance.max():.4g} m exceeds half the diagonal of the cell, {reach:.4g} m; ask for "
                "shorter distances"
            )
        return correlation_of(pairs, distance)[:2]

    def curves(self) -> dict[str, Array]:
        """Return the curves of the column sliding over the `slid_distance`, m; ValueError without a sound member.

        Arrays (members, speeds, distances) or (members, distances), by the names in `observables.catalogue.CURVES`.
        """
        level, indices = self._slides()
        rows = [read_member(member_path(self.folder, level, index)).curves for index in indices]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]} | {AXIS: rows[0][AXIS]}

    def _slides(self) -> tuple[int, list[int]]:
        """Return the level of slides, and its sound counted members; ValueError if there is none."""
        level = self.numerics.slide
        if level is None:
            raise ValueError(f'{self.folder} has no column "sliding": its scene has history = "frozen"')
        if sound := self.members.sound(level, self.counts[level]):
            return level, sound
        raise ValueError(f"{self.folder} has no sound member that slides yet; let it run first")

    def _slide_numbers(self) -> dict[str, Array]:
        """Return the numbers of the counted slides, (members, speeds); errors as `_slides`."""
        level, indices = self._slides()
        return {name: self.members.numbers(level, name, indices) for name, n in NUMBERS.items() if n.of_slide}

    def _coarsening(self) -> float:
        """Return the ratio of pixels of slides, coarser grid over own grid; 1 without a coarser grid."""
        level = self._slides()[0]
        grid = self.numerics.grid(level)
        coarser = coarser_grid(grid, self.numerics.levels[level].q_max)
        return 1.0 if coarser is None else coarser.spacing[0] / grid.spacing[0]
