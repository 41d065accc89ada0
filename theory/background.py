"""Background temperature: the uniform part (q = 0) of the frictional heat, of an endless plane or a round contact."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf, isinf, pi, sqrt
from typing import NamedTuple, Protocol, Required, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import (
    Array,
    Several,
    float_if_scalar,
    itself,
    not_negative_array,
    positive,
    real_array,
)
from theory.disc import mean_rise
from theory.quadrature import QuadratureError
from theory.skin import Skin, ThermalBody, body_of, steady_rise

_ACCURACY = 1e-10


class NominalContact(NamedTuple):
    """The face that is heated, and for how long; a radius of inf is an endless plane, a track of inf straight."""

    duration: float = inf  # s since the heat began; inf is steady
    radius: float = inf  # m
    track_radius: float = inf  # m, of the ring on which the contact moves over a body


ENDLESS = NominalContact()


def nominal_contact(
    duration: float | None, contact_radius: float | None, track_radius: float | None
) -> NominalContact:
    """Return a contact of checked numbers, each None for inf; TypeError or ValueError naming the argument otherwise.

    `duration` is in s, `contact_radius` and `track_radius` in m.
    """
    numbers = {
        "duration": (duration, "s"),
        "contact_radius": (contact_radius, "m"),
        "track_radius": (track_radius, "m"),
    }
    contact = NominalContact(
        *(
            inf if value is None else positive(name, value, unit)
            for name, (value, unit) in numbers.items()
        )
    )
    if contact_radius is None and track_radius is not None:
        raise ValueError(
            f"track_radius = {contact.track_radius:.6g} m is of a round contact; give its contact_radius"
        )
    if contact_radius is not None and contact.track_radius < contact.radius:
        raise ValueError(
            f"track_radius = {contact.track_radius:.6g} m must be at least the contact_radius of {contact.radius:.6g} m"
        )
    return contact


def heat_length(body: ThermalBody, contact: NominalContact, speed: float = 0.0) -> float:
    """Return κT₀/q̇, m: the background of a body by a constant flux on a contact that moves at a speed, m/s, ≥ 0.

    It is 2√(Dt/π) under an endless plane, and aU of a disc (`theory.disc`), plus the rise by layers of the body.
    ValueError if these have not warmed through, or without a steady value: of an endless plane at t = inf.
    """
    diffusivity, layers = body.diffusivity, body.layers
    if isinf(contact.radius):
        if isinf(contact.duration):
            raise ValueError("duration is missing: an endless plane warms for ever; give it")
        length = 2 * sqrt(diffusivity / pi) * sqrt(contact.duration)
        spread, limit = inf, "duration"
    else:
        radius = contact.radius
        time, peclet = diffusivity * contact.duration / radius**2, speed * radius / diffusivity
        length = radius * mean_rise(time, peclet, contact.track_radius / radius)
        spread, limit = radius**2 / max(1.0, peclet), "contact_radius"  # a²/D or a/v passes
    if diffusivity * contact.duration < spread:
        spread, limit = diffusivity * contact.duration, "duration"
    return length + (steady_rise(layers, spread, limit) if layers is not None else 0.0)


class _Flux(TypedDict, total=False):
    heat_flux: Required[float | Callable[[float], float]]
    conductivity: Required[float]
    diffusivity: Required[float]
    breaks: Sequence[float]
    skin: Skin | None
    heat_depth: float
    contact_radius: float | None
    track_radius: float | None


class _OfTime(Protocol):
    @overload
    def __call__(self, t: float, *, speed: float = 0.0, **flux: Unpack[_Flux]) -> float: ...
    @overload
    def __call__(self, t: Several, *, speed: ArrayLike = 0.0, **flux: Unpack[_Flux]) -> Array: ...
    @overload
    def __call__(
        self, t: ArrayLike, *, speed: ArrayLike = 0.0, **flux: Unpack[_Flux]
    ) -> Array | float: ...


_of_time: Callable[[Callable[..., Array | float]], _OfTime] = itself


@_of_time
def temperature(
    t: ArrayLike,
    *,
    heat_flux: float | Callable[[float], float],
    conductivity: float,
    diffusivity: float,
    breaks: Sequence[float] = (),
    skin: Skin | None = None,
    heat_depth: float = 0.0,
    contact_radius: float | None = None,
    speed: ArrayLike = 0.0,
    track_radius: float | None = None,
) -> Array | float:
    """Background surface temperature after a uniform heat flux for the time `t`. End of Sec. 4.

    Of endless planes T₀(t) = (1/κ) √(D/π) ∫₀ᵗ q̇(t′) (t − t′)^(−1/2) dt′, and (2 q̇/κ) √(Dt/π) for a constant flux, with
    q̇ = s μ σ₀ v the share of the frictional power that enters the body. Under a disc of radius a, the mean over the
    disc is (q̇a/κ) U(Dt/a², va/D): `theory.disc`.

    Parameters
    ----------
    t : array_like
        Time since sliding began, s, ≥ 0, any shape; inf is steady, of a round contact.
    heat_flux : float or callable
        q̇ into the body, W/m²: one number > 0, or, of planes, q̇(t′) of one time in s, finite and of either sign.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s, of the body.
    breaks : sequence of float
        Times of the jumps and kinks of a callable q̇, s.
    skin : three floats, optional
        A layer on the body: thickness d, m, conductivity κ_s, W/(m K), and diffusivity D_s, m²/s. It raises T₀ by
        (q̇d/κ_s)(1 − κ_s²D/κ²D_s) once t ≫ d²/D_s and d²/D; for a constant flux.
    heat_depth : float
        Depth h, m, ≥ 0, in which the heat is released, with the density q̇ e^(−z/h)/h: without a skin it lowers T₀ by
        q̇h/κ once t ≫ h²/D; for a constant flux.
    contact_radius : float, optional
        a of a round contact, m; None is an endless plane.
    speed : array_like
        v, m/s, of either sign, of the contact over this body, broadcast with `t`; 0 on the body that carries it.
    track_radius : float, optional
        Of the ring on which the contact moves, m, ≥ a; it comes back to its own heat. None is straight.

    Returns
    -------
    ndarray or float
        K above the start, the shape of `t` and `speed`; a float for one of each. Of a disc to 1e-8.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or a time or a radius is too short for a skin or a
        depth, or for the track.
    theory.quadrature.QuadratureError
        If the integral over q̇(t′) does not reach its accuracy, 1e-10: name its breaks. Or that of a disc.
    """
    contact = nominal_contact(None, contact_radius, track_radius)
    time = _times(t, steady=contact_radius is not None)
    body = body_of(conductivity, diffusivity, skin, heat_depth)
    if not callable(heat_flux):
        flux = positive("heat_flux", heat_flux, "W/m²")
        ends, speeds = np.broadcast_arrays(time, np.abs(real_array("speed", speed, "m/s")))
        lengths = [
            heat_length(body, contact._replace(duration=end), velocity)
            for end, velocity in zip(ends.ravel().tolist(), speeds.ravel().tolist(), strict=True)
        ]
        return float_if_scalar(flux / body.conductivity * np.reshape(lengths, ends.shape))
    if body.layers is not None or contact != ENDLESS:
        raise ValueError(
            "skin, heat_depth and contact_radius go with a constant heat_flux; give one number in W/m²"
        )
    turns = not_negative_array("breaks", np.asarray(breaks, dtype=np.float64), "s")
    several = [_accumulated(heat_flux, end, turns) for end in time.ravel().tolist()]
    half = np.reshape(several, time.shape)
    return float_if_scalar(2 / body.conductivity * sqrt(body.diffusivity / pi) * half)


def _times(t: ArrayLike, steady: bool) -> Array:
    """Return times ≥ 0, inf too if there is a steady state."""
    times = np.asarray(t)
    endless = (times == inf) & steady
    checked = not_negative_array("t", np.where(endless, 0.0, times) if endless.any() else t, "s")
    return np.where(endless, inf, checked)


def _accumulated(heat_flux: Callable[[float], float], end: float, breaks: Array) -> float:
    """Return ∫₀^√t q̇(t − u²) du: half the integral over t′, without its singularity."""
    from scipy.integrate import quad  # loads transforms, which constant heat does without

    inner = np.sqrt(end - breaks[(breaks > 0.0) & (breaks < end)])
    edges = np.unique([0.0, *inner, sqrt(end)])

    def flux(u: float) -> float:
        return float(real_array("heat_flux", heat_flux(end - u * u), "W/m²"))

    pieces = [
        quad(flux, low, high, epsabs=0.0, epsrel=_ACCURACY / 10, limit=500, full_output=1)
        for low, high in pairwise(edges)
    ]
    parts, errors = np.reshape([piece[:2] for piece in pieces], (-1, 2)).T
    error, scale = errors.sum(), np.abs(parts).sum()
    if not error <= max(_ACCURACY * scale, np.finfo(float).tiny):
        raise QuadratureError(
            f"the background at t = {end:.6g} s has the relative error {error / scale:.1e}, above {_ACCURACY:.0e}; "
            "name the breaks of q̇(t)"
        )
    return float(parts.sum())
