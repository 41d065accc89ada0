"""Rules that join several keys of a scene: what must stand together, and what excludes what.

A refusal is a ValueError whose text begins with a key of the section that is checked.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from roughsim.scene.messages import as_written
from roughsim.scene.records import quantity

SELF_AFFINE_KEYS = ("hurst", "q_min", "q_roll_off", "q_max", "roll_off_exponent")
SIZE_KEYS = ("rms_height", "rms_slope", "psd", "spectrum")  # one of them says how rough a face is
ROUGHNESS_KEYS = (*SIZE_KEYS, "psd_convention", "psd_source", *SELF_AFFINE_KEYS)
THERMAL_KEYS = ("conductivity", "density", "heat_capacity")
MAX_ROWS = 1200  # of all tables C(q) of a scene together: written inline they still fit into 64 KiB
WIDEST_BAND = 1e12  # q_max/q_min; a metre over the size of an atom is 1e10


def check_roughness(face: Any) -> Any:
    """Return a face; refuse one whose C(q) is not fixed by its keys, or fixed twice."""
    sizes = [key for key in SIZE_KEYS if getattr(face, key) is not None]
    if not sizes:
        raise ValueError("rms_height is missing; give exactly one of rms_height, rms_slope, psd_file and spectrum")
    if len(sizes) > 1:
        first, second = (key.replace("psd", "psd_file") for key in sizes[:2])
        raise ValueError(f"{first} and {second} are both given; keep exactly one")
    if sizes[0] in ("psd", "spectrum"):
        what = "psd_file, whose table fixes C(q)" if face.psd else "spectrum, which has keys of its own"
        for key in SELF_AFFINE_KEYS:
            if getattr(face, key) is not None:
                value = as_written(getattr(face, key), quantity(type(face), key).unit)
                raise ValueError(f"{key} = {value} does not go with {what}; remove it")
    if face.psd and face.psd_convention is None:
        raise ValueError(
            'psd_convention is missing; a table needs "persson" or "surfacetopography" (whose C is 4π² larger)'
        )
    for key in ("psd_convention", "psd_source"):
        if not face.psd and getattr(face, key) is not None:
            raise ValueError(f"{key} goes with psd_file only; remove it")
    if sizes[0] in ("rms_height", "rms_slope"):
        check_band(face)
    return face


def check_band(face: Any) -> None:
    """Refuse a self-affine C(q) whose wavenumbers are missing or out of order."""
    for key in ("hurst", "q_min", "q_max"):
        if getattr(face, key) is None:
            raise ValueError(f"{key} is missing; write for example {key} = {quantity(type(face), key).example}")
    q_min, q_max = f"q_min = {face.q_min:.6g} rad/m", f"q_max = {face.q_max:.6g} rad/m"
    if face.q_min >= face.q_max:
        raise ValueError(f"{q_min} must be below {q_max}; change one of the two")
    if face.q_max > WIDEST_BAND * face.q_min:
        raise ValueError(
            f"{q_max} must be at most {WIDEST_BAND:g} times {q_min}: beyond, integrals over the spectrum are lost in "
            "rounding; raise q_min or lower q_max"
        )
    if face.q_roll_off is not None and not face.q_min <= face.q_roll_off <= face.q_max:
        raise ValueError(
            f"q_roll_off = {face.q_roll_off:.6g} rad/m must lie between {q_min} and {q_max}; change it or leave it out"
        )
    if face.roll_off_exponent and face.q_roll_off is None:
        raise ValueError(
            f"roll_off_exponent = {face.roll_off_exponent:g} needs q_roll_off; add it or leave the exponent out"
        )


def check_counterface(counterface: Any) -> Any:
    """Return a counterface; refuse one that is empty, is like the body and not, or has half a material."""
    keys = [key for key in counterface.known_keys() if getattr(counterface, key, None) is not None]
    if not keys:
        raise ValueError('like is missing; write like = "body", give keys of its own, or leave the section out')
    if counterface.like and len(keys) > 1:
        other = next(key for key in keys if key != "like")
        raise ValueError(f'{other} does not go with like = "body", which fixes it; remove one of the two')
    if counterface.rough:
        check_roughness(counterface)
    for together in (("youngs_modulus", "poisson_ratio"), THERMAL_KEYS):
        missing = [key for key in together if key not in keys]
        if missing and len(missing) < len(together):
            others = ", ".join(key for key in together if key in keys)
            raise ValueError(f"{missing[0]} is missing beside {others}; give all of {', '.join(together)} or none")
    return counterface


def check_scene(scene: Any) -> None:
    """Refuse sections that do not go together."""
    load, hardness = scene.sliding.nominal_pressure, scene.penetration_hardness
    if load > hardness:
        softer = "body" if scene.body.penetration_hardness == hardness else "counterface"
        raise ValueError(
            f"sliding.nominal_pressure = {load:.6g} Pa exceeds {softer}.penetration_hardness = {hardness:.6g} Pa, "
            "which no contact can carry; lower the pressure or raise the hardness"
        )
    rule = scene.sliding.heat_partition
    if rule in ("mean", "total") and not scene.counterface_conducts:
        missing = "[counterface]" if scene.counterface is None else "counterface.conductivity"
        raise ValueError(
            f'sliding.heat_partition = "{rule}" shares the heat with a second body, but {missing} is missing; add it '
            '(like = "body" for the same material), or write "all" or a number'
        )
    check_background(scene)
    rows = sum(len(face.psd or ()) for face in (scene.surface, scene.counterface) if face is not None)
    if rows > MAX_ROWS:
        raise ValueError(
            f"counterface.psd and surface.psd together have {rows} rows, above the limit of {MAX_ROWS}; average C over "
            "bins of log q"
        )
    for number, level in enumerate(scene.numerics.levels or ()):
        if scene.elastic and level.column != "elastic":
            raise ValueError(
                f'numerics.levels[{number}].column = "{level.column}" needs a body.penetration_hardness; add it or '
                'write "elastic"'
            )


def check_background(scene: Any) -> None:
    """Refuse a background temperature that is missing, needed for nothing, or outside the tables κ(T)."""
    low, high = scene.temperature_range
    start = scene.sliding.background_temperature
    if start is None:
        if high < math.inf:
            raise ValueError(
                "sliding.background_temperature is missing; a conductivity that is a table over temperature needs it: "
                'add for example background_temperature = "300 K"'
            )
        return
    background = f"sliding.background_temperature = {start:g} K"
    if min(high, scene.melting_temperature) == math.inf:
        raise ValueError(
            f"{background} goes with a conductivity that is a table over temperature, or with a melting_temperature; "
            "remove it"
        )
    if not low <= start <= high:
        raise ValueError(
            f"{background} must lie between {low:g} K and {high:g} K, where the tables of conductivity are given; "
            "extend them"
        )


def check_derived(scene: Any, diffusivities: Iterable[tuple[float, ...]]) -> None:
    """Refuse lawful numbers whose products are not; `diffusivities` of each body, m²/s, at all its temperatures."""
    try:
        derived = [
            ("rms height", scene.spectrum.rms_height, "m"),
            ("rms slope", scene.spectrum.rms_slope, ""),
            ("effective modulus", scene.effective_modulus, "Pa"),
        ]
        for name, values in zip(("diffusivity", "diffusivity of the counterface"), diffusivities, strict=False):
            derived += [(name, value, "m²/s") for value in values]
    except (ArithmeticError, ValueError) as error:
        raise ValueError(f"surface or body: numbers beyond what can be computed with ({error}); check them") from None
    for name, value, unit in derived:
        if not 0.0 < value < math.inf:
            raise ValueError(f"surface or body: the {name} becomes {value:.6g} {unit}; check the numbers it is made of")
