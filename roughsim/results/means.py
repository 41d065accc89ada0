"""`Means`: the means of the counted members of a run, with their errors."""

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite

import numpy as np

from roughsim import prediction
from roughsim.estimate.cell_size import size_error
from roughsim.estimate.errors import SOURCES, estimate, speed_axis, spread_of
from roughsim.estimate.levels import FLASH, notes_of, values_of
from roughsim.estimate.mean import Mean
from roughsim.estimate.rounds import Counts
from roughsim.estimate.sliding import (
    HOT,
    SLIDING_OBSERVABLES,
    sliding_estimate,
    sliding_flash,
    sliding_quantile,
    stretch_of,
    with_background,
)
from roughsim.estimate.telescoping import correlation_of
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, OBSERVABLES, observables_of
from roughsim.observables.record import Observable, Sample
from roughsim.prediction.scans import scan_error
from roughsim.prediction.sliding import SlidingContinuation
from roughsim.results import pressed, share
from roughsim.results.members import Members
from roughsim.scene import Scene
from roughsim.scene.numerics import QUADRANTS, SLIDING
from roughsim.sliding.path import coarser_grid
from roughsim.store.member_files import member_path, read_member
from roughsim.table import AT_CUT_OFF, IDENTITY, Estimate, Labels


class Means:
    """The means of the counted members of a run; `Run` describes the attributes."""

    def __init__(self, scene: Scene, members: Members):
        self.folder, self.numerics = members.folder, members.numerics
        self.scene, self.members = scene, members
        self.heat_partition = prediction.heat_partition(scene)
        # whether the surfaces are drawn from C(q), or are a map without shorter waves
        self.drawn = not self.numerics.of_column(QUADRANTS)
        # the parts of an error, in words
        self.sources: Mapping[str, str] = SOURCES if self.drawn else pressed.SOURCES
        columns = self.numerics.columns if self.drawn else (*self.numerics.columns, QUADRANTS)
        self._lowest = [self.numerics.of_column(column)[0] for column in columns]
        # of the members that count; all observables follow from them, and most values are asked for repeatedly
        self._samples: dict[str, list[Sample]] = {}
        self._values: dict[tuple[str, str, bool], Mean] = {}
        self._continued: SlidingContinuation | None = None  # .1 s to .5 s

    def count(self, counts: Counts) -> None:
        """Let so many members of each level count."""
        if counts != self.counts:
            self.members.counts = counts
            self._samples.clear()
            self._values.clear()

    @property
    def counts(self) -> Counts:
        """Number of members of each level that count."""
        return self.members.counts

    @property
    def observables(self) -> dict[str, Observable]:
        """Observables of the run by name, those of the distribution of the temperature only if its scene asks."""
        return observables_of(self.scene.distribution)

    @property
    def scanned(self) -> bool:
        """Whether the surfaces are drawn from a C(q) that was measured on maps."""
        return self.drawn and self.scene.scanned

    @property
    def independent(self) -> int:
        """Number of sound members of the lowest level, smallest over the columns; of a map its sound quadrants."""
        sound = [len(self.members.sound(level)) for level in self._lowest]
        return min(sound) if self.drawn or 0 in sound else sound[-1]

    def column(self, column: str | None) -> str:
        """Return the name of a column; None: capped, else elastic. ValueError if it is missing."""
        name = self.numerics.columns[-1] if column is None else column
        if not self.numerics.of_column(name) or name == SLIDING:
            raise ValueError(
                f"column = {name!r} is not in this run; it has {', '.join(self.numerics.columns)}"
            )
        return name

    def samples(self, column: str | None = None) -> list[Sample]:
        """Return the sound counted members of a column's levels, lowest first; levels without any are left out.

        ValueError if there is none.
        """
        name = self.column(column)
        if name not in self._samples:
            self._samples[name] = self.members.samples(name)
        if not self._samples[name]:
            raise ValueError(f"{self.folder} has no sound realization yet; let it run first")
        return self._samples[name]

    def values(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True
    ) -> Mean:
        """Return the values of an observable over the counted members, with all heat in the moving body.

        `extrapolated`, or at the highest cut-off, with all parts of their errors. Errors raised as `estimate`.
        """
        values, name = (
            self.of_levels(observable, column, extrapolated=extrapolated),
            self.column(column),
        )
        parts = {
            "size": self.size_error(observable, name),
            "solver": OBSERVABLES[observable].solver_share * self.numerics.tolerance,
        }
        values = values.with_errors(**parts, **self._scan_part(observable))
        if self.drawn or name == QUADRANTS:
            return values
        quadrants = self.of_levels(observable, QUADRANTS, extrapolated=extrapolated)
        return pressed.with_scatter(values, quadrants, self.members)

    def _scan_part(self, observable: str) -> dict[str, Array]:
        """Return the relative error of an observable by the scans that C(q) was measured on; empty without them."""
        return {"scan": scan_error(self.scene)[observable]} if self.scanned else {}

    def of_levels(
        self, observable: str, column: str | None = None, *, extrapolated: bool = True
    ) -> Mean:
        """Return `values` with those parts of their errors alone that the levels of a column show."""
        if observable not in self.observables:
            need = (
                "not in this run, whose scene lacks [observables] temperature_distribution = true"
            )
            fault = need if observable in OBSERVABLES else "unknown"
            raise ValueError(
                f"observable = {observable!r} is {fault}; choose one of {', '.join(self.observables)}"
            )
        key = observable, self.column(column), extrapolated
        if key not in self._values:
            samples = self.samples(column)
            self._values[key] = values_of(
                self.scene,
                self.numerics.columns[-1] if key[1] == QUADRANTS else key[1],
                observable,
                samples,
                extrapolated=extrapolated,
                continued=self.drawn,
            )
        return self._values[key]

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

    def size_error(self, observable: str, column: str) -> Array | float:
        """Return the relative error by the finite cell; of a map by the difference of its quadrants."""
        if not self.drawn:
            whole, parts = (self.of_levels(observable, name) for name in (column, QUADRANTS))
            return pressed.size_error(whole, parts, self.members)
        return size_error(
            self.scene, self.numerics.lengths, observable, column, self.numerics.parts(column)
        )

    def estimate(self, observable: str, column: str | None = None) -> Estimate:
        """Return the mean of an observable with its errors.

        Parameters
        ----------
        observable : str
            One of `observables`.
        column : {"smoothed", "capped", "elastic", "sliding"}, optional
            Default: capped for a scene with a hardness, else elastic.

        Returns
        -------
        Estimate
            Arrays over speed, or of one entry. Temperatures have the heat share used (`share`), and include its errors;
            in the column sliding, the share follows from its own heat.

        ValueError if there is no such observable or column, or no realization yet.
        """
        slid = column == SLIDING
        result = self._slid(observable) if slid else self.single(observable, column)
        per_speed = OBSERVABLES[observable].per_speed
        axis = speed_axis(result.mean, self.scene.speeds if per_speed else ())
        note = self._note(result, SLIDING if slid else self.column(column))
        notes = result.notes if self.drawn else (*result.notes, pressed.NOTE)
        return replace(result, coords=axis, note=note, sources=self.sources, notes=notes)

    def _note(self, found: Estimate, column: str) -> Labels:
        """Return the mark of each entry of an estimate: `IDENTITY`, `AT_CUT_OFF` or ""."""
        record = OBSERVABLES[found.observable]
        plastic = column in ("capped", SLIDING) and not self.scene.elastic
        yielded = plastic and isfinite(prediction.yield_wavenumber(self.scene))
        if yielded and record.by_force_balance:
            return np.full(found.mean.shape, IDENTITY, object)
        no_limit = np.isnan(found.budget.get("bandwidth", np.zeros_like(found.mean)))
        no_limit |= plastic and not record.limit  # plastic patches have steep edges
        cut = no_limit & ~np.isnan(found.mean)
        return np.where(cut, AT_CUT_OFF, "").astype(object)

    def estimates(self, column: str | None = None) -> dict[str, Estimate]:
        """Return the estimates of all observables of a column, by their names; arguments and errors as `estimate`."""
        names = self.slid_observables if column == SLIDING else self.observables
        return {name: self.estimate(name, column) for name in names}

    def single(
        self, observable: str, column: str | None = None, *, all_heat: bool = False
    ) -> Estimate:
        """Return the estimate of single contacts, with `all_heat` in the moving body or with the share of a column."""
        name = self.column(column)
        values = self.values(observable, name)
        notes = notes_of(self.scene, self.numerics, name, observable, values)
        if OBSERVABLES[observable].heated and not all_heat:
            values = self.reported(observable, name)
            if share.has_own_share(self.scene):
                notes = *notes, share.NOTE
        return estimate(observable, values, notes)

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

    @property
    def reacting_columns(self) -> tuple[str, ...]:
        """Columns whose members have stored the distribution of the temperature; none if the scene does not ask."""
        if not self.scene.distribution:
            return ()
        columns, level = self.numerics.columns, self.numerics.slide
        slides = (
            []
            if level is None
            else [self.members[level, index] for index in self.members.sound(level)]
        )
        stored = bool(slides) and all(slide.moments[0].bins is not None for slide in slides)
        return (*columns, SLIDING) if stored else columns

    @property
    def slid_observables(self) -> tuple[str, ...]:
        """Observables of the column sliding: those of the distribution only if its members have stored it."""
        if SLIDING not in self.reacting_columns:
            return SLIDING_OBSERVABLES
        return (
            *SLIDING_OBSERVABLES,
            *(name for name, record in OBSERVABLES.items() if record.asked),
        )

    def slid(self) -> tuple[Sample, Mean, Array]:
        """Return the slides, the T_flash that follows from them, and the factor of the distribution about it.

        By this factor, (speeds,), it grows in single contacts up to the end of C(q). ValueError without a slide.
        """
        flash, slides = self.values(FLASH), self.members.slides()
        coarsening = self._coarsening(slides.level)
        slid_flash = sliding_flash(flash, slides.numbers, coarsening, slides.stream)
        return slides, slid_flash, stretch_of(flash, self.values(HOT), self.samples()[0])

    def _slid(self, observable: str) -> Estimate:
        """Return the estimate of an observable in the column sliding."""
        if observable not in self.slid_observables or not OBSERVABLES[observable].asked:
            single, slides = self.single(observable, all_heat=True), self.members.slides()
            coarsening = self._coarsening(slides.level)
            return sliding_estimate(
                observable, single, slides.numbers, coarsening, self._continuation()
            )
        slides, flash, stretch = self.slid()
        values = sliding_quantile(flash, observable, slides.numbers, slides.stream, stretch)
        note = f"T_flash of the column sliding, times this quantile over T_flash in {len(slides.rows)} slides"
        return estimate(observable, values.with_errors(**self._scan_part(observable)), (note,))

    def _coarsening(self, level: int) -> float:
        """Return the ratio of pixels of slides, coarser grid over own grid; 1 without a coarser grid."""
        grid = self.numerics.grid(level)
        coarser = coarser_grid(grid, self.numerics.levels[level].q_max)
        return 1.0 if coarser is None else coarser.spacing[0] / grid.spacing[0]

    def _continuation(self) -> SlidingContinuation:
        """Return the factors from the distance that slides are followed to their whole distance."""
        if self._continued is None:
            self._continued = prediction.sliding_continuation(self.scene, self.followed)
        return self._continued

    def contact_temperature(self, column: str, warming: Array) -> Estimate:
        """Return T₀ + T_flash of a column over speed; `warming` is T₀ of single contacts with all the heat, K."""
        flash = self.estimate("flash_temperature", column)
        if column == SLIDING:
            rows = self.members.slides().numbers["sliding_background"]
            return with_background(
                flash, rows, self.estimate("heat_partition", SLIDING), self._continuation()
            )
        if share.has_own_share(self.scene):
            return share.with_warming(flash, self.estimate("heat_partition", column), warming)
        return replace(flash, mean=flash.mean + self.heat_partition * warming)

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
        slides = self.members.slides()
        paths = [member_path(self.folder, slides.level, index) for index in slides.rows.tolist()]
        rows = [read_member(path).curves for path in paths]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]} | {
            AXIS: rows[0][AXIS]
        }
