"""What a camera sees of two sliding bodies: the mean of the surface of the moving one over the end of a slide.

Beside it stand the same numbers of frozen contact, by the stress of the same slide.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roughsim import fourier
from roughsim.contact import Contact
from roughsim.grid import Array, Complex, Grid
from roughsim.heat.camera import Lens
from roughsim.observables.camera import (
    EXCEEDED,
    Camera,
    distances,
    hottest_of,
    seen_rms,
    seen_width,
    widths,
)
from roughsim.observables.moments import HeatSource
from roughsim.observables.record import Sample
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.sliding.correlation import mean_product
from roughsim.sliding.path import Path, slope
from roughsim.sliding.stepping import phases

if TYPE_CHECKING:  # no circle
    from roughsim.sliding.stepping import Step

_SHORT = 1e-6  # steps: a shorter exposure is none


class Shutter(NamedTuple):
    """A camera, and the end of a slide during which its shutter is open."""

    camera: Camera  # as it sees frozen contact
    exposures: tuple[float, ...]  # distance slid with an open shutter at each speed, m
    on_body: bool  # whether it moves with the moving body, or rests


class Pictures:
    """Adds up the surface temperature of the moving body over an exposure, which ends with the slide at each speed.

    `ends` are the last steps at each speed.
    """

    def __init__(self, grid: Grid, path: Path, ends: list[int], shutter: Shutter) -> None:
        self.grid = grid
        self.path = path
        self.ends = ends
        self.shutter = shutter
        self.weights = [
            exposed(length / path.distance[1], end)
            for length, end in zip(shutter.exposures, ends, strict=True)
        ]
        self.spectra: list[Complex] = [np.zeros(grid.half_shape, complex) for _ in ends]

    def add(self, n: int, step: "Step") -> None:
        """Take step n into the pictures of the speeds whose shutter is open."""
        for k, temperature in enumerate(step.temperatures):
            before = self.ends[k] - n
            if temperature is None or not 0 <= before < self.weights[k].size:
                continue
            seen = self.weights[k][before] * temperature
            if self.shutter.on_body:
                seen *= phases(self.grid, self.path.offsets[n]).conj()
            self.spectra[k] += seen

    def numbers(
        self, spectrum: StressSpectrum, contact: Contact, sliding: HeatSource
    ) -> dict[str, Array]:
        """Return rms, hottest part and width of the pictures, and of frozen contact, (speeds,), by their stored names.

        `spectrum` is the mean over the slide and `contact` the last one. NaN where the exposure exceeds the slide.
        """
        camera = self.shutter.camera
        seen = [
            self._seen(picture, source.lens or Lens()) if weights.size else (np.nan,) * 3
            for picture, weights, source in zip(
                self.spectra, self.weights, camera.sources, strict=True
            )
        ]
        rms, hottest, width = np.array(seen).T
        q = spectrum.wavenumber
        variance = spectrum.variance[None]
        sample = Sample(np.inf, 0.0, np.zeros(1, np.intp), {}, q, variance, spectrum.reach)
        return {
            "sliding_seen_rms": rms,
            "sliding_seen_99": hottest,
            "sliding_seen_width": width,
            "sliding_frozen_seen_rms": seen_rms(sample, camera)[0],
            "sliding_frozen_seen_99": hottest_of(
                contact.pressure, self.grid, spectrum, sliding, camera
            ),
            "sliding_frozen_seen_width": seen_width(sample, camera)[0],
        }

    def _seen(self, temperature: Complex, lens: Lens) -> tuple[float, float, float]:
        """Return rms, K, what `EXCEEDED` of the picture exceeds, K, and the width across sliding, m."""
        grid = self.grid
        qx, qy = grid.wavevectors
        seen = temperature * lens.blur(qx**2 + qy**2)
        seen[0, 0] = 0.0
        hottest = np.quantile(fourier.inverse(seen, grid.shape), 1.0 - EXCEEDED)
        power = (seen.real**2 + seen.imag**2) * grid.multiplicity
        across = (qy - slope(grid) * qx) / np.hypot(1.0, slope(grid))
        y = distances(0.5 * float(np.hypot(*grid.lengths)))
        correlation = [np.sum(power * np.cos(across * one)) for one in y]
        width = float(widths(np.array(correlation)[None], y)[0])
        return mean_product(grid, seen, seen) ** 0.5, float(hottest), width


def exposed(steps: float, end: int) -> Array:
    """Return the weights of the last steps, the latest first, in a mean over so many; none if they exceed the slide.

    The temperature is linear from one step to the next, and zero at step 0.
    """
    if steps > end * (1 + _SHORT):
        return np.empty(0)
    length = max(steps, _SHORT)
    at = np.clip(length - np.arange(int(length) + 2.0), -1.0, 1.0)
    # ∫ of a hat of the base [−1, 1] up to `at`; of the first one half is later than the end
    integral = 0.5 + at - 0.5 * at * np.abs(at)
    integral[0] -= 0.5
    return integral / length
