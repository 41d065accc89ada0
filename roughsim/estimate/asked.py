"""What a scene asks of the contacts of a column: rates of reactions, activation temperatures, the share of hot heat.

The absolute temperature of the contact is T₀ + T: T₀ is `sliding.background_temperature`, plus what the surface has
warmed after the `duration` of the scene, and T is the distribution about T_flash.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from roughsim.estimate.contacts import Contacts, factor_of
from roughsim.estimate.errors import estimate
from roughsim.estimate.mean import Mean
from roughsim.estimate.reactions import (
    ELECTRONVOLT,
    LEAST_MEMBERS,
    Activation,
    ContactMean,
    heat_above,
    mean_over_contact,
)
from roughsim.grid import Array
from roughsim.observables.record import bins_of
from roughsim.scene import Scene
from roughsim.scene.reactions import ReactionSection
from roughsim.table import AT_CUT_OFF, Estimate, concat

RATE = "reaction_rate"
ACTIVATION = "activation_temperature"
CONVERSION = "conversion"
HEAT_ABOVE = "heat_share_above"


class Asked(NamedTuple):
    """An observable that a scene may ask for."""

    axis: str  # "energy", eV, or "temperature", absolute, K
    unit: str  # SI
    key: str  # of the scene that asks for it
    lines: str  # of the scene, in words


_REACTION = "[reaction] with activation_energy and prefactor"
# a new one is a row here, and an estimate that `of_reaction` or `asked_of` makes
ASKED = {
    RATE: Asked("energy", "1/s", "reaction.activation_energy", _REACTION),
    ACTIVATION: Asked("energy", "K", "reaction.activation_energy", _REACTION),
    CONVERSION: Asked(
        "energy",
        "1",
        "reaction.contact_length",
        "[reaction] with activation_energy, prefactor and contact_length",
    ),
    HEAT_ABOVE: Asked(
        "temperature", "1", "observables.heat_above", "[observables] with heat_above"
    ),
}
ABOUT = {name: one.axis for name, one in ASKED.items()}


def asked_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of the estimates that [reaction] and `heat_above` of a scene ask for."""
    names = []
    for name, one in ASKED.items():
        section, _, key = one.key.partition(".")
        if getattr(getattr(scene, section), key, None) is not None:
            names.append(name)
    return tuple(names)


def asked_of(scene: Scene, contacts: Contacts) -> dict[str, Estimate]:
    """Return what [reaction] and `heat_above` of a scene ask for, by name.

    Over energy, eV, or temperature, absolute, K, the direction of faces with a lay, and speed.
    """
    found: dict[str, dict[float, Estimate]] = {}
    if scene.reaction is not None:
        for energy in scene.reaction.activation_energy:
            for one in of_reaction(contacts, scene.reaction, energy):
                label = round(energy / ELECTRONVOLT, 12)
                found.setdefault(one.observable, {})[label] = one.by_direction(scene.directions)
    if scene.observables is not None:
        for temperature in scene.observables.heat_above or ():
            one = _heat_above(contacts, temperature)
            found.setdefault(one.observable, {})[temperature] = one.by_direction(scene.directions)
    return {
        name: concat(
            {(k,): one for k, one in enumerate(by_label.values())},
            {ABOUT[name]: np.array([*by_label])},
        )
        for name, by_label in found.items()
    }


def of_reaction(contacts: Contacts, reaction: ReactionSection, energy: float) -> Iterator[Estimate]:
    """Yield rate and activation temperature at an energy, J, and the conversion in a pass if its length is given."""
    flash = contacts.flash
    activation = Activation(energy, reaction.activation_volume, contacts.background)
    scales = [
        activation.log_scale(bins_of(sample), factor_of(sample, flash))
        for sample in contacts.all_samples
    ]
    scale = np.max(scales, axis=0)
    activation = activation._replace(scale=scale)
    of_level = ContactMean(activation.rates, flash, activation.uniform_temperature)
    members = of_level.members(contacts.samples[0])
    found = mean_over_contact(contacts, of_level)
    # continued below absolute zero it is unknown
    warm = replace(found, value=np.where(found.value > 0.0, found.value, np.nan))
    if np.isfinite(found.value).any():
        of_contact = activation.of_uniform_temperature(warm, contacts.samples[-1])
    else:  # without a barrier
        of_contact = mean_over_contact(contacts, ContactMean(of_level.of_bins, flash))
    rate = of_contact * (reaction.prefactor * np.exp(scale)) * contacts.area
    yield _estimate(contacts, RATE, rate, members)
    yield _estimate(contacts, ACTIVATION, warm, members)
    if reaction.contact_length is not None:
        done = _conversion(rate, contacts.speeds, reaction.contact_length)
        yield _estimate(contacts, CONVERSION, done, members)


def _conversion(rate: Mean, speeds: tuple[float, ...], length: float) -> Mean:
    """Return 1 − exp(−k t) of the rate k after the time t that a point spends in a nominal contact of a length, m."""
    with np.errstate(divide="ignore"):
        time = length / np.array(speeds)
    with np.errstate(invalid="ignore", over="ignore"):
        done = rate.value * time
        factor = np.where(np.isinf(time), 0.0, time * np.exp(-done))
    return rate.through(-np.expm1(-done), -np.expm1(-rate.finest * time), factor)


def _heat_above(contacts: Contacts, temperature: float) -> Estimate:
    """Return the share of the heat where the contact is hotter than an absolute temperature, K."""
    of_bins = partial(heat_above, excess=temperature - contacts.background)
    of_level = ContactMean(of_bins, contacts.flash, by_contact=True)
    found = mean_over_contact(contacts, of_level)
    share = replace(found, value=np.clip(found.value, 0.0, 1.0))
    return _estimate(contacts, HEAT_ABOVE, share, of_level.members(contacts.samples[0]))


def _estimate(contacts: Contacts, observable: str, mean: Mean, members: Array) -> Estimate:
    """Return an estimate; the scatter of a mean that few effective members carry is unknown."""
    note = f"T₀ + T of the contact, with {np.round(members, 1).tolist()} effective members over the speeds"
    unit = ASKED[observable].unit
    found = estimate(observable, mean, (note,), contacts.speeds, unit)
    statistical = np.where(members < LEAST_MEMBERS, np.nan, found.budget["statistical"])
    budget = {**found.budget, "statistical": statistical}
    cut = np.isnan(budget.get("bandwidth", np.zeros_like(found.mean)))
    cut &= np.isfinite(found.mean) & (found.mean != 0.0)
    marks = np.where(cut, AT_CUT_OFF, "").astype(object)
    return replace(found, budget=budget, note=marks, sources=contacts.sources)
