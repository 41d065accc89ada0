"""What heat fields cost, in pairs of real transforms of the same size, and how exact each method is for that.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/heat.py [--points 2048] [-o FOLDER]

Prints ratios to a bare pair of the same run, and draws the error of T_flash of a Hertz contact at Pe = 10 over the time
of each method: periodic steady and from rest in a cell of 8 radii, the free half-space with pixel influences, and, as
a warning, the free half-space with the values of the point source at the pixels in their place.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import roughsim as rs
from roughsim import fourier
from roughsim.heat import half_space
from theory import hertz

mpl.use("Agg")
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
PECLET = 10.0


def best(work, repeats=3):
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def costs(points):
    """One row per precision: everything in pairs."""
    grid = rs.Grid((points, points), (1.0, 1.0))
    for dtype in (np.float64, np.float32):
        flux = np.random.default_rng(1).random((points, points)).astype(dtype)
        transform = fourier.Transform((points, points), dtype)
        transform.field[...] = flux
        pair = best(lambda transform=transform: (transform.forward(), transform.inverse()))
        free = best(lambda flux=flux: rs.half_space_temperature(flux, grid, speed=points, **UNIT))
        cell = best(lambda flux=flux: rs.sliding_temperature(flux, grid, speed=points, **UNIT))
        print(
            f"{dtype.__name__}: pair {pair:.4f} s; pairs: free half-space {free / pair:.2f}, periodic {cell / pair:.2f}"
        )
        if dtype is np.float64:
            for pixel_peclet in (0.0, 0.01, 1.0):
                half_space._spectrum.cache_clear()
                start = time.perf_counter()
                half_space.influence_spectrum(grid, (pixel_peclet * points, 0.0), 0.0, math.inf)
                print(
                    f"  its kernel at pixel Péclet {pixel_peclet:g}: {(time.perf_counter() - start) / pair:.2f} pairs"
                )


def source(pixels, margin):
    count = 2 * round(pixels * margin)
    x = (np.arange(8 * count) - (8 * count - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    flux = fine.reshape(count, 8, count, 8).mean((1, 3))
    return flux, rs.Grid((count, count), (count / pixels,) * 2)


def point_kernel(flux, grid):
    """The warning: e^(−p(r + x)/2)/2πr at the pixels, with that of the resting pixel at r = 0."""
    count, side = grid.shape[0], grid.spacing[0]
    x = (np.arange(2 * count) - count) * side
    r = np.hypot(x[:, None], x)
    r[count, count] = side / (2 * math.pi * 0.5610998523)
    kernel = np.exp(-PECLET * (r + x[:, None]) / 2) / (2 * math.pi * r) * side**2
    spectrum = np.fft.rfft2(np.roll(kernel, (-count, -count), (0, 1)))
    return np.fft.irfft2(np.fft.rfft2(flux, s=kernel.shape) * spectrum, s=kernel.shape)[:count, :count]


def chart(folder):
    def steady(flux, grid):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # too hot: that is what the chart shows
            return rs.sliding_temperature(flux, grid, speed=PECLET, slid_distance=math.inf, **UNIT)

    methods = {
        "periodic steady": (4.0, steady),
        "periodic from rest": (4.0, lambda flux, grid: rs.sliding_temperature(flux, grid, speed=PECLET, **UNIT)),
        "free, pixel influence": (1.05, lambda flux, grid: rs.half_space_temperature(flux, grid, speed=PECLET, **UNIT)),
        "free, point values": (1.05, point_kernel),
    }
    figure = Figure(figsize=(5, 4), layout="constrained")
    axis = figure.subplots()
    exact = float(hertz.flash_temperature(PECLET))
    for name, (margin, method) in methods.items():
        rows = []
        for pixels in (4, 8, 16, 32, 64, 128):
            flux, grid = source(pixels, margin)
            temperature = method(flux, grid)
            error = abs((temperature * flux).sum() / flux.sum() / exact - 1)
            rows.append((best(lambda f=flux, g=grid, m=method: m(f, g), 2), error))
        axis.loglog(*zip(*rows, strict=True), "o-", ms=3, label=name)
        print(f"{name:24}" + " ".join(f"{error:9.2e}" for _, error in rows))
    axis.set(xlabel="time, s", ylabel="relative error of T_flash", title="Hertz, vR/D = 10, 4 to 128 pixels per radius")
    axis.legend(frameon=False)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "heat.png", dpi=150)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--points", type=int, default=2048, help="points per side")
    options.add_argument("-o", "--output", type=Path, default=Path("runs/benchmarks"), help="folder of the chart")
    given = options.parse_args()
    costs(given.points)
    chart(given.output)


if __name__ == "__main__":
    main()
