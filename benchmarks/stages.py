"""Where the CPU time of a run and its comparison goes: a table of stages, in Markdown.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/stages.py [--scene steel-1.2GPa] [--target 0.01]

One process at one thread. Each stage counts its own time alone, without that of the stages inside it; the same columns
say how much of it was spent in Fourier transforms and compiled kernels. A process that goes ahead compiles the kernels;
this one loads them from the disk.
"""

from __future__ import annotations

import time

START = time.process_time()  # of Python itself
import argparse  # noqa: E402
import subprocess  # noqa: E402
import sys  # noqa: E402
import tempfile  # noqa: E402
from collections import Counter  # noqa: E402
from collections.abc import Callable  # noqa: E402
from dataclasses import replace  # noqa: E402
from importlib import import_module  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import roughsim as rs  # noqa: E402
from roughsim.comparison import compare  # noqa: E402
from roughsim.ensemble import run  # noqa: E402

IMPORTED = time.process_time()

PHYSICS = "transforms and kernels"
# stage: functions, as "module:name" of the package, whose time it is
STAGES = {
    "plan": ["planning.plan:plan"],
    "pilot of the plan": ["planning.pilot:pilot"],
    "surfaces": ["surface.synthesis:synthesize"],
    "contact": ["contact.active_set:solve_contact"],
    "moments": ["observables.moments:measure"],
    "members written": ["store.member_files:write_member"],
    "members read": ["results.reader:Reader.take", "results.reader:Reader.spectra"],
    "targets looked at": ["results.stopping:last_needed"],
    "hand-out": ["ensemble.run:run"],
    "comparison": ["comparison.compare:compare", "comparison.compare:comparison_table"],
    "theory of plan and comparison": [
        "prediction:predictions",
        "prediction:mode_sums",
        "prediction:calibrated_predictions",
        "prediction:yielded_fall",
    ],
}
TRANSFORMS = [
    *("fourier.plans:forward", "fourier.plans:inverse"),
    *(
        f"fourier.plans:{name}"
        for name in ("Transform.forward", "Transform.inverse", "Lines.forward", "Lines.backward")
    ),
]


class Clock:
    """CPU seconds by stage, and by stage those in transforms and kernels; the innermost stage counts."""

    def __init__(self) -> None:
        self.seconds, self.physics = Counter[str](), Counter[str]()
        self.running = ["between"]
        self.mark = time.process_time()

    def lap(self) -> None:
        """Give the time since the last lap to what is running."""
        now = time.process_time()
        stage = next(name for name in reversed(self.running) if name != PHYSICS)
        self.seconds[stage] += now - self.mark
        if self.running[-1] == PHYSICS:
            self.physics[stage] += now - self.mark
        self.mark = now

    def timed(self, stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function whose time is counted for a stage."""

        def call(*arguments: Any, **options: Any) -> Any:
            self.lap()
            self.running.append(stage)
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
    watched = {place: stage for stage, places in STAGES.items() for place in places} | dict.fromkeys(
        TRANSFORMS, PHYSICS
    )
    originals: dict[int, Any] = {}
    for place, stage in watched.items():
        owner, name = found(place)
        function = getattr(owner, name)
        originals[id(function)] = function, clock.timed(stage, function)
        setattr(owner, name, originals[id(function)][1])
    modules = [module for name, module in sys.modules.items() if name.startswith("roughsim")]
    for module in modules:
        for value in list(vars(module).values()):
            if module.__name__.startswith("roughsim._kernels.") and hasattr(value, "py_func"):
                originals.setdefault(id(value), (value, clock.timed(PHYSICS, value)))
    for module in modules:
        for name, value in list(vars(module).items()):
            if id(value) in originals:
                setattr(module, name, originals[id(value)][1])


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--scene", default="steel-1.2GPa")
    options.add_argument("--target", type=float, default=0.01, help="of the statistical error of T_flash")
    given = options.parse_args()
    scene = rs.load_scene(given.scene)
    target = {"flash_temperature": given.target}
    scene = replace(scene, ensemble=replace(scene.ensemble, until=target))
    with tempfile.TemporaryDirectory() as folder:
        compile_ahead = (
            "import roughsim as rs; "
            f"rs.run(rs.load_scene({given.scene!r}), {folder + '/ahead'!r}, max_realizations=1, workers=1)"
        )
        subprocess.run([sys.executable, "-c", compile_ahead], check=True)
        clock = Clock()
        watch(clock)
        result = run.run(scene, Path(folder) / "run")
        compare.comparison_table(compare.compare(rs.open_run(result.folder)))
        clock.lap()
    members = len(result.members)
    seconds = clock.seconds + Counter({"import": IMPORTED})
    whole = sum(seconds.values())
    print(f"{scene.title}: {members} members, {whole:.2f} s of CPU\n")
    print("| stage | seconds | share, % | in transforms and kernels, s |\n|---|---|---|---|")
    for stage, value in sorted(seconds.items(), key=lambda item: -item[1]):
        print(f"| {stage} | {value:.2f} | {100 * value / whole:.1f} | {clock.physics[stage]:.2f} |")
    inside = sum(clock.physics.values())
    print(f"| all | {whole:.2f} | 100 | {inside:.2f} |\n\n{100 * (1 - inside / whole):.0f} % outside")


if __name__ == "__main__":
    main()
