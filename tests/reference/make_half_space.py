"""Recompute half_space.json: what a heated pixel does to a point, by a route of its own.

A point source that has moved for the time t along a half-space leaves, with p = v/D, X ahead of it, at the distance R,
    κT = [e^(−p(R + X)/2) erfc(R/2u − pu/2) + e^(−p(X − R)/2) erfc(R/2u + pu/2)]/4πR,  u = √(Dt)
(Carslaw & Jaeger, 10.3). In polar coordinates around the point the pixel is summed over R and angle, piecewise between
its corners. Run ``python tests/reference/make_half_space.py`` to write the file.
"""

import json
from itertools import pairwise
from math import atan2, cos, exp, inf, pi, sin, sqrt
from pathlib import Path

from scipy.integrate import quad
from scipy.special import erfc

DRIFTS, OFFSETS = (0.0, 0.01, 1.0, 10.0, 100.0), ((0, 0), (-1, 0), (-1, 1), (-5, 2))
CASES = [  # offset (pixels), pixel (Δx, Δy), drift v/D, direction, depth, Dt
    *((ij, (1.0, 1.0), p, 0.0, 0.0, inf) for p in DRIFTS for ij in OFFSETS),
    ((-3, 1), (1.0, 1.0), 1e-3, 0.0, 0.0, inf),
    ((0, 0), (1.0, 0.4), 3.0, 0.7, 0.0, inf),
    ((-2, -3), (1.0, 0.4), 3.0, 0.7, 0.0, inf),
    ((1, -1), (1.0, 2.5), 3.0, -2.0, 0.0, 0.5),
    ((0, 0), (1.0, 1.0), 5.0, 0.0, 0.0, 0.01),
    ((-2, 0), (1.0, 1.0), 20.0, 0.0, 0.0, 0.1),
    ((0, 0), (1.0, 1.0), 0.0, 0.0, 0.3, inf),
    ((-1, 1), (1.0, 1.0), 4.0, 0.3, 0.6, inf),
    ((-1, 1), (1.0, 1.0), 4.0, 0.3, 0.6, 0.2),
    ((1, 0), (1.0, 1.0), -4.0, 0.0, 2.0, 3.0),
]


def source(distance, ahead, p, u):
    """κT·R of a moving point source."""
    steady = 2.0 if u == inf else erfc(distance / (2 * u) - p * u / 2)
    late = 0.0 if u == inf else erfc(distance / (2 * u) + p * u / 2)
    value = steady * exp(-p * (distance + ahead) / 2)
    return (value + (late * exp(-p * (ahead - distance) / 2) if late else 0.0)) / (4 * pi)


def crossings(angle, box):
    """Where the ray from the origin at this angle is inside the box: (first, last), or nothing."""
    first, last = 0.0, inf
    for (low, high), part in zip(box, (cos(angle), sin(angle)), strict=True):
        if abs(part) < 1e-15:
            if low > 0 or high < 0:
                return None
            continue
        near, far = sorted((low / part, high / part))
        first, last = max(first, near), min(last, far)
    return (first, last) if last > first else None


def influence(offset, pixel, p, direction, depth, spread):
    """κT at the centre of the pixel at this offset from a pixel with unit flux."""
    centre = [
        -k * side for k, side in zip(offset, pixel, strict=True)
    ]  # of the source, seen from the point
    box = [(c - side / 2, c + side / 2) for c, side in zip(centre, pixel, strict=True)]
    u = sqrt(spread)

    def ray(angle):
        limits = crossings(angle, box)
        if limits is None:
            return 0.0
        slant = -cos(
            angle - direction
        )  # the point lies opposite to the direction in which it sees the source

        def along(distance):
            return source(distance, sqrt(max(distance**2 - depth**2, 0.0)) * slant, p, u)

        first, last = (sqrt(r**2 + depth**2) for r in limits)
        return quad(along, first, last, epsabs=1e-13, epsrel=1e-12, limit=200)[0]

    corners = {atan2(y, x) for x in box[0] for y in box[1]}
    special = {direction + pi, direction - pi, 0.0, pi / 2, -pi / 2, pi, -pi}
    stops = sorted({-pi, pi, *(a for a in corners | special if -pi <= a <= pi)})
    return sum(
        quad(ray, a, b, epsabs=1e-12, epsrel=1e-11, limit=400)[0]
        for a, b in pairwise(stops)
        if b > a
    )


def main():
    names = ("offset", "pixel", "drift", "direction", "depth", "spread")
    rows = []
    for case in CASES:
        row = dict(zip(names, case, strict=True)) | {"influence": influence(*case)}
        rows.append(row | {"spread": None if row["spread"] == inf else row["spread"]})
    Path(__file__).with_name("half_space.json").write_text(
        json.dumps({"pixels": rows}, indent=1) + "\n"
    )


if __name__ == "__main__":
    main()
