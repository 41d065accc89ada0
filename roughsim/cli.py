"""The command line: each verb is one public function, which imports what it needs, so that help comes at once."""

import json
import sys
import time
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Exit, Option, Typer

import roughsim as rs
from roughsim.show import text
from roughsim.show.text import (
    errors_in_one_line,
    fail,
    print_in_any_language,
    say,
    show_warnings_once,
    tell,
    warn,
)

app = Typer(
    name="roughsim",
    rich_markup_mode=None,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def complete_scene(incomplete: str) -> list[str]:
    """Return the bundled scenes that a word may become, for completion in the shell."""
    from roughsim.scene import bundled_scenes

    return [name for name in bundled_scenes() if name.startswith(incomplete)]


def complete_form(incomplete: str) -> list[str]:
    """Return the bundled scenes and the blank form that a word may become, for completion in the shell."""
    return [*complete_scene(incomplete), *(name for name in ("blank",) if name.startswith(incomplete))]


def print_version(asked: bool) -> None:
    """Print the version and end, if asked."""
    if asked:
        say(f"roughsim {rs.__version__}")
        raise Exit


SceneName = Annotated[str, Argument(metavar="SCENE", help="A file or a bundled scene.", autocompletion=complete_scene)]
RunFolder = Annotated[Path, Argument(metavar="RUN", help="The folder of a run.")]
Json = Annotated[bool, Option("--json", help="Print JSON (SI units) for programs.")]
Chart = Annotated[Path | None, Option(metavar="FILE", help="Draw the figure: .png, .pdf or .svg.")]
Output = Annotated[Path | None, Option("-o", "--output", metavar="FILE", help="Left out: a file beside RUN.")]
Workers = Annotated[int | None, Option(metavar="N", min=1, help="Processes; all cores if left out.")]


@app.callback()
def options(
    version: Annotated[bool, Option("--version", callback=print_version, is_eager=True, help="The version.")] = False,
) -> None:
    """Flash temperatures of rough sliding contacts: Monte Carlo simulation beside the analytic theory."""


@app.command()
def demo(
    output: Annotated[Path, Option("-o", "--output", metavar="RUN", help="Folder of the run.")] = Path("roughsim-demo"),
    workers: Workers = None,
) -> None:
    """Run a small scene, compare it with theory, and draw the picture. It takes less than a minute."""
    run("demo", output, workers=workers)
    compare(output, chart=output / "comparison.png")


@app.command()
def new(
    name: Annotated[
        str | None, Argument(metavar="NAME", help="Left out: list all.", autocompletion=complete_form)
    ] = None,
) -> None:
    """List the bundled scenes, or print one to start your own from. `blank` is a form with every key.

    For example: roughsim new demo > my.toml
    """
    from roughsim.scene import BLANK, bundled_scenes, scene_text

    say("\n".join((*bundled_scenes(), BLANK)) if name is None else scene_text(name).rstrip("\n"))


@app.command()
def theory(
    scene: SceneName,
    as_json: Json = False,
    trust: Annotated[bool, Option("--trust", help="Say how far the theory is off for this scene.")] = False,
) -> None:
    """Print what the analytic theory expects of a scene."""
    from roughsim.comparison.tables import theory_dict, theory_table, trust_table
    from roughsim.comparison.trust import trust as look_up
    from roughsim.planning.limits import judge

    loaded = rs.load_scene(scene)
    reliability, judged = look_up(loaded) if trust else None, judge(loaded)
    if as_json:
        print_json(theory_dict(loaded) | judged.to_dict() | ({"trust": reliability.to_dict()} if reliability else {}))
    else:
        print_parts(theory_table(loaded), *([trust_table(reliability)] if reliability else []), *judged.tables())
        for line in judged.warnings:
            warn(line)


@app.command()
def plan(
    scene: SceneName,
    target_error: Annotated[float | None, Option(metavar="X", help="Error of T_flash to reach: 0.01 is 1 %.")] = None,
    as_json: Json = False,
) -> None:
    """Show how a scene would be computed, and why so."""
    from roughsim.planning.limits import judge
    from roughsim.planning.plan import plan_table

    loaded = rs.load_scene(scene)
    numerics = rs.plan(loaded, target_error)
    judged = judge(loaded, numerics)
    if as_json:
        reasons = [reason._asdict() for reason in numerics.reasons]
        print_json(numerics.to_dict() | {"reasons": reasons} | judged.to_dict())
    else:
        print_parts(plan_table(numerics.reasons), *judged.tables())
        for line in judged.warnings:
            warn(line)


@app.command()
def run(
    scene: SceneName,
    output: Annotated[Path, Option("-o", "--output", metavar="RUN", help="Folder of the run, new or begun.")],
    until: Annotated[list[str] | None, Option(metavar="NAME=X", help="Stop at this 95 % error: 1% or 0.01.")] = None,
    most: Annotated[int | None, Option("--max", metavar="N", min=1, help="Stop after N realizations.")] = None,
    workers: Workers = None,
    threads: Annotated[int | None, Option(metavar="N", min=1, help="Threads of each process.")] = None,
    keep_fields: Annotated[int | None, Option(metavar="K", min=0, help="Store fields of the first K members.")] = None,
) -> None:
    """Compute realizations of a scene. The same command goes on where it was stopped.

    For example: roughsim run demo -o runs/demo --until flash_temperature=1%
    """
    began = time.monotonic()
    from dataclasses import replace

    from roughsim.ensemble.progress import run_shown

    loaded = rs.load_scene(scene)
    changes: dict[str, Any] = {"threads": threads, "keep_fields": keep_fields}
    changes = {key: value for key, value in changes.items() if value is not None}
    loaded = replace(loaded, numerics=replace(loaded.numerics, **changes))
    try:
        pairs = [word.partition("=") for word in until or ()]
        targets = {name.strip(): value for name, _, value in pairs} or None
        result = run_shown(loaded, output, workers, began=began, until=targets, max_realizations=most)
    except KeyboardInterrupt:  # caught here: typer would end without a word
        fail("stopped; what was computed is stored, and the same command goes on from there", 130)
    if result.failed > 0.01 * result.realizations:
        raise Exit(1)


@app.command()
def status(run: RunFolder, as_json: Json = False) -> None:
    """Show how far a run is: means and errors, failures, time left. The run may still be going on."""
    from roughsim.ensemble.status import status_dict, status_lines

    opened = open_without_damaged(run)
    if as_json:
        print_json(status_dict(opened))
    else:
        print_parts(*status_lines(opened))


@app.command()
def compare(run: RunFolder, chart: Chart = None, as_json: Json = False) -> None:
    """Compare a run with the theory, in a table of values and ratios."""
    from roughsim.comparison.tables import comparison_table, trust_table
    from roughsim.comparison.trust import trust

    opened = rs.open_run(run)
    comparison = rs.compare(opened)
    if as_json:
        print_json(comparison.to_dict())
    else:
        print_parts(comparison_table(comparison), trust_table(trust(opened.scene)))
    if chart is not None:
        comparison.chart(chart)
        tell(f"picture: {chart}")


@app.command()
def plot(
    run: RunFolder,
    quantity: Annotated[str, Argument(metavar="QUANTITY", help="A map or a curve, see above.")],
    output: Output = None,
    realization: Annotated[int | None, Option("-r", metavar="K", min=0, help="A realization with kept fields.")] = None,
    speed: Annotated[float | None, Option(metavar="V", help="In m/s; left out: the scene's highest.")] = None,
    column: Annotated[str | None, Option(metavar="COLUMN", help="smoothed, capped or elastic.")] = None,
    zoom: Annotated[str | None, Option(metavar="X0:X1,Y0:Y1", help="Draw this part of a map; in m.")] = None,
    side_by_side: Annotated[bool, Option("--side-by-side", help="Add heights and pressure to the map.")] = False,
) -> None:
    """Draw a map or a curve of a run, as .png, .pdf or .svg.

    Maps: heights, pressure, temperature, heat_flux. Curves: such as distribution or spectrum; another word lists them.
    Temperatures are computed from the stored pressure.
    """
    from roughsim.charts.plot import plot_run
    from roughsim.results.folder import gap

    choices: dict[str, Any] = {"realization": realization, "speed": speed, "column": column}
    choices |= {"zoom": parse_zoom(zoom), "side_by_side": side_by_side}
    opened = open_without_damaged(run)
    picture = plot_run(opened, quantity, output, **choices)
    tell("\n".join([*gap(opened), f"picture: {picture}"]))


@app.command()
def explore(
    run: RunFolder,
    port: Annotated[int | None, Option(metavar="N", min=1, max=65535, help="Left out: first free from 5006.")] = None,
    browser: Annotated[bool, Option("--browser/--no-browser", help="Open the page in the web browser.")] = True,
) -> None:
    """Look at a run in the web browser: fields at any speed, curves. The run may still be going on."""
    from roughsim.explore import explore as serve

    def announce(address: str) -> None:
        tell(f"page: {address} (this computer only; Ctrl-C ends it)")

    serve(run, port=port, browser=browser, announce=announce)


@app.command()
def report(run: RunFolder, output: Output = None) -> None:
    """Write a run as one .html page to mail. It holds scene, plan, comparison, errors and pictures."""
    from roughsim.report import report_run

    page = report_run(open_without_damaged(run), output)
    tell(f"report: {page}, {page.stat().st_size / 1e6:.3g} MB")


@app.command()
def export(
    run: RunFolder,
    output: Annotated[Path, Option("-o", "--output", metavar="FILE", help="The file.")],
    bits: Annotated[int | None, Option(metavar="N", min=1, max=23, help="Mantissa bits of fields, of 23.")] = None,
    surface: Annotated[int | None, Option(metavar="K", min=0, help="Only heights of realization K: .nc, .npy.")] = None,
) -> None:
    """Write the numbers and the kept fields of a run into one file. It is HDF5 (netCDF-4): .h5, .hdf5 or .nc."""
    from roughsim.results.export import export_run, export_surface
    from roughsim.results.folder import gap

    if surface is not None and bits is not None:
        raise ValueError("--bits does not go with --surface, which keeps all digits; leave one of them out")
    opened = rs.open_run(run)
    file = export_run(opened, output, bits) if surface is None else export_surface(opened, output, surface)
    tell("\n".join([*gap(opened), f"file: {file}, {file.stat().st_size / 1e6:.3g} MB"]))


@app.command()
def bench(
    scene: SceneName,
    stage: Annotated[list[str] | None, Option(metavar="STAGE", help="May be repeated; left out: all.")] = None,
    realizations: Annotated[int, Option(metavar="N", min=4, help="Members to measure scatter and bias with.")] = 8,
    chart: Chart = None,
    as_json: Json = False,
) -> None:
    """Measure error and cost of the ways to compute a scene. The choice of the plan is marked.

    Stages: contact (tolerance, precision, pixel), chain (levels and realizations of the ensemble).
    """
    from roughsim.bench import STAGES, bench_dict, bench_tables
    from roughsim.bench import bench as measure
    from roughsim.charts.error_over_cost import error_over_cost_chart

    points = measure(rs.load_scene(scene), stages=stage or STAGES, realizations=realizations)
    if as_json:
        print_json(bench_dict(points))
    else:
        print_parts(*bench_tables(points))
    if chart is not None:
        error_over_cost_chart(points, chart)
        tell(f"picture: {chart}")


@app.command()
def doctor(as_json: Json = False) -> None:
    """Check this installation, and compute two exact cases. Exits with 1 if something is wrong."""
    from roughsim.doctor import examine, lines

    findings = examine(Path())
    say(json.dumps(findings, indent=1) if as_json else "\n".join(lines(findings)))
    if not findings["sound"]:
        raise Exit(1)


def parse_zoom(text: str | None) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return the ends along x and y, m, of "X0:X1,Y0:Y1"; None for None."""
    if text is None:
        return None
    try:
        (x0, x1), (y0, y1) = (side.split(":") for side in text.split(","))
        return (float(x0), float(x1)), (float(y0), float(y1))
    except ValueError:
        raise ValueError(f"--zoom {text}: write X0:X1,Y0:Y1 in m, for example 0:5e-4,2e-4:7e-4") from None


def open_without_damaged(folder: Path) -> Any:
    """Open a run without its damaged files, and name these on the terminal."""
    run = rs.open_run(folder, damaged="skip")
    for reason in run.damaged.values():
        tell(f"left out: {reason}")
    return run


def print_json(value: Any) -> None:
    """Print a value as JSON."""
    say(json.dumps(value, indent=1))


def print_parts(*parts: Any) -> None:
    """Print lines and tables."""
    from roughsim.show.terminal import PlainConsole

    PlainConsole().print_parts(*parts)


def main(words: list[str] | None = None) -> None:
    """Run the command line on `words`, or on the process's own; an error is one line and a non-zero exit code."""
    show_warnings_once()
    text.notes_are_shown = True
    print_in_any_language()
    with errors_in_one_line(" ".join(sys.argv[1:] if words is None else words)):
        code = app(words, standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    raise SystemExit(code or 0)


if __name__ == "__main__":
    main()
