"""Contact area in theory, its yielded share, and the wavenumber at which the contact has yielded."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from math import inf
from types import MappingProxyType

import theory
from roughsim.prediction.stress import load_arguments, modulus_of, pressure_arguments
from roughsim.scene import Scene

_NEVER = 1e-6  # share of the theory's contact: if less yields, the hardness changes no number


@lru_cache(maxsize=256)  # 3 ms for each observable at each level of a comparison
def area_fractions(scene: Scene, q_max: float = inf) -> Mapping[str, float]:
    """Return the contact and the plastic fraction of the area with all roughness, or with waves up to q_max, rad/m."""
    spectrum, load = scene.spectrum, load_arguments(scene)
    end = min(q_max, float(spectrum.breaks[-1]))
    if scene.elastic:
        share = theory.persson.contact_probability(end, spectrum, **load)
        return MappingProxyType({"contact_fraction": float(share), "plastic_fraction": 0.0})
    variance = theory.persson.half_variance(end, spectrum, effective_modulus=modulus_of(scene))
    _, elastic, plastic = theory.plasticity.area_fractions(
        variance, scene.sliding.nominal_pressure, scene.penetration_hardness
    )
    areas = {"contact_fraction": float(elastic + plastic), "plastic_fraction": float(plastic)}
    return MappingProxyType(areas)  # it is remembered: nobody may write into it


def yielded_share(scene: Scene, q_max: float = inf) -> float:
    """Return the yielded share of the theory's contact, with all roughness, or with waves up to q_max, rad/m."""
    areas = area_fractions(scene, q_max)
    return (
        areas["plastic_fraction"] / areas["contact_fraction"] if areas["plastic_fraction"] else 0.0
    )


def computed(scene: Scene) -> Scene:
    """Return the scene that is computed: without a hardness that the theory's contact never reaches.

    It keeps the hardness if its levels or its targets name a column or an observable of contact that yields.
    """
    asked = scene.numerics.levels is not None or "plastic_fraction" in dict(scene.ensemble.until)
    if scene.elastic or asked or yielded_share(scene) >= _NEVER:
        return scene
    body, counterface = scene.body, scene.counterface
    if counterface is not None:
        counterface = replace(counterface, penetration_hardness=None)  # type: ignore[call-arg]
    sliding = replace(scene.sliding, junction_growth=None)
    return replace(
        scene,
        body=replace(body, penetration_hardness=None),
        counterface=counterface,
        sliding=sliding,
    )


@lru_cache(maxsize=256)  # 2 ms for each plan, and each list of warnings
def yield_wavenumber(scene: Scene) -> float:
    """Return q_y, rad/m, at which 1 % of the theory's contact is still elastic; infinite if C(q) ends before."""
    return float(theory.plasticity.yield_wavenumber(scene.spectrum, **pressure_arguments(scene)))
