"""The calibrated law of the stress spectrum for a scene, beside the paper's weight: its values and its error bands."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import isinf
from typing import Any

import theory
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.stress import law_arguments, law_of
from roughsim.scene import Scene
from theory.lay import LayStress
from theory.yielding import ELASTIC_BANDS, ERROR_BANDS, YieldingSpectrum

# observables in which contacts that yield were compared; their g_σ(r) is rarely known down to a tenth of g_σ(0)
_OF_YIELDING = (
    *("flash_temperature", "heat_partition", "contact_fraction", "plastic_fraction"),
    *("pressure_variance", "correlation_radius_50", "seen_rms", "seen_width"),
)

# of faces with a lay, whose stress the law gives in the stretched frame
_OF_LAY = (
    *("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length"),
    *("heat_partition", "seen_rms", "seen_width", "contact_fraction", "plastic_fraction"),
)


@dataclass(frozen=True, slots=True)
class Calibrated:
    """The calibrated law of the stress spectrum for a scene, over the whole C(q)."""

    # |σ_q|²(q), Pa² m², of faces with a lay in the stretched frame
    stress_spectrum: YieldingSpectrum | None  # None where the scene lies outside its range
    observables: tuple[str, ...]  # observables by the law
    errors: dict[str, float]  # relative error bands by observable; T_flash is the first
    range: str  # "inside", or the number of the scene that lies outside, with the range that was compared
    stress: LayStress | None = None  # of a scan in its directions, or of a face with a lay


@lru_cache(maxsize=64)  # .02 s, up to .1 s; ten times in a comparison or report
def calibrated(scene: Scene) -> Calibrated:
    """Return the calibrated law of a scene; without a hardness it is the law of elastic contact."""
    errors = ELASTIC_BANDS if scene.elastic else ERROR_BANDS
    try:
        stress = _in_directions(scene)
        law: Any = (
            stress.stress_spectrum if stress else law_of(scene.spectrum, **law_arguments(scene))
        )
        theory.persson.stress_density(
            stress_spectrum=law
        )  # kept for all quantities; refuses integrals without limit
    except (ValueError, theory.quadrature.QuadratureError) as error:
        return Calibrated(None, (), errors, str(error).split(";")[0])
    elastic = isinf(law.penetration_hardness)
    if stress is not None:
        bands = ELASTIC_BANDS if elastic else ERROR_BANDS
        flash = theory.lay.error_band(
            stress.lay, bands["flash_temperature"], own_lays=scene.lay == 1.0
        )
        areas = {name: bands[name] for name in bands if name in _OF_LAY[-2:]}
        known = tuple(name for name in _OF_LAY if elastic or name in _OF_YIELDING)
        return Calibrated(law, known, {"flash_temperature": flash} | areas, "inside", stress)
    if elastic:
        return Calibrated(law, tuple(OBSERVABLES), ELASTIC_BANDS, "inside")
    return Calibrated(law, _OF_YIELDING, ERROR_BANDS, "inside")


def _in_directions(scene: Scene) -> LayStress | None:
    """Return the stress of faces with a lay, or of scans in their directions, by the law; None of isotropic faces."""
    if scene.lay > 1.0:
        return theory.lay.stress_of_lay(scene.spectrum, scene.lay, **law_arguments(scene))
    if scene.directions:
        scan: Any = scene.spectrum
        return theory.lay.stress_of_waves(scan, **law_arguments(scene))
    return None
