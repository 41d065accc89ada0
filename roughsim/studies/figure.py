"""The figure of a study: choice of the results, and their curves for the chart, the report and the page."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim.results.columns import observables_of
from roughsim.studies.results import SPEED, StudyResults
from roughsim.studies.tables import key_text, value_text, words_of
from roughsim.table import AXES, Estimate

if TYPE_CHECKING:  # matplotlib is slow to import
    from roughsim.charts.style import Look

NONE = "none"  # in place of an axis
_FEWEST_OF_A_MAP = 3  # values of either key


@dataclass(frozen=True)
class Choice:
    """Results of a figure: an observable over `x`, a curve for each value of `family`, all else fixed.

    `x` and `family` are names of varied keys in the table, or `SPEED`, or "energy" of a reaction, or "temperature" of
    the share of hot heat; `family` may be `NONE`. `fixed` has the values of the others by their names. Left out, the
    speed is the highest of each point, and the energy or temperature the first one.
    """

    observable: str
    x: str
    family: str
    fixed: Mapping[str, Any] = field(default_factory=dict)


def usual_choice(study: StudyResults, observable: str, over: str | None = None) -> Choice:
    """Return the first number, and a curve for each value of the second one, or for each speed or word.

    A reaction has a curve for each energy, the share of hot heat for each temperature. `over` names another axis:
    `SPEED`, a varied number, in the table or in full, or the energy or temperature. ValueError if it is none.
    """
    numeric = [study.keys[key] for key in study.numeric_keys]
    first = {study.keys[key]: value for key, value in study.points[0].values.items()}
    words = [name for name in first if name not in numeric]
    own = _own_axes(study, observable)
    over_speed = not numeric or any(len(run.scene.speeds) > 1 for _, run in study.results)
    candidates = [*numeric[:1], *own, *numeric[1:], *[SPEED] * over_speed, *words, NONE]
    if over is not None:
        over = study.keys.get(over, over)
        axes = [name for name in candidates if name in (SPEED, *own, *numeric)]
        if over not in axes:
            raise ValueError(
                f"over = {over!r} is no axis of {study.folder}; choose one of {', '.join(axes)}"
            )
        candidates = [over, *(name for name in candidates if name != over)]
    return Choice(observable, candidates[0], candidates[1], first)


def _own_axes(study: StudyResults, observable: str) -> set[str]:
    """Return the axes of an observable beside column and speed: those with several labels at some point."""
    own = set()
    for point, run in study.results:
        names = [observable] if observable in observables_of(run) else []
        for one in study.results_at(point, run, names).values():
            own |= {dim for dim, labels in one.coords.items() if len(labels) > 1}
    return own - {"column", SPEED}


def curves_of(study: StudyResults, choice: Choice) -> dict[str, Estimate]:
    """Return the observable of a choice at each value of its family, by the value as text, numbers ascending.

    Without a family it is one; there is none if the observable has no axis `x`, or no value.
    """
    axes = choice.x, choice.family
    fixed = {name: value for name, value in choice.fixed.items() if name not in axes}
    whole = study.view(choice.observable, axes, fixed)
    if whole is None or choice.x not in whole.dims:
        return {}
    values = [*study.values_of(choice.family).values()]
    if not values:
        if choice.family not in whole.dims:
            return {"": whole}
        values = whole.known(choice.family).tolist()
    if all(isinstance(value, (int, float)) for value in values):
        values.sort()
    curves = {}
    for value in values:
        free = {choice.x} - {choice.family}
        one = study.view(choice.observable, free, fixed | {choice.family: value})
        if one is not None:
            curves[value_text(study.full(choice.family), value)] = one
    return curves


def draw_study(study: StudyResults, choice: Choice, path: Path, look: "Look | None" = None) -> None:
    """Draw a choice of the results of a study; ValueError for an unknown observable or without results."""
    from roughsim.charts.study import Along, study_chart
    from roughsim.charts.style import USUAL  # matplotlib is slow to import

    curves = curves_of(study, choice)
    if not curves:
        known = dict.fromkeys(name for _, run in study.results for name in observables_of(run))
        if known and choice.observable not in known:
            raise ValueError(
                f"observable = {choice.observable!r} is unknown; choose one of {', '.join(known)}"
            )
        raise ValueError(
            f"there is nothing to draw: no point has {choice.observable} with these values yet"
        )
    family = study.full(choice.family)
    study_chart(
        path,
        curves,
        Along(choice.x, *words_of(study.full(choice.x))),
        study.column,
        legend="" if choice.family == NONE else words_of(family)[0],
        title=_title(study, choice),
        subtitle=_subtitle(choice, curves),
        y=Along(choice.family, *words_of(family)) if _over_two(study, choice, curves) else None,
        look=look or USUAL,
    )


def _over_two(study: StudyResults, choice: Choice, curves: Mapping[str, Estimate]) -> bool:
    """Whether the curves make a map: over two varied numbers with enough values."""
    numeric = [study.keys[key] for key in study.numeric_keys]
    return all(
        name in numeric and len(_labels(curves, name)) >= _FEWEST_OF_A_MAP
        for name in (choice.x, choice.family)
    )


def _labels(curves: Mapping[str, Estimate], dim: str) -> set[Any]:
    """Return the labels of an axis at which the curves have values."""
    found = (one.known(dim).tolist() for one in curves.values() if dim in one.dims)
    return {label for labels in found for label in labels}


def _title(study: StudyResults, choice: Choice) -> str:
    """Return the name of the study, the number of finished points, and the fixed values.

    The title of the base scene may name a value that the study varies.
    """
    title = f"{study.folder.resolve().name}: {study.finished} of {len(study.points)} points"
    for key, name in study.keys.items():
        if name not in (choice.x, choice.family):
            title += f"; {key_text(key, choice.fixed[name])}"
    return title


def _subtitle(choice: Choice, curves: Mapping[str, Estimate]) -> str:
    """Return speed, energy and temperature that all curves have and that are neither axis nor differ between curves."""
    parts = []
    for name in reversed(AXES):
        labels = _labels(curves, name)
        unit = words_of(name)[0].removeprefix(name).strip(", ")
        if unit and name not in (choice.x, choice.family) and len(labels) == 1:
            parts.append(f"at {value_text(name, labels.pop())} {unit}")
    return ", ".join(parts)
