"""What a finite cell changes: the same scenes in cells of 2, 4, 8 and 16 waves per side, at equal pixel and cut-off.

    python experiments/cell_size.py [--toy] [-o FOLDER] [--only NAME ...] [--work POINTS] [--parts]

Scenes are made by hand or drawn at random: σ₀/σ_P .001 … .5, H .4 … .9, q_y 1.5 to 30 times the wavenumber of the waves
that count (the longest, or those of the roll-off where C(q) is flat below it), capped contact, contact on the smoothed
C(q), and elastic contact. T_flash at three speeds, area, variance of the pressure and r(g = 0.5) are means over so many
members as make POINTS points, at the mean peak volume. Printed is, in %, what each cell lacks of the largest, ± its
standard error, and the same by the model of `estimate.cell_size`. With --parts: what one step of the cut-off, from
4 q_y, changes in cells of 1, 2, 4, and 8 waves. Rows in FOLDER are not computed again; all take three hours of a core.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import exp, log, pi, sqrt
from pathlib import Path

import numpy as np
import scipy.optimize
import scipy.special
from matplotlib.figure import Figure
from numpy.typing import NDArray
from script import Command, Row, Rows

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.cell_size import size_error

Array = NDArray[np.float64]
Compared = list[
    tuple[str, Array, Array, float]
]  # column, what cells lack, its standard error, and the model's
PIXELS, LEAST, MOST = 4, 24, 20_000  # pixels per shortest wave; members of a cell
MOST_SIDE = 1100  # points per side of a grid
CUT_OFF = {
    "capped": 2.0,
    "smoothed": 1.5,
    "elastic": 1.0,
}  # q_y, or q_max: the effect hardly depends on it
FIRST = {
    "capped": 4.0,
    "elastic": 0.25,
}  # from where a step of the cut-off is taken, in the same unit
Q_WAVE = 6350.0  # of the waves that count, rad/m
WAVE = 2 * pi / Q_WAVE  # m
DIFFUSIVITY = 30.0 / (7900.0 * 500.0)  # m²/s
OBSERVED = ("T slow", "T middle", "T fast", "area", "variance", "r_50")


@dataclass(frozen=True)
class Case:
    """A scene by its ratios."""

    name: str
    load: float  # σ₀/σ_P; of elastic contact σ₀/(E* rms slope)
    band: float  # q_y, or q_max of elastic contact, over the wavenumber of the waves that count
    hurst: float
    flat: float = 1.0  # q_roll_off/q_min
    exponent: float = 0.0  # C(q) falls as q^(−exponent) below q_roll_off

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are measured."""
        return ("elastic",) if "elastic" in self.name else ("capped", "smoothed")


BY_HAND = (
    Case("light", 0.003, 3.0, 0.8),
    Case("light .01", 0.01, 3.0, 0.8),
    Case("light r8", 0.003, 8.0, 0.8),
    Case("light H.5", 0.003, 3.0, 0.5),
    Case("mid r3", 0.05, 3.0, 0.8),
    Case("heavy r3", 0.3, 3.0, 0.8),
    Case("heavy r15", 0.4, 15.0, 0.6),
    Case("steel", 0.075, 8.0, 0.8, 14.8, 1.5),
    Case("flat light", 0.003, 3.0, 0.8, 16.0),
    Case("flat heavy", 0.2, 6.0, 0.8, 16.0),
    Case("tiny r1.5", 0.001, 1.5, 0.8),
    Case("tiny r20", 0.001, 20.0, 0.8),
    Case("elastic light", 0.005, 12.0, 0.8),
    Case("elastic mid", 0.1, 12.0, 0.7),
    Case("steel light", 0.001, 8.0, 0.8, 14.8, 1.5),
    Case("roll light", 0.003, 6.0, 0.8, 4.0, 1.5),
    Case("elastic long", 0.0038, 48.0, 0.8),
)
DRAWN = (
    *range(12),
    *range(100, 112),
)  # they test the model; its constants are from the scenes made by hand


def drawn(number: int) -> Case:
    """Return a case drawn at random."""
    draw = np.random.default_rng(4000 + number)
    kind = ("plain", "flat", "plain", "roll", "elastic")[number % 5]
    load, band = (
        exp(draw.uniform(log(low), log(high))) for low, high in ((0.001, 0.5), (1.5, 30.0))
    )
    case = Case(f"{kind} {number}", load, band, draw.uniform(0.4, 0.9))
    if kind == "flat" or (kind == "elastic" and number % 10 == 9):
        case = replace(case, flat=exp(draw.uniform(log(2.0), log(32.0))))
    if kind == "roll":
        case = replace(
            case, flat=exp(draw.uniform(log(2.0), log(8.0))), exponent=draw.uniform(1.0, 2.0)
        )
    if kind == "elastic":
        load, band = (
            exp(draw.uniform(log(low), log(high))) for low, high in ((0.003, 0.3), (4.0, 24.0))
        )
        case = replace(case, load=load, band=band)
    return case


def scene_of(case: Case) -> rs.Scene:
    """Return the scene: its rms height is that which has the wanted q_y, or any for elastic contact."""
    elastic, end = "elastic" in case.name, case.band * Q_WAVE
    first = Q_WAVE if case.exponent >= 1.0 else Q_WAVE / case.flat
    face = {"hurst": case.hurst, "q_min": first, "q_max": end * (1.0 if elastic else 64.0)}
    if case.flat > 1.0:
        face |= {"q_roll_off": first * case.flat, "roll_off_exponent": case.exponent}
    body = {
        "youngs_modulus": 2e11,
        "poisson_ratio": 0.3,
        "conductivity": 30.0,
        "density": 7900.0,
        "heat_capacity": 500.0,
    }
    body |= {} if elastic else {"penetration_hardness": 2e9}
    speeds = [factor * DIFFUSIVITY * end for factor in (0.01, 3.0, 300.0)]

    def scene(log_height: float, pressure: float) -> rs.Scene:
        sliding = {"friction_coefficient": 0.1, "speed": speeds, "nominal_pressure": pressure}
        return rs.load_scene(
            {"surface": face | {"rms_height": exp(log_height)}, "body": body, "sliding": sliding}
        )

    if elastic:
        some = scene(log(1e-6), 1e6)
        return scene(log(1e-6), case.load * some.effective_modulus * some.spectrum.rms_slope)

    def excess(log_height: float) -> float:
        yields = prediction.yield_wavenumber(scene(log_height, case.load * 2e9))
        return log(min(yields, 60.0 * end) / end)

    return scene(scipy.optimize.brentq(excess, log(1e-9), log(1e-3), xtol=1e-4), case.load * 2e9)


def fast_size(points: float) -> int:
    """Return an even size of small primes, near to so many points."""
    sizes = (2**a * 3**b * 5**c for a in range(1, 13) for b in range(3) for c in range(2))
    return min(size for size in sizes if size >= 0.97 * points)


def row_of(solution: rs.Solution) -> list[float]:
    found = solution.observables
    return [*found.flash_temperature, found.contact_fraction_corrected, found.pressure_variance]


def cell(scene: rs.Scene, case: Case, column: str, waves: int, work: float) -> Row:
    """Return means over the members of one cell, and their relative standard errors."""
    side = fast_size(PIXELS * waves * CUT_OFF[column] * case.band)
    level = rs.Level(column, (side, side), CUT_OFF[column] * case.band * Q_WAVE)
    numerics = rs.Numerics((level,), (waves * WAVE,) * 2)
    count = int(np.clip(work / side**2, LEAST, MOST))
    members = (rs.realize(scene, numerics, seed=11, index=index) for index in range(count))
    every = [(row_of(each), each.peak_volume, each.observables.stress_spectrum) for each in members]
    last, spectra = every[-1][2], np.stack([spectrum.variance for _, _, spectrum in every])
    # r(g = 0.5) of the mean spectrum, and what each member moves it by
    mean, q = spectra.mean(axis=0), last.wavenumber
    radius = replace(last, variance=mean).correlation_radius(0.5)
    moved = (
        spectra @ (scipy.special.j0(q * radius) - 0.5) / ((mean * q) @ scipy.special.j1(q * radius))
    )
    rows = np.column_stack([[row for row, _, _ in every], radius + moved])
    # at the mean peak volume, whose mean over surfaces is zero
    design = np.column_stack([np.ones(count), [volume for _, volume, _ in every]])
    fit = np.linalg.lstsq(design, rows, rcond=None)[0]
    error = np.linalg.norm(rows - design @ fit, axis=0) / sqrt((count - design.shape[1]) * count)
    return {
        "n": count,
        "side": side,
        "mean": fit[0].tolist(),
        "error": (error / np.abs(fit[0])).tolist(),
    }


def correction(scene: rs.Scene, case: Case, waves: int, work: float) -> Row:
    """Return what a step of the cut-off changes, as a ratio of means on the same surfaces, and its standard error."""
    side, q = (
        fast_size(PIXELS * waves * FIRST[case.columns[0]] * case.band),
        FIRST[case.columns[0]] * case.band * Q_WAVE,
    )
    low, high = (
        rs.Numerics((rs.Level(case.columns[0], (k * side, k * side), k * q),), (waves * WAVE,) * 2)
        for k in (1, 2)
    )
    count = int(np.clip(work / (2 * side) ** 2, LEAST, MOST))
    pairs = np.array(
        [
            [row_of(rs.realize(scene, each, seed=12, index=i)) for each in (low, high)]
            for i in range(count)
        ]
    )
    below, above = pairs.mean(axis=0)
    change = pairs[:, 1] / above - pairs[:, 0] / below
    error = above / below * change.std(axis=0, ddof=1) / sqrt(count)
    return {"n": count, "side": 2 * side, "mean": (above / below).tolist(), "error": error.tolist()}


def lacks(found: dict[int, Row]) -> dict[int, tuple[Array, Array]]:
    """Return what each cell but the largest has less than that one, relative, and the standard error."""
    largest = found[max(found)]
    return {
        waves: (
            1 - np.divide(row["mean"], largest["mean"]),
            np.hypot(row["error"], largest["error"]),
        )
        for waves, row in found.items()
        if row is not largest
    }


def modelled(scene: rs.Scene, column: str, waves: int, most: int) -> float:
    """Return the same by the model, for any observable."""
    few, many = (1 - size_error(scene, (n * WAVE, n * WAVE), column=column) for n in (waves, most))
    return 1 - few / many


def chart(points: Compared, path: Path) -> None:
    """Draw measured over modelled errors of T_flash."""
    figure = Figure((6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for column in CUT_OFF:
        some = [each for each in points if each[0] == column]
        if some:
            found, error = (100 * np.concatenate([each[i][:3] for each in some]) for i in (1, 2))
            model = 100 * np.repeat([each[3] for each in some], 3)
            axes.errorbar(model, found, yerr=error, fmt="o", ms=3, lw=0.7, label=column)
    line = np.geomspace(0.01, 60, 50)
    axes.plot(line, line, color="0.5", lw=0.8)
    axes.plot(line, -line, color="0.5", lw=0.8)
    axes.set_xscale("log")
    axes.set_yscale("symlog", linthresh=0.1)
    axes.set(xlabel="by the model (%)", ylabel="T_flash lacks of the largest cell (%)")
    axes.legend(frameon=False)
    figure.savefig(path, dpi=130)


def compare(case: Case, column: str, rows: Rows, work: float, sizes: Sequence[int]) -> Compared:
    """Compute what is missing of a column; print, and return, measured and modelled errors of its cells."""
    scene, found = scene_of(case), {}
    for n in sizes:
        if fast_size(PIXELS * n * CUT_OFF[column] * case.band) <= MOST_SIDE:
            compute = partial(cell, scene, case, column, n, work)
            found[n] = rows.once(f"{case.name}, {column}", str(n), compute)
    points = []
    for n, (lack, error) in lacks(found).items():
        model = modelled(scene, column, n, max(found))
        points.append((column, lack, error, model))
        text = " ".join(f"{100 * a:6.2f} ± {100 * b:.2f}" for a, b in zip(lack, error, strict=True))
        print(
            f"{case.name:14s}{column:9s}{n:2d}:{max(found):<3d}{text}; model {100 * model:.2f}",
            flush=True,
        )
    return points


def steps(case: Case, rows: Rows, work: float) -> None:
    """Print what a step of the cut-off changes in each cell."""
    scene = scene_of(case)
    for n in (1, 2, 4, 8):
        if 2 * fast_size(PIXELS * n * FIRST[case.columns[0]] * case.band) <= MOST_SIDE:
            row = rows.once(f"{case.name}, step", str(n), partial(correction, scene, case, n, work))
            pairs = zip(row["mean"], row["error"], strict=True)
            text = " ".join(
                f"{100 * (ratio - 1):7.2f} ± {100 * error:.2f}" for ratio, error in pairs
            )
            print(f"{case.name:14s}step in {n} waves {text}", flush=True)


def main() -> None:
    command = Command(__file__, __doc__, "one scene, few members")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--work", type=float, default=1e8, help="points of all members of a cell")
    command.add_argument(
        "--parts", action="store_true", help="measure corrections in smaller cells"
    )
    options = command.parse()
    warnings.simplefilter("ignore", RuntimeWarning)
    cases = {case.name: case for case in (*BY_HAND, *map(drawn, DRAWN))}
    names = options.only or (["light .01"] if options.toy else list(cases))
    work, sizes = (1e6, (2, 4)) if options.toy else (options.work, (2, 4, 8, 16))
    rows, points = Rows(options.output / "rows.json", resume=True), []
    print(f"columns: {', '.join(OBSERVED)}, in %; the model: T_flash at three speeds, and all else")
    for case in (cases[name] for name in names):
        for column in case.columns:
            points += compare(case, column, rows, work, sizes)
        if options.parts:
            steps(case, rows, work)
    chart(points, options.output / "cell_size.png")


if __name__ == "__main__":
    main()
