"""`plot_run`: draws one quantity of a run as a map or a curve, and chooses the file."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from roughsim.charts.maps import Zoom, map_chart, side_by_side_chart
from roughsim.charts.reaction import over_speed_chart, reaction_chart
from roughsim.charts.sliding import sliding_chart
from roughsim.charts.snapshots import snapshots_chart
from roughsim.charts.spectra import correlation_chart, spectrum_chart
from roughsim.charts.style import FIELDS, USUAL, Look, Subject, beside, check_ending
from roughsim.charts.temperature import distribution_chart, profile_chart
from roughsim.errors import number
from roughsim.estimate.asked import ABOUT
from roughsim.results.heated import DERIVED_UNITS
from roughsim.results.run import Run
from roughsim.results.snapshots import no_snapshots, pictured
from roughsim.scene.numerics import SLIDING

CURVES: dict[str, Callable[[Subject, Path], None]] = {
    "distribution": distribution_chart,
    "spectrum": spectrum_chart,
    "correlation": correlation_chart,
    "profile": profile_chart,
    "sliding": sliding_chart,
    "reaction": reaction_chart,
    **{name: partial(over_speed_chart, name) for name in ABOUT},
    "snapshots": snapshots_chart,
}
QUANTITIES = (*FIELDS, *CURVES)
_OF_REACTIONS = ("reaction", *ABOUT)
_OF_ALL = ("correlation", "sliding", *_OF_REACTIONS)  # means over all realizations, without fields
_NEEDS_SPEED = (*DERIVED_UNITS, "distribution", "profile")


def _choose_subject(
    quantity: str, run: Run, realization: int | None, speed: float | None, column: str | None
) -> Subject:
    """Return the data that a quantity is drawn from; ValueError without kept fields, or if an argument does not fit."""
    if quantity == "sliding" and column is not None:
        raise ValueError(f"column = {column!r}: sliding has a column of its own; leave it out")
    slid = column == SLIDING and SLIDING in run.simulated_columns
    slides = quantity in _OF_REACTIONS and slid and run.simulated(SLIDING).reacts
    name = SLIDING if slides else run.column(column)
    level = run.picture(None if slides else name)
    if quantity not in _OF_ALL:
        indices = run.kept(level)
        if not indices or (realization is not None and realization not in indices):
            raise run.not_kept(level, realization)
        if realization is None and quantity != "spectrum":  # which uses all kept realizations
            realization = indices[0]
    elif realization is not None:
        raise ValueError(
            f"realization = {realization}: {quantity} is a mean over all of them; leave it out"
        )
    return Subject(run, name, level, realization, _choose_speed(run, quantity, speed))


def _choose_speed(run: Run, quantity: str, speed: float | None) -> float | None:
    """Return the speed to draw, m/s: the given one, or the highest; None if the quantity does not depend on it."""
    if quantity not in _NEEDS_SPEED:
        if speed is not None:
            raise ValueError(
                f"speed = {speed:g} m/s: {quantity} does not depend on it; leave it out"
            )
        return None
    chosen = max(run.scene.speeds) if speed is None else number("speed", speed, "m/s")
    if chosen == 0.0:
        raise ValueError("speed = 0 m/s makes no heat to draw; give a speed, for example 1")
    return chosen


def _choose_snapshots(
    run: Run, realization: int | None, speed: float | None, column: str | None
) -> Subject:
    """Return the data of snapshots; ValueError if they were not kept, or the slide does not follow that speed."""
    if column is not None:
        raise ValueError(f"column = {column!r}: snapshots have a column of their own; leave it out")
    indices = pictured(run)
    if not indices or (realization is not None and realization not in indices):
        raise no_snapshots(run, realization or 0)
    speed = max(run.scene.speeds) if speed is None else number("speed", speed, "m/s")
    if speed not in run.scene.speeds:
        followed = ", ".join(f"{v:g}" for v in run.scene.speeds)
        raise ValueError(
            f"speed = {speed:g} m/s: the slide has followed {followed} m/s; choose one of them"
        )
    index = indices[0] if realization is None else realization
    return Subject(run, SLIDING, run.numerics.slide or 0, index, speed)


def plot_run(
    run: Run,
    quantity: str,
    path: str | Path | None = None,
    *,
    realization: int | None = None,
    speed: float | None = None,
    column: str | None = None,
    zoom: Zoom | None = None,
    side_by_side: bool | None = None,
    look: Look = USUAL,
) -> Path:
    """Draw one quantity of a run, and return the path of the picture.

    Maps are of "heights", "pressure", "temperature", "heat_flux", or "seen", the temperature through the [camera].
    "distribution" shows the distribution of the temperature over the contact, "profile" the line along x through
    the hottest point, "spectrum" the power spectra of the kept heights and of the stress, "correlation" g_σ(r),
    "sliding" temperatures and share over the slid distance, "reaction" temperatures and rates of a run with
    [reaction], also of the column "sliding", as "reaction_rate" and the other rows that a scene asks for over the
    speed, "snapshots" pressure and temperature at four slid distances.

    `path` ends in .png, .pdf or .svg; default: a .png beside the run folder. `realization` is by default the first kept
    one, or all for spectra, `speed` the scene's highest, m/s, `column` as in `Run.estimate`. Of a map `zoom` draws the
    points between these ends along x and along y, m, and `side_by_side` heights, pressure and temperature (or heat_flux
    if that is the quantity) beside each other.

    `look` sets title and size of the figure, and whether the drawn numbers get a file. ValueError if an argument is
    unknown or does not fit the quantity, or if the field was not kept.
    """
    if quantity not in QUANTITIES:
        raise ValueError(
            f"quantity = {quantity!r} cannot be drawn; choose one of {', '.join(QUANTITIES)}"
        )
    if quantity not in FIELDS and (zoom is not None or side_by_side):
        maps = ", ".join(FIELDS)
        raise ValueError(
            f"zoom and side_by_side are for maps, and {quantity} is not a map; choose one of {maps}"
        )
    if path is None:
        at = "" if realization is None else f"r{realization}"
        words = quantity, column, at, "" if speed is None else f"{speed:g}mps"
        path = beside(run.folder, *filter(None, words))
    path = Path(path)
    check_ending(path)
    if side_by_side and quantity not in DERIVED_UNITS:
        quantity = "temperature"  # the third field
    choose = _choose_snapshots if quantity == "snapshots" else partial(_choose_subject, quantity)
    subject = replace(choose(run, realization, speed, column), look=look)
    if side_by_side:
        side_by_side_chart(subject, quantity, path, zoom)
    elif quantity in FIELDS:
        map_chart(subject, quantity, path, zoom)
    else:
        CURVES[quantity](subject, path)
    return path
