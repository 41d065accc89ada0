"""What a camera sees of the temperature of one contact: means over directions from its stress, and its picture.

The mean square of the picture is (μv/κ)² Σ w(q) ⟨|F|²⟩, F = κT/q̇ of `roughsim.heat.periodic.response_of` with the
lens, w(q) the variance of the stress, averaged over the directions of sliding; with cos(q_y y) under the mean it is the
correlation across sliding at the distance y. That holds for isotropic roughness, and leaves out the rows of waves on
which contacts of a periodic cell meet their own tracks. Faces with a lay have a sum over waves in each direction
(`roughsim.observables.directed_pictures`).
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.special import ndtr

from roughsim.fourier import transformed
from roughsim.fourier.convolution import convolutions
from roughsim.grid import Array, Field, Grid
from roughsim.heat.periodic import MovingSource, moving, response_of, turned_response
from roughsim.observables.catalogue import CORRELATIONS
from roughsim.observables.directed_pictures import (
    correlation_across,
    mean_squares_of_waves,
    variance_of,
)
from roughsim.observables.distribution import crossing
from roughsim.observables.moments import HeatSource
from roughsim.observables.record import Sample, ratio
from roughsim.observables.stress_spectrum import StressSpectrum, gathering, stress_spectrum

EXCEEDED = 0.01  # share of the picture that is hotter than `seen_99`
_GROWTH, _NODES = 1.6, 14  # of panels over the angle, and their nodes: 1e-6 of smooth means
_AT_REST = 1e-100  # K/(Pa m): no speed makes so little heat
_BINS = 1000  # of temperatures
_BLOCK = 128  # wavenumbers that share their directions
_DISTANCES = np.append(
    0.0, np.geomspace(1e-3, 1.0, len(CORRELATIONS) - 1)
)  # of the correlation, over the largest


class Camera(NamedTuple):
    """A camera, and the sliding that it looks at, at each speed of a `HeatSource`."""

    # with the lens and the slid distance, sliding along x; over faces with a lay in each direction
    sources: tuple[MovingSource, ...]
    heating: tuple[float, ...]  # μ|v|/κ, K/(Pa m)
    # of the pictures, radians from axis 0 towards axis 1; or of each speed
    direction: float | tuple[float, ...] = 0.0
    slid_distance: float | None = None  # most of the picture, m; None: half the chord of the cell
    directed: bool = False  # whether faces have a lay: then no mean over directions holds


def mean_squares(wavenumber: Array, source: MovingSource, distance: float = 0.0) -> Array:
    """Return ⟨|F|²⟩ over directions, m², at each wavenumber, rad/m; (n,).

    With a `distance` > 0, m, ⟨|F|² cos(q_y y)⟩ at 49 distances y = 0 … `distance`, (n, 49), as `distances` has them.
    """
    return _remembered(wavenumber.tobytes(), source, distance)


def distances(largest: float) -> Array:
    """Return the distances across sliding of a correlation, m, from 0 on."""
    return largest * _DISTANCES


@lru_cache(maxsize=64)  # .1 to 1 s for the wavenumbers of a grid, at each speed
def _remembered(wavenumbers: bytes, source: MovingSource, distance: float) -> Array:
    q = np.frombuffer(wavenumbers)
    lens = source.lens
    rate = math.hypot(*source.drift)
    points, weights = legendre.leggauss(_NODES)
    # lengths l of waves cos(q_xl) in |F|²
    lengths = [source.spread * rate]
    if lens is not None:
        lengths += [lens.smear] if lens.behind is None else [lens.contact_length]
    means = []
    for start in range(0, q.size, _BLOCK):
        part = q[start : start + _BLOCK]
        low = float(part.min())
        high = float(part.max())
        turns = [1 / (high * one) for one in lengths if 0 < one < math.inf]
        few = min([1.0, low / rate, *turns])
        narrow = 1.0
        if lens is not None and lens.behind is not None:
            age = lens.behind + min(lens.contact_length, 1.0)
            narrow = min(1.0, 1 / (high * math.sqrt(age / rate + lens.resolution**2)))
        edges = np.append(_panels(few)[:-1], math.pi / 2 - _panels(narrow)[::-1])
        half = np.diff(edges)[:, None] / 2
        angle = (edges[:-1, None] + half * (1 + points)).ravel()  # from q_x = 0
        share = (half * weights).ravel() * 2 / math.pi
        x = part[:, None] * np.sin(angle)
        y = part[:, None] * np.cos(angle)
        response = response_of(x**2 + y**2, rate * x, source._replace(drift=(rate, 0.0)))
        power = share * (response.real**2 + response.imag**2)
        if distance == 0.0:
            means.append(power.sum(axis=1))
        else:
            each = (np.sum(power * np.cos(y * one), axis=1) for one in distances(distance))
            means.append(np.stack([*each], axis=1))
    found = np.concatenate(means) if means else np.empty(0)
    found.flags.writeable = False
    return found


def _panels(start: float) -> Array:
    """Return edges of growing panels over an eighth of a turn."""
    count = max(math.ceil(math.log(math.pi / 4 / start) / math.log(_GROWTH)), 0)
    return np.append(0.0, math.pi / 4 * _GROWTH ** -np.arange(count, -1.0, -1.0))


def hottest_of(
    pressure: Field, grid: Grid, spectrum: StressSpectrum, sliding: HeatSource, camera: Camera
) -> Array:
    """Return the temperature that `EXCEEDED` of the picture of a contact exceeds, K above its mean, (speeds,).

    The picture starts from rest in the periodic cell, and slides at most so far that no contact meets its own track;
    what it shows over its rms comes with older heat as in `hottest_over_rms`. Its rms is at the whole slid distance,
    over all directions if faces are isotropic. Zero at rest, and of a uniform pressure.

    An instrument that averages its pictures finds the mean over contacts. That is within .3 % of what as much of all
    pictures together exceeds, with few spots in each (experiments/few_spots_seen.py).
    """
    mean_square = _mean_square(pressure, grid, camera, spectrum)
    rms = np.array(camera.heating) * np.sqrt([mean_square(one) for one in camera.sources])
    return rms * hottest_over_rms(pressure, grid, sliding, camera, spectrum)


def _mean_square(
    pressure: Field, grid: Grid, camera: Camera, spectrum: StressSpectrum | None
) -> Callable[[MovingSource], float]:
    """Return a function of a source: the mean square of κT/q̇ of the stress of a contact, Pa² m²."""
    if camera.directed:
        waves = variance_of(transformed(pressure), grid)
        return lambda one: float(np.sum(waves * mean_squares_of_waves(grid, one)))
    if spectrum is None:
        spectrum, _ = stress_spectrum(transformed(pressure), grid, gathering(grid))
    q = spectrum.wavenumber
    variance = spectrum.variance
    return lambda one: float(variance @ mean_squares(q, one))


def correlations_of(pressure: Field, grid: Grid, camera: Camera) -> Array:
    """Return Σ w ⟨|F|²⟩ cos(q·y) of a contact of faces with a lay at `distances` y, Pa² m², (speeds, distances)."""
    variance = variance_of(transformed(pressure), grid)
    reach = 0.5 * math.hypot(*grid.lengths)
    return correlation_across(variance, grid, camera.sources, distances(reach))


def hottest_over_rms(
    pressure: Field,
    grid: Grid,
    sliding: HeatSource,
    camera: Camera,
    spectrum: StressSpectrum | None = None,
) -> Array:
    """Return the temperature that `EXCEEDED` of the picture exceeds, over its own rms, (speeds,).

    Heat older than the picture adds a normally distributed temperature with the variance that the picture lacks: left
    out, the result would be up to 13 % too high. An exposure longer than the slide lengthens old tracks and young ones
    alike, so that nothing is added. NaN if the camera blurs all waves of the cell away.
    """
    if pressure.min() == pressure.max():
        return np.zeros(len(camera.sources))
    mean_square = _mean_square(pressure, grid, camera, spectrum)
    hottest = np.full(len(camera.sources), np.nan)
    younger = _young(grid, sliding, camera)
    for k, field in enumerate(pictures(pressure, grid, sliding, camera)):
        own = float(np.sqrt(np.mean(np.square(field, dtype=float))))
        if own > 0.0:
            older = _older(mean_square, camera.sources[k], younger[k])
            hottest[k] = _exceeded(field, own * math.sqrt(older)) / (own * math.sqrt(1 + older))
    return hottest


def _older(
    mean_square: Callable[[MovingSource], float], whole: MovingSource, young: MovingSource
) -> float:
    """Return the variance of the picture by heat that is older than it, over the variance of the picture."""
    slid = young.spread * math.hypot(*young.drift)
    if whole == young or (whole.lens is not None and whole.lens.smear > slid):
        return 0.0
    # the direction of sliding does not count in means over all of them
    seen = mean_square(young._replace(drift=whole.drift))
    all_of_it = mean_square(whole)
    return max(all_of_it / seen - 1.0, 0.0) if seen > 0.0 else 0.0


def _exceeded(field: Field, spread: float) -> float:
    """Return what `EXCEEDED` of a field exceeds with a normally distributed number of this standard deviation added."""
    hottest = float(np.quantile(field, 1.0 - EXCEEDED))
    if spread <= 1e-3 * np.ptp(field):
        return hottest
    counts, edges = np.histogram(field, _BINS)
    middles = (edges[:-1] + edges[1:]) / 2

    def colder(temperature: Array) -> Array:
        return counts @ ndtr((temperature - middles) / spread) / field.size

    ends = np.array([hottest - 3 * spread, edges[-1] + 3 * spread])
    return float(crossing(colder, 1.0 - EXCEEDED, *ends)[1])


def pictures(pressure: Field, grid: Grid, sliding: HeatSource, camera: Camera) -> list[Field]:
    """Return κT/q̇ of the whole picture, m, at each speed, q̇ the mean heat; without its mean."""
    flux = (pressure / pressure.mean()).astype(np.float32)
    sources = _young(grid, sliding, camera)
    responses = [turned_response(grid, source, np.float32) for source in sources]
    return list(convolutions(flux, responses, grid.shape))


def _young(grid: Grid, sliding: HeatSource, camera: Camera) -> list[MovingSource]:
    """Return the sources that slide through the cell so far that no contact meets its own track."""
    directions = np.broadcast_to(camera.direction, len(sliding.speeds)).tolist()
    sources = []
    for body, angle, seen in zip(sliding.bodies, directions, camera.sources, strict=True):
        drift, _, chord = moving(grid, body.speed, body.diffusivity, angle)
        rate = math.hypot(*drift)
        lens = seen.lens
        # in half a cell no contact meets its own track
        slid = min(seen.spread * rate, camera.slid_distance or chord / 2)
        if lens is not None and lens.behind is not None:
            lens = lens._replace(contact_length=min(lens.contact_length, slid))
        sources.append(MovingSource(drift, slid / rate, layers=seen.layers, lens=lens))
    return sources


def seen_rms(sample: Sample, camera: Camera) -> Array:
    """Return influence values of the rms of the picture, K, (n, speeds)."""
    if camera.directed:
        both = sample.numbers[CORRELATIONS[0]] * np.square(camera.heating)
    else:
        squares = [
            sample.spectrum @ mean_squares(sample.wavenumber, one) * heating**2
            for one, heating in zip(camera.sources, camera.heating, strict=True)
        ]
        both = np.stack(squares, axis=1)
    heated = np.array(camera.heating) > _AT_REST
    both[:, heated & ~(both > 0.0).any(axis=0)] = np.nan  # blurred by more than the cell
    return ratio(both, np.ones_like(both), 0.5)


def seen_width(sample: Sample, camera: Camera) -> Array:
    """Return influence values of the full width at half maximum of the correlation across sliding, m, (n, speeds)."""
    y = distances(sample.reach)
    if camera.directed:
        stored = np.stack([sample.numbers[name] for name in CORRELATIONS], axis=2)
        return np.stack([widths(stored[:, k], y) for k in range(stored.shape[1])], axis=1)
    columns = []
    for one in camera.sources:
        kernel = mean_squares(sample.wavenumber, one, sample.reach)
        columns.append(widths(sample.spectrum @ kernel, y))
    return np.stack(columns, axis=1)


def widths(correlation: Array, y: Array) -> Array:
    """Return influence values (n,) of twice the first distance at which the mean of correlations (n, m) is halved.

    A change δC of one realization moves the crossing by −δC/C′; NaN if there is none.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    mean = correlation.mean(axis=0)
    below = np.flatnonzero(mean < 0.5 * mean[0])
    if not below.size or below[0] < 2 or not mean[0] > 0.0:
        return np.full(len(correlation), np.nan)
    ln_y = np.log(y[1:])
    above_half = correlation - correlation[:, :1] / 2
    excess = CubicSpline(ln_y, above_half[:, 1:], axis=1)
    of_mean = CubicSpline(ln_y, (mean - mean[0] / 2)[1:])
    low = np.log(y[below[0] - 1])
    high = np.log(y[below[0]])
    place = next(root for root in of_mean.solve(0.0, extrapolate=False) if low <= root <= high)
    half = math.exp(place)
    return 2.0 * half * (1.0 - excess(place) / of_mean(place, 1))
