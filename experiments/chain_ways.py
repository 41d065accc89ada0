"""Other ways to T_flash than a run: one grid with a mean over surfaces, the paper's theory, the calibrated law.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/chain_ways.py [--toy] [-o FOLDER] [--evidence]

Six scenes with deep references (reference/deep.json, by reference/make_deep.py). One grid has 2, 4 or 8 pixels per
shortest wave in the cell of the plan for 1 %, and as much of C(q) as 1024² points hold. The mean over --members
surfaces and their scatter give the error of any number of members; what is beyond the cut-off, and the pixel, stay. All
heat is in the moving body. The error counts at the worst speed of a scene. Rows in FOLDER/ways.json are not computed
again. The lines of roughsim and the plain script in the figure are from benchmarks/chain.py.
"""

import json
import time
from functools import partial
from math import pi, sqrt
from statistics import median

import figures
import numpy as np
from reference import make_deep
from script import EVIDENCE, Command, Rows, write_evidence

import roughsim as rs
from roughsim import prediction

MOST = 1024  # points per side of the one grid
TARGET = 0.01  # of the plan whose cell it has
SEED = 77_001  # of these surfaces alone


def one_grid(name, case, pixels, members, most):
    """Bias of T_flash against the reference, its standard error by one member, and CPU seconds of a member."""
    length = rs.plan(case.scene, TARGET).lengths[0]
    q_max = min(case.scene.spectrum.breaks[-1], 2 * pi * most / (pixels * length))
    points = min(most, make_deep.side(q_max, length, pixels))
    level = rs.Level("elastic" if case.scene.elastic else "capped", (points, points), q_max)
    speeds = len(case.scene.speeds)
    make_deep.moments(case, level, length, members, SEED)  # kernels and plans are there by now
    start = time.process_time()
    values = np.stack(
        [make_deep.moments(case, level, length, k, SEED)[:speeds] for k in range(members)]
    )
    seconds = (time.process_time() - start) / members
    truth, doubt = reference(case)
    return {
        "scene": name,
        "way": f"one grid, {pixels} pixels",
        "points": points,
        "bias": (values.mean(axis=0) / truth - 1.0).tolist(),
        "scatter": (values.std(axis=0, ddof=1) / truth).tolist(),
        "doubt": doubt.tolist(),
        "members": members,
        "seconds": seconds,
    }


def reference(case):
    """T_flash with all heat in the moving body, K, and its relative standard error, by speed."""
    name = next(name for name, other in make_deep.cases().items() if other == case)
    found = make_deep.assembled(case, Rows(make_deep.FILE, resume=True)[name])["flash_temperature"]
    return np.array(found["value"]), np.array(found["error"])


def formulas(case):
    """The paper's theory and the calibrated law: deviation from the reference, CPU seconds of `rs.theory` with both."""
    truth, doubt = reference(case)
    speeds = np.array(case.scene.speeds)
    name = "flash_temperature"
    values = {
        "paper's theory": prediction.over_speed(case.scene, speeds, names=(name,))[name],
        "calibrated law": prediction.calibrated_over_speed(case.scene, speeds)[name],
    }
    seconds = warm_seconds(case.scene)
    for way, value in values.items():
        bias = (value / truth - 1.0).tolist()
        yield {"way": way, "bias": bias, "doubt": doubt.tolist(), "seconds": seconds}


def warm_seconds(scene):
    """Median CPU seconds of `rs.theory`, whose modules are loaded, of loads that it has not seen."""
    load, spent = scene.sliding.nominal_pressure, []
    for turn in range(4):
        other = scene.with_("sliding.nominal_pressure", load * (1.0 + 1e-6 * (turn + 1)))
        start = time.process_time()
        str(rs.theory(other))
        spent.append(time.process_time() - start)
    return median(spent[1:])


def worst_bias(row):
    """The bias at its worst speed, %, as it is printed; "≤" where the scatter hides it."""
    bias = np.array(row["bias"])
    if np.isnan(bias).any():
        return "–"  # outside the range of the law
    k = int(np.argmax(np.abs(bias)))
    error = 1.96 * np.hypot(
        row.get("scatter", np.zeros(len(bias)))[k] / sqrt(row.get("members", 1)), row["doubt"][k]
    )
    sign = "" if abs(bias[k]) > error else "≤ "
    value = 100 * max(abs(bias[k]), error if sign else 0.0)
    return f"{sign}{value:.2g}" if value < 99.5 else f"{sign}{value:.0f}"


def bias_table(found):
    """The error that stays at any cost, %, by scene and way."""
    ways = list(dict.fromkeys(row["way"] for row in found))
    table = [["scene", *ways]]
    for scene in dict.fromkeys(row["scene"] for row in found):
        rows = {row["way"]: row for row in found if row["scene"] == scene}
        table.append([scene, *(worst_bias(rows[way]) for way in ways)])
    return table


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument("--members", type=int, default=32, help="surfaces of each grid")
    options = command.parse()
    rows = Rows(options.output / "ways.json", resume=True)
    for name, case in make_deep.cases().items():
        if options.toy and name != "demo":
            continue
        for pixels in (2, 4) if options.toy else (2, 4, 8):
            size = (4, 256) if options.toy else (options.members, MOST)
            row = rows.once(
                "ways", f"{name}, {pixels} pixels", partial(one_grid, name, case, pixels, *size)
            )
            print(
                f"{name:14}{row['way']:22}{row['points']}² {worst_bias(row):>8} % {row['seconds']:8.3f} s",
                flush=True,
            )
        if f"{name}, paper's theory" not in rows["ways"]:
            rows.extend(
                "ways", {f"{name}, {row['way']}": {"scene": name} | row for row in formulas(case)}
            )
    found = list(rows["ways"].values())
    runs = (
        json.loads((EVIDENCE / "chain.json").read_text())["rows"]
        if (EVIDENCE / "chain.json").exists()
        else []
    )
    figures.chain(runs, found, options.output / "chain.png")
    if options.evidence:
        command_line = "python experiments/chain_ways.py --evidence"
        write_evidence("chain_ways", command_line, rows=found, tables={"bias": bias_table(found)})


if __name__ == "__main__":
    main()
