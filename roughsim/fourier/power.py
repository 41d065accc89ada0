"""The power of a field by wavenumber: |f(q)|² of the half spectrum, gathered from all modes of the plane."""

import numpy as np

from roughsim._kernels.gathering import gather_power
from roughsim.grid import Complex, Field, Index


def gathered_power(
    amplitude: Complex,
    multiplicity: Field,
    slot: Index,
    slots: int,
) -> tuple[Field, Field]:
    """Return Σ|f(q)|² over the four modes (±q_x, ±q_y), and its sums over the modes of each slot.

    `amplitude` is the half spectrum f(q), shape (n_x, n_y//2 + 1), and `multiplicity` holds the weights of its columns;
    `slot` maps each mode of the quarter plane to its slot, below `slots`, flattened. The results have the shapes
    (n_x//2 + 1, n_y//2 + 1) and (slots,).
    """
    quarter = np.empty((amplitude.shape[0] // 2 + 1, amplitude.shape[1]))
    sums = np.zeros(slots)
    half = np.ascontiguousarray(amplitude, complex)
    gather_power(half, multiplicity.ravel(), slot.reshape(quarter.shape), quarter, sums)
    return quarter, sums
