"""Integrals over wavenumber: Gauss panels between the breaks, refined until two resolutions agree.

A piece between two breaks q_k < q_{k+1} is mapped by ln q = ln q_k + y² ln(q_{k+1}/q_k), 0 ≤ y ≤ 1. The square
opens up the boundary layer just above the break at the onset of roughness: there P falls as (q − q_k)^(−1/2), so its
integral is smooth in y, however thin the layer.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from theory.arguments import Array, Which
from theory.roots import root

NODES = 16
TOLERANCE = 1e-11
POINTS, WEIGHTS = legendre.leggauss(NODES)
_WIDEST = 1.0  # of a panel in ln q: then kernels in v/Dq, analytic within ±iπ/2, are exact to rounding at every speed
_PER_PANEL = TOLERANCE / 100  # a panel's share of the tolerance
_MOST_PANELS = 20_000

# matrices that act on the values at the nodes of a panel
_POLYNOMIALS = legendre.legvander(POINTS, NODES)  # P_k at the nodes, one degree more than fitted
_ODD_NUMBERS = 2 * np.arange(NODES) + 1
FIT: Array = _ODD_NUMBERS[:, None] / 2 * WEIGHTS * _POLYNOMIALS[:, :-1].T  # Legendre coefficients
_PRIMITIVES = (_POLYNOMIALS[:, 2:] - _POLYNOMIALS[:, :-2]) / _ODD_NUMBERS[1:]
_PRIMITIVE: Array = np.column_stack([1 + POINTS, _PRIMITIVES]) @ FIT  # ∫ from −1 to each node
_SLOPES = legendre.legval(POINTS, legendre.legder(np.eye(NODES))).T
DERIVATIVE: Array = np.ascontiguousarray(_SLOPES) @ FIT
ENDS: Array = legendre.legvander(np.array([-1.0, 1.0]), NODES - 1) @ FIT
HALVES: Array = legendre.legvander(np.stack([POINTS - 1, POINTS + 1]) / 2, NODES - 1) @ FIT


class QuadratureError(ArithmeticError):
    """An integral did not reach its accuracy, so there is no number to return."""


class Panels(NamedTuple):
    """Consecutive intervals of y, each within one piece; arrays of one entry per panel.

    `lower` and `upper` are the wavenumbers that bound the piece, rad/m; `start` and `stop` bound the panel in y.
    """

    piece: Array
    lower: Array
    upper: Array
    start: Array
    stop: Array

    def at(self, y: Array) -> tuple[Array, Array]:
        """Return q and dq/dy at `y`, shape (panels, any)."""
        extent = _extents(self.lower, self.upper)[:, None]
        q = np.minimum(self.lower[:, None] * np.exp(extent * y**2), self.upper[:, None])
        return q, 2 * extent * y * q

    def coordinates(self) -> Array:
        """Return y at the Gauss nodes, shape (panels, NODES)."""
        return self.start[:, None] + ((self.stop - self.start) / 2)[:, None] * (1 + POINTS)

    def place(self) -> tuple[Array, Array]:
        """Return the lower bound of the piece and the exact ln(q/lower) at the Gauss nodes, shape (panels, NODES)."""
        rise = _extents(self.lower, self.upper)[:, None] * self.coordinates() ** 2
        return np.broadcast_to(self.lower[:, None], rise.shape), rise

    def nodes(self) -> tuple[Array, Array]:
        """Return q and dq/dt at the Gauss nodes t, shape (panels, NODES); t runs from −1 to 1 over a panel."""
        q, slope = self.at(self.coordinates())
        return q, slope * ((self.stop - self.start) / 2)[:, None]

    def ends(self) -> Array:
        """Return the wavenumbers at both ends of each panel, shape (panels, 2)."""
        return self.at(np.array((self.start, self.stop)).T)[0]

    def take(self, which: Which) -> "Panels":
        """Return the panels selected by an index or a mask."""
        return Panels(*(column[which] for column in self))

    def halves(self) -> "Panels":
        """Return twice as many panels, each cut in two, in order."""
        twice = self.take(np.repeat(np.arange(self.start.size), 2))
        twice.start[1::2] = twice.stop[::2] = (self.start + self.stop) / 2
        return twice


def _extents(lower: Array, upper: Array) -> Array:
    """Return ln(upper/lower), to its own relative accuracy also for nearly equal bounds."""
    return np.log1p((upper - lower) / lower)


def panels_between(breaks: Array) -> Panels:
    """Return panels over all pieces, none wider than one e-fold."""
    counts = np.ceil(_extents(breaks[:-1], breaks[1:]) / _WIDEST).astype(int)
    piece = np.repeat(np.arange(counts.size), counts)
    index = np.concatenate([np.arange(n) for n in counts])
    start, stop = np.sqrt(index / counts[piece]), np.sqrt((index + 1) / counts[piece])
    return Panels(piece.astype(np.float64), breaks[:-1][piece], breaks[1:][piece], start, stop)


def together(*parts: Panels) -> Panels:
    """Return all panels, in the order of the parts."""
    return Panels(*map(np.concatenate, zip(*parts, strict=True)))


def _ascending(panels: Panels) -> Which:
    return np.lexsort((panels.start, panels.piece))


def graded(panels: Panels, layers: list[tuple[float, float]]) -> Panels:
    """Cut the first panel above a break from the height y of its layer upwards, each cut eight times the last."""
    for piece, y in layers:
        lowest = (panels.piece == piece) & (panels.start == 0.0)
        whole = panels.take(lowest)
        top = float(whole.stop[0])
        steps = max(int(np.ceil(np.log(top / y) / np.log(8))), 1)
        edges = np.append(0.0, top * 8.0 ** np.arange(-steps, 1))
        cut = whole.take(np.zeros(steps + 1, dtype=int))._replace(start=edges[:-1], stop=edges[1:])
        panels = together(panels.take(~lowest), cut)
        panels = panels.take(_ascending(panels))
    return panels


Integrands = Callable[[Panels], Array]


def refine(
    integrands: Integrands, panels: Panels, *, running: bool = False
) -> tuple[Panels, Array]:
    """Cut panels in two until the polynomial through the nodes of each panel agrees with the values on its halves.

    Parameters
    ----------
    integrands : callable
        Takes panels to the integrands with respect to t at their nodes, shape (integrands, panels, NODES), ≥ 0.
    panels : Panels
        The first panels.
    running : bool
        Measure the error against the integral from the first break up to the panel, not against the whole.

    Returns
    -------
    Panels, ndarray
        The refined panels, and the integrands on them.

    Raises
    ------
    QuadratureError
        If the sum of all errors exceeds 1e-11 of the integral, or the panels become too many.
    """
    values = integrands(panels)
    error = np.full(values.shape[:2], np.inf)
    untested = np.isinf(error[0])
    while untested.any():
        halves = panels.take(untested).halves()
        finer = integrands(halves)
        error[:, untested] = _departure(values[:, untested], finer)
        bad = np.any(error > _PER_PANEL * _scale(values, running), axis=0)
        error[:, bad] = np.inf  # also of panels tested before: the scale has shrunk since
        kept = ~(bad & untested)
        chosen = np.repeat(bad[untested], 2)
        panels = together(panels.take(kept), halves.take(chosen))
        order = _ascending(panels)
        panels = panels.take(order)
        values = np.concatenate([values[:, kept], finer[:, chosen]], axis=1)[:, order]
        unknown = np.full(finer[:, chosen].shape[:2], np.inf)
        error = np.concatenate([error[:, kept], unknown], axis=1)[:, order]
        if panels.start.size > _MOST_PANELS:
            raise QuadratureError(
                f"an integral over wavenumber needs more than {_MOST_PANELS} panels; name the kinks of the spectrum "
                "in its breaks"
            )
        untested = np.isinf(error[0])
    _confirm(error, _scale(values, running))
    return panels, values


def _departure(values: Array, finer: Array) -> Array:
    """Return ∫ |polynomial through the nodes − values on the halves| dt per panel: it bounds the error under J₀ too."""
    guess = np.einsum("hij,kpj->kphi", HALVES, values) / 2
    difference = np.abs(guess - finer.reshape(guess.shape)) @ WEIGHTS
    return np.asarray(difference.sum(axis=-1))


def _scale(values: Array, running: bool) -> Array:
    integrals = values @ WEIGHTS
    return integrals.cumsum(axis=1) if running else integrals.sum(axis=1, keepdims=True)


def _confirm(error: Array, scale: Array) -> None:
    total = np.maximum(scale[:, -1], np.finfo(float).tiny)
    worst = float((error.sum(axis=1) / total).max())
    if not worst <= TOLERANCE:
        raise QuadratureError(
            f"an integral over wavenumber has the relative error {worst:.1e}, above {TOLERANCE:.0e}; name the kinks "
            "of the spectrum in its breaks"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """The integral of a density from the first break up to q, as a polynomial on each panel.

    Above a break the density per dy vanishes as y; taking (1 + t)² out of the polynomial of such a panel, and (1 + t)
    out of the others, keeps the *relative* accuracy of the integral down to the break itself.
    """

    panels: Panels
    breaks: Array
    before: Array
    power: Array
    coefficients: Array

    def __call__(self, wavenumber: Array) -> Array:
        """Return the integral up to `wavenumber` (rad/m, any shape): 0 below the first break, all above the last."""
        return self.above(np.clip(wavenumber, self.breaks[0], self.breaks[-1]), 0.0)

    def above(self, start: Array, rise: Array | float) -> Array:
        """Return the integral up to start·e^rise, for `start` within the breaks and the `rise` ≥ 0 of one piece."""
        piece = np.clip(
            np.searchsorted(self.breaks, start, side="right") - 1, 0, self.breaks.size - 2
        )
        lower = self.breaks[piece]
        share = (_extents(lower, start) + rise) / _extents(lower, self.breaks[piece + 1])
        return self.at(piece, np.sqrt(np.minimum(share, 1.0)))

    def at(self, piece: Array | Which, y: Array) -> Array:
        """Return the integral at the coordinate `y` of each `piece`."""
        keys = self.panels.piece + self.panels.start
        last = (
            np.searchsorted(self.panels.piece, piece, side="right") - 1
        )  # at y = 1 the sum reaches the next piece
        return self._within(np.minimum(np.searchsorted(keys, piece + y, side="right") - 1, last), y)

    def _within(self, index: Which, y: Array) -> Array:
        start, stop = self.panels.start[index], self.panels.stop[index]
        rise = 2 * (y - start) / (stop - start)
        return self.before[index] + rise ** self.power[index] * self._polynomial(index, rise - 1)

    def _polynomial(self, index: Which, t: Array) -> Array:
        """Sum the Legendre series of the panels `index` at `t` by the recurrence of the P_k."""
        previous, current = np.ones_like(t), t
        total: Array = self.coefficients[0][index] + self.coefficients[1][index] * t
        for k in range(1, NODES - 1):
            previous, current = current, ((2 * k + 1) * t * current - k * previous) / (k + 1)
            total += self.coefficients[k + 1][index] * current
        return total

    def inverse(self, value: float) -> float:
        """Return the lowest wavenumber at which the integral reaches `value` ≥ 0, rad/m; ∞ if it never does."""
        last = np.array([self.panels.start.size - 1])
        if value > float(self._within(last, self.panels.stop[last])[0]):
            return float("inf")
        index = np.searchsorted(self.before, [value], side="right") - 1
        start, stop = self.panels.start[index], self.panels.stop[index]

        def excess(fraction: float) -> float:
            return float(self._within(index, start + fraction * (stop - start))[0]) - value

        fraction = 1.0
        if excess(1.0) > 0.0:
            fraction = root(excess, 0.0, 1.0, accuracy=1e-15, relative=1e-15)
        return float(
            self.panels.take(index).at((start + fraction * (stop - start))[:, None])[0][0, 0]
        )

    def layers(self, value: float) -> list[tuple[float, float]]:
        """Return (piece, y) above each break at which the integral reaches `value`, or doubles, if within a panel.

        The weight P of the stress falls from there on. A layer thinner than a panel is not seen by its nodes: cut the
        panel there.
        """
        first = np.flatnonzero(self.panels.start == 0.0)
        slope = self._polynomial(first, np.full(first.size, -1.0))
        with np.errstate(divide="ignore"):
            rise = np.sqrt(np.maximum(self.before[first], value) / np.maximum(slope, 0.0))
        y = rise * self.panels.stop[first] / 2
        thin = y < self.panels.stop[first]
        return list(zip(self.panels.piece[first][thin].tolist(), y[thin].tolist(), strict=True))


Density = Callable[[Array, tuple[Array, Array]], Array]


def primitive(density: Density, breaks: Array) -> Primitive:
    """Return the integral of a density ≥ 0 from the first of `breaks` up to any q.

    It is called with wavenumbers and their places in the pieces, see `Panels.place`.

    Raises
    ------
    QuadratureError
        If the density is not smooth between the breaks.
    """

    def integrand(panels: Panels) -> Array:
        q, slope = panels.nodes()
        return (density(q, panels.place()) * slope)[None]

    panels, values = refine(integrand, panels_between(breaks), running=True)
    integrals = values[0] @ WEIGHTS
    before = np.concatenate([[0.0], integrals.cumsum()[:-1]])
    power = np.where(panels.start == 0.0, 2.0, 1.0)
    ratio = values[0] @ _PRIMITIVE.T / (1 + POINTS) ** power[:, None]
    return Primitive(panels, breaks, before, power, np.ascontiguousarray((ratio @ FIT.T).T))
