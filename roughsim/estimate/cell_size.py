"""The periodic cell: the length of its sides, and the error of its finite size.

Each cell bears the same load, while in an infinite plane the load gathers where hills are high. So a small cell has too
low a T_flash. Its relative error is that of the number of hills which carry load, with hills as large as the
autocorrelation ρ of the heights:

    error = (a/A + b) / N,    N = L²/∫(ρ + ρ²)d²r

over what yielding leaves of the waves. The share A of the hills that carry load is that of the area in contact. It was
measured on scenes drawn at random, in cells of 2 to 16 waves (`experiments/cell_size.py`). A run cannot show the error
of its own cell, nor can the theory: summed over the modes of a cell with four longest waves per side it is within 0.6 %
of its integral.
"""

from functools import lru_cache
from math import inf, nan, pi

import numpy as np

from roughsim import prediction
from roughsim.grid import Array
from roughsim.scene import Scene

# relative error × N of hills that carry load: of T_flash at rest, and of fast sliding and all else
SLOW_LOAD, FAST_LOAD = 0.03, 0.015
YIELDED, ELASTIC = 0.1, 0.3  # relative error × N where all hills carry load
OF_CORRECTION = 2.0  # relative error of what finer levels add in a smaller cell, over that of a mean there, squared
PART_ERROR, PART_HILLS = 0.1, 10  # of a cell for corrections: the largest relative error of a mean, the least hills
SIZE_SHARE = 0.45  # of a target error that the size may take
LEAST_WAVES, MOST_WAVES = 4, 32  # per side of a chosen cell: pictures and g_σ(r) need some, grids hold no more


def choose_lengths(scene: Scene, target: float = inf) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, and the reason: those that the scene gives, or the shortest that suffice.

    The size takes at most `SIZE_SHARE` of the relative error `target`, as far as `MOST_WAVES` allow.
    """
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    flat = plateau_end(scene)
    wave = 2 * pi / (flat or scene.spectrum.breaks[0])
    kind = "roll-off waves (2π/q_roll_off), as C(q) is flat below q_roll_off," if flat else "longest waves (2π/q_min)"
    waves, error = LEAST_WAVES, worst(scene, LEAST_WAVES * wave)
    while error > SIZE_SHARE * target and waves < MOST_WAVES:
        waves += 2
        error = worst(scene, waves * wave)
    why = ", as in fewer the load would have too few hills" if waves > LEAST_WAVES else ""
    reason = f"{waves} {kind} per side{why}; the size changes T_flash by {100 * error:.1g} %"
    return (waves * wave, waves * wave), reason


def worst(scene: Scene, side: float) -> float:
    """Return the largest relative error of T_flash in a cell of this side, m, over speeds."""
    return float(np.max(size_error(scene, (side, side))))


def parts_of(scene: Scene, lengths: tuple[float, float]) -> int:
    """Return how many sides of a cell for corrections make one of these sides, m: 4, 2, or 1."""
    if scene.elastic:
        return 1
    for parts in (4, 2):
        side = min(lengths) / parts
        if worst(scene, side) <= PART_ERROR and side**2 >= PART_HILLS * hill_area(scene, side):
            return parts
    return 1


def size_error(
    scene: Scene, lengths: tuple[float, float], observable: str = "flash_temperature", column: str = ""
) -> Array:
    """Return the relative error of a mean in a cell of these sides, m, of which the shorter one counts.

    Of shape (speeds,) for T_flash, else one number. `column` left out is the capped or the elastic one. NaN for the
    distance where g_σ first vanishes: that jumped by 40 % in a steel whose g_σ only touches zero.
    """
    if observable == "correlation_radius_0":
        return np.array(nan)
    hill = hill_area(scene, min(lengths))
    few = np.array(SLOW_LOAD if observable == "correlation_radius_10" else FAST_LOAD)
    if observable == "flash_temperature":
        peclet = np.abs(scene.speeds) * np.sqrt(hill) / (2 * prediction.conduction(scene).diffusivity)
        few = FAST_LOAD + (SLOW_LOAD - FAST_LOAD) / (1.0 + peclet)
    carrying = prediction.area_fractions(scene)["contact_fraction"]
    if column == "smoothed":  # touches on fewer hills: measured
        carrying /= 2.0
    many = ELASTIC if scene.elastic or column == "smoothed" else YIELDED
    error = (few / carrying + many) * hill / min(lengths) ** 2
    return np.asarray(error / (1.0 + error))


@lru_cache(maxsize=32)
def hill_area(scene: Scene, side: float) -> float:
    """Return ∫(ρ + ρ²)d²r of the smoothed heights, m², with their autocorrelation ρ.

    ∫ρ d²r is (2π)² C/⟨h²⟩ at the longest wave of the cell of this side, m: 0 where that is longer than all of C(q).
    """
    spectrum = prediction.smoothed_spectrum(scene)
    q = np.geomspace(spectrum.breaks[0] * (1 + 1e-12), spectrum.breaks[-1] * (1 - 1e-12), 1001)
    psd = spectrum(q)
    variance = np.trapezoid(psd * q**2, np.log(q))
    second = np.trapezoid(psd**2 * q**2, np.log(q)) / variance
    return float(2 * pi * (spectrum(np.array(2 * pi / side)) + second) / variance)


def size_error_of_sum(
    scene: Scene, lengths: tuple[float, float], parts: int, observable: str, column: str, from_part: Array | float
) -> Array:
    """Return the relative error of the cell's size where a share `from_part` of a mean comes from a part of the cell.

    Its sides are those of the cell, m, over `parts`. The error is an array of the shape of that share.
    """
    whole = size_error(scene, lengths, observable, column)
    part = size_error(scene, (lengths[0] / parts, lengths[1] / parts), observable, column)
    return np.hypot(whole, np.multiply(from_part, OF_CORRECTION * part**2))


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
