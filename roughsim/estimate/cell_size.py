"""The periodic cell: the length of its sides, and the error of its finite size.

A run cannot show the error of its own cell. It was measured once, by doubling cells at equal pixel and cut-off
(`experiments/cell_size.py`). The theory cannot show it either: summed over the modes of a cell with four longest waves
per side it is within 0.6 % of its integral.
"""

from math import inf, nan, pi, sqrt

import numpy as np

from roughsim import prediction
from roughsim.estimate.ladder import SAME
from roughsim.grid import Array
from roughsim.scene import Scene

# relative error at 4 longest waves per side, or 8 of the roll-off where C(q) is flat below it; and of capped contact
# where C(q) has no plateau, but for r(g = 0.1)
SIZE_ERROR, CAPPED_SIZE_ERROR = 0.004, 0.002
ENOUGH_WAVES, ENOUGH_ROLL_OFF_WAVES, MOST_WAVES = 4.0, 8.0, 8.0
# relative error × (longest waves per side)² σ₀/σ_P where few spots carry the load; measured at σ₀/σ_P = .0008 … .008
FEW_SPOTS = {"smoothed": 0.0016, "capped": 0.0002}
# relative error of what finer levels add in half such a cell, and × its number of spots where few carry the load;
# measured by `experiments/half_cell.py`; of elastic contact, which plans leave in the run's cell, 4.4 % of an area and
# 8.7 % of a T_flash were seen
STEP_ERROR, FEW_SPOTS_OF_STEP, ELASTIC_STEP_ERROR = 0.004, 0.016, 0.09
LEAST_SPOTS = 0.4  # in a part of the cell: half a spot was measured, and no fewer
SIZE_SHARE = 0.45  # of a target error that the size may take before the cell has twice the sides


def choose_lengths(scene: Scene, target: float = inf) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, and the reason: those that the scene gives, or the shortest that suffice.

    They have twice that length where the error of the size would take too much of the relative error `target`.
    """
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    length, wave, kind = enough_length(scene)
    times, why = 1, ""
    if length > (1 + SAME) * ENOUGH_WAVES * wave and plateau_end(scene) is None:
        why = ": few spots carry the load"
    if size_error(scene, (length, length)) > SIZE_SHARE * target:
        times, why = 2, f"{why}: half of them would leave too much of the target to the size"
    lengths = (times * length, times * length)
    reason = f"{lengths[0] / wave:.3g} {kind} per side{why}"
    return lengths, f"{reason}; a larger cell changes T_flash by less than {100 * size_error(scene, lengths):.1g} %"


def enough_length(scene: Scene) -> tuple[float, float, str]:
    """Return the length of the sides that suffice for most targets, m, the wave that counts, m, and what it is."""
    longest = 2 * pi / scene.spectrum.breaks[0]
    roll_off = plateau_end(scene)
    if roll_off is not None:
        wave = 2 * pi / roll_off
        enough = ENOUGH_ROLL_OFF_WAVES * wave
        kind = "roll-off waves (2π/q_roll_off), as C(q) is flat below q_roll_off,"
        return max(enough, min(ENOUGH_WAVES * longest, 2 * enough)), wave, kind
    waves = ENOUGH_WAVES
    if spots := share_of_spots(scene):  # so many waves keep the capped column within SIZE_ERROR; at most MOST_WAVES
        waves = min(max(ENOUGH_WAVES, sqrt(FEW_SPOTS["capped"] / SIZE_ERROR / spots)), MOST_WAVES)
    return waves * longest, longest, "longest waves (2π/q_min)"


def parts_of(scene: Scene, lengths: tuple[float, float]) -> int:
    """Return how many sides of a cell for corrections of capped contact make one of these sides, m: 4, 2, or 1.

    1: there is no such cell. It has half the sides that suffice for most targets, at least. Few spots may not make more
    than `SIZE_ERROR` in the run's cell, and the smaller one has `LEAST_SPOTS`.
    """
    fit = min(lengths) / enough_length(scene)[0] * (1 + SAME)
    if scene.elastic or few_spots(scene, lengths, "capped") > SIZE_ERROR * (1 + SAME):
        return 1
    fits = (p for p in (4, 2) if fit >= p / 2 and spots_in(scene, min(lengths) / p) >= LEAST_SPOTS)
    return next(fits, 1)


def size_error(
    scene: Scene, lengths: tuple[float, float], observable: str = "flash_temperature", column: str = ""
) -> float:
    """Return the relative error of the cell's size, which falls as 1/L² up to the length that suffices, then as 1/L.

    `lengths` are the sides, m, of which the shorter one counts; `column` left out is the capped or the elastic one.
    Under light load the error is at least what few spots of contact change: each cell bears the same load, and means
    are too low by the inverse of the number of spots. NaN for the distance where g_σ first vanishes: that jumped by
    40 % in a steel whose g_σ only touches zero.
    """
    if observable == "correlation_radius_0":
        return nan
    capped = column in ("", "capped") and not scene.elastic and observable != "correlation_radius_10"
    enough = CAPPED_SIZE_ERROR if capped and plateau_end(scene) is None else SIZE_ERROR
    return max(enough * shortness(scene, lengths), few_spots(scene, lengths, column or "capped"))


def shortness(scene: Scene, lengths: tuple[float, float]) -> float:
    """Return the error of the size over that of the length that suffices for C(q); the shorter side, m, counts."""
    enough = ENOUGH_WAVES if plateau_end(scene) is None else ENOUGH_ROLL_OFF_WAVES
    short = enough / waves_per_side(scene, lengths)
    return max(short, short**2)


def few_spots(scene: Scene, lengths: tuple[float, float], column: str) -> float:
    """Return the relative error of means over few spots of contact; 0 where these have no size of their own."""
    spots = share_of_spots(scene)
    return FEW_SPOTS.get(column, 0.0) / (spots * waves_per_side(scene, lengths) ** 2) if spots else 0.0


def waves_per_side(scene: Scene, lengths: tuple[float, float]) -> float:
    """Return how many waves fit the shorter side, m: the longest ones, or those of the roll-off under a plateau."""
    roll_off = plateau_end(scene)
    return min(lengths) * (scene.spectrum.breaks[0] if roll_off is None else roll_off) / (2 * pi)


def size_error_of_sum(
    scene: Scene, lengths: tuple[float, float], parts: int, observable: str, column: str, from_part: Array | float
) -> Array:
    """Return the relative error of the cell's size where a share `from_part` of a mean comes from a part of the cell.

    Its sides are those of the cell, m, over `parts`. The error is an array of the shape of that share.
    """
    whole = size_error(scene, lengths, observable, column)
    of_part = step_error(scene, min(lengths) / parts, column) if np.any(from_part) else 0.0
    return np.hypot(whole, np.multiply(from_part, of_part))


def step_error(scene: Scene, side: float, column: str = "") -> float:
    """Return the relative error of what finer levels add in a part of the cell of this side, m; `column` as above.

    Those of capped contact count in ratios, which depend less on the cell than means do.
    """
    short = shortness(scene, (2 * side, 2 * side))
    if scene.elastic or column not in ("", "capped"):
        return ELASTIC_STEP_ERROR * short
    return max(STEP_ERROR * short, FEW_SPOTS_OF_STEP / spots_in(scene, side))


def spots_in(scene: Scene, side: float) -> float:
    """Return how many spots of contact that yields a cell of this side, m, has.

    A spot is as large as the shortest wave that the contact has not yielded at.
    """
    return share_of_spots(scene) * (side * prediction.yield_wavenumber(scene) / (2 * pi)) ** 2


def share_of_spots(scene: Scene) -> float:
    """Return σ₀/σ_P, the share of the area that yielding spots take; 0 of an elastic scene."""
    return scene.sliding.nominal_pressure / scene.penetration_hardness


def plateau_end(scene: Scene) -> float | None:
    """Return q_roll_off where every rough face is flat (m < 1) below it, else None."""
    ends = []
    for face in (scene.surface, scene.counterface if scene.counterface and scene.counterface.rough else None):
        if face is None:
            continue
        kink, flat = face.q_roll_off, (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)
