"""The simulated columns of a run with their estimates: single contacts, and two bodies that slide.

Each has the same members: `observables`, `estimate`, `share`, `contact_temperature`, and `contacts` for reactions.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import isfinite

import numpy as np

from roughsim import prediction
from roughsim.estimate.asked import ASKED, asked_of
from roughsim.estimate.contacts import Contacts
from roughsim.estimate.errors import estimate
from roughsim.estimate.levels import FLASH, PIXEL_FALL, notes_of
from roughsim.estimate.mean import Mean
from roughsim.estimate.reactions import law_of_flash
from roughsim.estimate.sliding import (
    HOT,
    SLIDING_OBSERVABLES,
    sliding_estimate,
    sliding_flash,
    sliding_quantile,
    stretch_of,
    stretched,
    warmed,
    with_background,
)
from roughsim.grid import Array
from roughsim.observables.catalogue import ASKED_BY, CAMERA, DISTRIBUTION, OBSERVABLES, pooled
from roughsim.observables.distribution import Pooled
from roughsim.prediction.sliding import SlidingContinuation
from roughsim.results import share
from roughsim.results.means import Means
from roughsim.scene.numerics import SLIDING
from roughsim.sliding.path import coarser_grid
from roughsim.table import AT_CUT_OFF, IDENTITY, Estimate, Labels

_SOLVER_SHARE = 2.0  # of the tolerance, of temperatures: as of observables that were not measured


class Single:
    """Single contacts of a column, in which temperatures have the share of the heat of this column."""

    def __init__(self, run: Means, column: str | None):
        self.run, self.scene, self.name = run, run.scene, run.column(column)
        self.plastic = (
            self.name == "capped"
        )  # whether the pressure is capped where the scene yields
        self.observables = tuple(run.observables)
        self.reacts = (
            run.scene.distribution
        )  # whether the distribution of the temperature is stored

    @property
    def share(self) -> Array:
        """The share of the heat, (speeds,), in reported temperatures."""
        return self.run.share(self.name)

    @property
    def background(self) -> Array:
        """T₀, absolute, of the surface of the moving body at each speed, K, by the share of the heat."""
        start = self.scene.background_temperature or 0.0
        return start + self.share * prediction.background(self.scene)

    def estimate(self, observable: str, *, all_heat: bool = False) -> Estimate:
        """Return an estimate, with `all_heat` in the moving body or with its share."""
        values = self.run.values(observable, self.name)
        notes = notes_of(self.scene, self.run.numerics, self.name, observable, values)
        if OBSERVABLES[observable].heated and not all_heat:
            values = self.run.reported(observable, self.name)
            if share.has_own_share(self.scene):
                notes = *notes, share.NOTE
        found = estimate(observable, values, notes, self.scene.speeds)
        if OBSERVABLES[observable].asked == DISTRIBUTION:
            found = _where_known(found, pooled(self.run.samples(self.name)[0], observable))
        return found

    def contact_temperature(self, found: Callable[[str], Estimate]) -> Estimate:
        """Return T₀ + T_flash over speed; `found` has the estimates of this column by name."""
        flash, warming = found(FLASH), prediction.background(self.scene)
        if share.has_own_share(self.scene):
            warming = warming.reshape(flash.mean.shape)  # over direction and speed
            return share.with_warming(flash, found("heat_partition"), warming)
        warm = self.run.heat_partition * warming
        return replace(flash, mean=flash.mean + warm.reshape(flash.mean.shape))

    def contacts(self) -> Contacts:
        """Return its contacts, for means over the distribution of their temperature."""
        run, samples = self.run, self.run.samples(self.name)
        flash = run.reported(FLASH, self.name)
        if share.has_own_share(self.scene):  # it makes T₀ too: the errors of both add
            warm = run.values("heat_partition", self.name) * prediction.background(self.scene)
            both = flash + warm
            errors = {name: both.errors[name] for name in flash.errors}
            flash = replace(flash, errors=errors, influence=both.influence)
        end = float(self.scene.spectrum.breaks[-1]) if run.drawn else samples[-1].q_max
        return Contacts(
            samples,
            flash.with_errors(solver=_SOLVER_SHARE * run.numerics.tolerance),
            run.values("contact_fraction", self.name),
            self.background,
            self.scene.speeds,
            law_of_flash(self.scene, self.name, samples, end),
            end,
            PIXEL_FALL[self.name],
            sources=run.sources,
        )


def _where_known(found: Estimate, quantile: Pooled) -> Estimate:
    """Return the estimate of a quantile, its scatter unknown where too few contacts are hotter, or colder."""
    statistical = found.budget["statistical"]
    known = quantile.known | (statistical == 0.0)  # exact at rest
    budget = {**found.budget, "statistical": np.where(known, statistical, np.nan)}
    return replace(found, budget=budget)


class Slid:
    """Two bodies that slide: single contacts of the main column, times the change by the slides.

    ValueError without a sound slide.
    """

    plastic = True

    def __init__(self, run: Means):
        self.run, self.scene, self.slides = run, run.scene, run.slides()
        level, rows = self.slides.level, self.slides.rows.tolist()
        stored = (run.members[level, index].moments[0].bins is not None for index in rows)
        self.reacts = run.scene.distribution and all(stored)
        asked = (
            name
            for name, record in OBSERVABLES.items()
            if record.asked == DISTRIBUTION and self.reacts
        )
        seen = (
            name
            for name, record in OBSERVABLES.items()
            if record.asked == CAMERA and np.isfinite(self.slides.numbers[f"sliding_{name}"]).any()
        )
        self.observables = (*SLIDING_OBSERVABLES, *asked, *seen)
        # the ratio of pixels, coarser grid over own grid; 1 without a coarser grid
        grid = run.numerics.grid(level)
        coarser = coarser_grid(grid, run.numerics.levels[level].q_max)
        self._coarsening = 1.0 if coarser is None else coarser.spacing[0] / grid.spacing[0]

    @property
    def share(self) -> Array:
        """The share of the heat, (speeds,), in reported temperatures."""
        return self.estimate("heat_partition").mean

    @property
    def _continued(self) -> SlidingContinuation:
        """The factors from the distance that slides are followed to their whole distance."""
        return prediction.sliding_continuation(self.scene, self.run.followed)

    def _flash(self) -> tuple[Mean, Array]:
        """Return T_flash, and the growth of the distribution about it in single contacts up to the end of C(q)."""
        run, slides = self.run, self.slides
        single = run.values(FLASH)
        flash = sliding_flash(single, slides.numbers, self._coarsening, slides.stream)
        lowest = run.samples()[0]
        hot = OBSERVABLES[HOT].of_level(lowest).mean(axis=0) / lowest.numbers[FLASH].mean(axis=0)
        return flash, stretch_of(single, run.values(HOT), hot)

    def estimate(self, observable: str) -> Estimate:
        """Return an estimate, in which the share of the heat follows from the slides."""
        numbers = self.slides.numbers
        if observable not in self.observables or OBSERVABLES[observable].asked != DISTRIBUTION:
            single = Single(self.run, None).estimate(observable, all_heat=True)
            return sliding_estimate(observable, single, numbers, self._coarsening, self._continued)
        flash, stretch = self._flash()
        quantile = pooled(self.slides, f"sliding_{observable}")
        values = sliding_quantile(flash, quantile.rows, self.slides, stretch)
        values = values.with_errors(**self.run.scan_part(observable))
        many = len(self.slides.rows)
        note = f"T_flash of the column sliding, times this quantile over T_flash in {many} slides"
        found = estimate(observable, values, (note,), self.scene.speeds)
        return _where_known(found, quantile)

    def contact_temperature(self, found: Callable[[str], Estimate]) -> Estimate:
        """Return T₀ + T_flash over speed; `found` has the estimates of this column by name."""
        rows = self.slides.numbers["sliding_background"]
        return with_background(found(FLASH), rows, found("heat_partition"), self._continued)

    def contacts(self) -> Contacts:
        """Return its contacts, for means over the distribution of their temperature."""
        flash, stretch = self._flash()
        warm = np.zeros_like(flash.value)
        if self.scene.sliding.warms:
            warm = self.slides.numbers["sliding_background"].mean(axis=0)
        flash = warmed(flash, warm, self.estimate("heat_partition"))
        return Contacts(
            [stretched(self.slides, stretch)],
            flash.with_errors(solver=_SOLVER_SHARE * self.run.numerics.tolerance),
            self.run.values("contact_fraction"),
            (self.scene.background_temperature or 0.0) + warm,
            self.scene.speeds,
            stretch=stretch,
            sources=self.run.sources,
        )


class Estimates(Means):
    """The estimates of the simulated columns of a run."""

    def simulated(self, column: str | None = None) -> Single | Slid:
        """Return a simulated column; ValueError if it is missing."""
        return Slid(self) if column == SLIDING else Single(self, column)

    @property
    def simulated_columns(self) -> tuple[str, ...]:
        """The simulated columns with their own names in tables: those of single contacts, and sliding with a slide."""
        slide = self.numerics.slide
        slid = slide is not None and self.members.sound(slide)
        return (*self.numerics.columns, SLIDING) if slid else self.numerics.columns

    def estimate(self, observable: str, column: str | None = None) -> Estimate:
        """Return the mean of an observable with its errors.

        ValueError if there is no such observable or column, or no realization yet.

        Parameters
        ----------
        observable : str
            One of `observables`.
        column : {"smoothed", "capped", "elastic", "sliding"}, optional
            Default: capped for a scene with a hardness, else elastic.

        Returns
        -------
        Estimate
            Arrays over speed, of faces with a lay over direction and speed, or of one entry. Temperatures have the heat
            share used (`share`), and include its errors; in the column sliding, the share follows from its own heat.
        """
        column_of = self.simulated(column)
        found = column_of.estimate(observable)
        note = self._note(found, column_of.plastic and not self.scene.elastic)
        notes = *found.notes, *self.surfaces.notes
        found = replace(found, note=note, sources=self.sources, notes=notes)
        return found.by_direction(self.scene.directions)

    def _note(self, found: Estimate, plastic: bool) -> Labels:
        """Return the mark of each entry of an estimate: `IDENTITY`, `AT_CUT_OFF` or ""."""
        record = OBSERVABLES[found.observable]
        yielded = plastic and isfinite(prediction.yield_wavenumber(self.scene))
        if yielded and record.by_force_balance:
            return np.full(found.mean.shape, IDENTITY, object)
        no_limit = np.isnan(found.budget.get("bandwidth", np.zeros_like(found.mean)))
        no_limit |= plastic and not record.limit  # plastic patches have steep edges
        cut = no_limit & ~np.isnan(found.mean)
        return np.where(cut, AT_CUT_OFF, "").astype(object)

    def estimates(self, column: str | None = None) -> dict[str, Estimate]:
        """Return the estimates of all observables of a column, by their names; arguments and errors as `estimate`."""
        names = self.simulated(column).observables
        return {name: self.estimate(name, column) for name in names}

    def contact_temperature(self, column: str | None = None) -> Estimate:
        """Return T₀ + T_flash of a column over speed, after the `duration` of the scene."""
        return self.simulated(column).contact_temperature(partial(self.estimate, column=column))

    def reactions(self, column: str | None = None) -> dict[str, Estimate]:
        """Return rates, activation temperatures and conversions of [reaction], and the heat above each temperature.

        By name, over (energy, speed), eV, or (temperature, speed), absolute, K. ValueError if there is no such column,
        or no realization yet; empty if the scene asks for nothing.
        """
        if self.scene.reaction is None and self.scene.observables is None:
            return {}
        return asked_of(self.scene, self.simulated(column).contacts())

    def not_asked(self, name: str) -> ValueError:
        """Return the error that the scene does not ask for an observable, or for the distribution itself."""
        asked = ASKED.get(name)
        lines = asked.lines if asked else "[observables] with temperature_distribution = true"
        if name == "seen" or (name in OBSERVABLES and OBSERVABLES[name].asked == CAMERA):
            return ValueError(
                f"{self.folder} has no {name}: its scene has no camera; add {ASKED_BY[CAMERA]} and run it in another "
                "folder"
            )
        # members that have stored the distribution need not be computed again
        where = "again" if self.scene.distribution else "in another folder"
        return ValueError(
            f"{self.folder} has no {name}: its scene does not ask for it; add {lines} and run it {where}"
        )
