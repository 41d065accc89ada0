"""One open page: what its controls do, and what they show. Bokeh calls it; the work is done in threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from math import atan2, degrees, radians
from typing import Any
from weakref import ref

import numpy as np
from bokeh.document import Document

from roughsim.errors import positive
from roughsim.explore.fields import (
    Ends,
    Field,
    Image,
    MemberFields,
    Temperature,
    image_of,
    line_through,
    nearest_point,
)
from roughsim.explore.layout import Layout
from roughsim.explore.panels import THEME
from roughsim.explore.watched_run import Summary, WatchedRun
from roughsim.grid import Grid

PERIOD = 2000  # ms between looks for new members
NO_ICON = '{% block preamble %}<link rel="icon" href="data:,">{% endblock %}'  # or browsers ask for one by another path


class LatestTask:
    """A thread that does the latest of its tasks; a task that has not begun when the next one comes is dropped.

    `deliver` takes a function without arguments and calls it in the thread of the page. There `failed` is called with
    the error of a task.
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], None], failed: Callable[[BaseException], None]):
        self.deliver, self.failed = deliver, failed
        self.pool = ThreadPoolExecutor(1)
        self.latest: Callable[[], Future[Any] | None] = lambda: None

    def ask(self, work: Callable[[], Any], show: Callable[[Any], None]) -> None:
        """Do `work` in the thread, then `show` its result in the thread of the page."""

        def done(future: Future[Any]) -> None:
            if not future.cancelled():
                error = future.exception()
                self.deliver(lambda: self.failed(error) if error else show(future.result()))

        if (waiting := self.latest()) is not None:
            waiting.cancel()  # without effect on a task that has begun
        future = self.pool.submit(work)
        self.latest = ref(future)  # weak: a result may hold fields of many megabytes
        future.add_done_callback(done)

    def close(self) -> None:
        """End the thread; what it is doing is finished, what waits is dropped."""
        self.pool.shutdown(wait=False, cancel_futures=True)


class Page:
    """The page of a run in an empty document of Bokeh."""

    def __init__(self, watched: WatchedRun, document: Document):
        self.watched, self.document = watched, document
        scene = watched.run.scene
        self.speed = max(scene.speeds) or 1.0
        self.direction = 0.0
        self.fields: MemberFields | None = None
        self.temperature: Temperature | None = None
        self.point: tuple[int, int] | None = None
        self.maps: dict[str, tuple[Field, Grid, Ends]] = {}  # with the lowest and the highest value
        self.summary: Summary | None = None
        self._closed = self._moving = self._setting_controls = False
        self.layout = Layout(watched.run, self.speed)
        self.readings, self.previews, self.images, self.news = (LatestTask(self._deliver, self.say) for _ in range(4))
        for name, curve in watched.theory.items():
            self.layout.curves[name].show_theory(*curve)
        self._connect()
        document.title = f"roughsim: {scene.title or watched.run.folder.name}"
        document.template, document.theme = NO_ICON, THEME
        document.add_root(self.layout.root)
        document.add_periodic_callback(self.look_for_news, PERIOD)
        self.look_for_news()

    def _connect(self) -> None:
        """Tell Bokeh what each control does; nothing while the page itself sets its controls."""
        layout, controls = self.layout, self.layout.controls

        def when(model: Any, name: str, act: Callable[[], None]) -> None:
            model.on_change(name, lambda attr, old, new: None if self._setting_controls else act())

        when(controls.slider, "value", lambda: self.move(10.0**controls.slider.value, self.direction))
        when(controls.slider, "value_throttled", lambda: self.settle(10.0**controls.slider.value, self.direction))
        when(controls.speed, "value", lambda: self.type_speed(controls.speed.value))
        when(controls.angle, "value", lambda: self.type_angle(controls.angle.value))
        when(controls.level, "value", self.choose_level)
        when(controls.member, "value", self.choose_member)
        when(controls.colours_of, "active", self.draw_maps)
        for axis in (layout.x_range, layout.y_range):
            when(axis, "start", self.draw_maps)
            when(axis, "end", self.draw_maps)
        for event in ("pan", "panend", "tap"):
            controls.dial.figure.on_event(event, self.turn)
        for panel in layout.maps.values():
            panel.figure.on_event("tap", lambda event: self.mark(event.x, event.y))

    def _deliver(self, show: Any) -> None:
        if not self._closed:
            self.document.add_next_tick_callback(show)

    def close(self) -> None:
        """End the threads of the page, and let go of all fields."""
        self._closed = True
        for worker in (self.readings, self.previews, self.images, self.news):
            worker.close()
        self.fields, self.temperature, self.maps = None, None, {}
        self.watched.fields.cache_clear()

    def say(self, problem: BaseException | str) -> None:
        """Show a problem above those of the run; an empty text clears it."""
        lines = [str(problem)] if str(problem) else []
        self.layout.problems.text = "\n".join([*lines, *(self.summary.problems if self.summary else [])])

    # the run

    def look_for_news(self) -> None:
        """Look whether the run has grown."""
        self.news.ask(lambda: (self.watched.summary(), self.watched.state()), self.show_news)

    def show_news(self, news: tuple[Summary, str]) -> None:
        """Show the state of the run, and its curves and texts if it has grown."""
        summary, self.layout.state.text = news
        if summary is self.summary:
            return
        self.summary = summary
        for column, curves in summary.measured.items():
            for name, curve in curves.items():
                self.layout.curves[name].show(column, curve)
        for column, text in summary.budget.items():
            self.layout.budgets[column].text = text
        self.say("")
        self.offer_members()

    def offer_members(self) -> None:
        """List the realizations of the chosen level; the first one with fields is shown if none is yet."""
        if self.summary is None:
            return
        level = int(self.layout.controls.level.value)
        sound, kept, member = self.summary.sound[level], self.summary.kept[level], self.layout.controls.member
        with_fields = set(kept)
        member.options = [(str(i), str(i) if i in with_fields else f"{i} (fields not kept)") for i in sound]
        member.disabled = not sound
        if sound and member.value not in map(str, sound):
            member.value = str((kept or sound)[0])

    def choose_level(self) -> None:
        """Show the same realization at another level."""
        before = self.layout.controls.member.value
        self.offer_members()
        if self.layout.controls.member.value == before:
            self.choose_member()

    def choose_member(self) -> None:
        """Read the fields of the chosen member."""
        if not self.layout.controls.member.value:
            return
        level, index = int(self.layout.controls.level.value), int(self.layout.controls.member.value)
        self.layout.busy.text = f"reading realization {index} …"
        self.fields, self.temperature, self.maps = None, None, {}
        self.layout.clear()
        speed, direction = self.speed, self.direction
        self.readings.ask(lambda: self.watched.fields(level, index).temperature(speed, direction), self.show_member)

    def show_member(self, temperature: Temperature) -> None:
        """Show a member that has been read; the hottest point is marked."""
        self.fields, self.temperature, field = temperature.member, temperature, temperature.field
        heights, pressure, grid = self.fields.heights, self.fields.pressure, self.fields.grid
        highest = float(np.abs(heights).max())
        self.maps = {
            "heights": (heights, grid, (-highest, highest)),
            "pressure": (pressure, grid, (float(pressure.min()), float(pressure.max()))),
            "temperature": (field, grid, (float(field.min()), float(field.max()))),
        }
        self.point = divmod(int(field.argmax()), field.shape[1])
        self.say("")
        self.draw_maps()
        if self._is_chosen(temperature):
            self.show_whole(temperature)
        else:  # another speed was chosen while the member was read
            self.settle(self.speed, self.direction)

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

    def turn(self, event: Any) -> None:
        """Take a direction from the dial, in whole degrees: a preview while the hand is dragged."""
        if event.x is None or event.y is None or event.x == event.y == 0:
            return
        direction = radians(round(degrees(atan2(event.y, event.x))) % 360)
        (self.move if event.event_name == "pan" else self.settle)(self.speed, direction)

    def move(self, speed: float, direction: float) -> None:
        """Show a preview at another speed, m/s, and direction, rad."""
        self.speed, self.direction, self._moving = speed, direction, True
        self.layout.controls.dial.turn(direction)
        fields = self.fields
        if fields is not None:
            self.previews.ask(lambda: fields.temperature(speed, direction, preview=True), self.show_preview)

    def settle(self, speed: float, direction: float) -> None:
        """Show the whole field at another speed, m/s, and direction, rad."""
        self.move(speed, direction)
        self._setting_controls = True
        self.layout.controls.show(speed, direction)
        for panel in self.layout.curves.values():
            panel.chosen_speed.location = speed
        self._setting_controls = False
        fields = self.fields
        if fields is not None:
            self.layout.busy.text = "" if fields.preview_grid == fields.grid else "computing the whole field …"
            self.readings.ask(lambda: fields.temperature(speed, direction), self.show_whole)

    def _is_chosen(self, temperature: Temperature) -> bool:
        return (temperature.speed, temperature.direction) == (self.speed, self.direction)

    def show_preview(self, preview: Temperature) -> None:
        """Show the long waves of a temperature, unless the whole field is already shown."""
        current = self.temperature
        if preview.member is self.fields and not (current and current.whole and self._is_chosen(current)):
            self.show_temperature(preview)

    def show_whole(self, temperature: Temperature) -> None:
        """Show a whole field with what is read off it, unless another has been chosen meanwhile."""
        if temperature.member is not self.fields or not self._is_chosen(temperature):
            return
        self.layout.busy.text, self._moving = "", False
        self.show_temperature(temperature)
        self.layout.distribution.show(temperature.distribution)
        self.draw_line()

    def show_temperature(self, temperature: Temperature) -> None:
        """Replace the temperature map."""
        self.temperature, field = temperature, temperature.field
        self.maps["temperature"] = field, temperature.grid, (float(field.min()), float(field.max()))
        self.show_image("temperature", self.image_in_view("temperature")())

    # maps and points

    def image_in_view(self, name: str) -> Callable[[], Image]:
        """Return what makes the image of a map as it is in view now, in any thread."""
        (field, grid, limits), factor = self.maps[name], self.layout.factor
        x, y = ((axis.start / factor, axis.end / factor) for axis in (self.layout.x_range, self.layout.y_range))
        of_cell = self.layout.controls.colours_of.active == 0
        return lambda: image_of(field, grid, (x, y), limits if of_cell else None)

    def draw_maps(self) -> None:
        """Draw the part of the fields that is in view now."""
        maps, images = dict(self.maps), {name: self.image_in_view(name) for name in self.maps}

        def show(drawn: dict[str, Image]) -> None:
            for name, image in drawn.items():
                if self.maps.get(name) is maps[name]:  # a field that has been replaced meanwhile is left out
                    self.show_image(name, image)

        self.images.ask(lambda: {name: draw() for name, draw in images.items()}, show)

    def show_image(self, name: str, image: Image) -> None:
        """Show the image of a field on its map."""
        note = ""
        if name == "temperature" and self.temperature is not None:
            # a title that changes is laid out anew: not at every move of the slider
            settled = self.temperature.whole and not self._moving
            note = f", {self.temperature.speed:.3g} m/s" if settled else ", preview"
        self.layout.maps[name].show(image, self.layout.factor, note)

    def mark(self, x: float, y: float) -> None:
        """Mark a place, in the unit of the axes, and show the values there and along the line through it."""
        if self.fields is not None:
            self.point = nearest_point(self.fields.grid, x / self.layout.factor, y / self.layout.factor)
            self.draw_line()

    def draw_line(self) -> None:
        """Draw the whole fields on the line through the marked point; a preview of the temperature is left out."""
        fields, temperature, point = self.fields, self.temperature, self.point
        if fields is None or temperature is None or point is None:
            return
        line = line_through(fields.grid, point, self.direction)
        whole = temperature.field if temperature.whole else np.broadcast_to(np.nan, fields.grid.shape)
        maps = {"heights": fields.heights, "pressure": fields.pressure, "temperature": whole}
        along = {name: field[line.i, line.j].astype(np.float64) for name, field in maps.items()}
        self.layout.show_line(fields.grid, point, line, along)
