"""The contact problem in its own units, on coarser grids, and in closed form if no point lifts off.

Lengths are in units of the longer side of the cell, heights in units of half their range, and E* is 1. Spectra are
transposed half spectra, as `operators` hold them.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from roughsim._kernels import lines as kernels
from roughsim.contact.solver.operators import half_space, kept_half_space
from roughsim.fourier.blocks import extremes, run, spans
from roughsim.grid import Field, Grid

LOADS = (1e-303, 1e250)  # σ₀ over E* times range over length
_COARSEST = 64  # an axis is halved while it keeps at least this many points


class ScaledProblem(NamedTuple):
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
        """Float32 if pressures keep well inside its range."""
        return np.float32 if 1e-15 < self.load < 1e15 else np.float64

    @property
    def target(self) -> float:
        """Σ p over all points."""
        return self.load * self.grid.points

    @property
    def room(self) -> float:
        """Σ p that is free to vary: little if nearly all points have yielded."""
        return min(self.target, self.cap * self.grid.points - self.target)


class ScaledSolution(NamedTuple):
    """Solution on one grid; unless an iteration made it, in closed form."""

    pressure: Field  # shape of the grid
    gap: Field
    residual: float = 0.0
    iterations: int = 0
    # real float64 transforms of this grid, the transform of the heights left out
    transforms: float = 1.0


class _Relief(NamedTuple):
    """Properties of the heights and grid of a contact problem, for any load."""

    grid: Grid  # in units of the longer side
    middle: float  # m
    unit: float  # half the range of the heights, m
    spectrum: Field  # in a buffer that the next solve on this grid overwrites
    stiffness: float
    pressed: float  # p − load at the lowest point in full contact


def relief_of(heights: Field, grid: Grid) -> _Relief:
    """Return the relief of some heights, m."""
    low, high = extremes(heights)
    middle = 0.5 * (high + low)
    side = max(grid.lengths)
    unit = max(high - middle, middle - low) or side
    unit_grid = Grid(grid.shape, (grid.lengths[0] / side, grid.lengths[1] / side))
    scaled = heights - middle
    scaled /= unit
    operator = kept_half_space(unit_grid, np.float64)
    spectrum = operator.forward(scaled)
    along, across = operator.along, operator.across

    def greatest(least: float) -> Any:
        """Return the greatest power of a mode, and the greatest q² of the modes whose power is above `least`."""
        blocks = spans(*spectrum.shape)
        parts = run(lambda *rows: kernels.highest(*rows, spectrum, along, across, least), blocks)
        return np.max(parts, axis=0)

    # modes below rounding are not in the heights. κ = q_s/2 makes the residual close to the error of the pressure
    highest = math.sqrt(greatest(1e-24 * greatest(np.inf)[0])[1])
    stiffness = 0.5 * max(highest, 2 * np.pi / max(unit_grid.lengths))
    pressed = _pressed_at(int(np.argmin(heights)), unit_grid, spectrum, along, across)
    return _Relief(unit_grid, middle, unit, spectrum, stiffness, pressed)


def dimensionless(
    heights: Field, grid: Grid, effective_modulus: float, nominal_pressure: float, hardness: float
) -> tuple[ScaledProblem, _Relief, float]:
    """Return the problem, the relief of its heights, and the unit of its pressures, Pa."""
    relief = relief_of(heights, grid)
    middle = relief.middle
    unit = relief.unit
    pressure_unit = effective_modulus * (unit / max(grid.lengths))
    load = nominal_pressure / pressure_unit if pressure_unit else math.inf
    if not LOADS[0] <= load <= LOADS[1]:
        raise ValueError(
            f"nominal_pressure = {nominal_pressure:.6g} Pa is {load:.3g} of E* times half the range of the heights "
            f"over the longer side, {effective_modulus:.6g} Pa · {unit:.6g} m / {max(grid.lengths):.6g} m; only "
            f"{LOADS[0]:g} to {LOADS[1]:g} is in the range of double precision: check the units of the heights"
        )
    cap = hardness / pressure_unit
    problem = ScaledProblem(heights, middle, unit, relief.grid, load, cap, relief.stiffness)
    return problem, relief, pressure_unit


def coarser(finest: ScaledProblem, relief: _Relief, known: int = 0) -> list[ScaledProblem]:
    """Return the problem and its spectrally truncated versions of more than `known` points, finest first."""
    levels = [finest]
    while True:
        fine = levels[-1].grid.shape
        nx, ny = ((n + 1) // 2 if n >= 2 * _COARSEST else n for n in fine)
        if (nx, ny) == fine or nx * ny <= known:
            return levels
        grid, heights = truncated(relief, (nx, ny))
        stiffness = min(finest.stiffness, 0.5 * grid.nyquist)
        levels.append(
            finest._replace(heights=heights, middle=0.0, unit=1.0, grid=grid, stiffness=stiffness)
        )


def truncated(relief: _Relief, shape: tuple[int, int]) -> tuple[Grid, Field]:
    """Return a coarser grid, and the heights on it."""
    nx, ny = shape
    spectrum = relief.spectrum
    grid = Grid(shape, relief.grid.lengths)
    heights = np.empty(shape)
    operator = kept_half_space(grid, np.float64)
    coarse = operator.complex_spectrum
    rows = ny // 2 + 1
    positive = (nx + 1) // 2
    # a Nyquist row or column that the finest has not is dropped
    coarse[:, :positive] = spectrum[:rows, :positive]
    coarse[:, positive:] = spectrum[:rows, spectrum.shape[1] - nx + positive :]
    if nx % 2 == 0 and nx < relief.grid.shape[0]:
        coarse[:, nx // 2] = 0.0
    if ny % 2 == 0 and ny < relief.grid.shape[1]:
        coarse[-1] = 0.0
    operator.inverse(heights)
    return grid, heights


def _pressed_at(point: int, grid: Grid, spectrum: Field, along: Field, across: Field) -> float:
    """Return p − load = |q|h/2 of full contact at one point of the flattened grid, with q² along both axes: one sum."""
    row, column = divmod(point, grid.shape[1])
    # phases q·x of the point, along both axes
    turn_along = 2 * np.pi * row / grid.shape[0] * np.arange(along.size)
    turn_across = 2 * np.pi * column / grid.shape[1] * np.arange(across.size)
    weight = grid.multiplicity[0]
    phases = np.cos(turn_along), np.sin(turn_along)
    cosine = weight * np.cos(turn_across)
    sine = weight * np.sin(turn_across)

    def pressed(start: int, stop: int) -> Any:
        rows = slice(start, stop)
        pairs = np.ascontiguousarray(spectrum[rows]).view(np.float64)
        own = cosine[rows], sine[rows]
        return kernels.point_sum(pairs, along, across[rows], phases, own)

    return 0.5 * float(sum(run(pressed, spans(*spectrum.shape))))


def full_contact(problem: ScaledProblem, relief: _Relief) -> ScaledSolution | None:
    """Return the solution if p = load + |q|h/2 keeps to the bounds or the load is the cap; else None."""
    grid = problem.grid
    load = problem.load
    if load == problem.cap:
        gap = (problem.middle - problem.heights) / problem.unit
        return ScaledSolution(np.full(grid.shape, load), gap)
    # one point beyond the bounds suffices, and the lowest nearly always is
    if load + relief.pressed < -1e-3 * load:
        return None
    # in a buffer of its own: the spectrum may be needed after this
    operator = half_space(grid, np.float64)
    fluctuation = np.empty(grid.shape)
    half_wavenumber = 0.5 * np.sqrt(operator.across[:, None] + operator.along)
    np.multiply(relief.spectrum, half_wavenumber, out=operator.complex_spectrum)
    operator.inverse(fluctuation)
    rounding = 1e-14 * (load + float(np.abs(fluctuation).max()))
    pressure = load + fluctuation
    if pressure.min() < -rounding or pressure.max() > problem.cap + rounding:
        return None
    gap = np.full(grid.shape, -relief.spectrum[0, 0].real)
    return ScaledSolution(np.clip(pressure, 0.0, problem.cap), gap)
