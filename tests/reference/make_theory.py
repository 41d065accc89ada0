"""Recompute the reference numbers of tests/analytic by routes of their own: python tests/reference/make_theory.py

No code of the package is used. Angular integrals and area fractions: mpmath at 40 and 60 digits, from their
definitions. Whole cases: G in closed form for a spectrum of two powers, tanh-sinh quadrature in ln q at 30 digits.
Correlation at large distance: brute force, twenty million nodes. Smoothed spectrum: G_sm = σ_P² ∫ factor dg by nested
scipy.integrate.quad. Takes about ten seconds.
"""

import itertools
import json
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy import integrate, optimize, special

STEEL = {
    "modulus": 2e11 / 0.91 / 2,
    "pressure": 9e7,
    "friction": 0.11,
    "conductivity": 30.0,
    "diffusivity": 30 / 3.95e6,
}
CASES = {
    "steel_like": {
        "psd": 1.4215267925448979e-21,
        "q": [1e3, 1e4, 1e6],
        "hurst": 0.8,
        "low": 0.0,
        "gamma": 0.45,
        "speeds": [1e-3, 35.0],
        "r": [1e-6, 1e-4, 1e-3],
        "modulus": 1e11 / 0.91,
        "pressure": 9e7,
        "friction": 0.11,
        "conductivity": 30.0,
        "diffusivity": 30 / 3.95e6,
    },
    "light_load": {
        "psd": 3e-20,
        "q": [1e3, 8e3, 1e7],
        "hurst": 0.6,
        "low": 1.5,
        "gamma": 0.7,
        "speeds": [1e-2, 10.0],
        "r": [1e-7, 1e-5],
        "modulus": 1e9,
        "pressure": 1e3,
        "friction": 0.5,
        "conductivity": 0.2,
        "diffusivity": 1e-7,
    },
}
SIX_DECADES = {
    "q": [1e3, 1e3, 1e9],
    "hurst": 0.8,
    "low": 0.0,
    "gamma": 0.45,
    "modulus": 1e7 / 0.75,
    "pressure": 1e5,
    "friction": 1.0,
    "conductivity": 0.23,
    "diffusivity": 0.23 / 1200 / 1650,
    "rms_height": 2e-4,
}
FAR = {**SIX_DECADES, "q": [1e3, 1e3, 1e5], "pressure": 1e2}
BEST = {
    "psd": 1.3861101622950204e-23,
    "q": [6350.0, 9.4e4, 4.1508770351185866e7],
    "hurst": 0.8,
    "low": 1.5,
    "gamma": 0.294,
    **STEEL,
}


def angular(a):
    with mp.workdps(40):
        a = mp.mpf(a)
        cuts = (
            [0, mp.pi / 2]
            if a < 1
            else [0, *(mp.pi / 2 - mp.mpf(10) ** -k for k in range(1, 14)), mp.pi / 2]
        )

        def root(x):
            return 1 / mp.sqrt(1 - 1j * a * mp.cos(x))

        even = mp.quad(lambda x: root(x).real, cuts)
        odd = mp.quad(lambda x: (1j * mp.cos(x) * root(x)).real, cuts)
        return [float(even), float(odd)]


def areas(s, g):
    with mp.workdps(60):
        s, g = mp.mpf(s), mp.mpf(g)
        w = 1 / (2 * mp.sqrt(g))
        walls = [
            (k, mp.erfc((2 * k + 1 - s) * w) - mp.erfc((2 * k + 1 + s) * w)) for k in range(60)
        ]
        plastic = mp.fsum(term for _, term in walls)
        bare = mp.fsum(mp.erfc((2 * k + s) * w) - mp.erfc((2 * k + 2 - s) * w) for k in range(60))
        ratio = plastic / s
        return [float(bare), float(1 - bare - plastic), float(plastic), float(1 - ratio**6)]


def psd(q, c):
    return c["psd"] * (
        (q / c["q"][1]) ** (-c["low"])
        if q <= c["q"][1]
        else (q / c["q"][1]) ** (-2 - 2 * c["hurst"])
    )


def cube(q, c):
    """∫ q³ C dq from q_min in closed form."""
    kink, low, high = c["q"][1], 4 - c["low"], 2 - 2 * c["hurst"]

    def first(x):
        return c["psd"] * kink**4 * ((x / kink) ** low - (c["q"][0] / kink) ** low) / low

    if q <= kink:
        return first(q)
    return first(kink) + c["psd"] * kink**4 * ((q / kink) ** high - 1) / high


def whole_case(c):
    mp.mp.dps = 30
    c = {k: ([mp.mpf(x) for x in v] if isinstance(v, list) else mp.mpf(v)) for k, v in c.items()}

    def stress(q):
        half = max(mp.pi / 4 * c["modulus"] ** 2 * cube(q, c), 0)  # ln q_min may round below q_min
        p = mp.erf(c["pressure"] / (2 * mp.sqrt(half))) if half else mp.mpf(1)
        return (
            mp.pi
            / 2
            * c["modulus"] ** 2
            * q**3
            * psd(q, c)
            * p
            * (c["gamma"] + (1 - c["gamma"]) * p**2)
        )

    def integral(kernel):
        lo, kink, hi = c["q"]
        near = [mp.log(lo) + (mp.log(kink / lo)) * mp.mpf(2) ** -k for k in (24, 16, 8, 4, 2, 1)]
        cuts = [mp.log(lo), *near, *mp.linspace(mp.log(kink), mp.log(hi), 10)]
        return mp.quad(
            lambda x: kernel(mp.exp(x)) * stress(mp.exp(x)) * mp.exp(x), sorted(set(cuts))
        )

    def even(a):
        h = mp.sqrt(1 + a * a)
        return mp.ellipk((h - 1) / (2 * h)) / mp.sqrt(h)

    def odd(a):
        return -mp.pi * a / 8 * mp.hyp2f1(0.75, 1.25, 2, -a * a)

    def moments(v):
        d, f = c["diffusivity"], c["friction"] * v / c["conductivity"] / c["pressure"] * 2 / mp.pi
        kernels = [
            lambda q: even(v / d / q) / q,
            lambda q: odd(v / d / q),
            lambda q: -even(v / d / q) * q,
        ]
        return [float(f * integral(kernel)) for kernel in kernels]

    def correlation(r):
        return float(integral(lambda q: mp.besselj(0, q * r)))

    return {
        "half_variance": float(mp.pi / 4 * c["modulus"] ** 2 * cube(c["q"][2], c)),
        "T, gradient, Laplacian": [moments(v) for v in c["speeds"]],
        "g": [correlation(r) for r in [0, *c["r"]]],
    }


def single_power(c):
    """s(q) of Eq. (2) for one power from q_min, h_rms given."""
    lo, hi, h2 = c["q"][0], c["q"][2], 2 * c["hurst"]
    c["psd"] = c["rms_height"] ** 2 * h2 / (2 * np.pi * lo**2 * (1 - (hi / lo) ** -h2))

    def stress(q):
        half = (
            np.pi
            / 4
            * c["modulus"] ** 2
            * c["psd"]
            * lo**4
            * np.expm1((2 - h2) * np.log(q / lo))
            / (2 - h2)
        )
        p = special.erf(c["pressure"] / 2 / np.sqrt(np.maximum(half, 1e-300)))
        return (
            np.pi
            / 2
            * c["modulus"] ** 2
            * q
            * c["psd"]
            * lo**2
            * (q / lo) ** -h2
            * p
            * (0.45 + 0.55 * p**2)
        )

    return stress


def brute_force(c, r):
    """g_σ(r): panels of ln q = ln q_min + y² through the layer, then one panel of 12 nodes for each 3 rad of phase."""
    stress, (lo, _, hi) = single_power(c), c["q"]
    x, w = np.polynomial.legendre.leggauss(12)
    top = min(2 * lo, lo + 3 / r)
    depth = np.sqrt(np.log(top / lo) * np.concatenate([[0.0], np.geomspace(1e-14, 1, 400)]))
    a, b = depth[:-1, None], depth[1:, None]
    y = (a + b) / 2 + (b - a) / 2 * x
    q = lo * np.exp(y**2)
    total = (stress(q) * special.j0(q * r) * 2 * y * q * (b - a) / 2 * w).sum()
    near = min(100 * lo, hi)
    far = np.linspace(near, hi, int((hi - near) * r / 3) + 1)[1:]
    edges = np.concatenate([np.linspace(top, near, int(near * r / 3) + 2000), far])
    for part in np.array_split(np.arange(edges.size - 1), 100):
        a, b = edges[part][:, None], edges[part + 1][:, None]
        q = (a + b) / 2 + (b - a) / 2 * x
        total += (stress(q) * special.j0(q * r) * (b - a) / 2 * w).sum()
    return total


def six_decades(c):
    total, stress, (lo, _, hi) = brute_force(c, 5e-3), single_power(c), c["q"]

    def heat(y):
        q = lo * np.exp(y * y)
        return stress(q) * 2 * y * special.ellipk(parameter(c, q)) / even_root(c, q)

    cuts = {"points": [1e-6, 1e-4, 1e-2, 0.1, 0.3], "limit": 2000, "epsabs": 0, "epsrel": 2e-13}
    t = integrate.quad(heat, 0, np.sqrt(np.log(hi / lo)), **cuts)[0]
    return {
        "g(5 mm)": total,
        "T(1 m/s)": 2 / np.pi * c["friction"] / c["conductivity"] / c["pressure"] * t,
    }


def even_root(c, q):
    return (1 + (1 / c["diffusivity"] / q) ** 2) ** 0.25


def parameter(c, q):
    return (1 - even_root(c, q) ** -2) / 2


def smoothing(s, g):
    if g == 0:
        return 1.0
    if g < 0.15:
        w = 0.5 / np.sqrt(g)
        k = np.arange(6)
        return (
            1
            - ((special.erfc((2 * k + 1 - s) * w) - special.erfc((2 * k + 1 + s) * w)).sum() / s)
            ** 6
        )
    n = np.arange(1, 8)
    delta = (
        2
        / np.pi
        / s
        * ((-1.0) ** (n + 1) * np.sin(n * np.pi * s) / n * np.exp(-((n * np.pi) ** 2) * g)).sum()
    )
    return -np.expm1(6 * np.log1p(-delta))


def steel(hardness):
    c, s = BEST, BEST["pressure"] / hardness
    rate = np.pi / 4 * (c["modulus"] / hardness) ** 2
    lo, kink, hi = c["q"]

    def to_q(g):
        return optimize.brentq(
            lambda x: rate * cube(np.exp(x), c) - g, np.log(lo), np.log(hi) - 1e-12, xtol=1e-15
        )

    # smoothed half variance on Gauss nodes of panels in √g, cumulated by quad over g
    cuts = np.sqrt([0, 1e-3, 1e-2, *np.geomspace(0.03, 6, 12), rate * cube(kink, c)])
    cuts = np.unique(cuts[cuts <= np.sqrt(7)])
    x, w = np.polynomial.legendre.leggauss(40)
    sums = {"g0": 0.0, "static": 0.0, "T": 0.0, "slope": 0.0, "laplacian": 0.0}
    reached, at = 0.0, 0.0
    for a, b in itertools.pairwise(cuts):
        for node, weight in zip((a + b) / 2 + (b - a) / 2 * x, (b - a) / 2 * w, strict=True):
            g = node * node
            reached += integrate.quad(lambda z: smoothing(s, z), at, g, epsabs=1e-16, epsrel=1e-13)[
                0
            ]
            at = g
            p = special.erf(s / 2 / np.sqrt(reached))
            stress = (
                2
                * hardness**2
                * smoothing(s, g)
                * p
                * (c["gamma"] + (1 - c["gamma"]) * p * p)
                * 2
                * node
                * weight
            )
            q = np.exp(to_q(g))
            ratio = 35.0 / c["diffusivity"] / q
            h = np.hypot(1, ratio)
            m = (h - 1) / 2 / h
            even = special.ellipk(m) / np.sqrt(h)
            odd = (
                special.ellipk(m) / np.sqrt(h)
                - np.sqrt(h) * (2 * special.ellipe(m) - special.ellipk(m))
            ) / ratio
            for name, value in zip(sums, (1, np.pi / 2 / q, even / q, odd, even * q), strict=True):
                sums[name] += float(stress * value)
    f = 2 / np.pi * c["friction"] * 35.0 / c["conductivity"] / c["pressure"]
    share = sums["static"] / (sums["static"] + sums["T"])
    return {
        "T": f * sums["T"],
        "share": share,
        "D": np.sqrt(sums["T"] / sums["laplacian"]),
        "d": -sums["T"] / sums["slope"],
        "g0": sums["g0"],
        "G_end": reached * hardness**2,
    }


def main():
    reference = {
        "angular": [[a, *angular(a)] for a in (1e-9, 1e-3, 0.1, 0.5, 1.0, 3.0, 30.0, 1e4, 1e9)],
        "areas": [
            [s, g, *areas(s, g)]
            for s in (2.0**-20, 0.075, 0.5, 0.9375)
            for g in (1e-5, 1e-4, 1e-3, 1e-2, 0.03, 0.06, 0.1, 0.19, 0.21, 0.5, 1.0, 3.0, 9.0)
        ],
        "cases": {name: {"given": case, **whole_case(case)} for name, case in CASES.items()},
        "six_decades": {**six_decades(SIX_DECADES), "given": SIX_DECADES},
        "far": {
            "given": FAR,
            "r": [0.03, 0.3, 2.0],
            "g": [brute_force(FAR, r) for r in (0.03, 0.3, 2.0)],
        },
        "steel": {"given": BEST, **{f"{y:g}": steel(y) for y in (0.5e9, 1.2e9, 2e9)}},
    }
    path = Path(__file__).with_name("theory.json")
    path.write_text(json.dumps(reference, indent=1) + "\n")


if __name__ == "__main__":
    main()
