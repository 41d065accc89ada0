"""`plot`: a picture of one quantity of a run or a study."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from roughsim.charts.curves import OVER_SPEED, PSD, Entry, curves_chart
from roughsim.charts.plot import QUANTITIES, plot_run
from roughsim.charts.style import Look, beside, check_ending
from roughsim.estimate.asked import ABOUT, asked_names
from roughsim.outputs.opened import Folder, opened
from roughsim.results.columns import results_of
from roughsim.results.run import Run
from roughsim.studies.figure import draw_study, usual_choice
from roughsim.studies.study import Study


def plot(  # noqa: PLR0913  (each is an option)
    run: Folder,
    quantity: str,
    path: str | Path | None = None,
    *,
    over: str | None = None,
    realization: int | None = None,
    speed: float | None = None,
    column: str | None = None,
    zoom: tuple[tuple[float, float], tuple[float, float]] | None = None,
    side_by_side: bool = False,
    title: bool = True,
    size: tuple[float, float] | None = None,
    dpi: int = 160,
    csv: str | Path | None = None,
) -> Path:
    """Draw a map or a curve of a run, or an observable of a study, and return the path of the picture.

    Parameters
    ----------
    run : Run, Study, str or Path
        The run, the study, or its folder. Damaged members of a run are left out.
    quantity : str
        Maps: "heights", "pressure", "temperature", "seen", "heat_flux", "snapshots". Curves of one member or of all:
        "distribution", "profile", "spectrum", "correlation", "sliding", "reaction". Curves over theory, of all members:
        "psd", which is C(q) and C_sm(q), and each observable over the speed, such as "flash_temperature" or, of a scene
        that asks, "reaction_rate". Of a study: an observable.
    path : str or Path, optional
        Ends in .png, .pdf or .svg. Default: a .png beside the folder.
    over : str, optional
        Of a study, the axis: "speed", or the name of a varied number. Default: the first varied number.
    realization, speed, column, zoom, side_by_side : optional
        Of maps and members: index of a realization with kept fields, speed in m/s, column as in `Run.estimate`,
        ends of a part along x and y in m, and whether heights and pressure stand beside the map.
    title, size, dpi, csv : optional
        Whether the picture has a title; width and height of one row of panels, inches (panels of a narrow picture stand
        below one another); pixels per inch of a .png; a file for the numbers drawn, .csv.

    Raises
    ------
    ValueError
        If an argument is unknown or does not fit the quantity, or if the field was not kept.
    RecordError
        If the folder is no run and no study.
    """
    look = Look(title, size, dpi, csv)
    record = opened(run, "skip")
    options: dict[str, Any] = {
        "realization": realization,
        "speed": speed,
        "column": column,
        "zoom": zoom,
        "side_by_side": side_by_side or None,  # None is left out
    }
    if isinstance(record, Study):
        _refuse(options, f"{record.folder} is a study")
        place = beside(record.folder, quantity) if path is None else Path(path)
        draw_study(record, usual_choice(record, quantity, over), place, look)
        return place
    if over is not None:
        raise ValueError(f"over = {over!r} is for studies; leave it out")
    if quantity in (PSD, *OVER_SPEED):
        _refuse(options, f"{quantity} is of all members")
        return _plot_curve(record, quantity, path, look)
    if quantity in ABOUT and quantity not in asked_names(record.scene):
        raise record.not_asked(quantity)
    if quantity not in QUANTITIES:
        if quantity in record.observables:
            raise ValueError(
                f"{quantity} is one number, not a curve over the speed; `compare --all` prints it, and "
                f"`plot STUDY {quantity}` draws it over the keys of a study"
            )
        known = ", ".join(
            (*QUANTITIES, PSD, *(name for name in OVER_SPEED if name in record.observables))
        )
        raise ValueError(f"quantity = {quantity!r} cannot be drawn; choose one of {known}")
    return plot_run(record, quantity, path, look=look, **options)


def _refuse(options: Mapping[str, object], reason: str) -> None:
    """Raise ValueError if an option is given that does not fit."""
    given = [name for name, value in options.items() if value is not None]
    if given:
        raise ValueError(f"{', '.join(given)}: {reason}; leave it out")


def _plot_curve(run: Run, quantity: str, path: str | Path | None, look: Look) -> Path:
    """Draw a curve of all members over the theory."""
    place = beside(run.folder, quantity) if path is None else Path(path)
    check_ending(place)
    if quantity != PSD and quantity not in run.observables:
        raise run.not_asked(quantity)
    results = results_of(run, [] if quantity == PSD else [quantity])
    entry = Entry(run.folder.resolve().name, run.scene, run, results)
    curves_chart(place, [entry], [quantity], title=f"{run.scene.title}: {run.extent}", look=look)
    return place
