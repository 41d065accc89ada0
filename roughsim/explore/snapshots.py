"""Snapshots of two sliding bodies on the page: pressure and temperature at the kept positions, and T_flash."""

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh import models
from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.plotting import figure

from roughsim.charts.style import AT_REST, MARK, scale_colours, scaled
from roughsim.explore.content import image_of
from roughsim.explore.controls import WRAPPED
from roughsim.explore.layout import (
    LEGEND,
    MapPanel,
    empty_source,
    frame,
    plain_text,
    upright,
)
from roughsim.observables.catalogue import AXIS
from roughsim.results.run import Run
from roughsim.results.snapshots import MemberSnapshots, read_snapshots

_SIDE = 286  # screen pixels along the longer side of a map: one map fits on a telephone
_FRAME = 300  # ms that a position is shown while the snapshots play
_WORDS = (
    "Both faces slide. Triangles: the highest summits of the face at rest. Circles: the highest summits of the moving "
    "face, which move to the left. Contact forms at meeting summits. Temperature: of the surface of the moving body, "
    "above its background. The colours are the same at all positions."
)
_NONE_YET = "No slide has kept its maps yet: the first --keep-fields realizations do."


class SnapshotsView:
    """Snapshots of a run with two sliding faces; `root` is its part of the page.

    `ask` runs a first function in a thread and shows its result by a second one.
    """

    def __init__(
        self,
        run: Run,
        document: Document,
        ask: Callable[[Callable[[], Any], Callable[[Any], None]], None],
    ):
        self.run, self.document, self.ask = run, document, ask
        self.snapshots: MemberSnapshots | None = None
        self.playing: Any = None  # the callback that turns to the next position
        self.factor, self.unit = scaled(max(run.sides), "m")
        self._add_controls()
        self._add_maps()
        self._add_curves()
        self.text = plain_text("snapshots_text", _NONE_YET)
        self.root = column(
            row(self.member, self.speed, self.slider, self.play, styles=WRAPPED),
            row(*(panel.figure for panel in self.maps.values()), self.curve, styles=WRAPPED),
            self.text,
            plain_text("snapshots_words", _WORDS, **{"max-width": "1000px", "color": "#666666"}),
            name="snapshots",
        )

    def _add_controls(self) -> None:
        """Make the controls: realization, speed, slid distance, and a button that plays the snapshots."""
        speeds = [(str(k), f"{v:g} m/s") for k, v in enumerate(self.run.scene.speeds)]
        fastest = str(int(np.argmax(self.run.scene.speeds)))
        self.member = models.Select(
            title="snapshots of realization",
            value="",
            width=140,
            disabled=True,
            name="snapshots_member",
        )
        self.speed = models.Select(
            title="at", options=speeds, value=fastest, width=100, name="snapshots_speed"
        )
        self.slider = models.Slider(
            title="slid distance", start=0, end=1, step=1, value=0, width=240
        )
        self.slider.update(name="snapshots_position", disabled=True)
        self.play = models.Toggle(label="▶ play", width=70, align="end", name="snapshots_play")
        self.member.on_change("value", lambda attr, old, new: self.choose_member())
        self.speed.on_change("value", lambda attr, old, new: self.choose_speed())
        self.slider.on_change("value", lambda attr, old, new: self.draw())
        self.play.on_change("active", lambda attr, old, new: self.start_or_stop())

    def _add_maps(self) -> None:
        """Make the maps, which are zoomed together, with the summits of both faces."""
        lengths = self.run.sides
        # the first view is half the cell: in a smaller one spots appear and vanish
        view = frame(lengths, self.unit, _SIDE)
        for axis, length in zip("xy", lengths, strict=True):
            end = length * self.factor
            view[f"{axis}_range"] = models.Range1d(0, end / 2, reset_end=end)
        self.maps = {
            name: MapPanel(name, f"snapshots_{name}", **view)
            for name in ("pressure", "temperature")
        }
        self.at_rest, self.riding = empty_source("x", "y"), empty_source("x", "y")
        marks: dict[str, Any] = {"fill_alpha": 0.0, "line_width": 2, "size": 9}
        for panel in self.maps.values():
            for source, marker, colour in (
                (self.at_rest, "triangle", AT_REST),
                (self.riding, "circle", MARK),
            ):
                style = marks | {"source": source, "marker": marker, "line_color": colour}
                panel.figure.scatter("x", "y", **style)

    def _add_curves(self) -> None:
        """Make the panel of T_flash over the distance, a line for each speed, with a cursor."""
        options = dict.fromkeys(("x_axis_type", "y_axis_type"), "log")
        options |= {"x_axis_label": f"slid distance, {self.unit}", "y_axis_label": "T_flash, K"}
        options |= {"name": "snapshots_curve", "tools": "pan,wheel_zoom,reset"}
        self.curve = figure(width=360, height=_SIDE + 60, **options)
        self.curve.visible = False  # until there are snapshots
        self.lines = []
        speeds = self.run.scene.speeds
        for speed, colour in zip(speeds, scale_colours(len(speeds)), strict=True):
            source = empty_source("x", "y", "frozen")
            style = {"source": source, "color": colour}
            self.curve.line("x", "y", line_width=2, legend_label=f"{speed:g} m/s", **style)
            self.curve.line("x", "frozen", line_dash="dashed", **style)
            self.lines.append(source)
        self.curve.title.text = "Flash temperature; dashed: frozen contact"
        self.curve.legend.update(**LEGEND, ncols=4, padding=0)
        self.curve.add_layout(self.curve.legend[0], "below")  # there are lines in every corner
        self.cursor = upright(None, MARK, line_width=2)
        self.curve.add_layout(self.cursor)

    def offer(self, indices: list[int]) -> None:
        """List the realizations with snapshots; if none is shown yet, show the first."""
        self.member.options = [str(index) for index in indices]
        self.member.disabled = not indices
        if indices and not self.member.value:
            self.member.value = str(indices[0])

    def choose_member(self) -> None:
        """Read the snapshots of the chosen realization."""
        index = int(self.member.value)
        self.text.text = f"reading the snapshots of realization {index} …"
        self.ask(lambda: read_snapshots(self.run, index), self.show_snapshots)

    def show_snapshots(self, snapshots: MemberSnapshots) -> None:
        """Show snapshots that have been read, at their last position."""
        self.snapshots = snapshots
        distance = snapshots.curves[AXIS] * self.factor
        for k, source in enumerate(self.lines):
            flash = snapshots.curves["slide_flash_temperature"][k]
            frozen = snapshots.curves["slide_frozen_flash_temperature"][k]
            slid = np.isfinite(flash)
            source.data = {"x": distance[slid], "y": flash[slid], "frozen": frozen[slid]}
        self.curve.visible = True
        x, y = snapshots.resting_summits.T * self.factor
        self.at_rest.data = {"x": x, "y": y}
        self.choose_speed()

    def choose_speed(self) -> None:
        """Show the last position at the chosen speed, or the same one if it comes before that."""
        if self.snapshots is None:
            return
        last = self.snapshots.positions(int(self.speed.value)) - 1
        slid = self.snapshots.maps.distance * self.factor
        texts = [f"{distance:.3g} {self.unit}" for distance in slid]
        label = models.CustomJSTickFormatter(args={"texts": texts}, code="return texts[tick]")
        place = last if self.slider.disabled else min(self.slider.value, last)
        # first: the page writes it beside the slider when the value changes
        self.slider.format = label
        self.slider.update(end=max(last, 1), value=place, disabled=last < 1)
        self.draw()

    def draw(self) -> None:
        """Show the chosen position."""
        if (snapshots := self.snapshots) is None:
            return
        place, k = int(self.slider.value), int(self.speed.value)
        fields = {"pressure": snapshots.maps.pressure, "temperature": snapshots.maps.temperature[k]}
        for name, frames in fields.items():
            limits = float(np.nanmin(frames)), float(np.nanmax(frames))
            x, y = snapshots.grid.lengths
            image = image_of(frames[place], snapshots.grid, ((0.0, x), (0.0, y)), limits)
            note = f", {self.run.scene.speeds[k]:g} m/s" if name == "temperature" else ""
            self.maps[name].show(image, self.factor, note)
        x, y = snapshots.moving_summits[place].T * self.factor
        self.riding.data = {"x": x, "y": y}
        slid = float(snapshots.maps.distance[place])
        self.cursor.location = slid * self.factor
        self.text.text = self.words(snapshots, k, slid)

    def words(self, snapshots: MemberSnapshots, k: int, slid: float) -> str:
        """Return a line of the temperatures, heat share and contact area at a position."""
        # snapshots have some positions of the curves
        at = int(np.abs(snapshots.curves[AXIS] - slid).argmin())
        flash, background, share = (
            snapshots.curves[f"slide_{name}"][k, at]
            for name in ("flash_temperature", "background", "moving_share")
        )
        return (
            f"After {slid * self.factor:.3g} {self.unit} at {self.run.scene.speeds[k]:g} m/s: T_flash = {flash:.4g} K "
            f"above a background of {background:.4g} K; {100 * share:.3g} % of the heat enters the moving body; "
            f"{100 * snapshots.curves['slide_contact_fraction'][at]:.3g} % of the area touches"
        )

    def start_or_stop(self) -> None:
        """Play from the chosen position, or from the first if it is the last; stop if they play."""
        if self.playing is not None:
            self.document.remove_periodic_callback(self.playing)
            self.playing = None
        if self.play.active:
            if self.slider.value >= self.slider.end:
                self.slider.value = 0
            self.playing = self.document.add_periodic_callback(self.turn, _FRAME)
        self.play.label = "❚❚ stop" if self.play.active else "▶ play"

    def turn(self) -> None:
        """Turn to the next position; at the last one they stop."""
        if self.slider.value < self.slider.end:
            self.slider.value += 1
        if self.slider.value >= self.slider.end:
            self.play.active = False
