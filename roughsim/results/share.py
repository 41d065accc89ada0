"""The share of the heat in reported temperatures, given by the scene or computed from the contacts of the run.

The rules "mean" and "total" need the temperatures of both bodies. The share of a measured column follows from its own
temperatures, the share of the theory from the theory.
"""

from dataclasses import replace

import numpy as np

from roughsim import prediction
from roughsim.grid import Array
from roughsim.scene import Scene
from roughsim.table import Estimate

_OWN = ("mean", "total")  # the rules by which each measured column has a share of its own
NOTE = "with the share of the heat from the temperatures of both bodies in this contact"


def has_own_share(scene: Scene) -> bool:
    """Return whether the share of the heat follows from the contact."""
    return scene.sliding.heat_partition in _OWN


def with_warming(flash: Estimate, share: Estimate, warming: Array) -> Estimate:
    """Return s (T₀ + T_flash) from s T_flash and s, whose errors add; `warming`, (speeds,), is T₀ with all heat, K."""
    parts = {**flash.budget, **share.budget}
    return replace(
        flash,
        mean=flash.mean + share.mean * warming,
        standard_error=flash.standard_error + share.standard_error * warming,
        budget={
            name: flash.budget.get(name, 0.0) + share.budget.get(name, 0.0) * warming
            for name in parts
        },
        bias=flash.bias + share.bias * warming,
    )


def at_other_speed(scene: Scene, speed: float, known: Array, own: Array) -> float:
    """Return the share of a run at a speed, m/s, without moments, from the share of the theory there.

    `known` and `own`, (speeds,), are the shares by the theory and by the run. The odds s/(1 − s) are the ratio of the
    temperatures of the resting and the moving body, each with all the heat. The odds of the run over the odds of the
    theory are interpolated linearly over the odds of the theory, and constant beyond.
    """
    theory = float(prediction.heat_partition(scene, (speed,))[0])
    if not has_own_share(scene):
        return theory
    if scene.sliding.heat_partition == "mean":  # at rest the conductivities alone share the heat
        at_rest = prediction.heat_partition(scene, (0.0,))
        known, own = np.concatenate([at_rest, known]), np.concatenate([at_rest, own])
    order = np.argsort(known)
    odds, measured = (share[order] / (1.0 - share[order]) for share in (known, own))
    of_theory = theory / (1.0 - theory)
    ratio = of_theory * float(np.interp(of_theory, odds, measured / odds))
    return ratio / (1.0 + ratio)


def with_other_layers(scene: Scene, layered: Scene, speed: float, own: float) -> float:
    """Return the share at a speed, m/s, of a run whose bodies get the layers of another scene; `own` is without them.

    The odds change as by the calibrated spectrum of the stress, or by the theory where that does not hold.
    """
    found = prediction.calibrated(scene)
    law = found.stress or found.stress_spectrum
    before, after = (
        float(prediction.heat_partition(each, (speed,), stress=law)[0]) for each in (scene, layered)
    )
    odds = own / (1.0 - own) * after / (1.0 - after) * (1.0 - before) / before
    return odds / (1.0 + odds)
