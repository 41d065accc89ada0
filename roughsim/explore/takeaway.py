"""How maps look, what a reader takes from the page as a file, and the state of the page in its address."""

import numpy as np
from bokeh import models
from bokeh.layouts import row

from roughsim.errors import number
from roughsim.explore.content import USUAL, Field, Image, MapLook

LINE = "line"  # in the menu of data
_COLOURS = ("", "usual"), *((name, name) for name in ("viridis", "cividis", "gray"))
_SAVE = """const link = document.createElement('a')
link.href = URL.createObjectURL(new Blob([menu.tags[1]], {type: 'text/csv'}))
link.download = menu.tags[0]
link.click()
URL.revokeObjectURL(link.href)"""
_SHOW_LINK = "history.replaceState(null, '', '#' + link.value)"
# once: a document is ready again after each change
_READ_LINK = """if (!window.linkWasRead && location.hash.length > 1)
    link.value = decodeURIComponent(location.hash.slice(1))
window.linkWasRead = true"""


class Takeaway:
    """The controls of the look of a map, the menu of data, and a hidden box that holds the state of the page."""

    def __init__(self, titles: dict[str, str], colours_of: models.RadioButtonGroup):
        maps = [*titles.items()]
        self.map = models.Select(title="look of", options=maps, value="temperature", width=160)
        self.colours = models.Select(title="colour map", options=[*_COLOURS], value="", width=100)
        self.low, self.high = (
            models.TextInput(title=title, value="", placeholder="own", width=80, name=title)
            for title in ("from", "to")
        )
        self.log = models.CheckboxGroup(labels=["log scale"], active=[], align="end", name="log")
        menu = [("line", LINE), *((f"map: {title}", name) for name, title in maps)]
        self.save = models.Dropdown(label="save data", menu=menu, width=110, align="end")
        self.save.js_on_change("tags", models.CustomJS(args={"menu": self.save}, code=_SAVE))
        self.link = models.TextInput(value="", visible=False, name="link")
        self.link.js_on_change("value", models.CustomJS(args={"link": self.link}, code=_SHOW_LINK))
        self.read = models.CustomJS(args={"link": self.link}, code=_READ_LINK)
        self.inputs = self.colours, self.low, self.high, self.log
        wrapped = {"flex-wrap": "wrap"}
        self.row = row(self.map, *self.inputs, colours_of, self.save, self.link, styles=wrapped)

    def look(self, prefix: float) -> MapLook:
        """Return the look in the controls; the prefix turns SI into the unit of the map. ValueError if wrong."""
        low, high = (
            number(box.title, float(box.value), "the unit of the map") / prefix
            if box.value.strip()
            else None
            for box in (self.low, self.high)
        )
        if low is not None and high is not None and low >= high:
            raise ValueError(f"from = {self.low.value} must be below to = {self.high.value}")
        return MapLook(self.colours.value, low, high, bool(self.log.active))

    def show_look(self, look: MapLook, prefix: float) -> None:
        """Show the look of a map in the controls."""
        self.colours.value, self.log.active = look.colours, [0] if look.log else []
        for box, limit in ((self.low, look.low), (self.high, look.high)):
            box.value = "" if limit is None else f"{limit * prefix:.4g}"

    def hand_over(self, name: str, text: str) -> None:
        """Let the browser save a file."""
        self.save.tags = [name, text]


def map_text(image: Image, title: str, factor: float, unit: str, prefix: float) -> str:
    """Return the part of a map in view as CSV, as `plot --csv` writes it: x down, y along the first line."""
    left, bottom, width, height = (length * factor for length in image.box)
    count, other = image.means.shape
    x, y = (
        np.round(low + (np.arange(points) + 0.5) * length / points, 9)
        for low, points, length in ((left, count, width), (bottom, other, height))
    )
    head = f"# {title}; x ({unit}) in the first column; y ({unit}) in the first line\n"
    rows = np.column_stack((x, image.means * prefix))
    return head + "," + _line(y) + "".join(map(_line, rows))


def line_text(columns: dict[str, Field]) -> str:
    """Return fields along the line as CSV, with a title for each column."""
    return ",".join(columns) + "\n" + "".join(map(_line, np.column_stack([*columns.values()])))


def _line(values: Field) -> str:
    return ",".join(f"{value:.7g}" for value in values) + "\n"


def look_text(look: MapLook) -> str:
    """Return a look as it stands in a link: "viridis,,400,log"; "" for the usual one."""
    if look == USUAL:
        return ""
    limits = ("" if end is None else f"{end:.6g}" for end in (look.low, look.high))
    return ",".join((look.colours, *limits, "log" * look.log))


def look_of(text: str) -> MapLook:
    """Return the look of a text of a link; ValueError if it is none."""
    colours, low, high, log = text.split(",")
    if colours not in dict(_COLOURS):
        raise ValueError(f"colour map = {colours!r} is none of {', '.join(dict(_COLOURS))}")
    ends = [number("limit", float(end), "SI") if end else None for end in (low, high)]
    return MapLook(colours, ends[0], ends[1], log == "log")
