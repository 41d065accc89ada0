"""The actions of the controls of an open page. Bokeh calls the methods; slow work runs in threads."""

import time
from collections.abc import Callable
from functools import partial
from math import degrees, radians
from typing import Any
from urllib.parse import parse_qsl, urlencode

import numpy as np
from bokeh import models
from bokeh.document import Document

from roughsim.charts.maps import share_at_hardness
from roughsim.errors import number, positive
from roughsim.explore.content import (
    USUAL,
    Ends,
    Field,
    Image,
    MapLook,
    MemberFields,
    Summary,
    Temperature,
    WatchedRun,
    image_of,
    line_through,
    load_fields,
    nearest_point,
    usual_seconds,
)
from roughsim.explore.layout import FIELDS, THEME, Layout
from roughsim.explore.reactions import ReactionView
from roughsim.explore.skin import layers_text
from roughsim.explore.snapshots import SnapshotsView
from roughsim.explore.takeaway import LINE, line_text, look_of, look_text, map_text
from roughsim.explore.tasks import LatestTask
from roughsim.grid import Grid
from roughsim.heat.statistics import hottest_pixel
from roughsim.show.text import clock

_PERIOD = 2000  # ms between looks for new members
_TURN = 300  # ms between two states of the bar
_BAR = 20  # letters of it
HEAD = (  # without an icon browsers ask for one at another path; a telephone takes its own width
    '{% block preamble %}<link rel="icon" href="data:,">'
    '<meta name="viewport" content="width=device-width, initial-scale=1">{% endblock %}'
)


class Page:
    """The page of a run in an empty document of Bokeh; `tasks` runs its slow work."""

    def __init__(
        self, watched: WatchedRun, document: Document, tasks: type[LatestTask] = LatestTask
    ):
        self.watched = watched
        scene = watched.run.scene
        self.speed, self.direction = max(scene.speeds) or 1.0, (scene.headings or (0.0,))[0]
        # of the shown temperature: the skin and the depth of the heat may be chosen
        self.scene = scene
        self.member: MemberFields | None = None
        self.temperature: Temperature | None = None
        self.point: tuple[int, int] | None = None  # that is marked
        # by name: a field, its grid, its lowest and highest value
        self.maps: dict[str, tuple[Field, Grid, Ends]] = {}
        self.looks: dict[str, MapLook] = dict.fromkeys(FIELDS, USUAL)
        self.wanted = ""  # a link that waits for the run to be read
        self.hard = 0.0  # share of the contact at the hardness
        self.summary: Summary | None = None
        # when fields that were not kept began to be computed, by `time.monotonic`
        self.began: float | None = None
        self.usual = 0.0  # s that this takes
        self._setting_controls = False
        self.layout = Layout(watched.run, self.speed)
        self.controls = self.layout.controls
        queue = partial(tasks, document, self.say)
        self.news, self.readings, self.temperatures, self.images = (queue() for _ in range(4))
        self.snapshots: SnapshotsView | None = None
        if watched.run.numerics.slide is not None:
            self.snapshots = SnapshotsView(watched.run, document, queue().ask)
            self.layout.add_below(self.snapshots.root)
        self.reactions = ReactionView(watched.run.column(None))
        if scene.distribution:
            self.layout.add_below(self.reactions.root)
        self._connect()
        self.show_curves()
        document.title = f"roughsim: {scene.title or watched.run.folder.name}"
        document.template, document.theme = HEAD, THEME
        document.add_root(self.layout.root)
        document.js_on_event("document_ready", self.layout.takeaway.read)
        document.add_periodic_callback(self.look_for_news, _PERIOD)
        document.add_periodic_callback(self.turn_bar, _TURN)
        self.layout.busy.text = "reading the run …"
        self.look_for_news()

    def _connect(self) -> None:
        """Connect the controls to their actions; changes made by the page itself have none."""
        layout, controls = self.layout, self.controls

        def when(model: Any, name: str, act: Callable[[], None]) -> None:
            model.on_change(name, lambda attr, old, new: None if self._setting_controls else act())

        def slide_speed(*, moving: bool = False) -> None:
            self.choose(10.0**controls.slider.value, self.direction, moving=moving)

        def turn(*, moving: bool = False) -> None:
            self.choose(self.speed, radians(controls.angle.value), moving=moving)

        moved: dict[models.Slider, Callable[..., None]] = {
            controls.slider: slide_speed,
            controls.angle: turn,
            layout.skin.thickness: self.choose_layers,
            layout.skin.heat_depth: self.choose_layers,
        }
        for slider, act in moved.items():
            when(slider, "value", partial(act, moving=True))
            when(slider, "value_throttled", act)
        when(controls.speed, "value", lambda: self.type_speed(controls.speed.value))
        when(controls.direction, "value", self.choose_direction)
        when(controls.level, "value", self.choose_level)
        when(controls.member, "value", self.choose_member)
        when(controls.colours_of, "active", self.draw_maps)
        when(layout.skin.material, "value", self.choose_layers)
        when(layout.skin.camera, "active", self.choose_layers)
        away = layout.takeaway
        when(away.map, "value", self.show_look)
        for control in away.inputs:
            when(control, "active" if control is away.log else "value", self.choose_look)
        away.save.on_click(lambda event: self.save(event.item))
        when(away.link, "value", lambda: self.follow(away.link.value))
        for axis in (layout.x_range, layout.y_range):
            when(axis, "start", self.draw_maps)
            when(axis, "end", self.draw_maps)
        for panel in layout.maps.values():
            panel.figure.on_event("tap", lambda event: self.mark(event.x, event.y))

    def say(self, problem: Exception | str) -> None:
        """Show the problem that ended a task above the problems of the run; an empty text removes it."""
        lines = [str(problem), *(self.summary.problems if self.summary else [])]
        self.layout.problems.text = "\n".join(filter(None, lines))
        if str(problem):
            self.began, self.layout.busy.text = None, ""

    # the run

    def look_for_news(self) -> None:
        """Look whether the run has grown."""
        self.news.ask(lambda: (self.watched.summary(), self.watched.state()), self.show_news)

    def show_news(self, news: tuple[Summary, str]) -> None:
        """Show the state of the run, and its curves and texts if it has grown."""
        summary, self.layout.state.text = news
        if summary is self.summary:
            return
        if self.summary is None:
            self.layout.busy.text = ""
        self.summary = summary
        self.show_curves()
        for column, text in summary.budget.items():
            self.layout.budgets[column].text = text
        self.say("")
        if self.wanted:
            self.follow(self.wanted)
        self.offer_members()
        if self.snapshots is not None:
            self.snapshots.offer(summary.with_snapshots)

    def show_curves(self) -> None:
        """Show theory, columns and reactions, in the chosen direction if the run has any."""
        angles = self.watched.run.scene.directions
        angle = angles[int(self.controls.direction.value)] if angles else None
        for name, theory in self.watched.theory(angle).items():
            self.layout.curves[name].show_theory(*theory)
        if self.summary is None:
            return
        for column, curves in self.summary.measured.items():
            for name, curve in curves.items():
                turned = "direction" in curve.coords
                shown = curve.sel(direction=angle) if turned else curve
                self.layout.curves[name].show(column, shown)
        self.reactions.show(self.summary.reactions.get(angle, {}))

    def offer_members(self) -> None:
        """List the realizations of the chosen level; if none is shown yet, show the first one with fields."""
        if self.summary is None:
            return
        level = self.chosen_level
        sound, kept = self.summary.sound[level], self.summary.kept[level]
        member = self.controls.member
        member.options = [(str(i), str(i) if i in kept else f"{i} (computed again)") for i in sound]
        member.disabled = not sound
        if sound and member.value not in map(str, sound):
            member.value = str((kept or sound)[0])

    @property
    def chosen_level(self) -> int:
        """The level in the control."""
        return int(self.controls.level.value)

    def choose_level(self) -> None:
        """Show the same realization at another level."""
        before = self.controls.member.value
        self.offer_members()
        if self.controls.member.value == before:
            self.choose_member()

    def choose_member(self, point: tuple[int, int] | None = None) -> None:
        """Read the fields of the chosen member, or compute them again, with a progress bar; then mark a point."""
        if not self.controls.member.value:
            return
        level, index = self.chosen_level, int(self.controls.member.value)
        self.member, self.temperature, self.point, self.maps = None, None, point, {}
        self.layout.clear()
        self.layout.busy.text = f"reading realization {index} …"
        kept = self.summary is not None and index in self.summary.kept[level]
        self.began = None if kept else time.monotonic()
        self.usual = usual_seconds(self.watched.run, level)
        self.turn_bar()

        def show(member: MemberFields) -> None:
            if (level, index) == (self.chosen_level, int(self.controls.member.value)):
                self.show_member(member)  # and no other was chosen meanwhile

        self.readings.ask(lambda: load_fields(self.watched.run, level, index), show)

    def turn_bar(self) -> None:
        """Show the progress of the computation of fields, estimated from the times of the level."""
        if self.began is None:
            return
        elapsed = time.monotonic() - self.began
        done = min(elapsed / max(self.usual, 1e-9), 0.99)
        bar = ("█" * round(_BAR * done)).ljust(_BAR, "░")
        rest = self.usual - elapsed
        left = f"about {clock(rest)} left" if rest > 0.0 else "any moment now"
        self.layout.busy.text = f"{bar} these fields were not kept and are computed again, {left}"

    def show_member(self, member: MemberFields) -> None:
        """Show a member that has been read; its temperature follows."""
        self.began, self.member, highest = None, member, float(np.abs(member.heights).max())
        self.layout.show_cell(member.grid.lengths)
        pressures = float(member.pressure.min()), float(member.pressure.max())
        self.hard = share_at_hardness(member.pressure, self.watched.run.scene, member.column)
        self.maps = {
            "heights": (member.heights, member.grid, (-highest, highest)),
            "pressure": (member.pressure, member.grid, pressures),
        }
        self.say("")
        self.draw_maps()
        self.choose(self.speed, self.direction)

    # speed and direction

    def choose_direction(self) -> None:
        """Show the results in one of the directions of the run, and turn the map to it."""
        self.show_curves()
        scene = self.watched.run.scene
        chosen = int(self.controls.direction.value) * len(scene.sliding.speed)
        self.choose(self.speed, (scene.headings or ())[chosen])

    def type_speed(self, text: str) -> None:
        """Take the speed that was typed into the box."""
        try:
            speed = positive("speed", float(text), "m/s")
        except ValueError as error:
            no_number = f"speed = {text!r} is no number; type one in m/s, for example 35"
            self.say(error if "speed" in str(error) else no_number)
            return
        self.say("")
        self.choose(speed, self.direction)

    def choose(self, speed: float, direction: float, *, moving: bool = False) -> None:
        """Show the temperature at a speed, m/s, and direction, rad; a preview while a control is being moved."""
        if moving and (speed, direction) == (self.speed, self.direction):
            return  # a late event: the whole field of this choice is coming already
        self.speed, self.direction = speed, direction
        if not moving:
            self._setting_controls = True
            self.layout.show_choice(speed, direction)
            self._setting_controls = False
        self.ask_temperature(moving=moving)

    def choose_layers(self, *, moving: bool = False) -> None:
        """Show the temperature with the chosen skin and depth of the heat; a preview while a control is being moved."""
        scene = self.layout.skin.scene()
        if moving and scene == self.scene:
            return  # a late event, as of the speed
        self.scene = scene
        self.ask_temperature(moving=moving)

    def ask_temperature(self, *, moving: bool) -> None:
        """Compute the temperature of all that is chosen, from the pressure of the member."""
        if (member := self.member) is None:
            return
        if not moving and member.preview_grid != member.grid:
            self.layout.busy.text = "computing the whole field …"
        work = partial(member.temperature, self.speed, self.direction, self.scene, preview=moving)
        self.temperatures.ask(work, self.show_temperature)

    def show_temperature(self, temperature: Temperature) -> None:
        """Show a temperature; distribution, point and line follow only with the whole field."""
        if temperature.member is not self.member:
            return  # another member has been chosen meanwhile
        self.temperature, field = temperature, temperature.field
        self.maps["temperature"] = field, temperature.grid, (float(field.min()), float(field.max()))
        self.show_image("temperature", self.image_in_view("temperature")())
        if temperature.contact is not None:
            self.layout.busy.text = ""
            self.layout.distribution.show(temperature.contact)
            self.point = self.point or hottest_pixel(field)
            self.draw_line()

    # maps and points

    def image_in_view(self, name: str) -> Callable[[], Image]:
        """Return a function that makes the image of a map as it is in view now; any thread may call it."""
        (field, grid, limits), factor = self.maps[name], self.layout.factor
        x, y = (
            (axis.start / factor, axis.end / factor)
            for axis in (self.layout.x_range, self.layout.y_range)
        )
        of_cell, look = self.controls.colours_of.active == 0, self.looks[name]
        return lambda: image_of(field, grid, (x, y), limits if of_cell else None, look)

    def draw_maps(self) -> None:
        """Draw the part of the fields that is in view now."""
        maps, images = dict(self.maps), {name: self.image_in_view(name) for name in self.maps}

        def show(drawn: dict[str, Image]) -> None:
            for name, image in drawn.items():
                # a field that has been replaced meanwhile is left out
                if self.maps.get(name) is maps[name]:
                    self.show_image(name, image)

        self.images.ask(lambda: {name: draw() for name, draw in images.items()}, show)

    def show_image(self, name: str, image: Image) -> None:
        """Show the image of a field on its map."""
        note, lengths = "", self.maps[name][1].lengths
        if name == "temperature" and self.temperature is not None:
            # a new title makes the browser lay out the page again, so a preview does not name its speed
            note = (
                ", preview" if self.temperature.preview else f", {self.temperature.speed:.3g} m/s"
            )
            shown, own = self.temperature.scene, self.watched.run.scene
            note += ", through the camera" * (shown.camera is not None)
            if not self.temperature.preview and shown.layers != own.layers:
                note += f", {layers_text(shown)}"
        if lengths != self.watched.run.sides:
            where = self.watched.run.numerics.levels[self.chosen_level].where
            sides = " × ".join(f"{length * self.layout.factor:.4g}" for length in lengths)
            note += f",{where.removeprefix(' in')}: {sides} {self.layout.unit}"
        look = self.looks[name]
        of_cell = self.controls.colours_of.active == 0 and look.high is None
        hard = name == "pressure" and self.hard > 0.0 and of_cell
        if hard:
            note += f", grey: {100 * self.hard:.3g} % at σ_P"
        self.layout.maps[name].show(image, self.layout.factor, note, look, hard=hard)

    def mark(self, x: float, y: float) -> None:
        """Mark a point, in the unit of the axes, and show the values there and along the line through it."""
        if self.member is not None:
            self.point = nearest_point(
                self.member.grid, x / self.layout.factor, y / self.layout.factor
            )
            self.draw_line()

    def draw_line(self) -> None:
        """Draw the whole fields on the line through the marked point, along the sliding direction."""
        temperature, point = self.temperature, self.point
        if temperature is None or temperature.preview or point is None:
            return  # the line follows with the whole field
        line = line_through(temperature.grid, point, temperature.direction)
        maps = {name: self.maps[name][0] for name in FIELDS}
        along = {name: field[line.i, line.j].astype(np.float64) for name, field in maps.items()}
        self.layout.show_line(temperature.grid, point, line, along)
        self.show_link()

    # what a reader takes along

    def show_look(self) -> None:
        """Show the look of the chosen map in the controls."""
        away = self.layout.takeaway
        name, self._setting_controls = away.map.value, True
        away.show_look(self.looks[name], self.layout.maps[name].prefix)
        self._setting_controls = False

    def choose_look(self) -> None:
        """Draw the chosen map as the controls say."""
        away = self.layout.takeaway
        try:
            self.looks[away.map.value] = away.look(self.layout.maps[away.map.value].prefix)
        except ValueError as error:
            self.say(error)
            return
        self.say("")
        self.draw_maps()
        self.show_link()

    def save(self, name: str) -> None:
        """Let the browser save the part of a map in view, or the fields on the line, as they are shown."""
        if name == LINE:
            if (line := self.layout.line).titles:
                columns = (line.source.data[key] for key in ("distance", *FIELDS))
                text = line_text(dict(zip(line.titles, columns, strict=True)))
                self.layout.takeaway.hand_over("line.csv", text)
        elif (image := (panel := self.layout.maps[name]).shown) is not None:
            title, factor, unit = panel.figure.title.text, self.layout.factor, self.layout.unit
            text = map_text(image, title, factor, unit, panel.prefix)
            self.layout.takeaway.hand_over(f"{name}.csv", text)

    def show_link(self) -> None:
        """Put contact, realization, speed, direction, marked point and looks into the address."""
        state = {
            "contact": self.controls.level.value,
            "realization": self.controls.member.value,
            "speed": f"{self.speed:.6g}",
            "angle": f"{degrees(self.direction):.6g}",
            "point": ",".join(map(str, self.point or ())),
            **{name: look_text(look) for name, look in self.looks.items()},
        }
        link = urlencode({name: value for name, value in state.items() if value}, safe=",")
        self._setting_controls = True
        self.layout.takeaway.link.value = link
        self._setting_controls = False

    def follow(self, link: str) -> None:
        """Show the state that a link holds; a link that is wrong changes nothing but what is said."""
        if self.summary is None:
            self.wanted = link
            return
        self.wanted, given = "", dict(parse_qsl(link))
        try:
            speed = positive("speed", float(given.get("speed", self.speed)), "m/s")
            angle = number("angle", float(given.get("angle", degrees(self.direction))), "°")
            looks = {name: look_of(given[name]) for name in FIELDS if name in given}
            level = int(given.get("contact", self.chosen_level))
            index = int(given.get("realization", self.controls.member.value or 0))
            point = None
            if "point" in given:
                i, j = map(int, given["point"].split(","))
                x, y = self.watched.run.grid(level).shape
                point = i % x, j % y  # the cell is periodic
            if index not in self.summary.sound[level]:
                raise ValueError(f"realization {index} of contact {level} is not there")
        except (ValueError, KeyError) as error:
            self.say(f"the link {link[:80]!r} cannot be followed: {error}")
            return
        self.looks |= looks
        self.show_look()
        before = self.controls.level.value, self.controls.member.value
        self._setting_controls = True
        self.controls.level.value = str(level)
        self.offer_members()
        self.controls.member.value = str(index)
        self._setting_controls = False
        if before == (str(level), str(index)):
            self.point = point or self.point
            self.draw_maps()
        else:
            self.choose_member(point)
        self.choose(speed, radians(angle))
