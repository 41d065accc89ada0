"""`Run`: an opened run folder with its means, fields and arrays."""

from collections.abc import Iterator
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.errors import RecordError, number
from roughsim.grid import Grid
from roughsim.results import arrays
from roughsim.results.arrays import DERIVED_UNITS, Labelled
from roughsim.results.means import Means
from roughsim.show.markup import in_notebook
from roughsim.show.table import Column, Row, Table
from roughsim.store.member_files import KEPT_FIELDS, member_path, read_field

Field = NDArray[np.float32]


class Run(Means):
    """State of a run folder at the time of opening; `refresh` reads members written since.

    Attributes as of `Means`.
    """

    def fields(
        self, name: str, column: str | None = None, *, speed: float | None = None, direction: float = 0.0
    ) -> Iterator[tuple[int, Field]]:
        """Iterate over the kept fields of a column's finest level in the run's cell, one in memory at a time.

        Parameters
        ----------
        name : {"heights", "pressure", "heat_flux", "temperature"}
            Composite heights, m; pressure, Pa; the frictional heat μσ|v| of both bodies, W/m²; the temperature of the
            moving body with its share of the heat, above the mean of the cell, K, after the slide from rest over the
            `slid_distance` of the numerics. The last two are computed from the stored pressure.
        column : str, optional
            As in `estimate`.
        speed : float, optional
            v, m/s, for heat_flux and temperature: any speed, also one without moments in the run; negative: the
            opposite direction.
        direction : float
            Angle of sliding, radians from axis 0 towards axis 1.

        Returns
        -------
        iterator of (int, ndarray)
            Index of the realization, and its field of the shape of the level, float32.

        ValueError if there is no such field or column, the speed is missing, or no realization kept its fields.
        RecordError if a file is damaged.
        """
        _check_field(name, speed, direction)
        level = self.numerics.picture(self.column(column))
        indices = self.kept(level, name)
        if not indices:
            raise self.not_kept(level)
        return ((index, self.field(level, index, name, speed=speed, direction=direction)) for index in indices)

    def field(self, level: int, index: int, name: str, *, speed: float | None = None, direction: float = 0.0) -> Field:
        """Return one field of one kept realization; name, speed and direction as in `fields`."""
        _check_field(name, speed)
        path = member_path(self.folder, level, index)
        if speed is None:
            return read_field(path, name)
        flux = read_field(path, "pressure")
        flux *= np.float32(prediction.heat_per_pressure(self.scene, speed))
        column = self.numerics.levels[level].column
        grid = self.numerics.grid(level)
        return flux if name == "heat_flux" else self.temperature(flux, grid, speed, direction, column)

    def temperature(
        self, flux: Field, grid: Grid, speed: float, direction: float = 0.0, column: str | None = None
    ) -> Field:
        """Return the temperature, K, by the frictional heat of both bodies, W/m², on any grid of any cell.

        The moving body takes the share of heat of a column, by default the one of `estimate`.
        """
        from roughsim.heat.periodic import sliding_temperature  # slow to import: means need no transforms

        moving = prediction.conduction(self.scene, (abs(speed),)).each[0]
        temperature: Field = sliding_temperature(
            flux,
            grid,
            speed=speed,
            conductivity=moving.conductivity,
            diffusivity=moving.diffusivity,
            direction=direction,
            slid_distance=self.numerics.slid_distance,
        )
        temperature *= np.float32(self.heat_share(speed, column))
        return temperature

    def not_kept(self, level: int, index: int | None = None) -> ValueError:
        """Return the error for fields that were not kept, of a realization or of all, with advice."""
        if index is not None and (level, index) in self.damaged:
            return RecordError(self.damaged[level, index])
        missing = "has kept no fields" if index is None else f"has not kept the fields of realization {index}"
        index = index or 0
        if not self.drawn:
            advice = f"press the map in a new folder with --set numerics.keep_fields={index + 1}"
        else:
            call = f"rs.realize(run.scene, run.numerics, seed={self.seed}, level={level}, index={index})"
            advice = f"run the scene in a new folder with --keep-fields {index + 1}, or recompute one: {call}"
        return ValueError(f"{self.folder} {missing} at level {level}; {advice}")

    def _repr_html_(self) -> str:
        """The state of the run and its flash temperature in each column, for notebooks."""
        failed = f", {self.failed} failed and left out" if self.failed else ""
        state = f"{self.realizations} realizations{failed}" + ("; the target is met" if self.target_met else "")
        lines = [self.scene.title or "untitled", f"{self.folder}: {state}"]
        if not self.independent:
            return in_notebook(*lines)
        flash = {name: self.estimate("flash_temperature", name) for name in self.numerics.columns}
        columns = [Column(title, number=True) for title in ("speed, m/s", *flash)]
        rows: list[Row] = [[f"{v:g}", *(e.number(k) for e in flash.values())] for k, v in enumerate(self.scene.speeds)]
        notes = ("± total error, 95 %. rs.compare(run) has the theory beside it, and all other observables.",)
        return in_notebook(*lines, Table(columns, rows, "flash_temperature, K", notes))

    def arrays(self) -> list[Labelled]:
        """Return all numbers of all counted members, and the kept fields, with names, axes and units."""
        self.pairs()
        here = copy(self)
        here.folder = self.folder.absolute()  # an unpickled dataset may be used in another directory
        return list(arrays.arrays_of(self, here.field))

    def to_xarray(self) -> Any:
        """Return all numbers of all counted members, and the kept fields, as an `xarray.Dataset`.

        Its dimensions are level, realization and speed, with column, q_c and cell of each level as coordinates, so that
        ``ds.flash_temperature.isel(level=-1).mean("realization")`` is a curve over speed of that level alone, which may
        be one in half the cell. Arrays that depend on the grid of a level have its number: ``pressure_L2``
        (kept_realization_L2, x_L2, y_L2), loaded lazily. Temperatures have the heat share `heat_partition`
        (level, speed). Failed members are NaN with converged = 0.

        ImportError if xarray is not installed: ``pip install 'roughsim[xarray]'``. ValueError if the run has no sound
        realization yet.
        """
        return arrays.to_dataset(self.arrays(), arrays.attributes_of(self))


def _check_field(name: str, speed: float | None, direction: float = 0.0) -> None:
    """Refuse an unknown field, a missing or an unneeded speed, or a direction that is no number: ValueError."""
    number("direction", direction, "rad")
    if name not in (*KEPT_FIELDS, *DERIVED_UNITS):
        raise ValueError(f"name = {name!r} is no field; choose one of {', '.join((*KEPT_FIELDS, *DERIVED_UNITS))}")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        number("speed", speed, "m/s")
    elif speed is not None:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")
