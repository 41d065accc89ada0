"""What the pixel and the cut-off of a slide change of its ratio to frozen contact.

    python experiments/sliding_pixel.py [--toy] [-o FOLDER]

Two rough faces of five pairs of bodies, of which the contact yields at all waves, at some or at none. The same faces at
cut-offs from 4 q_y (or the end of C(q)) to four times that, with 3 to 16 pixels per shortest wave. Printed: T_flash of
the slide over that of the same contacts slid on frozen, against the ratio with 4 pixels at the lowest cut-off.
Correction: what a run makes of 3 and 4 pixels (`roughsim.estimate.sliding`); its test is the ratio with 8 and 16.
"""

from __future__ import annotations

from math import inf, pi
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.sliding import ORDERS
from roughsim.surface.synthesis import synthesize

SPEEDS = (1.5, 15.0)
STEEL = {
    "youngs_modulus": 2e11,
    "poisson_ratio": 0.3,
    "conductivity": 30.0,
    "density": 7900.0,
    "heat_capacity": 500.0,
}
BRASS = {"youngs_modulus": 1.1e11, "poisson_ratio": 0.34, "penetration_hardness": 1.5e9}
BRASS |= {"conductivity": 120.0, "density": 8500.0, "heat_capacity": 380.0}
ALUMINIUM = {"youngs_modulus": 7e10, "poisson_ratio": 0.33, "penetration_hardness": 0.6e9}
ALUMINIUM |= {"conductivity": 160.0, "density": 2700.0, "heat_capacity": 900.0}


def face(
    rms_height: float, hurst: float, q_min: float, q_roll_off: float, q_max: float
) -> dict[str, float]:
    """Return the keys of a self-affine C(q)."""
    return {
        "rms_height": rms_height,
        "hurst": hurst,
        "q_min": q_min,
        "q_roll_off": q_roll_off,
        "q_max": q_max,
    }


def pair(surface: dict, body: dict, counterface: dict, load: float, friction: float) -> rs.Scene:
    """Return a scene of two rough faces."""
    sliding = {"nominal_pressure": load, "friction_coefficient": friction, "speed": SPEEDS}
    return rs.load_scene(
        {"surface": surface, "body": body, "counterface": counterface, "sliding": sliding}
    )


SCENES = {
    "steel-1.2GPa": rs.load_scene("steel-1.2GPa"),
    "steel-0.5GPa": rs.load_scene("steel-0.5GPa"),
    "brass on steel": pair(
        face(0.5e-6, 0.6, 1e4, 3e4, 1e7), BRASS, face(0.8e-6, 0.9, 1e4, 3e4, 1e7) | STEEL, 2e7, 0.3
    ),
    "aluminium on steel": pair(
        face(2e-6, 0.7, 3e3, 1.2e4, 1e7),
        ALUMINIUM,
        face(1e-6, 0.8, 3e3, 3e4, 1e7) | STEEL,
        5e6,
        0.3,
    ),
    "elastic steel": pair(face(1e-7, 0.8, 2e4, 6e4, 6e5), STEEL, {"like": "body"}, 1e8, 0.2),
}


def change(scene: rs.Scene, length: float, points: int, q_max: float, index: int) -> np.ndarray:
    """Return T_flash of a slide over one cell, over that of the same contacts frozen, mean of the last half."""
    grid, bodies = rs.Grid((points, points), (length, length)), scene.conduction()
    streams = np.random.SeedSequence(77, spawn_key=(index,)).spawn(
        2
    )  # the same waves on every grid
    faces = [side.truncated(q_max=min(q_max, side.breaks[-1])) for side in scene.sliding_faces]
    resting, moving = (
        synthesize(side, grid, np.random.default_rng(s))
        for side, s in zip(faces, streams, strict=True)
    )
    slid = rs.slide(
        resting,
        grid,
        rs.Solid(scene.effective_modulus, scene.penetration_hardness),
        nominal_pressure=scene.sliding.nominal_pressure,
        friction_coefficient=scene.friction_coefficient(),
        speed=SPEEDS,
        moving=rs.Body(bodies.conductivity, bodies.diffusivity),
        resting=rs.Body(bodies.counter_conductivity, bodies.counter_diffusivity),
        counter_heights=moving,
        slid_distance=length,
        tolerance=1e-3,
    )
    late = slid.slid_distance > length / 2
    return slid.flash_temperature[:, late].mean(axis=1) / slid.frozen_flash_temperature[
        :, late
    ].mean(axis=1)


def draw(changes: dict[str, dict[int, np.ndarray]], path: Path) -> None:
    """Draw what pixels change at the lowest cut-off, %: arrays over speed by scene and pixels per shortest wave."""
    figure = Figure((6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    colours = ("#0072B2", "#56B4E9", "#E69F00", "#009E73", "#CC79A7")
    for (name, of_scene), colour in zip(changes.items(), colours, strict=False):
        for k, (speed, line) in enumerate(zip(SPEEDS, ("o--", "o-"), strict=True)):
            values = [of_scene[pixels][k] for pixels in of_scene]
            axes.plot(
                list(of_scene), values, line, ms=4, color=colour, label=f"{name}, {speed:g} m/s"
            )
    axes.axhline(0.0, color="0.7", lw=0.8)
    axes.set_xscale("log", base=2)
    axes.set_xticks((3, 4, 8, 16), ("3", "4", "8", "16"))
    axes.set(xlabel="pixels per shortest wave", ylabel="sliding/frozen, change from 4 pixels (%)")
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=150)


def main() -> None:
    options = Command(__file__, __doc__, "one scene at 3 and 4 pixels per shortest wave").parse()
    drawn: dict[str, dict[int, np.ndarray]] = {}
    points, most = 128, 1 if options.toy else 4
    names = ["elastic steel"] if options.toy else SCENES
    weight = np.mean([1 / ((4 / 3) ** order - 1) for order in ORDERS])
    print(
        "ratio of sliding to frozen, against 4 pixels per shortest wave at the lowest cut-off, %, at 1.5 and 15 m/s"
    )
    for name in names:
        scene = SCENES[name]
        yields = inf if scene.elastic else prediction.yield_wavenumber(scene)
        lowest = min(4 * yields, scene.spectrum.breaks[-1]) * (1 - 1e-9)
        length = points * 2 * pi / (4 * lowest)
        first = change(scene, length, points, lowest, 0)
        for times in (1, 2, 4):
            if times > most or (times > 1 and scene.elastic):
                continue
            pixels = [p for p in (3, 4, 8, 16) if p * times <= 4 * most]
            ratios = {
                p: change(scene, length, points * times * p // 4, times * lowest, 0) for p in pixels
            }
            corrected = ratios[4] + weight * (ratios[4] - ratios[3])
            if times == 1:
                drawn[name] = {p: 100 * (ratio / first - 1) for p, ratio in ratios.items()}
            shown = {f"{p} px": 100 * (ratio / first - 1) for p, ratio in ratios.items()}
            shown["3 and 4 px, corrected"] = 100 * (corrected / first - 1)
            words = "; ".join(f"{key} {low:+.2f} {high:+.2f}" for key, (low, high) in shown.items())
            print(f"{name}, q_c × {times}: {words}", flush=True)
    draw(drawn, options.output / "sliding_pixel.png")


if __name__ == "__main__":
    main()
