"""Estimates of the column calibrated: quantiles and reactions of contacts that the law draws, with all their errors.

The contacts are members without a solver (`roughsim.prediction.fields`), and are averaged as members are. Two parts
of the error are their own: "form", as solved contacts are evener than the fields, the slower the more, and "law".
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughsim import prediction
from roughsim.estimate.asked import asked_of
from roughsim.estimate.errors import estimate
from roughsim.estimate.levels import FLASH
from roughsim.estimate.mean import Mean, exact
from roughsim.estimate.reactions import Contacts, bins_of, rest_of
from roughsim.estimate.sliding import HOT, sliding_quantile, stretch_of, stretched
from roughsim.estimate.telescoping import LevelMean, telescoped
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.distribution import BIN_AREAS, LEVELS
from roughsim.observables.record import Sample, ratio
from roughsim.prediction.fields import FrozenFields
from roughsim.scene import Scene
from roughsim.table import Estimate

QUANTILES = tuple(name for name, record in OBSERVABLES.items() if record.asked)
_FURTHEST = 2.0  # steps of the cut-off, to twice as high a one, by which fields are continued
# of `form_uncertainty`: at 1, its fall, least and most. Set on 29 contacts that were drawn by chance, tested on 13
# others (experiments/reactions.py)
_AT_ONE, _PER_E_FOLD, _UNCERTAINTIES = 0.17, 0.02, (0.06, 0.24)
_OF_SLIDES = 0.15  # chosen wide: beside solved slides .06 rms, at most .15, at 99 % (experiments/sliding_reactions.py)
_SHIFT = (
    1.4  # of all temperatures, over T_flash and the uncertainty: contact that the law lacks is cold
)


class Drawn(NamedTuple):
    """Contacts that the law draws, as a column; temperatures are with all their heat in the moving body."""

    contacts: Contacts
    quantile: Callable[[str], Mean]  # by its name


def form_uncertainty(peclet_number: ArrayLike) -> Array:
    """Return how uncertain T/T_flash is by the form of the fields at v h_rms/(D h′), dimensionless."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.clip(_AT_ONE - _PER_E_FOLD * np.log(peclet_number), *_UNCERTAINTIES))


def by_law(value: Array, band: float, part: str = "bandwidth") -> Mean:
    """Return T_flash, K, or the contact area of the law with its relative error; `part` is that of their contacts."""
    nothing = np.zeros_like(value)
    return replace(exact(value), errors={part: nothing, "form": nothing, "law": band * value})


def drawn_frozen(
    fields: FrozenFields,
    end: float,
    flash: Mean,
    uncertainty: Array | float,
    speeds: tuple[float, ...] = (),
) -> Drawn:
    """Return frozen contacts as a column; `end` of C(q), rad/m, `uncertainty` by their form, 0 of solved ones."""
    nothing = np.zeros_like(flash.value)
    below: Sample | None = None
    samples: list[Sample] = []
    for sample in fields.samples:
        samples.append(replace(sample, below=below))
        below = sample

    def law(_: tuple[float, ...]) -> Array:
        """The temperature below which a share of the heat is set free is linear in T_flash; here it is over T_flash."""
        below, high, last = fields.flash
        with np.errstate(all="ignore"):
            steps = np.clip(np.nan_to_num((last - high) / (high - below)), 0.0, _FURTHEST)
        growth = steps * below / (high + steps * (high - below))
        return np.stack([nothing, nothing + 1.0, 1.0 + growth])

    def levels_of(name: str) -> list[LevelMean]:
        return telescoped(partial(_over_flash, name=name), samples)

    def by_form(value: Callable[[Sample], Array]) -> Array:
        return _by_form(value, samples[-1], uncertainty)

    by_heat = [levels_of(name) for name in QUANTILES[: len(LEVELS)]]
    tops = np.array([levels[-1].mean.value for levels in by_heat])
    rests = np.array([rest_of(levels, end, law)[0].value for levels in by_heat])

    def quantile(name: str) -> Mean:
        top = levels_of(name)[-1].mean
        # points of one temperature change together, by heat and by area: once all has yielded both are equal
        columns = zip(top.value, tops.T, rests.T, strict=True)
        rest = np.array([np.interp(*column) for column in columns])
        value = top.value + rest
        form = by_form(lambda sample: _over_flash(sample, name).mean(axis=0))
        errors = {
            "bandwidth": flash.value * np.abs(rest),
            "form": flash.value * form,
            "law": flash.errors["law"] * np.abs(value),
        }
        return replace(top * flash.value, value=flash.value * value, errors=errors)

    contacts = Contacts(samples, flash, flash, nothing, speeds, law, end, by_form=by_form)
    return Drawn(contacts, quantile)


def drawn_slides(
    sample: Sample, flash: Mean, stretch: Array, speeds: tuple[float, ...] = ()
) -> Drawn:
    """Return slides as a column, of which temperatures about T_flash grow by `stretch` up to the end of C(q)."""

    def quantile(name: str) -> Mean:
        def values(sample: Sample) -> Mean:
            return sliding_quantile(flash, name, sample.numbers, 0, stretch)

        found = values(sample)
        form = _by_form(lambda each: values(each).value, sample, _OF_SLIDES)
        return replace(found, errors={**found.errors, "form": form})

    def by_form(value: Callable[[Sample], Array]) -> Array:
        return _by_form(lambda each: value(stretched(each, stretch)), sample, _OF_SLIDES)

    nothing = np.zeros_like(flash.value)
    samples = [stretched(sample, stretch)]
    return Drawn(Contacts(samples, flash, flash, nothing, speeds, by_form=by_form), quantile)


def _over_flash(sample: Sample, name: str) -> Array:
    """Return influence values of a temperature over T_flash."""
    return ratio(sample.numbers[name], sample.numbers[FLASH])


def _by_form(value: Callable[[Sample], Array], sample: Sample, uncertainty: Array | float) -> Array:
    """Return the error of a value by the form of the fields, whose changes add as squares."""
    plain = value(sample)
    changes = [value(other) - plain for other in _displaced(sample, uncertainty)]
    return np.asarray(np.sqrt(sum(np.square(change) for change in changes)))


def _displaced(sample: Sample, uncertainty: Array | float) -> Iterator[Sample]:
    """Yield samples as far from a given one as its form is uncertain, 95 %, with the same T_flash.

    At the distance x from T_flash, over T_flash, the hotter, or the colder points, are nearer to it by
    `uncertainty`·x^(3/2); or all are hotter by 1.4 `uncertainty`.
    """
    flash, bins = sample.numbers[FLASH].mean(axis=0), bins_of(sample)
    hot = {name: values for name, values in sample.numbers.items() if "quantile" in name}
    apart = np.broadcast_to(uncertainty, flash.shape)
    over = bins.temperature / flash[:, None]
    heat = BIN_AREAS * bins.pressure
    for side in (1.0, -1.0):
        evened = _evened(over, apart[:, None], side)
        # they have another mean, but T_flash is given
        unit = flash / ((heat * evened).sum(axis=(0, 2)) / (heat * over).sum(axis=(0, 2)))
        numbers = {
            name: unit * _evened(values / flash, apart, side) for name, values in hot.items()
        }
        yield replace(
            sample,
            numbers=sample.numbers | numbers,
            bins=bins._replace(temperature=unit[:, None] * evened),
        )
    warmer = 1.0 + _SHIFT * apart
    yield replace(
        sample,
        numbers=sample.numbers | {name: warmer * values for name, values in hot.items()},
        bins=bins._replace(temperature=warmer[:, None] * bins.temperature),
    )


def _evened(ratio: Array, uncertainty: Array, side: float) -> Array:
    """Return T/T_flash with the hotter points, `side` 1, or the colder ones, −1, nearer to 1."""
    excess = ratio - 1.0
    with np.errstate(divide="ignore"):  # further out all come to the same: the order stays
        apart = np.minimum(np.abs(excess), 4.0 / 9.0 / uncertainty**2)
    nearer = 1.0 + np.sign(excess) * (apart - uncertainty * apart**1.5)
    return np.where(side * excess > 0.0, nearer, ratio)


def _frozen(scene: Scene) -> Drawn | None:
    """Return the drawn contacts of a scene that slide frozen; None where it has none."""
    fields = prediction.frozen_fields(scene)
    if fields is None:
        return None
    speeds = np.array(scene.speeds)
    flash = prediction.calibrated_over_speed(scene, speeds)[FLASH]
    length = scene.spectrum.rms_height / scene.spectrum.rms_slope
    uncertainty = form_uncertainty(speeds * length / prediction.conduction(scene).diffusivity)
    band = prediction.calibrated(scene).errors[FLASH]
    end = float(scene.spectrum.breaks[-1])
    return drawn_frozen(fields, end, by_law(flash, band), uncertainty, scene.speeds)


def _slid(scene: Scene) -> Drawn | None:
    """Return the drawn slides of a scene; None where it has none."""
    sample, frozen = prediction.slid_fields(scene), _frozen(scene)
    slid = prediction.sliding_prediction(scene)
    if sample is None or frozen is None or slid is None:
        return None
    flash = by_law(slid.flash_temperature, prediction.sliding_error(scene), "slide")
    contacts = frozen.contacts
    stretch = stretch_of(contacts.flash, frozen.quantile(HOT), contacts.samples[0])
    return drawn_slides(sample, flash, stretch, scene.speeds)


def quantiles(scene: Scene, *, sliding: bool = False) -> dict[str, Estimate]:
    """Return each quantile of the temperature, K, with all heat in the moving body; empty where there is none.

    `sliding` is of two bodies that slide, with the moving body's own share of the heat.
    """
    drawn = _slid(scene) if sliding else _frozen(scene)
    if drawn is None:
        return {}
    return {name: estimate(name, drawn.quantile(name), speeds=scene.speeds) for name in QUANTILES}


def asked(scene: Scene, *, sliding: bool = False) -> dict[str, Estimate]:
    """Return reactions and the share of hot heat that a scene asks for, with its share of the heat, as `asked_of`."""
    drawn = _slid(scene) if sliding else _frozen(scene)
    law = prediction.calibrated(scene)
    if drawn is None or law.stress_spectrum is None:
        return {}
    start = scene.sliding.background_temperature or 0.0
    share, warm = np.ones(len(scene.speeds)), np.zeros(len(scene.speeds))
    slid = prediction.sliding_prediction(scene) if sliding else None
    if slid is None:
        share = prediction.calibrated_share(scene)
        warm = share * prediction.background(scene)
    elif scene.sliding.duration is not None:
        warm = slid.contact_temperature - slid.flash_temperature
    area = by_law(np.full(1, law.stress_spectrum.contact_fraction), law.errors["contact_fraction"])
    flash = drawn.contacts.flash * share
    return asked_of(scene, drawn.contacts._replace(flash=flash, area=area, background=start + warm))
