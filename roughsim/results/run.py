"""A run on disk, read: its scene, its sound members, and the estimates made of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0

from roughsim import prediction
from roughsim.estimate.cell_size import size_error
from roughsim.estimate.errors import LEAST, Estimate, estimate, first_sufficient, spread
from roughsim.estimate.ladder import Values, observe
from roughsim.observables.catalogue import NUMBERS, OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.results.members import Members
from roughsim.results.reader import Reader, identity_of

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.numerics import Numerics

Array = NDArray[np.float64]


class Run:
    """A run folder as it stands when first asked; open it again to see later members.

    Attributes
    ----------
    folder : Path
        Where it is.
    scene : Scene
        What was computed.
    numerics : Numerics
        How well.
    seed : int
        Of all random streams.
    until : dict of str to float
        Relative 95 % half-widths at which it stops.
    max_realizations : int
        Where it stops in any case.
    heat_partition : ndarray
        Share of the heat that temperatures are reported with, per speed.
    reasons : list of [str, str, str]
        What the plan chose and why, as `plan` told it; empty if the numerics were given without reasons.
    """

    def __init__(
        self,
        folder: Path,
        description: dict[str, Any],
        scene: Scene,
        numerics: Numerics,
        *,
        skip_damaged: bool = False,
    ):
        self.folder = folder
        self.scene = scene
        self.numerics = numerics
        self.seed: int = description["seed"]
        self.until: dict[str, float] = description["until"]
        self.max_realizations: int = description["max_realizations"]
        self.heat_partition: Array = np.array(description["heat_partition"])
        self.reasons: list[list[str]] = description["reasons"]
        self._reader = Reader(folder, numerics, scene.speeds, identity_of(description), skip_damaged)
        self._tested: tuple[dict[str, float], int] | None = None  # so many sound realizations miss these targets

    @property
    def members(self) -> Members:
        """What is there by level and index, without spectra and fields."""
        return self._reader.members

    @property
    def damaged(self) -> dict[tuple[int, int], str]:
        """Level and index of files that could not be used, and why; empty unless opened with ``damaged="skip"``."""
        return self._reader.damaged

    @property
    def missing(self) -> list[str]:
        """Names, as "L0-000003", of the members not there although later ones are; none once the targets are met."""
        return [] if self.target_met else self._reader.missing()

    def refresh(self) -> None:
        """Read the members that have come since, in order, up to the first gap; damaged ones again.

        Raises
        ------
        RecordError
            If one is damaged or of another run, naming it.
        OSError
            If one cannot be read now, which is no damage.
        """
        self.__dict__.pop("realizations", None)
        self._reader.refresh(self.max_realizations)

    def take(self, level: int, index: int) -> bool:
        """Read one member now, also beyond a gap; False if its file is not there. Errors as `refresh`."""
        return self._reader.take(level, index)

    @cached_property
    def realizations(self) -> int:
        """How many indices count: the first n at which the targets are met, or all there are without a gap."""
        available = self._reader.available
        rows = self.sound(available)
        stop = self._stop(rows)
        return available if stop is None else rows[stop - 1] + 1

    def _stop(self, rows: list[int]) -> int | None:
        """How many of the rows meet the targets first; what did not suffice once never will."""
        if not self.until:
            return None
        if self._tested is None or self._tested[0] != self.until:
            self._tested = dict(self.until), max(LEAST - 1, self._reader.remembered(rows, self.until))
        short = self._tested[1]
        if short >= len(rows):
            return None
        samples = {name: self.samples(None, rows, spectra=OBSERVABLES[name].spectra) for name in self.until}

        def targets(count: int) -> Iterator[tuple[Values, float]]:
            for name, goal in self.until.items():
                yield self._values(name, None, [sample.first(count) for sample in samples[name]]), goal

        stop = first_sufficient(targets, range(short + 1, len(rows) + 1))
        short = len(rows) if stop is None else stop - 1
        self._tested = dict(self.until), short
        self._reader.remember(short, rows, self.until)
        return stop

    @property
    def target_met(self) -> bool:
        """Whether the targets of `until` are met."""
        return self._stop(self.sound(self._reader.available)) is not None

    @property
    def failed(self) -> int:
        """How many of the realizations that count did not converge at some level."""
        damaged = {index for _, index in self.damaged if index < self.realizations}
        return self.realizations - len(self.sound(self.realizations)) - len(damaged)

    def sound(self, count: int) -> list[int]:
        """Return the indices below `count` of which every level is sound."""
        good = np.ones(count, bool)
        for level in range(len(self.numerics.levels)):
            good[self.members.failed(level, count)] = False
        return [int(index) for index in np.flatnonzero(good)]

    def column(self, column: str | None) -> str:
        """Return the name of a column: the capped one where there is a hardness, else the elastic one, if None.

        Raises
        ------
        ValueError
            If the run has no such column.
        """
        name = self.numerics.columns[-1] if column is None else column
        if name not in self.numerics.columns:
            raise ValueError(f"column = {name!r} is not in this run; it has {', '.join(self.numerics.columns)}")
        return name

    def samples(
        self, column: str | None = None, rows: list[int] | None = None, *, spectra: bool = True
    ) -> list[Sample]:
        """Return the numbers of a column's levels, coarsest first, over the realizations that count.

        The stress spectra are read from disk if wanted, else left empty.
        """
        wanted = np.array(self.sound(self.realizations) if rows is None else rows, np.int64)
        reach = 0.5 * float(np.hypot(*self.numerics.lengths))
        result = []
        for number in self.numerics.of_column(self.column(column)):
            level = self.numerics.levels[number]
            place = np.flatnonzero(wanted % level.every == 0)
            there = wanted[place]
            numbers = {name: self.members.numbers(number, name, there) for name in NUMBERS}
            nothing = np.empty(0), np.empty((len(there), 0))
            wavenumber, spectra_there = self._reader.spectra(number, there) if spectra else nothing
            result.append(Sample(level.q_max, float(level.shape[0]), place, numbers, wavenumber, spectra_there, reach))
        return result

    def values(self, observable: str, column: str | None = None, *, extrapolated: bool = True) -> Values:
        """Return the values of an observable, a row per sound realization, with all heat in the moving body.

        Not extrapolated they are those of the highest cut-off.

        Raises
        ------
        ValueError
            If there is no such observable or column, or no realization yet.
        """
        if observable not in OBSERVABLES:
            raise ValueError(f"observable = {observable!r} is unknown; choose one of {', '.join(OBSERVABLES)}")
        rows = self.sound(self.realizations)
        if not rows:
            raise ValueError(f"{self.folder} has no sound realization yet; let it run first")
        samples = self.samples(column, rows, spectra=OBSERVABLES[observable].spectra)
        return self._values(observable, column, samples, extrapolated)

    def _values(self, observable: str, column: str | None, samples: list[Sample], extrapolated: bool = True) -> Values:
        name = self.column(column)
        if observable == "heat_partition":
            samples = [prediction.balanced(self.scene, sample) for sample in samples]
        cut_offs = tuple(sorted({sample.q_max for sample in samples}))
        end, theory = self.scene.spectrum.breaks[-1], None
        if not extrapolated:
            end = cut_offs[-1]
        elif cut_offs[-1] < end * (1 - 1e-9):
            theory = prediction.continuation(self.scene, name, cut_offs, observable)
        capped = name == "capped"
        names: dict[str, Any] = {"capped": capped, "end": end, "theory": theory}
        if capped and theory is None:
            names |= {"settled": 4.0 * prediction.yield_wavenumber(self.scene)}
            names |= {"usual": prediction.usual_exponent(self.scene, cut_offs[-1])}
        values = observe(observable, samples, **names)
        rest = OBSERVABLES[observable].at_rest
        if rest is not None:  # members are measured at a tiny speed instead: exact limits here
            moving = np.array(self.scene.speeds) > 0.0
            exact = dict.fromkeys(("extrapolated", "finest", "base"), rest) | {"bandwidth": 0.0, "pixel": 0.0}
            return values._replace(**{key: np.where(moving, getattr(values, key), x) for key, x in exact.items()})
        return values

    def estimate(self, observable: str, column: str | None = None) -> Estimate:
        """Return the mean of an observable with its errors.

        Parameters
        ----------
        observable : str
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.
        column : {"smoothed", "capped", "elastic"}, optional
            Left out: capped where there is a hardness, else elastic.

        Returns
        -------
        Estimate
            Arrays over speed, or of one entry. Temperatures are those of the heat share used (`heat_partition`).

        Raises
        ------
        ValueError
            If there is no such observable or column, or no realization yet.
        """
        name, values = self.column(column), self.values(observable, column)
        if OBSERVABLES[observable].heated:
            share = self.heat_partition
            keys = ("extrapolated", "finest", "base", "bandwidth", "pixel")
            scaled = {key: getattr(values, key) * share for key in keys}
            values = values._replace(**scaled)
        return estimate(
            observable,
            values,
            self._notes(observable, name, values),
            size=size_error(self.scene, self.numerics.lengths, observable, name),
            tolerance=self.numerics.tolerance,
            scanned=self.scene.scanned,
        )

    def _notes(self, observable: str, column: str, values: Values) -> tuple[str, ...]:
        levels = [self.numerics.levels[i] for i in self.numerics.of_column(column)]
        grids = ", ".join(f"{level.shape[0]} × {level.shape[1]} to {level.q_max:.3g}" for level in levels)
        notes = [f"{column} contact on {grids} rad/m, solver tolerance {self.numerics.tolerance:.1g}"]
        if np.any(np.isfinite(values.exponent)):
            shown = ", ".join(dict.fromkeys(f"{p:.2f}" for p in values.exponent))
            notes.append(f"extrapolated as q_c^(−p) with p = {shown}")
        elif column == "capped" and not OBSERVABLES[observable].limit:
            notes.append("does not converge with the grid: the value of the finest level, not extrapolated")
        elif levels[-1].q_max < self.scene.spectrum.breaks[-1] * (1 - 1e-9):
            if values.extrapolated is values.finest and np.any(values.bandwidth > 0.0):
                notes.append(
                    "shorter than a wave of the cut-offs: the value of the highest q_c, the last step is in doubt"
                )
            elif np.any(values.bandwidth > 0.0):
                notes.append("continued from q_c to q_max with the shape of the theory")
            if np.any(np.isnan(values.bandwidth)):
                notes.append("where the bandwidth is unknown, the value of the highest q_c")
        if OBSERVABLES[observable].per_speed:
            notes.append(f"speeds {', '.join(f'{v:g}' for v in self.scene.speeds)} m/s")
        return tuple(notes)

    def correlation(self, distance: Array, column: str | None = None) -> tuple[Array, Array]:
        """Return g_σ(r) of the finest level and its standard error, Pa².

        Parameters
        ----------
        distance : ndarray
            r, m, one-dimensional, at most half the diagonal of the cell.
        column : str, optional
            As in `estimate`.

        Raises
        ------
        ValueError
            If a distance lies beyond half the diagonal of the cell.
        """
        sample = self.samples(column)[-1]
        if distance.max(initial=0.0) > sample.reach * (1 + 1e-12):
            raise ValueError(
                f"distance = {distance.max():.4g} m exceeds half the diagonal of the cell, {sample.reach:.4g} m; "
                f"ask for shorter distances"
            )
        rows = sample.spectrum @ j0(np.multiply.outer(sample.wavenumber, distance))
        return rows.mean(axis=0), spread(rows)[0]

    def fields(
        self, name: str, column: str | None = None, *, speed: float | None = None, direction: float = 0.0
    ) -> Iterator[tuple[int, NDArray[np.float32]]]:
        """Go through the kept fields of a column's finest level, one in memory at a time.

        Parameters
        ----------
        name : {"heights", "pressure", "heat_flux", "temperature"}
            Composite heights, m; pressure, Pa; the frictional heat μσ|v| of both bodies, W/m²; the temperature above
            the mean of the cell that the share of that heat leaves in the moving body, K, after the slide from rest
            that the numerics say (`slid_distance`). The last two are computed from the stored pressure.
        column : str, optional
            As in `estimate`.
        speed : float, optional
            v, m/s, for heat_flux and temperature: any speed, also one that the run has no moments for; a negative
            one slides the other way.
        direction : float
            Angle of sliding, radians from axis 0 towards axis 1.

        Returns
        -------
        iterator of (int, ndarray)
            Index of the realization, and its field of the shape of the level, float32.

        Raises
        ------
        ValueError
            If there is no such field or column, the speed is missing, or no realization kept its fields.
        RecordError
            If a file is damaged.
        """
        from roughsim.results.fields import stream

        return stream(self, name, column, speed, direction)

    def to_xarray(self) -> Any:
        """Return all numbers of all members, and the kept fields, as an `xarray.Dataset`.

        Its dimensions are level, realization and speed, with the column and q_c of each level as coordinates, so that
        ``ds.flash_temperature.isel(level=-1).mean("realization")`` is a curve over speed. What depends on the grid of
        a level carries its number: ``pressure_L2`` (kept_realization, x_L2, y_L2) is read when it is used.
        Temperatures are those of the heat share used, `heat_partition`. Failed members are NaN with converged = 0.

        Raises
        ------
        ImportError
            If xarray is not installed: ``pip install 'roughsim[xarray]'``.
        ValueError
            If the run has no sound realization yet.
        """
        from roughsim.results.labelled import to_xarray

        return to_xarray(self)
