"""Recompute transients.json: Hertz, disc and square sources that have slid from rest, by their autocorrelation.

In units of q̇R/κ, with Pe = vR/D and Fo = Dt/R², a source q̇ has
    Σ T q̇/Σ q̇ = (2/√π) ∫₀^√Fo du ∫ g(r) N(r; d, u) d²r/∫ q̇,   d = Pe u²,
where g is the autocorrelation of the source and N a normal distribution of variance 2u² per axis around the distance d
that the source has left that heat behind. Around the circle N is an e^(−x)I₀(x). For the square (half side 1) all is a
product over the axes, and its centre and the middle of its trailing edge are single integrals. No convolution, no grid.
Run ``python tests/reference/make_transients.py`` to write the file.
"""

import json
from itertools import pairwise
from math import acos, acosh, erf, exp, pi, sqrt
from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.special import i0e

CASES = [
    *((0, fourier) for fourier in (1e-4, 0.01, 0.3, 10)),
    *((1, fourier) for fourier in (1e-3, 0.1, 1)),
    *((10, fourier) for fourier in (1e-4, 0.01, 0.3, 10)),
    *((100, fourier) for fourier in (1e-3, 0.1, 1)),
    *((1000, fourier) for fourier in (1e-4, 0.01, 0.3)),
    (1e4, 1e-5),
    (1e5, 1e-5),
    (1e5, 0.3),
]


def disc(r):
    """Area that two unit discs share at the distance r < 2."""
    return 2 * acos(r / 2) - r / 2 * sqrt((2 - r) * (2 + r))


def hertz(r):
    """Autocorrelation of √(1 − r²)."""
    if r < 1e-12:
        return pi / 2
    s = sqrt((2 - r) * (2 + r))
    return pi / 4 * (s * (1 + r * r / 8) - r * r * (1 - r * r / 16) * acosh(2 / r))


def smeared(correlation, u, d):
    """∫ g N d²r over 0 ≤ r < 2."""

    def ring(r):
        return (
            correlation(r)
            * exp(-(((r - d) / (2 * u)) ** 2))
            * i0e(r * d / (2 * u * u))
            * r
            / (2 * u * u)
        )

    low, high = max(0.0, d - 14 * u), min(2.0, d + 14 * u)
    if low >= high:
        return 0.0
    stops = sorted({min(max(d + k * u, low), high) for k in (-14, -5, -2, 0, 2, 5, 14)})
    return sum(
        quad(ring, a, b, epsabs=1e-13, epsrel=1e-11, limit=200)[0] for a, b in pairwise(stops)
    )


def spread_line(u, d):
    """Mean over −1 < x < 1 of heat from −1 < x < 1 that lies d behind."""

    def primitive(x):
        return x * erf(x / (2 * u)) + 2 * u / sqrt(pi) * exp(-((x / (2 * u)) ** 2))

    return (primitive(d + 2) - 2 * primitive(d) + primitive(d - 2)) / 4


def at(x, u, d):
    """Share of heat from −1 < x < 1, now d behind, at x."""
    return (erf((x + d + 1) / (2 * u)) - erf((x + d - 1) / (2 * u))) / 2


def transient(spread, peclet, fourier):
    """(2/√π) ∫₀^√Fo spread(u, Pe u²) du."""
    end = sqrt(fourier)
    edges = {0.0, *(end * np.geomspace(1e-3, 1, 14))}
    for distance in (1.0, 2.0) if peclet else ():  # heat leaves a point, or the source
        passage = sqrt(distance / peclet)
        edges |= {passage * (1 + s) for s in (-0.5, -0.2, -0.05, 0.0, 0.05, 0.2, 0.5)}
        edges |= {passage + k / peclet for k in (-8, -2, 2, 8)}
    if peclet:
        edges |= set(np.geomspace(0.1, 100, 7) / peclet)
    stops = sorted(edge for edge in edges if 0 <= edge <= end)
    parts = (
        quad(lambda u: spread(u, peclet * u * u), a, b, epsabs=1e-13, epsrel=1e-10, limit=200)[0]
        for a, b in pairwise(stops)
    )
    return 2 / sqrt(pi) * sum(parts)


def main():
    rows = []
    for peclet, fourier in CASES:
        values = {
            "hertz_flash": transient(lambda u, d: smeared(hertz, u, d), peclet, fourier)
            / (2 * pi / 3),
            "disc_mean": transient(lambda u, d: smeared(disc, u, d), peclet, fourier) / pi,
            "square_mean": transient(
                lambda u, d: spread_line(u, d) * spread_line(u, 0.0), peclet, fourier
            ),
            "square_centre": transient(
                lambda u, d: at(0.0, u, d) * at(0.0, u, 0.0), peclet, fourier
            ),
            "square_trailing_edge": transient(
                lambda u, d: at(-1.0, u, d) * at(0.0, u, 0.0), peclet, fourier
            ),
        }
        rows.append({"peclet": peclet, "fourier_number": fourier} | values)
    Path(__file__).with_name("transients.json").write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
