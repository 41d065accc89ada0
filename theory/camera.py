"""What a camera sees of the temperature of a sliding rough surface: its rms, and the width of its tracks.

Of one wave T_q = μvσ_q/(κλ) with λ² = q² − iq_xv/D; x lies along sliding. A camera multiplies it by a factor H:

- point spread, a Gaussian with the full width w at half maximum: e^(−q²b²/2), b = w/√(8 ln 2);
- exposure, during which the contact moves by l past the camera: sin(q_xl/2)/(q_xl/2);
- a start from rest, since which it has slid a distance L: erf√(λ²Dt) with Dt = DL/v.

On a line at the distance d behind the straight trailing edge of a contact of length ℓ the heat was released in the
ages from d/v to (d + ℓ)/v. For vd/D ≫ 1 conduction along sliding does not count, and with λ² = q_y² − iq_xv/D

    H = erfc√(λ²Dd/v) − erfc√(λ²D(d + ℓ)/v),

blurred across only: e^(−q_y²b²/2). In all cases T_rms² = (μv/κ)² 2π ∫ q |σ_q|² ⟨|H|²/|λ|²⟩ dq, the mean over the
directions of q; of a face with a lay it has the weight of `theory.lay`, and waves have their true q. Source: Carslaw &
Jaeger, Conduction of Heat in Solids, 2nd ed. (1959), Sec. 10.7, for one wave.
"""

from collections.abc import Callable, Iterator
from math import hypot, inf, log10
from typing import NamedTuple, Protocol, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, Several, SpectrumLike, not_negative_array, real_array
from theory.flash import HeatSource, formula_of, heat_source
from theory.lay_picture import LayPicture
from theory.lay_waves import Weighted
from theory.persson import Weight
from theory.picture import Picture, View
from theory.skin import Skin
from theory.typed import Load

__all__ = ["ERROR_BANDS", "View", "error_band", "seen_rms", "seen_width"]

SHARP = View()
# relative; experiments/camera_law.py: 15 contacts, worst −1.4 %; frozen contact followed from rest, from either body,
# 10 pictures, worst +4.0 %; slides, 12 pictures, worst +1.7 %. The width in 10 contacts, worst +2.8 %
ERROR_BANDS = {"seen_rms": 0.05, "seen_width": 0.05}
_OF_LAY = {"seen_rms": 0.09, "seen_width": 0.18}  # beside it at γ = 10; experiments/lay_camera.py


class _Look(NamedTuple):
    """What a camera looks at, with checked numbers."""

    source: HeatSource
    view: View
    stress: Weighted | None
    direction: float

    def pictures(self) -> "Iterator[Picture]":
        """Yield the picture at each speed."""
        for speed in np.abs(self.source.velocity).flat:
            if self.stress is None:
                yield Picture(self.source, speed, self.view)
            else:
                yield LayPicture(self.source, speed, self.view, self.stress, self.direction)


def _looked_at(  # noqa: PLR0913  (load, body, and the camera)
    speed: ArrayLike,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
    view: View = SHARP,
    stress: Weighted | None = None,
    direction: float = 0.0,
) -> _Look:
    """Check the arguments of both functions below, which `seen_rms` describes."""
    if stress is not None:
        stress_spectrum = stress.stress_spectrum
    source = heat_source(
        speed,
        spectrum,
        nominal_pressure=nominal_pressure,
        friction_coefficient=friction_coefficient,
        conductivity=conductivity,
        diffusivity=diffusivity,
        effective_modulus=effective_modulus,
        gamma=gamma,
        stress_spectrum=stress_spectrum,
        skin=skin,
        heat_depth=heat_depth,
    )
    angle = float(real_array("direction", direction, "rad"))
    return _Look(source, _checked(view, source), stress, angle)


class _Seen(Load, total=False):
    view: View
    stress: Weighted | None
    direction: float


class _OfSpeed(Protocol):
    @overload
    def __call__(
        self, speed: float, spectrum: SpectrumLike | None = None, **seen: Unpack[_Seen]
    ) -> float: ...
    @overload
    def __call__(
        self, speed: Several, spectrum: SpectrumLike | None = None, **seen: Unpack[_Seen]
    ) -> Array: ...
    @overload
    def __call__(
        self, speed: ArrayLike, spectrum: SpectrumLike | None = None, **seen: Unpack[_Seen]
    ) -> Array | float: ...


_seen: Callable[[Callable[[_Look], Array]], _OfSpeed] = formula_of(_looked_at)


@_seen
def seen_rms(look: _Look) -> Array:
    """Root mean square of the temperature that a camera sees, about the mean of the surface, with all heat in the body.

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `theory.flash.flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `theory.flash.flash_temperature`.
    view : View
        What the camera looks at, and how sharply.
    stress, direction : LayStress, float
        Of a face with a lay (`theory.lay.stress_of_lay`), in place of a spectrum; sliding, rad from its grooves.

    Returns
    -------
    ndarray or float
        K, the shape of `speed`; a float for one speed. 0 at rest. Without a camera, `theory.flash.rms_temperature`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real and of the right sign, or a `view` of a body with a skin or a heated depth is not
        of steady sliding.
    theory.quadrature.QuadratureError
        If two quadratures differ by more than 1e-6 of the mean square.
    """
    source = look.source
    squares = [picture.mean_square() for picture in look.pictures()]
    rms: Array = np.sqrt(np.reshape(squares, source.velocity.shape))
    return source.pressure * source.heating * rms


@_seen
def seen_width(look: _Look) -> Array:
    """Full width at half maximum of the autocorrelation of the picture across sliding, m.

    It is √2 times the full width of a track with a Gaussian profile.

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `theory.flash.flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `theory.flash.flash_temperature`.
    view, stress, direction
        As in `seen_rms`.

    Returns
    -------
    ndarray or float
        m, the shape of `speed`; a float for one speed. At rest the limit for v → 0. μ and κ cancel.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `seen_rms`, or the picture is uniform.
    """
    widths = [picture.width() for picture in look.pictures()]
    return np.reshape(widths, look.source.velocity.shape)


def error_band(name: str, lay: float = 1.0) -> float:
    """Return the relative error, 95 %, of the observable of a picture by its `name`, of a face with a `lay` γ."""
    return hypot(ERROR_BANDS[name], _OF_LAY[name] * log10(lay))


def _checked(view: View, source: HeatSource) -> View:
    """Return a view with checked numbers."""

    def length(name: str, value: float) -> float:
        if value == inf and name in ("slid_distance", "contact_length"):
            return inf
        return float(not_negative_array(name, value, "m"))

    numbers = {
        name: length(name, part) for name, part in view._asdict().items() if part is not None
    }
    for name in ("slid_distance", "contact_length"):
        if numbers[name] == 0.0:
            raise ValueError(f"{name} = 0 m must be positive: without heat there is no picture")
    checked = View(**numbers)
    if source.body.layers is not None and (
        checked.behind is not None or checked.slid_distance < inf
    ):
        raise ValueError(
            "a picture of a body with a skin or a heated depth is known for steady sliding only; leave out behind and "
            "slid_distance"
        )
    if checked.behind is not None and checked.smear > 0.0:
        raise ValueError(
            f"smear = {checked.smear:.6g} m with behind: the line stays at its distance from the contact; leave one out"
        )
    return checked
