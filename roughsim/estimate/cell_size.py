"""The periodic cell: the length of its sides, and the error of its finite size.

Each cell bears the same load, while in an infinite plane the load gathers on high hills. So a small cell has too low a
T_flash. Its relative error falls with the number N of hills, whose size follows from the autocorrelation ρ of the
heights after yielding:

    error = (a/A + b) / N,    N = L²/∫(ρ + ρ²)d²r

The share A of hills that carry load equals the contact fraction of waves down to half a hill. The constants were
measured on scenes made by hand, in cells of 2 to 16 waves, and tested on scenes drawn at random
(`experiments/cell_size.py`). Neither a run nor the theory shows the error of its cell: the theory summed over the modes
of a cell with four longest waves per side is within 0.6 % of its integral.
"""

from functools import lru_cache
from math import inf, nan, pi, sqrt

import numpy as np

from roughsim import prediction
from roughsim.grid import Array
from roughsim.scene import Scene

# relative error × number of hills, by the same experiment: times A if few hills carry load (T_flash at low speed; half
# of it at high speed and for other observables), and if all hills carry load
_FEW_HILLS, _ALL_HILLS = 0.03, 0.2
# relative error of T_flash of capped contact in a part of the cell, at most: in smaller ones corrections scatter so
# much that the doubt of the last step adds levels
_PART_ERROR = 0.05
SIZE_SHARE = 0.2  # of a squared target error, for the size of the cell
_WAVES = range(4, 33, 2)  # per side of a cell: pictures and g_σ(r) need four, and grids hold no more than 32


def choose_lengths(scene: Scene, target: float = inf) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, given in the scene or the shortest that suffice, and the reason.

    The squared error of the cell is at most `SIZE_SHARE` of the squared relative error `target`, as far as `_WAVES`
    allow. If C(q) is flat below a roll-off, a side holds at least 8 roll-off waves, or 4 of the longest waves: on rocks
    shorter sides left an error of .7 %.
    """
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    flat = _plateau_end(scene)
    wave = 2 * pi / (flat or scene.spectrum.breaks[0])
    kind = "roll-off waves (2π/q_roll_off), as C(q) is flat below q_roll_off," if flat else "longest waves (2π/q_min)"
    least = min(8.0, 4.0 * flat / scene.spectrum.breaks[0]) if flat else 4.0
    choices = [n for n in _WAVES if n >= 0.99 * least]
    waves = next((n for n in choices if _worst(scene, n * wave) <= sqrt(SIZE_SHARE) * target), _WAVES[-1])
    why = ", as in fewer too few hills carry the load" if waves > choices[0] else ""
    reason = f"{waves} {kind} per side{why}; a larger cell changes T_flash by {100 * _worst(scene, waves * wave):.1g} %"
    return (waves * wave, waves * wave), reason


def _worst(scene: Scene, side: float) -> float:
    """Return the largest relative error of T_flash in a cell of this side, m, over speeds."""
    return float(np.max(size_error(scene, (side, side))))


def parts_of(scene: Scene, lengths: tuple[float, float], target: float = inf) -> int:
    """Return the ratio of these sides, m, to the sides of a smaller cell for corrections: 4, 2, or 1 for no such cell.

    The relative error of elastic T_flash in the smaller cell is at most `target`; corrections err by half of it.
    """
    most = target if scene.elastic else _PART_ERROR
    return next((parts for parts in (4, 2) if _worst(scene, min(lengths) / parts) <= most), 1)


def _correction_error(error: Array | float, elastic: bool) -> Array | float:
    """Return the relative error of a ratio of means from the relative error of the means.

    It is the square. In elastic contact ratios of T_flash erred by a third of the error itself: half is charged.
    """
    return 0.5 * error if elastic else error**2


def size_error(
    scene: Scene, lengths: tuple[float, float], observable: str = "flash_temperature", column: str = ""
) -> Array:
    """Return the relative error of a mean in a cell whose shorter side, m, counts.

    Shape (speeds,) for T_flash, else one number. Default column: capped or elastic. NaN for the first zero of g_σ: it
    jumped by 40 % in a steel whose g_σ only touches zero.
    """
    if observable == "correlation_radius_0":
        return np.array(nan)
    hill, carrying = _hills(scene, min(lengths))
    if hill == 0.0:
        return np.zeros(len(scene.speeds) if observable == "flash_temperature" else ())
    slow = np.array(observable == "correlation_radius_10", dtype=np.float64)
    if observable == "flash_temperature":
        peclet = np.abs(scene.speeds) * sqrt(hill) / (2 * prediction.conduction(scene).diffusivity)
        slow = 1.0 / (1.0 + peclet)
    if scene.elastic or column == "smoothed":  # elastic contact errs as if on fewer hills, as was measured
        carrying *= 0.4
    error = (_FEW_HILLS * (1.0 + slow) / 2.0 / carrying + _ALL_HILLS) * hill / min(lengths) ** 2
    return np.asarray(error / (1.0 + error))


@lru_cache(maxsize=32)  # 3 ms for each observable in each column of a comparison, .4 s in all
def _hills(scene: Scene, side: float) -> tuple[float, float]:
    """Return `hill_area`, m², and the share of the area in contact with waves up to half a hill; 0 if all yields."""
    area = hill_area(scene, side)
    if area == 0.0:
        return 0.0, 0.0
    return area, prediction.area_fractions(scene, 4 * pi / sqrt(area))["contact_fraction"]


def hill_area(scene: Scene, side: float) -> float:
    """Return ∫(ρ + ρ²)d²r, m², of the autocorrelation ρ of the smoothed heights.

    ∫ρ d²r is (2π)² C/⟨h²⟩ at the longest wave of a cell of this side, m; zero if the side exceeds all waves of C(q).
    """
    spectrum = prediction.smoothed_spectrum(scene)
    q = np.geomspace(spectrum.breaks[0] * (1 + 1e-12), spectrum.breaks[-1] * (1 - 1e-12), 1001)
    psd = spectrum(q)
    variance = np.trapezoid(psd * q**2, np.log(q))
    if variance == 0.0:  # all of it yields
        return 0.0
    second = np.trapezoid(psd**2 * q**2, np.log(q)) / variance
    longer = spectrum(np.array(2 * pi / side * (1 - 1e-9)))  # a side as long as the longest wave has all waves
    return float(2 * pi * (longer + second) / variance)


def size_error_of_sum(
    scene: Scene, lengths: tuple[float, float], parts: int, observable: str, column: str, from_part: Array | float
) -> Array:
    """Return the relative error by the finite cell of a mean whose share `from_part` comes from a smaller cell.

    The sides of the smaller cell are `lengths`, m, over `parts`. The error has the shape of the share.
    """
    whole = size_error(scene, lengths, observable, column)
    part = size_error(scene, (lengths[0] / parts, lengths[1] / parts), observable, column)
    if scene.elastic or column == "smoothed":  # whatever share of the mean these corrections are
        return np.hypot(whole, np.where(np.greater(from_part, 0.0), _correction_error(part, elastic=True), 0.0))
    return np.hypot(whole, from_part * _correction_error(part, elastic=False))


def _plateau_end(scene: Scene) -> float | None:
    """Return q_roll_off if each rough face is flat (m < 1) below it, else None."""
    ends = []
    for face in (scene.surface, scene.counterface if scene.counterface and scene.counterface.rough else None):
        if face is None:
            continue
        kink, flat = face.q_roll_off, (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)
