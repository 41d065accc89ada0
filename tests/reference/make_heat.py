"""Recompute heat.json: single modes and a sliding Hertz contact from the heat kernel in time, and angular integrals.

Nothing here uses a closed form in λ: a mode of an instantaneous plane source decays as e^(−λ²Dτ − z²/4Dτ)/√(πDτ), and
the sum over all τ < t is done numerically. Run ``python tests/reference/make_heat.py`` to write the file.
"""

import json
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy.special import j0

mp.mp.dps = 40


def mode(q, qx, drift, spread, depth):
    """κT/q̇ (m): ∫₀^{Dt} e^(−λ²s − z²/4s)/√(πs) ds with s = u², drift = v/D, spread = Dt."""
    square = mp.mpf(q) ** 2 - 1j * mp.mpf(qx) * mp.mpf(drift)
    end = mp.sqrt(mp.mpf(spread)) if spread is not None else 12 / mp.sqrt(square.real)
    if spread is not None:
        end = min(end, 12 / mp.sqrt(square.real))

    def flow(u):
        return (
            2
            / mp.sqrt(mp.pi)
            * mp.exp(-square * u**2 - (mp.mpf(depth) ** 2 / (4 * u**2) if depth else 0))
        )

    pieces = max(8, int(abs(square.imag) * end**2 / 6) + 1)
    return mp.quad(flow, [end * mp.sqrt(mp.mpf(k) / pieces) for k in range(pieces + 1)])


def angular(a):
    """(A, B) from their definitions, Eqs. (4) and (7)."""
    a = mp.mpf(a)
    edge = min(mp.pi / 4, 1 / a) if a > 0 else mp.pi / 4
    points = [0, mp.pi / 4, mp.pi / 2 - edge / 2, mp.pi / 2 - edge / 16, mp.pi / 2]
    points = sorted(
        {mp.mpf(0), mp.pi / 4, *points, *(mp.pi / 2 - mp.mpf(10) ** -k for k in range(1, 8))}
    )
    even = mp.quad(lambda x: mp.re((1 - 1j * a * mp.cos(x)) ** -0.5), points)
    odd = mp.quad(lambda x: mp.re(1j * mp.cos(x) * (1 - 1j * a * mp.cos(x)) ** -0.5), points)
    return float(even), float(odd)


def hertz(peclet, fourier_number, q_end=3000.0):
    """T_flash of a Hertz source that has slid from rest in free space, units q̇₁R/κ; 1e-6."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    edges = np.linspace(0.0, q_end, 1501)
    half = np.diff(edges)[:, None] / 2
    q = (edges[:-1, None] + half + half * nodes).ravel()
    source = (
        2
        * np.pi
        * np.where(
            q < 1e-3, 1 / 3 - q**2 / 30, (np.sin(q) - q * np.cos(q)) / np.maximum(q, 1e-3) ** 3
        )
    )
    weight = (half * weights).ravel() * q * source**2 / (2 * np.pi)
    total, pieces = (
        0.0,
        np.sqrt(fourier_number) * np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 25))),
    )
    for low, high in pairwise(pieces):
        for node, share in zip((low + high) / 2 + (high - low) / 2 * nodes, weights, strict=True):
            total += (
                (high - low)
                / 2
                * share
                * np.sum(weight * np.exp(-((q * node) ** 2)) * j0(q * peclet * node**2))
            )
    return 2 / np.sqrt(np.pi) * total / (2 * np.pi / 3)


def main():
    modes = []
    for q, qx, drift, spread, depth in [
        (1.0, 0.6, 0.0, 0.3, 0.0),
        (2.0, 1.9, 100.0, 0.05, 0.0),
        (1.0, 1.0, 1e4, 1e-3, 0.0),
        (1.0, 0.6, 0.0, 0.3, 0.5),
        (2.0, 1.9, 100.0, 0.05, 0.3),
        (2.0, -1.9, 100.0, 0.05, 0.01),
        (1.0, 0.6, 3.0, 1e-4, 0.01),
        (1.0, 0.6, 3.0, 1e-4, 0.05),
        (1.0, 0.6, 3.0, 1e-14, 1e-7),
        (1.0, 0.6, 3.0, 22.0, 0.0),
        (3.0, 2.0, 40.0, 2.0, 0.7),
        (3.0, 2.0, 40.0, None, 0.7),
        (3.0, 2.0, 40.0, None, 0.0),
    ]:
        value = mode(q, qx, drift, spread, depth)
        modes.append(
            {"q": q, "qx": qx, "drift": drift, "spread": spread, "depth": depth}
            | {"real": float(mp.re(value)), "imaginary": float(mp.im(value))}
        )
    ratios = [0.0, 1e-3, 0.1, 0.5, 1.0, 3.0, 10.0, 100.0, 1e3, 1e5]
    content = {
        "modes": modes,
        "angular": [dict(zip(("a", "A", "B"), (a, *angular(a)), strict=True)) for a in ratios],
        "hertz_from_rest": [
            {"peclet": p, "fourier_number": f, "flash_temperature": hertz(p, f)}
            for p, f in [(0, 0.3), (10, 0.3)]
        ],
    }
    Path(__file__).with_name("heat.json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
