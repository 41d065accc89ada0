"""How far the theory can be trusted for a scene: what the shipped map of its validity says there.

The map holds measured/theory with γ = 0.45. Between its points splines go through ln of the ratio; what these can miss,
by the bend of the map, is in the error. What lies off the map in any coordinate gets no number, and the coordinate is
named. The scene’s own γ is put right by the theory itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, log, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator, RegularGridInterpolator

from roughsim import prediction
from roughsim.store.validity_map import Table, read_validity
from roughsim.surface.power_laws import SelfAffineSpectrum

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
GAMMA = 0.45  # of the theory in the map
# what counts as one step between places: a factor for logarithmic coordinates, a difference for the others
_FACTOR = {"load": 3.0, "hurst": 1.4, "bandwidth": 2.0, "plateau": 2.0, "share": 2.5, "yields": 2.0}
_STEP = {"low_exponent": 0.75}
_DEPTH = (0.3, 1.05)  # T_flash nears its limit as q_max^−(0.3 + 1.05 H): between slow and fast sliding on all ladders
_NEAR = 0.1  # steps: how far a scene may be from a coordinate that the map has at one value only
_PER_STEP = 0.2  # what ln(measured/theory) may change over such a step: 0.12 for the plateau, up to 0.15 for the others
_CURVED = 0.5  # of what a straight line misses, a spline may: leaving points of the map out, it is 0.4
_UNSEEN = 0.01  # missed halfway between the only two q_y/q_roll_off: for H = 0.8 a third one shows 0.007
_WORDS = {
    "load": "load p/(E*h')",
    "hurst": "H",
    "bandwidth": "q_max/q_roll_off",
    "plateau": "q_roll_off/q_min",
    "low_exponent": "roll_off_exponent",
    "share": "pressure/hardness",
    "yields": "q_y/q_roll_off",
    "depth": "q_max/q_y",
}


@dataclass(frozen=True, slots=True)
class Judgement:
    """What is known of one prediction of the theory.

    Attributes
    ----------
    observable : str
        As in `compare`.
    speed : float or None
        m/s.
    percent : float
        100 (theory/measured − 1): positive where the theory is high.
    error : float
        Its total error, 95 %.
    """

    observable: str
    speed: float | None
    percent: float
    error: float

    def __str__(self) -> str:
        side = "high" if self.percent >= 0.0 else "low"
        return f"{abs(self.percent):.0f} ± {max(self.error, 1.0):.0f} % {side}"


@dataclass(frozen=True, slots=True)
class Trust:
    """What is known of a scene.

    Attributes
    ----------
    source : {"map", "calibrated", "off the map"}
        The scene lies on the map; or its stress spectrum is within what is calibrated; or nothing is known of it.
    where : str
        The place of the scene in words; off the map each coordinate that leaves it, with its value and the map's range.
    against : str
        What the theory is high or low against; empty off the map.
    judgements : tuple of Judgement
        One per observable and speed.
    off : tuple of (float, str)
        Speeds, m/s, without a judgement, and why.
    """

    source: str
    where: str
    against: str = ""
    judgements: tuple[Judgement, ...] = ()
    off: tuple[tuple[float, str], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values."""
        rows = [
            {"observable": j.observable, "speed": j.speed, "percent": j.percent, "error": j.error}
            for j in self.judgements
        ]
        off = [{"speed": speed, "where": why} for speed, why in self.off]
        return {"source": self.source, "where": self.where, "against": self.against, "rows": rows, "off": off}


def trust(scene: Scene, tables: dict[str, Table] | None = None) -> Trust:
    """Return how far the theory is known to be off for a scene.

    Parameters
    ----------
    scene : Scene
        Elastic or with a hardness.
    tables : dict of str to Table, optional
        The map; the one that the package ships if left out.

    Returns
    -------
    Trust
        Without judgements where nothing is known; `where` then says why.
    """
    table = (read_validity() if tables is None else tables)["elastic" if scene.elastic else "capped"]
    place = _place(scene)
    found = _WITHOUT_A_PLACE if place is None else _looked_up(table, place)
    if not isinstance(found, str):
        assert place is not None
        words = ", ".join(f"{_WORDS[name]} {place[name]:.3g}" for name in table.coordinates)
        against = f"the simulation extrapolated to q_max = {scene.spectrum.breaks[-1]:.3g} rad/m"
        off, within = _speeds(scene, table)
        return Trust("map", words, against, tuple(_judgements(scene, table, *found, within)), off)
    if not scene.elastic:
        return Trust("off the map", found)
    return _by_calibration(scene, table, found)


_WITHOUT_A_PLACE = (
    "C(q) is not self-affine (a table, the sum of two different faces, or another law), and has no place on the map"
)


def _place(scene: Scene) -> dict[str, float] | None:
    """Return the coordinates of a scene; None where C(q) is not self-affine."""
    spectrum = scene.spectrum
    if not isinstance(spectrum, SelfAffineSpectrum):
        return None
    load, roll_off = scene.sliding.nominal_pressure, spectrum.q_roll_off
    result = {
        "load": load / (scene.effective_modulus * spectrum.rms_slope),
        "hurst": spectrum.hurst,
        "bandwidth": spectrum.q_max / roll_off,
        "plateau": roll_off / spectrum.q_min,
        "low_exponent": spectrum.roll_off_exponent,
    }
    if not scene.elastic:
        yields = prediction.yield_wavenumber(scene)  # infinite where C(q) ends before: the depth says so
        result |= {"share": load / scene.penetration_hardness, "yields": yields / roll_off}
        result |= {"depth": spectrum.q_max / yields}
    return result


def _speeds(scene: Scene, table: Table) -> tuple[tuple[tuple[float, str], ...], dict[int, float]]:
    """Return the speeds whose Péclet number is off the map, and the Péclet numbers of the others by place."""
    spectrum = scene.spectrum
    if isinstance(spectrum, SelfAffineSpectrum):
        q = spectrum.q_roll_off
    else:  # the mean wavenumber, which is about q_roll_off
        k = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1], 2001)
        q = float(np.trapezoid(k**2 * spectrum(k), np.log(k)) / np.trapezoid(k * spectrum(k), np.log(k)))
    peclet = np.abs(scene.speeds) / (prediction.conduction(scene).diffusivity * q)
    known = [pe for _, pe in table.quantities if isfinite(pe)]
    off: list[tuple[float, str]] = []
    within: dict[int, float] = {}
    for place, (speed, pe) in enumerate(zip(scene.speeds, peclet.tolist(), strict=True)):
        if why := _outside("Péclet number", pe, min(known), max(known)):
            off += [(speed, f"{why[:-1]} of v/(D q_roll_off))")] if speed else []  # at rest there is no heat to judge
        else:
            within[place] = pe
    return tuple(off), within


def _outside(name: str, x: float, low: float, high: float) -> str:
    """Say how a coordinate leaves the range of the map; empty where it does not."""
    if low * (1 - 1e-9) <= x <= high * (1 + 1e-9):
        return ""
    side = f"below {low:.4g}" if x < low else f"above {high:.4g}"
    return f"{name} {x:.4g} {side} (map: {low:.4g} to {high:.4g})"


def _looked_up(table: Table, place: dict[str, float]) -> tuple[Array, Array] | str:
    """Return ln(measured/theory) and its error at a place, by quantity; or why the map has none there.

    A labelled point, such as a steel, is a map of its own; its other coordinates are those of the scene, or nearly so.
    """
    labels, reason = np.array(table.labels), ""
    for label in sorted(set(table.labels), reverse=True):  # the regular grid, without a label, comes last
        rows, axes = _regular(table, np.flatnonzero(labels == label))
        reason = "; ".join(filter(None, (_off_axis(name, place[name], axis) for name, axis in axes.items())))
        if not reason:
            return _interpolated(table, rows, axes, place)
    return reason


def _regular(table: Table, rows: Any) -> tuple[Any, dict[str, Array]]:
    """Return the rows of a regular grid, in its order, and its axes; a value that lacks some rows is left out."""
    axes: dict[str, Array] = {}
    for k, name in enumerate(table.coordinates):
        values, place, count = np.unique(table.place[rows, k], return_inverse=True, return_counts=True)
        axes[name], rows = values[count == count.max()], rows[(count == count.max())[place]]
    return rows[np.lexsort(table.place[rows][:, ::-1].T)], axes


def _off_axis(name: str, x: float, axis: Array) -> str:
    """Say how a coordinate leaves the map; empty where it does not."""
    if name == "yields" and not isfinite(x):
        return ""
    if name == "depth" and x == 0.0:
        return "q_y beyond q_max, less than 99 % of the contact yields"
    if axis.size > 1:
        return _outside(_WORDS[name], x, float(axis[0]), float(axis[-1]))
    near = abs(_scaled(name, x) - _scaled(name, float(axis[0]))) <= _NEAR
    return "" if near else f"{_WORDS[name]} {x:.3g}, the map has only {axis[0]:.3g}"


def _scaled(name: str, x: float, hurst: float = nan) -> float:
    """Return a coordinate in which ln(measured/theory) is nearly linear."""
    if name == "depth":
        return -float(x ** -(_DEPTH[0] + _DEPTH[1] * hurst))
    if name == "share":  # full contact, 1, is as far as none
        return log(x / (1.0 - x)) / log(_FACTOR[name])
    if name in _FACTOR:
        return log(x) / log(_FACTOR[name]) if x > 0.0 else -inf
    return x / _STEP[name]


def _interpolated(table: Table, rows: Any, axes: dict[str, Array], place: dict[str, float]) -> tuple[Array, Array]:
    """Return ln(measured/theory) and its error between the points of a regular grid."""
    free = [name for name, axis in axes.items() if axis.size > 1]
    hurst = place["hurst"]
    nodes = [np.array([_scaled(name, x, hurst) for x in axes[name]]) for name in free]
    at = [float(np.clip(_scaled(name, place[name], hurst), *nodes[k][[0, -1]])) for k, name in enumerate(free)]
    shape = (*(axes[name].size for name in free), len(table.quantities))
    logs, measured = (x[rows].reshape(shape) for x in (np.log(table.value), table.error))
    errors = [RegularGridInterpolator(nodes, measured)(at)[0]]
    for k in range(len(free)):
        along = np.moveaxis(logs, k, len(free) - 1)  # of this coordinate, once the others are at the place
        for other in (i for i in range(len(free)) if i != k):
            along = CubicSpline(nodes[other], along)(at[other])
        errors.append(_missed(nodes[k], along, at[k], _CURVED))
    value: Array = CubicSpline(nodes[-1], along)(at[-1])
    fixed = [name for name, axis in axes.items() if axis.size == 1]
    apart = sum(abs(_scaled(name, place[name]) - _scaled(name, float(axes[name][0]))) for name in fixed)
    return value, np.sqrt(np.sum(np.square(errors), axis=0) + (_PER_STEP * apart) ** 2)


def _missed(nodes: Array, values: Array, x: float, part: float) -> Array:
    """Return that part of what linear interpolation at `x` misses by the bend of `values` (nodes, ...) about its cell.

    The bend at a node is what leaving that node out shows; two nodes show none.
    """
    k = int(np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2))
    square = (x - nodes[k]) * (nodes[k + 1] - x)
    if nodes.size == 2:
        return np.full(values.shape[1:], 4.0 * _UNSEEN * square / (nodes[1] - nodes[0]) ** 2)
    slopes = np.diff(values, axis=0) / np.diff(nodes).reshape(-1, *[1] * (values.ndim - 1))
    bend = np.abs(np.diff(slopes, axis=0)) / (nodes[2:] - nodes[:-2]).reshape(-1, *[1] * (values.ndim - 1))
    result: Array = part * square * bend[max(k - 1, 0) : k + 1].max(axis=0)
    return result


def _judgements(scene: Scene, table: Table, logs: Array, error: Array, within: dict[int, float]) -> Iterator[Judgement]:
    own = prediction.predictions(scene)
    base = prediction.predictions(replace(scene, theory=replace(scene.theory, gamma=GAMMA)))
    for name in dict.fromkeys(name for name, _ in table.quantities):
        columns = [k for k, (other, _) in enumerate(table.quantities) if other == name]
        if len(columns) == 1:
            off = float(own[name][0] / base[name][0] / np.exp(logs[columns[0]]))
            yield Judgement(name, None, 100 * (off - 1), 100 * off * float(error[columns[0]]))
            continue
        nodes = np.log([table.quantities[k][1] for k in columns])
        between = PchipInterpolator(nodes, logs[columns])  # a straight line misses up to twice as much
        for k, peclet in within.items():
            x = float(np.clip(log(peclet), nodes[0], nodes[-1]))
            off = float(own[name][k] / base[name][k] / np.exp(between(x)))
            total = np.hypot(np.interp(x, nodes, error[columns]), _missed(nodes, logs[columns], x, 1.0))
            yield Judgement(name, scene.speeds[k], 100 * (off - 1), 100 * off * float(total))


def _by_calibration(scene: Scene, table: Table, reason: str) -> Trust:
    """Judge by the calibrated stress spectrum; `reason` says why the map does not."""
    try:
        true = prediction.calibrated(scene)
    except ValueError as error:
        return Trust("off the map", f"{reason}; calibrated spectrum: {str(error).split(';')[0]}")
    band, (off, within) = prediction.calibration_error(), _speeds(scene, table)
    own, rows = prediction.predictions(scene), []
    for name, values in true.items():
        for k in within if name != "pressure_variance" else (0,):
            high = float(own[name][k] / values[k])
            speed = None if name == "pressure_variance" else scene.speeds[k]
            rows.append(Judgement(name, speed, 100 * (high - 1), 100 * high * band))
    end = f"q_max = {scene.spectrum.breaks[-1]:.3g} rad/m"
    against = f"the calibrated stress spectrum up to {end}, which is within {band:.0%} of simulations"
    return Trust("calibrated", f"load and C(q) within its range (off the map: {reason})", against, tuple(rows), off)
