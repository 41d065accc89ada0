"""Arguments and options that the verbs share, opening of scenes and runs, and printing."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

import roughsim as rs
from roughsim.show.table import Table, table_text
from roughsim.show.text import columns_of_terminal, marked, note, say, tell, warn, wrapped

if TYPE_CHECKING:  # commands import late: the help loads none of these
    from roughsim.results.run import Run
    from roughsim.scene import Scene
    from roughsim.studies.study import Study

_NARROW, _LINES = 80, 24  # of a first screen, below a line on slow work
_MOST_REMARKS = 3  # of a first screen


def complete_scene(incomplete: str) -> list[str]:
    """Return the bundled scenes that a word may become, for completion in the shell."""
    from roughsim.scene import bundled_scenes

    return [name for name in bundled_scenes() if name.startswith(incomplete)]


def complete_form(incomplete: str) -> list[str]:
    """Return the bundled scenes and the blank form that a word may become, for completion in the shell."""
    return complete_scene(incomplete) + ["blank"] * "blank".startswith(incomplete)


SceneName = Annotated[
    str, Argument(metavar="SCENE", help="A file or a bundled scene.", autocompletion=complete_scene)
]
Set = Annotated[
    list[str] | None,
    Option(
        "--set",
        metavar="KEY=VALUE",
        help="Another value of a key, as sliding.speed=35m/s. May be repeated.",
    ),
]
TargetError = Annotated[
    str | None,
    Option("--target-error", metavar="X", help="Total 95 % error of T_flash to reach: 1% or 0.01."),
]
RunFolder = Annotated[Path, Argument(metavar="RUN", help="The folder of a run, or of a study.")]
Json = Annotated[bool, Option("--json", help="Print JSON (SI units) for programs.")]
Every = Annotated[
    bool, Option("--all", help="Print all values, reasons, assumptions and warnings.")
]
Chart = Annotated[Path | None, Option(metavar="FILE", help="Draw the figure: .png, .pdf or .svg.")]
Csv = Annotated[
    Path | None, Option(metavar="FILE", help="Write the numbers that are drawn, too: .csv.")
]
Output = Annotated[
    Path | None, Option("-o", "--output", metavar="FILE", help="Left out: a file beside RUN.")
]
Workers = Annotated[
    int | None,
    Option(metavar="N", min=1, help="Processes; left out: as many as fit for long runs."),
]


def changes_of(words: list[str] | None, options: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return the changes that were written as KEY=VALUE, and those by other options that are not None."""
    from roughsim.scene.changes import read_changes

    by_options = {key: value for key, value in (options or {}).items() if value is not None}
    return read_changes(words or []) | by_options


def open_scene(
    name: str, words: list[str] | None, options: dict[str, Any] | None = None
) -> "Scene":
    """Return a scene with the changes by words and options."""
    return rs.load_scene(name, changes_of(words, options))


def open_without_damaged(folder: Path) -> "Run | Study":
    """Open a study, or a run without its damaged files, which are named on the terminal."""
    from roughsim.outputs.opened import opened

    record = opened(folder, damaged="skip")
    if isinstance(record, rs.Run):
        for reason in record.damaged.values():
            tell(f"left out: {reason}")
    return record


def print_json(value: Any) -> None:
    """Print a value as JSON."""
    say(json.dumps(value, indent=1))


def print_parts(*parts: str | Table) -> None:
    """Print lines and tables, an empty line between tables."""
    width = columns_of_terminal()
    for before, part in zip((None, *parts), parts, strict=False):
        if isinstance(part, str):
            say("\n".join(wrapped(part, width)))
        else:
            say("\n" * isinstance(before, Table) + str(part))


def show_scene(
    short: Table,
    whole: Sequence[Table],
    warnings: Sequence[str],
    every: bool,
    screens: int = 1,
) -> None:
    """Print the first screen of a scene, one of several, or its whole tables and all of its warnings.

    `screens` first screens have 25 lines of 80 columns: a short table, the most serious warnings, and what --all adds.
    The table has its most important rows first; the last ones are left out where there is no room.
    """
    if every:
        print_parts(*whole)
        for line in warnings:
            warn(line)
        return
    width = columns_of_terminal(_NARROW)
    told = [
        fill(f"roughsim: {line}", width, subsequent_indent="  ", break_on_hyphens=False)
        for line in marked(warnings[:_MOST_REMARKS])
    ]
    room = _LINES // screens - 1 - sum(text.count("\n") + 1 for text in told)
    say(table_text(_first_rows(short, room, width), width))
    for text in told:
        tell(text)
    more = f"{sum(len(table.rows) for table in whole)} rows"
    if len(warnings) > len(told):
        more += f", and {len(warnings) - len(told)} more warnings"
    say(f"--all prints {more}, with reasons.")


def _first_rows(table: Table, room: int, width: int | None = None) -> Table:
    """Return a table without the last rows that lines of a width have no room for, but with a row."""
    rows = list(table.rows)
    while len(rows) > 1 and table_text(replace(table, rows=rows), width).count("\n") >= room:
        del rows[-1]
    return replace(table, rows=rows)


def print_comparison(compared: "rs.Comparison") -> None:
    """Print the first screen of a comparison: T_flash, as much as fits of what the scene asks for, and what is left."""
    summary, *asked = compared.first_screen()
    room = _LINES - 3 - str(summary).count("\n")  # with an empty line, and the last one
    short = [_first_rows(table, room) for table in asked]
    left = sum(len(a.rows) - len(b.rows) for a, b in zip(asked, short, strict=True))
    more = f"{left} more rows, " * (left > 0)
    print_parts(
        summary, *short, f"compare --all prints {more}all observables, and the theory's error."
    )


def check_figure(chart: Path | None, csv: Path | None = None) -> None:
    """Raise ValueError, before anything is computed, for the name of a file that no figure is written to."""
    if chart is None and csv is None:
        return  # without the slow import
    from roughsim.charts.style import Look, check_ending

    Look(csv=csv)
    if chart is not None:
        check_ending(chart)


def draw_figure(draw: Callable[..., None], chart: Path | None, csv: Path | None) -> None:
    """Draw a figure, and write its numbers; either may be left out."""
    if chart is None and csv is None:
        return
    if chart is not None:
        note(f"drawing {chart}")
    draw(chart, csv=csv)
    names = {"picture": chart, "numbers": csv}
    tell("\n".join(f"{name}: {path}" for name, path in names.items() if path is not None))
