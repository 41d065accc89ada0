"""A spectrum of two powers, written out for the tests alone."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PowerLaw:
    """C = psd (q/kink)^(−low) up to the kink, psd (q/kink)^(−2−2H) beyond."""

    psd: float
    q: tuple[float, float, float]
    hurst: float
    low: float = 0.0

    @property
    def breaks(self):
        return self.q

    def __call__(self, q):
        x = q / self.q[1]
        return self.psd * np.where(x <= 1.0, x**-self.low, x ** (-2 - 2 * self.hurst))

    def cube(self, q):
        """∫ q³ C dq from q_min in closed form (q ≤ kink)."""
        n = 4 - self.low
        return self.psd * self.q[1] ** self.low * (q**n - self.q[0] ** n) / n


@dataclass(frozen=True)
class Flat:
    """A constant density over a band."""

    value: float
    breaks: tuple[float, ...]

    def __call__(self, q):
        return np.full_like(q, self.value)
