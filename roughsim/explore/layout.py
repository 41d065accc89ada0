"""The page as it lies on the screen: the controls, the figures, and how values are put into them. No computing."""

from __future__ import annotations

from math import cos, degrees, isnan, log10, pi, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.layouts import column, row
from bokeh.models import (
    ColumnDataSource,
    Div,
    PreText,
    RadioButtonGroup,
    Select,
    Slider,
    Spinner,
    TabPanel,
    Tabs,
    TextInput,
)

from roughsim.charts.style import scaled
from roughsim.explore import curves, figures
from roughsim.explore import words as sentences

if TYPE_CHECKING:
    from roughsim.explore.specimen import Distribution, Line
    from roughsim.grid import Grid
    from roughsim.results.run import Run

_UNITS = {"heights": "m", "pressure": "Pa", "temperature": "K"}
_SMALL = {"font-size": "11px"}
_STEPS = 40  # of the slider in a decade of speed
_CURVES = {
    curves.CORRELATION: ("Stress correlation g_σ(r)", "r, µm", "g_σ, GPa²", 1e6, 1e-18),
    "flash_temperature": ("Flash temperature", "v, m/s", "T_flash, K", 1.0, 1.0),
    "flash_width": ("Hot-spot width", "v, m/s", "D_flash, µm", 1.0, 1e6),
    "slope_length": ("Slope length", "v, m/s", "d_flash, µm", 1.0, 1e6),
}


def words(name: str, text: str = "", **styles: str) -> Div:
    """Return a place for text, now or later, that is neither HTML nor a formula."""
    return Div(text=text, render_as_text=True, disable_math=True, name=name, styles=styles)


class Layout:
    """All that is on the page.

    Parameters
    ----------
    run : Run
        What is shown.
    speed : float
        Where the slider stands first, m/s.
    ends : (float, float)
        Of the slider, m/s.
    """

    def __init__(self, run: Run, speed: float, ends: tuple[float, float]):
        self.run = run
        self.factor, self.unit = scaled(max(run.numerics.lengths), "m")
        self.first_speed = speed
        self._build_controls(speed, ends)
        self._build_figures()
        self.texts = {
            name: PreText(text="", disable_math=True, name=f"budget_{name}", styles=_SMALL)
            for name in run.numerics.columns
        }
        self.root = self._arranged()

    def _build_controls(self, speed: float, ends: tuple[float, float]) -> None:
        run = self.run
        labels = {
            str(k): f"{level.column}, q_c {level.q_max:.3g}, {level.shape[0]} × {level.shape[1]}"
            for k, level in enumerate(run.numerics.levels)
        }
        finest = str(run.numerics.of_column(run.column(None))[-1])
        self.level = Select(title="contact", options=list(labels.items()), value=finest, width=240, name="level")
        self.member = Select(title="realization", options=[], value="", width=150, disabled=True, name="member")
        low, high = (round(log10(end)) for end in ends)
        self.slider = Slider(
            start=low,
            end=high,
            step=1 / _STEPS,
            value=log10(speed),
            title="speed",
            format=figures.as_speed(),
            width=300,
            name="speed",
        )
        self.speed = TextInput(title="v, m/s", value=f"{speed:.4g}", width=80, name="speed_box")
        self.angle = Spinner(title="direction, °", low=-360, high=360, step=1, value=0, width=90, name="angle")
        self.span = RadioButtonGroup(labels=["colours of the cell", "of the view"], active=0, name="span")
        self.state = words("state")
        self.busy = words("busy", color="#666666")
        self.problems = words("problems", color="#b00020", **{"max-width": "1300px", "white-space": "pre-line"})
        self.values = words("values")

    def _build_figures(self) -> None:
        self._turned = 0.0
        self._hand = ColumnDataSource(_hand(self._turned))
        self.dial = figures.dial(self._hand)
        self._mark, self._line = (ColumnDataSource({"x": [], "y": []}) for _ in range(2))
        lengths = self.run.numerics.lengths[0] * self.factor, self.run.numerics.lengths[1] * self.factor
        self.maps = figures.maps(lengths, self.unit, self._mark, self._line)
        first = self.maps["heights"].figure
        self.x_range, self.y_range = first.x_range, first.y_range
        self.panels, self._profile = figures.profiles(self.unit)
        self.distribution = figures.distribution()
        columns = self.run.numerics.columns
        self._now = {name: figures.speed_line(self.first_speed) for name in curves.OVER_SPEED}
        self.charts = {
            name: figures.curve(*labels[:3], columns, self._now.get(name)) for name, labels in _CURVES.items()
        }

    def _arranged(self) -> Any:
        title = self.run.scene.title or str(self.run.folder)
        heading = words("heading", title, **{"font-size": "16px", "font-weight": "bold"})
        colours = column(words("", "colours"), self.span)
        controls = row(self.level, self.member, self.slider, self.speed, self.dial, self.angle, colours)
        budget = Tabs(tabs=[TabPanel(child=text, title=f"error budget, {n}") for n, text in self.texts.items()])
        scene = PreText(text=sentences.scene_of(self.run), disable_math=True, name="scene", width=560, styles=_SMALL)
        return column(
            row(heading, self.state, self.busy, spacing=16),
            self.problems,
            controls,
            row(*(one.figure for one in self.maps.values())),
            self.values,
            row(column(*self.panels), self.distribution.figure),
            row(*(chart.figure for chart in self.charts.values())),
            row(scene, budget, spacing=30),
            margin=(6, 10),
        )

    def tell(self, lines: list[str]) -> None:
        """Show what is wrong, a line each."""
        self.problems.text = "\n".join(lines)

    def offer(self, sound: list[int], kept: list[int]) -> None:
        """List the realizations."""
        there = set(kept)
        self.member.options = [(str(i), str(i) if i in there else f"{i} (fields not kept)") for i in sound]
        self.member.disabled = not sound

    def clear(self) -> None:
        """Empty the maps and what is read off them."""
        for one in self.maps.values():
            one.image.data = dict(figures.IMAGE)
        for source in (self._mark, self._line, self._profile, *self.distribution.sources.values()):
            source.data = {name: [] for name in source.data}
        self.values.text = self.distribution.figure.title.text = ""

    def show_controls(self, speed: float, direction: float) -> None:
        """Set every control to a speed, m/s, and a direction, rad."""
        self.speed.value = f"{speed:.4g}"
        self.slider.value = min(max(log10(speed), self.slider.start), self.slider.end)
        self.angle.value = round(degrees(direction))
        self.turn_dial(direction)
        for line in self._now.values():
            line.location = speed

    def turn_dial(self, direction: float) -> None:
        """Point the hand of the dial along a direction, rad."""
        if self._turned != direction:
            self._turned = direction
            self._hand.data = _hand(direction)

    def show_image(
        self, name: str, data: dict[str, Any], limits: tuple[float, float], step: tuple[int, int], note: str
    ) -> None:
        """Show the image of a field: one replacement of its data, and the limits beside it."""
        one = self.maps[name]
        factor, unit = scaled(max(abs(limits[0]), abs(limits[1])), _UNITS[name])
        one.image.data = data
        one.scale.update(low=limits[0] * factor, high=max(limits[1] * factor, limits[0] * factor + 1e-9))
        seen = f"averaged view, {step[0]} × {step[1]}" if max(step) > 1 else "every point"
        one.figure.title.text = f"{figures.TITLES[name]}, {unit}{note}  ({seen})"

    def show_line(self, grid: Grid, point: tuple[int, int], line: Line, values: dict[str, Any]) -> None:
        """Show the marked point, its values, and the line through it."""
        x, y = (index * d for index, d in zip(point, grid.spacing, strict=True))
        self._mark.data = {"x": [x * self.factor], "y": [y * self.factor]}
        ends = [0, -1]
        self._line.data = {
            "x": line.i[ends] * grid.spacing[0] * self.factor,
            "y": line.j[ends] * grid.spacing[1] * self.factor,
        }
        said, data = [], {"distance": values["distance"] * self.factor}
        middle = int(np.abs(values["distance"]).argmin())
        for name, panel in zip(_UNITS, self.panels, strict=True):
            factor, unit = scaled(float(np.nanmax(np.abs(values[name]), initial=0.0)), _UNITS[name])
            data[name] = values[name] * factor
            panel.yaxis.axis_label = f"{figures.LETTERS[name]}, {unit}"
            at = values[name][middle]
            said.append(f"{figures.LETTERS[name]} = {'…' if isnan(at) else f'{at * factor:.5g} {unit}'}")
        data["contact"] = (values["pressure"] > 0.0).astype(np.float64)
        data["width"] = np.full(len(line.i), min(grid.spacing) * self.factor)
        self._profile.data = data
        place = f"x = {x * self.factor:.5g} {self.unit}, y = {y * self.factor:.5g} {self.unit}"
        self.values.text = (
            f"Marked point ({place}), values of the full field: {', '.join(said)}. Click a map to move it."
        )

    def show_distribution(self, found: Distribution) -> None:
        """Show the temperature over the contact."""
        edges, plot = found.edges, self.distribution.figure
        middle = 0.5 * (edges[1:] + edges[:-1])
        bins = {
            "left": edges[:-1],
            "right": edges[1:],
            "area": 100 * found.area,
            "middle": middle,
            "heat": 100 * found.heat,
        }
        self.distribution.sources["bins"].data = bins
        top = 100 * float(max(found.area.max(initial=0.0), found.heat.max(initial=0.0)))
        known = not isnan(found.flash_temperature)
        flash = {"x": [found.flash_temperature], "y0": [0.0], "y1": [top]}
        self.distribution.sources["flash"].data = flash if known else {"x": [], "y0": [], "y1": []}
        plot.title.text = (
            f"In the contact: ⟨Tσ⟩/⟨σ⟩ = {found.flash_temperature:.4g} K (dashed), "
            f"mean {found.mean_temperature:.4g} K, highest {found.max_temperature:.4g} K"
            if known
            else "No contact"
        )

    def show_theory(self, lines: dict[str, tuple[Any, Any]]) -> None:
        """Show the curves of the theory."""
        for name, (x, value) in lines.items():
            _, _, _, x_factor, factor = _CURVES[name]
            self.charts[name].sources["theory"].data = {"x": x * x_factor, "y": value * factor}

    def show_curves(self, measured: dict[str, dict[str, curves.Curve]]) -> None:
        """Show the measured curves: bands of the errors that each bears."""
        for label, of_column in measured.items():
            for name, curve in of_column.items():
                _, _, _, x_factor, factor = _CURVES[name]
                reach = np.where(np.isfinite(curve.error), curve.error, 0.0)
                low, high = (curve.mean - reach) * factor, (curve.mean + reach) * factor
                if name != curves.CORRELATION:  # a logarithmic axis ends somewhere
                    low = np.maximum(low, 1e-3 * curve.mean * factor)
                data = {"x": curve.x * x_factor, "y": curve.mean * factor, "low": low, "high": high}
                self.charts[name].sources[label].data = data

    def show_budget(self, texts: dict[str, str]) -> None:
        """Show the error budgets."""
        for name, text in texts.items():
            self.texts[name].text = text


def _hand(direction: float) -> dict[str, Any]:
    x, y = cos(direction), sin(direction)
    return {
        "x": [0.0, 0.86 * x],
        "y": [0.0, 0.86 * y],
        "tip_x": [x] * 2,
        "tip_y": [y] * 2,
        "angle": [direction - pi / 2] * 2,
    }
