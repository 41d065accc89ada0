"""The surface temperature of a half-space from the history of its heat, step by step, in the frame of the body.

    κ T(q, t) = √(D/π) ∫₀^t q̇(q, t − τ) τ^(−1/2) e^(−D q² τ) dτ

(Carslaw & Jaeger 1959, 2.9 and 10.7). The flux is linear between the steps. The latest step is integrated exactly. For
older heat τ^(−1/2) is a sum of decaying exponentials, so that each mode keeps a few numbers and not its past. The mean,
q = 0, decays too slowly for an error that adds up: it is summed over all steps. A body with a skin, or heated in depth,
has another kernel, `roughsim.heat.layered_history`, and is followed in the same way.
"""

import math
from functools import lru_cache

import numpy as np
import scipy

from roughsim.errors import ConvergenceError
from roughsim.grid import Array, Complex, Grid
from roughsim.heat.layered_history import layered_kernel
from roughsim.heat.skin import Layering

KERNEL_ERROR = 5e-5  # of the sum of exponentials, relative to τ^(−1/2), at all times of the slide
_TERMS = range(4, 40)  # exponentials: 10 to 18 are usual


class History:
    """Memory of one half-space of the heat that has entered it.

    Parameters
    ----------
    grid : Grid
        The periodic cell, at rest in the body.
    conductivity, diffusivity : float
        κ, W/(m K); D, m²/s.
    step : float
        Time between two steps, s.
    steps : int
        Steps of the whole history, at least 1.
    start : ndarray
        Complex of the flux at time 0, W/m², when the body has its initial temperature everywhere.
    layers : Layering, optional
        Its skin, and the depth in which its heat is released.
    """

    def __init__(
        self,
        grid: Grid,
        conductivity: float,
        diffusivity: float,
        step: float,
        steps: int,
        start: Complex,
        layers: Layering | None = None,
    ) -> None:
        qx, qy = grid.wavevectors
        if layers is None:
            decay = diffusivity * step
            late, early = latest_step(decay * qx**2 + decay * qy**2)
            self.rates, shared = exponentials(steps)
            weights = shared[None, None]
            self._mean_weights, self._first_weights = mean_weights(steps)
            self.unit = math.sqrt(diffusivity * step / math.pi) / conductivity  # K m²/W
        else:
            decay, self.rates, weights, late, early, self._mean_weights, self._first_weights = (
                layered_kernel(grid, diffusivity, layers, step, steps)
            )
            self.unit = 1 / conductivity
        self.along = decay * qx[:, 0] ** 2
        self.across = decay * qy[0] ** 2
        # K m²/W, real and positive
        self.response = self.unit * late
        self._previous = self.unit * early
        self.weights = self.unit * weights
        self._memory = np.zeros((*grid.half_shape, 2, self.rates.size))
        self._flux = start
        self._known = self._previous * start
        self._mean_flux = np.zeros(steps + 1)
        self._mean_flux[0] = start[0, 0].real
        self._step = 0

    def known(self) -> Complex:
        """Return the temperature that all earlier heat leaves at the end of the next step, K.

        The flux at that end adds `response` times its spectrum.
        """
        n = self._step + 1
        earlier = self._first_weights[n] * self._mean_flux[0]
        earlier += self._mean_flux[1:n] @ self._mean_weights[n - 1 : 0 : -1]
        self._known[0, 0] = self.unit * earlier
        return self._known

    def advance(self, flux: Complex) -> None:
        """Take the flux at the end of the next step, W/m²; the history then ends there."""
        from roughsim._kernels.history import remember  # not at the top: numba is slow to import

        self._step += 1
        self._mean_flux[self._step] = flux[0, 0].real
        past = self.along, self.across, self.rates, self.weights
        remember(*past, flux, self._flux, self._previous, self._memory, self._known)
        self._flux = flux


def latest_step(decay: Array) -> tuple[Array, Array]:
    """Return ∫₀¹ (1 − u) u^(−1/2) e^(−xu) du and ∫₀¹ u^(1/2) e^(−xu) du for x = `decay`."""
    x = np.maximum(decay, 1e-30)
    whole = math.sqrt(math.pi) * scipy.special.erf(np.sqrt(x)) / np.sqrt(x)
    early = scipy.special.gamma(1.5) * scipy.special.gammainc(1.5, x) / x**1.5
    return whole - early, early


def mean_weights(steps: int) -> tuple[Array, Array]:
    """Return the weights of ∫₀^n u^(−1/2) f(n − u) du for f linear between whole numbers.

    The first array is for f(n − m), m = 0 … `steps`; the second for f(0) with n = 0 … `steps`.
    """
    m = np.arange(steps + 2, dtype=float)
    # second difference of the second integral of u^(−1/2), 4/3 u^(3/2); far from 0 its terms cancel: a series there
    integral = 4 / 3 * m**1.5
    inner = integral[2:] - 2 * integral[1:-1] + integral[:-2]
    far = m[1:-1] > 100
    u = m[1:-1][far]
    inner[far] = u**-0.5 * (1 + 1 / (16 * u**2) + 7 / (384 * u**4))
    first = np.zeros(steps + 1)
    n = m[1 : steps + 1]
    # f falls from 1 at u = n to 0 at u = n − 1
    first[1:] = 2 * np.sqrt(n) - (integral[1 : steps + 1] - integral[:steps])
    far = n > 100
    u = n[far]
    first[1:][far] = u**-0.5 * (1 / 2 + 1 / (12 * u) + 1 / (32 * u**2) + 1 / (64 * u**3))
    return np.concatenate([[4 / 3], inner]), first


@lru_cache(maxsize=8)  # .17 s for both bodies at each speed of each slide
def exponentials(steps: int) -> tuple[Array, Array]:
    """Return rates s and weights w > 0 with Σ w e^(−sτ) = τ^(−1/2) to `KERNEL_ERROR`, for τ from 1 to `steps`.

    Rates in geometric sequence, weights by least squares; ConvergenceError if no sum is good enough.
    """
    # slow to import, and workers that solve single contacts do without
    from scipy.optimize import nnls

    times = np.geomspace(1.0, max(float(steps), 2.0), 2000)
    for terms in _TERMS:
        for lowest, highest in ((0.1, 2.0), (0.2, 3.0), (0.2, 5.0), (0.2, 8.0)):
            rates = np.geomspace(lowest / times[-1], highest, terms)
            values = np.exp(-np.outer(times, rates)) * np.sqrt(times)[:, None]
            weights = nnls(values, np.ones(times.size))[0]
            if np.abs(values @ weights - 1).max() < KERNEL_ERROR:
                used = weights > 0.0
                return rates[used], weights[used]
    raise ConvergenceError(
        f"memory of the heat over {steps} steps: no sum of {_TERMS[-1]} exponentials comes within {KERNEL_ERROR:g} of "
        "τ^(−1/2); take fewer steps",
        KERNEL_ERROR,
        _TERMS[-1],
    )
