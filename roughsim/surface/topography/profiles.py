"""C(q) of an isotropic surface from a line scan, or from the spectrum of profiles.

A line across an isotropic surface has C₁(k) = ∫C(√(k² + p²)) dp over all p, with ⟨h²⟩ = ∫C₁ dk over all k. Solved for
C (Abel), ∫C q' dq' from q on is the integral of C₁(k) k/√(k² − q²) from q on, over π: it needs no derivative of C₁. Its
differences between the ends of a bin give C(q) there. They scatter, as long waves of a line are mostly short waves of
the surface that run across the line. So C(q) is taken not to rise with q: neighbouring bins are put together until it
does not (isotonic inverse estimator, Groeneboom and Jongbloed 1995).
"""

from itertools import pairwise

import numpy as np

from roughsim.grid import Array
from roughsim.surface.topography.measured import BINS_PER_DECADE, BinnedSpectrum

_WIDE = 2  # bins of C(q) in one, as a line has few modes
_KNOWN = 0.3  # standard error of a variance, relative: above it, it is not known
_TAIL = 0.3  # decades below the last mode, over which the exponent of C₁ beyond it is fitted
_BEYOND = 30.0  # C₁ goes on to so many times the last wavenumber
_STEPS_BEYOND = 100
_NODES = 32  # of Gauss and Legendre between two rows of a table of C₁


def line_modes(
    heights: Array, length: float, *, periodic: bool, reliable: float = np.inf
) -> tuple[Array, Array, float]:
    """Return k, rad/m, and C₁, m³, of the modes of a line scan in m, and how many modes count as one.

    `length` is in m. A Hann window is used unless the line is periodic. `reliable` is the wavenumber, rad/m, up to
    which the instrument resolves.
    """
    points = heights.size
    step = 2 * np.pi / length
    window = np.ones(points)
    if not periodic:
        window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(points) + 0.5) / points)
    # without q = 0 and the Nyquist wavenumber
    modes = np.fft.rfft(heights * window)[1 : (points + 1) // 2]
    k = step * np.arange(1.0, modes.size + 1.0)
    inside = k <= reliable
    square = np.mean(window**2)
    along = np.abs(modes[inside]) ** 2 / (points**2 * step * float(square))
    together = float(np.mean(window**4) / square**2)
    return k[inside], along, together


def of_surface(k: Array, along: Array, *, together: float = 1.0, lines: int = 1) -> BinnedSpectrum:
    """Return C(q) of an isotropic surface from the modes of a line across it.

    `k` are their wavenumbers, rad/m, in even steps from one step on, and `along` is C₁ at them, m³, the mean over
    `lines`; `together` is how many modes count as one. ValueError if fewer than three bins of wavenumbers hold modes.
    """
    step = k[0]
    q_max = float(k[-1] + 0.5 * step)
    wide_bin = np.floor(BINS_PER_DECADE / _WIDE * np.log10(k) + 1e-9).astype(np.intp)
    index = _WIDE * np.unique(wide_bin)
    if index.size < 3:
        raise ValueError(
            f"only {index.size} bins of wavenumbers up to q_max = {q_max:.4g} rad/m hold modes"
        )
    ends = np.concatenate([[0.5 * step], 10.0 ** (index[1:] / BINS_PER_DECADE), [q_max]])
    low, high, values = _with_tail(k, along)

    def share_beyond(q: float) -> Array:
        """Weight of each mode of the line in ∫C q' dq' from q on."""
        upper = np.sqrt(np.maximum(high**2 - q**2, 0.0))
        lower = np.sqrt(np.maximum(low**2 - q**2, 0.0))
        return (upper - lower) / np.pi

    shares = [share_beyond(float(q)) for q in ends]
    areas = 0.5 * np.diff(ends**2)
    variances = -np.diff([float(share @ values) for share in shares])

    def scatter(pool: slice) -> float:
        """Return the standard error of the variance of a pool.

        A mode of Gaussian heights scatters by its mean: of the mean over n lines the mean square is n + 1 times that.
        """
        counts = ((shares[pool.start] - shares[pool.stop]) * values)[: k.size]
        return float(np.sqrt(together / (lines + 1) * (counts**2).sum()))

    pools = [slice(i, j) for i, j in _not_rising(variances / areas, areas)]
    # within a pool C follows the power laws between the pools, and keeps the variance of the pool
    centre = np.sqrt(np.append(k[0], ends[1:-1]) * ends[1:])
    ln_centre = np.log(centre)
    means = [float(variances[pool].sum() / areas[pool].sum()) for pool in pools]
    places = [float(areas[pool] @ ln_centre[pool] / areas[pool].sum()) for pool in pools]
    psd = np.exp(np.interp(ln_centre, places, np.log(means)))
    error = np.empty(index.size)
    for pool, mean in zip(pools, means, strict=True):
        psd[pool] *= mean / float(areas[pool] @ psd[pool] / areas[pool].sum())
        # pooled rows scatter together: with √n of the error their sum of squares is at least the square of the sum
        together_error = np.sqrt(pool.stop - pool.start) * scatter(pool)
        error[pool] = together_error / float(variances[pool].sum())
    exponent = -np.gradient(np.log(psd), ln_centre)
    # as long as the variance of all waves down from a length is unknown, it may come from some of them alone
    few = (slice(0, j) for j in range(1, index.size))
    known = next(
        (part.stop for part in few if scatter(part) <= _KNOWN * variances[part].sum()), index.size
    )
    error[:known] = np.maximum(error[:known], np.sqrt(known))
    return BinnedSpectrum(
        centre, psd, exponent, error, index, 2.0 * step * float(along.sum()), q_max
    )


def _with_tail(k: Array, along: Array) -> tuple[Array, Array, Array]:
    """Return the ends of the cells of the modes, and C₁ in them, carried on as a power law beyond the last one."""
    step = k[0]
    end = k[-1] + 0.5 * step
    first = np.searchsorted(k, k[-1] * 10.0**-_TAIL)
    middle = (first + k.size) // 2
    # the mean of both halves: modes scatter too much for a fit of logarithms
    lower_place, lower_level = _mean_point(k[first:middle], along[first:middle])
    upper_place, upper_level = _mean_point(k[middle:], along[middle:])
    slope = (upper_level - lower_level) / (upper_place - lower_place)
    exponent = max(-slope, 0.5)
    beyond = end * np.geomspace(1.0, _BEYOND, _STEPS_BEYOND + 1)
    centre = np.sqrt(beyond[1:] * beyond[:-1])
    tail = np.exp(upper_level - exponent * (np.log(centre) - upper_place))
    low = np.concatenate([k - 0.5 * step, beyond[:-1]])
    high = np.concatenate([k + 0.5 * step, beyond[1:]])
    return low, high, np.concatenate([along, tail])


def _mean_point(k: Array, along: Array) -> tuple[float, float]:
    """Return the mean of ln k and the ln of the mean of C₁ of some modes."""
    return float(np.mean(np.log(k))), float(np.log(np.mean(along)))


def _not_rising(values: Array, weights: Array) -> list[tuple[int, int]]:
    """Return first and one past the last of the neighbours that are put together so that their means do not rise.

    Pool adjacent violators; the mean of all stays above 0 if the mean of the last ones does.
    """
    from scipy.optimize import isotonic_regression  # slow to import

    found = isotonic_regression(values, weights=weights, increasing=False)
    edges = found.blocks.tolist()
    # a mean at or below 0 belongs to those before
    while len(edges) > 2:
        last = slice(edges[-2], edges[-1])
        if values[last] @ weights[last] > 0.0:
            break
        del edges[-2]
    return list(pairwise(edges))


def of_profile_table(k: Array, along: Array) -> tuple[Array, Array]:
    """Return C(q), m⁴, of an isotropic surface at the wavenumbers of a table of C₁, and its error, relative.

    `k`, rad/m, rises, and `along` is C₁, m³. Between rows, and beyond the last one, C₁ is a power law, from which the
    integral of Abel gives C: −1/π ∫ C₁'(k)/√(k² − q²) dk from q on. The error is the change without every second row,
    and all of the part beyond the last row; it is multiplied so that rows that err together may add up as if they were
    independent. ValueError if C is not above 0, as of tables that rise or scatter.
    """
    psd, beyond = _abel(k, along)
    if not (psd > 0.0).all():
        q = float(k[int(np.argmin(psd))])
        raise ValueError(
            f" gives a negative C(q) at q = {q:.4g} rad/m, as its spectrum rises or scatters there; "
            "average it over wider bins, or give the line scan itself as topography"
        )
    # with both ends, the second row without
    every_second = np.unique(np.append(np.arange(0, k.size, 2), k.size - 1))
    rows = k[every_second]
    coarse = np.interp(k, rows, _abel(rows, along[every_second])[0] / psd[every_second])
    error = np.minimum(np.hypot(coarse - 1.0, beyond / psd), 1.0)
    together = np.sum(error) ** 2 / np.sum(error**2) if error.any() else 1.0
    return psd, error * np.sqrt(together)


def _abel(k: Array, along: Array) -> tuple[Array, Array]:
    """Return C at each row of a table of C₁, and its part by the power law beyond the last row."""
    tail = min(int(np.searchsorted(k, k[-1] * 10.0**-_TAIL)), k.size - 2)
    exponent = np.log(along[tail] / along[-1]) / np.log(k[-1] / k[tail])
    factors = np.geomspace(1.0, _BEYOND, _STEPS_BEYOND + 1)[1:]
    rows = np.concatenate([k, k[-1] * factors])
    values = np.concatenate([along, along[-1] * factors ** -max(float(exponent), 0.5)])
    exponents = -np.diff(np.log(values)) / np.diff(np.log(rows))
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    psd = np.empty(k.size)
    beyond = np.empty(k.size)
    for i, q in enumerate(k):
        # with s = √(k² − q²) the integral is 1/π ∫ (−k C₁') / k² ds, without a singular end
        ends = np.sqrt(np.maximum(rows[i:] ** 2 - q**2, 0.0))
        half = 0.5 * np.diff(ends)
        middle = 0.5 * (ends[1:] + ends[:-1])
        place = np.hypot(middle[:, None] + half[:, None] * nodes, q)
        power = exponents[i:, None]
        level = values[i:-1, None] * (place / rows[i:-1, None]) ** -power
        parts = half * ((power * level / place**2) @ weights) / np.pi
        psd[i] = parts.sum()
        beyond[i] = parts[k.size - 1 - i :].sum()
    return psd, beyond
