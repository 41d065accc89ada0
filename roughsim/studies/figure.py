"""The figure of a study: choice of the results, and their curves for the chart, the report and the page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim.estimate.asked import ABOUT
from roughsim.observables.catalogue import UNITS
from roughsim.studies.results import StudyResults
from roughsim.studies.tables import value_text, words_of

if TYPE_CHECKING:  # matplotlib is slow to import
    from roughsim.charts.style import Look

SPEED, NONE = "speed", "none"  # in place of a varied key
_ABOUT = ("energy", "temperature")  # of rows of a reaction, and of the share of hot heat
_FEWEST_OF_A_MAP = 3  # values of either key
_Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Choice:
    """Results of a figure: an observable over `x`, a curve for each value of `family`, all else fixed.

    `x` and `family` are names of varied keys in the table, or `SPEED`, or "energy" of a reaction, or "temperature" of
    the share of hot heat; `family` may be `NONE`. `fixed` has the values of the other keys by their names. `speed`,
    m/s: None is the highest speed of each point. Of several energies or temperatures the first of each point.
    """

    observable: str
    x: str
    family: str
    fixed: Mapping[str, Any] = field(default_factory=dict)
    speed: float | None = None


def usual_choice(study: StudyResults, observable: str, over: str | None = None) -> Choice:
    """Return the first number, and a curve for each value of the second one, or for each speed or word.

    A reaction has a curve for each energy, the share of hot heat for each temperature. `over` names another axis:
    `SPEED`, a varied number, in the table or in full, or the energy or temperature. ValueError if it is none.
    """
    numeric = [study.keys[key] for key in study.numeric_keys]
    first = {study.keys[key]: value for key, value in study.points[0].values.items()}
    words = [name for name in first if name not in numeric]
    several = any(len(run.scene.speeds) > 1 for _, run in study.results)
    about = _several_about(study, observable)
    candidates = [
        *numeric[:1],
        *about,
        *numeric[1:],
        *([SPEED] if several or not numeric else []),
        *words,
        NONE,
    ]
    if over is not None:
        over = study.keys.get(over, over)
        axes = [name for name in candidates if name in (SPEED, *about, *numeric)]
        if over not in axes:
            raise ValueError(
                f"over = {over!r} is no axis of {study.folder}; choose one of {', '.join(axes)}"
            )
        candidates = [over, *(name for name in candidates if name != over)]
    return Choice(observable, candidates[0], candidates[1], first)


def _several_about(study: StudyResults, observable: str) -> list[str]:
    """Return the energy of a reaction or the temperature of a share of heat, if points have several; else nothing."""
    about = ABOUT.get(observable)
    scenes = [run.scene for _, run in study.results]
    counts = {
        "energy": [len(scene.reaction.activation_energy) for scene in scenes if scene.reaction],
        "temperature": [
            len(scene.observables.heat_above or ()) for scene in scenes if scene.observables
        ],
    }
    return [about] if about is not None and max(counts[about], default=0) > 1 else []


def chosen_rows(rows: _Rows, choice: Choice) -> list[Mapping[str, Any]]:
    """Return the rows of a choice."""
    fixed: dict[str, Any] = {"observable": choice.observable}
    fixed |= {
        name: value for name, value in choice.fixed.items() if name not in (choice.x, choice.family)
    }
    chosen = [row for row in rows if all(row[name] == value for name, value in fixed.items())]
    for name in _ABOUT:
        if choice.x == name:
            chosen = [row for row in chosen if name in row]
        elif choice.family != name:
            firsts: dict[str, float | None] = {}
            chosen = [
                row
                for row in chosen
                if row.get(name) == firsts.setdefault(row["point"], row.get(name))
            ]
    if choice.x == SPEED:
        return [row for row in chosen if row["speed"] is not None]
    if choice.family == SPEED:
        return chosen
    speeds = (
        _highest_speeds(chosen)
        if choice.speed is None
        else {row["point"]: choice.speed for row in chosen}
    )
    return [row for row in chosen if row["speed"] in (None, speeds.get(row["point"]))]


def _highest_speeds(rows: _Rows) -> dict[str, float]:
    """Return the highest speed of each point, m/s."""
    highest: dict[str, float] = {}
    for row in rows:
        if row["speed"] is not None:
            highest[row["point"]] = max(row["speed"], highest.get(row["point"], 0.0))
    return highest


def draw_study(
    study: StudyResults, rows: _Rows, choice: Choice, path: Path, look: "Look | None" = None
) -> None:
    """Draw a choice of the rows of a study; ValueError for an unknown observable or without results."""
    from roughsim.charts.study import Along, study_chart
    from roughsim.charts.style import USUAL  # matplotlib is slow to import

    if choice.observable not in UNITS:
        raise ValueError(
            f"observable = {choice.observable!r} is unknown; choose one of {', '.join(UNITS)}"
        )
    chosen = chosen_rows(rows, choice)
    if not chosen:
        raise ValueError(
            f"there is nothing to draw: no point has {choice.observable} with these values yet"
        )
    key_of = {name: name for name in _ABOUT} | {SPEED: "sliding.speed"}
    key_of |= {name: key for key, name in study.keys.items()}
    study_chart(
        path,
        _curves(chosen, choice.family, key_of),
        Along(choice.x, *words_of(key_of[choice.x])),
        study.column,
        choice.observable,
        legend="" if choice.family == NONE else words_of(key_of[choice.family])[0],
        title=_title(study, choice, key_of),
        subtitle=_subtitle(chosen, choice),
        y=Along(choice.family, *words_of(key_of[choice.family]))
        if _over_two(study, chosen, choice)
        else None,
        look=look or USUAL,
    )


def _over_two(study: StudyResults, rows: _Rows, choice: Choice) -> bool:
    """Whether the rows make a map: over two varied numbers with enough values."""
    names = choice.x, choice.family
    numeric = [study.keys[key] for key in study.numeric_keys]
    return all(
        name in numeric and len({row[name] for row in rows}) >= _FEWEST_OF_A_MAP for name in names
    )


def _title(study: StudyResults, choice: Choice, key_of: Mapping[str, str]) -> str:
    """Return the name of the study, the number of finished points, and the fixed values.

    The title of the base scene may name a value that the study varies.
    """
    title = f"{study.folder.resolve().name}: {study.finished} of {len(study.points)} points"
    for name, value in choice.fixed.items():
        if name not in (choice.x, choice.family):
            words, _, unit = words_of(key_of[name])[0].partition(", ")
            title += f"; {words} {value_text(key_of[name], value)} {unit}".rstrip()
    return title


def _subtitle(rows: _Rows, choice: Choice) -> str:
    """Return speed, energy and temperature that all rows have and that are neither axis nor differ between curves."""
    parts = []
    for name, unit in ((SPEED, "m/s"), ("energy", "eV"), ("temperature", "K")):
        values = {row.get(name) for row in rows}
        if name not in (choice.x, choice.family) and len(values) == 1 and None not in values:
            parts.append(f"at {values.pop():g} {unit}")
    return ", ".join(parts)


def _curves(
    rows: _Rows, family: str, key_of: Mapping[str, str]
) -> dict[str, list[Mapping[str, Any]]]:
    """Return the rows of each curve by its label, numbers ascending."""
    if family == NONE:
        return {"": list(rows)}
    values = list(dict.fromkeys(row.get(family) for row in rows))
    if all(isinstance(value, (int, float)) for value in values):
        values.sort()
    curves = {}
    for value in values:
        label = "" if value is None else value_text(key_of[family], value)
        curves[label] = [row for row in rows if row.get(family) == value]
    return curves
