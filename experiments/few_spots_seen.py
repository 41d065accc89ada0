"""What a camera sees of light contacts with few spots in view: `seen_99` of runs against many pictures together.

    python experiments/few_spots_seen.py [--toy] [-o FOLDER] [--runs N] [--cells N] [--tune] [--evidence]

Scenes are drawn with a seed, a third of them elastic, each with a speed, a point spread, and an exposure from the
counterface or from the body. They slide from rest by at most half of the cell, so that a picture has all of its heat,
and C(q) ends at the highest cut-off of their runs: only scatter and bias are left. The reference puts the pixels of N
pictures together, each of twice the sides of those of a run, and sorts them; each is one sum over waves, by the
formulas of Carslaw and Jaeger for one wave from rest. "own" is the mean quantile of many pictures of the size of a
run over that of the same pictures together: the bias of a mean over pictures. An interval holds the reference
if they are no further apart than both errors (95 %, added as squares). --tune has other scenes.
"""

from __future__ import annotations

from math import inf, log, pi, sqrt
from pathlib import Path
from typing import Any

import few_spots
import numpy as np
from few_spots import CELL, CONDUCTIVITY, DENSITY, FRICTION, HEAT
from scipy.special import wofz
from script import Command, Row, Rows, write_evidence

import roughsim as rs

JUDGE, TUNE = 20270218, 20270319  # seeds of scenes
SCENES, BLOCKS = 9, 10
EXCEEDED = 0.01


def drawn(seed: int) -> list[dict[str, Any]]:
    """Draw modulus, hardness, load, roll-off, slope, H, and the camera with its slide."""
    rng = np.random.default_rng(seed)
    scenes = []
    for number in range(SCENES):
        hardness = 1e9 * 4.0 ** rng.uniform()
        one = {
            "modulus": 1e11 * 2.0 ** rng.uniform(),
            "hardness": None if number % 3 == 2 else hardness,
            "pressure": hardness * 0.01 * 6.0 ** rng.uniform(),
            "plateau": 1.5 * 2.0 ** rng.uniform(),  # q_r/q_min
            "slope": 0.1 * 3.0 ** rng.uniform(),
            "hurst": rng.uniform(0.5, 0.9),
            "speed": 0.3 * 100.0 ** rng.uniform(),
            "slid": CELL * rng.uniform(0.15, 0.5),
            "resolution": 5e-6 * 12.0 ** rng.uniform(),
            "on_body": bool(rng.uniform() < 0.5),
            "smear": 10e-6 * 10.0 ** rng.uniform(),
        }
        scenes.append(one)
    return scenes


def scene_of(one: dict[str, Any], points: int) -> rs.Scene:
    """Return the scene of a run, with two levels up to the end of C(q)."""
    sections = few_spots.sections_of(one, points)
    sections["sliding"] |= {"speed": [one["speed"]], "duration": one["slid"] / one["speed"]}
    sections["camera"] = {
        "resolution": one["resolution"],
        "exposure": one["smear"] / one["speed"],
        "fixed_to": "body" if one["on_body"] else "counterface",
    }
    del sections["observables"]
    return rs.load_scene(sections)


def picture(one: dict[str, Any], pressure: np.ndarray, side: float) -> np.ndarray:
    """Return the picture of a contact about the mean of the surface, K."""
    n = len(pressure)
    qx = 2 * pi * np.fft.fftfreq(n, side / n)[:, None]
    qy = 2 * pi * np.fft.rfftfreq(n, side / n)[None]
    diffusivity = CONDUCTIVITY / DENSITY / HEAT
    q2 = qx**2 + qy**2
    q2[0, 0] = 1.0
    waves = np.sqrt(q2 - 1j * qx * one["speed"] / diffusivity)
    turned = waves * sqrt(diffusivity * one["slid"] / one["speed"])
    heated = (1.0 - np.exp(-(turned**2)) * wofz(1j * turned)) / (CONDUCTIVITY * waves)
    heated[0, 0] = 0.0
    blur = np.exp(-q2 * one["resolution"] ** 2 / (16.0 * log(2.0)))
    if one["on_body"]:
        blur = blur * np.sinc(qx * one["smear"] / (2.0 * pi))
    flux = FRICTION * one["speed"] * np.fft.rfft2(pressure)
    return np.fft.irfft2(flux * heated * blur, s=pressure.shape)


def pictures(one: dict[str, Any], points: int, wide: int, cells: int) -> list[np.ndarray]:
    """Return sorted pictures of cells so many times as wide as those of a run."""
    spectrum = scene_of(one, points).spectrum
    side = wide * CELL
    grid = rs.Grid((wide * points,) * 2, (side, side))
    solid = rs.Solid(one["modulus"] / (1 - 0.3**2), one["hardness"] or inf)
    found = []
    for stream in np.random.SeedSequence([JUDGE, wide]).spawn(cells):
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(stream))
        contact = rs.solve_contact(
            heights, grid, solid, nominal_pressure=one["pressure"], tolerance=1e-3
        )
        found.append(np.sort(picture(one, contact.pressure, side).ravel()))
    return found


def reference(one: dict[str, Any], points: int, cells: int) -> Row:
    """Return the quantile of all pictures together, and the mean of those of pictures as wide as a run, K."""
    whole = pictures(one, points, 2, cells)
    blocks = [whole[b::BLOCKS] for b in range(min(BLOCKS, cells))]
    others = [
        together([cell for other in blocks if other is not block for cell in other])
        for block in blocks
    ]
    error = sqrt((len(blocks) - 1) * np.var(others))  # jackknife
    small = pictures(one, points, 1, 4 * cells)
    own = [together([cell]) for cell in small]
    return {
        "seen_99": together(whole),
        "error": 2.3 * error,
        "small": together(small),
        "own": float(np.mean(own)),
    }


def together(cells: list[np.ndarray]) -> float:
    """Return what `EXCEEDED` of all pixels exceeds, K."""
    pixels = np.concatenate(cells)
    place = int(pixels.size * (1.0 - EXCEEDED))
    return float(np.partition(pixels, place)[place])


def run_of(scene: rs.Scene, seed: int, most: int, folder: Path) -> Row:
    """Return `seen_99` of a run, K, and its error by scatter and cell."""
    run = rs.run(scene, folder, seed=seed, until={}, max_realizations=most)
    found = run.estimate("seen_99")
    parts = [float(found.budget[part][0]) for part in ("statistical", "size")]
    return {"seen_99": float(found.mean[0]), "error": float(np.linalg.norm(parts))}


def judged(rows: Rows, runs: int) -> dict[str, float]:
    """Print and return departures from the references in %, and how many intervals hold them."""
    bias, own, held, unknown = [], [], [], 0
    for place, exact in rows["reference"].items():
        truth, error, small = (float(exact[name]) for name in ("seen_99", "error", "small"))
        own.append(100 * (float(exact["own"]) / small - 1))
        here = []
        for seed in range(runs):
            found = rows["runs"][f"{place} {seed}"]
            value, part = float(found["seen_99"]), float(found["error"])
            here.append(100 * (value / truth - 1))
            if np.isnan(part):
                unknown += 1
            else:
                held.append(abs(value - truth) <= np.hypot(part, error))
        bias += here
        print(
            f"{place}: {truth:.4g} K ± {100 * error / truth:.1f} %; cells of a run {100 * (small / truth - 1):+.1f} %, own "
            f"{own[-1]:+.1f} %, runs " + ", ".join(f"{x:+.1f} %" for x in here)
        )
    print(
        f"own {np.mean(own):+.2f} %, at most {np.abs(own).max():.2f} %; runs {np.mean(bias):+.1f} % (rms "
        f"{np.std(bias):.1f}), {sum(held)} of {len(held)} hold, {unknown} unknown"
    )
    return {
        "own": float(np.mean(own)),
        "own_worst": float(np.abs(own).max()),
        "runs": float(np.mean(bias)),
        "held": int(sum(held)),
        "known": len(held),
    }


def main() -> None:
    command = Command(__file__, __doc__, "two runs of one scene, of 64² points")
    command.add_argument("--runs", type=int, default=4, help="runs of each scene")
    command.add_argument("--cells", type=int, default=100, help="cells of a reference")
    command.add_argument("--tune", action="store_true", help="other scenes")
    options = command.parse()
    points, most, runs, cells = (
        (64, 6, 2, 6) if options.toy else (128, 24, options.runs, options.cells)
    )
    name = "tune" if options.tune else "judge"
    rows = Rows(options.output / f"{name}.json", resume=not options.toy)
    scenes = drawn(TUNE if options.tune else JUDGE)[: 1 if options.toy else None]
    few_spots.fill(
        rows,
        [scene_of(one, points) for one in scenes],
        runs,
        lambda place: reference(scenes[place], points, cells),
        lambda scene, seed, own: run_of(scene, seed, most, options.output / f"{name}-{own}"),
    )
    numbers = judged(rows, runs)
    if options.evidence:
        command_line = "python experiments/few_spots_seen.py --evidence"
        write_evidence("few_spots_seen", command_line, numbers=numbers)


if __name__ == "__main__":
    main()
