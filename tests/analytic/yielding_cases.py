"""Spectra and the law that tests of contact that yields share."""

import dataclasses

import numpy as np

from theory.yielding import YieldingSpectrum

MODULUS, HARDNESS = 1.1e11, 1.2e9
HEATING = {"friction_coefficient": 1.0, "conductivity": 1.0, "diffusivity": 1.0}


@dataclasses.dataclass(frozen=True)
class SelfAffine:
    """C(q) with a plateau from q_min to q_r = 1e5 1/m."""

    level: float = 2e-26
    hurst: float = 0.8
    q_min: float = 5e4
    q_max: float = 4e7

    @property
    def breaks(self):
        return (self.q_min, 1e5, self.q_max)

    def __call__(self, q):
        return self.level * np.where(
            q < 1e5, 1.0, (np.maximum(q, 1e5) / 1e5) ** (-2 - 2 * self.hurst)
        )


def law(spectrum=None, modulus=MODULUS, pressure=0.1 * HARDNESS, hardness=HARDNESS):
    return YieldingSpectrum(spectrum or SelfAffine(), modulus, pressure, hardness)


@dataclasses.dataclass(frozen=True)
class InUnits:
    """The same spectrum with lengths in another unit."""

    spectrum: SelfAffine
    length: float

    @property
    def breaks(self):
        return tuple(q / self.length for q in self.spectrum.breaks)

    def __call__(self, q):
        return self.spectrum(np.asarray(q) * self.length) * self.length**4


@dataclasses.dataclass(frozen=True)
class Rough:
    """C(q) up to a multiple of q_min = 2π/mm, with a plateau up to q_r."""

    level: float
    hurst: float
    plateau: float  # q_r/q_min
    end: float  # q_max/q_min

    @property
    def breaks(self):
        return tuple(2e3 * np.pi * x for x in (1.0, self.plateau, self.end))

    def __call__(self, q):
        return self.level * np.maximum(q / self.breaks[1], 1.0) ** (-2 - 2 * self.hurst)
