"""Estimates of the column calibrated: quantiles and reactions of contacts that the law draws, with all their errors.

The contacts are members without a solver (`roughsim.prediction.fields`), and are averaged as members are, but for
their quantiles, which are the mean over the fields. Two parts
of the error are their own: "form", as solved contacts are evener than the fields, the slower the more if these are not
corrected at rest, and "law".
"""

from dataclasses import replace
from functools import partial

import numpy as np

from roughsim import prediction
from roughsim.estimate.asked import asked_of
from roughsim.estimate.contacts import SETTLED, SHIFTS, WALKED, Contacts, form_uncertainty
from roughsim.estimate.errors import estimate
from roughsim.estimate.levels import FLASH
from roughsim.estimate.mean import Mean, exact, mean_of
from roughsim.estimate.reactions import rest_of
from roughsim.estimate.sliding import HOT, sliding_quantile, stretch_of, stretched
from roughsim.estimate.telescoping import telescoped
from roughsim.grid import Array
from roughsim.observables.catalogue import DISTRIBUTION, OBSERVABLES
from roughsim.observables.distribution import LEVELS
from roughsim.observables.record import Sample, ratio
from roughsim.prediction.fields import FrozenFields
from roughsim.scene import Scene
from roughsim.scene.numerics import SAME
from roughsim.table import Estimate

QUANTILES = tuple(name for name, record in OBSERVABLES.items() if record.asked == DISTRIBUTION)
_FURTHEST = 2.0  # steps of the cut-off, to twice as high a one, by which fields are continued
_OF_SLIDES = 0.15  # chosen wide: beside solved slides .06 rms, at most .15, at 99 % (experiments/sliding_reactions.py)


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
) -> Contacts:
    """Return frozen contacts as a column; `end` of C(q), rad/m, `uncertainty` by their form, 0 of solved ones."""
    nothing = np.zeros_like(flash.value)
    lowest, *others = fields.samples
    samples = [lowest, *(replace(sample, below=lowest) for sample in others)]
    law = SETTLED
    if others and samples[-1].q_max < end * (1.0 - SAME):
        # the temperature below which a share of the heat is set free is linear in T_flash; here it is over T_flash
        below, high, last = fields.flash
        with np.errstate(all="ignore"):
            steps = np.clip(np.nan_to_num((last - high) / (high - below)), 0.0, _FURTHEST)
        growth = steps * below / (high + steps * (high - below))
        law = np.stack([nothing, nothing + 1.0, 1.0 + growth])
    return Contacts(samples, flash, flash, nothing, speeds, law, end, form=uncertainty)


def drawn_slides(
    sample: Sample, flash: Mean, stretch: Array, speeds: tuple[float, ...] = ()
) -> Contacts:
    """Return slides as a column, of which temperatures about T_flash grow by `stretch` up to the end of C(q)."""
    samples = [stretched(sample, stretch)]
    nothing = np.zeros_like(flash.value)
    return Contacts(samples, flash, flash, nothing, speeds, stretch=stretch, form=_OF_SLIDES)


def quantile_of(contacts: Contacts, name: str) -> Mean:
    """Return a quantile of the temperature of drawn contacts by its name, K."""
    flash = contacts.flash
    stretch = contacts.stretch
    if stretch is not None:

        def slid(sample: Sample) -> Mean:
            return sliding_quantile(flash, sample.numbers[f"sliding_{name}"], sample, stretch)

        found = slid(contacts.samples[-1])
        form = contacts.by_form(lambda sample: slid(sample).value)
        return replace(found, errors={**found.errors, "form": form})
    top = telescoped(partial(_over_flash, name=name), contacts.samples)[-1].mean
    # points of one temperature change together, by heat and by area: once all has yielded both are equal
    by_heat = [
        telescoped(partial(_over_flash, name=each), contacts.samples)
        for each in QUANTILES[: len(LEVELS)]
    ]
    tops = np.array([levels[-1].mean.value for levels in by_heat])
    rests = np.array([rest_of(levels, contacts.law).value for levels in by_heat])
    columns = zip(top.value, tops.T, rests.T, strict=True)
    rest = np.array([np.interp(*column) for column in columns])
    value = top.value + rest
    form = contacts.by_form(lambda sample: _over_flash(sample, name).mean(axis=0))
    errors = {
        "bandwidth": flash.value * np.abs(rest),
        "form": flash.value * form,
        "law": flash.errors["law"] * np.abs(value),
    }
    return replace(top * flash.value, value=flash.value * value, errors=errors)


def _over_flash(sample: Sample, name: str) -> Array:
    """Return influence values of a quantile over T_flash.

    It is the mean of those of each field: at rest each has the whole distribution, and all together were .07 T_flash
    (rms) off at 99 % of the heat of 28 contacts, the mean .05.
    """
    return ratio(sample.numbers[name], sample.numbers[FLASH])


def _frozen(scene: Scene, *, walk: bool = True) -> Contacts | None:
    """Return the drawn contacts of a scene that slide frozen; None where it has none."""
    fields = prediction.frozen_fields(scene, walk=walk)
    if fields is None:
        return None
    speeds = np.array(scene.speeds)
    flash = prediction.calibrated_over_speed(scene, speeds)[FLASH]
    band = prediction.calibrated(scene).errors[FLASH]
    end = float(scene.spectrum.breaks[-1])
    uncertainty, shifts = WALKED if fields.walked else (_uncertainty(scene), SHIFTS)
    drawn = drawn_frozen(fields, end, by_law(flash, band), uncertainty, scene.speeds)
    return drawn._replace(shifts=shifts)


def _uncertainty(scene: Scene) -> Array:
    """Return how uncertain T/T_flash of drawn contacts is by their form, (speeds,)."""
    length = scene.spectrum.rms_height / scene.spectrum.rms_slope
    peclet_number = np.array(scene.speeds) * length / prediction.conduction(scene).diffusivity
    return form_uncertainty(peclet_number)


def _slid(scene: Scene) -> Contacts | None:
    """Return the drawn slides of a scene; None where it has none."""
    sample = prediction.slid_fields(scene)
    frozen = _frozen(scene, walk=False)
    slid = prediction.sliding_prediction(scene)
    if sample is None or frozen is None or slid is None:
        return None
    flash = by_law(slid.flash_temperature, prediction.sliding_error(scene), "slide")
    lowest = _over_flash(frozen.samples[0], HOT).mean(axis=0)
    stretch = stretch_of(frozen.flash, quantile_of(frozen, HOT), lowest)
    return drawn_slides(sample, flash, stretch, scene.speeds)


def quantiles(scene: Scene, *, sliding: bool = False) -> dict[str, Estimate]:
    """Return each quantile of the temperature, K, with all heat in the moving body; empty where there is none.

    `sliding` is of two bodies that slide, with the moving body's own share of the heat.
    """
    drawn = _slid(scene) if sliding else _frozen(scene)
    if drawn is None:
        return {}
    return {
        name: estimate(name, quantile_of(drawn, name), speeds=scene.speeds) for name in QUANTILES
    }


def hottest_seen(scene: Scene) -> Estimate | None:
    """Return what 1 % of the picture of a camera exceeds, K, with all heat in the moving body; None if unknown.

    It is the rms of the law times the mean ratio in pictures of drawn contacts: of light ones it is within 1 % of the
    ratio in all pictures together. Their last step to a higher cut-off counts as error, and form and law as for the
    quantiles of the temperature.
    """
    drawn = prediction.drawn_pictures(scene)
    if not drawn:
        return None
    law = prediction.calibrated_predictions(scene)
    rms = np.nan_to_num(law["seen_rms"])
    flash = np.nan_to_num(law[FLASH])
    mean = mean_of(0, drawn[-1]) * rms
    last_step = drawn[-1].mean(axis=0) - drawn[0].mean(axis=0)
    errors = {
        "bandwidth": rms * np.abs(last_step),
        "form": _uncertainty(scene) * flash,
        "law": prediction.calibrated(scene).errors[FLASH] * mean.value,
    }
    return estimate("seen_99", replace(mean, errors=errors), speeds=scene.speeds)


def asked(scene: Scene, *, sliding: bool = False) -> dict[str, Estimate]:
    """Return reactions and the share of hot heat that a scene asks for, with its share of the heat, as `asked_of`."""
    drawn = _slid(scene) if sliding else _frozen(scene)
    law = prediction.calibrated(scene)
    if drawn is None or law.stress_spectrum is None:
        return {}
    start = scene.background_temperature or 0.0
    share = np.ones(len(scene.speeds))
    warm = np.zeros(len(scene.speeds))
    slid = prediction.sliding_prediction(scene) if sliding else None
    if slid is None:
        share = prediction.calibrated_share(scene)
        warm = share * prediction.background(scene)
    elif scene.sliding.warms:
        warm = slid.contact_temperature - slid.flash_temperature
    area = by_law(np.full(1, law.stress_spectrum.contact_fraction), law.errors["contact_fraction"])
    flash = drawn.flash * share
    return asked_of(scene, drawn._replace(flash=flash, area=area, background=start + warm))
