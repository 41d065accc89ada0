"""The page as it lies on the screen: the controls, the texts and the panels. No computing."""

from __future__ import annotations

from math import degrees, log10

from bokeh import models
from bokeh.layouts import column, row

from roughsim.charts.style import scaled
from roughsim.explore import panels
from roughsim.explore.fields import Field, Line
from roughsim.explore.watched_run import speed_range
from roughsim.grid import Grid
from roughsim.results.run import Run

SIDE = 336  # pixels of the screen along the longer side of a map: three fit side by side on a small one
STEPS = 40  # of the slider in a decade of speed
SPEED_LABEL = "return Number(Math.pow(10, tick).toPrecision(3)) + ' m/s'"  # of a slider over log10 v


def plain_text(name: str, text: str = "", **styles: str) -> models.Div:
    """Return a place for text, now or later, that is neither HTML nor a formula."""
    return models.Div(text=text, render_as_text=True, disable_math=True, name=name, styles=styles)


def small_text(name: str, text: str = "") -> models.PreText:
    """Return a place for lines of small text of even width."""
    return models.PreText(text=text, disable_math=True, name=name, styles={"font-size": "11px"})


def scene_text(run: Run) -> str:
    """Return the scene file, the cell and the grids of a run."""
    grids = (
        f"# L{number}: {level.column}, {level.shape[0]} × {level.shape[1]} points, q_c = {level.q_max:.4g} rad/m"
        for number, level in enumerate(run.numerics.levels)
    )
    sides = " × ".join(f"{1e3 * length:.4g}" for length in run.numerics.lengths)
    return "\n".join([run.scene.to_toml().strip(), "", f"# cell {sides} mm, seed {run.seed}", *grids])


class Controls:
    """What can be chosen: level, realization, speed, direction, and the limits of the colours."""

    def __init__(self, run: Run, speed: float):
        levels = [
            (str(k), f"{level.column}, q_c {level.q_max:.3g}, {level.shape[0]} × {level.shape[1]}")
            for k, level in enumerate(run.numerics.levels)
        ]
        finest = str(run.numerics.of_column(run.column(None))[-1])
        self.level = models.Select(title="contact", options=levels, value=finest, width=240, name="level")
        self.member = models.Select(title="realization", options=[], value="", width=150, disabled=True, name="member")
        low, high = (round(log10(end)) for end in speed_range(run.scene))
        self.slider = models.Slider(start=low, end=high, step=1 / STEPS, value=log10(speed), title="speed", width=300)
        self.slider.update(format=models.CustomJSTickFormatter(code=SPEED_LABEL), name="speed")
        self.speed = models.TextInput(title="v, m/s", value=f"{speed:.4g}", width=80, name="speed_box")
        self.dial = panels.Dial()
        self.angle = models.Spinner(title="direction, °", low=-360, high=360, step=1, value=0, width=90, name="angle")
        self.colours_of = models.RadioButtonGroup(
            labels=["colours of the cell", "of the view"], active=0, name="colours"
        )
        colours = column(plain_text("", "colours"), self.colours_of)
        self.row = row(self.level, self.member, self.slider, self.speed, self.dial.figure, self.angle, colours)

    def show(self, speed: float, direction: float) -> None:
        """Set every control to a speed, m/s, and a direction, rad."""
        self.speed.value = f"{speed:.4g}"
        self.slider.value = min(max(log10(speed), self.slider.start), self.slider.end)
        self.angle.value = round(degrees(direction))
        self.dial.turn(direction)


class Layout:
    """All that is on the page of a run, first at a speed, m/s."""

    def __init__(self, run: Run, speed: float):
        self.factor, self.unit = scaled(max(run.numerics.lengths), "m")
        columns, lengths = run.numerics.columns, [length * self.factor for length in run.numerics.lengths]
        self.controls = Controls(run, speed)

        # maps over one view, with the marked point and the line through it
        ranges = [models.Range1d(0, side, bounds=(-0.02 * side, 1.02 * side)) for side in lengths]
        self.x_range, self.y_range = ranges
        size = [max(int(SIDE * side / max(lengths)), 90) for side in lengths]
        self.maps = {
            name: panels.MapPanel(name, self.unit, (ranges[0], ranges[1]), (size[0], size[1])) for name in panels.FIELDS
        }
        self.point, self.line_ends = (panels.empty_source("x", "y") for _ in range(2))
        for panel in self.maps.values():
            panel.figure.line("x", "y", source=self.line_ends, color=panels.MARK, line_alpha=0.7, line_dash="dashed")
            cross = {"marker": "circle_cross", "size": 13, "color": panels.MARK, "fill_alpha": 0, "line_width": 2}
            panel.figure.scatter("x", "y", source=self.point, **cross)

        # the other panels
        self.line = panels.LinePanels(self.unit)
        self.distribution = panels.DistributionPanel()
        self.curves = {name: panels.CurvePanel(name, columns, speed) for name in panels.CURVES}

        # texts
        self.state, self.values = plain_text("state"), plain_text("values")
        self.busy = plain_text("busy", color="#666666")
        wrapped = {"max-width": "1300px", "white-space": "pre-line"}
        self.problems = plain_text("problems", color="#b00020", **wrapped)
        self.budgets = {name: small_text(f"budget_{name}") for name in columns}

        heading = plain_text(
            "heading", run.scene.title or str(run.folder), **{"font-size": "16px", "font-weight": "bold"}
        )
        scene = small_text("scene", scene_text(run))
        scene.width = 560
        tabs = [models.TabPanel(child=text, title=f"error budget, {name}") for name, text in self.budgets.items()]
        self.root = column(
            row(heading, self.state, self.busy, spacing=16),
            self.problems,
            self.controls.row,
            row(*(panel.figure for panel in self.maps.values())),
            self.values,
            row(column(*self.line.figures), self.distribution.figure),
            row(*(panel.figure for panel in self.curves.values())),
            row(scene, models.Tabs(tabs=tabs), spacing=30),
            margin=(6, 10),
        )

    def clear(self) -> None:
        """Empty the maps and what is read off them."""
        images = (panel.image for panel in self.maps.values())
        panels.clear(*images, self.point, self.line_ends, self.line.source)
        self.distribution.clear()
        self.values.text = ""

    def show_line(self, grid: Grid, point: tuple[int, int], line: Line, fields: dict[str, Field]) -> None:
        """Show the marked point, the line through it on all maps, and fields along it."""
        x, y = (index * d * self.factor for index, d in zip(point, grid.spacing, strict=True))
        self.point.data = {"x": [x], "y": [y]}
        ends = ((name, indices[[0, -1]], d) for name, indices, d in zip("xy", line[1:], grid.spacing, strict=True))
        self.line_ends.data = {name: indices * d * self.factor for name, indices, d in ends}
        texts = self.line.show(line.distance * self.factor, fields, min(grid.spacing) * self.factor)
        position = f"x = {x:.5g} {self.unit}, y = {y:.5g} {self.unit}"
        self.values.text = (
            f"Marked point ({position}), values of the full field: {', '.join(texts)}. Click a map to move it."
        )
