"""A steel surface pressed once, relieved and pressed again: what yields, what stays, and what Eq. (27) says of it.

    python experiments/unloading.py [--toy] [-o FOLDER] [--evidence]

Two rough steel faces of hardness 1.2 GPa are pressed with up to 90 MPa, relieved, pressed to the same load and beyond.
Drawn: the way of the flat; contact and yielded area on the way up and down; one profile before and after; the power
spectrum of the deformed surface beside C_sm(q) of the theory; patches by size; how well the deformed surface repeats
the pressures elastically, which it should to the tolerance of the solver.
"""

from __future__ import annotations

import numpy as np
from figures.style import BLACK, BLUE, GREEN, ORANGE, decades, new_figure
from script import Command, show_on_pages

import roughsim as rs
from theory import plasticity

GREY = "0.55"
SCENE = rs.load_scene("steel-1.2GPa")
LENGTH, LOAD, MICRON, MEGA = 3.96e-3, 90e6, 1e6, 1e-6
STEEL = rs.Solid(SCENE.effective_modulus, SCENE.penetration_hardness)


def history(heights, grid, points, tolerance):
    """Up to the load, down, up again and to twice the load: (load, flat, areas, plastic volume so far) of each step."""
    up = LOAD * np.linspace(0, 1, points + 1)[1:] ** 2
    beyond = LOAD * np.linspace(1, 2, 6)[1:]
    parts = {
        "first loading": up,
        "unloading": up[-2::-1],
        "loading again": np.concatenate((up[1:], beyond)),
    }
    loads = np.concatenate(list(parts.values()))
    steps = rs.follow_loads(heights, grid, STEEL, nominal_pressures=loads, tolerance=tolerance)
    rows, volume = [], 0.0
    for load, (contact, deformed) in zip(loads, steps, strict=True):
        volume += deformed.volume
        rows.append(
            [load, deformed.flat_height, contact.contact_fraction, contact.plastic_fraction, volume]
        )
    ends = np.cumsum([len(part) for part in parts.values()])[:-1]
    return dict(zip(parts, np.split(np.array(rows), ends), strict=True))


def ring_psd(heights, grid, edges):
    """C(q) of a surface in rings of wavenumber, m⁴: ⟨|h_q|²⟩ A₀/4π²."""
    power = (
        np.abs(np.fft.rfft2(heights) / heights.size) ** 2 * np.prod(grid.lengths) / (4 * np.pi**2)
    )
    ring = np.digitize(grid.wavenumbers.ravel(), edges)
    weights = np.broadcast_to(grid.multiplicity, power.shape).ravel()
    total = np.bincount(ring, power.ravel() * weights, len(edges) + 1)[1:-1]
    return total / np.bincount(ring, weights, len(edges) + 1)[1:-1]


def repeats(heights, grid, tolerances):
    """Relative difference of the pressures when the deformed surface is pressed elastically by the same load."""
    found = []
    for tolerance in tolerances:
        first = rs.solve_contact(heights, grid, STEEL, nominal_pressure=LOAD, tolerance=tolerance)
        surface = rs.plastic_deformation(first, heights, grid, STEEL).heights
        elastic = rs.Solid(STEEL.effective_modulus)
        again = rs.solve_contact(surface, grid, elastic, nominal_pressure=LOAD, tolerance=tolerance)
        found.append(
            np.linalg.norm(again.pressure - first.pressure) / np.linalg.norm(first.pressure)
        )
    return np.array(found)


def draw_history(way, area, parts):
    styles = {
        "first loading": (BLUE, "-"),
        "unloading": (ORANGE, "-"),
        "loading again": (BLACK, ":"),
    }
    origin = parts["first loading"][0, 1]
    for name, (colour, line) in styles.items():
        rows = parts[name]
        way.plot(
            (origin - rows[:, 1]) * MICRON, rows[:, 0] * MEGA, color=colour, ls=line, label=name
        )
        area.plot(rows[:, 0] * MEGA, 100 * rows[:, 2], color=colour, ls=line)
    for name, first in (
        ("first loading", 0.0),
        ("loading again", LOAD),
    ):  # on unloading nothing yields
        rows = parts[name][parts[name][:, 0] > first]
        area.plot(rows[:, 0] * MEGA, 100 * rows[:, 3], color=styles[name][0], ls="--", lw=1)
    area.plot([], [], color=GREY, label="contact")
    area.plot([], [], color=GREY, ls="--", lw=1, label="yielded")
    way.set(title="way of the flat", xlabel="way (µm)", ylabel="load (MPa)")
    area.set(title="area", xlabel="load (MPa)", ylabel="share of the cell (%)")
    way.legend(loc="upper left")
    area.legend(loc="lower right")


def draw_profile(axis, heights, deformed, grid):
    row, middle = np.unravel_index(deformed.displacement.argmax(), grid.shape)
    y = (np.arange(grid.shape[1]) - grid.shape[1] // 2) * grid.spacing[1] * MICRON
    shift = grid.shape[1] // 2 - middle
    axis.plot(y, np.roll(heights[row], shift) * MICRON, color=GREY, label="new")
    axis.plot(
        y,
        np.roll(deformed.heights[row], shift) * MICRON,
        color=ORANGE,
        label="after 90 MPa, relieved",
    )
    axis.axhline(deformed.flat_height * MICRON, color=BLUE, label="flat at 90 MPa")
    axis.set(title="profile at the most yielded point", xlabel="$y$ (µm)", ylabel="height (µm)")
    axis.set(xlim=(-300, 300), ylim=(-3.5, heights[row].max() * MICRON * 1.6))
    axis.legend(loc="upper left", ncols=3)


def draw_spectra(axis, heights, deformed, grid):
    load = {"effective_modulus": STEEL.effective_modulus, "nominal_pressure": LOAD}
    spectrum = SCENE.spectrum
    smooth = plasticity.smoothed_spectrum(
        spectrum, penetration_hardness=STEEL.penetration_hardness, **load
    )
    edges = np.geomspace(spectrum.breaks[0], grid.nyquist / 2, max(4, grid.shape[0] // 40))
    edges = edges[np.concatenate(([True], np.diff(edges) > 2 * np.pi / LENGTH))]
    q = np.sqrt(edges[1:] * edges[:-1])
    before, after = (ring_psd(surface, grid, edges) for surface in (heights, deformed.heights))
    axis.loglog(q, before, color=GREY, label="new")
    axis.loglog(q, after, color=ORANGE, label="deformed")
    theory = smooth(q)
    axis.loglog(q, theory, color=BLACK, ls="--", label=r"$C_\mathrm{sm}$")
    axis.set(title="spectrum", xlabel="wavenumber $q$ (rad/m)", ylabel="$C$ (m⁴)")
    decades(axis, y=(before[-1] / 100, 2 * before[0]))
    axis.legend(loc="lower left", handlelength=1.3)
    return q, after / before, theory / spectrum(q)


def draw_patches(axis, top, relieved, grid):
    fields = {
        "contact at 90 MPa": (top.pressure > 0, BLUE),
        "yielded at 90 MPa": (top.pressure == STEEL.penetration_hardness, ORANGE),
        "contact after, at 10 MPa": (relieved.pressure > 0, GREEN),
    }
    for name, (mask, colour) in fields.items():
        found = rs.contact_patches(mask, grid)
        sizes = found.size_distribution()
        middle, some = np.sqrt(sizes.edges[1:] * sizes.edges[:-1]) * MICRON**2, sizes.counts > 0
        axis.loglog(
            middle[some], sizes.density[some] / MICRON**2, "o-", ms=3, color=colour, label=name
        )
        print(
            f"{name}: {found.count} patches, largest {found.largest * MICRON**2:.4g} µm², "
            f"{100 * found.unresolved_share:.1f} % of the area in patches below 4 pixels"
        )
    pixel = np.prod(grid.spacing) * MICRON**2
    axis.axvspan(axis.get_xlim()[0], 4 * pixel, color="0.93", zorder=0)
    axis.margins(x=0)
    axis.set(
        title="patches; grey: below 4 pixels",
        xlabel="area (µm²)",
        ylabel="number per area (1/µm²)",
    )
    decades(axis, y=(1e-7, 1e2))
    axis.legend(loc="lower left")


def main() -> None:
    options = Command(__file__, __doc__).parse()
    points = 64 if options.toy else 1024
    grid = rs.Grid((points, points), (LENGTH, LENGTH))
    spectrum = SCENE.spectrum.truncated(q_max=grid.nyquist / 2)  # four pixels per shortest wave
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(1))
    parts = history(heights, grid, 6 if options.toy else 16, 1e-6)
    top, deformed = next(rs.follow_loads(heights, grid, STEEL, nominal_pressures=[LOAD]))
    relieved = rs.solve_contact(deformed.heights, grid, STEEL, nominal_pressure=10e6)
    tolerances = np.array([1e-2, 1e-6]) if options.toy else 10.0 ** np.arange(-9, -1)
    errors = repeats(heights, grid, tolerances)
    picture = options.output / "unloading.png"
    with new_figure(picture, 8.4) as figure:
        panels = figure.subplot_mosaic("ab;cc;de;ff", height_ratios=(5, 4, 5, 3))
        way, area, profile, psd, patch, repeat = panels.values()
        draw_history(way, area, parts)
        draw_profile(profile, heights, deformed, grid)
        spectra = draw_spectra(psd, heights, deformed, grid)
        draw_patches(patch, top, relieved, grid)
        repeat.loglog(tolerances, errors, "o-", color=ORANGE, label="pressed again")
        repeat.loglog(tolerances, tolerances, color=GREY, label="the tolerance")
        repeat.set(
            title="difference of the pressures", xlabel="tolerance", ylabel="relative difference"
        )
        decades(repeat)
        repeat.legend(loc="upper left")
    if options.evidence:
        show_on_pages(picture)
    tell(parts, top, deformed, errors / tolerances, spectra)


def tell(parts, top, deformed, ratio, spectra):
    rows, again, area = parts["first loading"], parts["loading again"], LENGTH**2
    contact, plastic = rs.corrected_fractions(top.pressure, STEEL.penetration_hardness)
    print(
        f"at 90 MPa: contact {top.contact_fraction:.4f}, yielded {top.plastic_fraction:.4f} of the cell"
    )
    print(
        f"  (corrected for the pixels {contact:.4f}, {plastic:.4f}; load over hardness {90 / 1200:.4f})"
    )
    print(f"  plastic displacement up to {deformed.displacement.max() * MICRON:.3f} µm,")
    print(
        f"  {deformed.volume / area * 1e9:.3f} nm over the cell, plastic work {1.2e9 * deformed.volume / area:.4g} J/m²"
    )
    down = parts["unloading"][-1, 2] / rows[0, 2]
    print(
        f"relieved to {rows[0, 0] * MEGA:.2g} MPa: contact {down:.2f} times that of the first loading"
    )
    repeated, doubled = again[again[:, 0] <= LOAD, 4][-1] / rows[-1, 4], again[-1, 4] / rows[-1, 4]
    print(
        f"pressed again to 90 MPa: {repeated - 1:.1e} of the plastic volume is added; to 180 MPa: {doubled - 1:.2f}"
    )
    print(f"pressures repeat elastically to {ratio.min():.2f} ... {ratio.max():.2f} tolerances")
    q, kept, theory = spectra
    for k in np.unique(np.linspace(0, len(q) - 1, 5).astype(int)):
        print(
            f"  q = {q[k]:8.3g} rad/m: C falls to {kept[k]:.3f}, in the theory to {theory[k]:.3g}"
        )


if __name__ == "__main__":
    main()
