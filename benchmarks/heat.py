"""What heat fields cost, in pairs of real transforms of the same size, and where their methods fail.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/heat.py [--points 2048] [--charts FOLDER] [--evidence]

Prints CPU times as ratios to a bare pair of the same run, then draws `heat_limits.png`, the errors beyond the limits of
each method. --evidence draws it for docs/heat.md, and writes its numbers. `experiments/heat_methods.py` has the error
over the CPU time.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from matplotlib.ticker import NullLocator

import roughsim as rs
from roughsim import fourier
from roughsim.charts.style import legend_below
from roughsim.heat import half_space, periodic, source_temperature, uniform_temperature
from theory import hertz

sys.path.append(str(Path(__file__).parents[1] / "experiments"))
from figures.style import AMBER, GREEN, LOOKS, PINK, decades, new_figure
from script import EVIDENCE, write_evidence

UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
CELL = 8.0  # radii, of the periodic cell around a single contact
STEADY, REST = LOOKS["periodic, steady"]["color"], LOOKS["periodic, from rest"]["color"]


def best(work, repeats=3):
    """Shortest CPU time, s, of a few runs after a first one that fills caches."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


# costs


def costs(points):
    grid, one = rs.Grid((points, points), (1.0, 1.0)), {}
    for dtype in (np.float64, np.float32):
        flux = np.random.default_rng(1).random((points, points)).astype(dtype)
        transform = fourier.Transform((points, points), dtype)
        transform.field[...] = flux
        pair = best(lambda transform=transform: (transform.forward(), transform.inverse()), 5)
        one[dtype] = pair
        print(
            f"{dtype.__name__}: a bare pair takes {pair:.4f} s; in such pairs (in brackets: in pairs of float64)"
        )
        for name, work in fields(flux, grid).items():
            cost = best(work)
            print(f"  {name:44} {cost / pair:5.2f}  ({cost / one[np.float64]:.2f})")
    for name, work in kernels(grid).items():
        print(f"  {name:44} {best(work) / one[np.float64]:5.2f}")


def fields(flux, grid):
    times = [1e-5, 2e-5, 4e-5, 8e-5]
    return {
        "periodic field, kernel ready": lambda: rs.sliding_temperature(
            flux, grid, speed=grid.shape[0], **UNIT
        ),
        "free half-space, kernel ready": lambda: rs.half_space_temperature(
            flux, grid, speed=grid.shape[0], **UNIT
        ),
        "periodic, 4 times with their kernels": lambda: rs.sliding_temperature(
            flux, grid, speed=grid.shape[0], time=times, **UNIT
        ),
    }


def kernels(grid):
    pixel = grid.shape[0]
    contact = SimpleNamespace(
        pressure=np.random.default_rng(1).random(grid.shape),
        contact_fraction=1.0,
        plastic_fraction=0.0,
    )
    speeds = list(np.geomspace(1.0, 1e4, 20))

    def free(peclet, spread=math.inf):  # √(Dt) in pixels
        axes = half_space.axes(grid, peclet * pixel)
        return half_space.influence_response.__wrapped__(*axes, 0.0, "d", None, spread)

    table = {
        f"free kernel, pixel Péclet {peclet:g}": lambda peclet=peclet: free(peclet)
        for peclet in (0.0, 0.01, 1.0, 100.0)
    }
    table["free kernel from rest, √(Dt) 30 pixels"] = lambda: free(0.1, 30.0)
    table["periodic kernel from rest"] = lambda: periodic.turned_response(
        grid, periodic.MovingSource((pixel, 0.0), 0.5 / pixel), np.float64
    )
    table["moments, 20 speeds, mean over directions"] = lambda: rs.measure(
        contact, grid, rs.HeatSource(speeds, 0.1, 1.0, 1.0)
    )
    table["moments, 20 speeds, one direction"] = lambda: rs.measure(
        contact, grid, rs.HeatSource(speeds, 0.1, 1.0, 1.0, direction=0.0)
    )
    return table


# sources and fields


def hertz_source(pixels, margin):
    """Mean flux over each pixel, from 8² points, and the grid of a cell of 2·margin radii."""
    count = 2 * round(pixels * margin)
    x = (np.arange(8 * count) - (8 * count - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    flux = fine.reshape(count, 8, count, 8).mean((1, 3))
    return flux, rs.Grid((count, count), (count / pixels,) * 2)


def steady(flux, grid, speed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # too hot: that is what the charts show
        return rs.sliding_temperature(flux, grid, speed=speed, slid_distance=math.inf, **UNIT)


def from_rest(flux, grid, speed):
    """Over half the cell, with the uniform term."""
    slid = grid.lengths[0] / 2 / speed
    return rs.sliding_temperature(flux, grid, speed=speed, **UNIT) + uniform_temperature(
        flux.mean(), slid, **UNIT
    )


def free(flux, grid, speed):
    return rs.half_space_temperature(flux, grid, speed=speed, **UNIT)


def flash_error(method, flux, grid, speed):
    """Relative error of T_flash of a Hertz contact."""
    temperature = method(flux, grid, speed)
    return abs((temperature * flux).sum() / flux.sum() / float(hertz.flash_temperature(speed)) - 1)


# limits


def hot_tracks(axis):
    """Steady T_flash over that of an endless surface: the mean over all directions, by the closed angular mean.

    Returns the excess in % at vL/2πD = 100 and 1000 by method and longest waves per side, and the largest from rest.
    """
    found, rests = {}, []
    points, laps = 256, np.geomspace(1, 1e4, 13)
    grid = rs.Grid((points, points), (1.0, 1.0))
    for waves, style in ((1, "-"), (4, "--"), (16, ":")):
        q = 2 * math.pi * waves
        spectrum = rs.SelfAffineSpectrum.from_rms_height(
            1.0, hurst=0.8, q_min=q, q_roll_off=2 * q, q_max=math.pi * points / 2
        )
        flux = 20 + rs.synthesize(spectrum, grid, np.random.default_rng(1), amplitudes="fixed")
        contact = SimpleNamespace(pressure=flux, contact_fraction=1.0, plastic_fraction=0.0)
        exact = rs.measure(
            contact, grid, rs.HeatSource(2 * math.pi * laps, 1.0, 1.0, 1.0)
        ).flash_temperature
        for name, color, method in (
            ("steady", STEADY, steady),
            ("from rest", REST, lambda f, g, s: rs.sliding_temperature(f, g, speed=s, **UNIT)),
        ):
            flash = [np.mean(method(flux, grid, 2 * math.pi * lap) * flux) for lap in laps]
            error = np.abs(np.array(flash) / flux.mean() * 2 * math.pi * laps / exact - 1)
            if name == "from rest":
                rests.append(100 * error.max())
            else:
                found |= {
                    f"tracks_{waves}_{lap:g}": 100 * np.interp(lap, laps, error)
                    for lap in (100, 1000)
                }
            axis.loglog(
                laps, error, style, color=color, label=f"{name}, {waves} wave{'s' * (waves > 1)}"
            )
            print(
                f"hot tracks {name:9} {waves:2} waves: "
                + " ".join(f"{value:8.1e}" for value in error)
            )
    decades(axis, x=(1, 1e4), y=(1e-5, 1e3))
    axis.set(
        title="hot tracks, by longest waves",
        xlabel=r"$vL/(2\pi D)$",
        ylabel=r"error of $T_\mathrm{flash}$",
    )
    legend_below(axis, columns=2)
    return found | {"tracks_from_rest": max(rests)}


def square_source(pixels, margin):
    count = 2 * round(pixels * margin)
    inside = (abs(np.arange(count) - (count - 1) / 2) < pixels).astype(float)
    return np.outer(inside, inside), rs.Grid((count, count), (count / pixels,) * 2)


def undershoot(axis):
    """Lowest over highest temperature of a fast square: the Gibbs oscillation of the periodic field; most, in %."""
    sizes, most = (4, 8, 16, 32, 64), np.zeros(5)
    for peclet, style in ((100.0, "--"), (1e3, "-"), (1e5, ":")):
        fields = {
            "rest": [from_rest(*square_source(pixels, CELL / 2), peclet) for pixels in sizes],
            "free": [free(*square_source(pixels, 2.0), peclet) for pixels in sizes],
        }
        shares = {
            name: [max(-field.min() / field.max(), 0.0) for field in made]
            for name, made in fields.items()
        }
        axis.loglog(
            sizes,
            shares["rest"],
            style,
            marker="o",
            color=REST,
            label=f"from rest, $vR/D$ = {peclet:g}",
        )
        most = np.maximum(most, 100 * np.array(shares["rest"]))
        print(
            f"undershoot vR/D = {peclet:g}: "
            + " ".join(f"{value:8.1e}" for value in shares["rest"])
        )
        print(f"  free half-space at most {max(shares['free']):.0e}")
    decades(axis, y=(1e-4, 0.1))
    axis.set(
        title="undershoot at a sharp edge",
        xlabel="pixels per half side",
        ylabel=r"$-T_\mathrm{min}/T_\mathrm{max}$",
    )
    legend_below(axis, columns=2)
    _ticks(axis, sizes)
    return {f"undershoot_{size}": value for size, value in zip(sizes, most, strict=True)}


def _ticks(axis, sizes):
    axis.set_xticks(sizes, [str(size) for size in sizes])
    axis.xaxis.set_minor_locator(NullLocator())


def resolution(axis):
    """What a pixel costs: T_max read at centres, T_max of `source_temperature`, and ∇²T."""
    sizes, peclet = (4, 8, 16, 32, 64), 1000.0
    exact = float(hertz.square_max_temperature(peclet))
    centres, search, laplacian = [], [], []
    for pixels in sizes:
        flux, grid = square_source(pixels, 1.25)
        centres.append(1 - free(flux, grid, peclet).max() / exact)
        search.append(
            abs(source_temperature(flux, grid, speed=peclet, **UNIT).max_temperature / exact - 1)
        )
        pressure, grid = hertz_source(pixels, CELL / 2)
        power = np.abs(np.fft.rfft2(pressure) / grid.points) ** 2 * grid.multiplicity
        laplacian.append(
            1 - float(np.sum(power * grid.wavenumbers) / pressure.mean()) / (math.pi / 2)
        )
    curves = {
        r"$\nabla^2T$, resting Hertz contact": (laplacian, PINK),
        r"$T_\mathrm{max}$, fast square, at centres": (centres, GREEN),
        r"$T_\mathrm{max}$, source_temperature": (search, AMBER),
    }
    for label, (values, color) in curves.items():
        axis.loglog(sizes, values, "o-", color=color, label=label)
        print(f"{label:36}" + " ".join(f"{value:8.1e}" for value in values))
    decades(axis)
    axis.set(title="pixel", xlabel="pixels per radius or half side", ylabel="relative error")
    legend_below(axis, columns=2)
    _ticks(axis, sizes)
    return {f"laplacian_{size}": 100 * value for size, value in zip(sizes, laplacian, strict=True)}


def limits(folder):
    numbers = {}
    with new_figure(folder / "heat_limits.png", 8.0) as figure:
        for axis, draw in zip(
            figure.subplots(3, 1), (hot_tracks, undershoot, resolution), strict=True
        ):
            numbers |= draw(axis)
    return numbers


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--points", type=int, default=2048, help="points per side; 0: no times")
    options.add_argument("--charts", type=Path, default=None, help="folder for the chart")
    options.add_argument(
        "--evidence", action="store_true", help="write the chart and the numbers of docs/heat.md"
    )
    given = options.parse_args()
    if given.points:
        costs(given.points)
    folder = EVIDENCE.parent / "figures" if given.evidence else given.charts
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        numbers = limits(folder)
        if given.evidence:
            write_evidence(
                "heat_limits", "python benchmarks/heat.py --points 0 --evidence", numbers=numbers
            )


if __name__ == "__main__":
    main()
