"""The largest macroasperity of a sliding steel contact, as in the first figure of the paper.

    python experiments/macroasperity.py [--toy] [-o FOLDER]

The contact of two rough steel faces is solved at magnification 4 and with all that the grid resolves. The circle is a
Hertz contact with the D_flash of the theory: D_flash of capped contact has no limit as the grid is refined.
Its hot tracks are those of experiments/camera.py.
"""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter
from script import Command

import roughsim as rs
from theory import flash, hertz, plasticity

mpl.rcParams.update(
    {"font.size": 9, "axes.titlesize": 9, "figure.constrained_layout.use": True, "savefig.dpi": 150}
)
SCENE = rs.load_scene("steel-1.2GPa")
MICRON = 1e6
LENGTH, PRESSURE, FRICTION = 4e-3, 90e6, 0.11
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
            xlabel="$x$ (µm)",
        )
    places[0].set_ylabel("$y$ (µm)")
    figure.colorbar(image, ax=places, label="pressure (GPa)", shrink=0.8)
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
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(5))
    macroasperity_chart(heights, contact_of(heights, grid), grid, options.output)


if __name__ == "__main__":
    main()
