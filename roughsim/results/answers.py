"""Results of a run as arrays: every observable in every column with its total error and marks, and both theories.

The marks of a value are the unknown parts of its error, and a note: whether it is at q_c or fixed by force balance.
"""

from collections.abc import Collection, Iterator, Sequence
from math import isfinite

import numpy as np

from roughsim import prediction
from roughsim.estimate import fields
from roughsim.estimate.asked import HEAT_ABOVE, RATE
from roughsim.estimate.errors import Estimate
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, UNITS
from roughsim.results.arrays import SHARE, Labelled
from roughsim.results.reactions import ABOUT, asked_names
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING

_MEANINGS = {
    "theory": "the analytic theory over the whole spectrum C(q)",
    "calibrated": "the theory with a stress spectrum fitted to simulations, with the error of the fit; NaN outside the "
    "range compared with simulations",
    "smoothed": "simulated elastic contact of surfaces with the smoothed spectrum C_sm(q)",
    "capped": "simulated contact, in which the pressure never exceeds the hardness",
    "elastic": "simulated elastic contact",
    SLIDING: "simulated contact of two rough faces that slide over one another, with its own share of the heat",
}
IDENTITY, AT_CUT_OFF = "identity", "at q_c"
_Entry = tuple[
    Array, Array, list[str], list[str]
]  # values, total errors, unknown parts and notes, over speed
TAIL, UNKNOWN, NOTE = (
    "_total_error",
    "_unknown",
    "_note",
)  # suffixes of the arrays beside an observable
TAILS = (
    "NAME_total_error is its error, 95 %, NAME_unknown are the missing parts of this error, and NAME_note marks values "
    "that are not extrapolated (at q_c) or fixed by force balance (identity)."
)


def notes_of(run: Run, column: str, estimate: Estimate) -> list[str]:
    """Return a note on each entry of an estimate of a column: "identity", "at q_c" or "".

    "identity": force balance alone fixes the value, as all contact has yielded. "at q_c": the value has no limit in the
    cut-off, or the levels of the run do not show it, so that it is not extrapolated.
    """
    record = OBSERVABLES[estimate.observable]
    plastic = column in ("capped", SLIDING) and not run.scene.elastic
    if plastic and record.by_force_balance and isfinite(prediction.yield_wavenumber(run.scene)):
        return [IDENTITY] * len(estimate.mean)
    no_limit = np.isnan(estimate.budget.get("bandwidth", np.zeros_like(estimate.mean)))
    no_limit |= plastic and not record.limit  # plastic patches have steep edges
    return [AT_CUT_OFF * bool(cut) for cut in no_limit & ~np.isnan(estimate.mean)]


def meanings(unknown: Collection[str], notes: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each mark that a table has; `unknown` are parts of errors, `notes` are from `notes_of`."""
    if unknown:
        yield f"≥: a part of the error is unknown, as no level of the run shows it ({', '.join(unknown)})."
    if IDENTITY in notes:
        yield "identity: fixed by force balance; its ratios test nothing."
    if AT_CUT_OFF in notes:
        yield "at q_c: no limit in the cut-off, or none that the run shows; its ratios test nothing."


def _columns_of(run: Run) -> list[str]:
    """Return the columns of the comparison that a run has, in their order."""
    slide = run.numerics.slide
    slid = [SLIDING] if slide is not None and run.members.sound(slide) else []
    return ["theory", "calibrated", *run.numerics.columns, *slid]


def answers(run: Run, observables: Sequence[str] | None = None) -> Iterator[Labelled]:
    """Yield the columns, the speeds, the heat share, and observables with their total error, 95 %, and marks.

    They are (column, speed) or (column,). The marks are texts: the unknown parts of the error, and the note of
    `notes_of`. `observables` are all of the run by default. Together follow all reactions and the heat above
    temperatures, if one of them is named; of a pressed map T_flash by the direction of sliding. ValueError if the run
    has no sound realization.
    """
    columns = _columns_of(run)
    yield Labelled(
        "column", ("column",), np.array(columns), {"description": "source of a value, see README"}
    )
    yield Labelled("speed", ("speed",), np.array(run.scene.speeds), {"units": "m/s"})
    slid = [run.estimate("heat_partition", SLIDING).mean] if SLIDING in columns else []
    own = prediction.calibrated_share(run.scene)
    shares = (
        [run.heat_partition, own] + [run.share(column) for column in run.numerics.columns] + slid
    )
    yield Labelled("heat_share_used", ("column", "speed"), np.array(shares), SHARE)
    theories = prediction.predictions(run.scene), fields.calibrated_predictions(run.scene)
    bands = prediction.calibrated(run.scene).errors
    quantiles = fields.quantiles(run.scene)
    names = [*run.observables, *asked_names(run.scene)] if observables is None else observables
    for name in (name for name in names if name not in ABOUT):
        record = OBSERVABLES[name]
        theory, calibrated = (
            by[name] * (heat if record.heated else 1.0)
            for by, heat in zip(theories, shares, strict=False)
        )
        nothing, unmarked = np.full_like(theory, np.nan), [""] * len(theory)
        entries: list[_Entry] = [(theory, nothing, unmarked, unmarked)]
        band = np.abs(calibrated) * bands.get(name, np.nan)
        band = quantiles[name].total_error * shares[1] if name in quantiles else band
        entries.append((calibrated, band, unmarked, unmarked))
        for column in columns[2:]:
            measured = column != SLIDING or name in run.slid_observables
            entries.append(
                _measured(run, name, column) if measured else (nothing, nothing, unmarked, unmarked)
            )
        axes = ("column", "speed") if record.per_speed else ("column",)
        tables = (np.array(table) for table in zip(*entries, strict=True))
        yield from marked(
            name, axes, *(table if record.per_speed else table[:, 0] for table in tables)
        )
    if any(name in ABOUT for name in names):
        yield from _answers_of_reactions(run)
    yield from _answers_of_directions(run)


def _measured(run: Run, observable: str, column: str) -> _Entry:
    """Return mean, total error, unknown parts and notes of an observable in a column."""
    estimate = run.estimate(observable, column)
    unknown = [", ".join(estimate.unknown_at(k)) for k in range(len(estimate.mean))]
    return estimate.mean, estimate.total_error, unknown, notes_of(run, column, estimate)


def _answers_of_reactions(run: Run) -> Iterator[Labelled]:
    """Yield reactions over column, energy and speed, and shares of the heat over column, temperature and speed."""
    columns = _columns_of(run)
    asked = {column: run.reactions(column) for column in run.reacting_columns}
    first = asked[run.numerics.columns[0]]
    asked["calibrated"] = fields.asked(run.scene)
    for name in dict.fromkeys(one.estimate.observable for one in first):
        places = [k for k, one in enumerate(first) if one.estimate.observable == name]
        axis, unit = ("heat_above", "K") if name == HEAT_ABOVE else ("energy", "eV")
        if name in (RATE, HEAT_ABOVE):  # the first on its axis
            numbers = np.array([getattr(first[k], ABOUT[name]) for k in places])
            yield Labelled(axis, (axis,), numbers, {"units": unit})
        shape = len(columns), len(places), len(run.scene.speeds)
        values, errors = np.full(shape, np.nan), np.full(shape, np.nan)
        unknown, notes = np.full(shape, "", object), np.full(shape, "", object)
        for column, of_column in asked.items():
            for j, k in enumerate(places if of_column else ()):
                at, estimate = (columns.index(column), j), of_column[k].estimate
                values[at], errors[at] = estimate.mean, estimate.total_error
                parts = [estimate.unknown_at(n) for n in range(len(estimate.mean))]
                unknown[at] = [", ".join(lacking) for lacking in parts]
                notes[at] = [AT_CUT_OFF if "bandwidth" in lacking else "" for lacking in parts]
        yield from marked(
            name, ("column", axis, "speed"), values, errors, unknown.astype(str), notes.astype(str)
        )


def _answers_of_directions(run: Run) -> Iterator[Labelled]:
    """Yield T_flash of a pressed map in each direction with its error, and over its Gaussian twin; all over speed."""
    for name, angle in run.angles.items():
        estimate, title = run.in_direction(name), f"flash_temperature_{name}"
        about = {"units": "K", "description": f"sliding at {angle:.6g} rad from x towards y"}
        yield Labelled(
            title, ("speed",), estimate.mean, about | {"ancillary_variables": title + TAIL}
        )
        error = {"units": "K", "description": "total error of the mean, 95 %"}
        yield Labelled(title + TAIL, ("speed",), estimate.total_error, error)
    if run.over_twin is not None:
        words = "ratio of T_flash, map over one map of the same |h(q)| with random phases"
        yield Labelled(
            "map_over_gaussian_twin",
            ("speed",),
            run.over_twin,
            {"units": "1", "description": words},
        )


def marked(
    name: str, axes: tuple[str, ...], values: Array, errors: Array, unknown: Array, notes: Array
) -> Iterator[Labelled]:
    """Yield an observable, its error and its marks as arrays over some axes; `unknown` and `notes` are texts."""
    unit = {"units": UNITS[name]}
    parts = ", ".join(
        sorted({part for text in unknown.ravel() for part in str(text).split(", ")} - {""})
    )
    words = {
        TAIL: "total error of the mean, 95 %"
        + (f"; a lower bound if parts of it are unknown ({parts})" if parts else ""),
        UNKNOWN: "unknown parts of the total error",
        NOTE: "identity: fixed by force balance; at q_c: not extrapolated in the cut-off",
    }
    yield Labelled(
        name, axes, values, unit | {"ancillary_variables": " ".join(name + tail for tail in words)}
    )
    yield Labelled(name + TAIL, axes, errors, unit | {"description": words[TAIL]})
    yield Labelled(name + UNKNOWN, axes, unknown, {"description": words[UNKNOWN]})
    yield Labelled(name + NOTE, axes, notes, {"description": words[NOTE]})


def readme(run: Run) -> str:
    """Return the README text of an exported file."""
    columns = _columns_of(run)
    failed = f", {run.failed} of them failed and left out" if run.failed else ""
    levels = [
        f"- level {i}: {level.column} contact, {level.shape[0]} x {level.shape[1]} points{level.where}, "
        f"q_c = {level.q_max:.4g} rad/m."
        for i, level in enumerate(run.numerics.levels)
    ]
    parts = [
        f"{run.scene.title or run.folder.resolve().name}: {run.realizations} realizations{failed}. Units are SI. "
        "Temperatures are above the background, with the share heat_share_used of the heat of both bodies.",
        "The root group holds the results. Each observable is an array over the columns, and over the speed if it "
        f"depends on it. {TAILS} The columns are",
        *(f"- {column}: {_MEANINGS[column]}" for column in columns),
        "The means are extrapolated to all of C(q) if the levels allow it. The raw numbers, one for each level and "
        "realization, are in the group members. Its levels are",
        *levels,
        "Arrays of one level, as pressure_L2, end with its number: spectra, and fields (heights, pressure, and "
        "temperature at the highest speed) of the realizations that kept them. The group entry links to the data for "
        "viewers (NeXus).",
        f'For example in Python, T_flash of column "{columns[-1]}" over the speed: '
        f'h5py.File(NAME)["flash_temperature"][{len(columns) - 1}] or '
        f'xarray.open_dataset(NAME).flash_temperature.sel(column="{columns[-1]}").',
    ]
    return "\n".join(parts)
