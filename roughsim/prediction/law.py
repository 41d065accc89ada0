"""The calibrated law of the stress spectrum for a scene, beside the paper's weight: what it gives, and how well."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import theory
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.bodies import load_arguments, pressure_arguments
from roughsim.scene import Scene
from theory import calibrated as elastic
from theory import yielding

# what the law for contact that yields was compared in; g_σ(r) of contacts is rarely known down to a tenth of g_σ(0)
OF_YIELDING = (
    *("flash_temperature", "contact_fraction", "plastic_fraction"),
    *("pressure_variance", "correlation_radius_50"),
)


@dataclass(frozen=True, slots=True)
class Calibrated:
    """The calibrated law of the stress spectrum for a scene: what it gives over the whole C(q), and how well."""

    stress_spectrum: Any  # |σ_q|²(q), Pa² m²; None where the scene lies outside
    observables: tuple[str, ...]  # that it gives: those that were compared with contacts
    errors: dict[str, float]  # relative error bands, by the observables that have one; T_flash is the first
    range: str  # "inside", or what of the scene lies outside the range that was compared


@lru_cache(maxsize=64)
def calibrated(scene: Scene) -> Calibrated:
    """Return the law for contact that yields where there is a hardness, else that of elastic contact."""
    errors = elastic.ERROR_BANDS if scene.elastic else yielding.ERROR_BANDS
    try:
        if scene.elastic:
            law: Any = theory.persson.calibrated_spectrum(scene.spectrum, **load_arguments(scene))
        else:
            law = theory.plasticity.stress_spectrum(scene.spectrum, **pressure_arguments(scene))
        theory.persson.stress_density(stress_spectrum=law)  # remembered; here it shows whether integrals converge
    except (ValueError, theory.quadrature.QuadratureError) as error:
        return Calibrated(None, (), errors, str(error).split(";")[0])
    if isinstance(law, yielding.YieldingSpectrum):
        return Calibrated(law, OF_YIELDING, errors, "inside")
    return Calibrated(law, tuple(OBSERVABLES), elastic.ERROR_BANDS, "inside")
