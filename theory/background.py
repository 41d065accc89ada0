"""Background temperature: the uniform part (q = 0) of the frictional heat, which grows with the time of sliding."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, not_negative_array, positive


def temperature(t: ArrayLike, *, heat_flux: float, conductivity: float, diffusivity: float) -> Array | float:
    """Background surface temperature after a uniform constant heat flux for the time `t`. End of Sec. 4.

    T₀(t) = (2 q̇/κ) √(Dt/π), with q̇ = s μ σ₀ v the share of the frictional power that enters the body.

    Parameters
    ----------
    t : array_like
        Time since sliding began, s, ≥ 0, any shape.
    heat_flux : float
        q̇ into the body, W/m², > 0.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s, of the body.

    Returns
    -------
    ndarray or float
        K above the start, the shape of `t`; a float for one time.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign.
    """
    time = not_negative_array("t", t, "s")
    flux = positive("heat_flux", heat_flux, "W/m²")
    kappa, diffusion = positive("conductivity", conductivity, "W/(m K)"), positive("diffusivity", diffusivity, "m²/s")
    rise = 2 * flux / kappa * np.sqrt(diffusion * time / pi)
    return float(rise) if time.ndim == 0 else np.asarray(rise)
