"""Integrals with J₀(qr), exact to rounding however often the Bessel function oscillates.

A panel over which J₀ oscillates little more than once is summed over its Gauss nodes. At a faster phase the
method of Levin applies: ∫ F J₀ dt is p₀J₀ + p₁J₁ between the ends, with p₀′ + rq′p₁ = F and
p₁′ − rq′p₀ − (q′/q)p₁ = 0. These have a solution as smooth as F, found by collocation at the nodes. The cost does not
grow with r.
(D. Levin, Math. Comp. 38 (1982) 531; J. Comput. Appl. Math. 67 (1996) 95.)
"""

from collections.abc import Callable

import numpy as np
import scipy
from scipy.special import j0, j1

from theory.arguments import Array
from theory.quadrature import (
    DERIVATIVE,
    ENDS,
    HALVES,
    NODES,
    TOLERANCE,
    WEIGHTS,
    Panels,
    QuadratureError,
    together,
)
from theory.roots import root

_SLOW, _FAST = (
    8.0,
    40.0,
)  # phase over a panel, rad: below, Gauss nodes suffice; above, Levin's p has settled


def hankel_transform(panels: Panels, values: Array, distance: Array) -> Array:
    """Return ∫ F(q) J₀(qr) dq for each distance r.

    Parameters
    ----------
    panels : Panels
        Panels that resolve F.
    values : ndarray
        F dq/dt ≥ 0 at their nodes, shape (panels, NODES).
    distance : ndarray
        r ≥ 0, m, any shape.

    Raises
    ------
    QuadratureError
        If the panels and their halves differ by more than 1e-11 of the integral of F.
    """
    whole = float((values @ WEIGHTS).sum())
    halves, finer = _halved(panels, values)
    result = np.empty(distance.shape)
    for place, r in np.ndenumerate(distance):
        result[place] = _transform(halves, finer, float(r))
        error = abs(result[place] - _transform(panels, values, float(r)))
        if not error <= TOLERANCE * whole:
            raise QuadratureError(
                f"the integral with J₀(qr) at r = {r:.6g} m has the error {error / whole:.1e} of its value at r = 0, "
                f"above {TOLERANCE:.0e}; name the kinks of the spectrum in its breaks"
            )
    return result


def first_crossing(panels: Panels, values: Array, fraction: float) -> float:
    """Return the smallest r, m, at which the transform equals `fraction` of its value at r = 0."""
    q = panels.nodes()[0]
    whole = float((values @ WEIGHTS).sum())
    if whole == 0.0:
        raise ValueError(
            "the correlation vanishes at every distance, so no fraction of it is reached anywhere"
        )
    roughness = float(((values * (q / q.max()) ** 2) @ WEIGHTS).sum()) * q.max() ** 2

    def excess(r: float) -> float:
        return _transform(panels, values, r) / whole - fraction

    r = float(2 * np.sqrt((1 - fraction) * whole / roughness)) * (
        1 - 1e-9
    )  # 1 − J₀(x) ≤ x²/4: no crossing before
    waves, moments = q.ravel(), (values * q * WEIGHTS).ravel() / whole

    def steepest(r: float) -> float:
        """The fastest that it can fall from r on: |J₁(x)| ≤ 0.582 and 0.8251/√x."""
        return float(moments @ np.minimum(0.583, 0.826 / np.sqrt(r * waves)))

    trail = [(r, excess(r))]
    while trail[-1][0] < 100 / panels.lower[0]:
        clear = r + trail[-1][1] / steepest(r)  # no crossing before
        r *= 1.03
        while 1.03 * r < clear:
            r *= 1.03
        trail = [*trail[-2:], (r, excess(r))]
        bracket = _bracket(excess, trail)
        if bracket is not None:
            return root(excess, *bracket, accuracy=1e-16 * r, relative=1e-13)
    raise ValueError(f"the correlation stays above fraction = {fraction:.6g} of its value at r = 0")


def _bracket(
    excess: Callable[[float], float], trail: list[tuple[float, float]]
) -> tuple[float, float] | None:
    """Return an interval that holds the first root, if the last steps passed or, between them, touched it."""
    (before, _), (now, value) = trail[-2:]
    if value <= 0.0:
        return before, now
    if len(trail) == 3 and trail[0][1] > trail[1][1] < value:
        dip = scipy.optimize.minimize_scalar(excess, bounds=(trail[0][0], now), method="bounded")
        if dip.fun <= 0.0:
            return trail[0][0], float(dip.x)
    return None


def _transform(panels: Panels, values: Array, r: float) -> float:
    slowly: list[tuple[Panels, Array]] = []
    quickly: list[tuple[Panels, Array]] = []
    while panels.start.size:
        phase = r * np.diff(panels.ends())[:, 0]
        slow = phase <= _SLOW
        # p varies with 1/y: at a break it is not smooth
        fast = (phase >= _FAST) & (panels.start > panels.stop / 2)
        slowly.append((panels.take(slow), values[slow]))
        quickly.append((panels.take(fast), values[fast]))
        rest = ~(slow | fast)
        panels, values = _halved(panels.take(rest), values[rest])
    (gauss, at_gauss), (levin, at_levin) = (
        (together(*parts), np.concatenate(held))
        for parts, held in (zip(*found, strict=True) for found in (slowly, quickly))
    )
    summed = float(((at_gauss * j0(r * gauss.nodes()[0])) @ WEIGHTS).sum())
    return summed + _levin(levin, at_levin, r)


def _halved(panels: Panels, values: Array) -> tuple[Panels, Array]:
    """Cut all panels in two and interpolate F dq/dt on the halves."""
    finer = np.einsum("hij,pj->phi", HALVES, values) / 2
    return panels.halves(), finer.reshape(-1, NODES)


def _levin(panels: Panels, values: Array, r: float) -> float:
    q, slope = panels.nodes()
    diagonal = np.arange(NODES)
    system = np.zeros((q.shape[0], 2 * NODES, 2 * NODES))
    system[:, :NODES, :NODES] = system[:, NODES:, NODES:] = DERIVATIVE
    system[:, diagonal, NODES + diagonal] = r * slope
    system[:, NODES + diagonal, diagonal] = -r * slope
    system[:, NODES + diagonal, NODES + diagonal] -= slope / q
    known = np.concatenate([values, np.zeros_like(values)], axis=1)
    solution = np.linalg.solve(system, known[..., None])[..., 0]
    at_ends = solution.reshape(-1, 2, NODES) @ ENDS.T
    phase = r * panels.ends()
    primitive = at_ends[:, 0] * j0(phase) + at_ends[:, 1] * j1(phase)
    return float((primitive[:, 1] - primitive[:, 0]).sum())
