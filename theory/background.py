"""Background temperature: the uniform part (q = 0) of the frictional heat, which grows with the time of sliding."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import pi, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from theory.arguments import Array, float_if_scalar, not_negative_array, positive, real_array
from theory.quadrature import QuadratureError
from theory.skin import Skin, body_of, steady_rise

_ACCURACY = 1e-10


def temperature(
    t: ArrayLike,
    *,
    heat_flux: float | Callable[[float], float],
    conductivity: float,
    diffusivity: float,
    breaks: Sequence[float] = (),
    skin: Skin | None = None,
    heat_depth: float = 0.0,
) -> Array | float:
    """Background surface temperature after a uniform heat flux for the time `t`. End of Sec. 4.

    T₀(t) = (1/κ) √(D/π) ∫₀ᵗ q̇(t′) (t − t′)^(−1/2) dt′, and (2 q̇/κ) √(Dt/π) for a constant flux, with q̇ = s μ σ₀ v the
    share of the frictional power that enters the body.

    Parameters
    ----------
    t : array_like
        Time since sliding began, s, ≥ 0, any shape.
    heat_flux : float or callable
        q̇ into the body, W/m²: one number > 0, or q̇(t′) of one time in s, finite and of either sign.
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

    Returns
    -------
    ndarray or float
        K above the start, the shape of `t`; a float for one time.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or a time is too short for a skin or a depth.
    theory.quadrature.QuadratureError
        If the integral over q̇(t′) does not reach its accuracy, 1e-10: name its breaks.
    """
    time = not_negative_array("t", t, "s")
    kappa, diffusion, layers = body_of(conductivity, diffusivity, skin, heat_depth)
    if callable(heat_flux):
        if layers is not None:
            raise ValueError(
                "skin and heat_depth go with a constant heat_flux; give one number in W/m²"
            )
        turns = not_negative_array("breaks", np.asarray(breaks, dtype=np.float64), "s")
        several = [_accumulated(heat_flux, end, turns) for end in time.ravel().tolist()]
        half = np.array(several).reshape(time.shape)
    else:
        half = positive("heat_flux", heat_flux, "W/m²") * np.sqrt(time)
    rise = 2 / kappa * sqrt(diffusion / pi) * half
    if layers is not None and time.size:
        flux = positive("heat_flux", heat_flux, "W/m²")
        rise = rise + flux / kappa * steady_rise(layers, diffusion * float(time.min()))
    return float_if_scalar(rise)


def _accumulated(heat_flux: Callable[[float], float], end: float, breaks: Array) -> float:
    """Return ∫₀^√t q̇(t − u²) du: half the integral over t′, without its singularity."""
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
