"""The figures of a report, each as an image inside the page."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from roughsim.charts import plot_run
from roughsim.report.markup import Html, joined, tag, text

if TYPE_CHECKING:
    from roughsim.results.run import Run

KINDS = {".svg": "image/svg+xml", ".png": "image/png"}
# quantity of `plot_run` → format and caption; fields of many points are points, curves are lines
PICTURES = {
    "temperature": (
        ".png",
        "Temperature above the mean of the cell at the highest speed, recomputed from the stored pressure: hot tracks "
        "behind the contacts.",
    ),
    "pressure": (".png", "Contact pressure."),
    "heights": (".png", "Composite heights of both faces."),
    "profile": (".svg", "Heights, pressure and temperature along the sliding direction through the hottest point."),
    "spectrum": (".svg", "Power spectra of the kept heights and of the stress."),
}


def figures(run: Run) -> Html:
    """Return the pictures of the first kept realization; a sentence in place of one that cannot be drawn."""
    if not run.sound(run.realizations):
        return tag("p", "There is no sound realization to draw yet.")
    drawn: list[Html] = []
    reasons: dict[str, str] = {}
    for quantity, (ending, caption) in PICTURES.items():
        try:
            drawn.append(picture(partial(plot_run, run, quantity), ending, caption))
        except (ValueError, OSError) as error:  # not kept, at rest, or damaged
            reasons[quantity] = str(error)
    lines = [f"{quantity} is not shown: {reason}" for quantity, reason in reasons.items()]
    if len(reasons) == len(PICTURES) and len(set(reasons.values())) == 1:  # the same for all is said once
        lines = [f"No pictures: {reasons.popitem()[1]}"]
    return joined(*drawn, *(tag("p", line, css="warning") for line in lines))


def picture(draw: Callable[[Path], object], ending: str, caption: str) -> Html:
    """Return a figure that `draw` writes to a path, as an image inside the page."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"picture{ending}"
        draw(path)
        content = b64encode(path.read_bytes()).decode()
    image = Html(f'<img alt="{text(caption)}" src="data:{KINDS[ending]};base64,{content}">')
    return tag("figure", image, tag("figcaption", caption))
