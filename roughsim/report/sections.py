"""The sections of a report, from what a run says of itself."""

from __future__ import annotations

import re
import time
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from roughsim import prediction
from roughsim.comparison.compare import compare
from roughsim.comparison.tables import comparison_table
from roughsim.ensemble.status import clock, ended, reached, status_dict
from roughsim.estimate.errors import SOURCES
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.planning.limits import judge
from roughsim.report.markup import Html, grouped_table, joined, number, plus_minus, table, tag
from roughsim.report.pictures import picture
from roughsim.show.units import shown
from roughsim.store.claims import writer

if TYPE_CHECKING:
    from roughsim.comparison.compare import Comparison, Row
    from roughsim.estimate.errors import Estimate
    from roughsim.results.run import Run
    from roughsim.scene import Scene

COLUMNS = {
    "theory": "theory over the whole spectrum",
    "smoothed": "smoothed: elastic contact on the smoothed spectrum",
    "capped": "capped: contact of the surface, p\N{NO-BREAK SPACE}≤\N{NO-BREAK SPACE}hardness",
    "elastic": "elastic contact of the surface",
}
_FEW_ROWS = 6  # of a table C(q) in the text of the scene


def header(run: Run) -> Html:
    """Return the title and where the run stands."""
    counted = f"{run.realizations} realizations"
    failed = f", {run.failed} failed and left out of all means" if run.failed else ""
    parts = [
        tag("h1", run.scene.title or run.folder.resolve().name),
        tag(
            "p",
            f"Flash temperature of a sliding rough contact, theory beside simulation. {counted}{failed}; {_state(run)}",
            css="state",
        ),
    ]
    if run.damaged:
        parts.append(tag("p", "Damaged files, left out; all else is shown:", css="warning"))
        parts.append(tag("ul", *(tag("li", reason) for reason in run.damaged.values()), css="plain"))
    warnings = judge(run.scene, run.numerics).warnings
    if warnings:
        parts.append(tag("p", "Where this scene leaves what the model means:", css="warning"))
        parts.append(tag("ul", *(tag("li", line) for line in warnings), css="plain"))
    return joined(*parts)


def _state(run: Run) -> str:
    if run.target_met or run.realizations >= run.max_realizations:
        return f"finished, {ended(run)}{reached(run)}"
    if writer(run.folder):
        left = status_dict(run)["seconds_left"]
        return "being computed while this was written" + (f", {clock(left)} left" if left is not None else "")
    return f"not finished{reached(run)}"


def compared(run: Run) -> Comparison | Html:
    """Return the comparison of a run, or the sentence that says why there is none yet."""
    try:
        return compare(run)
    except ValueError as error:  # fewer than two sound realizations
        return tag("p", f"There is nothing to compare yet: {error}", css="warning")


def answer(found: Comparison | Html) -> Html:
    """Return the flash temperature at the highest speed in each column, and the figure of the comparison."""
    if isinstance(found, Html):
        return found
    row = max((r for r in found.rows if r.observable == "flash_temperature"), key=lambda r: r.speed or 0.0)
    boxes = [_box("theory", number(row.theory_full_spectrum))]
    boxes += [_box(name, plus_minus(cell.mean, cell.total_error, cell.unknown)) for name, cell in row.columns.items()]
    told = [tag("li", _ratio_words(name, row)) for name in row.ratios]
    caption = (
        "Roughness, stress correlation g(r), flash temperature T, hot-spot width D and slope length d over the sliding "
        "speed. The black line is the theory over the whole spectrum. Bands are the total error, 95 %; of g(r) the "
        "statistical error, 95 %."
    )
    return joined(
        tag("p", f"Flash temperature ⟨Tσ⟩/⟨σ⟩ at {row.speed:g} m/s, with the heat share {_share(found.run)}:"),
        tag("ul", *boxes, css="answer"),
        tag("ul", *told, css="plain"),
        picture(found.chart, ".svg", caption),
    )


def _box(column: str, value: Html) -> Html:
    label = tag("span", COLUMNS[column], css="label")
    return tag("li", tag("span", value, tag("small", " K"), css="value"), label, css=column)


def _ratio_words(name: str, row: Row) -> Html:
    above, _, below = name.partition("_over_")
    found = row.ratios[name]
    tested = {
        "smoothed_over_theory": "tests the weight W(q) of the theory",
        "capped_over_smoothed": "tests the plastic smoothing, Eq. (27); γ drops out",
        "elastic_over_theory": "tests the weight W(q) of the theory",
    }
    value = plus_minus(found.value, found.total_error, found.unknown)
    modes = " of the same modes" if below == "theory" else ""
    return Html(f"{above} / {below}{modes} = {value}: {tested.get(name, '')}")


def _share(run: Run) -> str:
    low, high = run.heat_partition.min(), run.heat_partition.max()
    return f"{high:.3g}" if high - low < 1e-12 else f"{low:.3g} to {high:.3g}, by speed"


def comparison(found: Comparison | Html) -> Html:
    """Return the whole table of theory beside simulation."""
    if isinstance(found, Html):
        return found
    first = found.rows[0]
    titles = ["m/s", "theory", *first.columns, *(_heading(name) for name in first.ratios), ""]
    groups = {name: [row for row in found.rows if row.observable == name] for name in OBSERVABLES}
    rows = {_name(name): [_row(row) for row in members] for name, members in groups.items() if members}
    return joined(grouped_table(titles, rows), *(tag("p", note, css="note") for note in comparison_table(found).notes))


def _heading(ratio: str) -> str:
    return ratio.replace("_over_", " / ") + (", same modes" if ratio.endswith("_over_theory") else "")


def _name(observable: str) -> str:
    unit = shown(OBSERVABLES[observable].unit)[0]
    return observable.replace("_", " ") + (f", {unit}" if unit else "")


def _row(row: Row) -> list[object]:
    factor = shown(row.unit)[1]
    cells: list[object] = ["" if row.speed is None else f"{row.speed:g}", number(row.theory_full_spectrum * factor)]
    cells += [plus_minus(cell.mean * factor, cell.total_error * factor, cell.unknown) for cell in row.columns.values()]
    cells += [plus_minus(ratio.value, ratio.total_error, ratio.unknown) for ratio in row.ratios.values()]
    return [*cells, row.note]


def budget(run: Run) -> Html:
    """Return each reported mean with the parts of its error, and what was done about the cut-off."""
    if not run.sound(run.realizations):
        return tag("p", "There is no sound realization yet.", css="warning")
    told = "; ".join(f"{source}: {words}" for source, words in SOURCES.items() if source != "scan" or run.scene.scanned)
    lead = "Means over all sound realizations, at the highest speed, with each source of error by itself."
    note = f"± total error, 95 %; ≥ where a dash stands for a part that no level tells. {told[0].upper()}{told[1:]}."
    parts = [tag("p", lead), tag("p", note, css="note")]
    for column in run.numerics.columns:
        found = [run.estimate(name, column) for name in OBSERVABLES]
        parts += [tag("h3", COLUMNS[column]), _budget_table(run, found)]
        parts.append(_notes(found))
    return joined(*parts)


def _notes(found: list[Estimate]) -> Html:
    """What the estimates say beyond numbers, each once, with the observables that it is said of, unless of all."""
    said: dict[str, list[str]] = {}
    for one in found:
        for note in one.notes:
            if not note.startswith("speeds "):
                said.setdefault(note, []).append(one.observable.replace("_", " "))
    told = (note if len(names) == len(found) else f"{', '.join(names)}: {note}" for note, names in said.items())
    return tag("ul", *(tag("li", line) for line in told), css="plain note")


def _budget_table(run: Run, found: list[Estimate]) -> Html:
    sources = list(found[0].budget)
    titles = ["observable", "m/s", "value ± total", *sources, "finest level − value"]
    rows: list[list[object]] = []
    for one in found:
        factor = shown(one.unit)[1]
        k = int(np.argmax(run.scene.speeds)) if OBSERVABLES[one.observable].per_speed else 0
        speed = f"{run.scene.speeds[k]:g}" if OBSERVABLES[one.observable].per_speed else ""
        parts = [*(one.budget[source][k] for source in sources), one.bias[k]]
        cells = [number(float(part) * factor, 2) for part in parts]
        value = plus_minus(float(one.mean[k]) * factor, float(one.total_error[k]) * factor, one.unknown_at(k))
        rows.append([_name(one.observable), speed, value, *cells])
    return table(titles, rows, numbers=set(range(1, len(titles))))


def plan_of(run: Run) -> Html:
    """Return the choices of the plan with their reasons, or the numerics where they were given without any."""
    if run.reasons:
        reasons: list[list[object]] = [list(reason) for reason in run.reasons]
        return table(["choice", "value", "because"], reasons, numbers=set())
    given = "These numerics were given to the run without a plan, so there are no reasons to show."
    rows: list[list[object]] = [[key.replace("_", " "), _shown(v)] for key, v in run.numerics.to_dict().items()]
    return joined(tag("p", given), table(["numerics", "value"], rows, numbers=set()))


def _shown(value: object) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "; ".join(
            f"{a['column']} {a['shape'][0]} × {a['shape'][1]} to q_c = {a['q_max']:.3g} rad/m" for a in value
        )
    return str(value)


def scene_of(run: Run) -> Html:
    """Return the scene file, long tables C(q) cut short, and what follows from it."""
    scene = run.scene
    derived: list[list[object]] = [
        ["effective modulus E*", number(scene.effective_modulus / 1e9), "GPa"],
        ["penetration hardness", number(scene.penetration_hardness / 1e9), "GPa"],
        ["thermal diffusivity", _diffusivity(scene), "mm²/s"],
    ]
    shown = re.sub(r"((?:^\[[^\[\]\n]*\],\n)+)", _shortened, scene.to_toml(), flags=re.MULTILINE)
    known = judge(scene, run.numerics).facts
    facts: list[list[object]] = [list(row) for row in known.table().rows] if known else []
    return joined(
        table(["what follows from it", "", ""], derived, numbers={1}),
        table(["to judge it by", "", ""], facts, numbers=set()),
        tag("pre", shown),
    )


def _diffusivity(scene: Scene) -> str:
    """One number, or the range over the speeds where κ depends on temperature."""
    values = prediction.conduction(scene).diffusivity * 1e6
    return " … ".join(dict.fromkeys(number(float(value)) for value in (values.max(), values.min())))


def _shortened(match: re.Match[str]) -> str:
    rows = match[1].splitlines(keepends=True)
    if len(rows) <= _FEW_ROWS:
        return match[1]
    half = _FEW_ROWS // 2
    return "".join([*rows[:half], f"# … {len(rows) - 2 * half} rows more in scene.toml of the run …\n", *rows[-half:]])


def origin(run: Run) -> Html:
    """Return what is needed to have the same numbers again, and what they cost."""
    sound = [member for member in run.members.values() if not member.failure]
    name = run.folder.resolve().name
    rows: list[list[object]] = [
        ["run", name],
        ["seed", str(run.seed)],
        ["files", f"{len(run.members)} of one realization and level each"],
    ]
    if sound:
        written = sorted(str(member.provenance.get("written", "")) for member in sound)
        stages: Counter[str] = Counter()
        for member in sound:
            stages.update(member.provenance.get("seconds", {}))
        cost = ", ".join(f"{stage} {clock(seconds)}" for stage, seconds in stages.items())
        worst = max(float(member.provenance.get("residual", np.nan)) for member in sound)
        rows += [["computed", f"{written[0]} to {written[-1]}"], ["time", cost], ["largest residual", f"{worst:.2g}"]]
        versions = {
            str(sorted(m.provenance.get("versions", {}).items())): m.provenance.get("versions", {}) for m in sound
        }
        rows += [["versions", ", ".join(f"{k} {v}" for k, v in found.items())] for found in versions.values()]
    rows.append(["written", time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())])
    again = (
        "Saved as scene.toml, the scene above gives these numbers again, to the bit on one kind of CPU with the same "
        "versions:"
    )
    command = f"roughsim run scene.toml -o {name}"
    failures = [
        f"level {m.level}, realization {m.index}: {m.failure}"
        for k, m in run.members.items()
        if m.failure and k not in run.damaged
    ]
    lost = (
        [tag("p", "Left out of all means:"), tag("ul", *(tag("li", f) for f in failures[:20]), css="plain")]
        if failures
        else []
    )
    return joined(table(["", ""], rows, numbers=set()), *lost, tag("p", again), tag("pre", command))
