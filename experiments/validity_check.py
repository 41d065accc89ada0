"""Attack the map of validity: scenes drawn at random inside it, off its points, simulated and set beside what it says.

    python experiments/validity_check.py [--toy] [-o FOLDER] [--workers N]

A statement "theory is 54 +- 3 % high" holds if the simulation, with its own error, agrees with it. The scenes are drawn
with a fixed seed, elastic and capped; no point of the map lies at them, and no member of the map is used again.
"""

from __future__ import annotations

import warnings
from math import hypot, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from script import Command
from validity_map import capped

import roughsim as rs
from roughsim import prediction
from roughsim.comparison.trust import trust
from roughsim.scene import parse_scene
from theory import persson

SEED, ROLL_OFF, MODULUS, SLOPE, DIFFUSIVITY = 20261122, 2e4, 1e11, 0.02, 30.0 / (7900 * 500)
OBSERVABLES = ("flash_temperature", "flash_gradient", "flash_width", "slope_length", "pressure_variance")
TEXT = """
title = "{title}"
[surface]
rms_slope = {slope}
hurst = {hurst}
q_min = {q_min}
q_roll_off = {q_roll_off}
q_max = {q_max}
[body]
youngs_modulus = {modulus}
poisson_ratio = 0
conductivity = 30
density = 7900
heat_capacity = 500
{hardness}
[sliding]
nominal_pressure = {pressure}
friction_coefficient = 0.1
speed = {speeds}
[theory]
gamma = 0.45
[ensemble]
seed = {seed}
max_realizations = {most}
until = {{ flash_temperature = "{target} %" }}
"""


def drawn(elastic: int, plastic: int, light: int, far: int) -> list[dict[str, Any]]:
    """Return coordinates inside the map, log-uniform but for H; `light` and `far`: where it bends most, H below 0.45,
    and a C(q) that ends beyond the last finite q_max of the map.
    """
    rng = np.random.default_rng(SEED)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def peclets() -> tuple[float, ...]:
        return tuple(sorted(between(2e-3, 8e2) for _ in range(3)))

    def smooth(hurst: float) -> dict[str, Any]:
        return {"load": between(4e-3, 0.5), "hurst": float(rng.uniform(0.3, hurst)), "bandwidth": between(4.2, 32.0)}

    def hard(hurst: float, depth: tuple[float, float]) -> dict[str, Any]:
        share, yields = between(0.012, 0.45), between(1.03, 1.95)
        return {"share": share, "yields": yields, "hurst": float(rng.uniform(0.3, hurst)), "depth": between(*depth)}

    places = [smooth(1.0) | {"peclet": peclets()} for _ in range(elastic)]
    places += [hard(0.8, (4.2, 40.0)) | {"peclet": peclets()} for _ in range(plastic)]
    places += [smooth(0.45) | {"peclet": peclets()} for _ in range(light)]
    places += [hard(0.45, (4.2, 12.0)) | {"peclet": peclets()} for _ in range(light)]
    return places + [hard(0.8, (70.0, 1000.0)) | {"peclet": peclets()} for _ in range(far)]


def scene_at(place: dict[str, Any], number: int, *, target: float, most: int) -> rs.Scene:
    """Return a scene with these coordinates."""
    if "load" in place:
        slope, q_max = SLOPE, place["bandwidth"] * ROLL_OFF
        pressure, hardness = place["load"] * MODULUS * SLOPE, ""
    else:  # the map's C(q) has the slope 1 up to its far end; this one ends at q_max
        point = capped.CappedPoint(place["share"], place["yields"], place["hurst"])
        q_max = place["depth"] * place["yields"]
        ends = (q_max, point.spectrum.q_max)
        kept, whole = (persson.half_variance(q, point.spectrum, effective_modulus=1.0) for q in ends)
        slope, q_max = SLOPE * float(np.sqrt(kept / whole)), q_max * ROLL_OFF
        pressure = place["share"] * point.hardness * MODULUS * SLOPE
        hardness = f"penetration_hardness = {point.hardness * MODULUS * SLOPE}"
    return parse_scene(
        TEXT.format(
            title=f"check {number}",
            slope=slope,
            hurst=place["hurst"],
            q_min=ROLL_OFF / 2,
            q_roll_off=ROLL_OFF,
            q_max=q_max,
            modulus=MODULUS,
            hardness=hardness,
            pressure=pressure,
            speeds=[pe * DIFFUSIVITY * ROLL_OFF for pe in place["peclet"]],
            seed=number + 100,
            most=most,
            target=target,
        )
    )


def checked(scene: rs.Scene, run: Any) -> list[dict[str, Any]]:
    """Return, for every statement of the map, what it says and what the run gives, in % of theory/measured - 1."""
    known, own, rows = trust(scene), prediction.predictions(scene), []
    for j in known.judgements:
        if j.observable not in OBSERVABLES:
            continue
        k = 0 if j.speed is None else scene.speeds.index(j.speed)
        found = run.estimate(j.observable)
        percent = 100 * (float(own[j.observable][k]) / float(found.mean[k]) - 1)
        error = (100 + percent) * float(found.total_error[k] / abs(found.mean[k]))
        holds = abs(percent - j.percent) <= hypot(j.error, error)
        rows.append({"observable": j.observable, "speed": j.speed, "says": j.percent, "error": j.error})
        rows[-1] |= {
            "found": percent,
            "found_error": error,
            "holds": holds,
            "kind": "elastic" if scene.elastic else "capped",
        }
    return rows


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """What is found less what the map says of T_flash, over what it says: bars are the errors of both."""
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for kind, colour in (("elastic", "#0072b2"), ("capped", "#d55e00")):
        some = [r for r in rows if (r["kind"], r["observable"]) == (kind, "flash_temperature")]
        said, off = np.array([r["says"] for r in some]), np.array([r["found"] - r["says"] for r in some])
        error = np.array([hypot(r["error"], r["found_error"]) for r in some])
        axes.errorbar(said, off, error, fmt="o", ms=3, lw=0.8, color=colour, label=kind)
    axes.axhline(0.0, color="0.3", lw=0.8)
    axes.set(xlabel="the map: theory is high by, %", ylabel="simulation less map, %", title=r"$T_\mathrm{flash}$")
    figure.legend(loc="outside right upper")  # inside it would hide bars
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "two scenes with few members, to see it work")
    command.add_argument("--workers", type=int, default=1, help="processes")
    options = command.parse()
    warnings.simplefilter("ignore", RuntimeWarning)
    places = drawn(12, 12, 4, 4)
    chosen = [places[1], places[23]] if options.toy else places
    rows = []
    for place in chosen:
        number = places.index(place)
        scene = scene_at(place, number, target=20.0 if options.toy else 1.5, most=12 if options.toy else 100)
        run = rs.run(scene, options.output / f"{number}", workers=options.workers)
        words = ", ".join(f"{name} {x:.3g}" for name, x in place.items() if name != "peclet")
        print(f"{number}: {words}; n = {run.realizations}", flush=True)
        for row in checked(scene, run):
            at = "" if row["speed"] is None else f"Pe {row['speed'] / DIFFUSIVITY / ROLL_OFF:.3g}"
            said = f"{row['says']:+7.1f} +- {row['error']:.1f}"
            measured = f"{row['found']:+7.1f} +- {row['found_error']:.1f}"
            print(
                f"  {row['observable']:18} {at:10} said {said}, found {measured}{'' if row['holds'] else '   MISSED'}"
            )
            rows.append(row)
    draw(rows, options.output / "validity_check.png")
    for kind in ("elastic", "capped"):
        for name in OBSERVABLES:
            some = [r for r in rows if (r["kind"], r["observable"]) == (kind, name) and isfinite(r["found"])]
            if some:
                print(f"{kind} {name}: {sum(row['holds'] for row in some)} of {len(some)} statements hold")


if __name__ == "__main__":
    main()
