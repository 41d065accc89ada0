"""Error of the pressure over CPU time: roughsim, other packages and a solver of one's own on the same rough contacts.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/contact_solvers.py [--sizes N ...] [--evidence]

Four problems (three loads, one of them capped too) on each grid. Each solver goes from its loosest tolerance to the
tightest, until it fails or a solve takes longer than --longest. The error is that of the whole pressure field, relative
to the solution of roughsim at 1e-10, to which all converge. The others are those of `pip install 'roughsim[peers]'
aspher`, if they are installed; "home-made" is benchmarks/preconditioned.py. Costs are CPU seconds of one thread. Solves
in FOLDER/solves.json are not repeated.
"""

from __future__ import annotations

import importlib.util
import math
import sys
import time
from functools import partial
from itertools import product
from pathlib import Path

import figures
import numpy as np
from script import Command, Rows, write_evidence

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import contact as solvers

TABLE = "solves"
PROBLEMS = {  # load σ₀/(E*h′), hardness σ_P/(E*h′)
    "load 0.005": (0.005, math.inf),
    "load 0.02": (0.02, math.inf),
    "load 0.1": (0.1, math.inf),
    "load 0.1, capped at 0.6": (0.1, 0.6),
}
TOLERANCES = tuple(10.0**-k for k in range(2, 9))
ENOUGH = 2.0  # CPU seconds of repeats


def measured(name, task, exact, tolerance):
    """Error and least CPU seconds of up to three solves, or the words of the failure."""
    run = solvers.ours if name == "roughsim" else solvers.PEERS[name][1]
    spent = []
    while len(spent) < 3 and sum(spent) < ENOUGH:
        start = time.process_time()
        try:
            pressure = run(task, tolerance)
        except (RuntimeError, ValueError) as reason:
            return {"error": None, "seconds": time.process_time() - start, "why": str(reason)[:80]}
        spent.append(time.process_time() - start)
    error = float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact))
    return {"error": error, "seconds": min(spent), "why": ""}


def climb(rows, name, problem, task, exact, longest):
    """From the loosest tolerance to the tightest, until one fails or takes too long."""
    for tolerance in TOLERANCES:
        words = {"solver": name, "problem": problem, "points": task.points, "tolerance": tolerance}
        key = f"{name}, {problem}, {task.points}², {tolerance:.0e}"
        row = rows.once(
            TABLE, key, lambda t=tolerance, words=words: words | measured(name, task, exact(), t)
        )
        print(
            f"{key:50s} error {row['error'] or math.nan:8.1e} {row['seconds']:8.3f} s  {row['why']}",
            flush=True,
        )
        if row["why"] or row["seconds"] > longest:
            return


def cheapest(found, name, problem, points, goal):
    """Return the least CPU seconds of a solver to an error; None if it was not reached."""
    same = {"solver": name, "problem": problem, "points": points}.items()
    times = [
        row["seconds"]
        for row in found
        if row["error"] is not None and row["error"] <= goal and same <= row.items()
    ]
    return min(times, default=None)


def ratios(found, points, goals=(1e-3, 1e-6)):
    """Return the table of least CPU times: of roughsim in seconds, of the others over it."""
    names = [name for name in figures.SOLVERS if name != "roughsim"]
    table = [["load σ₀/(E\\*h′)", "to an error of", "roughsim, s", *names]]
    for problem, goal in product(PROBLEMS, goals):
        times = {name: cheapest(found, name, problem, points, goal) for name in figures.SOLVERS}
        own = times["roughsim"]
        cells = [f"{times[name] / own:.2g}×" if times[name] else "–" for name in names]
        cells = [cell if "e" not in cell else f"{float(cell[:-1]):.0f}×" for cell in cells]
        table.append(
            [
                problem.removeprefix("load "),
                f"{goal:.0e}".replace("e-0", "e-"),
                f"{own:.2g}",
                *cells,
            ]
        )
    return table


def of_readme(found, points=512, goal=1e-6):
    """Return the numbers of the pages: CPU seconds of roughsim by problem, and times of the others over them."""
    numbers = {}
    names = {"elastic": "load 0.1", "light": "load 0.02", "capped": "load 0.1, capped at 0.6"}
    for name, problem in names.items():
        own = cheapest(found, "roughsim", problem, points, goal)
        numbers[f"{name}_seconds"] = own
        for other in ("home-made", "aspher", "tamaas", "ContactMechanics"):
            if time := cheapest(found, other, problem, points, goal):
                numbers[f"{name}_{other}"] = time / own
    return numbers


def over_size(found, goal=1e-6):
    """Return the table of the home-made solver over roughsim, by load and grid."""
    sizes = sorted({row["points"] for row in found})
    table = [["load σ₀/(E\\*h′)", *(f"{points}²" for points in sizes)]]
    for problem, (_, cap) in PROBLEMS.items():
        if cap == math.inf:
            pairs = [
                [cheapest(found, n, problem, m, goal) for n in ("home-made", "roughsim")]
                for m in sizes
            ]
            cells = [f"{home / own:.2g}" if home and own else "–" for home, own in pairs]
            table.append([problem.removeprefix("load "), *cells])
    return table


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument(
        "--sizes", type=int, nargs="+", default=[256, 512, 1024], help="points per side"
    )
    command.add_argument("--longest", type=float, default=8.0, help="CPU seconds of a solve")
    options = command.parse()
    rows = Rows(options.output / "solves.json", resume=True)
    names = [
        n
        for n in figures.SOLVERS
        if n == "roughsim" or importlib.util.find_spec(solvers.PEERS[n][0])
    ]
    print("not installed: " + (", ".join(set(figures.SOLVERS) - set(names)) or "none"))
    for name in names:
        small = solvers.problem(32, 0.1, math.inf)
        measured(
            name, small, solvers.ours(small, 1e-10), 1e-2
        )  # compiled, planned and imported by now
    for points in [64] if options.toy else options.sizes:
        for problem, (load, cap) in PROBLEMS.items():
            task, known = solvers.problem(points, load, cap), {}
            exact = partial(solution, task, known)
            for name in names:
                climb(rows, name, problem, task, exact, options.longest)
    found = list(rows[TABLE].values())
    figures.contact_error(found, options.output / "contact_error.png")
    figures.contact_cost(found, options.output / "contact_cost.png")
    if options.evidence:
        tables = {"ratios": ratios(found, 512), "home-made": over_size(found)}
        numbers = of_readme(found)
        command_line = "python experiments/contact_solvers.py --evidence"
        write_evidence("contact", command_line, rows=found, tables=tables, numbers=numbers)


def solution(task, known):
    """Return the pressure at 1e-10, computed when it is first asked for."""
    if "pressure" not in known:
        known["pressure"] = solvers.ours(task, 1e-10)
    return known["pressure"]


if __name__ == "__main__":
    main()
