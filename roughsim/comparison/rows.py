"""The rows of a comparison: each observable at each speed by theory and in each column, and the ratios of columns."""

import warnings
from collections.abc import Iterator, Sequence
from math import log, nan
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.comparison.row import NOTHING, Cell, Ratio, Row
from roughsim.estimate import fields
from roughsim.estimate.errors import Estimate, Uncertain, quantile, quotient, spread
from roughsim.estimate.levels import Values
from roughsim.grid import Array, Grid, modes_between
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.sliding import SlidingPrediction
from roughsim.prediction.values import Predicted
from roughsim.results.answers import AT_CUT_OFF, IDENTITY, notes_of
from roughsim.results.run import Run
from roughsim.scene.numerics import SLIDING
from roughsim.surface.spectrum import TruncatedSpectrum

FLASH, _OVER_TWIN = (
    "flash_temperature",
    "map_over_gaussian_twin",
)  # of the rows of a map that is pressed
CONTACT_TEMPERATURE = "contact_temperature"  # T₀(t) + T_flash, of scenes with a duration
_BIN_WIDTH, _LEAST_BINS = (
    0.12,
    12,
)  # of the stress spectrum, in ln q; least number of bins for a slope


class Slope(NamedTuple):
    """d ln|σ_q|²/d ln q of a column from `low` to `high`, rad/m; `error` is statistical, 95 %."""

    column: str
    low: float
    high: float
    measured: float
    error: float
    theory: float


def rows_of(
    run: Run, observables: Sequence[str] | None = None, theories: dict[str, Predicted] | None = None
) -> Iterator[Row]:
    """Yield a row for each observable, or for some of them, and speed; `theories` are those of `theories_of`.

    Of all observables the contact temperatures follow, if the scene has a duration, and the rows that it asks for.
    """
    theories = theories_of(run) if theories is None else theories
    slid = None if run.numerics.slide is None else prediction.sliding_prediction(run.scene)
    names = run.observables if observables is None else observables
    asks = slid is not None and any(OBSERVABLES[name].asked for name in names)
    quantiles = fields.quantiles(run.scene, sliding=True) if asks else {}
    drawn = {name: estimate.mean for name, estimate in quantiles.items()}
    for observable in names:
        predicted = {name: values[observable] for name, values in theories.items()}
        estimates = {name: run.estimate(observable, name) for name in run.numerics.columns}
        if run.numerics.slide is not None and observable in run.slid_observables:
            estimates[SLIDING] = run.estimate(observable, SLIDING)
        ratios = ratios_of(
            run, observable, predicted["theory_same_modes"], predicted["theory_at_cut_off"]
        )
        sliding = _theory_of_sliding(slid, observable, predicted["calibrated"])
        yield from _rows_of_one(
            run, observable, predicted, estimates, ratios, drawn.get(observable, sliding)
        )
    if observables is not None:
        return
    if run.scene.sliding.duration is not None:
        flash = {name: values[FLASH] for name, values in theories.items()}
        yield from _rows_of_contact_temperature(run, flash, slid)
    if run.scene.distribution:
        yield from _rows_that_are_asked(run)
    yield from _rows_of_directions(run)


def theories_of(run: Run) -> dict[str, Predicted]:
    """Return the theories of a run by the field of a row."""
    grid, q_c = finest(run)
    drawn = TruncatedSpectrum(prediction.smoothed_spectrum(run.scene), q_c)
    with warnings.catch_warnings():
        # the longest waves of C(q) represent the longest of a map, and the plan says which its own cell has
        if not run.drawn or run.scene.numerics.lengths is None:
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        summed = prediction.mode_sums(run.scene, drawn, grid)
    return {
        "theory": prediction.predictions(run.scene),
        "theory_same_modes": summed,
        "theory_at_cut_off": prediction.predictions(run.scene, q_c),
        "calibrated": fields.calibrated_predictions(run.scene),
    }


def _rows_of_contact_temperature(
    run: Run, flash: dict[str, Array], slid: SlidingPrediction | None
) -> Iterator[Row]:
    """Yield T₀ + T_flash at each speed from T_flash of the theories."""
    background = prediction.background(run.scene)
    predicted = {name: values + background for name, values in flash.items()}
    columns = (
        run.numerics.columns if run.numerics.slide is None else (*run.numerics.columns, SLIDING)
    )
    estimates = {name: run.contact_temperature(name, background) for name in columns}
    ratios = ratios_of(
        run, FLASH, predicted["theory_same_modes"], predicted["theory_at_cut_off"], background
    )
    sliding = _theory_of_sliding(slid, CONTACT_TEMPERATURE, predicted["calibrated"])
    yield from _rows_of_one(run, CONTACT_TEMPERATURE, predicted, estimates, ratios, sliding)


def _rows_that_are_asked(run: Run) -> Iterator[Row]:
    """Yield the rows of a reaction at each energy and speed, and of the heat above each temperature."""
    columns = run.numerics.columns
    names = [f"{columns[0]}_over_theory", *(f"{columns[1]}_over_{columns[0]}" for _ in columns[1:])]
    ratios = {name: Ratio(nan, nan) for name in names}
    predicted = {asked.key: asked.estimate.mean for asked in fields.asked(run.scene)}
    slid = {}
    if run.numerics.slide is not None:
        slid = {asked.key: asked.estimate.mean for asked in fields.asked(run.scene, sliding=True)}
    nothing = np.full(len(run.scene.speeds), nan)
    columns = run.reacting_columns
    for together in zip(*(run.reactions(column) for column in columns), strict=True):
        first = together[0].estimate
        calibrated, sliding = (values.get(together[0].key, nothing) for values in (predicted, slid))
        for k, speed in enumerate(run.scene.speeds):
            cells = {
                column: _cell_of(asked.estimate, k)
                for column, asked in zip(columns, together, strict=True)
            }
            if run.numerics.slide is not None:
                cells.setdefault(SLIDING, NOTHING)
            yield Row(
                first.observable,
                first.unit,
                speed,
                *(nan, nan, nan, float(calibrated[k])),
                columns=cells,
                ratios=ratios,
                note=AT_CUT_OFF
                if any("bandwidth" in cell.unknown for cell in cells.values())
                else "",
                sliding_calibrated=float(sliding[k]),
                energy=together[0].energy,
                temperature=together[0].temperature,
            )


def _rows_of_directions(run: Run) -> Iterator[Row]:
    """Yield T_flash of a map in each measured direction of sliding, and T_flash of the map over its Gaussian twin.

    There is no theory of them, and one twin shows no scatter: its error is unknown.
    """
    column = run.column(None)
    estimates = {f"{FLASH}_{name}": run.in_direction(name, column) for name in run.angles}
    without = {f"{column}_over_theory": Ratio(nan, nan)}
    for name, estimate in estimates.items():
        for k, speed in enumerate(run.scene.speeds):
            cells = {column: _cell_of(estimate, k)}
            yield Row(name, "K", speed, nan, nan, nan, nan, columns=cells, ratios=without, note="")
    if run.over_twin is not None:
        for speed, ratio in zip(run.scene.speeds, run.over_twin.tolist(), strict=False):
            cells = {column: Cell(ratio, nan, nan)}
            yield Row(
                _OVER_TWIN, "1", speed, nan, nan, nan, nan, columns=cells, ratios=without, note=""
            )


def _rows_of_one(
    run: Run,
    observable: str,
    predicted: dict[str, Array],
    estimates: dict[str, Estimate],
    ratios: dict[str, Uncertain],
    sliding: Array,
) -> Iterator[Row]:
    """Yield a row for each speed of an observable.

    `predicted` has its theories by the field of a row, with all heat in the moving body; `estimates` its columns, and
    `sliding` the theory of the column sliding.
    """
    record = OBSERVABLES[FLASH if observable == CONTACT_TEMPERATURE else observable]
    shares = dict.fromkeys(predicted, run.heat_partition) | {
        "calibrated": prediction.calibrated_share(run.scene)
    }
    if not record.heated:
        shares = dict.fromkeys(predicted, np.ones(len(run.scene.speeds)))
    notes = [notes_of(run, name, estimates[name]) for name in run.numerics.columns]
    for k, speed in enumerate(run.scene.speeds if record.per_speed else (None,)):
        cells = {name: _cell_of(estimate, k) for name, estimate in estimates.items()}
        if run.numerics.slide is not None:
            cells.setdefault(SLIDING, NOTHING)
        here = {of_column[k] for of_column in notes}
        yield Row(
            observable,
            record.unit,
            speed,
            **{name: float(values[k] * shares[name][k]) for name, values in predicted.items()},
            sliding_calibrated=float(sliding[k]),
            columns=cells,
            ratios={name: _ratio_of(ratio, k) for name, ratio in ratios.items()},
            note=next((note for note in (IDENTITY, AT_CUT_OFF) if note in here), ""),
        )


def _theory_of_sliding(slid: SlidingPrediction | None, name: str, frozen: Array) -> Array:
    """Return the calibrated theory of two sliding bodies for the column sliding; NaN without one.

    `frozen` are the values of the calibrated law for a frozen contact.
    """
    nothing = np.full(frozen.shape, nan)
    if slid is None:
        return nothing
    return frozen if name == "contact_fraction" else getattr(slid, name, nothing)


def _cell_of(estimate: Estimate, k: int) -> Cell:
    """Return entry k of an estimate."""
    parts = (estimate.mean, estimate.standard_error, estimate.bias, estimate.total_error)
    mean, error, bias, total = (float(x[k]) for x in parts)
    return Cell(mean, error, bias, total, estimate.unknown_at(k))


def _ratio_of(quotient: Uncertain, k: int) -> Ratio:
    """Return entry k of a quotient of two columns."""
    value, error, total = (
        float(x[k]) for x in (quotient.mean, quotient.standard_error, quotient.total_error)
    )
    return Ratio(value, error, total, quotient.unknown_at(k))


def finest(run: Run) -> tuple[Grid, float]:
    """Return a grid of the run's cell with the pixel of the first column's finest level, and its cut-off, rad/m.

    Levels without sound members are ignored.
    """
    level = run.numerics.levels[run.pairs(run.numerics.columns[0])[-1].level]
    return Grid(
        (level.parts * level.shape[0], level.parts * level.shape[1]), run.numerics.lengths
    ), level.q_max


def ratios_of(
    run: Run, observable: str, summed: Array, integral: Array, background: Array | None = None
) -> dict[str, Uncertain]:
    """Return the first column over the theory and, for capped scenes, capped over smoothed.

    The difference of the sum over the modes from the integral counts as an error by the finite cell, though contacts
    are less sensitive to it than the sum. `background`, (speeds,), is an exact number added to the columns.
    """
    columns = run.numerics.columns
    first = _values_of(run, observable, columns[0], background, extrapolated=False)
    with np.errstate(all="ignore"):  # 0/0 at rest
        apart = np.nan_to_num(summed / integral - 1.0, nan=0.0, posinf=0.0, neginf=0.0)
    # the theory uses the C(q) of the scans, also if the map itself is pressed
    result = {
        f"{columns[0]}_over_theory": quotient(first, summed, size=apart, scanned=run.scene.scanned)
    }
    if len(columns) > 1:
        below, above = (_values_of(run, observable, column, background) for column in columns)
        result[f"{columns[1]}_over_{columns[0]}"] = quotient(above, below, scanned=run.scanned)
    return result


def _values_of(
    run: Run, observable: str, column: str, background: Array | None, *, extrapolated: bool = True
) -> Values:
    """Return the values of a column with the background added."""
    values = run.values(observable, column, extrapolated=extrapolated)
    warm = 0.0 if background is None else background
    return values._replace(mean=values.mean + warm, finest=values.finest + warm)


def stress_slope(run: Run, column: str | None = None) -> Slope | None:
    """Return the slope of |σ_q|² at the finest level of a column; that level needs two sound members.

    With C ∝ q^(−2−2H) full contact has |σ_q|² ∝ q^(−2H). Loss of contact gives P ∝ 1/√G ∝ q^(H−1), so that the slope of
    the theory tends to −(1 + H) in a long band. The error does not include the effect of a finite pixel.

    The band extends from the last kink of C(q) to q_c, or to the yield wavenumber. None if the band is too short for a
    slope, as in steels that yield below q_roll_off.
    """
    name, scene = run.column(column), run.scene
    pair = run.pairs(name)[-1]
    low, high = scene.spectrum.breaks[-2], pair.sample.q_max
    if not scene.elastic:
        high = min(high, prediction.yield_wavenumber(scene))
    bins = int(log(high / low) / _BIN_WIDTH)
    if bins < _LEAST_BINS:
        return None
    # number of modes of the plane in each bin of ln q, and their mean ln q
    band = log(low), log(high)
    grid = run.numerics.grid(pair.level)
    modes = modes_between(grid)
    log_q, many = np.log(modes.wavenumber), modes.multiplicity
    count, sums = (
        np.histogram(log_q, bins, band, weights=weights)[0] for weights in (many, many * log_q)
    )
    filled = count > 0.0
    center = sums[filled] / count[filled]
    # least squares of ln|σ_q|² over ln q: the slope is a weighted sum; to first order so is its scatter
    x = center - center.mean()
    weights = x / (x @ x)
    area = count[filled] * 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    entries = np.log(pair.sample.wavenumber)
    spectra = [np.histogram(entries, bins, band, weights=row)[0] for row in pair.sample.spectrum]
    rows = np.stack(spectra)[:, filled] / area
    mean = rows.mean(axis=0)
    error, freedom = spread((rows / mean @ weights)[:, None])
    predicted = np.log(prediction.stress_spectrum(scene, np.exp(center)))
    half_width = float(error[0] * quantile(freedom[0]))
    return Slope(
        name, low, high, float(weights @ np.log(mean)), half_width, float(weights @ predicted)
    )
