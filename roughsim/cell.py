"""The periodic cell: how long its sides are, and what its finite size changes.

What a cell leaves out cannot be told by a run in it. It was measured once, by doubling cells at equal pixel and cut-off
(`experiments/cell_size.py`). The theory's sum over the modes of a cell is within 0.3 % of its integral at four longest
waves, and tells nothing of it.
"""

from __future__ import annotations

from math import nan, pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.sections import CounterfaceSection, SurfaceSection

# relative error at 4 longest waves per side, or 8 of the roll-off where C(q) is flat below it
SIZE_ERROR = 0.004
_ENOUGH, _ENOUGH_FLAT = 4.0, 8.0


def choose_lengths(scene: Scene) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, that the scene gives or that are long enough, and why."""
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    longest = 2 * pi / scene.spectrum.breaks[0]
    length, reason = _ENOUGH * longest, "4 longest waves (2π/q_min) per side"
    plateau = _plateau_end(scene)
    if plateau is not None:
        wave = 2 * pi / plateau
        length = max(_ENOUGH_FLAT * wave, min(_ENOUGH * longest, 2 * _ENOUGH_FLAT * wave))
        reason = f"{length / wave:.3g} roll-off waves (2π/q_roll_off) per side: C(q) is flat below q_roll_off"
    lengths = (length, length)
    return lengths, f"{reason}; a larger cell changes T_flash by less than {100 * size_error(scene, lengths):.1g} %"


def size_error(scene: Scene, lengths: tuple[float, float], observable: str = "flash_temperature") -> float:
    """Return the relative error of the cell's size: as measured, 1/L² in cells shorter than needed, 1/L in longer ones.

    NaN for the distance where g_σ first vanishes: that jumped by 40 % in a steel whose g_σ only touches zero.

    Parameters
    ----------
    scene : Scene
        What is computed.
    lengths : (float, float)
        Sides of the cell, m; the shorter one counts.
    observable : str, optional
        A key of `roughsim.means.UNITS`.
    """
    if observable == "correlation_radius_0":
        return nan
    plateau = _plateau_end(scene)
    waves = min(lengths) * (scene.spectrum.breaks[0] if plateau is None else plateau) / (2 * pi)
    short = (_ENOUGH if plateau is None else _ENOUGH_FLAT) / waves
    return SIZE_ERROR * max(short, short**2)


def _plateau_end(scene: Scene) -> float | None:
    """q_roll_off where every rough face is flat (m < 1) below it, else None."""
    faces: list[SurfaceSection | CounterfaceSection] = [scene.surface]
    if scene.counterface is not None and scene.counterface.rough:
        faces.append(scene.counterface)
    ends = []
    for face in faces:
        kink, flat = face.q_roll_off, (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)


__all__ = ["SIZE_ERROR", "choose_lengths", "size_error"]
