"""The results of a run: every observable in every column, as `Results`.

A column is a theory, a simulation, or the ratio of two columns. Here is one function of an observable for each column:
a new column is a new entry of `columns_of`, and a theory that needs no run one of `roughsim.results.theories`.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from roughsim import prediction
from roughsim.estimate.asked import ABOUT, asked_names
from roughsim.estimate.errors import quotient, speed_axis
from roughsim.estimate.levels import FLASH
from roughsim.estimate.mean import Mean
from roughsim.grid import Array, Grid
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.values import Predicted
from roughsim.results.arrays import attributes_of
from roughsim.results.run import Run
from roughsim.results.table import Results
from roughsim.results.theories import (
    CALIBRATED,
    CONTACT_TEMPERATURE,
    SLIDING_CALIBRATED,
    THEORIES,
    THEORY,
    ColumnOf,
    joined,
    of_theory,
    theory_columns,
    with_share,
)
from roughsim.scene.numerics import SLIDING
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.table import Estimate, concat

SAME_MODES, UP_TO_CUT_OFF = "theory_same_modes", "theory_at_cut_off"
BY_DIRECTION = "flash_temperature_by_direction"  # of a pressed map
OVER_TWIN = "map_over_gaussian_twin"  # T_flash of a map over that of maps of random phases
_ABOUT = {"angle": {"units": "rad", "description": "of sliding, from x towards y"}}
MEANINGS = THEORIES | {
    SAME_MODES: "the theory summed over the modes of the simulated cell, up to q_c",
    UP_TO_CUT_OFF: "the theory over C(q) up to q_c",
    "smoothed": "simulated elastic contact of surfaces with the smoothed spectrum C_sm(q)",
    "capped": "simulated contact, in which the pressure never exceeds the hardness",
    "elastic": "simulated elastic contact",
    SLIDING: "simulated contact of two rough faces that slide over one another, with its own share of the heat",
    SLIDING_CALIBRATED: "the calibrated theory of two rough faces that slide over one another",
}


def is_theory(column: str) -> bool:
    """Return whether a column is a theory."""
    return column in (*THEORIES, SAME_MODES, UP_TO_CUT_OFF, SLIDING_CALIBRATED)


def is_ratio(column: str) -> bool:
    """Return whether a column is the ratio of two."""
    return "_over_" in column


def estimated_columns(run: Run) -> dict[str, ColumnOf]:
    """Return the columns of the tidy table: theories of all of C(q), and simulations."""
    columns = columns_of(run).items()
    return {name: one for name, one in columns if name in THEORIES or is_simulated(name)}


def is_simulated(column: str) -> bool:
    """Return whether a column is a simulation."""
    return not (is_theory(column) or is_ratio(column))


def meaning(column: str) -> str:
    """Return a column in words."""
    above, _, below = column.partition("_over_")
    if below == THEORY:
        return f"ratio of {above} up to q_c to {SAME_MODES}, without a unit"
    return MEANINGS[column] if not below else f"ratio of {above} to {below}, without a unit"


def heat_shares(run: Run) -> Array:
    """Return the share of the heat in the temperatures of each column, (columns, speeds); NaN where it has none."""
    shares = dict.fromkeys((THEORY, SAME_MODES, UP_TO_CUT_OFF), run.heat_partition)
    shares[CALIBRATED] = prediction.calibrated_share(run.scene)
    shares |= {column: run.simulated(column).share for column in run.simulated_columns}
    nothing = np.full(len(run.scene.speeds), np.nan)
    return np.array([shares.get(column, nothing) for column in columns_of(run)])


def results_of(
    run: Run,
    observables: Sequence[str] | None = None,
    columns: Mapping[str, ColumnOf] | None = None,
) -> Results:
    """Return observables of a run, by default all, in columns of it, by default `columns_of`.

    ValueError if the run has no sound realization.
    """
    names = observables_of(run) if observables is None else observables
    estimates = joined(columns or columns_of(run), names, run.scene.directions)
    along = {}
    if BY_DIRECTION in estimates:
        along["angle"] = "direction", np.array([*run.angles.values()])
    about = _ABOUT | ({"direction": _ABOUT["angle"]} if run.scene.directions else {})
    return Results(estimates, attributes_of(run.members), about, along)


def observables_of(run: Run) -> list[str]:
    """Return the names of all observables of a run, in the order of tables."""
    names = list(run.observables)
    if run.scene.sliding.warms:
        names.append(CONTACT_TEMPERATURE)
    names += asked_names(run.scene)
    if not run.drawn:
        names += [BY_DIRECTION, OVER_TWIN]
    elif run.map_ratio is not None:
        names.append(OVER_TWIN)
    return names


def columns_of(run: Run) -> dict[str, ColumnOf]:
    """Return the columns of a run in their order, each as a function of the name of an observable."""
    first, *others = run.numerics.columns
    theories, theory = theory_columns(run.scene), cache(partial(theory_of, run))
    share = partial(getattr, run, "heat_partition")
    columns: dict[str, ColumnOf] = {THEORY: theories[THEORY]}
    for name in (SAME_MODES, UP_TO_CUT_OFF):
        columns[name] = partial(of_theory, run.scene, partial(theory, name), share)
    columns |= {name: theories[name] for name in THEORIES}
    for name in run.simulated_columns:
        columns[name] = partial(_simulated, run, name, cache(partial(run.reactions, name)))
    if run.numerics.slide is not None:
        columns[SLIDING_CALIBRATED] = theories[SLIDING_CALIBRATED]
    columns[f"{first}_over_theory"] = partial(_over_theory, run, first, theory)
    for name in others:
        columns[f"{name}_over_{first}"] = partial(_over_column, run, name, first)
    return columns


def finest(run: Run) -> tuple[Grid, float]:
    """Return a grid of the run's cell with the pixel of the first column's finest level, and its cut-off, rad/m.

    Levels without sound members are ignored.
    """
    level = run.numerics.levels[run.samples(run.numerics.columns[0])[-1].level]
    nx, ny = level.shape
    return Grid((level.parts * nx, level.parts * ny), run.numerics.lengths), level.q_max


def theory_of(run: Run, column: str) -> Predicted:
    """Return the theory of a column up to the cut-off of a run, with all heat in the moving body."""
    grid, q_c = finest(run)
    if column == UP_TO_CUT_OFF:
        return prediction.predictions(run.scene, q_c)
    drawn = TruncatedSpectrum(prediction.smoothed_spectrum(run.scene), q_c)
    with warnings.catch_warnings():
        # the longest waves of C(q) represent the longest of a map, and the plan says which its own cell has
        if not run.drawn or run.scene.numerics.lengths is None:
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        return prediction.mode_sums(run.scene, drawn, grid)


def _simulated(
    run: Run, column: str, asked: Callable[[], Mapping[str, Estimate]], observable: str
) -> Estimate | None:
    """Return an observable of a simulated column; None for one that it has not stored."""
    if observable == CONTACT_TEMPERATURE:
        return replace(run.contact_temperature(column), observable=observable)
    if observable in (BY_DIRECTION, OVER_TWIN):
        return _of_map(run, observable, column)
    stored = run.simulated(column)
    if observable in ABOUT:
        return asked().get(observable) if stored.reacts else None
    return run.estimate(observable, column) if observable in stored.observables else None


def _of_map(run: Run, observable: str, column: str) -> Estimate | None:
    """Return T_flash of a map by direction, or over maps of random phases; None while parts are missing."""
    if observable == OVER_TWIN:
        twin, beside, budget = run.over_twin, run.map_ratio, {}  # of one twin: it shows no scatter
        if beside is not None and not beside.reason and column == run.column(None):
            twin, budget = beside.ratio, {"statistical": beside.error}
        if twin is None:
            return None
        axis = speed_axis(observable, twin, run.scene.speeds)
        return Estimate.of(observable, "1", twin, axis, budget)
    pieces = {(k,): run.in_direction(name, column) for k, name in enumerate(run.angles)}
    if not pieces:
        return None
    return replace(concat(pieces, {"direction": np.array([*run.angles])}), observable=observable)


def _over_theory(
    run: Run, column: str, theory: Callable[[str], Predicted], observable: str
) -> Estimate | None:
    """Return the ratio of a column to the theory of the same modes, both up to q_c, with all heat in one body.

    The difference of the sum over the modes from the integral counts as an error by the finite cell, though contacts
    are less sensitive to it than the sum.
    """
    values = _values_of(run, observable, column, extrapolated=False)
    if values is None:
        return None
    summed, integral = (
        np.asarray(with_share(run.scene, theory(name), observable, np.ones(1)))
        for name in (SAME_MODES, UP_TO_CUT_OFF)
    )
    with np.errstate(all="ignore"):  # 0/0 at rest
        apart = np.nan_to_num(summed / integral - 1.0, nan=0.0, posinf=0.0, neginf=0.0)
    # the theory uses the C(q) of the scans, also if the map itself is pressed
    ratio = quotient(values, summed, size=apart, scanned=run.scene.scanned)
    return _named(run, ratio, observable)


def _over_column(run: Run, column: str, below: str, observable: str) -> Estimate | None:
    """Return the ratio of two simulated columns with all heat in one body."""
    above, base = (_values_of(run, observable, name) for name in (column, below))
    if above is None or base is None:
        return None
    return _named(run, quotient(above, base, scanned=run.scanned), observable)


def _named(run: Run, ratio: Estimate, observable: str) -> Estimate:
    """Return a ratio as an entry of an observable."""
    axis = speed_axis(observable, ratio.mean, run.scene.speeds)
    return replace(ratio, observable=observable, coords=axis)


def _values_of(run: Run, observable: str, column: str, *, extrapolated: bool = True) -> Mean | None:
    """Return the values of a column with all heat in the moving body; None for what has no ratio."""
    if observable == CONTACT_TEMPERATURE:
        flash = run.values(FLASH, column, extrapolated=extrapolated)
        return flash + prediction.background(run.scene)
    if observable not in OBSERVABLES:
        return None
    return run.values(observable, column, extrapolated=extrapolated)
