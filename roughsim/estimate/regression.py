"""Control variate: the peak volume of the surfaces, whose exact mean is known, reduces the scatter.

T_flash of a realization follows the volume of the peaks of its surface (`surface.peak_volume`), which is known without
a contact. A surface has it by chance: x, the excess over the exact mean, has the mean zero. So Y − b x has the mean of
Y with any slope b. A slope fitted to the same realizations would be correlated with their x. Each is therefore taken
with the slope of all others: then nothing is biased.
"""

from collections.abc import Mapping

import numpy as np

from roughsim.grid import Array

CONTROL = "peak_volume"  # a number of each member whose mean over surfaces is zero
LEAST_FITTED = (
    10  # realizations: of fewer, the uncertain slope adds a fifth to the variance that is left
)


def at_mean_peak_volume(values: Array, numbers: Mapping[str, Array]) -> Array:
    """Return values (n, any) at the mean peak volume, which is among their numbers, (n,) or (n, 1)."""
    x = np.nan_to_num(np.ravel(numbers[CONTROL])) if CONTROL in numbers else np.zeros(0)
    few = len(values) < LEAST_FITTED or len(x) != len(values)
    if few or np.ptp(x) <= 1e-12 * np.abs(x).max():
        return values
    apart = x - x.mean()
    spread = float(apart @ apart)
    with np.errstate(invalid="ignore"):  # infinite values stay infinite
        slope = apart @ (values - values.mean(axis=0)) / spread
        left = values - values.mean(axis=0) - np.multiply.outer(apart, slope)
        leverage = 1.0 / len(x) + apart**2 / spread
        # the slope without row j: b − x̃_j r_j / (S (1 − h_j))
        slopes = slope - left * (apart / (spread * np.maximum(1.0 - leverage, 1e-12)))[:, None]
        taken = slopes * x[:, None]
    return values - np.where(np.isfinite(taken), taken, 0.0)
