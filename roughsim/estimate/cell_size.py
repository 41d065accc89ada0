"""The periodic cell: how long its sides are, and what its finite size changes.

What a cell leaves out cannot be told by a run in it. It was measured once, by doubling cells at equal pixel and cut-off
(`experiments/cell_size.py`). The theory's sum over the modes of a cell is within 0.6 % of its integral at four longest
waves, and tells nothing of it.
"""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.sections import CounterfaceSection, SurfaceSection

# relative error at 4 longest waves per side, or 8 of the roll-off where C(q) is flat below it
SIZE_ERROR = 0.004
# and where few spots carry the load: times (longest waves per side)² σ₀/σ_P; measured at σ₀/σ_P = .0008, .0025, .008
_FEW_SPOTS = {"smoothed": 0.0016, "capped": 0.0002}
_ENOUGH, _ENOUGH_FLAT, _MOST = 4.0, 8.0, 8.0


def choose_lengths(scene: Scene) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, that the scene gives or that are long enough, and why."""
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    longest = 2 * pi / scene.spectrum.breaks[0]
    waves, reason = _ENOUGH, ""
    if few := _share_of_spots(scene):  # as many as keep the judged column within SIZE_ERROR, where that is affordable
        waves = min(max(_ENOUGH, sqrt(_FEW_SPOTS["capped"] / SIZE_ERROR / few)), _MOST)
        reason = ": few spots carry the load" if waves > _ENOUGH else ""
    length, reason = waves * longest, f"{waves:.3g} longest waves (2π/q_min) per side" + reason
    plateau = _plateau_end(scene)
    if plateau is not None:
        wave = 2 * pi / plateau
        length = max(_ENOUGH_FLAT * wave, min(_ENOUGH * longest, 2 * _ENOUGH_FLAT * wave))
        reason = f"{length / wave:.3g} roll-off waves (2π/q_roll_off) per side: C(q) is flat below q_roll_off"
    lengths = (length, length)
    return lengths, f"{reason}; a larger cell changes T_flash by less than {100 * size_error(scene, lengths):.1g} %"


def size_error(
    scene: Scene, lengths: tuple[float, float], observable: str = "flash_temperature", column: str = ""
) -> float:
    """Return the relative error of the cell's size: as measured, 1/L² in cells shorter than needed, 1/L in longer ones.

    Under light load it is at least what few spots of contact change: each cell bears the same load, and means are too
    low by the inverse of the number of spots. NaN for the distance where g_σ first vanishes: that jumped by 40 % in a
    steel whose g_σ only touches zero.

    Parameters
    ----------
    scene : Scene
        What is computed.
    lengths : (float, float)
        Sides of the cell, m; the shorter one counts.
    observable : str, optional
        A key of `roughsim.observables.catalogue.UNITS`.
    column : {"smoothed", "capped", "elastic"}, optional
        Which contact; left out: capped where there is a hardness, else elastic.
    """
    if observable == "correlation_radius_0":
        return nan
    plateau = _plateau_end(scene)
    waves = min(lengths) * (scene.spectrum.breaks[0] if plateau is None else plateau) / (2 * pi)
    short = (_ENOUGH if plateau is None else _ENOUGH_FLAT) / waves
    few = _share_of_spots(scene)
    spots = _FEW_SPOTS.get(column or "capped", 0.0) / (few * waves**2) if few else 0.0
    return max(SIZE_ERROR * max(short, short**2), spots)


def _share_of_spots(scene: Scene) -> float:
    """σ₀/σ_P, the share of the area that yielding spots take; 0 of an elastic scene."""
    return scene.sliding.nominal_pressure / scene.penetration_hardness


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
