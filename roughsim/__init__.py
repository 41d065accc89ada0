"""roughsim: Monte Carlo synthesis of rough surfaces, their elastoplastic contact, and the heat of sliding.

Conventions, stated once
------------------------
Units
    SI everywhere inside; units are read at the edge (scene files) and written at the edge (charts, files).
Axes
    Fields are arrays of ``grid.shape``; axis 0 is x, axis 1 is y. Directions are angles in radians from
    axis 0 towards axis 1.
Fourier
    f(x) = Σ_q f(q) exp(+i q·x), so f(q) = (1/N) Σ_x f(x) exp(−i q·x); q = 2πk/L in rad/m. Real fields are
    held by the half q_y ≥ 0 (`Grid.multiplicity` counts the modes that each entry stands for).
Power spectrum
    C(q) is isotropic with ⟨h²⟩ = 2π ∫ q C dq and ⟨|∇h|²⟩ = 2π ∫ q³ C dq (Persson's convention). On a grid the
    variance of a mode is ∫ C d²q over its Fourier cell.
Contact
    Pressure is ≥ 0 in compression. S(q) = 2/(E*|q|), S(0) = 0; the offset is the multiplier of the load.
Heat
    The source moves along +x through the body, so the wake lies at x < 0 and ∂T/∂x over the contact is
    negative. Temperatures are above the background: q = 0 is removed from stress and temperature.
"""

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers; at run time each name is imported when it is first used
    from roughsim.comparison.compare import compare as compare
    from roughsim.contact import Contact as Contact
    from roughsim.contact import Solid as Solid
    from roughsim.contact.active_set import solve_contact as solve_contact
    from roughsim.contact.patches import contact_patches as contact_patches
    from roughsim.contact.patches import corrected_area as corrected_area
    from roughsim.contact.patches import corrected_fractions as corrected_fractions
    from roughsim.contact.plasticity import follow_loads as follow_loads
    from roughsim.contact.plasticity import plastic_deformation as plastic_deformation
    from roughsim.ensemble.press import press as press
    from roughsim.ensemble.run import run as run
    from roughsim.errors import ConvergenceError as ConvergenceError
    from roughsim.errors import RecordError as RecordError
    from roughsim.errors import ResolutionError as ResolutionError
    from roughsim.errors import RoughsimError as RoughsimError
    from roughsim.fourier import set_threads as set_threads
    from roughsim.grid import Grid as Grid
    from roughsim.heat.half_space import half_space_temperature as half_space_temperature
    from roughsim.heat.partition import Body as Body
    from roughsim.heat.partition import partition_heat as partition_heat
    from roughsim.heat.periodic import sliding_temperature as sliding_temperature
    from roughsim.observables.moments import HeatSource as HeatSource
    from roughsim.observables.moments import measure as measure
    from roughsim.planning.plan import plan as plan
    from roughsim.planning.realization import realize as realize
    from roughsim.results.folder import open_run as open_run
    from roughsim.scene import Scene as Scene
    from roughsim.scene import load_scene as load_scene
    from roughsim.scene.numerics import Level as Level
    from roughsim.scene.numerics import Numerics as Numerics
    from roughsim.sliding.slide import Slide as Slide
    from roughsim.sliding.slide import slide as slide
    from roughsim.studies.study import Study as Study
    from roughsim.studies.study import open_study as open_study
    from roughsim.studies.work import study as study
    from roughsim.surface.power_laws import SelfAffineSpectrum as SelfAffineSpectrum
    from roughsim.surface.power_laws import TabulatedSpectrum as TabulatedSpectrum
    from roughsim.surface.synthesis import synthesize as synthesize

__version__: str  # of the installed package, built from the git tag

_HOME = {
    name: module
    for module, names in {
        "grid": "Grid",
        "surface.power_laws": "SelfAffineSpectrum TabulatedSpectrum",
        "surface.synthesis": "synthesize",
        "contact": "Solid Contact",
        "contact.active_set": "solve_contact",
        "contact.plasticity": "plastic_deformation follow_loads",
        "contact.patches": "contact_patches corrected_area corrected_fractions",
        "heat.partition": "Body partition_heat",
        "heat.half_space": "half_space_temperature",
        "heat.periodic": "sliding_temperature",
        "sliding.slide": "slide Slide",
        "observables.moments": "HeatSource measure",
        "fourier": "set_threads",
        "scene": "Scene load_scene",
        "scene.numerics": "Level Numerics",
        "planning.plan": "plan",
        "planning.realization": "realize",
        "ensemble.run": "run",
        "ensemble.press": "press",
        "results.folder": "open_run",
        "comparison.compare": "compare",
        "studies.work": "study",
        "studies.study": "Study open_study",
        "errors": "RoughsimError ConvergenceError RecordError ResolutionError",
    }.items()
    for name in names.split()
}
__all__ = [*_HOME, "__version__"]  # noqa: PLE0604  (the names are strings)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("roughsim")
        except PackageNotFoundError:  # a bare checkout: the package was never built
            return "0+unknown"
    if name == "Sliding":  # deprecated
        warnings.warn(
            "rs.Sliding is renamed to rs.HeatSource; the next release removes the old name", DeprecationWarning, 2
        )
        name = "HeatSource"
    if name not in _HOME:
        raise AttributeError(f"module 'roughsim' has no attribute {name!r}")
    return getattr(import_module(f"roughsim.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
