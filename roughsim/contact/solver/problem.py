"""The contact problem in its own units, on coarser grids, and in closed form where no point lifts off.

Lengths are in units of the longer side of the cell, heights in units of their range, and E* is 1. Spectra are
transposed half spectra, as `operators` hold them.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roughsim.contact.solver.operators import half_space
from roughsim.fourier.blocks import extremes, run, spans
from roughsim.grid import Field, Grid

COARSEST = 64  # an axis is halved while it keeps at least this many points


@dataclass(frozen=True, slots=True)
class ScaledProblem:
    """Minimise ½p·Sp − p·(heights − middle)/unit, 0 ≤ p ≤ cap, mean p = load: dimensionless but for the heights."""

    heights: Field
    middle: float
    unit: float
    grid: Grid
    load: float
    cap: float
    stiffness: float  # κ = q_s/2, q_s the highest wavenumber of the heights

    @property
    def step_type(self) -> Any:
        """Float32 where pressures keep well inside its range."""
        return np.float32 if 1e-15 < self.load < 1e15 else np.float64

    @property
    def target(self) -> float:
        """Σ p over all points."""
        return self.load * self.grid.points


def dimensionless(
    heights: Field, grid: Grid, effective_modulus: float, nominal_pressure: float, hardness: float
) -> tuple[ScaledProblem, Field, float]:
    """Return the problem, the spectrum of its heights, and the unit of its pressures, Pa."""
    low, high = extremes(heights)
    middle, side = 0.5 * (high + low), max(grid.lengths)
    unit = max(high - middle, middle - low) or side
    pressure_unit = effective_modulus * (unit / side)
    unit_grid = Grid(grid.shape, (grid.lengths[0] / side, grid.lengths[1] / side))
    scaled = np.empty(grid.shape)

    def scale(start: int, stop: int) -> None:
        scaled[start:stop] = (heights[start:stop] - middle) / unit

    run(scale, spans(*grid.shape))
    spectrum = half_space(unit_grid, np.float64).forward(scaled)
    highest = highest_wavenumber(unit_grid, spectrum)
    # κ = q_s/2 makes the residual close to the error of the pressure
    stiffness = 0.5 * max(highest, 2 * np.pi / max(unit_grid.lengths))
    load, cap = nominal_pressure / pressure_unit, hardness / pressure_unit
    return ScaledProblem(heights, middle, unit, unit_grid, load, cap, stiffness), spectrum, pressure_unit


def wavenumbers(grid: Grid, start: int = 0, stop: int | None = None) -> Field:
    """Return |q| of the rows start … stop − 1 of a transposed half spectrum."""
    along, across = (np.square(q.ravel()) for q in grid.wavevectors)
    squares: Field = across[start:stop, None] + along
    return np.sqrt(squares, out=squares)


def highest_wavenumber(grid: Grid, spectrum: Field) -> float:
    """Return the highest |q| in the heights of this spectrum; modes below rounding are not in them."""

    def power(start: int, stop: int) -> Field:
        part = spectrum[start:stop]
        return np.asarray(np.square(part.real) + np.square(part.imag))

    rows = spans(*spectrum.shape)
    least = 1e-24 * max(run(lambda a, b: float(power(a, b).max()), rows))
    highest: float = max(run(lambda a, b: float((wavenumbers(grid, a, b) * (power(a, b) > least)).max()), rows))
    return highest


def coarser(finest: ScaledProblem, spectrum: Field, known: int = 0) -> list[ScaledProblem]:
    """Return the problem and its spectrally truncated versions of more than `known` points, finest first."""
    levels = [finest]
    while True:
        fine = levels[-1].grid.shape
        nx, ny = ((n + 1) // 2 if n >= 2 * COARSEST else n for n in fine)
        if (nx, ny) == fine or nx * ny <= known:
            return levels
        # keep the modes that the coarse grid resolves; a Nyquist row or column that was not there before is dropped
        spectrum = spectrum[: ny // 2 + 1, np.rint(np.fft.fftfreq(nx) * nx).astype(int)]
        if nx % 2 == 0 and nx < fine[0]:
            spectrum[:, nx // 2] = 0.0
        if ny % 2 == 0 and ny < fine[1]:
            spectrum[-1] = 0.0
        grid, heights = Grid((nx, ny), finest.grid.lengths), np.empty((nx, ny))
        operator = half_space(grid, np.float64)
        operator.complex_spectrum[...] = spectrum
        operator.inverse(heights)
        stiffness = min(finest.stiffness, 0.5 * grid.nyquist)
        levels.append(replace(finest, heights=heights, middle=0.0, unit=1.0, grid=grid, stiffness=stiffness))


def full_contact(problem: ScaledProblem, spectrum: Field) -> tuple[Field, Field] | None:
    """Return pressure and gap where p = load + |q|h/2 keeps to the bounds or the load is the cap; None elsewhere."""
    grid, load = problem.grid, problem.load
    if load == problem.cap:
        return np.full(grid.shape, load), (problem.middle - problem.heights) / problem.unit
    # one point beyond the bounds is enough to say no, and the lowest nearly always is: its pressure is one sum
    row, column = np.unravel_index(np.argmin(problem.heights), grid.shape)
    along = np.exp(2j * np.pi * row / grid.shape[0] * np.arange(grid.shape[0]))
    across = np.exp(2j * np.pi * column / grid.shape[1] * np.arange(grid.half_shape[1]))

    def stiffened(start: int, stop: int) -> Field:
        return np.asarray(spectrum[start:stop] * (0.5 * wavenumbers(grid, start, stop)))

    # not BLAS: its threads spin on
    each = run(lambda a, b: np.einsum("ji,i->j", stiffened(a, b), along), spans(*spectrum.shape))
    lines: Field = np.concatenate(each)
    if load + np.sum(grid.multiplicity[0] * (across * lines).real) < -1e-3 * load:
        return None
    operator, fluctuation = half_space(grid, np.float64), np.empty(grid.shape)
    operator.complex_spectrum[...] = stiffened(0, len(spectrum))
    operator.inverse(fluctuation)
    rounding = 1e-14 * (load + float(np.abs(fluctuation).max()))
    pressure = load + fluctuation
    if pressure.min() < -rounding or pressure.max() > problem.cap + rounding:
        return None
    return np.clip(pressure, 0.0, problem.cap), np.full(grid.shape, -spectrum[0, 0].real)
