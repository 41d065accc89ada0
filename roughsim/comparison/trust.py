"""How far the theory can be trusted for a scene: what the shipped map of its validity says there.

The map holds measured/theory with γ = 0.45. Between its points splines go through ln of the ratio; what these can miss,
by the bend of the map, is in the error. What lies off the map in any coordinate gets no number, and the coordinate is
named. The scene’s own γ is put right by the theory itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, log, nan
from typing import Any, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.comparison.interpolation import cell_of, linear, monotone, spline
from roughsim.comparison.validity_map import Table, read_validity
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.scene import Scene
from roughsim.surface.power_laws import SelfAffineSpectrum

GAMMA = 0.45  # of the theory in the map
# how a coordinate of the map is called, and the factor that is one step in it; of roll_off_exponent the difference
COORDINATES = {
    "load": ("load p/(E*h')", 3.0),
    "hurst": ("H", 1.4),
    "bandwidth": ("q_max/q_roll_off", 2.0),
    "plateau": ("q_roll_off/q_min", 2.0),
    "low_exponent": ("roll_off_exponent", 0.75),
    "share": ("pressure/hardness", 2.5),
    "yields": ("q_y/q_roll_off", 2.0),
    "depth": ("q_max/q_y", nan),
}
DEPTH = (0.3, 1.05)  # T_flash nears its limit as q_max^−(0.3 + 1.05 H): between slow and fast sliding on all ladders
NEAR = 0.1  # steps: how far a scene may be from a coordinate that the map has at one value only
PER_STEP = 0.2  # what ln(measured/theory) may change over such a step: 0.12 for the plateau, up to 0.15 for the others
CURVED = 0.5  # of what a straight line misses, a spline may: leaving points of the map out, it is 0.4
UNSEEN = 0.01  # missed halfway between the only two q_y/q_roll_off: for H = 0.8 a third one shows 0.007
NOT_SELF_AFFINE = (
    "C(q) is not self-affine (a table, the sum of two different faces, or another law), and has no place on the map"
)


class OffMapError(Exception):
    """Why a scene has no place on the map."""


class Judgement(NamedTuple):
    """What is known of one prediction of the theory."""

    observable: str  # as in `compare`
    speed: float | None  # m/s
    percent: float  # 100 (theory/measured − 1): positive where the theory is high
    error: float  # its total error, 95 %

    def __str__(self) -> str:
        side = "high" if self.percent >= 0.0 else "low"
        return f"{abs(self.percent):.0f} ± {max(self.error, 1.0):.0f} % {side}"


@dataclass(frozen=True, slots=True)
class Trust:
    """What is known of a scene."""

    source: str  # "map" it lies on; "calibrated", as its stress spectrum is within what that holds for; "off the map"
    where: str  # its place in words; off the map each coordinate that leaves it, with its value and the map's range
    against: str = ""  # what the theory is high or low against; empty off the map
    judgements: tuple[Judgement, ...] = ()  # one per observable and speed
    off: tuple[tuple[float, str], ...] = ()  # speeds, m/s, without a judgement, and why

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values."""
        off = [{"speed": speed, "where": why} for speed, why in self.off]
        rows = [judgement._asdict() for judgement in self.judgements]
        return {"source": self.source, "where": self.where, "against": self.against, "rows": rows, "off": off}


def trust(scene: Scene, tables: dict[str, Table] | None = None) -> Trust:
    """Return how far the theory is known to be off for a scene, without judgements where nothing is known.

    `tables` is the map by "elastic" and "capped", the one that the package ships if left out.
    """
    table = (read_validity() if tables is None else tables)["elastic" if scene.elastic else "capped"]
    try:
        place = coordinates(scene)
        ratios = look_up(table, place)
    except OffMapError as reason:
        return by_calibration(scene, table, str(reason))
    words = ", ".join(f"{COORDINATES[name][0]} {place[name]:.3g}" for name in table.coordinates)
    against = f"the simulation extrapolated to q_max = {scene.spectrum.breaks[-1]:.3g} rad/m"
    off, within = split_speeds(scene, table)
    return Trust("map", words, against, tuple(judgements(scene, table, *ratios, within)), off)


def coordinates(scene: Scene) -> dict[str, float]:
    """Return the coordinates of a scene; OffMapError where C(q) is not self-affine."""
    spectrum = scene.spectrum
    if not isinstance(spectrum, SelfAffineSpectrum):
        raise OffMapError(NOT_SELF_AFFINE)
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


def split_speeds(scene: Scene, table: Table) -> tuple[tuple[tuple[float, str], ...], dict[int, float]]:
    """Return the speeds whose Péclet number is off the map with the reason, and that of the others by their place."""
    spectrum = scene.spectrum
    if isinstance(spectrum, SelfAffineSpectrum):
        q = spectrum.q_roll_off
    else:  # the mean wavenumber, which is about q_roll_off
        waves = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1], 2001)
        first, second = (np.trapezoid(waves**n * spectrum(waves), np.log(waves)) for n in (1, 2))
        q = float(second / first)
    peclet = np.abs(scene.speeds) / (prediction.conduction(scene).diffusivity * q)
    known = [pe for _, pe in table.quantities if isfinite(pe)]
    off: list[tuple[float, str]] = []
    within: dict[int, float] = {}
    for k, (speed, pe) in enumerate(zip(scene.speeds, peclet.tolist(), strict=True)):
        why = outside("Péclet number", pe, min(known), max(known))
        if not why:
            within[k] = pe
        elif speed:  # at rest there is no heat to judge
            off.append((speed, f"{why[:-1]} of v/(D q_roll_off))"))
    return tuple(off), within


def outside(name: str, x: float, low: float, high: float) -> str:
    """Say how a coordinate leaves the range of the map; empty where it does not."""
    if low * (1 - 1e-9) <= x <= high * (1 + 1e-9):
        return ""
    side = f"below {low:.4g}" if x < low else f"above {high:.4g}"
    return f"{name} {x:.4g} {side} (map: {low:.4g} to {high:.4g})"


def look_up(table: Table, place: dict[str, float]) -> tuple[Array, Array]:
    """Return ln(measured/theory) and its error at a place, by quantity; OffMapError where the map has none.

    A labelled point, such as a steel, is a map of its own; its other coordinates are those of the scene, or nearly so.
    """
    labels, reason = np.array(table.labels), ""
    for label in sorted(set(table.labels), reverse=True):  # the regular grid, without a label, comes last
        # the rows of a regular grid and its axes: a value that lacks some rows is left out
        rows, axes = np.flatnonzero(labels == label), {}
        for k, name in enumerate(table.coordinates):
            values, which, count = np.unique(table.place[rows, k], return_inverse=True, return_counts=True)
            whole = count == count.max()
            axes[name], rows = values[whole], rows[whole[which]]
        reason = "; ".join(filter(None, (off_axis(name, place[name], axis) for name, axis in axes.items())))
        if not reason:
            return interpolated(table, rows[np.lexsort(table.place[rows][:, ::-1].T)], axes, place)
    raise OffMapError(reason)


def off_axis(name: str, x: float, axis: Array) -> str:
    """Say how a coordinate leaves the map; empty where it does not."""
    words = COORDINATES[name][0]
    if name == "yields" and not isfinite(x):
        return ""
    if name == "depth" and x == 0.0:
        return "q_y beyond q_max, less than 99 % of the contact yields"
    if axis.size > 1:
        return outside(words, x, float(axis[0]), float(axis[-1]))
    near = abs(scaled(name, x) - scaled(name, float(axis[0]))) <= NEAR
    return "" if near else f"{words} {x:.3g}, the map has only {axis[0]:.3g}"


def scaled(name: str, x: float, hurst: float = nan) -> float:
    """Return a coordinate in steps, in which ln(measured/theory) is nearly linear."""
    step = COORDINATES[name][1]
    if name == "depth":
        return -float(x ** -(DEPTH[0] + DEPTH[1] * hurst))
    if name == "low_exponent":
        return x / step
    if name == "share":  # full contact, 1, is as far as none
        x /= 1.0 - x
    return log(x) / log(step) if x > 0.0 else -inf


def interpolated(table: Table, rows: Any, axes: dict[str, Array], place: dict[str, float]) -> tuple[Array, Array]:
    """Return ln(measured/theory) and its error between the points of a regular grid.

    Splines of one coordinate after the other, as some have two or three points only, and what a spline may miss is
    worked out along each.
    """
    free = [name for name, axis in axes.items() if axis.size > 1]
    hurst = place["hurst"]
    nodes = [np.array([scaled(name, x, hurst) for x in axes[name]]) for name in free]
    at = [float(np.clip(scaled(name, place[name], hurst), *nodes[k][[0, -1]])) for k, name in enumerate(free)]
    shape = (*(axes[name].size for name in free), len(table.quantities))
    logs, measured = (x[rows].reshape(shape) for x in (np.log(table.value), table.error))
    error = measured
    for axis, x in zip(nodes, at, strict=True):
        error = linear(axis, error, x)
    errors = [error]
    for k in range(len(free)):
        along = np.moveaxis(logs, k, len(free) - 1)  # of this coordinate, once the others are at the place
        for other in (i for i in range(len(free)) if i != k):
            along = spline(nodes[other], along, at[other])
        errors.append(missed(nodes[k], along, at[k], CURVED))
    value = spline(nodes[-1], along, at[-1])
    # what the map has at one value only may change from there to the scene
    fixed = [name for name, axis in axes.items() if axis.size == 1]
    steps = sum(abs(scaled(name, place[name]) - scaled(name, float(axes[name][0]))) for name in fixed)
    return value, np.sqrt(np.sum(np.square(errors), axis=0) + (PER_STEP * steps) ** 2)


def missed(nodes: Array, values: Array, x: float, part: float) -> Array:
    """Return that part of what linear interpolation at `x` misses by the bend of `values` (nodes, ...) about its cell.

    The bend at a node is what leaving that node out shows; two nodes show none.
    """
    k = cell_of(nodes, x)
    square = (x - nodes[k]) * (nodes[k + 1] - x)
    if nodes.size == 2:
        return np.full(values.shape[1:], 4.0 * UNSEEN * square / (nodes[1] - nodes[0]) ** 2)
    slopes = np.diff(values, axis=0) / np.diff(nodes).reshape(-1, *[1] * (values.ndim - 1))
    bend = np.abs(np.diff(slopes, axis=0)) / (nodes[2:] - nodes[:-2]).reshape(-1, *[1] * (values.ndim - 1))
    result: Array = part * square * bend[max(k - 1, 0) : k + 1].max(axis=0)
    return result


def judgements(scene: Scene, table: Table, logs: Array, error: Array, within: dict[int, float]) -> Iterator[Judgement]:
    """Judge every observable of the map; `within` has the Péclet numbers on the map by the place of their speed."""
    # the map is of γ = 0.45; the theory itself says what another γ changes
    own = prediction.predictions(scene)
    base = prediction.predictions(replace(scene, theory=replace(scene.theory, gamma=GAMMA)))
    for name in dict.fromkeys(name for name, _ in table.quantities):
        columns = [k for k, (other, _) in enumerate(table.quantities) if other == name]
        if len(columns) == 1:
            high = float(own[name][0] / base[name][0] / np.exp(logs[columns[0]]))
            yield Judgement(name, None, 100 * (high - 1), 100 * high * float(error[columns[0]]))
            continue
        nodes = np.log([table.quantities[k][1] for k in columns])
        # a straight line misses up to twice as much
        for k, peclet in within.items():
            x = float(np.clip(log(peclet), nodes[0], nodes[-1]))
            high = float(own[name][k] / base[name][k] / np.exp(monotone(nodes, logs[columns], x)))
            total = np.hypot(np.interp(x, nodes, error[columns]), missed(nodes, logs[columns], x, 1.0))
            yield Judgement(name, scene.speeds[k], 100 * (high - 1), 100 * high * float(total))


def by_calibration(scene: Scene, table: Table, reason: str) -> Trust:
    """Judge by the calibrated stress spectrum; `reason` says why the map does not."""
    law = prediction.calibrated(scene)
    if law.stress_spectrum is None:
        return Trust("off the map", f"{reason}; of the calibrated spectrum: {law.range}")
    off, within = split_speeds(scene, table)
    own, view, rows = prediction.predictions(scene), prediction.calibrated_integrals(scene), []
    for name, error in law.errors.items():
        true = OBSERVABLES[name].of_theory(view, len(scene.speeds))
        for k in within if OBSERVABLES[name].per_speed else (0,):
            speed = scene.speeds[k] if OBSERVABLES[name].per_speed else None
            high = float(own[name][k] / true[k])
            rows.append(Judgement(name, speed, 100 * (high - 1), 100 * high * error))
    end = f"q_max = {scene.spectrum.breaks[-1]:.3g} rad/m"
    against = f"the calibrated stress spectrum up to {end}, within the error given of simulations"
    return Trust(
        "calibrated", f"pressures and C(q) within its range (off the map: {reason})", against, tuple(rows), off
    )
