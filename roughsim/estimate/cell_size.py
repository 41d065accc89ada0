"""The periodic cell: the length of its sides, and the error of its finite size.

A run cannot show the error of its own cell. It was measured once, by doubling cells at equal pixel and cut-off
(`experiments/cell_size.py`). The theory cannot show it either: summed over the modes of a cell with four longest waves
per side it is within 0.6 % of its integral.
"""

from math import nan, pi, sqrt

import numpy as np

from roughsim import prediction
from roughsim.grid import Array
from roughsim.scene import Scene

# relative error at 4 longest waves per side, or 8 of the roll-off where C(q) is flat below it
SIZE_ERROR = 0.004
ENOUGH_WAVES, ENOUGH_ROLL_OFF_WAVES, MOST_WAVES = 4.0, 8.0, 8.0
# relative error × (longest waves per side)² σ₀/σ_P where few spots carry the load; measured at σ₀/σ_P = .0008 … .008
FEW_SPOTS = {"smoothed": 0.0016, "capped": 0.0002}
# relative error of what finer levels add in half such a cell, and × its number of spots where few carry the load;
# measured by `experiments/half_cell.py`
STEP_ERROR, FEW_SPOTS_OF_STEP = 0.008, 0.016


def choose_lengths(scene: Scene) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, and the reason: those that the scene gives, or the shortest that suffice."""
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    longest = 2 * pi / scene.spectrum.breaks[0]
    roll_off = plateau_end(scene)
    if roll_off is not None:
        wave = 2 * pi / roll_off
        enough = ENOUGH_ROLL_OFF_WAVES * wave
        length = max(enough, min(ENOUGH_WAVES * longest, 2 * enough))
        reason = f"{length / wave:.3g} roll-off waves (2π/q_roll_off) per side: C(q) is flat below q_roll_off"
    else:
        waves, why = ENOUGH_WAVES, ""
        if spots := share_of_spots(scene):  # so many waves keep the capped column within SIZE_ERROR; at most MOST_WAVES
            waves = min(max(ENOUGH_WAVES, sqrt(FEW_SPOTS["capped"] / SIZE_ERROR / spots)), MOST_WAVES)
            why = ": few spots carry the load" if waves > ENOUGH_WAVES else ""
        length, reason = waves * longest, f"{waves:.3g} longest waves (2π/q_min) per side" + why
    lengths = (length, length)
    return lengths, f"{reason}; a larger cell changes T_flash by less than {100 * size_error(scene, lengths):.1g} %"


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
    roll_off = plateau_end(scene)
    waves = min(lengths) * (scene.spectrum.breaks[0] if roll_off is None else roll_off) / (2 * pi)
    short = (ENOUGH_WAVES if roll_off is None else ENOUGH_ROLL_OFF_WAVES) / waves
    spots = share_of_spots(scene)
    few = FEW_SPOTS.get(column or "capped", 0.0) / (spots * waves**2) if spots else 0.0
    return max(SIZE_ERROR * max(short, short**2), few)


def size_error_of_sum(
    scene: Scene, lengths: tuple[float, float], observable: str, column: str, from_half: Array | float
) -> Array:
    """Return the relative error of the cell's size where a share `from_half` of a mean comes from half the cell.

    It is an array of the shape of that share.
    """
    whole = size_error(scene, lengths, observable, column)
    return np.hypot(whole, np.multiply(from_half, step_error(scene, lengths) if np.any(from_half) else 0.0))


def step_error(scene: Scene, lengths: tuple[float, float]) -> float:
    """Return the relative error of what finer levels of capped contact add in half the cell of these sides, m.

    They count in ratios, which depend less on the cell than means do. A spot is as large as the shortest wave that the
    contact has not yielded at.
    """
    spots = share_of_spots(scene) * (min(lengths) / 2 * prediction.yield_wavenumber(scene) / (2 * pi)) ** 2
    return max(STEP_ERROR * (size_error(scene, lengths) / SIZE_ERROR), FEW_SPOTS_OF_STEP / spots)


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
