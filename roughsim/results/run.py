"""`Run`: an opened run folder, with its rounds, means, fields and arrays."""

from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from roughsim.errors import RecordError
from roughsim.estimate.mean import Mean
from roughsim.estimate.rounds import Counts, Verdict, judge, replay
from roughsim.grid import Array, Grid
from roughsim.observables.member import Member
from roughsim.planning import limits
from roughsim.prediction.statements import ByMean, takes_all
from roughsim.results import heated, pressed
from roughsim.results.arrays import OF_LEVELS, arrays_of, attributes_of, lazily_read
from roughsim.results.description import RunDescription
from roughsim.results.heated import Field
from roughsim.results.map_ratio import MapRatio
from roughsim.results.members import Damaged, Members
from roughsim.results.simulated import Estimates
from roughsim.results.table import Labelled, to_dataset
from roughsim.scene import Scene
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import Remark
from roughsim.show.table import table_of
from roughsim.show.text import marked, plain
from roughsim.store.member_files import fields_path, read_fields
from roughsim.table import Estimate

if TYPE_CHECKING:  # not among the packages that roughsim needs
    import xarray


class Run(Estimates):
    """State of a run folder at the time of opening; `refresh` reads members written since.

    The reference of functions lists the attributes and methods for users. The others may change.

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
    reasons : tuple of Remark
        Choices of the plan, each with its value and reason; empty if the numerics were given.
    members : Members
        The members that were read, by level and index, without fields.
    damaged : dict of str to str
        Reasons by the names of unusable files; empty unless opened with ``damaged="skip"``.
    rounds : Rounds
        Progress of the run. The members of the last complete round count.
    """

    def __init__(self, folder: Path, description: RunDescription, scene: Scene, treatment: Damaged):
        super().__init__(Members(folder, description, scene, treatment))
        self.seed = scene.ensemble.seed
        self.until = scene.ensemble.ends
        self.max_realizations = scene.ensemble.most
        self.reasons = description.numerics.reasons
        # way in which a pressed map was made periodic
        self.edges = description.press.get("edges", "")
        self.damaged = self.members.damaged
        self._verdicts: dict[
            tuple[object, ...], Verdict
        ] = {}  # each round is judged again after each new member
        self.recount()

    def refresh(self) -> None:
        """Read the members written since the last call.

        RecordError if one is damaged or of another run, OSError if one cannot be read now, which is no damage.
        """
        self.members.read()
        self.recount()

    def add(self, members: Iterable[Member]) -> None:
        """Take members that this process has computed; RecordError if they are of another version."""
        for member in members:
            self.members.check_computed(member)
            self.members.add(member)
        self.recount()

    def recount(self) -> None:
        """Let the members of the last complete round count."""
        there, most = self.members.available, self.max_realizations
        self.rounds = replay(self.numerics, most, there, self._judged)
        self.count(self.rounds.counts)

    def _judged(self, counts: Counts) -> Verdict:
        """Return the verdict on these counts of members, which count from now on."""
        key = counts, self.max_realizations, *self.until.items()
        if key in self._verdicts:
            return self._verdicts[key]
        self.count(counts)

        def totals(observable: str, column: str, _: Counts) -> tuple[Mean, Estimate]:
            return self.reported(observable, column), self.simulated(column).estimate(observable)

        if self.independent:
            verdict = judge(self.numerics, self.until, self.max_realizations, counts, totals)
        else:
            verdict = Verdict(
                False, None, counts, "no contact of its lowest level has converged", {}
            )
        return self._verdicts.setdefault(key, verdict)

    @property
    def warnings(self) -> list[str]:
        """A line for each number of the scene beyond the model, and for each assumption that is easily missed."""
        return self.judged.warnings

    @property
    def remarks(self) -> list[Remark]:
        """The same as records, the most serious first."""
        return self.judged.remarks

    @property
    def judged(self) -> limits.Plausibility:
        """Sizes and assumptions of the scene, and its warnings with those of a pressed map."""
        measured = None
        if takes_all(self.scene) and self.independent > 1 and not self.scene.tables:
            flash, share = (
                self.estimate(name).mean.ravel() for name in ("flash_temperature", "heat_partition")
            )
            measured = ByMean(self.column(None), flash, share, share * flash)
        judged = limits.judge(self.scene, self.numerics, drawn=self.drawn, measured=measured)
        beside = self.map_ratio
        return replace(
            judged,
            remarks=judged.remarks + pressed.remarks(self.members),
            of_run=() if beside is None else (beside.statement,),
        )

    @property
    def map_ratio(self) -> MapRatio | None:
        """T_flash of the measured map itself over that of drawn surfaces; None of a run without it."""
        return MapRatio.read(self.folder, len(self.scene.speeds))

    @property
    def angles(self) -> dict[str, float]:
        """Directions of sliding with their own T_flash, radians: along and across the lay of a map, and "asked".

        Empty for drawn surfaces, and while the map or a quadrant is missing.
        """
        found = pressed.directions(self.members)
        return found[0].angles if len(found) == 1 + pressed.PARTS else {}

    @property
    def over_twin(self) -> Array | None:
        """Ratio of T_flash of a map and of its phase-randomized surrogate, (speeds,); None without it."""
        found = (each.over_twin for each in pressed.directions(self.members))
        return next((ratio for ratio in found if ratio is not None), None)

    def in_direction(self, name: str, column: str | None = None) -> Estimate:
        """Return T_flash of a map in one direction of sliding.

        Parameters
        ----------
        name : str
            One of `angles`; LookupError for another one.
        column : str, optional
            As in `estimate`.

        Returns
        -------
        Estimate
            The mean over directions, times its ratio in the contact, with the errors of both.
        """
        mean = self.estimate("flash_temperature", column)
        return pressed.in_direction(mean, pressed.directions(self.members), name)

    def needed_size(self) -> list[str]:
        """Return a line on the map whose statistical error of T_flash is the target; empty if none is needed."""
        goal = dict(self.scene.ensemble.until).get("flash_temperature", np.inf)
        if self.drawn:
            return []
        return pressed.needed_size(self.estimate("flash_temperature"), goal, self.scene.speeds)

    @property
    def realizations(self) -> int:
        """Number of counted members of the lowest level of the main column."""
        return self.counts[self.numerics.of_column(self.column(None))[0]]

    @property
    def target_met(self) -> bool:
        """Whether the targets of `until` are met."""
        return self.rounds.met

    @property
    def finished(self) -> bool:
        """Whether no round follows."""
        return self.rounds.finished

    @property
    def needed(self) -> Counts:
        """Expected final number of members of each level; in the first round the numbers of the round."""
        return self.rounds.verdict.needed

    @property
    def total_errors(self) -> dict[str, float]:
        """Relative total error, 95 %, of each target after the last complete round; empty before the first."""
        return self.rounds.verdict.errors

    def unknown_parts(self, name: str) -> list[str]:
        """Return the parts of the error of the target `name` that are unknown, and not in `total_errors`."""
        return [part for target, part in self.rounds.verdict.unknown if target == name]

    @property
    def missing(self) -> list[str]:
        """Names, as "L0-000003", of members that are missing although later ones exist; none once it has finished."""
        return [] if self.finished else self.members.missing(self.rounds.wanted)

    @property
    def failed(self) -> int:
        """Number of counted members of single contacts that did not converge."""
        return sum(len(self.members.failed(level)) for level in self.numerics.single)

    @property
    def extent(self) -> str:
        """The number of realizations, or of pressed maps, in words."""
        if self.drawn:
            return f"{self.realizations} realizations"
        return "the map itself" if self.realizations else "nothing of the map yet"

    def kept(self, level: int, name: str = "pressure") -> list[int]:
        """Return the sound counted members of a level that store the field `name`, or the pressure that it needs."""
        return self.members.kept(level, name)

    def picture(self, column: str | None = None) -> int:
        """Return the finest level of a column in the run's cell with counted members."""
        levels = [sample.level for sample in self.samples(column)]
        return next(level for level in reversed(levels) if self.numerics.levels[level].cell is None)

    def fields(
        self,
        name: str,
        column: str | None = None,
        *,
        speed: float | None = None,
        direction: float = 0.0,
    ) -> Iterator[tuple[int, Field]]:
        """Iterate over the kept fields of a column's finest level in the run's cell, one in memory at a time.

        ValueError if there is no such field or column, the speed is missing, or no realization kept its fields.
        RecordError if a file is damaged.

        Parameters
        ----------
        name : {"heights", "pressure", "heat_flux", "temperature", "seen"}
            Composite heights, m; pressure, Pa; the frictional heat μσ|v| of both bodies, W/m²; the temperature of the
            moving body with its share of the heat, above the mean of the cell, K, after the slide from rest over the
            `slid_distance` of the numerics; "seen", the same as the [camera] of the scene sees it. The last three are
            computed from the stored pressure.
        column : str, optional
            As in `estimate`.
        speed : float, optional
            v, m/s, for heat_flux, temperature and seen: any speed, also one without moments in the run; negative: the
            opposite direction.
        direction : float
            Angle of sliding, radians from axis 0 towards axis 1; axis 0 is along the grooves of faces with a lay.

        Returns
        -------
        iterator of (int, ndarray)
            Index of the realization, and its field of the shape of the level, float32.
        """
        heated.check_field(name, speed, direction)
        level = self.numerics.picture(self.column(column))
        indices = self.kept(level, name)
        if not indices:
            raise self.not_kept(level)
        return (
            (index, self.field(level, index, name, speed=speed, direction=direction))
            for index in indices
        )

    def field(
        self,
        level: int,
        index: int,
        name: str,
        *,
        speed: float | None = None,
        direction: float = 0.0,
    ) -> Field:
        """Return one field of the kept realization `index` of a level; name, speed and direction as in `fields`."""
        heated.check_field(name, speed, direction)
        path = fields_path(self.folder, level, index)
        stored = name if speed is None else "pressure"
        field = read_fields(path, (stored,))[1][stored]
        if speed is None:
            return field
        if name == "heat_flux":
            return heated.heat_flux(self.scene, field, speed)
        column = self.numerics.levels[level].column
        return self.heated(name, field, self.grid(level), speed, direction, column)

    def heated(
        self,
        name: str,
        pressure: Field,
        grid: Grid,
        speed: float,
        direction: float = 0.0,
        column: str | None = None,
        scene: Scene | None = None,
    ) -> Field:
        """Return "temperature", or "seen", K, by a pressure, Pa, on any grid; speed and direction as in `fields`.

        The moving body takes the share of heat of a column. `scene` is the scene of the run with other layers on its
        bodies. ValueError for "seen" without a [camera].
        """
        if name == "seen" and self.scene.camera is None:
            raise self.not_asked("seen")
        made = heated.seen if name == "seen" else heated.temperature
        way = heated.Way(speed, direction, self.numerics.slid_distance)
        share = self.heat_share(speed, column, scene)
        return made(scene or self.scene, pressure, grid, way, share)

    def not_kept(self, level: int, index: int | None = None) -> ValueError:
        """Return the error for fields of a level that were not kept, with advice: of realization `index`, or of all."""
        if (level, index) in self.members.lost:
            return RecordError("; ".join(self.damaged.values()))
        missing = (
            "has kept no fields"
            if index is None
            else f"has not kept the fields of realization {index}"
        )
        index = index or 0
        if not self.drawn:
            advice = f"press the map in a new folder with --set numerics.keep_fields={index + 1}"
        else:
            call = f"rs.realize(run.scene, run.numerics, seed={self.seed}, level={level}, index={index})"
            advice = f"run the scene in a new folder with --keep-fields {index + 1}, or recompute one: {call}"
        return ValueError(f"{self.folder} {missing} at level {level}; {advice}")

    def __repr__(self) -> str:
        state = "finished" if self.finished else "not finished"
        if self.until:
            state += f", target {'' if self.target_met else 'not '}met"
        columns = ", ".join(self.numerics.columns)
        about = f"<{type(self).__name__} {plain(self.folder)}: {self.extent}, {state}; {columns}>"
        return "\n".join([about, *marked(self.remarks)])

    def _repr_html_(self) -> str:
        """The state of the run and its flash temperature in each column, for notebooks."""
        failed = f", {self.failed} failed and left out" if self.failed else ""
        state = f"{self.realizations} realizations{failed}" + (
            "; the target is met" if self.target_met else ""
        )
        lines = [self.scene.title or "untitled", f"{self.folder}: {state}", *marked(self.warnings)]
        if not self.independent:
            return in_notebook(*lines)
        flash = {name: self.estimate("flash_temperature", name) for name in self.numerics.columns}
        first = next(iter(flash.values()))
        rows = [
            first.heads(place) | {name: one.number(*place) for name, one in flash.items()}
            for place in np.ndindex(first.mean.shape)
        ]
        notes = (
            "± total error, 95 %. rs.compare(run) has the theory beside it, and all other observables.",
        )
        return in_notebook(*lines, table_of(rows, "flash_temperature, K", notes))

    def arrays(self) -> list[Labelled]:
        """Return all numbers of all counted members, and the kept fields, with names, axes and units."""
        self.samples()  # ValueError without a sound realization
        here = copy(self)
        here.folder = (
            self.folder.absolute()
        )  # an unpickled dataset may be used in another directory
        columns = [level.column for level in self.numerics.levels]
        shares = [
            self.share(column if column in self.numerics.columns else None) for column in columns
        ]
        return list(arrays_of(self.members, shares, here.field))

    def to_xarray(self) -> "xarray.Dataset":
        """Return all numbers of all counted members, and the kept fields, as an `xarray.Dataset`.

        Its dimensions are level, realization and speed, with column, q_c and cell of each level as coordinates, so that
        ``ds.flash_temperature.isel(level=-1).mean("realization")`` is a curve over speed of that level alone, which may
        be one in half the cell. Arrays that depend on the grid of a level have its number: ``pressure_L2``
        (kept_realization_L2, x_L2, y_L2), loaded lazily. Temperatures have the heat share `heat_partition`
        (level, speed). Failed members are NaN with converged = 0.

        ImportError if xarray is not installed: ``pip install 'roughsim[xarray]'``. ValueError if the run has no sound
        realization yet.
        """
        arrays = map(lazily_read, self.arrays())
        return to_dataset(arrays, OF_LEVELS, attributes_of(self.members))
