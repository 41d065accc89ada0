"""Share of the frictional heat that enters the moving body, by the paper's rule or with the background."""

from collections.abc import Callable
from math import inf
from typing import Protocol, Required, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from theory.arguments import (
    Array,
    Several,
    SpectrumLike,
    float_if_scalar,
    itself,
    positive,
    real_array,
)
from theory.background import NominalContact, heat_length, nominal_contact
from theory.flash import EVEN, bracket
from theory.persson import StressDensity, Weight, stress_density
from theory.skin import Skin, ThermalBody, body_of, surface_response


class _Load(TypedDict, total=False):
    nominal_pressure: Required[float]
    conductivity: Required[float]
    diffusivity: Required[float]
    resting_conductivity: float | None
    resting_diffusivity: float | None
    effective_modulus: float | None
    gamma: Weight
    stress_spectrum: SpectrumLike | None
    rule: str
    duration: float | None
    skin: Skin | None
    heat_depth: float
    resting_skin: Skin | None
    resting_heat_depth: float
    contact_radius: float | None
    track_radius: float | None
    temperature_difference: float
    friction_coefficient: float | None


class _OfSpeed(Protocol):
    @overload
    def __call__(
        self, speed: float, spectrum: SpectrumLike | None = None, **load: Unpack[_Load]
    ) -> float: ...
    @overload
    def __call__(
        self, speed: Several, spectrum: SpectrumLike | None = None, **load: Unpack[_Load]
    ) -> Array: ...
    @overload
    def __call__(
        self, speed: ArrayLike, spectrum: SpectrumLike | None = None, **load: Unpack[_Load]
    ) -> Array | float: ...


_of_speed: Callable[[Callable[..., Array | float]], _OfSpeed] = itself


@_of_speed
def moving_share(  # noqa: PLR0913  (two bodies: each has its own two numbers)
    speed: ArrayLike,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float,
    conductivity: float,
    diffusivity: float,
    resting_conductivity: float | None = None,
    resting_diffusivity: float | None = None,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
    rule: str = "mean",
    duration: float | None = None,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
    resting_skin: Skin | None = None,
    resting_heat_depth: float = 0.0,
    contact_radius: float | None = None,
    track_radius: float | None = None,
    temperature_difference: float = 0.0,
    friction_coefficient: float | None = None,
) -> Array | float:
    """Share s of the frictional heat that enters the moving body.

    "mean", the paper's rule (Sec. 4): s T_mov = (1 − s) T_stat, so s = T_stat/(T_stat + T_mov). Each is taken with all
    the heat; T_stat has v = 0 in the integral of Eq. (4), since the resting body is heated always at the same place.

    "total": equal total temperatures after sliding for `duration` t, s (τ_mov + T_mov) = (1 − s)(τ_stat + T_stat(t)) +
    ΔT. τ is the background of each body with all the heat, (2μσ₀v/κ) √(Dt/π) of endless planes. The disc of a
    `contact_radius` rests on the resting body and slides over the moving one: τ as `theory.background.temperature` has
    it, which may be steady. T_stat(t) has the factor erf(q√(Dt)) of a source that was switched on at t = 0. ΔT is how
    much hotter the resting body was before.

    μ and the factor v cancel in both rules, but for ΔT. At rest s is the limit v → 0, 1/2 for equal bodies.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign and any shape.
    spectrum, nominal_pressure, effective_modulus, gamma, stress_spectrum
        As in `theory.flash.flash_temperature`.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s, of the moving body.
    resting_conductivity, resting_diffusivity : float, optional
        The same of the resting body; None: as the moving one.
    rule : {"mean", "total"}
        Equal T_flash of both bodies, steady; or equal T_flash + T₀ at the time `duration`.
    duration : float, optional
        Time since sliding began, s, for "total", which is steady without one; planes need it. "mean" takes none.
    skin, resting_skin : three floats, optional
        A layer on each body: thickness, m, conductivity, W/(m K), and diffusivity, m²/s, such as a `roughsim.Skin`. The
        rule "total" takes its steady change, which holds for durations well above d²/D_s.
    heat_depth, resting_heat_depth : float
        Depth h, m, in which the heat is released in each body, with the density q̇ e^(−z/h)/h; 0 is the surface.
    contact_radius, track_radius : float, optional
        Of the nominal contact and of the ring on which it slides over the moving body, m, for "total"; None is endless.
    temperature_difference, friction_coefficient : float
        ΔT, K, of either sign, for "total"; and μ, needed if it is not 0.

    Returns
    -------
    ndarray or float
        s between 0 and 1, but for ΔT, the shape of `speed`; a float for one speed.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or does not fit `rule`; for ΔT at rest, which has no
        heat to share.
    """
    velocity = real_array("speed", speed, "m/s")
    contact = nominal_contact(duration, contact_radius, track_radius)
    _check_rule(rule, contact, temperature_difference)
    moving = body_of(conductivity, diffusivity, skin, heat_depth)
    still = body_of(
        resting_conductivity, resting_diffusivity, resting_skin, resting_heat_depth, like=moving
    )
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, pressure, gamma)
    # of each body σ₀κT/μv, Pa² m, with all the heat in it
    hot = bracket(velocity, moving, stress, EVEN, -1)
    cold = _resting_bracket(stress, still, contact.duration)
    if rule == "total":
        lengths = [heat_length(moving, contact, abs(each)) for each in velocity.ravel().tolist()]
        hot = hot + pressure**2 * np.reshape(lengths, velocity.shape)
        cold = cold + pressure**2 * heat_length(still, contact)
    rise, still_rise = hot / moving.conductivity, cold / still.conductivity
    share = still_rise / (still_rise + rise)
    if temperature_difference:
        if not velocity.all():
            raise ValueError(
                "speed = 0 m/s makes no heat that a temperature_difference could be weighed against; leave one out"
            )
        heat = positive("friction_coefficient", friction_coefficient, "1") * np.abs(velocity)
        hotter = real_array("temperature_difference", temperature_difference, "K")
        share = share + hotter * pressure / heat / (still_rise + rise)
    return float_if_scalar(share)


def _check_rule(rule: str, contact: NominalContact, temperature_difference: float) -> None:
    """Refuse a rule of another name, and numbers that do not enter it."""
    if rule not in ("mean", "total"):
        raise ValueError(f'rule = {rule!r} must be "mean" or "total"')
    given = contact._asdict() | {"temperature_difference": temperature_difference or inf}
    extra = [f"{name} = {value:g}" for name, value in given.items() if value != inf]
    if rule == "mean" and extra:
        raise ValueError(
            f'{extra[0]} does not enter the steady rule "mean"; leave it out or use "total"'
        )


def _resting_bracket(stress: StressDensity, body: ThermalBody, time: float) -> float:
    """Return the integral of Eq. (4) at v = 0, Pa² m, a `time` after the heat was switched on; inf is steady."""
    q = stress.wavenumber()
    grown = erf(q * np.sqrt(body.diffusivity * time))
    if body.layers is not None:
        grown += surface_response(q, np.zeros_like(q), body.layers).real - 1.0
    return float((stress.weighted() / q * grown).sum())
