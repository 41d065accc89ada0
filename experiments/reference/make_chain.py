"""The limit that the chart of the whole chain measures errors against, checked by a ladder of its own.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/reference/make_chain.py [--members N] [-o FILE]

The chart (accuracy_vs_cost.py chain) takes the plan's own ladder over all members as the truth. Here the same members
are solved up to four times the plan's largest cut-off, with two pixels per shortest wave instead of four and finer, and
taken to the end of the spectrum as a geometric row over the last three octaves. Out comes T_flash by both ladders, with
the error of this one, as a JSON file; experiments/reference/chain.json is the last one.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np

import roughsim as rs
from roughsim.estimate.ladder import observe
from roughsim.observables.record import Sample
from roughsim.planning.realization import realize

SEED = 21  # of the chart: the same surfaces
PIXELS = 2.0
DOUBT = 0.1  # of what lies beyond the ladder, beside what its last rung changed


def deeper(scene, numerics, most):
    """Levels of an octave each from the plan's first cut-off on, at two pixels per shortest wave."""
    first, side = next(x for x in numerics.levels if x.column == "capped"), max(numerics.lengths)
    levels, q_max = [], first.q_max
    while (points := 2 * round(0.5 * PIXELS * q_max * side / 2 / pi + 0.499)) <= most:
        levels.append(rs.Level("capped", (points, points), min(q_max, scene.spectrum.q_max)))
        q_max *= 2.0
    return replace(numerics, levels=tuple(levels), forecast=None)


def temperatures(scene, numerics, members):
    """T_flash of every level, member and speed, K."""
    rows = [
        [realize(scene, numerics, seed=SEED, level=k, index=i).observables.flash_temperature for i in range(members)]
        for k in range(len(numerics.levels))
    ]
    return np.array(rows)


def limit(values, cutoffs, end):
    """Of the last three rungs, an octave apart, what they tend to at the cut-off `end`."""
    a, b, c = values[-3:]
    share = np.clip((c - b) / (b - a), 0.2, 0.8)
    return c + (c - b) * share / (1 - share) * (1 - (cutoffs[-1] / end) ** -np.log2(share))


def planned(scene, numerics, members):
    """T_flash at the end of the spectrum by the plan's ladder, over all its levels and the same members."""
    levels = [replace(level, every=1) for level in numerics.levels if level.column == "capped"]
    rows, nothing = np.arange(members, dtype=np.intp), np.ones(1)
    found = temperatures(scene, replace(numerics, levels=tuple(levels), forecast=None), members)
    samples = [
        Sample(x.q_max, float(x.shape[0]), rows, {"flash_temperature": v}, nothing, np.ones((members, 1)), 1.0)
        for x, v in zip(levels, found, strict=True)
    ]
    values = observe("flash_temperature", samples, capped=True, end=scene.spectrum.q_max)
    return values.extrapolated.mean(0), np.hypot(values.bandwidth, values.pixel)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--members", type=int, default=6, help="surfaces")
    options.add_argument("--scene", default="steel-1.2GPa", help="a capped scene, by name or path")
    options.add_argument("-o", "--output", type=Path, default=Path("runs/chain.json"), help="file")
    given = options.parse_args()
    scene, members = rs.load_scene(given.scene), given.members
    numerics = rs.plan(scene)
    deep = deeper(scene, numerics, 4100)
    cutoffs, end = [level.q_max for level in deep.levels], scene.spectrum.q_max
    values = temperatures(scene, deep, members).mean(1)
    truth, before = limit(values, cutoffs, end), limit(values[:-1], cutoffs[:-1], end)
    error = np.hypot(truth - before, DOUBT * (truth - values[-1]))
    own, doubt = planned(scene, numerics, members)
    rows = zip(scene.speeds, truth, error, own, doubt, strict=True)
    keys = ("speed", "reference", "error", "plan", "doubt")
    result = {"scene": given.scene, "seed": SEED, "members": members, "points": [x.shape[0] for x in deep.levels]}
    result["rows"] = [dict(zip(keys, (float(f"{x:.6g}") for x in row), strict=True)) for row in rows]
    given.output.parent.mkdir(parents=True, exist_ok=True)
    given.output.write_text(json.dumps(result, indent=1) + "\n")
    for row in result["rows"]:
        print(
            "{speed:8g} m/s: {reference:8.4g} ± {error:.2g} K, the plan's ladder {plan:8.4g} ± {doubt:.2g} K".format(
                **row
            )
        )


if __name__ == "__main__":
    main()
