"""Loop over the memory of a half-space: what each exponential of its kernel keeps of the heat that has entered."""

from typing import Any

import numpy as np

from roughsim._kernels import kernel

_SMALL = 0.02  # decays in a step below which series replace differences of almost equal numbers
_FORGOTTEN = 40.0  # decays in a step from which on nothing is left of what was before: e^-40 = 4e-18


@kernel()
def remember(along: Any, across: Any, rates: Any, weights: Any, new: Any, old: Any, memory: Any, result: Any) -> None:
    """Take one more step into the memory, and write what all of it gives at the end of the next step.

    `along[i]` + `across[j]` is D q² Δt of each mode, `rates` and `weights` are those of the exponentials, in units of
    the step. `new` and `old` are the spectra of the flux at the two ends of the step, linear in between. `memory`,
    shape (n_x, n_y//2 + 1, exponentials), holds ∫ exp(−(rate + D q² Δt) u) flux du over the past, u in steps.
    """
    falls = np.exp(-rates)
    for i in range(along.size):
        for j in range(across.size):
            decay = along[i] + across[j]
            if decay > _FORGOTTEN:
                result[i, j] = 0.0
                continue
            fall = np.exp(-decay)
            here, before = new[i, j], old[i, j]
            total = 0.0 * here
            kept = memory[i, j]
            for k in range(rates.size):
                y = rates[k] + decay
                left = falls[k] * fall
                z = max(y, _SMALL)
                mean = (1.0 - left) / z
                ends = (1.0 - mean) / z, (mean - left) / z  # ∫₀¹ (1 − u) e^(−yu) du and ∫₀¹ u e^(−yu) du
                if y < _SMALL:
                    ends = (
                        0.5 - y * (1 / 6 - y * (1 / 24 - y * (1 / 120 - y / 720))),
                        0.5 - y * (1 / 3 - y * (1 / 8 - y * (1 / 30 - y / 144))),
                    )
                value = left * kept[k] + ends[0] * here + ends[1] * before
                kept[k] = value
                total += weights[k] * left * value
            result[i, j] = total
