"""Waves of the picture of a camera: their mean square, and the width of their autocorrelation, by quadrature.

The formulas stand in `theory.camera`. Panels of |q| and of its angle resolve the response, and the oscillations of
exposure and slid distance, which are faded out where they cancel.
"""

from collections.abc import Iterator
from math import inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.special import erfc, erfcx

from theory.arguments import Array
from theory.flash import HeatSource
from theory.quadrature import FIT, POINTS, WEIGHTS, Panels, QuadratureError
from theory.roots import root
from theory.skin import surface_response

Complex = NDArray[np.complex128]
ACCURACY = 1e-6  # of the mean square, between two quadratures
_FWHM = sqrt(8 * log(2.0))  # of a Gaussian, over its standard deviation
_WHOLE, _WINDOW = (
    150.0,
    25.0,
)  # phase at which oscillations are faded out, and the width of that, rad
FADED = _WHOLE + 6 * _WINDOW
_GROWTH = 3.0  # of an angle over a panel
# nodes of such a panel, and the largest phase of a wave over it, rad
_ROUGH, _FINE = (8, 12.0), (11, 7.0)
_FAINT = 40.0  # e^(−40) is nothing


class View(NamedTuple):
    """What the camera looks at, and how sharply; the default is a sharp picture of steady sliding.

    Parameters
    ----------
    resolution : float
        Full width at half maximum of the Gaussian point spread, m, ≥ 0.
    smear : float
        Distance that the contact moves past the camera while the shutter is open, m, ≥ 0.
    slid_distance : float
        Distance slid since the start from rest, m, > 0; ∞ is steady sliding.
    behind : float, optional
        Distance d of a line behind the straight trailing edge of the contact, m, ≥ 0. Default: the contact itself.
    contact_length : float
        Length ℓ of the contact before that line, m, > 0; not beyond `slid_distance`. Only with `behind`.
    """

    resolution: float = 0.0
    smear: float = 0.0
    slid_distance: float = inf
    behind: float | None = None
    contact_length: float = inf


class _Cloud(NamedTuple):
    """Waves with weights: the sum of the weights is the mean square of κT/μv, Pa² m²."""

    across: Array  # q_y, rad/m
    weight: Array


class Picture:
    """The picture at one speed, in units of μv/κ."""

    _stretch = 1.0  # the largest q over the wavenumber of the stress

    def __init__(self, source: HeatSource, speed: float, view: View):
        self._source, self._view = source, view
        self._drift = speed / source.body.diffusivity  # v/D, 1/m

    def mean_square(self) -> float:
        """Return the mean square; QuadratureError if two quadratures disagree."""
        if self._drift == 0.0 and self._view.behind is not None:
            return 0.0
        rough, fine = (
            sum(float(part.weight.sum()) for part in self._clouds(0.0, *order))
            for order in (_ROUGH, _FINE)
        )
        return _agreed(rough, fine)

    def width(self) -> float:
        """Return the full width of the autocorrelation across sliding at half its maximum, m."""
        resting_line = self._drift == 0.0 and self._view.behind is not None
        cloud = self._gathered(0.0)[0] if not resting_line else _Cloud(np.empty(0), np.empty(0))
        whole = float(cloud.weight.sum())
        if whole == 0.0:
            raise ValueError(
                "the picture is uniform, so its tracks have no width; give a rough surface, and a speed with behind"
            )
        mean = float(cloud.weight @ cloud.across) / whole
        steepest = float(cloud.weight @ cloud.across**2) / whole
        near = 1 / sqrt(steepest)  # 1 − cos x ≤ x²/2: still above one half
        reach = 2 / mean
        while near < 1e6 * reach:
            cloud, sharper = self._gathered(reach)
            _agreed(whole, sharper)

            def excess(y: float, cloud: _Cloud = cloud) -> float:
                seen = slice(int(np.searchsorted(cloud.across, FADED / y)))
                return float(cloud.weight[seen] @ _wave(cloud.across[seen] * y)) / whole - 0.5

            while near < reach:
                far = min(1.4 * near, reach)
                if excess(far) <= 0.0:
                    return 2 * root(excess, near, far, accuracy=1e-9 * far, relative=ACCURACY)
                near = far
            reach *= 2
        raise ValueError("the autocorrelation of the picture does not fall to half its maximum")

    def _gathered(self, distance: float) -> tuple[_Cloud, float]:
        """Return the waves of `_clouds` together, but for the faintest, by rising q_y, and the mean square of all."""
        parts = zip(*self._clouds(distance, *_ROUGH), strict=True)
        across, weight = (np.concatenate(several) for several in parts)
        strength = np.sort(weight)
        dropped = int(np.searchsorted(strength.cumsum(), ACCURACY / 10 * strength.sum()))
        kept = weight >= strength[dropped]
        order = np.argsort(across[kept])
        return _Cloud(across[kept][order], weight[kept][order]), float(strength.sum())

    def _clouds(self, distance: float, nodes: int, phase: float) -> Iterator[_Cloud]:
        """Yield the waves by panels of |q|, `nodes` in a panel of the angle, at most `phase` rad of a wave in each.

        They resolve waves of cos(q_y `distance`), too.
        """
        view, stress = self._view, self._source.stress
        points, weights = legendre.leggauss(nodes)
        lengths = [each for each in self._lengths() if 0.0 < each < inf]
        longest = self._stretch * max([*lengths, distance])
        for q, moment in _subdivided(stress.panels, stress.values, longest, 2 * phase):
            edges = self._angles(float(q[0]), float(q[-1]), lengths, distance, phase)
            half = np.diff(edges)[:, None] / 2
            angle = (edges[:-1, None] + half * (1 + points)).ravel()
            share = self._share(q[:, None], angle, (half * weights).ravel())
            along, across, length = (q[:, None] * part for part in self._parts(angle))
            power = self._power(along, across) * _point_spread(length, across, view)
            yield _Cloud(across.ravel(), (moment[:, None] * share * power).ravel())

    def _parts(self, angle: Array) -> tuple[Array, Array, Array]:
        """Return q along and across sliding, both ≥ 0, and |q|, over the wavenumber of the stress."""
        return np.sin(angle), np.cos(angle), np.ones(1)

    def _share(self, q: Array, angle: Array, width: Array) -> Array:
        """Return the share of the stress at q (n, 1) in angles of some `width`."""
        return width * 2 / pi  # of a quarter turn, like all others

    def _lengths(self) -> tuple[float, ...]:
        """Return the lengths l of waves cos(q_xl) in |H|²."""
        view = self._view
        if view.behind is None:
            return view.smear, view.slid_distance
        return (min(view.contact_length, view.slid_distance),)

    def _angles(
        self, low: float, high: float, lengths: list[float], distance: float, phase: float
    ) -> Array:
        """Return the edges of panels over the angle, for |q| in a range."""
        edges = self._edges(low, high, lengths, distance)
        along, across, _ = self._parts(edges)
        counts = np.ones(edges.size - 1)
        for part, several in ((along, lengths), (across, [distance])):
            least, change = np.minimum(part[:-1], part[1:]), np.abs(np.diff(part))
            for one in several:
                turned = np.ceil(high * one * change / phase)
                counts = np.maximum(counts, np.where(low * least * one < FADED, turned, 1.0))
        counts = counts.astype(int)
        ends = zip(edges[:-1].tolist(), edges[1:].tolist(), counts.tolist(), strict=True)
        pieces = [a + (b - a) / n * np.arange(n) for a, b, n in ends]
        return np.append(np.concatenate(pieces), edges[-1])

    def _edges(self, low: float, high: float, lengths: list[float], distance: float) -> Array:
        """Return edges of panels over the angle ψ of q = (sinψ, cosψ)|q|, from 0 to π/2, without oscillations.

        They grow from both ends, at which the response varies fast.
        """
        few, last = self._narrow(low, high, lengths, distance)
        return np.append(growing(few, pi / 4)[:-1], pi / 2 - growing(last, pi / 4)[::-1])

    def _narrow(
        self, low: float, high: float, lengths: list[float], distance: float
    ) -> tuple[float, float]:
        """Return q_x/|q| and q_y/|q| below which the response varies fast: |q_x| < q²D/v, and a line at small q_y."""
        drift, layers = self._drift, self._source.body.layers
        steep = drift * (1.0 if layers is None else max(1.0, layers.diffusion))
        few = min([1.0, low / steep if steep else 1.0, *(1 / (high * one) for one in lengths)])
        spread = distance**2  # 1/q_y² of the longest waves that the response or the cosine resolves
        if self._view.behind is not None:
            age = self._view.behind + (lengths[0] if lengths else 0.0)
            spread += max(age, 1 / high) / drift + self._view.resolution**2
        return few, min(1.0, 1 / (high * sqrt(spread))) if spread else 1.0

    def _power(self, along: Array, across: Array) -> Array:
        """Return |H|²/|λ|² without the point spread, m²."""
        view, drift, layers = self._view, self._drift, self._source.body.layers
        if view.behind is not None:
            return self._power_behind(along, across)
        square = along**2 + across**2
        advection = drift * along
        if layers is None:
            power = 1 / np.hypot(square, advection)
        else:
            power = np.abs(surface_response(np.sqrt(square), advection, layers)) ** 2 / square
        if view.slid_distance < inf and drift > 0.0:
            power = power * _grown(
                square * (view.slid_distance / drift), along * view.slid_distance
            )
        return power * _smeared(along * view.smear)

    def _power_behind(self, along: Array, across: Array) -> Array:
        drift, near = self._drift, self._view.behind or 0.0
        (length,) = self._lengths()
        spread: Complex = across**2 / drift - 1j * along  # λ²D/v
        first = erfc_root(spread * near)
        last = erfc_root(spread * (near + length)) if length < inf else np.zeros_like(spread)
        crossed = 2 * (first * last.conj()).real
        if length < inf:
            crossed = crossed * fade(along * length)
        power: Array = np.abs(first) ** 2 + np.abs(last) ** 2 - crossed
        return power / (drift * np.abs(spread))


def _agreed(first: float, second: float) -> float:
    """Return the second of two quadratures of a mean square; QuadratureError if they differ by more than `ACCURACY`."""
    if not abs(second - first) <= ACCURACY * second:
        raise QuadratureError(
            f"the mean square of the picture has the relative error {abs(second / first - 1):.1e}, above "
            f"{ACCURACY:.0e}; name the kinks of the spectrum in its breaks"
        )
    return second


def _point_spread(q: Array, across: Array, view: View) -> Array:
    """Return |e^(−q²b²/2)|²; on a line behind the contact across it only."""
    blurred = q if view.behind is None else across
    return np.asarray(np.exp(-np.square(blurred * (view.resolution / _FWHM))))


def fade(phase: Array) -> Array:
    """Return a smooth window over the phase of an oscillation, 1 below some 10 turns and 0 beyond 50.

    Under an integral over q_x the rest cancels to e^(−`_WINDOW`²/4).
    """
    return np.asarray(erfc((phase - _WHOLE) / _WINDOW) / 2)


def _wave(phase: Array) -> Array:
    """Return the cosine of a phase ≥ 0, faded out where an integral over it is nothing."""
    return np.asarray(np.cos(phase) * fade(phase))


def _smeared(phase: Array) -> Array:
    """Return |sin(p/2)/(p/2)|² = 2(1 − cos p)/p² of a phase p ≥ 0."""
    few = np.sinc(np.minimum(phase, 1.0) / (2 * pi)) ** 2
    large = np.maximum(phase, 1.0)
    return np.where(phase < 1.0, few, 2 * (1 - _wave(large)) / large**2)


def _grown(decay: Array, phase: Array) -> Array:
    """Return |erf z|² of z² = `decay` − i `phase`, both ≥ 0: 1 − 2 Re erfc z + |erfc z|²."""
    rest = erfc_root(decay - 1j * phase)
    few = decay**2 + phase**2 < 1e-6
    power = 1 - 2 * rest.real * fade(phase) + np.abs(rest) ** 2
    z = decay[few] - 1j * phase[few]
    power[few] = 4 / pi * np.abs(z) * np.abs(1 - z / 3 + z**2 / 10) ** 2  # of the series
    return np.asarray(power)


def erfc_root(square: Complex) -> Complex:
    """Return erfc √s of s with Re s ≥ 0, 0 where it is less than e^(−40)."""
    result = np.zeros_like(square)
    seen = square.real < _FAINT
    part = square[seen]
    result[seen] = np.exp(-part) * erfcx(np.sqrt(part))
    return result


def growing(start: float, stop: float) -> Array:
    """Return edges of panels 0, `start`, and on by the factor `_GROWTH` to `stop`."""
    count = max(int(np.ceil(np.log(stop / start) / np.log(_GROWTH))), 0)
    return np.append(0.0, stop * _GROWTH ** -np.arange(count, -1.0, -1.0))


def _subdivided(
    panels: Panels, values: Array, length: float, phase: float
) -> Iterator[tuple[Array, Array]]:
    """Yield q, rad/m, and s dq, Pa², at the nodes of panels over which q `length` grows by at most `phase`.

    Where q `length` is so large that its waves are faded out a panel stays whole.
    """
    low, high = panels.ends().T
    counts = np.ceil((np.minimum(high, FADED / length if length else inf) - low) * length / phase)
    counts = np.maximum(counts, 1.0).astype(int)
    series = values @ FIT.T
    for k, count in enumerate(counts.tolist()):
        panel = panels.take(np.array([k]))
        for part in range(count):
            t = (2 * part + 1 + POINTS) / count - 1
            y = panel.start + (panel.stop - panel.start) / 2 * (1 + t)
            q = panel.at(y[None])[0][0]
            yield q, legendre.legval(t, series[k]) * WEIGHTS / count
