"""theory: Persson's contact mechanics and flash temperature, evaluated to ten digits.

Nothing here imports `roughsim`: every integral has its own quadrature, so that neither side hides the other's error.

Conventions
-----------
Units
    SI everywhere; temperatures in K above the background, pressures ≥ 0 in compression.
Spectrum
    Any callable C(q) [m⁴] of an array of wavenumbers [rad/m] with an attribute `breaks`: the first and the last are
    its ends, and C has kinks or jumps only there. Persson's convention: ⟨h²⟩ = 2π ∫ q C dq, ⟨|∇h|²⟩ = 2π ∫ q³ C dq.
    For two rough bodies C is the sum of both, and E* the composite modulus 1/E* = 1/E*₁ + 1/E*₂.
Stress spectrum
    |σ_q|² [Pa² m²], a callable of the same kind: g_σ(0) = 2π ∫ q |σ_q|² dq, without the mean pressure.
Heat
    The source moves along +x through the body at a speed > 0: the wake lies at x < 0 and T′_flash < 0. A negative
    speed is the mirror image: the same T_flash, the opposite T′_flash. All the heat enters the body.
Weight
    W = P[γ + (1 − γ)P²], γ explicit everywhere (the paper does not give it); γ = 1 is W = P, and a callable W(P, q)
    may stand in its place.

Equation numbers follow B.N.J. Persson, "Flash temperature in sliding contacts".
"""

from importlib import import_module
from typing import Any

__all__ = [
    "at_rest",
    "background",
    "camera",
    "classical",
    "clipped",
    "flash",
    "hardness",
    "hertz",
    "lay",
    "partition",
    "persson",
    "plasticity",
    "quadrature",
    "two_bodies",
]


def __getattr__(name: str) -> Any:
    """Import a module of the package at its first use (PEP 562)."""
    if name not in __all__:
        raise AttributeError(f"module 'theory' has no attribute {name!r}")
    return import_module(f"theory.{name}")


def __dir__() -> list[str]:
    return sorted(__all__)
