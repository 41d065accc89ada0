"""Hot tracks behind a sliding steel contact, as an experiment sees them through a hole in the resting block.

    python experiments/hot_tracks.py [--toy] [-o FOLDER]

Sutter and Ranc looked through a hole of radius 1 mm in the resting block at the steel that slid by at 33.9 and 34.5
m/s, with 4 µm resolution. Asperities just outside the hole leave hot tracks in it. Here the contact of two rough steel
faces is solved, the hole is taken out of its heat, and the sliding face has slid half the cell from rest. A second
figure shows the largest macroasperity at magnification 4 and with all that the grid resolves, with the circle of
a Hertz contact that has the D_flash of the theory: D_flash of capped contact has no limit as the grid is refined.
"""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter
from script import Command

import roughsim as rs
from roughsim.heat import hot_spots, uniform_temperature
from theory import flash, hertz, plasticity

mpl.rcParams.update(
    {"font.size": 9, "axes.titlesize": 9, "figure.constrained_layout.use": True, "savefig.dpi": 150}
)
SCENE = rs.load_scene("steel-1.2GPa")
SPEEDS = {3: 33.9, 5: 34.5}  # the experiment's numbers of its tests; each has a surface of its own
HOLE, RESOLUTION, MICRON = 1e-3, 4e-6, 1e6
LENGTH, PRESSURE, FRICTION, SHARE = 4e-3, 90e6, 0.11, 0.938
STEEL = {"conductivity": 30.0, "diffusivity": SCENE.conduction().diffusivity}
MAGNIFICATION, Q_MIN = 4, 6350.0


def coarse(heights, grid):
    """The same surface with its waves up to magnification 4 only."""
    modes = np.fft.rfft2(heights)
    modes[grid.wavenumbers > MAGNIFICATION * Q_MIN] = 0.0
    return np.fft.irfft2(modes, s=grid.shape)


def contact_of(heights, grid):
    solid = rs.Solid(
        effective_modulus=SCENE.effective_modulus, penetration_hardness=SCENE.penetration_hardness
    )
    return rs.solve_contact(heights, grid, solid, nominal_pressure=PRESSURE, tolerance=1e-4)


def seen(temperature, grid):
    """As through the camera: means over its resolution."""
    return uniform_filter(
        temperature, [max(1, round(RESOLUTION / d)) for d in grid.spacing], mode="wrap"
    )


def inside_the_rim(field, grid):
    """(y, temperature, full width at half height of the hottest track) 50 µm inside the leading rim of the hole."""
    radius, centre = HOLE - 50e-6, np.array(grid.shape) // 2
    y = np.arange(-int(0.9 * radius / grid.spacing[1]), int(0.9 * radius / grid.spacing[1]) + 1)
    i = centre[0] + np.rint(
        np.sqrt(radius**2 - (y * grid.spacing[1]) ** 2) / grid.spacing[0]
    ).astype(int)
    line = field[i, centre[1] + y]
    peak = line.argmax()
    low = np.flatnonzero(line < (line[peak] + np.median(line)) / 2)
    width = low[low > peak].min(initial=line.size) - low[low < peak].max(initial=-1) - 1
    return y * grid.spacing[1], line, width * grid.spacing[1]


def tracks_chart(fields, grid, folder):
    """Maps of the hole, and the temperature across sliding just inside its leading rim, where tracks are youngest."""
    x = (np.arange(grid.shape[0]) + 0.5) * grid.spacing[0] - LENGTH / 2
    hole, inside = np.hypot(x[:, None], x) < HOLE, np.abs(x) < HOLE
    figure = Figure(figsize=(9, 7.2))
    highest = max(
        field[hole].max() for field in fields.values()
    )  # one scale of colours for both tests
    look = {"cmap": "inferno", "vmin": 0, "vmax": highest, "extent": [-1e3, 1e3, -1e3, 1e3]}
    places = figure.subplots(2, 2, sharex="col", sharey="col")
    for row, (test, field) in zip(places, fields.items(), strict=True):
        shown = np.where(hole, field, np.nan)[np.ix_(inside, inside)]
        image = row[0].imshow(shown.T, origin="lower", **look)
        row[0].set(title=f"test {test}, {SPEEDS[test]} m/s; the block moves right")
        row[0].set(
            ylabel="$y$, µm", xticks=np.arange(-1000, 1001, 500), yticks=np.arange(-1000, 1001, 500)
        )
        y, line, width = inside_the_rim(field, grid)
        row[1].plot(y * MICRON, line, color="#D55E00", lw=1)
        row[1].set(title=f"inside the rim: hottest track {width * MICRON:.0f} µm wide")
        row[1].set(ylabel="temperature rise, K")
        spots = hot_spots(np.where(hole, field, 0.0), grid, line.max() / 2, periodic=False)
        print(
            f"test {test}: {SPEEDS[test]} m/s, hottest near the rim {line.max():6.1f} K, median {np.median(line):.0f},"
            f" width {width * MICRON:.0f} µm, {spots.count} tracks above half of it"
        )
    figure.colorbar(image, ax=places[:, 0], label="temperature rise, K", shrink=0.6)
    places[1, 0].set_xlabel("$x$, µm")
    places[1, 1].set(xlabel="$y$, µm", ylim=(0, None))
    figure.savefig(folder / "hot_tracks.png")


def largest_patch(pressure, grid, radius):
    """The pixel in the middle of the most loaded patch: where the pressure within `radius` has its mean."""
    x = (np.arange(grid.shape[0]) - grid.shape[0] // 2) * grid.spacing[0]
    within = np.hypot(x[:, None], x) <= radius
    blurred = uniform_filter(pressure, max(1, round(2 * radius / grid.spacing[0])), mode="wrap")
    centre = np.array(np.unravel_index(blurred.argmax(), grid.shape))
    for _ in range(20):
        around = within * np.roll(pressure, np.array(grid.shape) // 2 - centre, (0, 1))
        mean = [np.sum(axis * around) / around.sum() for axis in (x[:, None], x)]
        centre = (centre + np.rint(np.array(mean) / grid.spacing).astype(int)) % grid.shape
    return centre


def macroasperity_chart(heights, fine, grid, folder):
    """The first figure of the paper: one macroasperity, coarse and fine, and its Hertz circle."""
    load = {"effective_modulus": SCENE.effective_modulus, "nominal_pressure": PRESSURE}
    smooth = plasticity.smoothed_spectrum(
        SCENE.spectrum, penetration_hardness=SCENE.penetration_hardness, **load
    )
    width = float(
        flash.flash_width(35.0, smooth, friction_coefficient=FRICTION, gamma=0.294, **load, **STEEL)
    )
    radius = width / hertz.FAST.flash_width
    first = contact_of(coarse(heights, grid), grid)
    centre = largest_patch(first.pressure, grid, radius)
    half = min(max(2, round(2.5 * radius / grid.spacing[0])), grid.shape[0] // 2)
    edge = half * grid.spacing[0] * MICRON
    figure = Figure(figsize=(8.5, 4))
    places, hardness = figure.subplots(1, 2, sharey=True), SCENE.penetration_hardness / 1e9
    for axis, contact, title in zip(
        places, (first, fine), ("magnification 4", "full"), strict=True
    ):
        moved = np.roll(contact.pressure, [half - c for c in centre], (0, 1))[
            : 2 * half, : 2 * half
        ]
        look = {"cmap": "Greys", "vmin": 0, "vmax": hardness, "extent": [-edge, edge, -edge, edge]}
        image = axis.imshow(moved.T / 1e9, origin="lower", **look)
        turn = np.linspace(0, 2 * np.pi, 200)
        axis.plot(radius * MICRON * np.cos(turn), radius * MICRON * np.sin(turn), color="#0072B2")
        axis.set(
            title=f"{title}: contact on {100 * contact.contact_fraction:.1f} % of the area",
            xlabel="$x$, µm",
        )
    places[0].set_ylabel("$y$, µm")
    figure.colorbar(image, ax=places, label="pressure, GPa", shrink=0.8)
    widths = rf"$D_\mathrm{{flash}}$ = {width * MICRON:.1f} µm"
    figure.suptitle(
        widths + rf", circle $2R = 2D_\mathrm{{flash}}/\alpha$ = {2 * radius * MICRON:.0f} µm"
    )
    figure.savefig(folder / "macroasperity.png")
    print(
        f"D_flash = {width * MICRON:.1f} µm by the theory: R = D_flash/alpha, 2R = {2 * radius * MICRON:.0f} µm"
    )


def main() -> None:
    options = Command(__file__, __doc__).parse()
    points = 64 if options.toy else 1024
    grid = rs.Grid((points, points), (LENGTH, LENGTH))
    spectrum = SCENE.spectrum.truncated(q_max=grid.nyquist / 2)  # four pixels per shortest wave
    x = (np.arange(points) + 0.5) * grid.spacing[0] - LENGTH / 2
    outside = np.hypot(x[:, None], x) >= HOLE
    fields = {}
    for test, speed in SPEEDS.items():
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(test))
        contact = contact_of(heights, grid)
        flux = SHARE * FRICTION * speed * contact.pressure * outside
        rise = rs.sliding_temperature(flux, grid, speed=speed, **STEEL)
        rise += uniform_temperature(float(flux.mean()), LENGTH / 2 / speed, **STEEL)
        fields[test] = seen(rise, grid)
    tracks_chart(fields, grid, options.output)
    macroasperity_chart(heights, contact, grid, options.output)


if __name__ == "__main__":
    main()
