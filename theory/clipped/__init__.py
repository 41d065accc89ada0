"""Rough contact as a clipped Gaussian field: σ(x) = F(z(x)), with z Gaussian of mean 0 and variance 1.

F is the pressure of the same rank as z: P(σ > F(z)) = P(z′ > z). Where all has yielded it is one step, from 0 to σ_P.
In general it is a stack of many small ones, F(z) = Σ_i h_i 1(z > u_i). The distribution of the pressure is that of a
diffusion between absorbing walls at 0 and σ_P, with the variance g_σ(0) of the calibrated law. The correlation ρ(r) of
z gives ⟨σ(0)σ(r)⟩ − σ₀² the shape of g_σ(r) of that law.

Source: one step is the clipped random wave of N.F. Berk, Phys. Rev. Lett. 58, 2718 (1987).
"""

from theory.clipped.drawing import amplitudes, halved, heights, ranked
from theory.clipped.field import ClippedField, clipped_field, directed_correlations, law_of
from theory.clipped.products import PAIRS, Correlations, Products, products

__all__ = [
    "PAIRS",
    "ClippedField",
    "Correlations",
    "Products",
    "amplitudes",
    "clipped_field",
    "directed_correlations",
    "halved",
    "heights",
    "law_of",
    "products",
    "ranked",
]
