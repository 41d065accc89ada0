"""What a picture is of: which run, column, realization and speed, and how its fields are named."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import shorten

from roughsim.charts.style import Array
from roughsim.errors import number
from roughsim.grid import Grid
from roughsim.results.arrays import DERIVED_UNITS
from roughsim.results.run import Run
from roughsim.show.text import plain

# field → the words above a map of it, its symbol, and its unit
FIELDS = {
    "heights": ("Composite heights", "$h$", "m"),
    "pressure": ("Contact pressure", r"$\sigma$", "Pa"),
    "temperature": ("Temperature above the mean of the cell", "$T$", "K"),
    "heat_flux": ("Frictional heat of both bodies", r"$\mu\sigma v$", "W/m²"),
}
NEEDS_SPEED = (*DERIVED_UNITS, "distribution", "profile")


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A run, a column and its finest level, one realization or all (None), and a speed in m/s."""

    run: Run
    column: str
    level: int
    index: int | None
    speed: float | None

    @property
    def grid(self) -> Grid:
        """The grid of the fields."""
        return self.run.numerics.grid(self.level)

    def field(self, name: str) -> Array:
        """Return a field of the realization."""
        speed = self.speed if name in DERIVED_UNITS else None
        return self.run.field(self.level, self.index or 0, name, speed=speed).astype(float)

    def title(self, what: str) -> str:
        """Return scene, quantity, column, realization and speed in at most three lines."""
        mantissa, _, exponent = f"{self.run.numerics.levels[self.level].q_max:.2e}".partition("e")
        which = [rf"{self.column} contact, $q_c$ = {mantissa}$\times$10$^{{{int(exponent)}}}$ rad/m"]
        if self.index is not None:
            which.append(f"realization {self.index}")
        if self.speed is not None:
            which.append(f"$v$ = {self.speed:g} m/s")
        scene = plain(shorten(self.run.scene.title, 90, placeholder=" …")).replace("$", r"\$")  # a title is no formula
        return "\n".join(line for line in (scene, what, ", ".join(which)) if line)


def choose_subject(
    run: Run, quantity: str, realization: int | None, speed: float | None, column: str | None
) -> Subject:
    """Return what a quantity is drawn of; ValueError where fields were not kept, or an argument does not fit it."""
    column = run.column(column)
    level = run.numerics.of_column(column)[-1]
    if not run.sound(run.realizations):
        raise ValueError(f"{run.folder} has no sound realization yet; let it run first")
    if quantity == "correlation" and realization is not None:
        raise ValueError(f"realization = {realization}: the correlation is a mean over all of them; leave it out")
    if quantity != "correlation":  # all others need fields; the spectrum has those of all kept realizations
        indices = run.kept(level)
        if not indices or (realization is not None and realization not in indices):
            raise run.not_kept(level, realization)
        if realization is None and quantity != "spectrum":
            realization = indices[0]
    if quantity not in NEEDS_SPEED:
        if speed is not None:
            raise ValueError(f"speed = {speed:g} m/s: {quantity} does not depend on it; leave it out")
        return Subject(run, column, level, realization, None)
    speed = max(run.scene.speeds) if speed is None else number("speed", speed, "m/s")
    if speed == 0.0:
        raise ValueError("speed = 0 m/s makes no heat to draw; give a speed, for example 1")
    return Subject(run, column, level, realization, speed)
