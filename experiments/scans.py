"""What one scan tells wrongly: maps cut out of surfaces of known C(q), and the theory's T_flash of either.

    python experiments/scans.py [--toy] [-o FOLDER]

A surface of 4 longest waves a side is drawn with Gaussian amplitudes, a square of it is cut out and written as an
instrument would, and roughsim reads its C(q) back: a plane is taken off, and edges are under a window. Both C(q) go
through the same theory (two like faces of steel, hardness 1.2 GPa, 35 m/s), so that all that differs is the scan's.
Needs the extra `topography`.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim import prediction
from roughsim.scene.sections import SurfaceSection
from roughsim.surface.topography import read_topography

Q_MIN, Q_MAX, WAVES = 6350.0, 6e5, 4  # rad/m; longest waves on a side of the whole surface
KINDS = {"self-affine from the longest wave": (Q_MIN, 0.0), "steel, roll-off exponent 1.5": (9.4e4, 1.5)}
PARTS = (2, 4, 8)  # of the side that are cut out


def known(kind):
    """The scene with the C(q) that the surfaces are drawn from."""
    roll_off, exponent = KINDS[kind]
    face = SurfaceSection(
        rms_height=9e-7, hurst=0.8, q_min=Q_MIN, q_roll_off=roll_off, q_max=Q_MAX, roll_off_exponent=exponent
    )
    return replace(rs.load_scene("steel-1.2GPa"), surface=face)


def scanned(scene, heights, side):
    """The scene with the C(q) of a map, read from a file."""
    import SurfaceTopography

    with TemporaryDirectory() as folder:
        place = str(Path(folder) / "scan.nc")
        SurfaceTopography.Topography(heights, (side, side), unit="m", periodic=False).to_netcdf(place)
        spectrum = read_topography(place).spectrum
    rows = tuple((float(q), float(psd)) for q, psd in zip(spectrum.q, spectrum.psd, strict=True))
    return replace(scene, surface=SurfaceSection(psd=rows, psd_convention="persson", psd_source="scan"))


def hottest(scene):
    """T_flash at 35 m/s, K."""
    return float(prediction.predictions(scene)["flash_temperature"][list(scene.speeds).index(35.0)])


def errors(kind, part, points, seeds):
    """T_flash of scans over that of the known C(q), minus one, in percent."""
    scene, side = known(kind), WAVES * 2 * np.pi / Q_MIN
    grid = rs.Grid((points, points), (side, side))
    found = []
    for seed in range(seeds):
        heights = rs.synthesize(scene.faces[0], grid, np.random.default_rng(seed), amplitudes="gaussian")
        cut = points // part
        found.append(100 * (hottest(scanned(scene, heights[:cut, :cut], side / part)) / hottest(scene) - 1))
    return np.array(found)


def main():
    """Print the errors, and draw them over the side of the scan."""
    options = Command(__file__, __doc__, "one scan of each kind").parse()
    warnings.simplefilter("ignore", ImportWarning)  # SurfaceTopography says that there is no MPI
    figure = Figure(figsize=(5, 3.2), layout="constrained")
    axes = figure.subplots()
    for kind, marker in zip(KINDS, "os", strict=True):
        for part in PARTS[-1:] if options.toy else PARTS:
            found = errors(kind, part, 1024, 1 if options.toy else 10)
            print(f"{kind}, side {WAVES / part:g} longest waves: mean {found.mean():+.0f} %, ", end="")
            print(f"{found.min():+.0f} to {found.max():+.0f} %")
            axes.plot(np.full(found.size, WAVES / part), found, marker, mfc="none", label=kind if part == 8 else None)
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.set(xlabel="side of the scan, longest waves", ylabel="T_flash of the scan, off by %", xscale="log")
    axes.set_xticks([WAVES / part for part in PARTS], [f"{WAVES / part:g}" for part in PARTS])
    axes.legend(frameon=False)
    figure.savefig(options.output / "scans.png", dpi=150)


if __name__ == "__main__":
    main()
