"""A wave of the temperature in a half-space with a layer, or heated in depth, by finite volumes in depth."""

from math import inf

import numpy as np
import scipy


def decaying_modes(q, layers, deep, nodes):
    """Rates of the eigenvectors of conduction over capacity, over D, and of each its part in the surface temperature
    and its excitation by the source.

    `layers` are d, κ_s/κ, D/D_s and h; `nodes` go `deep` into the half-space.
    """
    d, k, ratio, h = layers
    below = d + deep * np.linspace(0.0, 1.0, nodes) ** 2
    z = (
        below
        if d == 0.0
        else np.concatenate((np.linspace(0.0, d, nodes // 2, endpoint=False), below))
    )
    middle, half = (z[1:] + z[:-1]) / 2, np.diff(z) / 2
    conduction = np.where(middle < d, k, 1.0)
    capacity = conduction * np.where(
        middle < d, ratio, 1.0
    )  # ρc of the layer over that of the half-space

    def lumped(values):
        return np.append(values, 0.0) + np.append(0.0, values)

    edges = np.concatenate(([0.0], middle, [inf]))
    source = -np.diff(np.exp(-edges / h)) if h else np.eye(1, z.size)[0]
    across, heat = conduction / np.diff(z), np.sqrt(lumped(capacity * half))
    diagonal = lumped(across + q**2 * conduction * half) / heat**2
    rates, modes = scipy.linalg.eigh_tridiagonal(diagonal, -across / (heat[1:] * heat[:-1]))
    return rates, modes[0] / heat[0], modes.T @ (source / heat)
