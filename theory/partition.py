"""Share of the frictional heat that enters the moving body, by the paper's rule or with the background."""

from math import pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from theory.arguments import Array, SpectrumLike, float_if_scalar, positive, real_array
from theory.flash import EVEN, bracket
from theory.persson import StressDensity, Weight, stress_density
from theory.skin import Skin, ThermalBody, body_of, steady_rise, surface_response


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
) -> Array | float:
    """Share s of the frictional heat that enters the moving body.

    "mean", the paper's rule (Sec. 4): s T_mov = (1 − s) T_stat, so s = T_stat/(T_stat + T_mov). Each is taken with all
    the heat; T_stat has v = 0 in the integral of Eq. (4), since the resting body is heated always at the same place.

    "total": equal total temperatures after sliding for `duration` t, s (τ_mov + T_mov) = (1 − s)(τ_stat + T_stat(t)).
    τ = (2μσ₀v/κ) √(Dt/π) is the background of each body, and T_stat(t) has the factor erf(q√(Dt)) of a source that was
    switched on at t = 0. Both bodies start at the same temperature.

    μ and the factor v cancel in both rules. At rest s is the limit v → 0, 1/2 for equal bodies.

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
        Time since sliding began, s, for "total"; "mean" is steady and takes none.
    skin, resting_skin : three floats, optional
        A layer on each body: thickness, m, conductivity, W/(m K), and diffusivity, m²/s, such as a `roughsim.Skin`. The
        rule "total" takes its steady change, which holds for durations well above d²/D_s.
    heat_depth, resting_heat_depth : float
        Depth h, m, in which the heat is released in each body, with the density q̇ e^(−z/h)/h; 0 is the surface.

    Returns
    -------
    ndarray or float
        s between 0 and 1, the shape of `speed`; a float for one speed.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or `rule` and `duration` do not fit each other.
    """
    velocity = real_array("speed", speed, "m/s")
    time = _sliding_time(rule, duration)
    moving = body_of(conductivity, diffusivity, skin, heat_depth)
    still = body_of(
        resting_conductivity, resting_diffusivity, resting_skin, resting_heat_depth, like=moving
    )
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, pressure, gamma)
    hot = bracket(velocity, moving, stress, EVEN, -1) + _background(moving, pressure, time)
    cold = _resting_bracket(stress, still, time) + _background(still, pressure, time)
    rise, still_rise = hot / moving.conductivity, cold / still.conductivity
    return float_if_scalar(still_rise / (still_rise + rise))


def _sliding_time(rule: str, duration: float | None) -> float | None:
    if rule == "total":
        return positive("duration", duration, "s")
    if rule != "mean":
        raise ValueError(f'rule = {rule!r} must be "mean" or "total"')
    if duration is not None:
        raise ValueError(
            f'duration = {duration!r} s does not enter the steady rule "mean"; leave it out or use "total"'
        )
    return None


def _background(body: ThermalBody, pressure: float, time: float | None) -> float:
    """Return σ₀ κ T₀(t)/μv, Pa² m; 0 in the rule without background."""
    if time is None:
        return 0.0
    spread = body.diffusivity * time
    bare = float(2 * pressure**2 * np.sqrt(spread / pi))
    return bare + pressure**2 * (steady_rise(body.layers, spread) if body.layers else 0.0)


def _resting_bracket(stress: StressDensity, body: ThermalBody, time: float | None) -> float:
    """Return the integral of Eq. (4) at v = 0, Pa² m, steady or `time` after the heat was switched on."""
    q = stress.wavenumber()
    grown = np.ones_like(q)
    if time is not None:
        grown = erf(q * np.sqrt(body.diffusivity * time))
    if body.layers is not None:
        grown += surface_response(q, np.zeros_like(q), body.layers).real - 1.0
    return float((stress.weighted() / q * grown).sum())
