"""Reactions of the surface of the moving body: rate, activation temperature and conversion, and the share of hot heat.

The absolute temperature of the contact is T₀ + T: T₀ is `sliding.background_temperature`, plus what the surface has
warmed after the `duration` of the scene, and T is the distribution about T_flash.
"""

from dataclasses import replace

import numpy as np

from roughsim import prediction
from roughsim.estimate.asked import ASKED, asked_of
from roughsim.estimate.levels import FLASH, PIXEL_FALL
from roughsim.estimate.mean import Mean
from roughsim.estimate.reactions import Contacts, law_of_flash
from roughsim.estimate.sliding import stretched, warmed
from roughsim.grid import Array
from roughsim.results.means import Means
from roughsim.results.share import has_own_share
from roughsim.scene.numerics import SLIDING
from roughsim.table import Estimate

_SOLVER_SHARE = 2.0  # of the tolerance, of temperatures: as of observables that were not measured


def _contacts_of(run: Means, column: str | None) -> Contacts:
    """Return the contacts of a column; ValueError if it is missing."""
    scene, solver = run.scene, _SOLVER_SHARE * run.numerics.tolerance
    if column == SLIDING:
        slides, flash, stretch = run.slid()
        warm = np.zeros_like(flash.value)
        if scene.sliding.duration is not None:
            warm = slides.numbers["sliding_background"].mean(axis=0)
        background = (scene.sliding.background_temperature or 0.0) + warm
        flash = warmed(flash, warm, run.estimate("heat_partition", SLIDING))
        return Contacts(
            [stretched(slides, stretch)],
            flash.with_errors(solver=solver),
            run.values("contact_fraction"),
            background,
            scene.speeds,
            sources=run.sources,
        )
    name = run.column(column)
    samples = run.samples(name)
    return Contacts(
        samples,
        _with_errors_of_background(run, name).with_errors(solver=solver),
        run.values("contact_fraction", name),
        background_temperature(run, name),
        scene.speeds,
        law_of_flash(scene, name),
        float(scene.spectrum.breaks[-1]) if run.drawn else samples[-1].q_max,
        PIXEL_FALL[name],
        sources=run.sources,
    )


def _with_errors_of_background(run: Means, column: str) -> Mean:
    """Return reported T_flash with the errors of T₀ too, where a share of each column makes both: they add."""
    flash = run.reported(FLASH, column)
    if not has_own_share(run.scene):
        return flash
    both = flash + run.values("heat_partition", column) * prediction.background(run.scene)
    errors = {name: both.errors[name] for name in flash.errors}
    return replace(flash, errors=errors, influence=both.influence)


def not_asked(run: Means, name: str) -> ValueError:
    """Return the error that the scene of a run does not ask for an observable, or for the distribution itself."""
    asked = ASKED.get(name)
    lines = asked.lines if asked else "[observables] with temperature_distribution = true"
    # members that have stored the distribution need not be computed again
    where = "again" if run.scene.distribution else "in another folder"
    return ValueError(
        f"{run.folder} has no {name}: its scene does not ask for it; add {lines} and run it {where}"
    )


def asked_estimates(run: Means, column: str | None = None) -> dict[str, Estimate]:
    """Return what [reaction] and `heat_above` of a scene ask for, as `asked_of`.

    ValueError if there is no such column, or no sound realization yet.
    """
    if run.scene.reaction is None and run.scene.observables is None:
        return {}
    return asked_of(run.scene, _contacts_of(run, column))


def background_temperature(run: Means, column: str | None = None) -> Array:
    """Return T₀, absolute, of the surface of the moving body at each speed, K, by the share of heat of a column."""
    start = run.scene.sliding.background_temperature or 0.0
    return start + run.share(column) * prediction.background(run.scene)
