"""Temperatures of faces with a lay in each direction of sliding, by a theory of the stress in the stretched frame."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

import theory
from roughsim.grid import Array
from roughsim.surface.spectrum import Spectrum
from theory.lay_waves import Weighted
from theory.slope_frame import ISOTROPIC, Directions

_RATIOS = {  # √ or not of −T over another moment
    "flash_width": ("flash_laplacian", 0.5),
    "slope_length": ("flash_gradient", 1.0),
}


@dataclass(frozen=True)
class _WeightedStress:
    """|σ_q′|² of the theory, Pa² m², at q′, rad/m: of isotropic contact in the stretched frame."""

    spectrum: Spectrum
    effective_modulus: float  # in that frame
    nominal_pressure: float
    gamma: float

    @property
    def breaks(self) -> tuple[float, ...]:
        """Wavenumbers at which it begins, has kinks, and ends."""
        return tuple(self.spectrum.breaks)

    def weight(self, q: Array) -> Array:
        """Return W at q′, rad/m."""
        load = {"nominal_pressure": self.nominal_pressure, "gamma": self.gamma}
        return theory.persson.stress_weight(
            q, self.spectrum, effective_modulus=self.effective_modulus, **load
        )

    def __call__(self, q: Array) -> Array:
        square = (0.5 * self.effective_modulus * q) ** 2
        return np.asarray(square * self.spectrum(q) * self.weight(q))


@dataclass(frozen=True)
class StressOfTheory:
    """The stress of a face with a lay by the theory, of C(q): all of it is in proportion to |q|, as in full contact."""

    stress_spectrum: Any  # |σ_q′|² in the stretched frame, Pa² m²
    lay: float  # γ
    directions: Directions = ISOTROPIC  # M(q′, φ)
    angle: float = 0.0  # of the grooves, radians

    @classmethod
    def of(cls, lay: float, spectrum: Spectrum, **stress_arguments: float) -> Self:
        """Return the stress of C(q′), with E* in the stretched frame, σ₀ and γ of the theory."""
        return cls(_WeightedStress(spectrum, **stress_arguments), lay)

    def own_share(self, q: Array) -> Array:
        """Return 1: all of the stress is of waves at their own wavenumbers, q, rad/m."""
        return np.ones_like(q)

    def response(self, q: Array, ratio: Array) -> Array:
        """Return the `ratio` of the true wavenumber to `q`, rad/m, at any of these."""
        return np.broadcast_to(ratio, np.broadcast_shapes(q.shape, ratio.shape))


def in_directions(
    names: tuple[str, ...], speeds: Array, headings: Array, stress: Weighted, **heat: Any
) -> dict[str, Array]:
    """Return T_flash, T′, ∇²T, D_flash and d_flash by these names, each at a speed, m/s, in a direction, rad.

    `heat` are the arguments of `theory.flash.flash_temperature` on the load, the heat and the body.
    """
    moments = {"flash_temperature"} if {*names} & {*_RATIOS} else set()
    moments |= {_RATIOS.get(name, (name,))[0] for name in names}
    found = {
        name: np.asarray(getattr(theory.lay, name)(speeds, headings, stress, **heat))
        for name in moments
    }
    with np.errstate(all="ignore"):  # 0/0 at rest
        for name, (below, power) in _RATIOS.items():
            if name in names:
                found[name] = (-found["flash_temperature"] / found[below]) ** power
    return {name: found[name] for name in names}
