"""One open page: what its controls do, and what they show. Bokeh calls it; the work is done in threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, degrees, radians
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim.errors import positive
from roughsim.explore import curves
from roughsim.explore.layout import Layout
from roughsim.explore.library import Latest, Library, Summary
from roughsim.explore.specimen import Distribution, Specimen, along, distribution, line_through, nearest
from roughsim.explore.views import Field, as_bytes, averaged, box_of, part_in_view, preview_grid

if TYPE_CHECKING:
    from bokeh.document import Document

    from roughsim.grid import Grid

_PERIOD = 2000  # ms between looks for new members
_TEMPLATE = '{% block preamble %}<link rel="icon" href="data:,">{% endblock %}'  # no icon is asked for by another path


@dataclass(frozen=True, slots=True, eq=False)
class Heat:
    """A temperature field, the controls it belongs to, and whether it is the whole field or a preview."""

    field: Field
    grid: Grid
    speed: float
    direction: float
    whole: bool


class Page:
    """The page of one browser tab.

    Parameters
    ----------
    library : Library
        The run, shared by all pages.
    document : Document
        Of Bokeh, still empty.
    """

    def __init__(self, library: Library, document: Document):
        self.library, self.document = library, document
        run = library.run
        self.speed = max(run.scene.speeds) or 1.0
        self.direction = 0.0
        self.specimen: Specimen | None = None
        self.heat: Heat | None = None
        self.point: tuple[int, int] | None = None
        self.limits: dict[str, tuple[float, float]] = {}
        self.summary: Summary | None = None
        self._closed = self._moving = self._showing = False
        self.layout = Layout(run, self.speed, curves.speed_range(run.scene))
        self.fields, self.previews, self.looks, self.news = (Latest(self._deliver, self.say) for _ in range(4))
        self.layout.show_theory(library.theory)
        self._connect()
        document.title = f"roughsim: {run.scene.title or run.folder.name}"
        document.template = _TEMPLATE
        document.add_root(self.layout.root)
        document.add_periodic_callback(self.look_for_news, _PERIOD)
        self.look_for_news()

    def _connect(self) -> None:
        see = self.layout
        self._when(see.slider, "value", lambda: self.move(10.0**see.slider.value, self.direction))
        self._when(see.slider, "value_throttled", lambda: self.settle(10.0**see.slider.value, self.direction))
        self._when(see.speed, "value", lambda: self.type_speed(see.speed.value))
        self._when(see.angle, "value", lambda: self.type_angle(see.angle.value))
        self._when(see.level, "value", self.choose_level)
        self._when(see.member, "value", self.choose_member)
        self._when(see.span, "active", self.draw_maps)
        see.dial.on_event("pan", lambda event: self.turn(event, done=False))
        see.dial.on_event("panend", lambda event: self.turn(event, done=True))
        see.dial.on_event("tap", lambda event: self.turn(event, done=True))
        for one in see.maps.values():
            one.figure.on_event("tap", lambda event: self.mark(event.x, event.y))
        for edge in (see.x_range, see.y_range):
            self._when(edge, "start", self.draw_maps)
            self._when(edge, "end", self.draw_maps)

    def _when(self, model: Any, name: str, act: Callable[[], None]) -> None:
        """Act when somebody has changed a property of a model; not when the page itself sets its controls."""

        def changed(attr: str, old: Any, new: Any) -> None:
            if not self._showing:
                act()

        model.on_change(name, changed)

    def _deliver(self, show: Any) -> None:
        if not self._closed:
            self.document.add_next_tick_callback(show)

    def close(self) -> None:
        """End the threads of the page, and let go of all fields."""
        self._closed = True
        for worker in (self.fields, self.previews, self.looks, self.news):
            worker.close()
        self.specimen = self.heat = None
        self.library.forget()

    def say(self, problem: Exception | str) -> None:
        """Show what is wrong; an empty text clears it."""
        lines = [str(problem)] if str(problem) else []
        self.layout.tell([*lines, *(self.summary.problems if self.summary else [])])

    # the run

    def look_for_news(self) -> None:
        """Look whether the run has grown."""
        self.news.ask(lambda: (self.library.summary(), self.library.state()), self.show_news)

    def show_news(self, found: tuple[Summary, str]) -> None:
        """Show the state of the run, and its curves and texts if it has grown."""
        summary, self.layout.state.text = found
        if summary is self.summary:
            return
        self.summary = summary
        self.layout.show_curves(summary.measured)
        self.layout.show_budget(summary.budget)
        self.say("")
        self.offer_members()

    def offer_members(self) -> None:
        """List the members of the chosen level; the first kept one is shown if none is yet."""
        if self.summary is None:
            return
        level = int(self.layout.level.value)
        sound, kept = self.summary.sound[level], self.summary.kept[level]
        self.layout.offer(sound, kept)
        if sound and self.layout.member.value not in map(str, sound):
            self.layout.member.value = str((kept or sound)[0])

    def choose_level(self) -> None:
        """Show the same member at another level."""
        before = self.layout.member.value
        self.offer_members()
        if self.layout.member.value == before:
            self.choose_member()

    def choose_member(self) -> None:
        """Read the fields of the chosen member."""
        if not self.layout.member.value:
            return
        level, index = int(self.layout.level.value), int(self.layout.member.value)
        speed, direction = self.speed, self.direction
        self.layout.busy.text = f"reading realization {index} …"
        self.specimen = self.heat = None
        self.layout.clear()
        self.fields.ask(lambda: self._opened(level, index, speed, direction), self.show_member)

    def _opened(self, level: int, index: int, speed: float, direction: float) -> Any:
        specimen = self.library.specimen(level, index)
        heat = _whole(specimen, speed, direction)
        return specimen, heat, distribution(heat.field, specimen.pressure)

    def show_member(self, found: tuple[Specimen, Heat, Distribution]) -> None:
        """Show a member that has been read; the hottest point is marked."""
        self.specimen, heat, spread = found
        biggest = float(np.abs(self.specimen.heights).max())
        self.limits = {"heights": (-biggest, biggest), "pressure": _ends(self.specimen.pressure)}
        hottest = np.unravel_index(int(heat.field.argmax()), heat.field.shape)
        self.point = int(hottest[0]), int(hottest[1])
        self.say("")
        self.show_whole((heat, spread))
        self.draw_maps()

    # speed and direction

    def type_speed(self, text: str) -> None:
        """Take a speed written in the box."""
        try:
            speed = positive("speed", float(text), "m/s")
        except ValueError as error:
            self.say(error if "speed" in str(error) else f"speed = {text!r} is no number; write m/s, for example 35")
            return
        self.say("")
        self.settle(speed, self.direction)

    def type_angle(self, angle: float | None) -> None:
        """Take an angle written in the box, degrees."""
        if angle is not None:
            self.settle(self.speed, radians(angle % 360))

    def turn(self, event: Any, *, done: bool) -> None:
        """Take a direction from the dial; whole degrees."""
        if event.x is None or event.y is None or event.x == event.y == 0:
            return
        direction = radians(round(degrees(atan2(event.y, event.x))) % 360)
        (self.settle if done else self.move)(self.speed, direction)

    def move(self, speed: float, direction: float) -> None:
        """Show a preview at another speed and direction; what was asked for before and not begun is dropped."""
        self.speed, self.direction, self._moving = speed, direction, True
        self.layout.turn_dial(direction)
        specimen = self.specimen
        if specimen is not None:
            self.previews.ask(lambda: _preview(specimen, speed, direction), self.show_preview)

    def settle(self, speed: float, direction: float) -> None:
        """Show the whole field at another speed and direction."""
        self.move(speed, direction)
        self._showing = True
        self.layout.show_controls(speed, direction)
        self._showing = False
        specimen = self.specimen
        if specimen is not None:
            self.layout.busy.text = "" if specimen.is_small else "computing the whole field …"
            self.fields.ask(lambda: _settled(specimen, speed, direction), self.show_whole)

    def _wanted(self, heat: Heat) -> bool:
        return (heat.speed, heat.direction) == (self.speed, self.direction)

    def show_preview(self, heat: Heat) -> None:
        """Show the long waves of a temperature, unless the whole field is there."""
        if self.specimen is None or (self.heat is not None and self.heat.whole and self._wanted(self.heat)):
            return
        self.show_heat(heat)

    def show_whole(self, found: tuple[Heat, Distribution]) -> None:
        """Show a whole field with what is read off it, unless something else is wanted by now."""
        heat, spread = found
        if self.specimen is None or heat.field.shape != self.specimen.grid.shape or not self._wanted(heat):
            return
        self.layout.busy.text, self._moving = "", False
        self.show_heat(heat)
        self.layout.show_distribution(spread)
        self.draw_line()

    def show_heat(self, heat: Heat) -> None:
        """Replace the temperature map."""
        self.heat = heat
        self.limits["temperature"] = _ends(heat.field)
        self._show_image("temperature", *self._image(heat.field, heat.grid, self._view(), self._limits("temperature")))

    # maps and points

    def _view(self) -> tuple[tuple[float, float], tuple[float, float]]:
        factor = self.layout.factor
        x, y = self.layout.x_range, self.layout.y_range
        return (x.start / factor, x.end / factor), (y.start / factor, y.end / factor)

    def _limits(self, name: str) -> tuple[float, float] | None:
        """Limits of the colours: of the whole cell, or None for those of the view."""
        return self.limits[name] if self.layout.span.active == 0 else None

    def draw_maps(self) -> None:
        """Draw the part of the fields that is in view now."""
        specimen, heat, view = self.specimen, self.heat, self._view()
        if specimen is None or heat is None:
            return
        fields = {"heights": (specimen.heights, specimen.grid), "pressure": (specimen.pressure, specimen.grid)}
        fields["temperature"] = heat.field, heat.grid
        limits = {name: self._limits(name) for name in fields}

        def work() -> tuple[Heat, dict[str, Any]]:
            return heat, {name: self._image(*fields[name], view, limits[name]) for name in fields}

        self.looks.ask(work, self.show_maps)

    def show_maps(self, found: tuple[Heat, dict[str, Any]]) -> None:
        """Show the images of a view; a temperature that has been replaced meanwhile is left out."""
        heat, images = found
        for name, image in images.items():
            if self.specimen is not None and (name != "temperature" or heat is self.heat):
                self._show_image(name, *image)

    def _image(self, field: Field, grid: Grid, view: Any, limits: tuple[float, float] | None) -> tuple[Any, Any, Any]:
        part = part_in_view(grid, *view)
        mean = averaged(field, part)
        limits = _ends(mean) if limits is None else limits
        box = [side * self.layout.factor for side in box_of(grid, part)]
        data = dict(zip(("x", "y", "dw", "dh"), ([side] for side in box), strict=True))
        return {"image": [as_bytes(mean, limits)], **data}, limits, part.step

    def _show_image(self, name: str, data: dict[str, Any], limits: tuple[float, float], step: tuple[int, int]) -> None:
        note = ""
        if name == "temperature" and self.heat is not None:
            settled = self.heat.whole and not self._moving  # a title that changes is laid out anew: not at every move
            note = f", {self.heat.speed:.3g} m/s" if settled else ", preview"
        self.layout.show_image(name, data, limits, step, note)

    def mark(self, x: float, y: float) -> None:
        """Read off the values at a place, in the unit of the axes, and draw the line through it."""
        if self.specimen is not None:
            self.point = nearest(self.specimen.grid, x / self.layout.factor, y / self.layout.factor)
            self.draw_line()

    def draw_line(self) -> None:
        """Draw the fields on the line through the marked point, from the whole fields."""
        specimen, heat, point = self.specimen, self.heat, self.point
        if specimen is None or heat is None or point is None:
            return
        line = line_through(specimen.grid, point, self.direction)
        temperature = heat.field if heat.whole else None
        values = along(line, heights=specimen.heights, pressure=specimen.pressure, temperature=temperature)
        self.layout.show_line(specimen.grid, point, line, values)


def _whole(specimen: Specimen, speed: float, direction: float) -> Heat:
    return Heat(specimen.temperature(speed, direction), specimen.grid, speed, direction, whole=True)


def _settled(specimen: Specimen, speed: float, direction: float) -> tuple[Heat, Distribution]:
    heat = _whole(specimen, speed, direction)
    return heat, distribution(heat.field, specimen.pressure)


def _preview(specimen: Specimen, speed: float, direction: float) -> Heat:
    field = specimen.temperature_preview(speed, direction)
    return Heat(field, preview_grid(specimen.grid), speed, direction, whole=specimen.is_small)


def _ends(field: Field) -> tuple[float, float]:
    return float(field.min()), float(field.max())
