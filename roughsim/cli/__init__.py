"""The command line: each verb is one public function with its imports inside, so that help is fast."""

import os
import sys
from typing import Annotated

from typer import Exit, Option, Typer

import roughsim as rs
from roughsim.cli.runs import compare, explore, export, plot, report, status
from roughsim.cli.scenes import bench, demo, doctor, new, plan, press, run, study, theory
from roughsim.show.text import (
    errors_in_one_line,
    print_in_any_language,
    say,
    show_notes,
    show_warnings_once,
)

# as help lists them
_VERBS = (
    demo,
    new,
    theory,
    plan,
    run,
    press,
    study,
    status,
    compare,
    plot,
    explore,
    report,
    export,
    bench,
    doctor,
)

app = Typer(
    name="roughsim",
    rich_markup_mode=None,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(asked: bool) -> None:
    """Print the version and end, if asked."""
    if asked:
        say(f"roughsim {rs.__version__}")
        raise Exit


@app.callback()
def options(
    version: Annotated[
        bool, Option("--version", callback=_print_version, is_eager=True, help="The version.")
    ] = False,
) -> None:
    """Flash temperatures of rough sliding contacts: Monte Carlo simulation and analytic theory."""


for verb in _VERBS:
    app.command()(verb)


def main(words: list[str] | None = None) -> None:
    """Run the command line on `words`, or on the process's own; an error is one line and a non-zero exit code."""
    # which pydantic looks for in all packages, a sixteenth of a start
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
    # a run sets the threads of linear algebra itself; starting them takes a fifth of the CPU time of other commands
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    show_warnings_once()
    show_notes()
    print_in_any_language()
    with errors_in_one_line(" ".join(sys.argv[1:] if words is None else words)):
        code = app(words, standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    raise SystemExit(code or 0)
