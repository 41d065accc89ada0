"""Where the CPU time of a run and its comparison goes: a table of stages, in Markdown.

    python benchmarks/stages.py [--scene steel-1.2GPa] [--target 0.01] [--warm]

One process at one thread. Each stage counts its own time alone, without that of the stages inside it. Two columns say
how much of it was spent in Fourier transforms and compiled kernels, and how much in the arithmetic of NumPy on whole
fields and spectra; the rest is Python and files. Modules that are imported, and kernels that are loaded from the disk,
are stages of their own, wherever that happens. A process that goes ahead compiles both. With --warm the process has
done the same run before.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module, machinery
from pathlib import Path
from typing import Any

PHYSICS, ARRAYS = KINDS = "transforms and kernels", "array arithmetic"
IMPORT, LOADED = "import", "kernels loaded"
# stage: functions, as "module:name" of the package, whose time it is
STAGES = {
    "plan": ["planning.plan:plan"],
    "surfaces": ["surface.synthesis:synthesize"],
    "contact": ["contact.active_set:solve_contact"],
    "moments": ["observables.moments:measure"],
    "members written": ["store.saving:Saver.add", "store.saving:Saver.save", "store.saving:merge"],
    "members read": ["results.members:Members.read", "results.members:Members.sample"],
    "rounds judged": ["estimate.rounds:judge"],
    "hand-out": ["ensemble.run:run"],
    "comparison": ["outputs.compare:compare", "comparison.compare:Comparison.table"],
    "theory of plan and comparison": [
        "prediction:predictions",
        "prediction:mode_sums",
        "prediction:calibrated_predictions",
        "prediction:calibrated_flash",
    ],
}
TRANSFORMS = [
    *("fourier.plans:forward", "fourier.plans:inverse"),
    *(
        f"fourier.plans:{name}"
        for name in ("Transform.forward", "Transform.inverse", "Lines.forward", "Lines.backward")
    ),
]


# functions that do little but arithmetic on whole fields and spectra
ARITHMETIC = [
    *(
        "surface.synthesis:synthesize",
        "surface.synthesis:independent_modes",
        "surface.peak_volume:peak_volume",
    ),
    *(
        "contact.solver.problem:relief_of",
        "contact.solver.problem:truncated",
        "contact.solver.problem:full_contact",
    ),
    *(
        "contact.solver.steps:Iterate.compute_gap",
        "contact.solver.solve:begun",
        "fourier.blocks:extremes",
    ),
    *(
        "observables.moments:measure",
        "observables.stress_spectrum:StressSpectrum.correlation_radius",
    ),
    "observables.catalogue:radius",
]
LOADERS = machinery.SourceFileLoader, machinery.ExtensionFileLoader


class Clock:
    """CPU seconds by stage and kind, None for neither kind; what runs innermost counts."""

    def __init__(self) -> None:
        self.seconds = Counter[tuple[str, str | None]]()
        self.running: list[tuple[str, str | None]] = [(IMPORT, None)]
        self.mark = 0.0  # of Python itself

    def lap(self) -> None:
        """Give the time since the last lap to what is running."""
        now = time.process_time()
        self.seconds[self.running[-1]] += now - self.mark
        self.mark = now

    def timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function whose time is counted for a stage, or for a kind in the stage that calls it."""

        def call(*arguments: Any, **options: Any) -> Any:
            self.lap()
            self.running.append((self.running[-1][0], name) if name in KINDS else (name, None))
            try:
                return function(*arguments, **options)
            finally:
                self.lap()
                self.running.pop()

        return call


def found(place: str) -> tuple[Any, str]:
    """Return the module or class that holds a function, and the name of the function there."""
    module, _, name = place.partition(":")
    owner: Any = import_module(f"roughsim.{module}")
    *classes, name = name.split(".")
    for part in classes:
        owner = getattr(owner, part)
    return owner, name


def watch(clock: Clock) -> None:
    """Replace the functions of all stages, the transforms and the kernels, wherever the package has them by name."""
    watched = [(place, ARRAYS) for place in ARITHMETIC] + [(place, PHYSICS) for place in TRANSFORMS]
    watched += [(place, stage) for stage, places in STAGES.items() for place in places]
    owners = [found(place) for place, _ in watched]
    originals: dict[int, Any] = {}
    for (owner, name), (_, stage) in zip(owners, watched, strict=True):
        function = getattr(owner, name)
        _, inner = originals.get(
            id(function), (function, function)
        )  # a stage may be arithmetic as a whole
        originals[id(function)] = function, clock.timed(stage, inner)
    modules = [module for name, module in sys.modules.items() if name.startswith("roughsim")]
    for module in modules:
        for value in list(vars(module).values()):
            if module.__name__.startswith("roughsim._kernels.") and hasattr(value, "py_func"):
                originals.setdefault(id(value), (value, clock.timed(PHYSICS, value)))
    for owner in [*modules, *(owner for owner, _ in owners)]:
        for name, value in list(vars(owner).items()):
            if id(value) in originals:
                setattr(owner, name, originals[id(value)][1])
    for owner, name, stage in (
        *((loader, "create_module", IMPORT) for loader in LOADERS[1:]),
        *((loader, "exec_module", IMPORT) for loader in LOADERS),
        (import_module("numba.core.dispatcher").Dispatcher, "_compile_for_args", LOADED),
    ):
        setattr(owner, name, clock.timed(stage, getattr(owner, name)))


def measure(name: str, target: float, *, warm: bool, watched: bool) -> None:
    """Do a run and its comparison, and print the table; not watched all is shown as one stage."""
    clock = Clock()
    import roughsim as rs
    from roughsim.ensemble import run

    if watched:
        watch(clock)
    scene = rs.load_scene(name)
    scene = replace(scene, ensemble=replace(scene.ensemble, until={"flash_temperature": target}))
    clock.lap()
    clock.running = [("between", None)]
    with tempfile.TemporaryDirectory() as folder:
        for repetition in range(1 + warm):
            if repetition:
                clock.lap()
                clock.seconds.clear()
            result = run.run(scene, Path(folder) / f"run{repetition}")
            rs.compare(rs.open_run(result.folder)).table()
    clock.lap()
    stages = Counter[str]()
    for (stage, _), seconds in clock.seconds.items():
        stages[stage] += seconds
    whole, members = sum(stages.values()), len(result.members)
    print(f"{scene.title}: {members} members, {whole:.2f} s of CPU\n")
    print(
        "| stage | seconds | share, % | transforms and kernels, s | arrays, s |\n|---|---|---|---|---|"
    )
    for stage, value in stages.most_common():
        parts = [clock.seconds[stage, kind] for kind in KINDS]
        print(
            f"| {stage} | {value:.2f} | {100 * value / whole:.1f} | {parts[0]:.2f} | {parts[1]:.2f} |"
        )
    sums = [sum(clock.seconds[stage, kind] for stage in stages) for kind in KINDS]
    print(f"| all | {whole:.2f} | 100 | {sums[0]:.2f} | {sums[1]:.2f} |\n")
    shares = [100 * part / whole for part in (*sums, whole - sum(sums))]
    print(
        "transforms and kernels {:.0f} %, arrays {:.0f} %, Python and files {:.0f} %".format(
            *shares
        )
    )
    left = 1.0 - sum(sums) / (whole - stages[IMPORT] - stages[LOADED])
    print(f"without imports and the loading of kernels: Python and files {100 * left:.0f} %")


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--scene", default="steel-1.2GPa")
    options.add_argument("--target", type=float, default=0.01, help="of the total error of T_flash")
    options.add_argument(
        "--warm", action="store_true", help="after the same run in the same process"
    )
    options.add_argument(
        "--here", action="store_true", help="in this process, whatever is compiled"
    )
    options.add_argument(
        "--unwatched",
        action="store_true",
        help="without stages: kernels that are watched cannot be compiled",
    )
    given = options.parse_args()
    if given.here:
        measure(given.scene, given.target, warm=given.warm, watched=not given.unwatched)
        return
    with tempfile.TemporaryDirectory() as folder:
        # both processes keep the bytecode of all modules in the folder, also where the environment would not
        environment = os.environ | {
            "PYTHONPYCACHEPREFIX": folder,
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        command = [sys.executable, *sys.argv, "--here"]
        subprocess.run(
            [*command, "--unwatched"], env=environment, check=True, stdout=subprocess.DEVNULL
        )
        subprocess.run(command, env=environment, check=True)


if __name__ == "__main__":
    main()
