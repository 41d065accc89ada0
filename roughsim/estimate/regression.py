"""Scatter that comes from the skewness of the surfaces, taken off by regression: the mean of the skewness is zero.

T_flash of a realization follows the skewness of its surface, which is known without a contact. A surface has it by
chance: over many surfaces its mean is exactly zero. So Y − b s has the mean of Y with any slope b, and scatters least
with that of the regression (a control variate). A slope fitted to the same realizations would be correlated with their
skewness. Each realization is therefore taken with the slope of all others: then nothing is biased.
"""

import numpy as np

from roughsim.grid import Array

LEAST_FITTED = 8  # realizations: of fewer, the uncertain slope adds a third to the variance that is left


def at_zero_skewness(values: Array, skewness: Array) -> Array:
    """Return values (n, any) without what follows their skewness (n,) or (n, 1); NaN there counts as zero.

    The mean over surfaces is that of `values`. The variance of the mean is that of the rows over n, to a few percent.
    """
    n = len(values)
    known = np.nan_to_num(np.reshape(skewness, (n, 1)))
    if n < LEAST_FITTED or not known.any():
        return values
    with np.errstate(all="ignore"):  # infinite values stay infinite
        x, y = known - known.mean(), values - values.mean(axis=0)
        # sums over all other realizations, about their own means
        products = (x * y).sum(axis=0) - n / (n - 1) * x * y
        squares = (x * x).sum() - n / (n - 1) * x * x
        slopes = np.where(squares > 1e-12 * (known * known).sum(), products / squares, 0.0)
    return values - np.where(np.isfinite(slopes), slopes, 0.0) * known
