"""How far the theory can be trusted for a scene: what the shipped map of its validity says there.

The map holds measured/theory with γ = 0.45. Between its points it is interpolated, ln of the ratio linear in the
logarithms of load, bandwidth and Péclet number; elsewhere the nearest point speaks. The scene’s own γ is put right by
the theory itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isnan, log, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import analytic
from roughsim.record.validity import Table, read_validity
from roughsim.spectrum import SelfAffineSpectrum

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
GAMMA = 0.45  # of the theory in the map
# what counts as one step between places: a factor for logarithmic coordinates, a difference for the others
_FACTOR = {"load": 3.0, "bandwidth": 2.0, "plateau": 2.0, "share": 2.5, "yields": 2.0}
_STEP = {"hurst": 0.25, "low_exponent": 0.75}
_SAME_FAMILY = 0.3  # of q_roll_off/q_min and of the low exponent: how far a scene may be from those of the regular grid
_BETWEEN = 0.01  # error of the interpolation: a quarter of what leaving every other point out makes, at its worst
_BETWEEN_RADII = 0.06  # g_σ(r) oscillates about a tenth of g_σ(0), so its radius jumps
_WORDS = {
    "load": "load p/(E*h')",
    "hurst": "H",
    "bandwidth": "q_max/q_roll_off",
    "plateau": "q_roll_off/q_min",
    "low_exponent": "roll_off_exponent",
    "share": "pressure/hardness",
    "yields": "q_y/q_roll_off",
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
    source : {"map", "calibrated", "nearest"}
        The scene lies on the map; or its stress spectrum is within what is calibrated; or only the nearest point of the
        map can be named.
    where : str
        The place that the judgements are for, in words.
    judgements : tuple of Judgement
        One per observable and speed.
    """

    source: str
    where: str
    judgements: tuple[Judgement, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values."""
        rows = [
            {"observable": j.observable, "speed": j.speed, "percent": j.percent, "error": j.error}
            for j in self.judgements
        ]
        return {"source": self.source, "where": self.where, "rows": rows}


def trust(scene: Scene, tables: dict[str, Table] | None = None) -> Trust:
    """Return how far the theory is known to be off for a scene.

    Parameters
    ----------
    scene : Scene
        Elastic or with a hardness.
    tables : dict of str to Table, optional
        The map; the one that the package ships if left out.

    Raises
    ------
    ValueError
        If C(q) is a table or a sum, which have no place on the map, and the scene has a hardness or is not calibrated.
    """
    table = (read_validity() if tables is None else tables)["elastic" if scene.elastic else "capped"]
    place = _coordinates(scene)
    known = None if place is None else _on_the_map(scene, table, place)
    if known is None and scene.elastic:
        known = _by_calibration(scene)
    if known is None and place is not None:
        k, _ = _nearest(table, place)
        rows = tuple(_judgements(scene, table, table.value[k], table.error[k]))
        known = Trust("nearest", _words(table, table.place[k], table.labels[k]), rows)
    if known is None:
        raise ValueError("C(q) of this scene is a table or a sum; only a self-affine one has a place on the map")
    return known


def _on_the_map(scene: Scene, table: Table, place: dict[str, float]) -> Trust | None:
    k, distance = _nearest(table, place)
    if distance < 0.1:
        value, error = table.value[k], table.error[k]
    else:
        around = _grid_around(table, np.array([place[name] for name in table.coordinates]))
        if around is None:
            return None
        value, error = around
    words = _words(table, np.array([place[name] for name in table.coordinates]), "")
    return Trust("map", words, tuple(_judgements(scene, table, value, error)))


def _by_calibration(scene: Scene) -> Trust | None:
    try:
        true = analytic.calibrated(scene)
    except ValueError:
        return None
    own, rows = analytic.predictions(scene), []
    for name, values in true.items():
        for k, value in enumerate(values.tolist()):
            speed = scene.speeds[k] if values.size == len(scene.speeds) and name != "pressure_variance" else None
            if speed != 0.0:
                off = float(own[name][k]) / value
                rows.append(Judgement(name, speed, 100 * (off - 1), 100 * off * analytic.calibration_error()))
    return Trust("calibrated", "load and C(q) within its range", tuple(rows))


def known(scene: Scene) -> Trust | None:
    """Return what `trust` does; None for a scene that has no place on the map."""
    try:
        return trust(scene)
    except ValueError:
        return None


def _nearest(table: Table, place: dict[str, float]) -> tuple[int, float]:
    scaled = _scaled(table, np.array([place[name] for name in table.coordinates]))
    distance = np.linalg.norm(np.array([_scaled(table, row) for row in table.place]) - scaled, axis=1)
    k = int(np.argmin(distance))
    return k, float(distance[k])


def _coordinates(scene: Scene) -> dict[str, float] | None:
    spectrum = scene.spectrum
    if not isinstance(spectrum, SelfAffineSpectrum):
        return None
    roll_off = spectrum.q_roll_off
    load = scene.sliding.nominal_pressure
    result = {
        "load": load / (scene.effective_modulus * spectrum.rms_slope),
        "hurst": spectrum.hurst,
        "bandwidth": spectrum.q_max / roll_off,
        "plateau": roll_off / spectrum.q_min,
        "low_exponent": spectrum.roll_off_exponent,
    }
    if not scene.elastic:
        result |= {"share": load / scene.penetration_hardness}
        result |= {"yields": min(analytic.yield_wavenumber(scene), spectrum.q_max) / roll_off}
    return result


def _scaled(table: Table, place: Array) -> Array:
    pairs = zip(table.coordinates, place, strict=True)
    return np.array([log(x) / log(_FACTOR[name]) if name in _FACTOR else x / _STEP[name] for name, x in pairs])


def _grid_around(table: Table, place: Array) -> tuple[Array, Array] | None:
    """Return ratios and errors between the corners of the cell of the map that holds `place`; None without a cell."""
    free = np.array([name not in ("plateau", "low_exponent") for name in table.coordinates])
    home = np.median(table.place[:, ~free], axis=0)
    rows = np.flatnonzero((np.abs(table.place[:, ~free] - home) < 1e-9).all(axis=1))
    if (np.abs(place[~free] - home) > _SAME_FAMILY).any():
        return None
    scaled = np.array([_scaled(table, row)[free] for row in table.place[rows]])
    weights = _corner_weights(scaled, _scaled(table, place)[free])
    if weights is None:
        return None
    between = np.array([_BETWEEN_RADII if "radius" in name else _BETWEEN for name, _ in table.quantities])
    value, error = np.exp(weights @ np.log(table.value[rows])), weights @ table.error[rows]
    return value, np.hypot(error, between)


def _corner_weights(points: Array, target: Array) -> Array | None:
    """Return the weights of multilinear interpolation between the points at the corners around `target`."""
    weights = np.ones(points.shape[0])
    for column, x in zip(points.T, target, strict=True):
        below, above = column[column <= x + 1e-9], column[column >= x - 1e-9]
        if below.size == 0 or above.size == 0:
            return None
        low, high = below.max(), above.min()
        share = (x - low) / (high - low) if high > low else 0.0
        weights *= np.where(column == low, 1.0 - share, np.where(column == high, share, 0.0))
    return weights if abs(weights.sum() - 1.0) < 1e-9 else None  # a corner is missing


def _judgements(scene: Scene, table: Table, value: Array, error: Array) -> Iterator[Judgement]:
    own = analytic.predictions(scene)
    base = analytic.predictions(replace(scene, theory=replace(scene.theory, gamma=GAMMA)))
    spectrum = scene.spectrum
    unit = analytic.conduction(scene).diffusivity * spectrum.q_roll_off  # type: ignore[union-attr]
    for name in dict.fromkeys(name for name, _ in table.quantities):
        columns = [k for k, (other, _) in enumerate(table.quantities) if other == name]
        peclet = np.array([table.quantities[k][1] for k in columns])
        for k, speed in enumerate(scene.speeds if len(columns) > 1 else (nan,)):
            if speed == 0.0:
                continue
            weights = np.ones(1) if isnan(speed) else _hats(log(abs(speed) / unit[k]), np.log(peclet))
            ratio = float(np.exp(weights @ np.log(value[columns])))
            off = float(own[name][k] / base[name][k]) / ratio
            yield Judgement(
                name, None if isnan(speed) else speed, 100 * (off - 1), 100 * off * float(weights @ error[columns])
            )


def _hats(x: float, nodes: Array) -> Array:
    """Return the weights of linear interpolation at `x`, constant beyond the ends."""
    return np.array([np.interp(x, nodes, row) for row in np.eye(nodes.size)])


def _words(table: Table, place: Array, label: str) -> str:
    named = ", ".join(f"{_WORDS[name]} {x:.3g}" for name, x in zip(table.coordinates, place, strict=True))
    return f"{label} ({named})" if label else named
