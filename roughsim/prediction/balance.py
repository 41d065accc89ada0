"""Heat balance of two bodies: their temperatures with all the heat in each, as the time of sliding changes them."""

from dataclasses import replace
from math import inf
from typing import NamedTuple

import numpy as np
import scipy

from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.prediction.bodies import conduction, friction_coefficient
from roughsim.prediction.shares import thermal_bodies, warming_lengths
from roughsim.scene import Scene
from roughsim.scene.bodies import Conduction, Layers
from theory.skin import surface_response


class HeatHistory(NamedTuple):
    """The terms by which time and the size of the contact enter the heat balance at each speed.

    Where they play no part, as under the rule "mean", they are 1 and 0. In the balance all temperatures are σ₀κT/μv,
    Pa² m, with all the heat in the body.
    """

    growth: (
        Array  # part of the steady temperature that the resting body has reached, (speeds, modes)
    )
    moving: Array  # background of the moving body, (speeds,)
    resting: Array  # of the resting one
    hotter: (
        Array  # by how much the resting body was hotter before, as a background of the moving one
    )


def heat_history(scene: Scene, q: Array) -> HeatHistory:
    """Return the terms of the heat balance of a scene; q (modes,) in rad/m."""
    bodies, sliding = conduction(scene), scene.sliding
    layered = np.array([_layered(each, q) for each in bodies.each])
    if sliding.heat_partition != "total":
        zero = np.zeros(len(scene.speeds))
        return HeatHistory(1.0 + layered, zero, zero, zero)
    lengths = [
        warming_lengths(scene, speed, each)
        for speed, each in zip(scene.speeds, bodies.each, strict=True)
    ]
    moving, resting = sliding.nominal_pressure**2 * np.array(lengths).T
    time = inf if sliding.duration is None else sliding.duration
    grown = scipy.special.erf(q * np.sqrt(bodies.counter_diffusivity * time)[:, None])
    hotter = np.zeros(len(scene.speeds))
    if scene.temperature_difference:  # refused at rest
        heat = friction_coefficient(scene) * np.array(scene.speeds)
        pressure = sliding.nominal_pressure
        hotter = scene.temperature_difference * pressure * bodies.conductivity / heat
    return HeatHistory(grown + layered, moving, resting, hotter)


def _layered(bodies: Conduction, q: Array) -> Array:
    """Return the steady change of |q|κT/q̇ of the resting body at rest by its skin, (modes,)."""
    resting = thermal_bodies(bodies)[1]
    if resting is None or resting.layers is None:
        return np.zeros(q.size)
    return surface_response(q, np.zeros_like(q), resting.layers).real - 1.0


def balanced(scene: Scene, sample: Sample) -> Sample:
    """Return a level with the flash temperatures of both bodies that the rule of the scene makes equal.

    The resting body is measured with the conductivity of the moving one: its temperature is multiplied by κ/κ', NaN
    where it does not conduct. For "total" it has grown for the sliding duration, and `backgrounds` come on top. The
    sample needs its stress spectra then. The level below it is changed alike.
    """
    resting = sample.numbers["resting_flash_temperature"]
    bodies = conduction(scene)
    if scene.sliding.heat_partition == "total" or bodies.each[0].counter_layers != Layers():
        steady = sample.spectrum / sample.wavenumber
        growth = heat_history(scene, sample.wavenumber).growth
        resting = resting / steady.sum(axis=1, keepdims=True) * (steady @ growth.T)
    resting = resting * (bodies.conductivity / bodies.counter_conductivity)
    numbers = sample.numbers | {"resting_flash_temperature": resting}
    below = None if sample.below is None else balanced(scene, sample.below)
    return replace(sample, numbers=numbers, below=below)


def backgrounds(scene: Scene, sample: Sample) -> tuple[Array, Array]:
    """Return the mean temperatures T₀ of the moving and of the resting body, each with all the heat, K, (speeds,).

    They are of the rule "total", else zero. The sample is any of the scene.
    """
    if scene.sliding.heat_partition != "total":
        return np.zeros(len(scene.speeds)), np.zeros(len(scene.speeds))
    history = heat_history(scene, sample.wavenumber)
    steady = (sample.spectrum[0] / sample.wavenumber).sum()
    rate = sample.numbers["resting_flash_temperature"][0] / steady  # μv/κσ₀, also at rest
    bodies = conduction(scene)
    return rate * history.moving, rate * history.resting * (
        bodies.conductivity / bodies.counter_conductivity
    )
