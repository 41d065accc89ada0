"""A run as one HTML page to send: scene, plan, comparison, errors, figures and provenance, all in one file."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from importlib import resources
from math import degrees, isfinite
from pathlib import Path
from string import Template

import numpy as np

from roughsim import prediction
from roughsim.charts.plot import plot_run
from roughsim.charts.style import data_url
from roughsim.comparison.compare import TESTS, Comparison
from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import state_line
from roughsim.planning.limits import Plausibility
from roughsim.planning.reasons import level_text, plan_table
from roughsim.results.columns import meaning
from roughsim.results.run import Run
from roughsim.results.theories import THEORIES
from roughsim.scene import Scene, with_short_tables
from roughsim.show.markup import Html, bullets, digits, html_table, joined, tag, text
from roughsim.show.table import Cell, Column, Number, Table
from roughsim.show.text import clock
from roughsim.show.text import note as note_work

# quantity of `plot_run` → format and caption: maps as pixels, curves as lines
PICTURES = {
    "temperature": (
        ".png",
        "Temperature above the mean of the cell at the highest speed, recomputed from the stored pressure of one "
        "realization; lines: outlines of the contact, ahead of its hot tracks; a large cell has its hottest part beside it.",
    ),
    "pressure": (".png", "Contact pressure of this realization; grey: at the hardness."),
    "heights": (".png", "Composite heights of both faces of this realization."),
    "profile": (
        ".svg",
        "Heights, pressure and temperature along the sliding direction through the hottest point, in a large cell also "
        "enlarged around it; shaded: contact.",
    ),
    "spectrum": (
        ".svg",
        "C(q) of the kept heights on that of the scene, dashed: C_sm(q); variance of the stress by wavenumber, all "
        "realizations with their statistical error, 95 %, beside the theory; dotted: q_c.",
    ),
}
_SLIDING_PICTURES = {
    "sliding": (
        ".svg",
        "Both faces slide: temperatures, share of the heat and turnover of the contact over the slid distance.",
    ),
    "snapshots": (
        ".png",
        "Pressure, and temperature of the moving body, at four slid distances of one member.",
    ),
}
_REACTION_PICTURES = {
    "reaction": (
        ".svg",
        "Share of the contact that is hotter than T at the highest speed; activation temperatures and rates over the "
        "speed, a colour for each energy; bands and bars: total error, 95 %; dashed: calibrated theory.",
    )
}
_OPEN = "Result", "Pictures", "Charts"  # parts of a page that are not folded
_ALWAYS = "temperature", "reaction", "sliding"  # pictures that are not folded
_FEW_FAILURES = 20  # members without numbers that the report names


def page(run: Run) -> str:
    """Return the page of a run as HTML: scene, plan, comparison, errors, figures and provenance.

    The run may still be going on, or have no realization yet. Of a run opened with ``damaged="skip"`` the page names
    the damaged files and shows the rest.
    """
    note_work(f"comparing {run.folder} with the theory")
    try:
        comparison = Comparison(run)
        result, table = answer(comparison), html_table(comparison.table())
    except ValueError as error:  # fewer than two sound realizations
        result = table = tag("p", f"There is nothing to compare yet: {error}", css="warning")
    judged = run.judged
    parts = {
        "Result": result,
        "Pictures": figures_section(run),
        "Comparison": table,
        "Errors": errors_section(run),
        "Plan": _plan_section(run),
        "Scene": scene_section(run.scene, judged),
        "Provenance": _provenance_section(run),
    }
    title = run.scene.title or run.folder.resolve().name
    return assembled(title, header(run, judged.warnings), parts)


def assembled(title: str, head: Html, parts: Mapping[str, Html]) -> str:
    """Return a page: its head, links to its parts, and the parts by their names."""
    links = (tag("a", name, href=f"#{name.lower()}") for name in parts)
    bodies = (
        tag("section", tag("h2", name), content, id=name.lower())
        if name in _OPEN
        # a link to what is folded opens it
        else tag("details", tag("summary", name), tag("section", content, id=name.lower()))
        for name, content in parts.items()
    )
    template = (resources.files("roughsim.outputs") / "page.html").read_text(encoding="utf-8")
    body = joined(head, tag("nav", *links), *bodies)
    return Template(template).substitute(title=text(title), body=body)


def header(run: Run, warnings: list[str]) -> Html:
    """Return title, state and warnings."""
    failed = f"; {run.failed} did not converge and are left out of the means" if run.failed else ""
    what = "Flash temperature of a sliding rough contact, theory beside simulation."
    parts = [
        tag("h1", run.scene.title or run.folder.resolve().name),
        tag("p", f"{what} State when this was written: {state_line(run)}{failed}", css="state"),
    ]
    if run.damaged:
        parts += [
            tag("p", "Damaged files, left out; all else is shown:", css="warning"),
            bullets(*run.damaged.values()),
        ]
    if warnings:
        parts += [tag("p", "Warnings of this scene:", css="warning"), bullets(*warnings)]
    return joined(*parts)


def answer(comparison: Comparison) -> Html:
    """Return the flash temperature at the highest speed in each column, and the figure of the comparison."""
    rows = [row for row in comparison.rows if row.observable == "flash_temperature"]
    row = max(rows, key=lambda row: row.speed or 0.0)
    known = {name: x for name, x in row.theories.items() if name in THEORIES and isfinite(x)}
    values = {name: Number(x, "K") for name, x in known.items()}
    values |= {name: one.number() for name, one in row.columns.items()}
    boxes = []
    for name, value in values.items():
        label = tag("span", f"{name}: {meaning(name)}", css="label")
        boxes.append(
            tag("li", tag("span", digits(value), tag("small", " K"), css="value"), label, css=name)
        )
    tests = []
    for name, ratio in row.ratios.items():
        words = name.replace("_over_", " / ") + " of the same modes" * name.endswith("_over_theory")
        quotient = digits(ratio.number())
        tests.append(Html(f"{words} = {quotient}: {TESTS[name]}"))
    share = comparison.run.share_text()
    angles = (x for axis, x in row.about.items() if axis == "direction")
    at = f"{row.speed:g} m/s" + "".join(f", {degrees(angle):.4g}°" for angle in angles)
    caption = (
        "Roughness, stress correlation g(r), flash temperature T and its ratio to the theory, hot-spot width D and slope "
        "length d over the speed. Black: theory over the whole spectrum, dashed up to q_c if it differs; green by "
        "the calibrated stress spectrum. Bands are the total error, 95 %; of g(r) the statistical error, 95 %."
    )
    return joined(
        tag("p", f"Flash temperature ⟨Tσ⟩/⟨σ⟩ at {at}, with the heat share {share}:"),
        tag("ul", *boxes, css="answer"),
        bullets(*tests),
        picture(comparison.chart, ".svg", caption),
    )


def errors_section(run: Run) -> Html:
    """Return each mean at the highest speed with the parts of its error, and notes on the extrapolation."""
    if not run.independent:
        return tag("p", "There is no sound realization yet.", css="warning")
    words = "Means over all sound realizations, at the highest speed, with each source of error by itself:"
    sources = (f"{name}: {x}" for name, x in run.sources.items() if name != "scan" or run.scanned)
    parts = [tag("p", words), bullets(*sources)]
    fastest = int(np.argmax(run.scene.speeds))
    for column in run.numerics.columns:
        # the notes of the estimates, each once, after the names of its observables if not all have it
        observables_by_note: dict[str, list[str]] = {}
        for observable in run.observables:
            for note in run.estimate(observable, column).notes:
                if not note.startswith("speeds "):
                    observables_by_note.setdefault(note, []).append(observable)
        notes = (
            note if len(names) == len(run.observables) else f"{', '.join(names)}: {note}"
            for note, names in observables_by_note.items()
        )
        parts += [
            tag("h3", f"{column}: {meaning(column)}"),
            html_table(budget_table(run, column, [fastest])),
        ]
        parts.append(bullets(*notes, css="plain note"))
    return joined(*parts)


def figures_section(run: Run) -> Html:
    """Return the pictures of the first kept realization, and why others cannot be drawn."""
    if not run.independent:
        return tag("p", "There is no sound realization to draw yet.")
    parts: list[Html] = []
    folded: list[Html] = []
    reasons: dict[str, list[str]] = {}  # with the quantities that are not shown for it
    pictures = PICTURES | (_SLIDING_PICTURES if run.numerics.slide is not None else {})
    pictures |= _REACTION_PICTURES if run.scene.distribution else {}
    for quantity, (ending, caption) in pictures.items():
        note_work(f"drawing {quantity}")
        try:
            drawn = picture(partial(plot_run, run, quantity), ending, caption)
            (parts if quantity in _ALWAYS else folded).append(drawn)
        except (ValueError, OSError) as error:  # not kept, at rest, or damaged
            reasons.setdefault(str(error), []).append(quantity)
    lines = (
        f"Not shown: {', '.join(quantities)}. Reason: {reason}"
        for reason, quantities in reasons.items()
    )
    more = [tag("details", tag("summary", "More pictures"), *folded)] if folded else []
    return joined(*parts, *more, *(tag("p", line, css="warning") for line in lines))


def picture(draw: Callable[[Path], object], ending: str, caption: str) -> Html:
    """Return a figure that `draw` writes to a path, as an image inside the page."""
    image = Html(f'<img alt="{text(caption)}" src="{data_url(draw, ending)}">')
    return tag("figure", image, tag("figcaption", caption))


def _plan_section(run: Run) -> Html:
    """Return the choices of the plan with their reasons, or the numerics of a run without a plan."""
    if run.reasons:
        return html_table(plan_table(run.reasons))
    values = run.numerics.to_dict()
    values["levels"] = level_text(run.numerics.levels)
    rows = [[key.replace("_", " "), str(value)] for key, value in values.items()]
    why = "These numerics were given to the run without a plan, so there are no reasons to show."
    return joined(tag("p", why), html_table(Table([Column("numerics"), Column("value")], rows)))


def scene_section(scene: Scene, judged: Plausibility) -> Html:
    """Return the scene file, with long tables C(q) shortened, and derived quantities."""
    follows: list[list[Cell]] = [
        ["effective modulus E*", Number(scene.effective_modulus / 1e9), "GPa"],
        ["penetration hardness", Number(scene.penetration_hardness / 1e9), "GPa"],
        ["thermal diffusivity", diffusivity_text(scene), "mm²/s"],
    ]
    titles = [Column("derived quantity"), Column("", number=True), Column("")]
    toml = with_short_tables(scene.to_toml())
    return joined(html_table(Table(titles, follows)), html_table(judged.table()), tag("pre", toml))


def diffusivity_text(scene: Scene) -> str:
    """Return D of the moving body, mm²/s: one number, or its range over the speeds if κ depends on temperature."""
    values = prediction.conduction(scene).diffusivity * 1e6
    return " … ".join(
        dict.fromkeys(str(Number(float(value))) for value in (values.max(), values.min()))
    )


def _provenance_section(run: Run) -> Html:
    """Return seed, versions, residual and time of the members, the failures, and the command that repeats the run."""
    name = run.folder.resolve().name
    counts = [f"{count} of level {level}" for level, count in enumerate(run.counts) if count]
    files = f"{len(run.members)} of one realization and level each; counted: {', '.join(counts) or 'none yet'}"
    rows = [["run", name], ["seed", str(run.seed)], ["files", files], *_rows_of_members(run)]
    rows.append(["written", time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())])
    parts = [html_table(Table([Column(""), Column("")], rows))]
    failures = [
        f"level {member.level}, realization {member.index}: {member.failure}"
        for key, member in run.members.items()
        if member.failure and key not in run.members.lost
    ]
    if failures:
        parts += [tag("p", "Left out of all means:"), bullets(*failures[:_FEW_FAILURES])]
    again = "Saved as scene.toml, the scene above gives these numbers again, to the bit on one kind of CPU with the same"
    verb = "run" if run.drawn else "press"
    return joined(
        *parts, tag("p", f"{again} versions:"), tag("pre", f"roughsim {verb} scene.toml -o {name}")
    )


def _rows_of_members(run: Run) -> list[list[str]]:
    """Return time, largest residual and versions of the sound members; none before the first."""
    records = [member.provenance for member in run.members.values() if not member.failure]
    if not records:
        return []
    written = sorted(str(record.get("written", "")) for record in records)
    stages: Counter[str] = Counter()
    for record in records:
        stages.update(record.get("seconds", {}))
    cost = ", ".join(f"{stage} {clock(seconds)}" for stage, seconds in stages.items())
    worst = max(float(record.get("residual", np.nan)) for record in records)
    rows = [
        ["computed", f"{written[0]} to {written[-1]}"],
        ["time", cost],
        ["largest residual", f"{worst:.2g}"],
    ]
    texts = (
        ", ".join(f"{k} {v}" for k, v in record.get("versions", {}).items()) for record in records
    )
    return rows + [["versions", text] for text in dict.fromkeys(texts)]
