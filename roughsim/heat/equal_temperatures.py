"""The heat of one step, shared between two bodies so that their temperatures agree at every point of the contact.

With the temperature left by earlier heat given, the flux x into the second body obeys

    (R₁ + R₂) x = K₁ − K₂ + R₁ q̇    on the contact,    x = 0 elsewhere,

R the responses to the flux of the step and K the temperatures without it. R₁ + R₂ is real and positive: conjugate
gradients. The preconditioner is its inverse on the whole plane, restricted to the contact.
"""

import numpy as np

from roughsim import fourier
from roughsim.errors import ConvergenceError
from roughsim.grid import Array, Field, Mask

_FLAT = 4.0  # ratio of the largest to the smallest response up to which no preconditioner is worth its transforms
_LIMIT = 200  # iterations: 2 to 10 are usual


def equalize(contact: Mask, jump: Array, response: Array, limit: float) -> Array:
    """Return the change of flux at the points of the contact that closes a jump of temperature there, W/m².

    Parameters
    ----------
    contact : ndarray of bool
        Mask of the contact.
    jump : ndarray
        Temperature of the first body minus the second, at the points of the contact, K.
    response : ndarray
        R₁ + R₂ of each mode, shape `grid.half_shape`, K m²/W.
    limit : float
        Norm of the jump that may be left, K, as far as single precision goes: check it, and go on from there.

    ConvergenceError if it is not reached.
    """
    # in units of the largest jump and response, so that no square leaves single precision
    kelvin = float(np.abs(jump).max()) or 1.0
    unit = float(response.max())
    field = np.zeros(contact.shape, np.float32)
    responses = (response / unit).astype(np.float32)
    inverse = None if response.max() < _FLAT * response.min() else 1 / responses

    def between(values: Array, factor: Field) -> Array:
        field[contact] = values
        result = fourier.inverse(fourier.forward(field) * factor, contact.shape)[contact]
        return result.astype(float)

    flux = np.zeros_like(jump)
    jump = jump / kelvin
    direction = np.zeros_like(flux)
    power = 1.0
    for iteration in range(_LIMIT + 1):
        left = float(np.linalg.norm(jump))
        if left <= limit / kelvin:
            return flux * (kelvin / unit)
        steepest = jump if inverse is None else between(jump, inverse)
        last = power
        power = float(jump @ steepest)
        direction = steepest + (power / last if iteration else 0.0) * direction
        change = between(direction, responses)
        length = power / float(direction @ change)
        flux += length * direction
        jump -= length * change
    raise ConvergenceError(
        f"temperatures of the two bodies: the norm of their difference is {left * kelvin:.3g} K after {_LIMIT} "
        f"iterations, {limit:.3g} K is allowed; take more steps or a finer grid",
        left * kelvin / limit,
        _LIMIT,
    )
