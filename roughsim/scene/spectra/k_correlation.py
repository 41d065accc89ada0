"""The k-correlation spectrum, which rolls off smoothly: C(q) ∝ (1 + (q/q_r)²)^(−1−H) between its ends.

Palasantzas, Phys. Rev. B 48, 14472 (1993).
"""

from math import exp, expm1, log1p, pi
from typing import Any, Literal, Self

import numpy as np
from pydantic import model_validator

from roughsim.scene.schema import Hurst, QMax, QMin, QRollOff, Record, RmsHeight, record


@record()
class Spectrum(Record):
    """C(q) of a face, m⁴."""

    name: Literal["k_correlation"]
    rms_height: RmsHeight
    """√⟨h²⟩ between the ends."""
    hurst: Hurst
    q_min: QMin
    q_roll_off: QRollOff
    """Transition from the plateau to q^(−2−2H)."""
    q_max: QMax

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.q_min >= self.q_max:
            raise ValueError(
                f"q_min = {self.q_min:.6g} rad/m must be below q_max = {self.q_max:.6g} rad/m; change one of the two"
            )
        return self

    @property
    def breaks(self) -> tuple[float, float]:
        """The two ends, rad/m."""
        return self.q_min, self.q_max

    def __call__(self, q: Any) -> Any:
        """Return C(q), m⁴, between the ends."""
        # ∫ (1 + x)^(−1−H) dx between the ends, x = (q/q_r)²
        low, high = (log1p((end / self.q_roll_off) ** 2) for end in self.breaks)
        span = high - low
        share = exp(-self.hurst * low) * (
            -expm1(-self.hurst * span) / self.hurst if self.hurst else span
        )
        plateau = self.rms_height**2 / (pi * self.q_roll_off**2 * share)
        return plateau * (1.0 + (np.asarray(q) / self.q_roll_off) ** 2) ** (-1.0 - self.hurst)
