"""Frictional heat on the periodic cell: from heat flux to surface temperature.

Heat enters under the source, which moves with `speed` through the body. In the frame of the source (Persson, flash
temperature, Eq. (4) before the averages)

    κ T(q) = q̇(q) / λ,    λ = √(q² − i q·v/D),

once the heat has flowed for ever, and q̇ erf(λ√(Dt))/λ a time t after the start from rest. |Im λ| ≤ Re λ, so that no
exponential here can overflow. Two cautions come with the periodic cell:

- The steady kernel has no advection across the direction of sliding. Each asperity then slides in its own hot track,
  for ever, and above v L/(2πD) = 1 the temperature is too high. From rest over half a cell nothing has met its own
  track yet; that is the default.
- q = 0 has no steady state in a half-space. It is left out of all fields; `uniform_temperature` is that term.
"""

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike

from roughsim import fourier
from roughsim.errors import need_computed, not_negative, number, real_field, sized
from roughsim.fourier import convolution
from roughsim.grid import Array, Complex, Field, Grid, Index, need_grid
from roughsim.heat.arguments import checked_times, need_phases, need_resolved
from roughsim.heat.body import Body
from roughsim.heat.camera import Lens
from roughsim.heat.skin import Layering, SkinLike, response_from_rest
from roughsim.heat.waves import FORGOTTEN, response_of_waves

ROWS = 32  # rows of the half spectrum in one block: the work arrays stay in the cache


class MovingSource(NamedTuple):
    """A moving source of heat, and the depth at which its temperature is taken, in units of the body."""

    drift: tuple[float, float]  # v/D along x and y, 1/m
    # D t, m², t the time since the start from rest; inf is the steady state
    spread: float = math.inf
    depth: float = 0.0  # below the surface, m
    layers: Layering | None = None  # None of a bare half-space that is heated in its plane
    lens: Lens | None = None  # through which it is seen; None: as it is


def sliding_temperature(  # noqa: PLR0913  (a body has two numbers, a skin and a depth)
    heat_flux: ArrayLike,
    grid: Grid,
    *,
    speed: float,
    conductivity: float,
    diffusivity: float,
    direction: float = 0.0,
    slid_distance: float | None = None,
    time: ArrayLike | None = None,
    depth: float = 0.0,
    skin: SkinLike | None = None,
    heat_depth: float = 0.0,
) -> Field:
    """Return the temperature above the background that a sliding heat source leaves in the body.

    The source has slid a finite distance since it started from rest, or, with `slid_distance` = inf, for ever. The
    waves at the Nyquist wavenumber of an axis run both ways along it, so their response is the mean of both: real if
    they lie along the sliding direction. TypeError or ValueError for an argument of the wrong kind, not finite or out
    of its range, or for both `time` and `slid_distance`. A RuntimeWarning for the steady kernel with v L/(2πD) > 1, L
    the chord of the cell along sliding: the field is biased by the periodic cell.

    Parameters
    ----------
    heat_flux : array_like
        Heat entering the body, shape `grid.shape`, W/m². float32 is computed and returned in float32.
    grid : Grid
        The periodic cell.
    speed : float
        Speed of the source through the body, m/s; a negative speed is the opposite direction.
    conductivity, diffusivity : float
        κ, W/(m K); D, m²/s.
    direction : float
        Angle of sliding, radians from axis 0 towards axis 1.
    slid_distance : float, optional
        Distance slid since the start from rest, m, ≥ 0 or inf. Default: half the chord of the cell through its centre
        along `direction`, which is half the length of the cell along an axis. At rest any distance > 0 takes for ever.
    time : float or array_like, optional
        Time since the start from rest, s, ≥ 0 or inf, in place of `slid_distance`. A 1-D array adds a leading axis.
    depth : float
        Distance below the surface, m, ≥ 0.
    skin : Skin, optional
        A layer of another material on the body: thickness, m, conductivity, W/(m K), and diffusivity, m²/s.
    heat_depth : float
        Depth h, m, ≥ 0, in which the heat is released, with the density q̇ e^(−z/h)/h; 0 is the surface.

    Returns
    -------
    ndarray
        T, K, shape `grid.shape` or `(len(time), *grid.shape)`, without its mean (q = 0).
    """
    need_grid(grid)
    flux = real_field("heat_flux", heat_flux, grid.shape)
    body = Body(conductivity, diffusivity, speed, skin, heat_depth)
    depth = not_negative("depth", depth, "m")
    drift, durations, chord = moving(
        grid, body.speed, body.diffusivity, direction, slid_distance, time
    )
    # a uniform flux has only q = 0: exactly nothing is left, whatever the transform rounds
    if flux[0, 0] == flux[-1, -1] and flux.min() == flux.max():
        return np.zeros((*durations.shape, *grid.shape), flux.dtype)
    source = MovingSource(drift, math.inf, depth, body.layers)

    def response(spread: float) -> Field:
        return turned_response(grid, source._replace(spread=spread), flux.dtype)

    spreads = body.diffusivity * durations.ravel()
    fields = fields_over_time(flux, spreads, response, grid.shape, 1 / body.conductivity)
    need_computed("temperature", fields, "K", "heat_flux and conductivity")
    laps = abs(body.speed) * chord / (2 * math.pi * body.diffusivity)
    if laps > 1.0 and np.isinf(durations).any():
        field = fields[np.isinf(durations).argmax()] * body.conductivity
        half_cell = source._replace(spread=body.diffusivity * chord / (2 * abs(body.speed)))
        excess = _hot_track_excess(flux, field, grid, half_cell)
        warnings.warn(
            f"v L/(2πD) = {laps:.3g} exceeds 1: each source slides in its own periodic hot track for ever, and the "
            f"steady T_flash exceeds a start from rest over half the cell by {100 * excess:.3g} %; "
            "use a finite slid_distance",
            RuntimeWarning,
            stacklevel=2,
        )
    return fields.reshape(durations.shape + grid.shape)


def moving(
    grid: Grid,
    speed: float,
    diffusivity: float,
    direction: float,
    slid_distance: float | None = None,
    time: ArrayLike | None = None,
) -> tuple[tuple[float, float], Array, float]:
    """Return v/D of a source along x and y, 1/m, its times since the start from rest, s, and the chord of the cell, m.

    Arguments and errors as `sliding_temperature`.
    """
    need_resolved(grid, speed, diffusivity)
    ux, uy = unit_vector(direction)
    # length of the line through the centre of the cell along the sliding direction
    chord = min(side / abs(part) for side, part in zip(grid.lengths, (ux, uy), strict=True) if part)
    if time is not None:
        if slid_distance is not None:
            raise ValueError(
                f"slid_distance = {slid_distance} m and time = {time!r} s are both given; give one of them"
            )
        durations = checked_times(time)
    else:
        distance = chord / 2 if slid_distance is None else slid_distance
        if not (isinstance(distance, (float, np.floating)) and distance == math.inf):
            distance = not_negative("slid_distance", distance, "m")
        with np.errstate(divide="ignore", over="ignore"):
            # at rest any distance takes for ever, and none takes no time
            durations = np.asarray(np.float64(distance) / abs(speed) if distance else 0.0)
    need_phases(grid, speed, durations)
    return (speed * ux / diffusivity, speed * uy / diffusivity), durations, chord


def uniform_temperature(
    mean_flux: float,
    time: ArrayLike,
    *,
    conductivity: float,
    diffusivity: float,
    depth: float = 0.0,
) -> Any:
    """Return the q = 0 term: T₀(z, t) = 2 q̇ √(Dt)/κ ierfc(z/2√(Dt)) of a uniform flux into a half-space.

    `mean_flux` is the mean heat flux into the body, W/m²; `time` that since the start, s, ≥ 0 and finite, one number or
    an array: the result, K, has its shape. κ is in W/(m K), D in m²/s, `depth` is z ≥ 0, m. TypeError or ValueError for
    an argument of the wrong kind, not finite or out of its range.
    """
    flux = number("mean_flux", mean_flux, "W/m²")
    conductivity = sized("conductivity", conductivity, "W/(m K)")
    instants = checked_times(time)
    if np.isinf(instants).any():
        raise ValueError(
            "time = inf s must be finite: a half-space under a uniform flux warms without limit"
        )
    reach = np.sqrt(sized("diffusivity", diffusivity, "m²/s") * instants)
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = np.where(reach > 0, not_negative("depth", depth, "m") / (2 * reach), np.inf)
        ierfc = np.exp(-(scaled**2)) * (
            1 / math.sqrt(math.pi) - scaled * scipy.special.erfcx(scaled)
        )
    result = 2 * flux / conductivity * reach * np.where(reach > 0, ierfc, 0.0)
    return result if instants.ndim else float(result)


def turned_response(grid: Grid, source: MovingSource, precision: DTypeLike) -> Field:
    """κT/q̇ of all modes, transposed as `convolution.convolve` takes it, shape (n_y//2 + 1, n_x)."""
    turned = np.empty(grid.half_shape[::-1], np.result_type(precision, np.complex64))
    for rows, response in responses(grid, source):
        turned[:, rows] = response.T / grid.points
    turned.flags.writeable = False
    return turned


def _hot_track_excess(flux: Field, field: Field, grid: Grid, source: MovingSource) -> float:
    """Relative excess of Σ T q̇ of the steady `field` (κT) over the field of a source that has not slid for ever.

    Only modes that are not steady yet differ. They are few at high speed: their rows and columns alone are summed.
    """
    amplitude = fourier.forward(flux)
    total = float(np.mean(flux * field, dtype=float))
    excess = 0.0
    qx, qy = grid.wavevectors
    layers = source.layers
    along, across = source.drift
    forgotten = FORGOTTEN / source.spread * (1.0 if layers is None else max(1.0, layers.diffusion))
    columns = int((qy[0] ** 2 < forgotten).sum())
    weights = grid.multiplicity[:, :columns]
    rows = np.flatnonzero(qx[:, 0] ** 2 < forgotten)
    for part in np.array_split(rows, math.ceil(rows.size / ROWS)):
        advection = along * qx[part] + across * qy[:, :columns]
        square = qx[part] ** 2 + qy[:, :columns] ** 2
        power = np.abs(amplitude[part, :columns]) ** 2 * weights
        mean = square == 0.0
        power[mean] = 0.0
        square[mean] = 1.0
        steady = response_of(square, advection, source._replace(spread=math.inf))
        young = response_of(square, advection, source)
        excess += float(np.sum(power * (steady.real - young.real)))
    return excess / (total - excess) if total != excess else math.nan


def unit_vector(direction: float) -> tuple[float, float]:
    """Return (cos, sin) of `direction`, exact at quarter turns.

    The rounding of cos(π/2) would let a source at Péclet number 1e12 drift across its own track.
    """
    angle = number("direction", direction, "rad")
    ux = math.cos(angle)
    uy = math.sin(angle)
    return (ux if abs(ux) > 1e-15 else 0.0), (uy if abs(uy) > 1e-15 else 0.0)


def responses(grid: Grid, source: MovingSource) -> Iterator[tuple[Index, Complex]]:
    """Yield (rows, κT/q̇ in m) block by block: every row of the half spectrum once, q = 0 with response 0."""
    qx = grid.wavevectors[0]
    count = grid.shape[0]
    half = grid.shape[0] // 2 + 1
    for start in range(0, half, ROWS):
        rows = np.arange(start, min(start + ROWS, half))
        response = _response_rows(grid, rows, qx[rows], source)
        if start == 0:
            response[0, 0] = 0.0
        yield rows, response
        # the rows at −q_x follow from the rows at q_x if the source slides along an axis
        inner = (rows > 0) & (2 * rows != count)  # rows with a partner at −q_x
        if not inner.any():
            continue
        if source.drift[1] == 0.0:
            partner = response[inner].conj()
        elif source.drift[0] == 0.0:
            partner = response[inner]
        else:
            partner = _response_rows(grid, rows, -qx[rows], source)[inner]
        yield count - rows[inner], partner


def _response_rows(grid: Grid, rows: Index, qx: Field, source: MovingSource) -> Complex:
    """κT/q̇ at the wavevectors (qx, q_y ≥ 0), averaged over both signs at the Nyquist wavenumber of an axis."""
    qy = grid.wavevectors[1]
    along = source.drift[0] * qx
    across = source.drift[1] * qy
    square = qx**2 + qy**2
    square[square == 0.0] = 1.0  # q = 0: any finite response, replaced by the caller

    def both_signs_of_qy(part: slice, along: Field) -> Complex:
        response = response_of(square[part], along + across, source)
        if grid.shape[1] % 2 == 0:
            flipped = response_of(square[part, -1:], along - across[:, -1:], source)
            response[:, -1:] = (response[:, -1:] + flipped) / 2
        return response

    response = both_signs_of_qy(slice(None), along)
    if 2 * rows[-1] == grid.shape[0]:
        response[-1:] = (response[-1:] + both_signs_of_qy(slice(-1, None), -along[-1:])) / 2
    return response


def response_of(square: Field, advection: Field, source: MovingSource) -> Complex:
    """κT/q̇ of waves with q² = `square` and q·v/D = `advection`, 1/m²."""
    drift, spread, depth, layers, lens = source
    if layers is None:
        response = response_of_waves(square, advection, depth, spread)
    else:
        response = response_from_rest(square, advection, layers, depth, spread)
    return response if lens is None else lens.seen(square, advection, math.hypot(*drift), response)


def fields_over_time(
    flux: Field,
    spreads: Array,
    response: Callable[[float], Field],
    shape: tuple[int, int],
    factor: float,
) -> Field:
    """Return one field per entry of `spreads`: one forward transform for all, one inverse each; zero for D t = 0.

    `response(spread)` is the response of `convolution.convolve`.
    """
    flowing = np.flatnonzero(spreads > 0.0)
    if spreads.size == flowing.size == 1:
        return convolution.convolve(flux, response(float(spreads[0])), shape, factor)[None]
    fields = np.zeros((spreads.size, *flux.shape), flux.dtype)
    if flowing.size:
        series = map(response, spreads[flowing].tolist())
        convolved = convolution.convolutions(flux, series, shape, factor)
        for index, field in zip(flowing, convolved, strict=True):
            fields[index] = field
    return fields
