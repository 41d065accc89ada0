"""Recompute the reference numbers of moving sources by routes of their own: python tests/reference/make_hertz.py

No code of the package is used, and no autocorrelation in closed form. Moments of the Hertz source: Fourier space, 20
digits, (6/π) ∫ (j₁/q)² q^n A(Pe/q) dq with the oscillating tail by mpmath's quadosc. Means: correlations by quadrature.
Square: heat kernels in time. Maxima of Hertz and disc: rays on a dense fixed rule. Fast limits: the integral (A2) and
its averages. Takes about two minutes.
"""

import itertools
import json
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy import integrate, optimize, special

PECLET = (0.1, 1.0, 10.0, 1000.0)


def even(a):
    h = mp.sqrt(1 + a * a)
    return mp.ellipk((h - 1) / (2 * h)) / mp.sqrt(h)


def odd(a):
    return -mp.pi * a / 8 * mp.hyp2f1(0.75, 1.25, 2, -a * a)


def fourier(kernel, power):
    """(6/π) ∫ j₁² q^(power − 2) kernel dq: j₁² = (1 + 1/q²)/2q² + (1/q² − 1/q⁴) cos(2q)/2 − sin(2q)/q³."""

    def whole(q):
        return (mp.sin(q) / q**2 - mp.cos(q) / q) ** 2 * q ** (power - 2) * kernel(q)

    def smooth(q):
        return (1 + q**-2) / (2 * q**2) * q ** (power - 2) * kernel(q)

    def cosine(q):
        return (q**-2 - q**-4) / 2 * mp.cos(2 * q) * q ** (power - 2) * kernel(q)

    def sine(q):
        return -mp.sin(2 * q) / q**3 * q ** (power - 2) * kernel(q)

    start = 4 * mp.pi
    near = mp.quad(whole, [0, *mp.linspace(mp.mpf("0.01"), start, 13)])
    far = mp.quad(smooth, [start, 100, 1e3, 1e4, 1e6, mp.inf])
    swing = sum(mp.quadosc(f, [start, mp.inf], omega=2) for f in (cosine, sine))
    return float(6 / mp.pi * (near + far + swing))


def moments(pe):
    return {
        "T_flash": fourier(lambda q: even(pe / q), 0),
        "slope": fourier(lambda q: odd(pe / q), 1),
        "laplacian": -fourier(lambda q: even(pe / q), 2),
    }


def against_disc(flux, r):
    """Integral of a source, flux(ρ), over the unit disc at the distance r from its centre."""

    def ring(rho):
        if rho <= 1 - r:
            return 2 * np.pi * rho * flux(rho)
        return (
            2 * np.arccos(np.clip((r * r + rho * rho - 1) / (2 * r * rho), -1, 1)) * rho * flux(rho)
        )

    def bent(u):  # ρ = b + (1 − b) sin² u: the roots at both ends are gone
        rho = edge + (1 - edge) * np.sin(u) ** 2
        return ring(rho) * (1 - edge) * np.sin(2 * u)

    edge = abs(1 - r)
    tight = {"epsabs": 0, "epsrel": 1e-13, "limit": 400}
    inner = integrate.quad(ring, 0, edge, **tight)[0] if r < 1 else 0.0
    return inner + integrate.quad(bent, 0, np.pi / 2, **tight)[0]


def mean(flux, pe):
    def integrand(u):  # r = u²: c(r) starts as r^(3/2)
        return against_disc(flux, u * u) * special.i0e(pe * u * u / 2) * 2 * u

    cuts = np.sqrt([0, 2e-4, 2e-3, 2e-2, 0.2, 1, 1.5, 1.9, 1.99, 1.999, 2])
    x, w = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for a, b in itertools.pairwise(cuts):
        total += sum(
            (b - a) / 2 * weight * integrand((a + b) / 2 + (b - a) / 2 * node)
            for node, weight in zip(x, w, strict=True)
        )
    return total / np.pi


def square(pe):
    """T = (2/√π) ∫ X Y d√τ with the erf differences of both sides; the mean has their integrals."""

    def spread(x, u):
        return (special.erf((x + 1) / (2 * u)) - special.erf((x - 1) / (2 * u))) / 2

    def mean_spread(shift, u):
        def second(x):
            return x * special.erf(x / (2 * u)) + 2 * u / np.sqrt(np.pi) * np.exp(
                -((x / (2 * u)) ** 2)
            )

        return (second(shift + 2) - 2 * second(shift) + second(shift - 2)) / 4

    def over_time(function):
        cuts = [0, *np.geomspace(1e-5, 1e5, 1500)]
        x, w = np.polynomial.legendre.leggauss(20)
        total = sum(
            (b - a) / 2 * w @ function((a + b) / 2 + (b - a) / 2 * x)
            for a, b in itertools.pairwise(cuts)
        )
        return 2 / np.sqrt(np.pi) * total

    def at(x):
        return over_time(lambda u: spread(x + pe * u * u, u) * spread(0.0, u))

    found = optimize.minimize_scalar(
        lambda x: -at(x), bounds=(-1, 0), method="bounded", options={"xatol": 1e-9}
    )
    average = over_time(lambda u: mean_spread(pe * u * u, u) * mean_spread(0.0, u))
    return {"T_max": at(found.x), "x_max": found.x, "T_av": average}


def rays(pe, flux_along):
    """Maximum over x of (1/π) ∫₀^π dφ ∫ q̇ e^(−ar) dr, φ = sinh-graded, r = reach · (t³(4 − 3t)): dense fixed rules."""
    x, w = np.polynomial.legendre.leggauss(400)
    top = np.arcsinh(np.pi * np.sqrt(pe + 1))
    phi = np.sinh(top * (1 + x) / 2) / np.sqrt(pe + 1)
    d_phi = w * top / 2 * np.cosh(top * (1 + x) / 2) / np.sqrt(pe + 1)
    t = (1 + x) / 2
    place, step = np.sin(np.pi / 2 * t**2) ** 2, w / 2 * np.pi * t * np.sin(np.pi * t**2)

    def at(x0):
        c = np.cos(phi)[:, None]
        root = np.sqrt(1 - x0**2 + (x0 * c) ** 2)
        reach, back = root - x0 * c, root + x0 * c
        decay = pe * np.sin(phi / 2)[:, None] ** 2
        inner = (flux_along(reach * place, reach, back) * np.exp(-decay * reach * place)) @ step
        return float(d_phi @ (reach[:, 0] * inner)) / np.pi

    found = optimize.minimize_scalar(
        lambda x0: -at(x0), bounds=(-1, 0), method="bounded", options={"xatol": 1e-9}
    )
    return {"T_max": at(found.x), "x_max": found.x}


def fast():
    """f of (A2) on the line, F(t) = ∫√(1−u²)/√(t−u) du, and its averages: s^(3/2) F(x/s) has closed powers."""
    with mp.workdps(20):

        def f(t):
            if t > 1:
                return mp.quad(lambda u: mp.sqrt(1 - u * u) / mp.sqrt(t - u), [-1, 0, 1])
            return mp.re(mp.quad(lambda z: 2 * mp.sqrt(1 - (t - z * z) ** 2), [0, mp.sqrt(1 + t)]))

        def slope(t):  # ∫ −u/√(1−u²)/√(t−u) du
            return mp.re(
                mp.quad(
                    lambda z: -2 * (t - z * z) / mp.sqrt(1 - (t - z * z) ** 2), [0, mp.sqrt(1 + t)]
                )
            )

        cuts = mp.linspace(-1, 1, 9)
        weighted = mp.quad(lambda t: f(t) * mp.sqrt(1 - t * t), cuts)
        plain = mp.quad(f, cuts)
        tilt = mp.quad(lambda t: f(t) * t / mp.sqrt(1 - t * t), cuts)  # ∫ ∂ₓf q̇ by parts
        power = [
            mp.quad(lambda y, n=n: (1 - y * y) ** n, [-1, 1])
            for n in (mp.mpf(7) / 4, mp.mpf(5) / 4, mp.mpf(5) / 4)
        ]
        top = mp.findroot(slope, 0.65)
        flash = weighted * power[0] / (2 * mp.pi / 3)
        root = mp.sqrt(mp.pi)
        return {
            "T_flash": float(flash / root),
            "T_av": float(plain * power[1] / mp.pi / root),
            "slope": float(-tilt * power[2] / (2 * mp.pi / 3) / root),
            "T_max": float(f(top) / root),
            "x_max": float(-top),
            "line": [
                [t, float(f(mp.mpf(t)) / root)]
                for t in (-0.9, -0.3, 0.5, 0.95, 1.0, 1.2, 4.0, 9.0, 40.0)
            ],
            "disc_T_av": float(
                mp.quad(lambda y: mp.mpf(4) / 3 * (2 * mp.sqrt(1 - y * y)) ** 1.5, [-1, 0, 1])
                / mp.pi
                / root
            ),
        }


def main():
    def hertz(rho):
        return np.sqrt(1 - rho * rho)

    def along(r, reach, back):
        return np.sqrt(np.maximum((reach - r) * (back + r), 0))

    reference = {"fast": fast(), "peclet": {}}
    for pe in PECLET:
        entry = {
            "hertz": {**moments(pe), "T_av": mean(hertz, pe), **rays(pe, along)},
            "square": square(pe),
        }
        entry["disc"] = {
            "T_av": mean(lambda rho: 1.0, pe),
            **rays(pe, lambda r, reach, back: np.ones_like(reach * r)),
        }
        reference["peclet"][f"{pe:g}"] = entry
    Path(__file__).with_name("hertz.json").write_text(json.dumps(reference, indent=1) + "\n")


if __name__ == "__main__":
    main()
