"""Errors of all observables by the error of a measured C(q), from the theory.

C(q) is changed by each error of its table, and the theory gives every observable with it; fewer waves count in one
direction of sliding than in all. Scans leave two errors: C(q) scatters, as a map holds few long waves, and waves longer
than the map are not in it. For a map whose lay drawn surfaces lack, or whose heights are not Gaussian, C(q) does not
suffice, and the error is unknown.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from roughsim.grid import Array
from roughsim.observables.catalogue import CAMERA, OBSERVABLES
from roughsim.prediction.bodies import conduction
from roughsim.prediction.theories import integrals, over_speed
from roughsim.prediction.values import Predicted
from roughsim.scene import Scene
from roughsim.scene.sections import SurfaceSection
from roughsim.scene.tables import directions_of

# q over the second row's: of the first rows, and of the rows above, whose exponent C(q) has at long waves too. A map
# shows too little of waves as long as itself, as its plane and the window remove a part: so much of the exponent
_FIRST, _ABOVE, _TAKEN = (0.0, 2.0), (2.0, 10.0), 2.7
_FIRST_SCATTER = 0.5  # of the exponent of the first rows, over their errors
_BELOW = 0.999  # of the first q: there the longer waves begin
_SETTLED = 0.5  # change by the second decade of longer waves over the change by the first: above, there is no limit
# probability that scans of one surface differ by more, which counts as a scatter from place to place
_LEVEL_OF_SIGNIFICANCE = 0.05
_FILLED = 3.0  # relative error of C over the share of points that were filled: measured where these are the valleys
_STEP = 0.1  # of ln C, by which each row is tried
_ANGLES = 720  # over half a turn
_NORMAL = 1.959964  # standard errors of a 95 % interval
_Changes = dict[str, Array]  # of the logarithm of every observable, over speeds or of one entry


@lru_cache(
    maxsize=64
)  # a theory for each row of the table of C(q): .1 s to seconds, for each mean of a run
def scan_error(scene: Scene, only: str = "") -> dict[str, Array]:
    """Return the relative 95 % error of every observable by the scans that C(q) was measured on.

    `only` is one name of `OVER_SPEED`, computed alone in a fiftieth of the time. The error is NaN without a value of
    the theory, for an unknown error of C(q), and for a map unlike surfaces drawn from its C(q). It is NaN too if C(q)
    rises, or within the error of its exponent may rise, so steeply towards the longest waves of the scans that longer
    ones change the value without limit.
    """
    squares = {name: np.zeros(values.shape) for name, values in _expected(scene, only).items()}
    for name, face in scene.scanned_faces.items():
        error = _error_of_face(scene, name, face, only)
        squares = {key: square + error[key] ** 2 for key, square in squares.items()}
    # the error is one of logarithms: a value that is too low lacks more than one that is too high has in excess
    return {key: np.expm1(np.sqrt(square)) for key, square in squares.items()}


def scan_of_hottest(scene: Scene) -> float | None:
    """Return the error of the highest T_flash by the scans of C(q), NaN if unknown; None where there are no scans."""
    if not scene.scanned:
        return None
    name = "flash_temperature"
    return float(scan_error(scene, name)[name][np.argmax(_expected(scene, name)[name])])


def unknown_by(scene: Scene) -> str:
    """Return in words why the error by the scans of C(q) is unknown, and what helps."""
    scanned = scene.scanned_faces
    if any(face.psd is None or face.psd_error is None for face in scanned.values()):
        return "psd_error is missing; give it, or the scan itself as topography"
    if not all(_alike(scene, name) for name in scanned):
        return "the map is not isotropic or not Gaussian; press the map"
    press = " press the map, or" if scene.textures else ""  # a line scan cannot be pressed
    return f"C(q) may rise without limit to waves longer than the scan;{press} take a larger scan"


def _alike(scene: Scene, name: str) -> bool:
    """Return whether the maps of a section are like surfaces that are drawn from their C(q⃗)."""
    drawn = bool(scene.directions) and scene.sections_of_faces[name].psd_directions is not None
    maps = scene.textures.get(name, ())
    return all((texture.isotropic or drawn) and texture.gaussian for texture in maps)


def _few_in_directions(scene: Scene, face: SurfaceSection) -> Array:
    """Return the error of each row in each direction at each speed over its error in all directions.

    A wave at φ from sliding counts in T_flash by M k, k = Re(1 − i cosφ v/Dq)^(−½): ⟨M²k²⟩/⟨Mk⟩² times fewer waves
    than those of a row with the same error. The error of a row has its scatter by M as well, which is left in, as M is
    measured on the same waves: 95 % of 120 errors hold in maps of 8 longest waves, γ 1.8 to 4, and 84 % without it.
    """
    if face.psd_directions is None or not scene.directions:
        return np.ones((1, 1))
    q, angle = np.array(face.psd)[:, :1, None], np.arange(_ANGLES) * (np.pi / _ANGLES)
    factor = directions_of(face.psd_directions)(q[:, 0], angle)[:, None]
    steep = np.array(scene.speeds) / conduction(scene).diffusivity
    turned = np.cos(angle - np.array(scene.headings)[:, None])
    counted = factor * (1 / np.sqrt(1 - 1j * (steep[:, None] * turned) / q)).real
    few = np.mean(counted**2, axis=2) / np.mean(counted, axis=2) ** 2
    return np.asarray(np.sqrt(few))


def _expected(scene: Scene, only: str) -> Mapping[str, Array]:
    """Return every observable by the theory, or one of `OVER_SPEED` alone."""
    if only:
        return over_speed(scene, np.array(scene.speeds), names=(only,))
    known = Predicted(integrals(scene), scene)
    return {name: known[name] for name in known if OBSERVABLES[name].asked != CAMERA}


def _error_of_face(scene: Scene, name: str, face: SurfaceSection, only: str) -> _Changes:
    """Return the error of the logarithms by the scans of one face, which stands in the section `name`."""
    own = _expected(scene, only)
    if face.psd is None or face.psd_error is None or not _alike(scene, name):
        return {key: np.full(values.shape, np.nan) for key, values in own.items()}
    few = _few_in_directions(scene, face)
    if few.size > 1:  # changes are those of an isotropic face, a hundred times as fast
        face = replace(face, psd_directions=None)
        plain: dict[str, Any] = {name: face}
        scene = replace(scene, **plain)
        own = _expected(scene, only)
    q, psd = np.array(face.psd).T
    errors = np.array(face.psd_error)

    def change(at: Array, values: Array) -> _Changes:
        """Return the change of ln of every observable by another table."""
        rows = tuple(zip(at.tolist(), values.tolist(), strict=True))
        changed: dict[str, Any] = {name: replace(face, psd=rows, psd_error=None)}
        found = _expected(replace(scene, **changed), only)
        with np.errstate(all="ignore"):  # 0/0 at rest
            return {
                key: np.where(own[key] == 0.0, 0.0, np.log(found[key] / own[key])) for key in own
            }

    # the rows scatter one by one, by so much that only small steps show how much the value follows each
    each = [change(q, psd * np.exp(_STEP * row)) for row in np.eye(q.size)]
    # overlapping scans may differ by more, from place to place
    scans = [change(q, psd * (1.0 + column)) for column in errors.T[1:]]
    shared = np.any(errors[:, 1:] != 0.0, axis=1)
    missing = _missing_waves(change, q, psd, errors[:, 0])
    filled = change(q, psd * (1.0 + _FILLED * face.psd_filled)) if face.psd_filled else {}
    result = {}
    for key in own:
        by_row = np.array([one[key] for one in each]) * errors[:, :1] / _STEP
        if few.size > 1 and OBSERVABLES[key].per_speed:
            by_row = np.tile(by_row, few.shape[1] // by_row.shape[1]) * few
        square = _NORMAL**2 * np.sum(by_row**2, axis=0)
        if scans:
            square += _square_between(by_row[shared], np.array([one[key] for one in scans]))
        # missing waves change the value one way: this is no scatter, and adds to it
        others = missing[key] + np.abs(filled.get(key, 0.0))
        result[key] = np.sqrt(square) + np.tile(others, square.size // others.size)
    return result


def _square_between(by_row: Array, by_scan: Array) -> Array:
    """Return the square of the error by differences of scans beyond the scatter of their rows, shape (speeds,)."""
    freedom = len(by_scan) - 1
    within, between = np.sum(by_row**2, axis=0), np.sum(by_scan**2, axis=0)
    shown = between > within * scipy.special.chdtri(freedom, _LEVEL_OF_SIGNIFICANCE) / freedom
    quantile = float(scipy.special.stdtrit(freedom, 0.975))
    return np.asarray(np.where(shown, quantile**2 * (between - within), 0.0))


def _missing_waves(
    change: Callable[[Array, Array], _Changes], q: Array, psd: Array, error: Array
) -> _Changes:
    """Return the change of every observable by waves longer than the scans; NaN without a limit.

    There is a limit only if C(q) may also be steeper by the scatter of its rows: rows that scatter low would have one
    by chance.
    """
    waves = long_waves(q, psd, error)

    def limits(exponent: float) -> _Changes:
        one, two = (
            change(*_continued(q, psd, exponent, waves.begin, decades)) for decades in (1, 2)
        )
        return {key: _limit_of(one[key], two[key]) for key in one}

    missing, possible = limits(waves.exponent), limits(waves.exponent + waves.error)
    return {key: np.where(np.isnan(possible[key]), np.nan, missing[key]) for key in missing}


class LongWaves(NamedTuple):
    """How C(q) goes on to waves longer than the scans."""

    exponent: float
    error: float  # standard error of the exponent
    begin: float  # C just below the first row, at the start of the power law, m⁴


def long_waves(q: Array, psd: Array, error: Array) -> LongWaves:
    """Return the power law of the rows above the first ones, unless C(q) ends at the first ones."""

    def power_law(low: float, high: float) -> tuple[float, float, float]:
        """Exponent, its standard error, and the value at the first row."""
        rows = (q >= q[1] * low * (1 - 1e-9)) & (q <= q[1] * high * (1 + 1e-9))
        if np.count_nonzero(rows) < 2:  # a table of few rows
            rows = q <= q[1]
        weight, x = 1.0 / np.maximum(error[rows], 1e-6), np.log(q[rows])
        (slope, level), covariance = np.polyfit(x, np.log(psd[rows]), 1, w=weight, cov="unscaled")
        return (
            -float(slope),
            float(np.sqrt(covariance[0, 0])),
            float(np.exp(level + slope * np.log(q[0]))),
        )

    (exponent, scatter, law), (at_first, scatter_of_first, _) = (
        power_law(*_ABOVE),
        power_law(*_FIRST),
    )
    if at_first + _TAKEN < exponent:
        return LongWaves(at_first + _TAKEN, _FIRST_SCATTER * scatter_of_first, float(psd[0]))
    # the plane and the window have taken of the first row: the law of those above begins higher
    return LongWaves(exponent, scatter, max(float(psd[0]), law))


def _continued(
    q: Array, psd: Array, exponent: float, begin: float, decades: int
) -> tuple[Array, Array]:
    """Return a table with so many decades of longer waves, over which C(q) goes on as a power law from `begin`, m⁴."""
    factor = 10.0**decades
    rise = factor ** max(exponent, 0.0)
    return np.concatenate([[q[0] / factor, q[0] * _BELOW], q]), np.concatenate(
        [[begin * rise, begin], psd]
    )


def _limit_of(first: Array, second: Array) -> Array:
    """Return the limit of the change by longer waves, from the changes by one and two decades of them; NaN without one.

    Each further decade changes the value by the same part of the change by the decade before.
    """
    part = np.divide(second - first, first, out=np.zeros_like(first), where=np.abs(first) > 1e-6)
    part = np.where(np.abs(part) > _SETTLED, np.nan, part)
    return np.asarray(np.abs(first / (1.0 - part)))
