"""`Means`: the means of the counted members of a run, with their errors."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from roughsim import prediction
from roughsim.estimate.errors import spread_of
from roughsim.estimate.levels import FLASH, values_of
from roughsim.estimate.mean import Mean
from roughsim.estimate.rounds import Counts
from roughsim.estimate.telescoping import correlation_of
from roughsim.grid import Array, Grid
from roughsim.observables.catalogue import ASKED_BY, AXIS, OBSERVABLES, observables_of
from roughsim.observables.record import Observable, Sample
from roughsim.prediction.scans import scan_error
from roughsim.results import share
from roughsim.results.members import Members
from roughsim.results.surfaces import Drawn, Map
from roughsim.scene import Scene
from roughsim.scene.numerics import QUADRANTS, SLIDING


class Means:
    """The means of the counted members of a run; `Run` describes the attributes."""

    def __init__(self, members: Members):
        self.folder, self.numerics = members.folder, members.numerics
        self.scene, self.members = members.scene, members
        self.heat_partition = prediction.heat_partition(self.scene)
        kind = Map if self.numerics.of_column(QUADRANTS) else Drawn
        self.surfaces = kind(members)
        self.drawn = self.surfaces.drawn  # whether they are drawn from C(q)
        self.sources: Mapping[str, str] = self.surfaces.sources  # the parts of an error, in words
        # of the members that count; all observables follow from them, and most values are asked for repeatedly
        self._samples: dict[str, list[Sample]] = {}
        self._values: dict[tuple[str, str, bool], Mean] = {}

    def count(self, counts: Counts) -> None:
        """Let so many members of each level count."""
        if counts != self.counts:
            self.members.counts = counts
            self._samples.clear()
            self._values.clear()

    def grid(self, level: int) -> Grid:
        """Return the grid of the fields of a level, with the lay of the surfaces along x."""
        return self.numerics.grid(level).stretched(self.scene.lay)

    @property
    def sides(self) -> tuple[float, float]:
        """Sides of the cell, m."""
        return Grid((1, 1), self.numerics.lengths).stretched(self.scene.lay).lengths

    @property
    def counts(self) -> Counts:
        """Number of members of each level that count."""
        return self.members.counts

    @property
    def observables(self) -> dict[str, Observable]:
        """Observables of the run by name, those of the distribution of the temperature only if its scene asks."""
        return observables_of(self.scene.asks)

    @property
    def scanned(self) -> bool:
        """Whether the surfaces are drawn from a C(q) that was measured on maps."""
        return self.drawn and self.scene.scanned

    @property
    def independent(self) -> int:
        """Number of sound members of the lowest level, smallest over the columns; of a map its sound quadrants."""
        return min(self.surfaces.independent())

    def column(self, column: str | None) -> str:
        """Return the name of a column; None: capped, else elastic. ValueError if it is missing."""
        name = self.numerics.columns[-1] if column is None else column
        if not self.numerics.of_column(name) or name == SLIDING:
            raise ValueError(
                f"column = {name!r} is not in this run; it has {', '.join(self.numerics.columns)}"
            )
        return name

    def samples(self, column: str | None = None) -> list[Sample]:
        """Return the sound counted members of a column's levels, lowest first, each with the level below it.

        Levels without any are left out. ValueError if there is none.
        """
        name = self.column(column)
        if name not in self._samples:
            samples: dict[int | None, Sample] = {}
            for level in self.numerics.of_column(name):
                below = self.numerics.below(level)
                if self.members.sound(level) and (below is None or below in samples):
                    lower = None if below is None else self.members.sample(level, below=True)
                    samples[level] = replace(self.members.sample(level), below=lower)
            self._samples[name] = list(samples.values())
        if not self._samples[name]:
            raise ValueError(f"{self.folder} has no sound realization yet; let it run first")
        return self._samples[name]

    def slides(self) -> Sample:
        """Return the sample of the slides, with their T_flash as that of contacts; ValueError without a sound one."""
        level = self.numerics.slide
        if level is None:
            raise ValueError(
                f'{self.folder} has no column "sliding": its scene has history = "frozen"'
            )
        sample = self.members.sample(level)
        if not sample.rows.size:
            raise ValueError(f"{self.folder} has no sound member that slides yet; let it run first")
        numbers = sample.numbers | {FLASH: sample.numbers["sliding_flash_temperature"]}
        return replace(sample, numbers=numbers)

    def values(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True
    ) -> Mean:
        """Return the values of an observable over the counted members, with all heat in the moving body.

        `extrapolated`, or at the highest cut-off, with all parts of their errors. Errors raised as `estimate`.
        """
        if observable not in self.observables:
            record = OBSERVABLES.get(observable)
            fault = (
                f"not in this run, whose scene lacks {ASKED_BY[record.asked]}"
                if record
                else "unknown"
            )
            raise ValueError(
                f"observable = {observable!r} is {fault}; choose one of {', '.join(self.observables)}"
            )

        def of_levels(name: str, extrapolated: bool = True) -> Mean:
            """Return the mean with those parts of its error alone that the levels of a column show."""
            key = observable, name, extrapolated
            if key not in self._values:
                self._values[key] = values_of(
                    self.scene,
                    self.numerics.columns[-1] if name == QUADRANTS else name,
                    observable,
                    self.samples(name),
                    extrapolated=extrapolated,
                    continued=self.drawn,
                )
            return self._values[key]

        name = self.column(column)
        parts = {
            # of a map by its quadrants, both extrapolated
            "size": self.surfaces.size_error(observable, name, of_levels),
            "solver": OBSERVABLES[observable].solver_share * self.numerics.tolerance,
        }
        mean = of_levels(name, extrapolated).with_errors(**parts, **self.scan_part(observable))
        at_cut_off = partial(of_levels, extrapolated=extrapolated)
        return self.surfaces.scattered(mean, name, at_cut_off)

    def scan_part(self, observable: str) -> dict[str, Array]:
        """Return the relative error of an observable by the scans that C(q) was measured on; empty without them."""
        if not self.scanned:
            return {}
        return {"scan": scan_error(self.scene).get(observable, np.array(np.nan))}

    def reported(self, observable: str, column: str | None = None) -> Mean:
        """Return `values` for reports: temperatures with their share of the heat."""
        values = self.values(observable, column)
        if not OBSERVABLES[observable].heated:
            return values
        if share.has_own_share(self.scene):
            both = values * self.values("heat_partition", column)  # from the same surfaces
            # a cell and a tolerance change the temperatures of both bodies alike, and hardly their share
            alike = {part: values.errors[part] * self.share(column) for part in ("size", "solver")}
            return replace(both, errors={**both.errors, **alike})
        return values * self.heat_partition

    def share(self, column: str | None = None) -> Array:
        """Return the share of the heat, (speeds,), in the reported temperatures of a column."""
        own = share.has_own_share(self.scene)
        return self.values("heat_partition", column).value if own else self.heat_partition

    def share_text(self) -> str:
        """Return in words the share of the heat in the theory and in each column; one text if all are equal."""
        shares = {
            "theory": self.heat_partition,
            "calibrated": prediction.calibrated_share(self.scene),
        }
        shares |= {column: self.share(column) for column in self.numerics.columns}
        texts = {
            name: " to ".join(dict.fromkeys(f"{value:.3g}" for value in (share.min(), share.max())))
            for name, share in shares.items()
            if not np.isnan(share).all()
        }
        if len({*texts.values()}) == 1:
            return texts["theory"]
        return ", ".join(f"{text} ({name})" for name, text in texts.items())

    def heat_share(
        self, speed: float, column: str | None = None, scene: Scene | None = None
    ) -> float:
        """Return the share of the heat in the reported temperatures of a column, at any speed, m/s.

        `scene` is the scene of the run with other layers on its bodies, which change a share that follows from both.
        """
        speed = abs(speed)
        if speed in self.scene.speeds:
            own = float(self.share(column)[self.scene.speeds.index(speed)])
        else:
            own = share.at_other_speed(self.scene, speed, self.heat_partition, self.share(column))
        if scene is None or not share.has_own_share(scene):
            return own
        return share.with_other_layers(self.scene, scene, speed, own)

    @property
    def followed(self) -> float | None:
        """Distance that slides are followed, m, if it is less than the whole slid distance; else None."""
        level = self.numerics.slide
        distance = None if level is None else self.numerics.levels[level].followed
        return (
            distance
            if distance is not None and distance < max(self.scene.sliding.distances)
            else None
        )

    def correlation(self, distance: Array, column: str | None = None) -> tuple[Array, Array]:
        """Return g_σ(r) at the highest cut-off of a column and its standard error, Pa².

        `distance` is r, m, one-dimensional; ValueError beyond half the diagonal of the cell.
        """
        samples = self.samples(column)
        reach = samples[0].reach
        if distance.max(initial=0.0) > reach * (1 + 1e-12):
            raise ValueError(
                f"distance = {distance.max():.4g} m exceeds half the diagonal of the cell, {reach:.4g} m; ask for "
                "shorter distances"
            )
        mean = correlation_of(samples, distance)
        return mean.value, spread_of(mean)[0]

    def curves(self) -> dict[str, Array]:
        """Return the curves of the column sliding over the `slid_distance`, m; ValueError without a sound member.

        Arrays (members, speeds, distances) or (members, distances), by the names in `observables.catalogue.CURVES`.
        """
        slides = self.slides()
        indices = slides.rows.tolist()
        rows = [self.members[slides.level, index].curves for index in indices]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]} | {
            AXIS: rows[0][AXIS]
        }
