"""Pictures of a run: which quantity of which member becomes which figure, and where it is written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING

from roughsim.charts.curves import correlation_chart, spectrum_chart
from roughsim.charts.maps import Zoom, map_chart, side_by_side_chart
from roughsim.charts.profile import profile_chart
from roughsim.charts.spread import distribution_chart
from roughsim.charts.style import Array, check_ending, letters
from roughsim.errors import number
from roughsim.results.fields import DERIVED_UNITS, kept, member_field, not_kept

if TYPE_CHECKING:
    from roughsim.results.run import Run

MAPS = {
    "heights": "Composite heights",
    "pressure": "Contact pressure",
    "temperature": "Temperature above the mean of the cell",
    "heat_flux": "Frictional heat of both bodies",
}
QUANTITIES = (*MAPS, "distribution", "spectrum", "correlation", "profile")
_NEEDS_SPEED = (*DERIVED_UNITS, "distribution", "profile")


_CHARTS = {
    "distribution": distribution_chart,
    "spectrum": spectrum_chart,
    "correlation": correlation_chart,
    "profile": profile_chart,
}


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What a picture is of: a run, a column and its finest level, one member or all (None), and a speed in m/s."""

    run: Run
    column: str
    level: int
    index: int | None
    speed: float | None

    def field(self, name: str) -> Array:
        """Return a field of the member."""
        speed = self.speed if name in DERIVED_UNITS else None
        return member_field(self.run, self.level, self.index or 0, name, speed=speed).astype(float)

    def title(self, what: str) -> str:
        """Return scene, quantity, column, member and speed in at most three lines."""
        level = self.run.numerics.levels[self.level]
        which = [f"{self.column} contact, $q_c$ = {_power(level.q_max)} rad/m"]
        if self.index is not None:
            which.append(f"realization {self.index}")
        if self.speed is not None:
            which.append(f"$v$ = {self.speed:g} m/s")
        scene = letters(shorten(self.run.scene.title, 90, placeholder=" …"))
        return "\n".join(line for line in (scene, what, ", ".join(which)) if line)


def _power(value: float) -> str:
    mantissa, _, exponent = f"{value:.2e}".partition("e")
    return rf"{mantissa}$\times$10$^{{{int(exponent)}}}$"


def plot_run(
    run: Run,
    quantity: str,
    path: str | Path | None = None,
    *,
    realization: int | None = None,
    speed: float | None = None,
    column: str | None = None,
    zoom: Zoom | None = None,
    side_by_side: bool = False,
) -> Path:
    """Draw one quantity of a run.

    Parameters
    ----------
    run : Run
        From `run` or `open_run`.
    quantity : str
        One of `QUANTITIES`: a map of "heights", "pressure", "temperature" or "heat_flux"; "distribution": of the
        temperature over the contact; "profile": heights, pressure and temperature on the line along the sliding
        direction (x) through the hottest point; "spectrum": the power spectra of the kept heights and of the stress;
        "correlation": g_σ(r).
    path : str or Path, optional
        Of the picture: .png, .pdf or .svg. Left out: a .png beside the run folder, named after both.
    realization : int, optional
        Which kept member; the first if left out. Spectra are means over all members if left out.
    speed : float, optional
        For temperature, heat_flux, distribution and profile, m/s; the scene's highest if left out.
    column : str, optional
        As in `Run.estimate`.
    zoom : ((float, float), (float, float)), optional
        Of a map: draw the points between these ends along x and along y, m.
    side_by_side : bool
        Of a map: heights, pressure, and temperature (or heat_flux, if that is the quantity) beside each other.

    Returns
    -------
    Path
        Where the picture is.

    Raises
    ------
    ValueError
        If the quantity, ending, column, realization, speed or zoom is none that there is; if the fields were not kept.
    """
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity = {quantity!r} is no picture; choose one of {', '.join(QUANTITIES)}")
    if quantity not in MAPS and (zoom is not None or side_by_side):
        raise ValueError(f"zoom and side_by_side are for maps, and {quantity} is none; choose one of {', '.join(MAPS)}")
    place = Path(path) if path is not None else _beside(run, quantity, realization, speed, column)
    check_ending(place)
    third = quantity if quantity in DERIVED_UNITS else "temperature"
    subject = _subject(run, third if side_by_side else quantity, realization, speed, column)
    if side_by_side:
        title = subject.title(f"Heights, pressure and {third.replace('_', ' ')}")
        side_by_side_chart(subject, ("heights", "pressure", third), title, place, zoom)
    elif quantity in MAPS:
        map_chart(subject, quantity, subject.title(MAPS[quantity]), place, zoom)
    else:
        _CHARTS[quantity](subject, place)
    return place


def _subject(run: Run, quantity: str, realization: int | None, speed: float | None, column: str | None) -> Subject:
    name = run.column(column)
    level = run.numerics.of_column(name)[-1]
    if not run.sound(run.realizations):
        raise ValueError(f"{run.folder} has no sound realization yet; let it run first")
    if quantity == "correlation" and realization is not None:
        raise ValueError(f"realization = {realization}: the correlation is a mean over all of them; leave it out")
    index = realization
    if quantity != "correlation":
        indices = kept(run, level)
        if not indices or (realization is not None and realization not in indices):
            raise not_kept(run, level, realization)
        index = indices[0] if realization is None and quantity != "spectrum" else realization
    return Subject(run, name, level, index, _speed(run, quantity, speed))


def _speed(run: Run, quantity: str, speed: float | None) -> float | None:
    if quantity not in _NEEDS_SPEED:
        if speed is not None:
            raise ValueError(f"speed = {speed:g} m/s: {quantity} does not depend on it; leave it out")
        return None
    chosen = max(run.scene.speeds) if speed is None else number("speed", speed, "m/s")
    if chosen == 0.0:
        raise ValueError("speed = 0 m/s makes no heat to draw; give a speed, for example 1")
    return chosen


def _beside(run: Run, quantity: str, realization: int | None, speed: float | None, column: str | None) -> Path:
    folder = run.folder.resolve()
    parts = [folder.name, quantity, column or ""]
    parts += [f"r{realization}" if realization is not None else "", f"{speed:g}mps" if speed is not None else ""]
    return folder.with_name("-".join(part for part in parts if part) + ".png")
