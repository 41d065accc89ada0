"""The refusal of a run whose scene does not ask for reactions, or for the distribution of the temperature."""

from roughsim.estimate.asked import ASKED
from roughsim.results.means import Means


def not_asked(run: Means, name: str) -> ValueError:
    """Return the error that the scene of a run does not ask for an observable, or for the distribution itself."""
    asked = ASKED.get(name)
    lines = asked.lines if asked else "[observables] with temperature_distribution = true"
    # members that have stored the distribution need not be computed again
    where = "again" if run.scene.distribution else "in another folder"
    return ValueError(
        f"{run.folder} has no {name}: its scene does not ask for it; add {lines} and run it {where}"
    )
