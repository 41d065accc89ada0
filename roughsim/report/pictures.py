"""The figures of a report, each as an image inside the page."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from roughsim.charts import plot_run
from roughsim.report.markup import Html, joined, tag

if TYPE_CHECKING:
    from roughsim.results.run import Run

KINDS = {".svg": "image/svg+xml", ".png": "image/png"}
# what `plot` draws, as what, and what to say under it; many points are a raster, few are lines
SHOWN = {
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
    reasons: list[str] = []
    for quantity, (ending, caption) in SHOWN.items():
        try:
            drawn.append(picture(_drawer(run, quantity), ending, caption))
        except (ValueError, OSError) as error:  # not kept, at rest, or damaged
            reasons.append(f"{quantity} is not shown: {error}")
    missing = (tag("p", reason, css="warning") for reason in dict.fromkeys(_short(reasons)))
    return joined(*drawn, *missing)


def _short(reasons: list[str]) -> list[str]:
    """The reasons, said once where they are the same for all."""
    causes = {reason.partition(": ")[2] for reason in reasons}
    return [f"No pictures: {causes.pop()}"] if len(reasons) == len(SHOWN) and len(causes) == 1 else reasons


def _drawer(run: Run, quantity: str) -> Callable[[Path], object]:
    return lambda path: plot_run(run, quantity, path)


def picture(draw: Callable[[Path], object], ending: str, caption: str) -> Html:
    """Return a figure that `draw` writes to the path it is given, as an image inside the page."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"picture{ending}"
        draw(path)
        content = path.read_bytes()
    image = Html(
        f'<img alt="{tag("i", caption)[3:-4]}" src="data:{KINDS[ending]};base64,{b64encode(content).decode()}">'
    )
    return tag("figure", image, tag("figcaption", caption))
