"""Error of the theory for a scene, estimated with the calibrated law of the stress spectrum.

The calibrated law was compared with simulations, and its error bands by observable are known. The difference between
theory and law, with the band of the law, estimates the error of the theory without a simulation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.scene import Scene

_FASTEST = 1000.0  # v/(D q_roll_off) up to which the law was compared; the slow limit was reached


class Judgement(NamedTuple):
    """Error of one prediction of the theory."""

    observable: str  # as in `compare`
    speed: float | None  # m/s; None for an observable that does not depend on it
    percent: float  # 100 (theory/calibrated − 1): positive for a theory that is too high
    error: float  # 95 % error of `percent`

    def __str__(self) -> str:
        size = f"{abs(self.percent):.0f}"
        side = "" if size == "0" else " high" if self.percent > 0.0 else " low"
        return f"{size} ± {max(self.error, 1.0):.0f} %{side}"


@dataclass(frozen=True, slots=True)
class Trust:
    """Errors of the theory for a scene."""

    source: str  # "calibrated", or "not known" for a scene outside the range of the law
    where: str  # the number of the scene outside the range; empty inside
    against: str = ""  # reference of `percent`
    judgements: tuple[Judgement, ...] = ()  # one per observable and speed with a known error band
    off: tuple[
        tuple[float, str], ...
    ] = ()  # speeds, m/s, at which the law was not compared, each with its reason

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values."""
        off = [{"speed": speed, "where": reason} for speed, reason in self.off]
        rows = [judgement._asdict() for judgement in self.judgements]
        return {
            "source": self.source,
            "where": self.where,
            "against": self.against,
            "rows": rows,
            "off": off,
        }


def trust(scene: Scene) -> Trust:
    """Return the error of the theory for each observable in which the calibrated law was compared with simulations."""
    law = prediction.calibrated(scene)
    if law.stress_spectrum is None:
        return Trust("not known", law.range)
    if scene.directions:
        return Trust("not known", "the theory was not compared in single directions")
    peclet = _peclet_numbers(scene)
    judgements = []
    by_theory, by_law = prediction.predictions(scene), prediction.calibrated_predictions(scene)
    for name, band in law.errors.items():
        theory, calibrated = by_theory[name], by_law[name]
        speeds: list[tuple[int, float | None]] = [(0, None)]
        if OBSERVABLES[name].per_speed:
            # no heat at rest
            speeds = [(k, v) for k, v in enumerate(scene.speeds) if v and peclet[k] <= _FASTEST]
        for k, speed in speeds:
            if calibrated[k]:
                ratio = float(theory[k] / calibrated[k])
                judgements.append(Judgement(name, speed, 100 * (ratio - 1), 100 * ratio * band))
    off = [
        (speed, f"Péclet number v/(D q_roll_off) {number:.4g} above {_FASTEST:g}")
        for speed, number in zip(scene.speeds, peclet, strict=True)
        if number > _FASTEST
    ]
    against = f"the calibrated stress spectrum up to q_max = {scene.spectrum.breaks[-1]:.3g} rad/m"
    return Trust("calibrated", "", against, tuple(judgements), tuple(off))


def _peclet_numbers(scene: Scene) -> list[float]:
    """Return |v|/(D q) at each speed, with the mean wavenumber ∫ q C dq/∫ C dq, which is about q_roll_off."""
    spectrum = scene.spectrum
    q = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1], 2001)
    first, second = (np.trapezoid(q**n * spectrum(q), np.log(q)) for n in (1, 2))
    mean = float(second / first)
    numbers: list[float] = (
        np.abs(scene.speeds) / (prediction.conduction(scene).diffusivity * mean)
    ).tolist()
    return numbers
