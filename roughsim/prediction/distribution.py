"""Distribution of the temperature over the contact, and what reacts there, by the calibrated law and drawn fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

import theory
from roughsim.grid import Array
from roughsim.observables.distribution import LEVELS
from roughsim.prediction.bodies import background, groups, heat_arguments, load_arguments
from roughsim.prediction.law import calibrated
from roughsim.scene import Scene
from roughsim.scene.model import Layers
from theory.clipped import Estimate, TemperatureDistribution

ELECTRONVOLT = 1.602176634e-19  # J
QUANTILES = {
    f"temperature_quantile_{'area_' * (weight == 'area')}{name}": (level, weight)
    for weight in ("heat", "area")
    for name, level in LEVELS.items()
}
Parts = tuple[
    tuple[list[int], TemperatureDistribution], ...
]  # places of speeds, and the distribution at these


_NORMAL = 1.96  # standard errors of a 95 % interval
_Found = dict[Any, Estimate]  # by name, or by observable, energy and temperature


class Banded(NamedTuple):
    """A value of the drawn fields over the speeds, its standard error by the drawing, and its whole error, 95 %.

    `error` is by the drawing, the form of the fields, and the calibrated law of T_flash and of the contact area.
    """

    value: Array
    standard_error: Array
    error: Array


@dataclass(frozen=True, slots=True)
class AskedPrediction:
    """The theory of what a scene asks for at one energy or temperature, over its speeds."""

    observable: str
    estimate: Banded
    energy: float | None = None  # eV
    temperature: float | None = None  # absolute, K

    @property
    def about(self) -> dict[str, float]:
        """Energy or temperature, whichever it has."""
        both = {"energy": self.energy, "temperature": self.temperature}
        return {name: value for name, value in both.items() if value is not None}

    @property
    def key(self) -> tuple[str, float | None, float | None]:
        """Observable, energy and temperature."""
        return self.observable, self.energy, self.temperature


@lru_cache(maxsize=16)  # 1 s at two speeds, in each table of a comparison
def temperature_distributions(scene: Scene) -> Parts:
    """Return the places of speeds, and the distribution of the temperature at these.

    Nothing where a scene does not ask for it, the moving body has a skin or is heated in depth, or the calibrated law
    does not hold for all of C(q) and for its part in the drawn fields.
    """
    if not scene.distribution or calibrated(scene).stress_spectrum is None:
        return ()
    speeds, found = np.array(scene.speeds), []
    for indices, constants in groups(scene, speeds):
        if constants.bodies.layers != Layers():
            return ()
        arguments: dict[str, Any] = load_arguments(scene) | heat_arguments(*constants)
        arguments["penetration_hardness"] = None if scene.elastic else scene.penetration_hardness
        way = scene.numerics.slid_distance
        arguments["slid_distance"] = way if way is not None and np.isfinite(way) else None
        try:
            fields = theory.clipped.temperature_distribution(
                speeds[indices], scene.spectrum, **arguments
            )
        except ValueError:  # the law does not hold for C(q) up to the shortest wave of the fields
            return ()
        found.append((indices, fields))
    return tuple(found)


def quantile_predictions(scene: Scene) -> dict[str, Banded]:
    """Return each quantile of the temperature over the speeds, K, with all heat in the moving body; empty without."""
    return quantiles_of(scene, temperature_distributions(scene))


def quantiles_of(scene: Scene, parts: Parts, of_flash: float | None = None) -> dict[str, Banded]:
    """Return each quantile of the distributions at some places of the speeds, over all speeds, K; empty without.

    `of_flash` is the relative error of their T_flash; None: of the calibrated law.
    """
    return _banded(scene, parts, of_flash, lambda varied: _quantiles(scene, varied))


def _banded(
    scene: Scene, parts: Parts, of_flash: float | None, compute: Callable[[Parts], _Found]
) -> dict[Any, Banded]:
    """Return what `compute` gives from distributions, with the error that follows from what is in doubt of them."""
    found, bands = compute(parts), calibrated(scene).errors
    squares = {key: (_NORMAL * estimate.standard_error) ** 2 for key, estimate in found.items()}
    warmer = 1.0 + (bands["flash_temperature"] if of_flash is None else of_flash)
    larger = 1.0 + bands["contact_fraction"]
    doubted = [
        (
            *fields.doubted(),
            replace(fields, flash_temperature=warmer * fields.flash_temperature),
            replace(fields, contact_fraction=larger * fields.contact_fraction),
        )
        for _, fields in parts
    ]
    for together in zip(*doubted, strict=True):
        # as one field: without a standard error they take a ninth of the time
        ones = [replace(fields, field=np.zeros_like(fields.field)) for fields in together]
        varied = compute(
            tuple((places, fields) for (places, _), fields in zip(parts, ones, strict=True))
        )
        squares = {
            key: square + (varied[key].value - found[key].value) ** 2
            for key, square in squares.items()
        }
    return {key: Banded(*estimate, np.sqrt(squares[key])) for key, estimate in found.items()}


def _quantiles(scene: Scene, parts: Parts) -> _Found:
    found: _Found = {}
    for weight in ("heat", "area") if parts else ():
        names = [name for name, (_, by) in QUANTILES.items() if by == weight]
        levels = [QUANTILES[name][0] for name in names]
        rows = _joined(
            scene, [(places, fields.quantiles(levels, by=weight)) for places, fields in parts]
        )
        found |= {name: Estimate(*(values[k] for values in rows)) for k, name in enumerate(names)}
    return found


def asked_predictions(scene: Scene, share: Array) -> list[AskedPrediction]:
    """Return reactions and the share of hot heat that a scene asks for; `share` is that of the heat at each speed."""
    start = (scene.sliding.background_temperature or 0.0) + share * background(scene)
    return asked_of(scene, temperature_distributions(scene), start, share)


def asked_of(
    scene: Scene, parts: Parts, start: Array, share: Array, of_flash: float | None = None
) -> list[AskedPrediction]:
    """Return what a scene asks for from distributions at some places of the speeds; empty without.

    `start` is the absolute temperature of the background, K, and `share` the factor of the temperatures, (speeds,);
    `of_flash` as of `quantiles_of`.
    """
    found = _banded(
        scene, parts, of_flash, lambda varied: dict(_asked(scene, varied, start, share))
    )
    return [AskedPrediction(name, banded, *about) for (name, *about), banded in found.items()]


def _asked(
    scene: Scene, parts: Parts, start: Array, share: Array
) -> Iterator[tuple[Any, Estimate]]:
    """Yield observable, energy, eV, and temperature, K, of all that a scene asks for, with its value."""
    if parts and scene.reaction is not None:
        yield from _reactions(scene, parts, start, share)
    limits = scene.observables.heat_above if scene.observables is not None else None
    for limit in (limits or ()) if parts else ():
        with np.errstate(divide="ignore"):
            excess = np.nan_to_num((limit - start) / share)
        above = _joined(
            scene, [(places, fields.share_above(excess[places])) for places, fields in parts]
        )
        yield ("heat_share_above", None, limit), above


def _reactions(
    scene: Scene, parts: Parts, start: Array, share: Array
) -> Iterator[tuple[Any, Estimate]]:
    """Yield rate, activation temperature and, if its length is given, conversion at each energy."""
    reaction = scene.reaction
    if reaction is None:
        return
    energies = np.array(reaction.activation_energy)
    rates, kelvins = [], []
    for places, fields in parts:
        given: dict[str, Any] = {
            "background_temperature": start[places],
            "heat_partition": share[places],
        }
        given["activation_volume"] = reaction.activation_volume
        rates.append(
            (places, fields.reaction_rate(energies, prefactor=reaction.prefactor, **given))
        )
        kelvins.append((places, fields.activation_temperature(energies, **given)))
    values = {
        "reaction_rate": _joined(scene, rates),
        "activation_temperature": _joined(scene, kelvins),
    }
    if reaction.contact_length is not None:
        with np.errstate(divide="ignore"):
            time = reaction.contact_length / np.array(scene.speeds)
        rate, error = values["reaction_rate"]
        steepness = np.exp(-rate * time) * np.nan_to_num(time, posinf=0.0)  # at rest all reacts
        values["conversion"] = Estimate(-np.expm1(-rate * time), steepness * error)
    for k, energy in enumerate(reaction.activation_energy):
        for name, estimate in values.items():
            at = round(energy / ELECTRONVOLT, 12)
            yield (name, at, None), Estimate(estimate.value[k], estimate.standard_error[k])


def _joined(scene: Scene, parts: list[tuple[list[int], Estimate]]) -> Estimate:
    """Return estimates at some places of the speeds as one at all speeds, (..., speeds)."""
    shape = parts[0][1].value.shape[:-1]
    result = np.empty((2, *shape, len(scene.speeds)))
    for places, estimate in parts:
        result[..., places] = estimate
    return Estimate(*result)
