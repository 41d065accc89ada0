"""Heat balance of two bodies: their temperatures with all the heat in each, as the time of sliding changes them."""

from dataclasses import replace
from math import nan

import numpy as np
import scipy

import theory
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.prediction.bodies import conduction
from roughsim.scene import Scene
from roughsim.scene.model import Conduction, Layers
from theory.skin import layers_of, surface_response


def heat_history(scene: Scene, q: Array) -> tuple[Array, Array, Array]:
    """Return the terms by which the time of sliding enters the heat balance at each speed; q (modes,) in rad/m.

    First the part of the steady temperature that the resting body has reached, (speeds, modes), then the backgrounds
    κT₀ σ₀/μv of the moving and of the resting body, Pa² m, (speeds,). Where time plays no part they are 1, 0 and 0.
    """
    time, each = scene.sliding.duration, conduction(scene).each
    layered = np.array([_layered(bodies, q) for bodies in each])
    if scene.sliding.heat_partition != "total" or time is None:
        zero = np.zeros(len(scene.speeds))
        return 1.0 + layered, zero, zero
    square = scene.sliding.nominal_pressure**2
    moving, resting = (
        np.array([_warming(time, square, *body) for body in bodies])
        for bodies in zip(*map(_bodies, each), strict=True)
    )
    grown = scipy.special.erf(q * np.sqrt(conduction(scene).counter_diffusivity * time)[:, None])
    return grown + layered, moving, resting


def _bodies(bodies: Conduction) -> tuple[tuple[float, float, Layers], tuple[float, float, Layers]]:
    """Return κ, D and layers of the moving and of the resting body; NaN of one that does not conduct."""
    kappa, diffusivity = bodies.counter_conductivity or nan, bodies.counter_diffusivity or nan
    return (bodies.conductivity, bodies.diffusivity, bodies.layers), (
        kappa,
        diffusivity,
        bodies.counter_layers,
    )


def _warming(time: float, flux: float, kappa: float, diffusivity: float, layers: Layers) -> float:
    """Return κT₀ of a body by a uniform flux, W/m, a time, s, after it began."""
    skin = None if layers.skin is None else (layers.skin[0], layers.skin[1] / kappa, layers.skin[2])
    body = {
        "conductivity": 1.0,
        "diffusivity": diffusivity,
        "skin": skin,
        "heat_depth": layers.heat_depth,
    }
    return float(theory.background.temperature(time, heat_flux=flux, **body))


def _layered(bodies: Conduction, q: Array) -> Array:
    """Return the steady change of |q|κT/q̇ of the resting body at rest by its skin, (modes,)."""
    kappa, diffusivity, counter_layers = _bodies(bodies)[1]
    layers = None if counter_layers == Layers() else layers_of(*counter_layers, kappa, diffusivity)
    if layers is None:
        return np.zeros(q.size)
    return surface_response(q, np.zeros_like(q), layers).real - 1.0


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
        growth = heat_history(scene, sample.wavenumber)[0]
        resting = resting / steady.sum(axis=1, keepdims=True) * (steady @ growth.T)
    resting = resting * (bodies.conductivity / bodies.counter_conductivity)
    numbers = sample.numbers | {"resting_flash_temperature": resting}
    below = None if sample.below is None else balanced(scene, sample.below)
    return replace(sample, numbers=numbers, below=below)


def backgrounds(scene: Scene, sample: Sample) -> tuple[Array, Array]:
    """Return the mean temperatures T₀ of the moving and of the resting body, each with all the heat, K, (speeds,).

    They are of the sliding duration under the rule "total", else zero. The sample is any of the scene.
    """
    if scene.sliding.heat_partition != "total":
        return np.zeros(len(scene.speeds)), np.zeros(len(scene.speeds))
    _, moving, resting = heat_history(scene, sample.wavenumber)
    steady = (sample.spectrum[0] / sample.wavenumber).sum()
    rate = sample.numbers["resting_flash_temperature"][0] / steady  # μv/κσ₀, also at rest
    bodies = conduction(scene)
    return rate * moving, rate * resting * (bodies.conductivity / bodies.counter_conductivity)
