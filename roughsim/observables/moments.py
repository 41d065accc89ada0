"""Measuring a solved contact: stress-weighted moments of the temperature, and the stress correlation.

All moments come from one forward transform of the pressure. With w(q) = |σ(q)|², summed over the modes without q = 0,

    T_flash   =  (μ|v|/κσ₀) Σ w Re F/|q|         Eqs. (3), (4)    F = (1 − ia)^(−1/2),  a = q·v/(D q²)
    T′_flash  =  (μ|v|/κσ₀) Σ w Re(i cosφ F)     Eqs. (6), (7)    φ the angle between q and the sliding velocity
    ∇²T_flash = −(μ|v|/κσ₀) Σ w |q| Re F         Eqs. (8), (9)

Averaged over all directions of sliding, Re F and Re(i cosφ F) become (2/π)A and (2/π)B of a = |v|/(D|q|), in closed
form. That average holds for isotropic roughness. It leaves no favoured row of modes, in which one direction of sliding
meets its own hot tracks in a periodic cell, and it needs one sum over |q| in place of one over the plane. With a skin,
or heat released in depth, F = |q| κT/q̇ of `roughsim.heat.skin`, and the averages are its quadrature.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from roughsim import fourier
from roughsim.contact import Contact
from roughsim.contact.patches import edge_corrected
from roughsim.errors import need_computed, need_finite, not_negative, number, real_plane, sized
from roughsim.grid import Array, Complex, Grid, need_grid
from roughsim.heat.body import Body
from roughsim.heat.periodic import MovingSource, moving, unit_vector
from roughsim.heat.skin import Layering, SkinLike, checked_skin, direction_means
from roughsim.observables.directed import sums_in_directions
from roughsim.observables.stress_spectrum import (
    StressSpectrum,
    gathering,
    stress_spectrum,
)

# K = (π/2) Σ and D = (K−E)/m = (π/4) Σ in powers of the parameter: (½)ₙ²/(1)ₙ² and (½)ₙ(3/2)ₙ/((2)ₙ(1)ₙ)
_K_SERIES = [math.comb(2 * n, n) ** 2 / 16**n for n in range(10)]
_D_SERIES = [math.comb(2 * n, n) ** 2 * (2 * n + 1) / (16**n * (n + 1)) for n in range(10)]
_SHORT = 1 << 13  # numbers of a sum that OpenBLAS leaves to one thread: it divides more than 10,000


@dataclass(frozen=True, slots=True)
class HeatSource:
    """Frictional heat of a sliding contact: speeds, friction, and the properties of the heated body.

    TypeError or ValueError for an entry of the wrong kind, not finite or out of its range.

    Parameters
    ----------
    speeds : sequence of float
        Sliding speeds, m/s, at least one. A negative speed slides the other way; heat is μσ|v|.
    friction_coefficient : float or sequence of float
        μ ≥ 0: one for all speeds, or one for each.
    conductivity, diffusivity : float or sequence of float
        κ, W/(m K), and D, m²/s, of the body whose temperature is measured: one for all speeds, or one for each.
    heat_partition : float
        Share of the heat that enters the body, 0 to 1: a factor on all temperatures.
    direction : float or sequence of float, optional
        Angle of sliding, radians from axis 0 towards axis 1: one for all speeds, or one for each. None: the mean over
        all directions, for isotropic roughness.
    from_rest : bool
        Whether the contact has slid half the chord of the cell along a direction since its start from rest, so that it
        does not meet its own tracks; else it has slid for ever.
    skin : Skin, optional
        A layer of another material on the body: thickness, m, conductivity, W/(m K), and diffusivity, m²/s.
    heat_depth : float
        Depth h, m, ≥ 0, in which the heat is released, with the density q̇ e^(−z/h)/h; 0 is the surface.
    """

    speeds: Sequence[float]
    friction_coefficient: float | Sequence[float]
    conductivity: float | Sequence[float]
    diffusivity: float | Sequence[float]
    heat_partition: float = 1.0
    direction: float | Sequence[float] | None = None
    skin: SkinLike | None = None
    heat_depth: float = 0.0
    from_rest: bool = False

    def __post_init__(self) -> None:
        words = isinstance(self.speeds, (str, bytes))
        if words or np.ndim(self.speeds) != 1 or len(self.speeds) == 0:
            raise TypeError(
                f"speeds = {self.speeds!r} must be a sequence of at least one speed in m/s"
            )
        checked: dict[str, Any] = {
            "speeds": tuple(number("speeds", speed, "m/s") for speed in self.speeds),
            "heat_partition": not_negative("heat_partition", self.heat_partition),
            "skin": checked_skin(self.skin),
            "heat_depth": not_negative("heat_depth", self.heat_depth, "m"),
        }
        if self.from_rest and self.direction is None:
            raise ValueError(
                "from_rest = True needs a direction: the mean over all directions is of steady sliding"
            )
        if self.heat_partition > 1.0:
            raise ValueError(f"heat_partition = {self.heat_partition:.6g} must lie between 0 and 1")
        checks = {
            "friction_coefficient": (not_negative, "1"),
            "conductivity": (sized, "W/(m K)"),
            "diffusivity": (sized, "m²/s"),
            "direction": (number, "rad"),
        }
        for name, (check, unit) in checks.items():
            value = getattr(self, name)
            if value is None:  # no direction
                continue
            if np.ndim(value) == 0:
                checked[name] = check(name, value, unit)
            elif np.shape(value) == (len(self.speeds),):
                checked[name] = tuple(check(name, entry, unit) for entry in value)
            else:
                raise ValueError(
                    f"{name} has shape {np.shape(value)} for {len(self.speeds)} speeds; give one number in {unit} or "
                    "one for each speed"
                )
        for name, entry in checked.items():
            object.__setattr__(self, name, entry)

    @property
    def bodies(self) -> list[Body]:
        """The heated body at each speed."""
        columns = np.broadcast(self.conductivity, self.diffusivity, self.speeds)
        return [
            Body(float(kappa), float(d), float(v), self.skin, self.heat_depth)
            for kappa, d, v in columns
        ]

    @property
    def rates(self) -> list[float]:
        """v/D at each speed, 1/m, with the sign of the speed."""
        return [body.speed / body.diffusivity for body in self.bodies]

    def sources(self, grid: Grid) -> list[MovingSource]:
        """Return the source at each speed, over half of a `grid` if it starts from rest; along x without a direction.

        ValueError for a cell or a speed at which the heat is lost in rounding.
        """
        slid = None if self.from_rest else math.inf
        angles = np.broadcast_to(self.direction or 0.0, len(self.speeds)).tolist()
        found = []
        for body, angle in zip(self.bodies, angles, strict=True):
            _, duration, _ = moving(grid, body.speed, body.diffusivity, angle, slid)
            ux, uy = unit_vector(angle)
            rate = body.speed / body.diffusivity
            spread = body.diffusivity * float(duration)
            found.append(MovingSource((rate * ux, rate * uy), spread, layers=body.layers))
        return found

    @property
    def layers(self) -> tuple[Layering | None, ...]:
        """The skin and the depth of release in units of the body at each speed; None of a bare body."""
        return tuple(body.layers for body in self.bodies)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Moments:
    """Moments of one contact; the arrays run over the speeds of `HeatSource`, areas are shares of the cell.

    Attributes
    ----------
    speeds : tuple of float
        Of sliding, m/s.
    flash_temperature : ndarray
        ⟨Tσ⟩/σ₀, K, steady sliding. Eq. (3).
    flash_gradient : ndarray
        ⟨∂T σ⟩/σ₀, K/m, along the sliding velocity: ≤ 0 for either sign of the speed. Eq. (6).
    flash_laplacian : ndarray
        ⟨∇²T σ⟩/σ₀, K/m², in the plane of the surface. Eq. (8).
    flash_width : ndarray
        D_flash = √(−T/∇²T), m; at rest its limit. Eq. (25).
    slope_length : ndarray
        d_flash = −T/T′, m; inf at rest. Eq. (26).
    resting_flash_temperature : ndarray
        ⟨Tσ⟩/σ₀, K, of the same heat μσ|v| in a bare body that does not move under it.
    contact_fraction : float
        Share of the pixels, as in `Contact`.
    plastic_fraction : float
        Share of the pixels with plastic contact, as in `Contact`.
    contact_fraction_corrected : float
        Corrected for the pixels along the edges (`roughsim.contact.patches`).
    plastic_fraction_corrected : float
        The same, of plastic contact.
    nominal_pressure : float
        Mean pressure σ₀, Pa.
    stress_spectrum : StressSpectrum
        Variance of the stress by wavenumber.
    """

    speeds: tuple[float, ...]
    flash_temperature: Array
    flash_gradient: Array
    flash_laplacian: Array
    flash_width: Array
    slope_length: Array
    resting_flash_temperature: Array
    contact_fraction: float
    plastic_fraction: float
    contact_fraction_corrected: float
    plastic_fraction_corrected: float
    nominal_pressure: float
    stress_spectrum: StressSpectrum

    def __repr__(self) -> str:
        speeds = ", ".join(f"{speed:g}" for speed in self.speeds)
        flash = ", ".join(f"{value:.4g}" for value in self.flash_temperature)
        return f"<Moments: T_flash {flash} K at {speeds} m/s, contact_fraction {self.contact_fraction:.4g}>"

    @property
    def pressure_variance(self) -> float:
        """g_σ(0) = ⟨σ²⟩ − σ₀², Pa²."""
        return self.stress_spectrum.pressure_variance

    def pressure_correlation(self, r: ArrayLike) -> Array:
        """Return g_σ(r), Pa², at distances up to half the diagonal of the cell, m. Eqs. (1), (2)"""
        return self.stress_spectrum.pressure_correlation(r)


def measure(
    contact: Contact, grid: Grid | HeatSource, sliding: HeatSource | None = None
) -> Moments:
    """Measure the moments of one contact at all speeds from one forward transform.

    Parameters
    ----------
    contact : Contact
        Its pressure (shape `grid.shape`, Pa), and its fractions of contact and plastic contact are read.
    grid : Grid
        Left out, as in ``measure(contact, heat_source)``: the grid that the contact was solved on.
    sliding : HeatSource
        Speeds, friction and the body.

    Returns
    -------
    Moments
        Of steady sliding; for one direction they are moments of the periodic field, hot tracks included unless it is
        `from_rest`. Without contact temperatures, width and length are NaN, with a RuntimeWarning.

    Raises
    ------
    TypeError, ValueError
        If the pressure is not a finite real field of `grid.shape`, or has no positive mean though it is not zero.
    """
    grid, sliding = _grid_and_source(contact, grid, sliding)
    pressure = real_plane("pressure", contact.pressure, grid.shape).astype(float, copy=False)
    low, high = float(pressure.min()), float(pressure.max())  # NaN if any pressure is
    if not (math.isfinite(low) and math.isfinite(high)):
        need_finite("pressure", pressure)
    amplitude = fourier.transformed(pressure)
    mean = float(amplitude[0, 0].real)
    if mean < 0.0 or (mean == 0.0 and pressure.any()):
        raise ValueError(
            f"pressure has the mean {mean:.6g} Pa, but compression is positive; give the pressure of a solved contact"
        )
    if mean == 0.0:
        message = (
            "pressure = 0 Pa everywhere: without contact temperatures, width and length are NaN"
        )
        warnings.warn(message, RuntimeWarning, 2)
    if low == high:  # only q = 0, whatever the rounding of the transform
        amplitude[...] = 0.0
    spectrum, sums = spectrum_and_sums(amplitude, grid, sliding)
    # corrections for the pixels along the edges of the contact
    hardness = high if contact.plastic_fraction > 0.0 else math.inf
    corrected = edge_corrected(np.maximum(pressure, 0.0) if low < 0.0 else pressure, hardness)
    # the factor of the sums, and their ratios; 0/0 without stress variance is NaN
    with np.errstate(divide="ignore", invalid="ignore"):
        friction = sliding.heat_partition * np.asarray(sliding.friction_coefficient)
        heating = friction * np.abs(sliding.speeds)
        factor = heating / (np.asarray(sliding.conductivity) * mean)
        ratios = sums[0] / (sums[1:] + 0.0)  # a sum of −0 would give −inf at rest
        if mean > 0.0:
            causes = "pressure, speeds, friction_coefficient and conductivity"
            need_computed("temperature", factor * sums, "K", causes)
        resting = float(np.sum(spectrum.variance / spectrum.wavenumber))
        return Moments(
            speeds=tuple(sliding.speeds),
            flash_temperature=factor * sums[0],
            flash_gradient=-factor * sums[1],
            flash_laplacian=-factor * sums[2],
            flash_width=np.sqrt(ratios[1]),
            slope_length=ratios[0],
            resting_flash_temperature=factor * resting,
            contact_fraction=contact.contact_fraction,
            plastic_fraction=contact.plastic_fraction,
            contact_fraction_corrected=corrected[0],
            plastic_fraction_corrected=corrected[1],
            nominal_pressure=mean,
            stress_spectrum=spectrum,
        )


def _grid_and_source(
    contact: Contact, grid: Grid | HeatSource, source: HeatSource | None
) -> tuple[Grid, HeatSource]:
    """Return the grid of a contact and the source from the arguments of `measure`."""
    if isinstance(grid, HeatSource):
        if contact.grid is None:
            raise TypeError("contact has no grid; write measure(contact, grid, heat_source)")
        return contact.grid, grid
    need_grid(grid)
    if source is None:
        raise TypeError("measure needs a HeatSource, as HeatSource(speeds=[35.0], ...)")
    return grid, source


def spectrum_and_sums(
    amplitude: Complex, grid: Grid, sliding: HeatSource
) -> tuple[StressSpectrum, Array]:
    """Return the spectrum of the stress, and the three sums of its moments at each speed, (3, speeds).

    `amplitude` is the transform of the pressure, Pa. The sums are over all directions, or in those of the source.
    """
    spectrum, unseen = stress_spectrum(amplitude, grid, gathering(grid))
    if sliding.direction is None:
        return spectrum, sums_over_directions(spectrum, unseen, grid_responses(grid, sliding))
    return spectrum, sums_in_directions(amplitude, grid, sliding.sources(grid))


def angular_means(ratio: Array) -> tuple[Array, Array]:
    """Return ((2/π)A(a), (2/π)B(a)) for a = v/(Dq) ≥ 0, dimensionless: A from 1 to 0, B ≤ 0. Eqs. (4), (7)

    With s = (1+a²)^(−1/2) and the parameter m = (1−s)/2 ≤ 1/2 of the complete elliptic integrals,

        A(a) = Re ∫₀^{π/2} (1 − ia cosφ)^(−1/2) dφ        =  √s K(m),
        B(a) = Re ∫₀^{π/2} i cosφ (1 − ia cosφ)^(−1/2) dφ = −√s · as/(1+s) · [E(m) − (1−m)K(m)]/m.
    """
    s = 1.0 / np.hypot(1.0, ratio)
    slid = s * ratio / (1.0 + s)  # as/(1+s) = √(m/(1−m)), without the cancellation of 1−s
    slope = np.sqrt(0.5 * (1.0 + s))  # k′ = √(1−m)
    # a descending Landen step takes m to n² ≤ 0.0295, so that ten terms of the series of K and D give 1e-17
    landen = (slid * slope / (1.0 + slope)) ** 2  # n = (1−k′)/(1+k′) = m/(1+k′)², m = slid²k′²
    square = landen * landen
    complete = polyval(square, _K_SERIES)
    scale = np.sqrt(s) * (1.0 + landen)
    # [E − (1−m)K]/m = ½(1+n)[K(n²) − n D(n²)] cancels nowhere
    odd = complete - 0.5 * landen * polyval(square, _D_SERIES)
    return scale * complete, -0.5 * scale * slid * odd


class GridResponses(NamedTuple):
    """`means_over_directions` at the wavenumbers of a grid, shapes (speeds, wavenumbers)."""

    even: Array
    odd: Array
    odd_at_nyquist: Array  # at the waves without a derivative along an axis


# 13 ms for each contact of 768² points, which a solve takes 140 ms for; the grids of a run come in turn
@lru_cache(maxsize=8)
def grid_responses(grid: Grid, sliding: HeatSource) -> GridResponses:
    """Return the responses at the wavenumbers of a grid, at each speed of a source."""
    nodes, waves = gathering(grid)
    pairs = [(abs(body.speed / body.diffusivity), body.layers) for body in sliding.bodies]

    def means(q: Array) -> Array:
        return np.stack([means_over_directions(q, *pair) for pair in pairs], axis=1)

    even, odd = means(nodes.entries)
    return GridResponses(even, odd, means(waves.wavenumber)[1])


def sums_over_directions(
    spectrum: StressSpectrum, unseen: Array, responses: GridResponses
) -> Array:
    """Return Σ w Re F/|q|, −Σ w Re(i cosφ F), Σ w |q| Re F, averaged over all directions; shape (3, speeds)."""
    q = spectrum.wavenumber
    w = spectrum.variance

    def total(response: Array, weight: Array) -> Array:
        # in short pieces, or the sums would depend on the number of threads of the BLAS
        result = np.zeros(len(response))
        for start in range(0, weight.size, _SHORT):
            piece = slice(start, start + _SHORT)
            result = result + np.vecdot(response[:, piece], weight[piece])
        return result

    flash = total(responses.even, w / q)
    gradient = total(responses.odd_at_nyquist, unseen) - total(responses.odd, w)
    return np.stack((flash, gradient, total(responses.even, w * q)))


def means_over_directions(q: Array, rate: float, layers: Layering | None) -> tuple[Array, Array]:
    """Return the means over directions of Re F and Re(i cosφ F) at wavenumbers, rad/m, for v/D = `rate` ≥ 0, 1/m."""
    return angular_means(rate / q) if layers is None else direction_means(q, rate, layers)
