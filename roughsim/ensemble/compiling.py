"""Compiling for a run, begun before all that the run imports: where nothing is compiled yet that takes longest."""

from pathlib import Path

from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_SOLVER


def begin_compiling_for(scene: Scene, folder: Path) -> None:
    """Start the second process that compiles the solver, where a new run will be planned with it; once in a process."""
    if scene.numerics.solver in (None, DEFAULT_SOLVER) and not folder.exists():
        from roughsim.contact.solver.ahead import begin_compiling  # loads numba, as the pilot of the plan will

        begin_compiling()
