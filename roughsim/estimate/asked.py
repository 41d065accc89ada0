"""What a scene asks of the contacts of a column: rates of reactions, activation temperatures, the share of hot heat.

The absolute temperature of the contact is T₀ + T: T₀ is `sliding.background_temperature`, plus what the surface has
warmed after the `duration` of the scene, and T is the distribution about T_flash.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from roughsim.estimate.errors import SOURCES, estimate
from roughsim.estimate.levels import Values, product, scaled
from roughsim.estimate.reactions import (
    ELECTRONVOLT,
    LEAST_MEMBERS,
    Activation,
    ContactMean,
    OverContact,
    bins_of,
    factor_of,
    heat_above,
    log_scale,
    of_uniform_temperature,
    rates,
    uniform_temperature,
)
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.scene import Scene
from roughsim.scene.reactions import ReactionSection
from roughsim.table import AT_CUT_OFF, Estimate, concat

RATE, ACTIVATION, CONVERSION, HEAT_ABOVE = (
    "reaction_rate",
    "activation_temperature",
    "conversion",
    "heat_share_above",
)
ABOUT = {  # axis of each
    RATE: "energy",
    ACTIVATION: "energy",
    CONVERSION: "energy",
    HEAT_ABOVE: "temperature",
}


class Contacts(NamedTuple):
    """The contacts of a column, whose temperatures are scaled to its T_flash."""

    speeds: tuple[float, ...]  # m/s
    samples: list[Sample]  # of the levels and of those below, or of slides, and at last `top`
    top: Sample  # of the highest level, or of the slides at the end of C(q)
    flash: Values  # reported T_flash, K
    area: Values  # A/A₀
    background: Array  # T₀, absolute, K
    mean: Callable[[ContactMean], OverContact]  # over these contacts, with its errors
    sources: Mapping[str, str] = SOURCES  # the parts of an error, in words


def asked_of(scene: Scene, contacts: Contacts) -> dict[str, Estimate]:
    """Return what [reaction] and `heat_above` of a scene ask for, by name.

    Over energy, eV, or temperature, absolute, K, and speed.
    """
    found: dict[str, dict[float, Estimate]] = {}
    if scene.reaction is not None:
        for energy in scene.reaction.activation_energy:
            for one in of_reaction(contacts, scene.reaction, energy):
                found.setdefault(one.observable, {})[round(energy / ELECTRONVOLT, 12)] = one
    if scene.observables is not None:
        for temperature in scene.observables.heat_above or ():
            one = _heat_above(contacts, temperature)
            found.setdefault(one.observable, {})[temperature] = one
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
        log_scale(bins_of(sample), factor_of(sample, flash), activation)
        for sample in contacts.samples
    ]
    scale = np.max(scales, axis=0)
    of_bins = partial(rates, activation=activation, scale=scale)
    of_mean = partial(uniform_temperature, activation=activation, scale=scale)
    warm = contacts.mean(ContactMean(of_bins, flash, of_mean))
    found = warm.values.mean  # continued below absolute zero it is unknown
    warm = warm._replace(values=warm.values._replace(mean=np.where(found > 0.0, found, np.nan)))
    if np.isfinite(found).any():
        over = warm._replace(
            values=of_uniform_temperature(warm.values, contacts.top, activation, scale)
        )
    else:  # without a barrier
        over = contacts.mean(ContactMean(of_bins, flash))
    of_contact = scaled(over.values, reaction.prefactor * np.exp(scale))
    rate = product(of_contact, contacts.area)
    yield _estimate(contacts, RATE, rate, over)
    yield _estimate(contacts, ACTIVATION, warm.values, warm)
    if reaction.contact_length is not None:
        yield _conversion(contacts, rate, over, reaction.contact_length)


def _conversion(contacts: Contacts, rate: Values, over: OverContact, length: float) -> Estimate:
    """Return 1 − exp(−k t) of the rate k after the time t that a point spends in a nominal contact of a length, m."""
    with np.errstate(divide="ignore"):
        time = length / np.array(contacts.speeds)
    with np.errstate(invalid="ignore", over="ignore"):
        done = rate.mean * time
        left = np.exp(-done)
        factor = np.where(np.isinf(time), 0.0, time * left)
    errors = {name: factor * part for name, part in rate.errors.items()}
    influence = {stream: rows * factor for stream, rows in rate.influence.items()}
    values = rate._replace(
        mean=-np.expm1(-done),
        finest=-np.expm1(-rate.finest * time),
        errors=errors,
        influence=influence,
    )
    return _estimate(contacts, CONVERSION, values, over)


def _heat_above(contacts: Contacts, temperature: float) -> Estimate:
    """Return the share of the heat where the contact is hotter than an absolute temperature, K."""
    of_bins = partial(heat_above, excess=temperature - contacts.background)
    over = contacts.mean(ContactMean(of_bins, contacts.flash, by_contact=True))
    values = over.values._replace(mean=np.clip(over.values.mean, 0.0, 1.0))
    return _estimate(contacts, HEAT_ABOVE, values, over)


def _estimate(contacts: Contacts, observable: str, values: Values, over: OverContact) -> Estimate:
    """Return an estimate; the scatter of a mean that few members carry is unknown."""
    note = f"T₀ + T of the contact, with {np.round(over.members, 1).tolist()} effective members over the speeds"
    found = estimate(observable, values, (note,), contacts.speeds)
    statistical = np.where(over.members < LEAST_MEMBERS, np.nan, found.budget["statistical"])
    budget = {**found.budget, "statistical": statistical}
    cut = np.isnan(budget.get("bandwidth", np.zeros_like(found.mean)))
    cut &= np.isfinite(found.mean) & (found.mean != 0.0)
    marks = np.where(cut, AT_CUT_OFF, "").astype(object)
    return replace(found, budget=budget, note=marks, sources=contacts.sources)
