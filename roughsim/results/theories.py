"""The theories of a scene as columns of results: of all of C(q), calibrated, and calibrated of two sliding bodies.

They need no run. Each column is one function of an observable; those of a run stand in `roughsim.results.columns`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial

import numpy as np

from roughsim import prediction
from roughsim.estimate import fields
from roughsim.estimate.asked import ABOUT
from roughsim.estimate.errors import speed_axis
from roughsim.estimate.levels import FLASH
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, UNITS
from roughsim.prediction.values import Predicted
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
from roughsim.table import Estimate, concat

THEORY, CALIBRATED, SLIDING_CALIBRATED = "theory", "calibrated", "sliding_calibrated"
# theories over all of C(q), with their meanings, in the order of tables; `theory_columns` has their functions
THEORIES = {
    THEORY: "the analytic theory over the whole spectrum C(q)",
    CALIBRATED: "the theory with a stress spectrum fitted to simulations, with the error of the fit, in the range "
    "compared with simulations",
}
SEEN_99 = "seen_99"  # of drawn contacts, as quantiles are
CONTACT_TEMPERATURE = "contact_temperature"  # T₀(t) + T_flash, of scenes with a duration
ColumnOf = Callable[[str], Estimate | None]  # of an observable; None where the column lacks it


def theory_columns(scene: Scene) -> dict[str, ColumnOf]:
    """Return the theories of a scene, each as a function of the name of an observable; it is computed when asked for.

    Temperatures are with the share of the heat that each theory has.
    """
    share = cache(partial(prediction.heat_partition, scene))
    by_law = cache(partial(prediction.calibrated_predictions, scene))
    columns: dict[str, ColumnOf] = {
        THEORY: partial(of_theory, scene, partial(prediction.predictions, scene), share),
        CALIBRATED: partial(
            _by_law, cache(partial(_of_fields, scene)), partial(_calibrated, scene, by_law)
        ),
    }
    if scene.sliding.history == SLIDING:
        of_fields = cache(partial(_of_fields, scene, sliding=True))
        sliding = partial(_sliding_theory, scene, by_law)
        columns[SLIDING_CALIBRATED] = partial(_by_law, of_fields, sliding)
    return columns


def joined(
    columns: Mapping[str, ColumnOf], observables: Iterable[str], directions: Sequence[float] = ()
) -> dict[str, Estimate]:
    """Return observables by name along the axes of columns and `directions`; those that no column has are left out."""
    estimates = {}
    for name in observables:
        found = {(k,): column(name) for k, column in enumerate(columns.values())}
        pieces = {
            place: one.by_direction(directions) for place, one in found.items() if one is not None
        }
        if pieces:
            estimates[name] = concat(pieces, {"column": np.array([*columns])})
    return estimates


def exact(
    scene: Scene, observable: str, mean: Array, budget: Mapping[str, Array] | None = None
) -> Estimate:
    """Return values over the speed, or one value, without realizations."""
    axis = speed_axis(observable, mean, scene.speeds)
    unit = "K" if observable == CONTACT_TEMPERATURE else UNITS[observable]
    return Estimate.of(observable, unit, mean, axis, budget)


def with_share(scene: Scene, predicted: Predicted, observable: str, share: Array) -> Array | None:
    """Return an observable by a theory, temperatures times a share of the heat; None if it has no theory."""
    if observable == CONTACT_TEMPERATURE:
        return (predicted[FLASH] + prediction.background(scene)) * share
    if observable not in OBSERVABLES:
        return None
    heated = OBSERVABLES[observable].heated
    return predicted[observable] * share if heated else predicted[observable]


def of_theory(
    scene: Scene, predicted: Callable[[], Predicted], share: Callable[[], Array], observable: str
) -> Estimate | None:
    """Return an observable by a theory of a scene; it states no error."""
    mean = with_share(scene, predicted(), observable, share())
    return None if mean is None else exact(scene, observable, mean)


def _by_law(
    of_fields: Callable[[], Mapping[str, Estimate]], of_means: ColumnOf, observable: str
) -> Estimate | None:
    """Return what the distribution of the temperature in drawn contacts gives, or an observable by its mean."""
    if observable in (*fields.QUANTILES, *ABOUT, SEEN_99):
        return of_fields().get(observable)
    return of_means(observable)


def _calibrated(scene: Scene, by_law: Callable[[], Predicted], observable: str) -> Estimate | None:
    """Return an observable by the calibrated law with the error of the law, where that was measured."""
    mean = with_share(scene, by_law(), observable, prediction.calibrated_share(scene))
    if mean is None:
        return None
    band: Array | float | None = prediction.calibrated(scene).errors.get(observable)
    if band is None:
        band = prediction.error_of_law(scene, observable)
    budget = {} if band is None else {"law": np.abs(mean) * band}
    return exact(scene, observable, mean, budget)


def _of_fields(scene: Scene, *, sliding: bool = False) -> dict[str, Estimate]:
    """Return quantiles of the temperature, reactions and the share of hot heat in contacts that the law draws."""
    share = 1.0 if sliding else prediction.calibrated_share(scene)
    quantiles = fields.quantiles(scene, sliding=sliding).items()
    found = {name: one.times(share) for name, one in quantiles}
    hottest = None if sliding else fields.hottest_seen(scene)
    if hottest is not None:
        found[hottest.observable] = hottest.times(share)
    return found | fields.asked(scene, sliding=sliding)


def _sliding_theory(
    scene: Scene, by_law: Callable[[], Predicted], observable: str
) -> Estimate | None:
    """Return an observable by the calibrated theory of two bodies that slide; T_flash with its error."""
    slid = prediction.sliding_prediction(scene)
    if slid is None:
        return None
    if observable == "contact_fraction":
        return exact(scene, observable, by_law()[observable])
    mean = getattr(slid, observable, None)
    if mean is None:
        return None
    budget = {"law": mean * prediction.sliding_error(scene)} if observable == FLASH else {}
    return exact(scene, observable, mean, budget)
