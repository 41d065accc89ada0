"""A camera that looks at the heated surface: a factor on the waves of its temperature.

Point spread, a Gaussian with the full width w at half maximum: e^(−q²b²/2), b = w/√(8 ln 2). Exposure, during which
the contact moves by l past the camera: sin(q_xl/2)/(q_xl/2), x along sliding. On a line at the distance d behind the
straight trailing edge of a contact of length ℓ heat came in during the ages d/v to (d + ℓ)/v, and for vd/D ≫ 1

    κ T/q̇ = [erfc√(sd) − erfc√(s(d + ℓ))]/√(sv/D),    s = q_y²D/v − iq_x,

blurred across sliding only.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import erfcx

from roughsim.grid import Array, Complex, Field

_FWHM = math.sqrt(8.0 * math.log(2.0))  # of a Gaussian, over its standard deviation
_FAINT = 40.0  # e^(−40) is nothing


class Lens(NamedTuple):
    """What a camera looks at, and how sharply."""

    resolution: float = 0.0  # full width at half maximum of the point spread, m
    smear: float = 0.0  # distance that the contact moves past the camera during the exposure, m
    behind: float | None = None  # distance of a line behind the contact, m; None: the contact
    contact_length: float = math.inf  # of the contact before that line, m

    def seen(self, square: Field, advection: Field, rate: float, response: Complex) -> Complex:
        """Return κT/q̇, m, of waves as the camera sees it; `response` is that of the contact itself.

        q² = `square` and q·v/D = `advection`, 1/m², and v/D = `rate` > 0, 1/m.
        """
        along = advection / rate
        if self.behind is None:
            phase = along * (self.smear / (2.0 * math.pi))
            return response * self.blur(square) * np.sinc(phase)
        across = np.maximum(square - along**2, 0.0)
        decay: Complex = across / rate - 1j * along
        decay[decay == 0.0] = 1.0  # q = 0 alone: replaced by the caller
        heated = _erfc_root(decay * self.behind)
        if self.contact_length < math.inf:
            heated = heated - _erfc_root(decay * (self.behind + self.contact_length))
        return heated * self.blur(across) / np.sqrt(decay * rate)

    def blur(self, square: Field) -> Array:
        """Return the factor of the point spread on waves with q² = `square`, 1/m²."""
        return np.exp(-0.5 * square * (self.resolution / _FWHM) ** 2)


def _erfc_root(square: Complex) -> Complex:
    """Return erfc √s of s with Re s ≥ 0."""
    result = np.zeros_like(square)
    seen = square.real < _FAINT
    result[seen] = np.exp(-square[seen]) * erfcx(np.sqrt(square[seen]))
    return result
