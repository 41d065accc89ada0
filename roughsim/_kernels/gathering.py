"""Loops that gather the modes of a grid by wavenumber."""

from roughsim._kernels import kernel

POWERS = 12  # see `observables.stress_spectrum`; a constant, so that the compiler unrolls the loop over them


@kernel()
def gather_power(amplitude, multiplicity, slot, quarter, sums):
    """Write Σ|amplitude|² over the four modes (±q_x, ±q_y) to `quarter`, and add each to the sum that its slot names.

    `amplitude` is the half spectrum of a real field, and `multiplicity` is the number of modes of each column.
    """
    for i in range(quarter.shape[0]):
        opposite = amplitude.shape[0] - i
        # row −i is another one, unless q_x is zero or the Nyquist wavenumber
        paired = 0 < i < opposite
        for j in range(quarter.shape[1]):
            a = amplitude[i, j]
            power = a.real * a.real + a.imag * a.imag
            if paired:
                b = amplitude[opposite, j]
                power += b.real * b.real + b.imag * b.imag
            power *= multiplicity[j]
            quarter[i, j] = power
            sums[slot[i, j]] += power


@kernel()
def moments_of_columns(table, offset, moments):
    """Add Σ table·offset^k down each column to row k of `moments`, for all powers."""
    for r in range(table.shape[0]):
        for c in range(table.shape[1]):
            w = table[r, c]
            x = offset[r, c]
            for k in range(POWERS):
                moments[k, c] += w
                w *= x
