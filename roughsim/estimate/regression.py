"""Scatter that comes from the peak volumes of the surfaces, taken off by regression: their mean over surfaces is known.

T_flash of a realization follows the volume of the peaks of its surface (`surface.peak_volume`), which is known without
a contact. A surface has it by chance: x, the excess over the exact mean, has the mean zero. So Y − b x has the mean of
Y with any slope b, and scatters least with that of the regression (a control variate). A slope fitted to the same
realizations would be correlated with their x. Each realization is therefore taken with the slopes of all others: then
nothing is biased.
"""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from roughsim.grid import Array

CONTROLS = ("peak_volume", "long_peak_volume")  # numbers of members whose mean over surfaces is zero
LEAST_FITTED = 10  # realizations: of fewer, the uncertain slopes add a third to the variance that is left
SINGULAR = 1e-12  # relative: numbers that vary less, or that others make up, tell no slope


def at_mean_peak_volume(values: Array, numbers: Mapping[str, Array]) -> Array:
    """Return values (n, any) without what follows the `CONTROLS` among their numbers, (n,) or (n, 1) each.

    Numbers that are missing or NaN count as zero. The mean over surfaces is that of `values`. The variance of the mean
    is that of the rows over n, to a few percent, and known with n − 1 − `slopes_of` degrees of freedom.
    """
    controls = controls_of(numbers, len(values))
    if controls is None:
        return values
    slopes, residuals, design, inverse = fitted(values, controls)
    with np.errstate(all="ignore"):  # infinite values stay infinite
        gain = design @ inverse
        leverage = (gain * design).sum(axis=1)
        told = leverage < 1.0 - SINGULAR  # without the row the others tell the slopes still
        left_out = residuals / np.where(told, 1.0 - leverage, 1.0)[:, None]
        # what the slopes without row j say of it: x_j · (b − G x̃_j r_j)
        said = controls @ slopes - (gain[:, 1:] * controls).sum(axis=1)[:, None] * left_out
    return values - np.where(told[:, None] & np.isfinite(said), said, 0.0)


def slopes_of(numbers: Mapping[str, Array], n: int) -> int:
    """Return how many slopes are fitted to n rows: each leaves the scatter a degree of freedom less."""
    controls = controls_of(numbers, n)
    if controls is None:
        return 0
    design, inverse = design_of(controls)
    return int(np.trace(inverse @ design.T @ design).round()) - 1  # a control that others make up has no slope


def scatter_at_mean_peak_volume(values: Array, numbers: Mapping[str, Array]) -> Array:
    """Return the standard deviation that regression on the `CONTROLS` leaves of values (n, any), for many rows."""
    controls = controls_of(numbers, len(values))
    if controls is None:
        return np.asarray(values.std(axis=0, ddof=1))
    residuals = fitted(values, controls)[1]
    return np.asarray(np.sqrt((residuals**2).sum(axis=0) / (len(values) - 1 - controls.shape[1])))


def controls_of(numbers: Mapping[str, Array], n: int) -> Array | None:
    """Return the controls that vary, (n, controls), at most 1 in size; None where they or the rows are too few."""
    known = [np.nan_to_num(np.ravel(numbers[name])) for name in CONTROLS if name in numbers]
    known = [x / np.abs(x).max() for x in known if np.ptp(x) > SINGULAR * np.abs(x).max()]
    return np.stack(known, axis=1) if known and n >= LEAST_FITTED else None


def fitted(values: Array, controls: Array) -> tuple[Array, Array, Array, Array]:
    """Return slopes (controls, any), residuals (n, any), the design x̃ = (1, x − ⟨x⟩), and G = (x̃ᵀx̃)⁻¹."""
    design, inverse = design_of(controls)
    with np.errstate(all="ignore"):  # infinite values have no slope
        slopes = inverse @ (design.T @ values)
        return slopes[1:], values - design @ slopes, design, inverse


def design_of(controls: Array) -> tuple[Array, Array]:
    """Return the design and G as in `fitted`; all observables of a level have the same."""
    return _design_of(controls.astype(np.float64).tobytes(), controls.shape)


@lru_cache(maxsize=16)
def _design_of(content: bytes, shape: tuple[int, ...]) -> tuple[Array, Array]:
    controls = np.frombuffer(content).reshape(shape)
    design = np.column_stack((np.ones(len(controls)), controls - controls.mean(axis=0)))
    inverse = np.linalg.pinv(design.T @ design, rcond=SINGULAR, hermitian=True)
    for array in (design, inverse):
        array.flags.writeable = False
    return design, inverse
