"""Distribution of the temperature over two faces that slide, and what reacts there, by drawn fields."""

from __future__ import annotations

import numpy as np

import theory
from roughsim.prediction.bodies import groups
from roughsim.prediction.distribution import AskedPrediction, Parts, asked_of
from roughsim.prediction.sliding import pair_arguments, sliding_error, sliding_prediction
from roughsim.scene import Scene
from roughsim.scene.model import Layers
from roughsim.scene.numerics import SLIDING


def sliding_distributions(scene: Scene) -> Parts:
    """Return the places of speeds, and the distribution of the temperature of the moving body at these: 3 s a speed.

    Nothing where a scene does not ask for it or does not slide, a body has a skin or is heated in depth, or the
    calibrated law does not hold for all of C(q) and for its part in the drawn fields.
    """
    asks = scene.distribution and scene.sliding.history == SLIDING
    slid = sliding_prediction(scene) if asks else None
    if slid is None:
        return ()
    speeds, found = np.array(scene.speeds), []
    for indices, constants in groups(scene, speeds):
        if (constants.bodies.layers, constants.bodies.counter_layers) != (Layers(), Layers()):
            return ()
        arguments = pair_arguments(scene, constants.bodies)
        for distance in np.unique(slid.slid_distance[indices]).tolist():
            places = [k for k in indices if slid.slid_distance[k] == distance]
            try:
                fields = theory.clipped.sliding_temperature_distribution(
                    speeds[places],
                    scene.spectrum,
                    slid_distance=distance,
                    flash_temperature=slid.flash_temperature[places],
                    **arguments,
                )
            except (
                ValueError,
                ArithmeticError,
            ):  # outside the law up to the shortest wave of the fields, or unequal
                return ()
            found.append((places, fields))
    return tuple(found)


def sliding_asked_predictions(scene: Scene, parts: Parts) -> list[AskedPrediction]:
    """Return reactions of the moving body, and the share of hot heat, that a scene asks for; empty without.

    `parts` are those of `sliding_distributions`. With a duration the contact has warmed by the background of the slide.
    """
    slid = sliding_prediction(scene) if parts else None
    if slid is None:
        return []
    start = np.full(len(scene.speeds), scene.sliding.background_temperature or 0.0)
    if scene.sliding.duration is not None:
        start += slid.contact_temperature - slid.flash_temperature
    return asked_of(scene, parts, start, np.ones_like(start), sliding_error(scene))
