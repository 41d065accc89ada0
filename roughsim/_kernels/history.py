"""Loop over the memory of a half-space: convolutions of the heat that has entered with exponentials."""

import numpy as np

from roughsim._kernels import REORDER, kernel

_SMALL = 0.02  # decays in a step below which series replace differences of almost equal numbers
_FORGOTTEN = 40.0  # decays in a step from which on the memory is empty: e^-40 = 4e-18


@kernel(fastmath=REORDER)
def remember(
    along,
    across,
    rates,
    weights,
    new,
    old,
    latest,
    memory,
    result,
):
    """Add one step to the memory, and write the temperature that it gives at the end of the next step.

    `along[i]` + `across[j]` is D q² Δt of each mode; the `rates` of the exponentials are in units of the step. Their
    `weights` have the shape (1, 1, exponentials) if all modes share them, else (n_x, n_y//2 + 1, exponentials). `new`
    and `old` are the spectra of the flux at the two ends of the step, linear in between. `latest`, real, is the
    response to `new` itself. `memory`, shape (n_x, n_y//2 + 1, 2, exponentials), holds the real and the imaginary part
    of ∫ exp(−(rate + D q² Δt) u) flux du over the past, u in steps.
    """
    count = rates.size
    last_i = weights.shape[0] - 1
    last_j = weights.shape[1] - 1
    falls = np.exp(-rates)
    falls_along = np.exp(-along)
    falls_across = np.exp(-across)
    for i in range(along.size):
        for j in range(across.size):
            decay = along[i] + across[j]
            direct = latest[i, j]
            if decay > _FORGOTTEN:
                result[i, j] = direct * new[i, j]
                continue
            fall = falls_along[i] * falls_across[j]
            real = memory[i, j, 0]
            imag = memory[i, j, 1]
            weight = weights[min(i, last_i), min(j, last_j)]
            new_real = new[i, j].real
            new_imag = new[i, j].imag
            old_real = old[i, j].real
            old_imag = old[i, j].imag
            total_real = direct * new_real
            total_imag = direct * new_imag
            for k in range(count):
                y = rates[k] + decay
                left = falls[k] * fall
                inverse = 1.0 / max(y, _SMALL)
                mean = (1.0 - left) * inverse
                # ∫₀¹ (1 − u) e^(−yu) du and ∫₀¹ u e^(−yu) du
                late = (1.0 - mean) * inverse
                early = (mean - left) * inverse
                small = y < _SMALL
                late = 0.5 - y * (1 / 6 - y * (1 / 24 - y * (1 / 120 - y / 720))) if small else late
                early = 0.5 - y * (1 / 3 - y * (1 / 8 - y * (1 / 30 - y / 144))) if small else early
                real[k] = left * real[k] + late * new_real + early * old_real
                imag[k] = left * imag[k] + late * new_imag + early * old_imag
                total_real += weight[k] * left * real[k]
                total_imag += weight[k] * left * imag[k]
            result[i, j] = complex(total_real, total_imag)
