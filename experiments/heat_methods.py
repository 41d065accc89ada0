"""Error of T_flash over the cost of each way to compute the heat of sliding, for a Hertz contact and a rough one.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/heat_methods.py [--toy] [-o FOLDER] [--evidence]

Hertz: 4 to 64 pixels per radius, one contact in a periodic cell of 8 radii or on the free half-space, against its exact
T_flash. Rough: an elastic contact of 8 longest waves per side, 2 to 16 pixels per shortest wave, against the steady
mean over all directions on the finest grid; T_flash is above the mean of the cell, on the free half-space above the
same square heated evenly. Fields slide along both sides of the cell. The Péclet number is vR/D, of the rough one v/(D
q_r). Costs are CPU seconds of one field, its kernel ready. Rows in FOLDER/heat.json are not computed again.
"""

from __future__ import annotations

import math
import sys
import warnings
from functools import partial
from itertools import product
from pathlib import Path

import figures
import numpy as np
from script import Command, Rows, write_evidence

import roughsim as rs

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from heat import CELL, UNIT, best, flash_error, free, from_rest, hertz_source, steady

PECLETS = (0.1, 1.0, 10.0, 100.0, 1e3, 1e4)
METHODS = {"periodic, steady": (CELL / 2, steady), "periodic, from rest": (CELL / 2, from_rest)} | {
    "free half-space": (1.05, free)
}
WAVES = (8, 64)  # per side of the rough cell: the longest, the shortest
LOAD = 0.05  # σ₀/(E*h′)
SEEDS = (1, 2)


def hertz_row(name, peclet, pixels):
    """Error of T_flash of one Hertz contact, and the cost of its field."""
    margin, method = METHODS[name]
    flux, grid = hertz_source(pixels, margin)
    error = float(flash_error(method, flux, grid, peclet))
    words = {"source": "Hertz", "method": name, "peclet": peclet, "pixels": pixels}
    return words | {"error": error, "seconds": best(partial(method, flux, grid, peclet), 2)}


def rough_contact(pixels, seed):
    """A rough elastic contact in the unit cell, E* = h′ = 1; the surface of a seed has the same waves on any grid."""
    points = pixels * WAVES[1]
    low, high = (2 * np.pi * waves for waves in WAVES)
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        1.0, hurst=0.8, q_min=low, q_roll_off=low, q_max=high
    )
    grid = rs.Grid((points, points), (1.0, 1.0))
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed))
    return rs.solve_contact(
        heights, grid, rs.Solid(1.0), nominal_pressure=LOAD, tolerance=1e-5
    ), grid


def over_directions(contact, grid, speed):
    """T_flash as runs compute it: the steady mean over all directions of sliding, without a field."""
    return (
        float(rs.measure(contact, grid, rs.HeatSource([speed], 1.0, 1.0, 1.0)).flash_temperature[0])
        / speed
    )


def of_field(method, contact, grid, speed):
    """T_flash of the fields of both directions along the sides, above the mean of the cell."""
    values = []
    for pressure in (contact.pressure, np.ascontiguousarray(contact.pressure.T)):
        flux = pressure - pressure.mean() if method is free else pressure
        temperature = method(flux, grid, speed)
        values.append(float((temperature * pressure).mean() / pressure.mean()))
    return float(np.mean(values))


def along(flux, grid, speed):
    """The temperature after sliding half a cell, without its mean."""
    return rs.sliding_temperature(flux, grid, speed=speed, **UNIT)


ROUGH = {"periodic, steady": steady, "periodic, from rest": along, "free half-space": free}


def rough_rows(peclet, pixels, finest):
    """Errors of T_flash of the rough contact by all methods, root mean square over the surfaces, and their costs."""
    speed = peclet * 2 * math.pi * WAVES[0]
    errors: dict[str, list[float]] = {}
    for seed in SEEDS:
        (contact, grid), reference = rough_contact(pixels, seed), rough_contact(finest, seed)
        exact = over_directions(*reference, speed)
        errors.setdefault("mean over directions", []).append(
            over_directions(contact, grid, speed) / exact - 1
        )
        for name, method in ROUGH.items():
            errors.setdefault(name, []).append(of_field(method, contact, grid, speed) / exact - 1)
    rows = {}
    for name, found in errors.items():
        work = partial(ROUGH[name], contact.pressure, grid, speed) if name in ROUGH else None
        seconds = best(work or partial(over_directions, contact, grid, speed), 2)
        words = {"source": "rough", "method": name, "peclet": peclet, "pixels": pixels}
        rows[f"rough, {name}, {peclet:g}, {pixels}"] = words | {
            "error": float(np.sqrt(np.mean(np.square(found)))),
            "seconds": seconds,
        }
    return rows


def table_of(found, error=0.01):
    """The least CPU milliseconds to 1 % of T_flash by source, method and Péclet number, or the least error, %."""
    peclets = sorted({row["peclet"] for row in found})
    table = [["source", "method", *(f"Pe = {peclet:g}" for peclet in peclets)]]
    for source, method in dict.fromkeys((row["source"], row["method"]) for row in found):
        cells = []
        for peclet in peclets:
            same = {"source": source, "method": method, "peclet": peclet}.items()
            rows = [row for row in found if same <= row.items()]
            good = [1e3 * row["seconds"] for row in rows if row["error"] <= error]
            least = 100 * min(row["error"] for row in rows)
            cells.append(
                f"{min(good):.2g}"
                if good
                else f"({least:.2g} %)"
                if least < 100
                else f"({least:.0f} %)"
            )
        table.append([source, method, *cells])
    return table


def main() -> None:
    command = Command(__file__, __doc__)
    options = command.parse()
    rows = Rows(options.output / "heat.json", resume=True)
    peclets = (0.1, 1000.0) if options.toy else PECLETS
    for name, peclet, pixels in product(
        METHODS, peclets, (4, 8) if options.toy else (4, 8, 16, 32, 64)
    ):
        key = f"Hertz, {name}, {peclet:g}, {pixels}"
        row = rows.once("heat", key, partial(hertz_row, name, peclet, pixels))
        print(f"{key:50s} error {row['error']:8.1e} {1e3 * row['seconds']:8.2f} ms", flush=True)
    sizes = (2, 4) if options.toy else (2, 4, 8, 16)
    for peclet, pixels in product(peclets, sizes):
        if f"rough, mean over directions, {peclet:g}, {pixels}" not in rows["heat"]:
            with warnings.catch_warnings():
                warnings.simplefilter(
                    "ignore", RuntimeWarning
                )  # of the errors that are measured here
                rows.extend("heat", rough_rows(peclet, pixels, sizes[-1]))
            print(f"rough, Pe {peclet:g}, {pixels} pixels", flush=True)
    found = list(rows["heat"].values())
    figures.heat(found, options.output / "heat_methods.png")
    if options.evidence:
        command_line = "python experiments/heat_methods.py --evidence"
        write_evidence("heat", command_line, rows=found, tables={"cost": table_of(found)})


if __name__ == "__main__":
    main()
