"""The verbs that take the folder of a run."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

import roughsim as rs
from roughsim.cli.words import (
    Chart,
    Csv,
    Json,
    Output,
    RunFolder,
    check_figure,
    draw_figure,
    open_without_damaged,
    print_comparison,
    print_json,
    print_parts,
)
from roughsim.show.text import note, tell


def status(run: RunFolder, as_json: Json = False) -> None:
    """Show the progress of a run: errors, failures, time left. It may still be computed."""
    state = rs.status(open_without_damaged(run))
    if as_json:
        print_json(state.to_dict())
    else:
        print_parts(*str(state).splitlines())


def compare(
    runs: Annotated[list[Path], Argument(metavar="RUN...", help="Folders of runs, or of a study.")],
    chart: Chart = None,
    csv: Csv = None,
    every: Annotated[
        bool, Option("--all", help="All observables, ratios and notes; the error of the theory.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Compare a run with the theory: T_flash in each column. Several runs, or those of a study, are side by side."""
    check_figure(chart, csv)
    compared = rs.compare(*runs)
    if isinstance(compared, rs.Comparison) and compared.run.scene.distribution:
        note("drawing fields for the theory of the distribution of the temperature")
    if as_json:
        print_json(compared.to_dict())
    elif isinstance(compared, rs.Comparisons):
        print_parts(compared.table(None) if every else compared.table())
    elif every:
        from roughsim.comparison.tables import trust_table
        from roughsim.comparison.trust import trust

        print_parts(compared.table(), trust_table(trust(compared.run.scene)))
    else:
        print_comparison(compared)
    draw_figure(compared.chart, chart, csv)


def plot(  # noqa: PLR0913  (each is an option)
    run: RunFolder,
    quantity: Annotated[str, Argument(metavar="QUANTITY", help="A map or a curve, see above.")],
    output: Output = None,
    realization: Annotated[
        int | None,
        Option("-r", "--realization", metavar="K", min=0, help="A realization with kept fields."),
    ] = None,
    speed: Annotated[
        str | None,
        Option(metavar="V", help="In m/s, or with a unit; left out: the scene's highest."),
    ] = None,
    column: Annotated[
        str | None,
        Option(metavar="COLUMN", help="smoothed, capped or elastic; of reactions also sliding."),
    ] = None,
    over: Annotated[
        str | None, Option(metavar="AXIS", help="Of a study: speed, or a varied number.")
    ] = None,
    zoom: Annotated[
        str | None, Option(metavar="X0:X1,Y0:Y1", help="Draw this part of a map; in m.")
    ] = None,
    side_by_side: Annotated[
        bool, Option("--side-by-side", help="Add heights and pressure to the map.")
    ] = False,
    title: Annotated[
        bool, Option("--title/--no-title", help="With the lines above the picture.")
    ] = True,
    size: Annotated[
        str | None, Option(metavar="WxH", help="Of one row of panels, inches, as 3.4x2.6.")
    ] = None,
    dpi: Annotated[int, Option(metavar="N", help="Pixels per inch of a .png.")] = 160,
    csv: Csv = None,
) -> None:
    """Draw a map or a curve of a run, as .png, .pdf or .svg. Of a study, an observable over its axes.

    Maps: heights, pressure, temperature, seen (by a camera), heat_flux. Curves: psd, correlation, spectrum,
    distribution, reaction, and each observable over the speed, as flash_temperature; another word lists all.
    Temperatures are computed from the stored pressure.
    """
    from roughsim.results.folder import gap

    opened = open_without_damaged(run)
    note(f"drawing {quantity} of {run}")
    picture = rs.plot(
        opened,
        quantity,
        output,
        over=over,
        realization=realization,
        speed=_parse_speed(speed),
        column=column,
        zoom=_parse_zoom(zoom),
        side_by_side=side_by_side,
        title=title,
        size=_parse_size(size),
        dpi=dpi,
        csv=csv,
    )
    tell("\n".join([*(gap(opened) if isinstance(opened, rs.Run) else []), f"picture: {picture}"]))


def explore(
    run: RunFolder,
    port: Annotated[
        int | None, Option(metavar="N", min=1, max=65535, help="Left out: first free from 5006.")
    ] = None,
    browser: Annotated[
        bool, Option("--browser/--no-browser", help="Open the page in the web browser.")
    ] = True,
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
    page = rs.report(open_without_damaged(run), output)
    tell(f"report: {page}, {page.stat().st_size / 1e6:.3g} MB")


def export(
    run: RunFolder,
    output: Annotated[Path, Option("-o", "--output", metavar="FILE", help="The file.")],
    bits: Annotated[
        int | None, Option(metavar="N", min=1, max=23, help="Mantissa bits of fields, of 23.")
    ] = None,
    surface: Annotated[
        int | None, Option(metavar="K", min=0, help="Only heights of realization K: .nc, .npy.")
    ] = None,
) -> None:
    """Write the numbers of a run or a study into one file.

    .h5, .hdf5 and .nc (netCDF-4) hold arrays, of a run also the kept fields; .csv, .json and .parquet hold one table, a
    row for each observable, column and speed.
    """
    from roughsim.outputs.opened import opened
    from roughsim.results.folder import gap

    record = opened(run)
    file = rs.export(record, output, bits=bits, surface=surface)
    lines = gap(record) if isinstance(record, rs.Run) else []
    tell("\n".join([*lines, f"file: {file}, {file.stat().st_size / 1e6:.3g} MB"]))


def _parse_speed(text: str | None) -> float | None:
    """Return a speed, m/s, of a number or of text with a unit; None for None."""
    if text is None:
        return None
    from roughsim.scene.sections import SPEED

    with suppress(ValueError):
        return float(text)
    return float(SPEED(text, "--speed"))


def _parse_zoom(text: str | None) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return the ends along x and y, m, of "X0:X1,Y0:Y1"; None for None."""
    if text is None:
        return None
    try:
        (x0, x1), (y0, y1) = (side.split(":") for side in text.split(","))
        return (float(x0), float(x1)), (float(y0), float(y1))
    except ValueError:
        raise ValueError(
            f"--zoom {text}: write X0:X1,Y0:Y1 in m, for example 0:5e-4,2e-4:7e-4"
        ) from None


def _parse_size(text: str | None) -> tuple[float, float] | None:
    """Return width and height, inches, of "WxH"; None for None."""
    if text is None:
        return None
    try:
        width, height = (float(side) for side in text.lower().replace("×", "x").split("x"))
        return width, height
    except ValueError:
        raise ValueError(
            f"--size {text}: write width x height in inches, for example 3.4x2.6"
        ) from None
