"""A run as one page that can be mailed: scene, plan, comparison, errors, figures and provenance, all in one file."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from roughsim.comparison.compare import compare
from roughsim.comparison.tables import comparison_table
from roughsim.report import sections
from roughsim.report.markup import html_table, joined, tag, text
from roughsim.store.disk import place_bytes

if TYPE_CHECKING:
    from roughsim.results.run import Run

ENDINGS = (".html", ".htm")


def report_run(run: Run, path: str | Path | None = None) -> Path:
    """Write a run as one self-contained HTML page, without scripts and requests, and return where it is.

    The run may be still going on, or have no realization yet. Opened with ``damaged="skip"``, damaged files are named
    and all else is shown. `path` ends in .html, ValueError if not; left out: beside the run folder, named after it.
    """
    folder = run.folder.resolve()
    place = folder.with_name(f"{folder.name}.html") if path is None else Path(path)
    if place.suffix.lower() not in ENDINGS:
        raise ValueError(f"path = {str(place)!r} of a report must end in .html")
    place.parent.mkdir(parents=True, exist_ok=True)
    place_bytes(place, page(run).encode())
    return place


def page(run: Run) -> str:
    """Return the page of a run as HTML."""
    try:
        comparison = compare(run)
        result, table = sections.answer(comparison), html_table(comparison_table(comparison))
    except ValueError as error:  # fewer than two sound realizations
        result = table = tag("p", f"There is nothing to compare yet: {error}", css="warning")
    parts = {
        "Result": result,
        "Comparison": table,
        "Errors": sections.errors_section(run),
        "Pictures": sections.figures_section(run),
        "Plan": sections.plan_section(run),
        "Scene": sections.scene_section(run),
        "Provenance": sections.provenance_section(run),
    }
    links = (tag("a", name, href=f"#{name.lower()}") for name in parts)
    bodies = (tag("section", tag("h2", name), content, id=name.lower()) for name, content in parts.items())
    body = joined(sections.header(run), tag("nav", *links), *bodies)
    template = Template((resources.files("roughsim.report") / "page.html").read_text(encoding="utf-8"))
    return template.substitute(title=text(run.scene.title or run.folder.resolve().name), body=body)


__all__ = ["page", "report_run"]
