"""The command line: each verb is one public function."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from roughsim.show.text import errors_in_one_line, fail, print_in_any_language, say, show_warnings_once, tell, warn

if TYPE_CHECKING:
    from roughsim.comparison.compare import Comparison
    from roughsim.results.run import Run
    from roughsim.scene import Scene

app = typer.Typer(
    name="roughsim",
    help="Monte Carlo simulation of rough sliding contacts, beside the analytic theory of the flash temperature.",
    rich_markup_mode=None,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _scenes(incomplete: str) -> list[str]:
    """The bundled scenes that a word may become, for completion in the shell."""
    from roughsim.scene import bundled_scenes

    return [name for name in bundled_scenes() if name.startswith(incomplete)]


SceneName = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A bundled scene (roughsim new lists them) or a path.", autocompletion=_scenes
    ),
]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON (SI units) for programs.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes; all cores if left out.")]


def _version(wanted: bool) -> None:
    if wanted:
        from roughsim import __version__

        say(f"roughsim {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Monte Carlo simulation of rough sliding contacts, beside the analytic theory of the flash temperature."""


@app.command()
def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the run.")] = Path("roughsim-demo"),
    workers: Workers = None,
) -> None:
    """Run and compare the scene `demo`, and draw the picture, in less than a minute."""
    from roughsim.scene import load_scene

    result = _run(load_scene("demo"), output, workers=workers)
    _compare(result, chart=output / "comparison.png", as_json=False)


@app.command()
def new(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="A bundled scene, or blank: a form with every key; left out: list them.",
            autocompletion=lambda incomplete: [*_scenes(incomplete), *["blank"][: "blank".startswith(incomplete)]],
        ),
    ] = None,
) -> None:
    """Print a bundled scene, commented, to start from: roughsim new demo > my.toml."""
    from roughsim.scene import BLANK, bundled_scenes, scene_text

    if name is None:
        say("\n".join((*bundled_scenes(), BLANK)))
    else:
        say(scene_text(name).rstrip("\n"))


@app.command()
def plan(
    scene: SceneName,
    target_error: Annotated[
        float | None, typer.Option(help="Relative error aimed at in T_flash; the scene's `until` if left out.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Show how a scene would be computed, each choice with its reason."""
    from roughsim.planning.limits import judge
    from roughsim.planning.plan import plan as make_plan
    from roughsim.planning.plan import plan_table
    from roughsim.scene import load_scene

    loaded = load_scene(scene)
    numerics = make_plan(loaded, target_error)
    judged = judge(loaded, numerics)
    if as_json:
        reasons = [reason._asdict() for reason in numerics.reasons]
        say(json.dumps(numerics.to_dict() | {"reasons": reasons} | judged.to_dict(), indent=1))
    else:
        _print(plan_table(numerics.reasons), *judged.tables())
        for line in judged.warnings:
            warn(line)


@app.command()
def theory(
    scene: SceneName,
    as_json: Json = False,
    trust: Annotated[bool, typer.Option("--trust", help="Say how far the theory is known to be off here.")] = False,
) -> None:
    """Evaluate the analytic theory of a scene over its whole spectrum."""
    from roughsim.comparison.tables import theory_dict, theory_table, trust_table
    from roughsim.comparison.trust import trust as look_up
    from roughsim.planning.limits import judge
    from roughsim.scene import load_scene

    loaded = load_scene(scene)
    known, judged = look_up(loaded) if trust else None, judge(loaded)
    if as_json:
        told = theory_dict(loaded) | judged.to_dict() | ({"trust": known.to_dict()} if known else {})
        say(json.dumps(told, indent=1))
    else:
        _print(theory_table(loaded), *([trust_table(known)] if known else []), *judged.tables())
        for line in judged.warnings:
            warn(line)


@app.command()
def run(
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="RUN", help="Folder of the run; resumed if there.")],
    until: Annotated[
        list[str] | None,
        typer.Option(metavar="OBSERVABLE=PERCENT", help="Stop at this 95 % half-width, e.g. flash_temperature=1%."),
    ] = None,
    most: Annotated[int | None, typer.Option("--max", min=1, help="Stop after this many realizations.")] = None,
    workers: Workers = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Threads of each realization.")] = None,
    keep_fields: Annotated[
        int | None, typer.Option(min=0, help="Store the fields of the first K realizations.")
    ] = None,
) -> None:
    """Compute an ensemble of realizations; the same command goes on where it was stopped."""
    from dataclasses import replace

    from roughsim.ensemble.progress import targets
    from roughsim.scene import load_scene

    loaded = load_scene(scene)
    given = {"threads": threads, "keep_fields": keep_fields}
    chosen: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if chosen:
        loaded = replace(loaded, numerics=replace(loaded.numerics, **chosen))
    result = _run(loaded, output, until=targets(until), max_realizations=most, workers=workers)
    if result.failed > 0.01 * result.realizations:
        raise typer.Exit(1)


@app.command()
def compare(
    run: RunFolder,
    chart: Annotated[Path | None, typer.Option(metavar="F", help="Draw the figure: .png, .pdf or .svg.")] = None,
    as_json: Json = False,
) -> None:
    """Set a run beside the theory: theory, smoothed, capped, and their ratios with errors."""
    from roughsim.results.folder import open_run

    _compare(open_run(run), chart=chart, as_json=as_json)


@app.command()
def status(run: RunFolder, as_json: Json = False) -> None:
    """Say where a run stands: members, mean ± error, time left, failures; also while it is being computed."""
    from roughsim.ensemble.status import status_dict, status_lines

    opened = _opened(run)
    if as_json:
        say(json.dumps(status_dict(opened), indent=1))
    else:
        _print(*status_lines(opened))


@app.command()
def plot(
    run: RunFolder,
    quantity: Annotated[
        str,
        typer.Argument(
            metavar="QUANTITY",
            help="heights, pressure, temperature, heat_flux (maps), distribution, spectrum, correlation or profile.",
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="F", help="Picture: .png, .pdf or .svg; beside RUN.")
    ] = None,
    realization: Annotated[int | None, typer.Option("-r", min=0, metavar="K", help="A kept realization.")] = None,
    speed: Annotated[float | None, typer.Option(metavar="V", help="m/s; the scene's highest if left out.")] = None,
    column: Annotated[str | None, typer.Option(help="smoothed, capped or elastic.")] = None,
    zoom: Annotated[str | None, typer.Option(metavar="X0:X1,Y0:Y1", help="The part of a map that is drawn, m.")] = None,
    side_by_side: Annotated[
        bool, typer.Option("--side-by-side", help="Heights and pressure beside the temperature (or heat_flux).")
    ] = False,
) -> None:
    """Draw a field or a curve of a run; temperatures are recomputed from the stored pressure."""
    from roughsim.charts import plot_run

    options: dict[str, Any] = {"realization": realization, "speed": speed, "column": column}
    options |= {"zoom": _zoom(zoom), "side_by_side": side_by_side}
    opened = _opened(run)
    place = plot_run(opened, quantity, output, **options)
    _tell_made(opened, f"picture: {place}")


@app.command()
def report(
    run: RunFolder,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="F", help="The page: .html; beside RUN if left out.")
    ] = None,
) -> None:
    """Write a run as one page to mail: scene, plan, comparison, errors, pictures and provenance."""
    from roughsim.report import report_run

    place = report_run(_opened(run), output)
    tell(f"report: {place}, {place.stat().st_size / 1e6:.3g} MB")


@app.command()
def export(
    run: RunFolder,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="F", help="The file: .h5, .hdf5 or .nc.")],
    bits: Annotated[
        int | None, typer.Option(min=1, max=23, metavar="N", help="Mantissa bits that fields keep; all 23 if left out.")
    ] = None,
    surface: Annotated[
        int | None,
        typer.Option(min=0, metavar="K", help="Only the heights of realization K, as .nc or .npy for other programs."),
    ] = None,
) -> None:
    """Write the numbers of all members and the kept fields into one HDF5 (netCDF-4) file."""
    from roughsim.results.export import export_run
    from roughsim.results.folder import open_run
    from roughsim.results.surfaces import export_surface

    if surface is not None and bits is not None:
        raise ValueError("--bits does not go with --surface, which keeps all digits; leave one of them out")
    opened = open_run(run)
    place = export_run(opened, output, bits) if surface is None else export_surface(opened, output, surface)
    _tell_made(opened, f"file: {place}, {place.stat().st_size / 1e6:.3g} MB")


@app.command()
def explore(
    run: RunFolder,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Where it is served; the first free one from 5006 if left out.")
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the web browser.")] = True,
) -> None:
    """Serve a page to look at a run, also while it is being computed: fields, any speed and direction, curves."""
    from roughsim.explore import explore as serve

    def announce(address: str) -> None:
        tell(f"page: {address} (this computer only; Ctrl-C ends it)")

    serve(run, port=port, browser=browser, announce=announce)


@app.command()
def bench(
    scene: SceneName,
    stage: Annotated[
        list[str] | None, typer.Option(help="surface, contact, heat, moments, theory or chain; all if left out.")
    ] = None,
    realizations: Annotated[int, typer.Option(min=4, help="Members that scatter and bias are measured with.")] = 8,
    chart: Annotated[Path | None, typer.Option(metavar="F", help="Draw the figure: .png, .pdf or .svg.")] = None,
    as_json: Json = False,
) -> None:
    """Measure error and cost of the ways to compute a scene, and where the plan's choice lies among them."""
    from roughsim.bench import STAGES, bench_chart, bench_dict, bench_tables
    from roughsim.bench import bench as measure
    from roughsim.scene import load_scene

    points = measure(load_scene(scene), stages=stage or STAGES, realizations=realizations)
    if as_json:
        say(json.dumps(bench_dict(points), indent=1))
    else:
        _print(*bench_tables(points))
    if chart is not None:
        bench_chart(points, chart)
        tell(f"picture: {chart}")


def _zoom(text: str | None) -> Any:
    if text is None:
        return None
    try:
        (x0, x1), (y0, y1) = (side.split(":") for side in text.split(","))
        return (float(x0), float(x1)), (float(y0), float(y1))
    except ValueError:
        raise ValueError(f"--zoom {text}: write X0:X1,Y0:Y1 in m, for example 0:5e-4,2e-4:7e-4") from None


def _opened(folder: Path) -> Run:
    """The run for looking at: damaged files are named, and the others shown."""
    from roughsim.results.folder import open_run

    run = open_run(folder, damaged="skip")
    for reason in run.damaged.values():
        tell(f"left out: {reason}")
    return run


def _tell_made(run: Run, made: str) -> None:
    """Tell which file was made, and what it lacks because members are missing in the middle of the run."""
    from roughsim.results.gaps import gap

    for line in (*gap(run), made):
        tell(line)


@app.command()
def doctor(as_json: Json = False) -> None:
    """Say what is installed and what is missing, and compute two exact cases; exits with 1 if something is wrong."""
    from roughsim.doctor import examine, lines

    found = examine(Path())
    say(json.dumps(found, indent=1) if as_json else "\n".join(lines(found)))
    if not found["sound"]:
        raise typer.Exit(1)


def _run(scene: Scene, output: Path, *, workers: int | None, **options: Any) -> Run:
    from roughsim.ensemble.progress import run_shown

    try:
        return run_shown(scene, output, workers, **options)
    except KeyboardInterrupt:  # here, since the command line's own frame would swallow it without a word
        fail("stopped; what was computed is stored, and the same command goes on from there", 130)


def _compare(run: Run, *, chart: Path | None, as_json: bool) -> None:
    from roughsim.comparison.compare import compare as set_beside
    from roughsim.comparison.tables import comparison_table, trust_table
    from roughsim.comparison.trust import trust

    table: Comparison = set_beside(run)
    if as_json:
        say(json.dumps(table.to_dict(), indent=1))
    else:
        _print(comparison_table(table), trust_table(trust(run.scene)))
    if chart is not None:
        table.chart(chart)
        tell(f"picture: {chart}")


def _print(*parts: Any) -> None:
    from roughsim.show.terminal import PlainConsole

    PlainConsole().print_parts(*parts)


def main(words: list[str] | None = None) -> None:
    """Run the command line on `words`, or on the process's own; an error is one line and a non-zero exit code."""
    show_warnings_once()
    print_in_any_language()
    with errors_in_one_line(" ".join(sys.argv[1:] if words is None else words)):
        code = app(words, standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    raise SystemExit(code or 0)


if __name__ == "__main__":
    main()
