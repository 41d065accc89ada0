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

import ast
from importlib import import_module
from importlib.resources import files
from typing import Any

# public name → its module, which is imported when the name is first used
_MODULES = {
    alias.name: node.module
    for node in ast.parse(files(__name__).joinpath("__init__.pyi").read_text(encoding="utf-8")).body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}
__all__ = [*_MODULES, "__version__"]  # noqa: PLE0604  (the names are strings)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("roughsim")
        except PackageNotFoundError:  # a checkout without an installed package
            return "0+unknown"
    if name not in _MODULES:
        raise AttributeError(f"module 'roughsim' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
