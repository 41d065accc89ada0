"""Reactions of the surface of the moving body: rate, activation temperature and conversion, and the share of hot heat.

The absolute temperature of the contact is T₀ + T: T₀ is `sliding.background_temperature`, plus what the surface has
warmed after the `duration` of the scene, and T is the distribution about T_flash.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.errors import Estimate, estimate
from roughsim.estimate.levels import FLASH, Values, product, scaled, with_errors
from roughsim.estimate.reactions import (
    LEAST_MEMBERS,
    Activation,
    ContactMean,
    OverContact,
    bins_of,
    factor_of,
    heat_above,
    log_scale,
    mean_over_contact,
    mean_over_slides,
    of_uniform_temperature,
    rates,
    uniform_temperature,
)
from roughsim.estimate.sliding import stretched, warmed
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.prediction.distribution import ELECTRONVOLT
from roughsim.results.means import Means
from roughsim.results.share import has_own_share
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
from roughsim.scene.reactions import ReactionSection

RATE, ACTIVATION, CONVERSION, HEAT_ABOVE = (
    "reaction_rate",
    "activation_temperature",
    "conversion",
    "heat_share_above",
)
ABOUT = {
    RATE: "energy",
    ACTIVATION: "energy",
    CONVERSION: "energy",
    HEAT_ABOVE: "temperature",
}  # key of their rows
# lines of a scene that ask for them; without a name: for the distribution of the temperature alone
_ASKS = {
    RATE: "[reaction] with activation_energy and prefactor",
    ACTIVATION: "[reaction] with activation_energy and prefactor",
    CONVERSION: "[reaction] with activation_energy, prefactor and contact_length",
    HEAT_ABOVE: "[observables] with heat_above",
}
_SOLVER_SHARE = 2.0  # of the tolerance, of temperatures: as of observables that were not measured


class Asked(NamedTuple):
    """An estimate of a reaction at one energy, or of the heat above one temperature."""

    estimate: Estimate
    energy: float | None = None  # eV
    temperature: float | None = None  # absolute, K

    @property
    def key(self) -> tuple[str, float | None, float | None]:
        """Observable, energy and temperature."""
        return self.estimate.observable, self.energy, self.temperature


class _Contacts(NamedTuple):
    """The contacts of a column, whose temperatures are scaled to its T_flash."""

    column: str  # of single contacts
    samples: list[Sample]  # of the levels and of those below, or of slides, and at last `top`
    top: Sample  # of the highest level, or of the slides at the end of C(q)
    flash: Values  # reported T_flash, K
    background: Array  # T₀, absolute, K
    mean: Callable[[ContactMean], OverContact]  # over these contacts, with its errors


def _contacts_of(run: Means, column: str | None) -> _Contacts:
    """Return the contacts of a column; ValueError if it is missing."""
    solver = {"solver": _SOLVER_SHARE * run.numerics.tolerance}
    if column == SLIDING:
        pair, flash, stretch = run.slid()
        warm = np.zeros_like(flash.mean)
        if run.scene.sliding.duration is not None:
            warm = pair.sample.numbers["sliding_background"].mean(axis=0)
        background = (run.scene.sliding.background_temperature or 0.0) + warm
        top = stretched(pair.sample, stretch)
        mean = partial(mean_over_slides, pair, stretch)
        flash = with_errors(warmed(flash, warm, run.estimate("heat_partition", SLIDING)), **solver)
        return _Contacts(run.column(None), [pair.sample, top], top, flash, background, mean)
    name = run.column(column)
    pairs = run.pairs(name)
    samples = [
        sample for pair in pairs for sample in (pair.below, pair.sample) if sample is not None
    ]
    end = float(run.scene.spectrum.breaks[-1]) if run.drawn else samples[-1].q_max
    mean = partial(mean_over_contact, run.scene, name, pairs, end=end)
    flash = with_errors(_with_errors_of_background(run, name), **solver)
    return _Contacts(name, samples, samples[-1], flash, background_temperature(run, name), mean)


def _with_errors_of_background(run: Means, column: str) -> Values:
    """Return reported T_flash with the errors of T₀ too, where a share of each column makes both: they add."""
    flash = run.reported(FLASH, column)
    if not has_own_share(run.scene):
        return flash
    warm = scaled(run.values("heat_partition", column), prediction.background(run.scene))
    errors = {name: part + warm.errors[name] for name, part in flash.errors.items()}
    scatter = flash.scattered.plus(warm.scattered).scatter
    return flash._replace(errors=errors, scatter=scatter)


def not_asked(run: Means, name: str) -> ValueError:
    """Return the error that the scene of a run does not ask for an observable, or for the distribution itself."""
    lines = _ASKS.get(name, "[observables] with temperature_distribution = true")
    # members that have stored the distribution need not be computed again
    where = "again" if run.scene.distribution else "in another folder"
    return ValueError(
        f"{run.folder} has no {name}: its scene does not ask for it; add {lines} and run it {where}"
    )


def asked_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of the estimates that [reaction] and `heat_above` of a scene ask for."""
    names: list[str] = []
    if scene.reaction is not None:
        names += [RATE, ACTIVATION]
        if scene.reaction.contact_length is not None:
            names.append(CONVERSION)
    if scene.observables is not None and scene.observables.heat_above is not None:
        names.append(HEAT_ABOVE)
    return tuple(names)


def asked_estimates(run: Means, column: str | None = None) -> Iterator[Asked]:
    """Yield the estimates that [reaction] and `heat_above` of a scene ask for, over its speeds.

    ValueError if there is no such column, or no sound realization yet.
    """
    reaction, observables = run.scene.reaction, run.scene.observables
    if reaction is None and observables is None:
        return
    contacts = _contacts_of(run, column)
    if reaction is not None:
        for energy in reaction.activation_energy:
            for found in _reaction(run, reaction, energy, contacts):
                yield Asked(found, energy=round(energy / ELECTRONVOLT, 12))
    if observables is not None:
        for temperature in observables.heat_above or ():
            yield Asked(_heat_above(run, temperature, contacts), temperature=temperature)


def background_temperature(run: Means, column: str | None = None) -> Array:
    """Return T₀, absolute, of the surface of the moving body at each speed, K, by the share of heat of a column."""
    start = run.scene.sliding.background_temperature or 0.0
    return start + run.share(column) * prediction.background(run.scene)


def _reaction(
    run: Means, reaction: ReactionSection, energy: float, contacts: _Contacts
) -> Iterator[Estimate]:
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
    rate = product(of_contact, run.values("contact_fraction", contacts.column))
    yield _estimate(run, RATE, rate, over)
    yield _estimate(run, ACTIVATION, warm.values, warm)
    if reaction.contact_length is not None:
        yield _conversion(run, rate, over, reaction.contact_length)


def _conversion(run: Means, rate: Values, over: OverContact, length: float) -> Estimate:
    """Return 1 − exp(−k t) of the rate k after the time t that a point spends in a nominal contact of a length, m."""
    with np.errstate(divide="ignore"):
        time = length / np.array(run.scene.speeds)
    with np.errstate(invalid="ignore", over="ignore"):
        done = rate.mean * time
        left = np.exp(-done)
        factor = np.where(np.isinf(time), 0.0, time * left)
    errors = {name: factor * part for name, part in rate.errors.items()}
    scatter = {stream: rows * factor for stream, rows in rate.scatter.items()}
    values = rate._replace(
        mean=-np.expm1(-done), finest=-np.expm1(-rate.finest * time), errors=errors, scatter=scatter
    )
    return _estimate(run, CONVERSION, values, over)


def _heat_above(run: Means, temperature: float, contacts: _Contacts) -> Estimate:
    """Return the share of the heat where the contact is hotter than an absolute temperature, K."""
    of_bins = partial(heat_above, excess=temperature - contacts.background)
    over = contacts.mean(ContactMean(of_bins, contacts.flash, by_contact=True))
    values = over.values._replace(mean=np.clip(over.values.mean, 0.0, 1.0))
    return _estimate(run, HEAT_ABOVE, values, over)


def _estimate(run: Means, observable: str, values: Values, over: OverContact) -> Estimate:
    """Return an estimate; the scatter of a mean that few members carry is unknown."""
    note = f"T₀ + T of the contact, with {np.round(over.members, 1).tolist()} effective members over the speeds"
    found = estimate(observable, values, (note,))
    statistical = np.where(over.members < LEAST_MEMBERS, np.nan, found.budget["statistical"])
    return replace(
        found,
        budget=found.budget | {"statistical": statistical},
        speeds=run.scene.speeds,
        sources=run.sources,
    )
