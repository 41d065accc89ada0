"""Where methods fail: maps of error, cost and failures of the contact solvers and of the heat kernels.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/where_methods_fail.py [MAP ...] [--resume] [-o F]

Maps: load (contact over load and hardness), roughness (contact over H, bandwidth and pixels per shortest wave), both
for the other solvers too where they are installed (`pip install 'roughsim[peers]'`), heat (T_flash of a Hertz contact
over the Péclet number and the box, three kernels), and theory (T_flash by the theory and by the calibrated law against
the elastic contacts of reference/contacts.json). All by default. --evidence writes docs/evidence/limits.json. Every
solve is a row of data.json; a failure is a row too, and a cross in a map.
"""

from __future__ import annotations

import importlib.util
import json
import sys
import time
import warnings
from itertools import product
from math import inf, isnan, nan
from pathlib import Path

import figures
import numpy as np
from contacts.members import spectrum_of
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim.heat import uniform_temperature
from theory import flash, hertz, persson

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import contact as solvers

TOLERANCE = 1e-6
LONGEST = (
    20.0  # CPU seconds of one solve; a solver that takes longer is not asked with finer pixels
)
NOT_MADE = "one bound only"  # what a solver is not made for is no failure of it
CONTACTS = Path(__file__).parent / "reference" / "contacts.json"
BANDWIDTHS = (4.0, 8.0, 16.0, 32.0, 64.0)
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
SOLVERS = ("roughsim", "tamaas", "ContactMechanics", "NuMPI")


# contact


def unit_problem(points, load, cap, *, hurst=0.8, waves=(4, 16), seed=0):
    """E* = 1, h′ = 1 in the unit cell, `waves` per side at the roll-off and at the end of the roughness."""
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        1.0,
        hurst=hurst,
        q_min=2 * np.pi,
        q_roll_off=2 * np.pi * waves[0],
        q_max=2 * np.pi * waves[1],
    )
    grid = rs.Grid((points, points), (1.0, 1.0))
    return solvers.Problem(
        points, load, cap, rs.synthesize(spectrum, grid, np.random.default_rng(seed))
    )


def ours(task, tolerance=TOLERANCE):
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", RuntimeWarning
        )  # the rounding floor: its residual is in the row
        return rs.solve_contact(
            task.heights,
            task.grid,
            rs.Solid(1.0, task.cap),
            nominal_pressure=task.load,
            tolerance=tolerance,
        )


def solved(name, task):
    """A row: error against our solution at 1e-10, CPU seconds, what the solver says of itself, or why it failed."""
    row = {
        "solver": name,
        "error": nan,
        "seconds": nan,
        "transforms": nan,
        "iterations": nan,
        "residual": nan,
    }
    try:
        if name == "roughsim":
            found, seconds = timed(lambda: ours(task))
            pressure = found.pressure
            row |= {
                "transforms": found.transforms,
                "iterations": float(found.iterations),
                "residual": found.residual,
            }
        else:
            pressure, seconds = timed(lambda: solvers.PEERS[name][1](task, TOLERANCE))
        exact = ours(task, 1e-10).pressure
    except (RuntimeError, ValueError) as reason:
        return row | {"why": str(reason) or type(reason).__name__}
    error = float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact))
    return row | {"error": error, "seconds": seconds, "why": ""}


def timed(work):
    """What it gives, and its CPU seconds; quick work is done twice, since the first may have compiled something."""
    spent = []
    while len(spent) < 2 and sum(spent) < 0.5:
        start = time.process_time()
        result = work()
        spent.append(time.process_time() - start)
    return result, min(spent)


def complaint(row):
    """Why a row counts as failed; what a solver is not made for does not."""
    if row["why"]:
        return "" if row["why"] == NOT_MADE else row["why"]
    if "solver" in row:
        return (
            f"a thousand times its tolerance of {TOLERANCE:g}"
            if row["error"] > 1e3 * TOLERANCE
            else ""
        )
    return "more than twice too hot" if row["error"] > 1.0 else ""


def there():
    return [
        n
        for n in SOLVERS
        if n == "roughsim" or importlib.util.find_spec(solvers.PEERS[n][0]) is not None
    ]


def load_map(rows, folder, toy):
    """Contact over load and hardness, every solver."""
    points = 32 if toy else 64
    loads = (0.01, 0.3) if toy else (0.001, 0.01, 0.1, 1.0)
    ratios = (1.5, inf) if toy else (1.01, 1.5, 3.0, 10.0, inf)
    names = there()
    for name in names:
        solved(name, unit_problem(32, 0.1, inf))  # imported and planned by now
    for name, load, ratio in product(names, loads, ratios):
        task = unit_problem(points, load, load * ratio, waves=(2, points // 8))
        key = f"{name} load {load:g} hardness {ratio:g} loads"
        rows.once(
            "load",
            key,
            lambda n=name, t=task, x=load, y=ratio: {"load": x, "ratio": y} | solved(n, t),
        )
    figures.limits_of_solvers(list(rows["load"].values()), folder / "limits_of_solvers.png")
    told("load", rows["load"].values())


def roughness_map(rows, folder, toy):
    """Contact over H, bandwidth and pixels per shortest wave, every solver; the error of the pixel beside our own."""
    hursts = (0.3, 0.8) if toy else (0.0, 0.3, 0.5, 0.8, 1.0)
    bands = (4,) if toy else (2, 8, 32)
    pixels = (2, 4) if toy else (2, 4, 8)
    names, slow = there(), set()
    for name in names:
        solved(name, unit_problem(32, 0.1, inf))  # imported and planned by now
    for name, hurst, band, pixel in product(names, hursts, bands, pixels):
        key = f"{name} H {hurst:g} bandwidth {band} at {pixel} pixels"
        work = too_long if (name, hurst, band) in slow else rough
        task = (name, hurst, band, pixel, 8 if toy else 16)
        row = rows.once("roughness", key, lambda work=work, task=task: work(*task))
        if row["seconds"] > LONGEST:
            slow.add((name, hurst, band))
        print(f"{key:50s} {row['error']:8.1e} {row['seconds']:8.3f} s  {row['why']}", flush=True)
    found = list(rows["roughness"].values())
    figures.limits_of_pixel(found, folder / "limits_of_pixel.png")
    told("roughness", found)


def rough(name, hurst, band, pixel, finest):
    """A row of the map: two roll-off waves per side, load 0.05; for ours the error of the pixel too."""
    waves = (2, 2 * band)
    task = unit_problem(2 * band * pixel, 0.05, inf, hurst=hurst, waves=waves)
    row = {
        "hurst": hurst,
        "bandwidth": float(band),
        "pixels": float(pixel),
        "pixel_error": nan,
    } | solved(name, task)
    if name != "roughsim":
        return row
    fine = unit_problem(2 * band * finest, 0.05, inf, hurst=hurst, waves=waves)
    values = [rs.measure(ours(t, 1e-5), t.grid, FAST).flash_temperature[0] for t in (task, fine)]
    return row | {"pixel_error": float(abs(values[0] / values[1] - 1))}


def too_long(name, hurst, band, pixel, _):
    """The row of a solver that took too long with larger pixels."""
    row = {
        "solver": name,
        "hurst": hurst,
        "bandwidth": float(band),
        "pixels": float(pixel),
        "pixel_error": nan,
    }
    row |= {"error": nan, "seconds": nan, "transforms": nan, "iterations": nan, "residual": nan}
    return row | {"why": f"not asked: over {LONGEST:g} s with larger pixels"}


FAST = rs.HeatSource([1e4], 1.0, 1.0, 1.0)


# heat


def steady(flux, grid, speed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # too hot: that is what the map shows
        return rs.sliding_temperature(flux, grid, speed=speed, slid_distance=inf, **UNIT)


def from_rest(flux, grid, speed):
    """Half the cell, with the uniform term."""
    slid = grid.lengths[0] / 2 / speed
    return rs.sliding_temperature(flux, grid, speed=speed, **UNIT) + uniform_temperature(
        flux.mean(), slid, **UNIT
    )


def free(flux, grid, speed):
    return rs.half_space_temperature(flux, grid, speed=speed, **UNIT)


KERNELS = {"periodic, steady": steady, "periodic, from rest": from_rest, "free half-space": free}


def hertz_source(pixels, side):
    """Mean flux over each pixel, from 8² points; lengths in radii."""
    count = pixels * side
    x = (np.arange(8 * count) - (8 * count - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    flux = fine.reshape(count, 8, count, 8).mean((1, 3))
    return flux, rs.Grid((count, count), (float(side),) * 2)


def heated(name, peclet, side, pixels):
    """A row: relative error of T_flash with its sign."""
    flux, grid = hertz_source(pixels, side)
    start = time.process_time()
    temperature = KERNELS[name](flux, grid, peclet)
    seconds = time.process_time() - start
    value = (
        float((temperature * flux).sum() / flux.sum()) / float(hertz.flash_temperature(peclet)) - 1
    )
    row = {
        "kernel": name,
        "peclet": peclet,
        "side": float(side),
        "excess": value,
        "error": abs(value),
    }
    return row | {"seconds": seconds, "why": ""}


def heat_map(rows, folder, toy):
    peclets = (0.1, 100.0) if toy else (0.01, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4)
    sides, pixels = ((4, 8), 4) if toy else ((4, 8, 16, 32, 64), 8)
    for name, peclet, side in product(KERNELS, peclets, sides):
        key = f"{name} Pe {peclet:g} box {side}"
        rows.once("heat", key, lambda n=name, p=peclet, s=side: heated(n, p, s, pixels))
    figures.limits_of_heat(list(rows["heat"].values()), folder / "limits_of_heat.png")
    told("heat", rows["heat"].values())


# theory


def theory_map(rows, folder, toy):
    """T_flash by the paper's theory and by the calibrated law over that of elastic contacts, the worst of all H."""
    peclets = (0.001, 1.0, 1000.0)
    contacts = [row for row in json.loads(CONTACTS.read_text())["elastic"] if row["plateau"] == 2.0]
    contacts = [
        row for row in contacts if row["bandwidth"] in BANDWIDTHS and row["low_exponent"] == 0.0
    ]
    worst: dict[str, dict] = {}
    for contact in contacts[:: 20 if toy else 1]:
        for formula, values in by_formula(contact, peclets).items():
            excess = 100 * (values / np.array(contact["flash_temperature"]["value"]) - 1)
            for peclet, value in zip(peclets, excess, strict=True):
                place = {
                    "load": contact["load"],
                    "bandwidth": contact["bandwidth"],
                    "peclet": peclet,
                }
                key = f"{formula} load {contact['load']:g} bandwidth {contact['bandwidth']:g} Pe {peclet:g}"
                row = {
                    "formula": formula,
                    **place,
                    "excess": float(value),
                    "error": abs(float(value)) / 100,
                    "why": "",
                }
                worst[key] = max(row, worst.get(key, row), key=lambda one: one["error"])
    rows.extend("theory", worst)
    figures.limits_of_theory(list(rows["theory"].values()), folder / "limits_of_theory.png")
    told("theory", rows["theory"].values())


def by_formula(contact, peclets):
    """T_flash of a contact of the file by both formulas, in its units."""
    spectrum = spectrum_of(
        contact["hurst"], contact["plateau"], contact["bandwidth"], contact["low_exponent"]
    )
    load = contact["load"]
    law = persson.calibrated_spectrum(spectrum, effective_modulus=1.0, nominal_pressure=load)
    unit = {
        "conductivity": 1.0,
        "diffusivity": 1.0,
        "friction_coefficient": load,
        "nominal_pressure": load,
    }
    return {
        "paper's theory": flash.flash_temperature(
            np.array(peclets), spectrum=spectrum, effective_modulus=1.0, **unit
        ),
        "calibrated law": flash.flash_temperature(np.array(peclets), stress_spectrum=law, **unit),
    }


def told(name, found):
    """Print the failures of a map, each with its reason, and how many rows there are."""
    failed = [row for row in found if complaint(row)]
    print(f"{name}: {len(list(found))} points, {len(failed)} failed")
    for row in failed:
        where = " ".join(
            f"{key} {row[key]}"
            for key in ("solver", "kernel", "load", "ratio", "peclet", "side")
            if key in row
        )
        print(f"    {where}: {complaint(row)[:90]} (error {row['error']:.1e})")


MAPS = {"load": load_map, "roughness": roughness_map, "heat": heat_map, "theory": theory_map}


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument(
        "maps", nargs="*", metavar="MAP", help=f"{', '.join(MAPS)}; all if left out"
    )
    command.add_argument(
        "--resume", action="store_true", help="keep the rows that are already in data.json"
    )
    options = command.parse()
    if unknown := set(options.maps) - set(MAPS):
        command.error(f"{', '.join(unknown)}: choose from {', '.join(MAPS)}")
    rows = Rows(options.output / "data.json", resume=options.resume)
    chosen = options.maps or list(MAPS)
    for name in chosen:
        MAPS[name](rows, options.output, options.toy)
    if options.evidence:
        measured = [row for name in chosen for row in rows[name].values()]
        # without CPU times, which no map shows, and what is not known of a failure
        known = [
            {key: value for key, value in row.items() if key != "seconds" and is_known(value)}
            for row in measured
        ]
        command_line = "python experiments/where_methods_fail.py --resume --evidence"
        write_evidence("limits", command_line, rows=known, numbers=numbers_of_page(measured))


def is_known(value):
    return isinstance(value, str) or not isnan(value)


def numbers_of_page(measured):
    """The largest errors of the pressure by the peers, and of T_flash by the pixel, %; of maps that were computed."""
    numbers = {}
    for row in measured:
        if "ratio" in row and row["solver"] != "roughsim" and not isnan(row["error"]):
            numbers[row["solver"]] = max(numbers.get(row["solver"], 0.0), 100 * row["error"])
        if row.get("solver") == "roughsim" and "pixels" in row:
            key = f"pixel_{row['pixels']:g}"
            numbers[key] = max(numbers.get(key, 0.0), 100 * row["pixel_error"])
    return numbers


if __name__ == "__main__":
    main()
