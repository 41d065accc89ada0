"""The heat of one step, shared between two bodies so that their temperatures agree at every point of the contact.

With what is left of earlier heat known, the flux x into the second body obeys

    (R₁ + R₂) x = K₁ − K₂ + R₁ q̇    on the contact,    x = 0 elsewhere,

R the responses to the flux of the step and K the temperatures without it. R₁ + R₂ is real and positive: conjugate
gradients. The preconditioner is its inverse on the whole plane, restricted to the contact.
"""

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim.errors import ConvergenceError
from roughsim.grid import Array

TOLERANCE = 1e-6  # ‖T₁ − T₂‖ over ‖T₁ + T₂‖ on the contact
_LIMIT = 200  # iterations: 2 to 10 are usual


def equalize(
    contact: NDArray[np.bool_], right: Array, response: Array, start: Array, scale: float
) -> tuple[Array, float, int]:
    """Return the flux at the points of the contact, the residual, and the iterations.

    Parameters
    ----------
    contact : ndarray of bool
        Where the bodies touch.
    right : ndarray
        The right side at the points of the contact, K.
    response : ndarray
        R₁ + R₂ of each mode, shape `grid.half_shape`, K m²/W.
    start : ndarray
        A first guess of the flux at the points of the contact, W/m².
    scale : float
        Norm of the temperatures at the points of the contact, K: the residual is relative to it.

    ConvergenceError if the residual does not come below `TOLERANCE`.
    """
    field = np.zeros(contact.shape)

    def between(values: Array, factor: Array) -> Array:
        field[contact] = values
        result: Array = fourier.inverse(fourier.forward(field) * factor, contact.shape)[contact]
        return result

    inverse = 1 / response
    flux = start.copy()
    jump = right - between(flux, response)
    direction, power = np.zeros_like(flux), 1.0
    for iteration in range(_LIMIT + 1):
        residual = float(np.linalg.norm(jump)) / scale
        if residual <= TOLERANCE:
            return flux, residual, iteration
        steepest = between(jump, inverse)
        last, power = power, float(jump @ steepest)
        direction = steepest + (power / last if iteration else 0.0) * direction
        change = between(direction, response)
        length = power / float(direction @ change)
        flux += length * direction
        jump -= length * change
    raise ConvergenceError(
        f"temperatures of the two bodies: they differ by {residual:.3g} of their norm on the contact after {_LIMIT} "
        f"iterations, {TOLERANCE:g} is allowed; take more steps or a finer grid",
        residual,
        _LIMIT,
    )
