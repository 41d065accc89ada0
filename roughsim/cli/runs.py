"""The verbs that take the folder of a run."""

from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

import roughsim as rs
from roughsim.cli.words import (
    Chart,
    Json,
    OneRun,
    Output,
    RunFolder,
    open_without_damaged,
    print_json,
    print_parts,
    study_of,
)
from roughsim.show.text import tell


def status(run: RunFolder, as_json: Json = False) -> None:
    """Show the progress of a run: errors, failures, time left. It may still be computed."""
    if (study := study_of(run)) is not None:
        from roughsim.studies.tables import study_table

        if as_json:
            print_json(study.to_dict())
        else:
            print_parts(study_table(study))
        return
    from roughsim.ensemble.status import status_dict, status_lines

    opened = open_without_damaged(run)
    if as_json:
        print_json(status_dict(opened))
    else:
        print_parts(*status_lines(opened))


def compare(run: OneRun, chart: Chart = None, as_json: Json = False) -> None:
    """Compare a run with the theory, in a table of values and ratios."""
    from roughsim.comparison.tables import trust_table
    from roughsim.comparison.trust import trust

    opened = rs.open_run(run)
    comparison = rs.compare(opened)
    if as_json:
        print_json(comparison.to_dict())
    else:
        print_parts(comparison.table(), trust_table(trust(opened.scene)))
    if chart is not None:
        comparison.chart(chart)
        tell(f"picture: {chart}")


def plot(  # noqa: PLR0913  (each is an option)
    run: RunFolder,
    quantity: Annotated[str, Argument(metavar="QUANTITY", help="A map or a curve, see above.")],
    output: Output = None,
    realization: Annotated[int | None, Option("-r", metavar="K", min=0, help="A realization with kept fields.")] = None,
    speed: Annotated[float | None, Option(metavar="V", help="In m/s; left out: the scene's highest.")] = None,
    column: Annotated[str | None, Option(metavar="COLUMN", help="smoothed, capped or elastic.")] = None,
    zoom: Annotated[str | None, Option(metavar="X0:X1,Y0:Y1", help="Draw this part of a map; in m.")] = None,
    side_by_side: Annotated[bool, Option("--side-by-side", help="Add heights and pressure to the map.")] = False,
    title: Annotated[bool, Option("--title/--no-title", help="With the lines above the picture.")] = True,
    size: Annotated[str | None, Option(metavar="WxH", help="Width and height in inches, as 3.4x2.6.")] = None,
    dpi: Annotated[int, Option(metavar="N", help="Pixels per inch of a .png.")] = 160,
    csv: Annotated[Path | None, Option(metavar="FILE", help="Write the numbers that are drawn, too.")] = None,
) -> None:
    """Draw a map or a curve of a run, as .png, .pdf or .svg. Of a study, an observable over its axes.

    Maps: heights, pressure, temperature, heat_flux. Curves: such as distribution or spectrum; another word lists them.
    Temperatures are computed from the stored pressure.
    """
    if (study := study_of(run)) is not None:
        picture = output or run.with_name(f"{run.name}-{quantity}.png")
        study.chart(picture, quantity)
        tell(f"picture: {picture}")
        return
    from roughsim.charts.plot import plot_run
    from roughsim.charts.style import Look
    from roughsim.results.folder import gap

    choices: dict[str, Any] = {"realization": realization, "speed": speed, "column": column}
    choices |= {"zoom": _parse_zoom(zoom), "side_by_side": side_by_side}
    choices["look"] = Look(title, _parse_size(size), dpi, csv)
    opened = open_without_damaged(run)
    picture = plot_run(opened, quantity, output, **choices)
    tell("\n".join([*gap(opened), f"picture: {picture}"]))


def explore(
    run: RunFolder,
    port: Annotated[int | None, Option(metavar="N", min=1, max=65535, help="Left out: first free from 5006.")] = None,
    browser: Annotated[bool, Option("--browser/--no-browser", help="Open the page in the web browser.")] = True,
) -> None:
    """Look at a run in the web browser: fields at any speed, curves. The run may still be going on.

    Of a study: every observable over its axes.
    """
    from roughsim.explore import explore as serve

    def announce(address: str) -> None:
        tell(f"page: {address} (this computer only; Ctrl-C ends it)")

    serve(run, port=port, browser=browser, announce=announce)


def report(run: RunFolder, output: Output = None) -> None:
    """Write a run as one .html page to mail. It holds scene, plan, comparison, errors and pictures."""
    if (study := study_of(run)) is not None:
        from roughsim.outputs.study_report import report_study

        page = report_study(study, output)
    else:
        from roughsim.outputs.report import report_run

        page = report_run(open_without_damaged(run), output)
    tell(f"report: {page}, {page.stat().st_size / 1e6:.3g} MB")


def export(
    run: RunFolder,
    output: Annotated[Path, Option("-o", "--output", metavar="FILE", help="The file.")],
    bits: Annotated[int | None, Option(metavar="N", min=1, max=23, help="Mantissa bits of fields, of 23.")] = None,
    surface: Annotated[int | None, Option(metavar="K", min=0, help="Only heights of realization K: .nc, .npy.")] = None,
) -> None:
    """Write the numbers and the kept fields of a run into one file. It is HDF5 (netCDF-4): .h5, .hdf5 or .nc.

    Of a study: every observable over its axes, or the same as one table: .csv, .json or .parquet.
    """
    if (study := study_of(run)) is not None:
        file = study.save(output)
        tell(f"file: {file}, {file.stat().st_size / 1e6:.3g} MB")
        return
    from roughsim.results.export import export_run, export_surface
    from roughsim.results.folder import gap

    if surface is not None and bits is not None:
        raise ValueError("--bits does not go with --surface, which keeps all digits; leave one of them out")
    opened = rs.open_run(run)
    file = export_run(opened, output, bits) if surface is None else export_surface(opened, output, surface)
    tell("\n".join([*gap(opened), f"file: {file}, {file.stat().st_size / 1e6:.3g} MB"]))


def _parse_zoom(text: str | None) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return the ends along x and y, m, of "X0:X1,Y0:Y1"; None for None."""
    if text is None:
        return None
    try:
        (x0, x1), (y0, y1) = (side.split(":") for side in text.split(","))
        return (float(x0), float(x1)), (float(y0), float(y1))
    except ValueError:
        raise ValueError(f"--zoom {text}: write X0:X1,Y0:Y1 in m, for example 0:5e-4,2e-4:7e-4") from None


def _parse_size(text: str | None) -> tuple[float, float] | None:
    """Return width and height, inches, of "WxH"; None for None."""
    if text is None:
        return None
    try:
        width, height = (float(side) for side in text.lower().replace("×", "x").split("x"))
        return width, height
    except ValueError:
        raise ValueError(f"--size {text}: write width x height in inches, for example 3.4x2.6") from None
