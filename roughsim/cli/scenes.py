"""Commands that take a scene, and commands without arguments."""

import time
import warnings
from functools import partial
from pathlib import Path
from typing import Annotated

from typer import Argument, Exit, Option

import roughsim as rs
from roughsim.cli.words import (
    Chart,
    Csv,
    Every,
    Json,
    SceneName,
    Set,
    TargetError,
    Workers,
    changes_of,
    check_figure,
    complete_form,
    complete_scene,
    draw_figure,
    open_scene,
    print_comparison,
    print_json,
    print_parts,
    show_scene,
)
from roughsim.show.text import clock, fail, note, say, tell, warn

_STOPPED = "stopped; all finished members are stored, and the same command continues from there"


def demo(
    output: Annotated[
        Path, Option("-o", "--output", metavar="RUN", help="Folder of the run.")
    ] = Path("roughsim-demo"),
    workers: Workers = None,
) -> None:
    """Run a small scene, compare it with theory, and draw the picture. It takes less than a minute."""
    run("demo", output, workers=workers, chart=output / "comparison.png")


def new(
    name: Annotated[
        str | None,
        Argument(metavar="NAME", help="Left out: list all.", autocompletion=complete_form),
    ] = None,
) -> None:
    """List the bundled scenes, or print one to start your own from. `blank` is a form with every key.

    For example: roughsim new demo > my.toml
    """
    say(rs.new(name).rstrip("\n"))


def theory(
    scenes: Annotated[
        list[str],
        Argument(
            metavar="SCENE...", help="Files or bundled scenes.", autocompletion=complete_scene
        ),
    ],
    changes: Set = None,
    chart: Chart = None,
    csv: Csv = None,
    as_json: Json = False,
    trust: Annotated[
        bool, Option("--trust", help="Print the error of the theory for this scene.")
    ] = False,
    every: Every = False,
) -> None:
    """Print the results of the analytic theory for a scene. A figure holds several scenes.

    For example: roughsim theory steel-0.5GPa steel-1.2GPa --chart theory.png
    """
    from roughsim.comparison.tables import trust_table
    from roughsim.comparison.theory import theory_chart
    from roughsim.comparison.trust import trust as look_up

    check_figure(chart, csv)
    theories = [rs.theory(open_scene(scene, changes)) for scene in scenes]
    if as_json:
        values = [
            one.to_dict() | ({"trust": look_up(one.scene).to_dict()} if trust else {})
            for one in theories
        ]
        print_json(values[0] if len(values) == 1 else {"scenes": values})
    else:
        for one in theories:
            errors = [trust_table(look_up(one.scene))] if trust else []
            more = [*filter(None, [one.asked()])] if every else []
            tables = [one.table(), *more, *errors, one.judged.table()]
            show_scene(one.summary(), tables, one.judged.warnings, every, len(theories))
            if not every:
                print_parts(*errors)
    draw_figure(partial(theory_chart, dict(zip(scenes, theories, strict=True))), chart, csv)


def plan(
    scene: SceneName,
    changes: Set = None,
    target_error: TargetError = None,
    every: Every = False,
    as_json: Json = False,
) -> None:
    """Show how a scene would be computed, and why so."""
    from roughsim.scene.ensemble import TARGET

    target = (
        None
        if target_error is None
        else {"flash_temperature": TARGET(target_error, "--target-error")}
    )
    loaded = open_scene(scene, changes, {"ensemble.until": target})
    if not as_json:
        note(f"planning {scene}")  # before slow imports
    from roughsim.planning.limits import judge
    from roughsim.planning.plan import numerics_of
    from roughsim.planning.reasons import plan_summary, plan_table

    numerics = numerics_of(loaded)
    judged = judge(loaded, numerics)
    if as_json:
        names = ("choice", "value", "reason")
        reasons = [dict(zip(names, one.row, strict=True)) for one in numerics.reasons]
        print_json(numerics.to_dict() | {"reasons": reasons} | judged.to_dict())
    else:
        short = plan_summary(loaded.title or scene, numerics, judged.sizes)
        tables = [plan_table(numerics.reasons), judged.table()]
        show_scene(short, tables, judged.warnings, every)


def run(  # noqa: PLR0913  (each is an option)
    scene: SceneName,
    output: Annotated[
        Path, Option("-o", "--output", metavar="RUN", help="Folder of the run, new or begun.")
    ],
    changes: Set = None,
    target_error: TargetError = None,
    until: Annotated[
        list[str] | None,
        Option(metavar="NAME=X", help="The same of any observable. May be repeated."),
    ] = None,
    most: Annotated[
        int | None, Option("--max", metavar="N", min=1, help="Stop at N of the lowest level.")
    ] = None,
    members: Annotated[
        int | None,
        Option(metavar="N", min=1, help="Compute N of the lowest level, in place of a target."),
    ] = None,
    workers: Workers = None,
    threads: Annotated[
        int | None, Option(metavar="N", min=1, help="Threads of each process.")
    ] = None,
    keep_fields: Annotated[
        int | None, Option(metavar="K", min=0, help="Store fields of the first K members.")
    ] = None,
    chart: Chart = None,
) -> None:
    """Compute realizations and compare them with theory. Repeated, it resumes.

    For example: roughsim run demo -o runs/demo --target-error 1%
    """
    from roughsim.scene.checks import check_ends
    from roughsim.scene.files import with_map

    check_figure(chart)
    began = time.monotonic()
    if target_error is not None:
        until = [*(until or []), f"flash_temperature={target_error}"]
    targets = {
        name.strip(): value for name, _, value in (word.partition("=") for word in until or ())
    } or None
    ensemble = {
        "ensemble.until": targets,
        "ensemble.max_realizations": most,
        "ensemble.realizations": members,
    }
    options = ensemble | {"numerics.threads": threads, "numerics.keep_fields": keep_fields}
    loaded, measured = with_map(scene, changes_of(changes, options))
    check_ends(loaded.ensemble, {"--until": until, "--max": most})
    begun = (output / "run.json").exists()
    if not output.is_file():  # which is refused below
        note(f"going on with {output}" if begun else f"planning {scene}")
    from roughsim.ensemble import executors
    from roughsim.ensemble.map_beside import press_beside
    from roughsim.ensemble.progress import Progress
    from roughsim.ensemble.run import begin, complete
    from roughsim.ensemble.status import losses, outcome

    if begun and (output / "scene.toml").is_file():
        _note_looser_targets(output / "scene.toml", loaded.ensemble.ends)
    try:
        with executors.Workers(workers) as allowed:
            numerics = begin(loaded, output)
            _show_plan(loaded, numerics)
            with Progress("computing") as bar:
                begun_run = [(loaded, numerics, output)]
                (result,) = complete(begun_run, allowed, bar.update, began=bar.update)
            press_beside(result, measured)
    except KeyboardInterrupt:  # caught here: typer would end without a message
        fail(_STOPPED, 130)
    took = clock(time.monotonic() - began)
    for line in (f"{result.extent} in {result.folder}, {took}; {outcome(result)}", *losses(result)):
        tell(line)
    _compare(result, chart)
    if result.failed > 0.01 * result.realizations:
        raise Exit(1)


def _compare(result: "rs.Run", chart: Path | None) -> None:
    """Print how a run compares with the theory, and draw it, if its realizations show an error."""
    try:
        compared = rs.compare(result)
    except ValueError as reason:  # a single realization
        tell(f"not compared: {reason}")
        return
    print_comparison(compared)
    draw_figure(compared.chart, chart, None)


def _note_looser_targets(stored: Path, targets: dict[str, float]) -> None:
    """Print a line for each target that was stricter in the stored scene of a run: fewer of its members will count."""
    from roughsim.scene.ensemble import EnsembleSection
    from roughsim.scene.files import scene_content

    before = EnsembleSection(**scene_content(stored)[0].get("ensemble", {}))
    for name, goal in before.ends.items():
        if goal < targets.get(name, 0.0):
            note(
                f"the target of {name} was {100 * goal:g} %, and is {100 * targets[name]:g} % now: members beyond it "
                f"stay stored but do not count; --until {name}={100 * goal:g}% takes them in again"
            )


def _show_plan(scene: "rs.Scene", numerics: "rs.Numerics") -> None:
    """Print what a run computes, its target and its cost, and warnings, before its members are computed."""
    from roughsim.planning.limits import judge
    from roughsim.planning.plan import cost_of
    from roughsim.planning.realization import slide_problem
    from roughsim.planning.reasons import opening

    tell(opening(scene, numerics, cost_of(scene, numerics)))
    if numerics.slide is not None:
        steps = slide_problem(scene, numerics).steps
        tell(
            f"sliding: {steps} contacts in turn for each member; one that is interrupted begins again"
        )
    for line in judge(scene, numerics).remarks:
        warn(line)


def press(
    scene: SceneName,
    output: Annotated[
        Path, Option("-o", "--output", metavar="RUN", help="Folder of the run, new or begun.")
    ],
    changes: Set = None,
    edges: Annotated[
        str | None, Option(metavar="EDGES", help="mirror or tile; left out: mirror, see above.")
    ] = None,
) -> None:
    """Press the measured map itself; its quadrants give the scatter.

    The key topography of [surface] names it. The map is made periodic by its mirror images, or laid side by side as it
    is (tile) if its file marks it as periodic. The run opens as any other: compare, plot, report, explore.
    """
    pressed = rs.press(scene, output, edges=edges, changes=changes_of(changes))  # type: ignore[arg-type]
    _compare(pressed, None)


def study(
    study: Annotated[
        Path, Argument(metavar="STUDY", help="A file with a scene and a table [vary].")
    ],
    output: Annotated[
        Path, Option("-o", "--output", metavar="FOLDER", help="Folder of the study, new or begun.")
    ],
    workers: Workers = None,
    as_json: Json = False,
) -> None:
    """Compute a scene for many values of its keys, a run for each. The same command resumes an interrupted study.

    A study file: scene = "demo", target_error = "2 %", and a table [vary] with lines such as
    "sliding.nominal_pressure" = ["1 MPa", "5 MPa"].
    """
    began = time.monotonic()
    from roughsim.studies.folder import study_file
    from roughsim.studies.tables import asked_table, study_table

    content = study_file(study)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "always", rs.SceneWarning
            )  # before hours of work, not below the table alone
            result = rs.study(
                content["scene"],
                vary=content["vary"],
                folder=output,
                target_error=content.get("target_error"),
                workers=workers,
            )
    except KeyboardInterrupt:  # caught here: typer would end without a message
        fail(_STOPPED, 130)
    spent = clock(time.monotonic() - began)
    tell(f"{result.finished} of {len(result.points)} points finished in {output}, {spent}")
    if as_json:
        print_json(result.to_dict())
    else:
        print_parts(*filter(None, (study_table(result), asked_table(result))))


def bench(
    scene: SceneName,
    changes: Set = None,
    stage: Annotated[
        list[str] | None, Option(metavar="STAGE", help="May be repeated; left out: all.")
    ] = None,
    realizations: Annotated[
        int, Option(metavar="N", min=4, help="Members to measure scatter and bias with.")
    ] = 8,
    chart: Chart = None,
    as_json: Json = False,
) -> None:
    """Measure error and cost of the ways to compute a scene. The choice of the plan is marked.

    Stages: contact (tolerance, precision, pixel), chain (levels and realizations of the ensemble).
    """
    from roughsim.charts.error_over_cost import error_over_cost_chart
    from roughsim.error_over_cost import STAGES, bench_dict, bench_tables

    check_figure(chart)
    points = rs.bench(open_scene(scene, changes), stages=stage or STAGES, realizations=realizations)
    if as_json:
        print_json(bench_dict(points))
    else:
        print_parts(*bench_tables(points))
    if chart is not None:
        error_over_cost_chart(points, chart)
        tell(f"picture: {chart}")


def doctor(as_json: Json = False) -> None:
    """Check this installation, and compute two exact cases. Exits with 1 if something is wrong."""
    from roughsim.cli.installation import examine, lines

    findings = examine(Path())
    if as_json:
        print_json(findings)
    else:
        print_parts(*lines(findings))
    if not findings["sound"]:
        raise Exit(1)
