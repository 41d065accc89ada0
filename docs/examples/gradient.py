"""Contact by projected gradients: slow, but short enough to check another solver."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from roughsim.contact import Contact, Solid
from roughsim.errors import ConvergenceError
from roughsim.grid import Grid

LIMIT = 5000


def solve(
    heights: NDArray[Any],
    grid: Grid,
    solid: Solid,
    *,
    nominal_pressure: float,
    tolerance: float,
    precision: Literal["double", "single"],
) -> Contact:
    """Return the contact; arguments and errors as `roughsim.solve_contact`."""
    q, hardness = grid.wavenumbers, solid.penetration_hardness
    compliance = np.divide(2.0, solid.effective_modulus * q, out=np.zeros(q.shape), where=q > 0)
    slow = (
        compliance.max() / compliance[q > 0].min()
    )  # the last steps are so much smaller than the error
    pressure = np.full(grid.shape, nominal_pressure)
    for iteration in range(1, LIMIT + 1):
        displacement = np.fft.irfft2(compliance * np.fft.rfft2(pressure), grid.shape)
        previous = pressure
        pressure = loaded(
            previous - (displacement - heights) / compliance.max(), hardness, nominal_pressure
        )
        residual = slow * float(np.linalg.norm(pressure - previous) / np.linalg.norm(pressure))
        if residual <= tolerance:
            kind = np.float32 if precision == "single" else np.float64
            shares = float(np.mean(pressure > 0)), float(np.mean(pressure >= hardness))
            work = residual, iteration, 2.0 * iteration
            return Contact(pressure.astype(kind), displacement.astype(kind), *shares, *work)
    message = f"contact solve stopped at the limit: residual {residual:.3g}; raise the tolerance"
    raise ConvergenceError(message, residual, LIMIT, pressure)


def loaded(trial: NDArray[Any], hardness: float, load: float) -> NDArray[Any]:
    """Shift the pressures so that, between 0 and the hardness, their mean is the load."""
    low, high = -trial.max(), load - trial.min()
    while high - low > 1e-14 * (abs(low) + abs(high)):
        middle = 0.5 * (low + high)
        if np.clip(trial + middle, 0.0, hardness).mean() < load:
            low = middle
        else:
            high = middle
    shifted: NDArray[Any] = np.clip(trial + high, 0.0, hardness)
    return shifted
