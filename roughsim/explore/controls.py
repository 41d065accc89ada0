"""The controls of the page of a run: contact, realization, speed and direction."""

from math import degrees, log10

from bokeh import models
from bokeh.layouts import row

from roughsim.explore.content import speed_range
from roughsim.results.run import Run

WRAPPED = {"flex-wrap": "wrap"}  # a line that is too long is broken
_STEPS = 40  # of the slider in a decade of speed
_SPEED_LABEL = "return Number(Math.pow(10, tick).toPrecision(3)) + ' m/s'"  # JavaScript: the slider is over log10 v


class Controls:
    """The controls: level, realization, speed, direction, and the limits of the colours."""

    def __init__(self, run: Run, speed: float):
        levels = []
        for k in run.numerics.single:
            level = run.numerics.levels[k]
            x, y = level.shape
            words = f"{level.column}, q_c {level.q_max:.3g}, {x} × {y}"
            levels.append((str(k), words + level.where.replace(" in", ",")))
        finest = str(run.picture() if run.independent else run.numerics.picture(run.column(None)))
        self.level = models.Select(
            title="contact", options=levels, value=finest, width=240, name="level"
        )
        self.member = models.Select(
            title="realization", options=[], value="", width=150, disabled=True, name="member"
        )
        low, high = (round(log10(end)) for end in speed_range(run.scene))
        self.slider = models.Slider(
            start=low, end=high, step=1 / _STEPS, value=log10(speed), title="speed", width=300
        )
        self.slider.update(format=models.CustomJSTickFormatter(code=_SPEED_LABEL), name="speed")
        self.speed = models.TextInput(
            title="v (m/s)", value=f"{speed:.4g}", width=80, name="speed_box"
        )
        angles = {"start": -180, "end": 180, "step": 1, "value": 0}
        self.angle = models.Slider(
            title="sliding direction from x of the map, °", width=250, name="angle", **angles
        )
        # of the results: the map turns with it, and with the slider to any other
        turned = [(str(k), f"{degrees(at):.4g}°") for k, at in enumerate(run.scene.directions)]
        self.direction = models.Select(
            title="results in direction",
            options=turned,
            value="0",
            width=140,
            visible=bool(turned),
            name="direction",
        )
        labels = ["colours of the cell", "of the view"]
        self.colours_of = models.RadioButtonGroup(
            labels=labels, active=0, align="end", name="colours"
        )
        self.row = row(
            self.level,
            self.member,
            self.slider,
            self.speed,
            self.angle,
            self.direction,
            styles=WRAPPED,
        )
