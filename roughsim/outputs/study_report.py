"""A study as one HTML page to send: its table, charts, and scene, all in one file."""

from functools import partial
from importlib import resources
from pathlib import Path
from string import Template

from roughsim.outputs.run_report import picture, place_of
from roughsim.scene import with_short_tables
from roughsim.show.markup import Html, html_table, joined, tag, text
from roughsim.store.disk import place_bytes
from roughsim.studies.study import Study
from roughsim.studies.tables import study_table

_DRAWN = {
    "flash_temperature": "Flash temperature. Points and bands: simulated, with the total error, 95 %. Lines: theory; "
    "dashed: by the calibrated stress spectrum. Hollow: at q_c, or a part of the error is unknown.",
    "contact_fraction": "Contact area over nominal area. Hollow: at q_c, or a part of the error is unknown.",
}


def report_study(study: Study, path: str | Path | None = None) -> Path:
    """Write a study as one self-contained HTML page, without scripts and requests, and return its path.

    `path` ends in .html, ValueError if not; left out: beside the folder, named after it.
    """
    place = place_of(study.folder, path)
    place_bytes(place, page(study).encode())
    return place


def page(study: Study) -> str:
    """Return the page of a study as HTML."""
    title = study.scene.title or study.folder.resolve().name
    keys = ", ".join(key for axis in study.axes for key in axis.keys)
    state = f"A study over {keys}: {study.finished} of {len(study.points)} points finished."
    parts = {
        "Result": html_table(study_table(study)),
        "Charts": joined(*(chart(study, name, caption) for name, caption in _DRAWN.items())),
        "Scene": tag("pre", with_short_tables(study.scene.to_toml())),
    }
    links = (tag("a", name, href=f"#{name.lower()}") for name in parts)
    bodies = (tag("section", tag("h2", name), content, id=name.lower()) for name, content in parts.items())
    body = joined(tag("header", tag("h1", title), tag("p", state, css="state")), tag("nav", *links), *bodies)
    template = Template((resources.files("roughsim.outputs") / "page.html").read_text(encoding="utf-8"))
    return template.substitute(title=text(title), body=body)


def chart(study: Study, observable: str, caption: str) -> Html:
    """Return a chart, or the reason for its absence."""
    try:
        return picture(partial(study.chart, observable=observable), ".svg", caption)
    except ValueError as error:
        return tag("p", f"{observable} is not shown: {error}", css="warning")
