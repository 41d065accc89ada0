"""Friction, conductivity and diffusivity at each speed, how the bodies share the heat, and arguments of the theory.

Where a friction coefficient or a conductivity is a table over temperature, one constant replaces it at each speed. It
comes from the theory over the whole spectrum. So it is known before a run, and it is the same for theory and
simulation: it does not disturb their ratio.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

import theory
from roughsim.grid import Array
from roughsim.prediction.law import calibrated
from roughsim.prediction.lay import in_directions
from roughsim.prediction.shares import AT_REST, FLASH, heat_arguments, share_of, warming_lengths
from roughsim.prediction.stress import (
    headings_at,
    smoothed_spectrum,
    stress_arguments,
    stress_of_lay,
)
from roughsim.scene import Scene, SceneError
from roughsim.scene.bodies import Conduction
from roughsim.surface.spectrum import Spectrum
from theory.lay import LayStress
from theory.roots import root

if TYPE_CHECKING:  # slow to import
    from roughsim.observables.moments import HeatSource

_STEPS = 64  # from the background to the end of the tables, in which the temperature of the contact is looked for


class Heating(NamedTuple):
    """What turns sliding at one speed into heat and temperature: μ, and κ and D of both bodies."""

    friction_coefficient: float
    bodies: Conduction


class Conductions(NamedTuple):
    """κ, W/(m K), and D, m²/s, of both bodies as arrays (speeds,); NaN for an insulating counterface."""

    each: tuple[Conduction, ...]  # the same as a record for each speed
    conductivity: Array
    diffusivity: Array
    counter_conductivity: Array
    counter_diffusivity: Array


def conduction(scene: Scene, speeds: ArrayLike | None = None) -> Conductions:
    """Return the constants κ and D of the bodies of a scene at each speed, the same for all columns.

    Where a κ is a table they are its values at the background temperature + T₀(t) + 0.75 s T_flash, with the share s of
    the scene, and T_flash of the theory over the whole spectrum; of faces with a lay by the calibrated law where it
    holds, in each direction. T₀(t) is the warming of the moving body, as `background`. Both bodies are taken at this
    temperature of their contact.

    The speeds, m/s, ≥ 0, are by default the speeds of the scene. SceneError if the contact gets hotter than a table.
    """
    each = tuple(one.bodies for one in _heatings(scene, speeds))
    numbers = [bodies[:4] for bodies in each]
    return Conductions(
        each, *np.array(list(zip(*numbers, strict=True)), dtype=np.float64)
    )  # None becomes NaN


def friction_coefficient(scene: Scene, speeds: ArrayLike | None = None) -> Array:
    """Return μ at each speed, shape (speeds,), the same for all columns.

    Where μ is a table it is its value at the background temperature + T₀(t) + s T_flash: friction acts where there is
    pressure, and T_flash is the mean temperature there. Speeds and errors: as `conduction`.
    """
    return np.array([one.friction_coefficient for one in _heatings(scene, speeds)])


def heat_per_pressure(scene: Scene, speed: float) -> float:
    """Return μ|v|, m/s, at a speed of either sign: the frictional heat of both bodies is q̇ = μ|v|σ."""
    return float(friction_coefficient(scene, (abs(speed),))[0]) * abs(speed)


def _heatings(scene: Scene, speeds: ArrayLike | None = None) -> list[Heating]:
    """Return `heating` at each speed, by default the speeds of the scene; with a lay in the direction of each."""
    values: list[float] = np.ravel(scene.speeds if speeds is None else speeds).tolist()
    angles = [case.get("direction") for case in scene.cases]
    if len(values) != len(angles):  # as `headings_at`
        angles = angles[:1] * len(values)
    pairs = zip(values, angles, strict=True)
    return [
        heating(scene if angle is None else turned(scene, angle), speed) for speed, angle in pairs
    ]


@lru_cache(maxsize=64)
def turned(scene: Scene, direction: float) -> Scene:
    """Return the scene towards a direction, radians from x, if that changes κ or μ of tables; else the scene."""
    return scene.towards(direction) if scene.tables else scene


def groups(scene: Scene, speeds: Array) -> Iterator[tuple[list[int], Heating]]:
    """Yield the indices of the speeds that share their constants, and these constants."""
    indices: dict[Heating, list[int]] = {}
    for k, constants in enumerate(_heatings(scene, speeds)):
        indices.setdefault(constants, []).append(k)
    return ((several, constants) for constants, several in indices.items())


# 6 ms for each number at a speed, with tables of μ or κ over temperature; .4 s with a lay
@lru_cache(maxsize=1024)
def heating(scene: Scene, speed: float) -> Heating:
    """Return μ, and κ and D of both bodies, at a speed, m/s; from tables at the temperature that the contact reaches.

    If there are several such temperatures it is the lowest, because a cold contact reaches it first. SceneError if
    there is none.
    """
    if not scene.tables:
        return Heating(scene.friction_coefficient(), scene.conduction())
    for constants, _ in _solutions(scene, speed):
        return constants
    ends = {key: min(rows[-1][0] for rows in tables) for key, tables in scene.tables.items()}
    end = min(ends.values())
    raise SceneError(
        f"sliding.speed = {speed:g} m/s heats the contact to T₀ + T_flash = "
        f"{_contact_with(scene, speed, end)[2]:.4g} K at constant {' and '.join(ends)} beyond {end:g} K, where the "
        "tables end; extend them or lower the speed"
    )


def contact_temperatures(scene: Scene, speed: float) -> list[float]:
    """Return every absolute temperature, K, that solves the heat balance with the tables of a scene, ascending.

    The first is the one in use; none of them lies beyond the end of a table. The contact is stable at the first, third
    and so on, and drifts away from those between.
    """
    return [contact for _, contact in _solutions(scene, speed)]


def _solutions(scene: Scene, speed: float) -> Iterator[tuple[Heating, float]]:
    """Yield μ, κ and D, and the absolute temperature of the contact, K, of each solution, from the coldest on.

    They are looked for in 64 steps and at the rows of the tables: if only μ is a table, none lies between.
    """
    friction_end = _end_of_friction(scene)

    def excess(temperature: float) -> float:
        return _contact_with(scene, speed, temperature)[1] - temperature

    marks = _marks(scene, speed)
    hotter = True  # whether the contact gets hotter than the last mark
    for low, high in pairwise([marks[0], *marks]):
        if (excess(high) > 0.0) != hotter:
            hotter = not hotter
            solution = root(excess, low, high, accuracy=1e-11 * high, relative=1e-13)
            constants, _, contact = _contact_with(scene, speed, solution)
            if contact > friction_end:
                return
            yield constants, contact


def _marks(scene: Scene, speed: float) -> list[float]:
    """Return the absolute temperatures, K, between which solutions are looked for, from the background on.

    Of a row of a table both its temperature, and the temperature of κ with the contact at that temperature.
    """
    start = scene.background_temperature or 0.0
    end = min(rows[-1][0] for tables in scene.tables.values() for rows in tables)
    background, flash = _rises(scene, speed, scene.conduction(start))
    part = (background + 0.75 * flash) / (background + flash) if flash else 1.0
    rows = [kelvin for tables in scene.tables.values() for table in tables for kelvin, _ in table]
    rows += [start + part * (kelvin - start) for kelvin in rows]
    return sorted(
        {*np.linspace(start, end, 1 + _STEPS).tolist(), *(k for k in rows if start <= k <= end)}
    )


def _end_of_friction(scene: Scene) -> float:
    """Return the last temperature of the tables of μ, K; inf without one."""
    return min((rows[-1][0] for rows in scene.tables.get("friction_coefficient", [])), default=inf)


def _contact_with(scene: Scene, speed: float, temperature: float) -> tuple[Heating, float, float]:
    """Return the constants with κ at a temperature, the temperature there with them, and the contact's, K."""
    start = scene.background_temperature or 0.0
    friction_end = _end_of_friction(scene)
    bodies = scene.conduction(temperature)
    background, flash = _rises(scene, speed, bodies)
    layer, contact = background + 0.75 * flash, background + flash
    # the temperature of κ gives the temperature of the contact: both rises are in proportion to μ
    hot = start + (temperature - start) * (contact / layer if layer else 1.0)
    friction = scene.friction_coefficient(min(hot, friction_end))
    return Heating(friction, bodies), start + friction * layer, start + friction * contact


def _rises(scene: Scene, speed: float, bodies: Conduction) -> tuple[float, float]:
    """Return T₀(t) of the moving body and s T_flash, K, with μ = 1: both are in proportion to it."""
    unit, spectrum = Heating(1.0, bodies), smoothed_spectrum(scene)
    law = calibrated(scene).stress if scene.directions else None
    rule, speeds = scene.sliding.heat_partition, np.array([speed])
    share = float(share_of(scene, rule, speeds, spectrum, bodies, law)[0])
    heat = heat_arguments(*unit)
    if scene.directions:
        heat |= {"nominal_pressure": scene.sliding.nominal_pressure}
        at, stress = headings_at(scene, speeds), stress_of_lay(scene, spectrum, law)
        (flash,) = in_directions((FLASH,), speeds, at, stress, **heat)[FLASH].tolist()
    else:
        load = stress_arguments(scene)
        flash = float(theory.flash.flash_temperature(speed, spectrum, **load, **heat))
    return share * _warming(scene, speed, unit), share * flash


def _warming(scene: Scene, speed: float, constants: Heating) -> float:
    """Return T₀ of the surface of the moving body with all the heat in it, K; 0 where no time or radius is given."""
    friction, bodies = constants
    flux = friction * scene.sliding.nominal_pressure * speed
    if not scene.sliding.warms or flux == 0.0:
        return 0.0
    return flux / bodies.conductivity * warming_lengths(scene, speed, bodies)[0]


def background(scene: Scene) -> Array:
    """Return T₀, K, shape (speeds,): how far the surface of the moving body has warmed, with all the heat in it.

    It is the mean over the nominal contact after the `duration`, or steady under a round one; 0 without either.
    """
    pairs = zip(scene.speeds, _heatings(scene), strict=True)
    return np.array([_warming(scene, speed, constants) for speed, constants in pairs])


def heat_partition(
    scene: Scene,
    speeds: ArrayLike | None = None,
    *,
    rule: float | str | None = None,
    spectrum: Spectrum | None = None,
    stress: Spectrum | LayStress | None = None,
) -> Array:
    """Return the moving body's share of the heat at each speed, m/s, by default the speeds of the scene.

    `rule` is a number, "all" (1), or the theory's "mean" or "total", NaN without a second body; None is the rule of
    the scene, with which temperatures are reported. `spectrum` stands for the whole C_sm if given, `stress` for the
    spectrum of the stress of the theory, Pa² m².
    """
    speed = np.asarray(scene.speeds if speeds is None else speeds, np.float64)
    rule = scene.sliding.heat_partition if rule is None else rule
    if stress is None and spectrum is None:
        spectrum = smoothed_spectrum(scene)
    result = np.empty(speed.shape)
    for indices, constants in groups(scene, speed):
        at = headings_at(scene, speed)[indices] if scene.directions else None
        result[indices] = share_of(
            scene, rule, speed[indices], spectrum, constants.bodies, stress, at
        )
    return result


def heat_source(scene: Scene) -> HeatSource:
    """Return the frictional heat of a scene, all of it in the moving body."""
    from roughsim.observables.moments import HeatSource  # loads the transforms

    bodies, layers = conduction(scene), scene.layers[0]
    return HeatSource(
        speeds=[speed or AT_REST for speed in scene.speeds],
        friction_coefficient=friction_coefficient(scene).tolist(),
        conductivity=bodies.conductivity.tolist(),
        diffusivity=bodies.diffusivity.tolist(),
        skin=layers.skin,
        heat_depth=layers.heat_depth,
        direction=scene.headings,
        from_rest=scene.headings is not None,
    )
