"""Penetration hardness of a hot contact, from a table over temperature, by the calibrated law or the theory.

The law for contact that yields gives T_flash within some percent of simulations; the theory of the paper may be a
quarter too hot. The law has a range: the theory stands in if a trial hardness lies outside.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

import theory
from roughsim.prediction.bodies import heat_partition
from roughsim.prediction.law import calibrated
from roughsim.prediction.theories import calibrated_over_speed, calibrated_share, over_speed
from roughsim.scene import Scene


class _OutsideError(Exception):
    """A hardness lies outside the range of the calibrated law; the text names the number of the scene."""


@dataclass(frozen=True, slots=True)
class HotHardness:
    """σ_P of a contact at its own temperature, and the T_flash that it follows from."""

    scene: Scene  # with this hardness
    penetration_hardness: float  # Pa
    flash_temperature: float  # K, of the share of the heat in the moving body
    background: float  # K
    law: str  # "calibrated" or "theory"
    range: str  # "inside", or the number of the scene outside the range of the calibrated law

    def __str__(self) -> str:
        by = "the calibrated law" if self.law == "calibrated" else f"the theory, as {self.range}"
        hot = f"{self.background:g} K + {self.flash_temperature:.4g} K"
        return f"hardness: σ_P = {self.penetration_hardness:.4g} Pa at {hot}; T_flash is by {by}"


def hot_hardness(
    scene: Scene, temperature: ArrayLike, penetration_hardness: ArrayLike, *, background: float
) -> HotHardness:
    """Return the hardness of a scene of one speed at the temperature that its contact reaches with it.

    Parameters
    ----------
    scene : Scene
        With one speed. The hardness of its [body] is replaced.
    temperature, penetration_hardness : array_like
        Table of the hardness of [body] as in `theory.hardness.self_consistent`, absolute K and Pa.
    background : float
        Absolute temperature to which T_flash adds, K.

    Raises
    ------
    ValueError
        If the scene has several speeds, or the table is refused or too short.
    """
    if len(scene.speeds) != 1:
        raise ValueError(
            f"sliding.speed has {len(scene.speeds)} speeds, each with a hardness of its own; give a scene of one speed"
        )

    def solve(rise: Callable[[Scene], float]) -> tuple[float, float]:
        """Return σ_P, Pa, and T_flash, K, by one way to find T_flash of a scene."""

        def of_hardness(pascal: float) -> float:
            return rise(_with_hardness(scene, pascal))

        table = temperature, penetration_hardness
        pascal, kelvin = theory.hardness.self_consistent(of_hardness, *table, background=background)
        return pascal, kelvin

    law, outside = "calibrated", "inside"
    try:
        pascal, kelvin = solve(_by_calibrated_law)
    except _OutsideError as error:
        law, outside = "theory", str(error)
        pascal, kelvin = solve(_by_theory)
    return HotHardness(_with_hardness(scene, pascal), pascal, kelvin, background, law, outside)


def _with_hardness(scene: Scene, pascal: float) -> Scene:
    """Return a scene with a penetration hardness of [body], Pa."""
    return replace(scene, body=replace(scene.body, penetration_hardness=pascal))


def _by_theory(scene: Scene) -> float:
    """Return s T_flash of the theory at the one speed of a scene, K."""
    speed = np.array(scene.speeds)
    return float((heat_partition(scene) * over_speed(scene, speed)["flash_temperature"])[0])


def _by_calibrated_law(scene: Scene) -> float:
    """Return s T_flash of the calibrated law at the one speed of a scene, K; `_OutsideError` outside its range."""
    law = calibrated(scene)
    if law.stress_spectrum is None:
        raise _OutsideError(law.range)
    speed = np.array(scene.speeds)
    return float(
        (calibrated_share(scene) * calibrated_over_speed(scene, speed)["flash_temperature"])[0]
    )
