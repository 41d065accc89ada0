"""What scans tell wrongly of a surface, and whether the error that roughsim states for it is right.

    python experiments/scans.py [--toy] [-o FOLDER] [--evidence]

A surface of 4 longest waves a side is drawn with Gaussian amplitudes, and maps are cut out of it. roughsim measures
their C(q) and its error: a plane is taken off, and edges are under a window. The C(q) of the maps and the one that the
surface was drawn from go through the same theory (two like faces of steel, hardness 1.2 GPa), so that all that differs
is the scan's. "inside" counts the draws whose T_flash is within the stated 95 % error. Several maps of one size need
the extra `topography`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from script import Command, write_evidence

import roughsim as rs
from roughsim import prediction
from roughsim.prediction.scans import scan_error
from roughsim.scene.sections import SurfaceSection
from roughsim.surface.topography.measured import combined, levelled, map_spectrum

Q_MIN, Q_MAX, WAVES = 6350.0, 3e5, 4  # rad/m; longest waves on a side of the whole surface
KINDS = {
    "self-affine from the longest wave": (Q_MIN, 0.0),
    "steel, roll-off exponent 1.5": (9.4e4, 1.5),
}
# maps: part of the side of the surface, and where each begins, in its own sides
MAPS = {
    "2": [(2, 0, 0)],
    "1": [(4, 0, 0)],
    "1/2": [(8, 0, 0)],
    "three of 1": [(4, 0, 0), (4, 1, 2), (4, 3, 1)],
    "2 and 1/4": [(2, 0, 0), (16, 9, 9)],
}
WIDE = "2"  # what docs/how-to/topography.md asks for
SPEEDS = (0.001, 35.0)  # m/s
FIRST_SEED = dict(
    zip(KINDS, (3000, 2000), strict=True)
)  # none of them was used to choose the rules


def known(kind):
    """The scene with the C(q) that the surfaces are drawn from."""
    roll_off, exponent = KINDS[kind]
    face = SurfaceSection(
        rms_height=9e-7,
        hurst=0.8,
        q_min=Q_MIN,
        q_roll_off=roll_off,
        q_max=Q_MAX,
        roll_off_exponent=exponent,
    )
    steel = rs.load_scene("steel-1.2GPa")
    return replace(steel, surface=face, sliding=replace(steel.sliding, speed=SPEEDS))


def scanned(scene, maps):
    """The scene with the C(q) of maps, and its errors: pairs of heights, m, as an instrument has them, and sides, m."""
    bins = []
    for heights, side in maps:
        grid = rs.Grid(heights.shape, (side, side))
        bins.append(map_spectrum(levelled(heights), grid, periodic=False))
    spectrum, errors = combined(bins)
    rows = tuple(zip(spectrum.q.tolist(), spectrum.psd.tolist(), strict=True))
    kept = tuple(map(tuple, errors.tolist()))
    face = SurfaceSection(psd=rows, psd_convention="persson", psd_source="scan", psd_error=kept)
    return replace(scene, surface=face)


def flash(scene):
    """T_flash at each speed, K."""
    return prediction.over_speed(scene, np.array(scene.speeds), names=("flash_temperature",))[
        "flash_temperature"
    ]


def draws(kind, maps, points, seeds):
    """T_flash of scans over that of the known C(q), minus one, and its stated error: percent, (seeds, speeds)."""
    scene, side = known(kind), WAVES * 2 * np.pi / Q_MIN
    grid = rs.Grid((points, points), (side, side))
    found, stated = [], []
    for seed in seeds:
        heights = rs.synthesize(
            scene.faces[0], grid, np.random.default_rng(seed), amplitudes="gaussian"
        )
        cuts = []
        for part, i, j in maps:
            n = points // part
            cuts.append((heights[i * n : (i + 1) * n, j * n : (j + 1) * n], side / part))
        scan = scanned(scene, cuts)
        found.append(flash(scan) / flash(scene) - 1)
        stated.append(
            scan_error(scan, "flash_temperature")["flash_temperature"] * flash(scan) / flash(scene)
        )
    return 100 * np.array(found), 100 * np.array(stated)


def main():
    """Print errors and how often the stated ones hold, and draw them over the side of the scan."""
    options = Command(__file__, __doc__, "one draw of each kind").parse()
    figure = Figure(figsize=(5, 3.2), layout="constrained")
    axes = figure.subplots()
    rows = []
    for kind, marker in zip(KINDS, "os", strict=True):
        for x, (name, maps) in enumerate(MAPS.items()):
            first = FIRST_SEED[kind]
            found, stated = draws(kind, maps, 512, first + np.arange(1 if options.toy else 100))
            inside, known = (np.abs(found) <= stated).sum(axis=0), np.isfinite(stated).sum(axis=0)
            row = {
                "kind": kind,
                "maps": name,
                "off": found[:, -1].mean(),
                "scatter": found[:, -1].std(),
            }
            rows.append(row | {"inside": inside.tolist(), "known": known.tolist()})
            print(
                f"{kind}, sides {name} longest waves: off by {row['off']:+.0f} ± {row['scatter']:.0f} %,"
            )
            if known[-1]:
                print(
                    f"    stated {np.median(stated[np.isfinite(stated[:, -1]), -1]):.0f} % (median),"
                )
            print(f"    inside {inside} of {known} known at {SPEEDS} m/s", flush=True)
            axes.plot(
                np.full(len(found), x),
                found[:, -1],
                marker,
                mfc="none",
                ms=3,
                label=None if x else kind,
            )
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.set(xlabel="sides of the scans, longest waves", ylabel="T_flash of the scan, off by %")
    axes.set_xticks(range(len(MAPS)), list(MAPS))
    axes.legend(frameon=False)
    figure.savefig(options.output / "scans.png", dpi=150)
    if options.evidence:
        write_evidence(
            "scans", "python experiments/scans.py --evidence", rows=rows, numbers=quoted(rows)
        )


def quoted(rows):
    """The numbers of docs/how-to/topography.md, %: scatter of wide scans at the highest speed, errors that hold.

    These are the errors of both speeds, of all scans whose error is known.
    """
    wide = [row["scatter"] for row in rows if row["maps"] == WIDE]
    inside, known = (sum(sum(row[name]) for row in rows) for name in ("inside", "known"))
    return {
        "wide_least": min(wide),
        "wide_most": max(wide),
        "known": known,
        "inside": 100 * inside / known,
    }


if __name__ == "__main__":
    main()
