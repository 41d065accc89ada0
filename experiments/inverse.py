"""What the paper's printed numbers determine about its unpublished input, and what they do not.

    python experiments/inverse.py [--toy] [-o FOLDER] [--evidence]

For a surface that yields fully, everything is an integral over g = G/sigma_P^2 with fixed weights; C(q) enters only as
the wavenumber q(g), an arbitrary rising function. So T_flash, D_flash, the share s and d_flash are moments of one
positive measure over q, whose total mass, g_sigma(0), depends on gamma alone. Linear programming over all measures
then bounds gamma for any C(q) whatever. And for each exponent m of C ~ q^(-m) there is one spectrum with the printed
T_flash, D_flash and s: the data do not choose among them.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path

import matplotlib as mpl
import numpy as np
from figures.style import AMBER, BLACK, BLUE, new_figure
from scipy.optimize import linprog, root
from scipy.special import erf
from script import Command, show_on_pages, write_evidence

from theory import flash, partition, persson, plasticity

PRESSURE, HARDNESS, SPEED = 90e6, 1.2e9, 35.0
LOAD = {"effective_modulus": 2e11 / 0.91 / 2, "nominal_pressure": PRESSURE}
BODY = {"conductivity": 30.0, "diffusivity": 30.0 / 3.95e6}
HEATING = 0.11 * SPEED / (BODY["conductivity"] * PRESSURE) * 2 / pi
T, D, S, SLOPE = (
    (258.5, 259.5),
    (46.575e-6, 46.585e-6),
    (0.9375, 0.9385),
    (117.5e-6, 118.5e-6),
)  # as printed, rounded
SHARE = 0.938


@dataclass(frozen=True)
class PowerLaw:
    """C = level (q/q_min)^(−exponent) from q_min on, m⁴."""

    level: float
    exponent: float
    q_min: float

    @property
    def breaks(self) -> tuple[float, float]:
        """Return the ends, rad/m."""
        return self.q_min, 4.15e7

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """Return C(q), m⁴."""
        return np.asarray(self.level * (q / self.q_min) ** -self.exponent)


def weights() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return g on Gauss nodes and g_σ(0) dg there for W = P and for W = P³, Pa²."""
    x, w = np.polynomial.legendre.leggauss(12)
    edges = np.sqrt(np.array([0.0, 2e-4, 2e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.5]))
    middle, half = (edges[1:] + edges[:-1])[:, None] / 2, np.diff(edges)[:, None] / 2
    y, dy = middle + half * x, half * w
    s = PRESSURE / HARDNESS
    density = plasticity.smoothing(s, 1 - s, y.ravel() ** 2).reshape(y.shape) * 2 * y
    fit = np.linalg.inv(np.polynomial.legendre.legvander(x, 11))
    integrals = np.polynomial.legendre.legint(np.eye(12), axis=0, lbnd=-1)
    within = density @ (np.polynomial.legendre.legval(x, integrals).T @ fit).T * half
    before = np.cumsum((density * dy).sum(axis=1)) - (density * dy).sum(axis=1)
    share = erf(s / (2 * np.sqrt(before[:, None] + within)))
    mass = 2 * HARDNESS**2 * density * dy
    return (y**2).ravel(), (mass * share).ravel(), (mass * share**3).ravel()


G, FIRST, THIRD = weights()


def kernels(q: np.ndarray) -> dict[str, np.ndarray]:
    """Return what the measure is multiplied with for T, its Laplacian, its slope and the resting T."""
    even, odd = flash.angular_integrals(SPEED / (BODY["diffusivity"] * q))
    return {"T": even / q, "laplacian": even * q, "slope": -odd, "rest": pi / 2 / q}


def bound(printed: str, sign: int, points: int) -> float:
    """Return the least (sign 1) or largest (−1) γ of any measure with T and D, and s and d if they are in `printed`."""
    q = np.geomspace(1e2, 1e7, points)
    k = kernels(q)
    scaled = HEATING * 1e16 * k["T"]
    rows, right = [-scaled * SHARE / T[0], scaled * SHARE / T[1]], [-1.0, 1.0]
    ratios = [(k["T"], k["laplacian"], D[0] ** 2, D[1] ** 2)]
    if "s" in printed:
        ratios.append((k["rest"], k["T"], S[0] / (1 - S[0]), S[1] / (1 - S[1])))
    if "d" in printed:
        ratios.append((k["T"], k["slope"], *SLOPE))
    for upper, lower, least, most in ratios:
        size = np.median(upper)
        rows += [(least * lower - upper) / size, (upper - most * lower) / size]
        right += [0.0, 0.0]
    found = linprog(
        sign * np.ones(points), A_ub=np.array(rows), b_ub=right, bounds=(0, None), method="highs"
    )
    if found.status != 0:
        raise RuntimeError(f"no measure has the printed {printed}: {found.message}")
    return float((sign * found.fun * 1e16 - THIRD.sum()) / (FIRST.sum() - THIRD.sum()))


def member(exponent: float) -> tuple[PowerLaw, float]:
    """Return the spectrum C ~ q^(−exponent), and the γ, with the printed T_flash, D_flash and s."""

    def numbers(unknown: np.ndarray) -> np.ndarray:
        q_min, level = np.exp(unknown[:2])
        n = 4 - exponent
        cube = G * HARDNESS**2 * 4 / (pi * LOAD["effective_modulus"] ** 2)
        q = q_min * (1 + n * cube / (level * q_min**4)) ** (1 / n)
        mass = unknown[2] * FIRST + (1 - unknown[2]) * THIRD
        total = {name: mass @ kernel for name, kernel in kernels(q).items()}
        rise, width = HEATING * SHARE * total["T"], np.sqrt(total["T"] / total["laplacian"])
        return np.array(
            [
                np.log(rise / 259),
                np.log(width / 46.58e-6),
                total["rest"] / total["T"] / (SHARE / (1 - SHARE)) - 1,
            ]
        )

    found = root(numbers, np.array([np.log(6e3), np.log(8e-22), 0.29]), tol=1e-12)
    if not found.success:
        raise RuntimeError(f"no spectrum of exponent {exponent}: {found.message}")
    return PowerLaw(float(np.exp(found.x[1])), exponent, float(np.exp(found.x[0]))), float(
        found.x[2]
    )


def check(spectrum: PowerLaw, gamma: float) -> dict[str, float]:
    """Return what the package's own quadrature makes of it."""
    smooth = plasticity.smoothed_spectrum(spectrum, penetration_hardness=HARDNESS, **LOAD)
    contact = {**LOAD, "gamma": gamma}
    heat = {**contact, **BODY, "friction_coefficient": 0.11}
    return {
        "T": SHARE * flash.flash_temperature(SPEED, smooth, **heat),
        "D": flash.flash_width(SPEED, smooth, **heat) * 1e6,
        "s": partition.moving_share(SPEED, smooth, **contact, **BODY),
        "d": flash.slope_length(SPEED, smooth, **heat) * 1e6,
        "r": persson.correlation_radius(0.1, smooth, **contact) * 1e6,
        "h": np.sqrt(spectrum_variance(spectrum) / 2) * 1e6,
    }


def spectrum_variance(spectrum: PowerLaw, q_max: float = 9.4e4) -> float:
    """Return ⟨h²⟩ of both faces up to the paper-like roll-off, m²."""
    n = 2 - spectrum.exponent
    ratio = q_max / spectrum.q_min
    integral = np.log(ratio) if n == 0 else (ratio**n - 1) / n
    return 2 * pi * spectrum.level * spectrum.q_min**2 * float(integral)


SETS = {"": "T, D", "s": "T, D, s", "d": "T, D, d", "sd": "T, D, s, d"}


def chart(
    folder: Path, bounds: dict[str, tuple[float, float]], family: list[tuple[PowerLaw, float]]
) -> None:
    """Draw the bounds of γ, and below them the spectra with the same printed numbers."""
    with new_figure(folder / "inverse.png", 4.6) as figure:
        upper, lower = figure.subplots(2, 1, height_ratios=[1, 1.9])
        ticks = []
        for row, (name, (low, high)) in enumerate(bounds.items()):
            upper.barh(row, high - max(low, 0.0), left=max(low, 0.0), height=0.5, color=BLUE)
            ticks.append(f"{SETS[name]}: {max(low, 0):.3f} to {high:.3f}")
        public = upper.axvspan(0.42, 0.5, color=AMBER, alpha=0.3, lw=0)
        used = upper.axvline(0.294, color=BLACK, ls="--")
        upper.set(yticks=range(4), yticklabels=ticks, xlim=(0, 0.52), ylim=(3.6, -0.6))
        upper.set(title="reproduced by some $C(q)$", xlabel="$\\gamma$")
        upper.tick_params(left=False)
        upper.grid(visible=False)
        words = ["$\\gamma$ of public\ncodes", "$\\gamma$ = 0.294"]
        upper.legend([public, used], words, loc="center left", bbox_to_anchor=(1.0, 0.5))
        colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(family)))
        for (spectrum, gamma), colour in zip(family, colours, strict=True):
            q = np.geomspace(spectrum.q_min, 3e5, 100)
            smooth = plasticity.smoothed_spectrum(spectrum, penetration_hardness=HARDNESS, **LOAD)
            lower.loglog(q, spectrum(q), color=colour, lw=0.7)
            name = f"$m$ = {spectrum.exponent:g}, $\\gamma$ = {gamma:.3f}"
            lower.loglog(
                q, np.where(smooth(q) > 1e-26, smooth(q), np.nan), color=colour, lw=1.8, label=name
            )
        lower.set(
            title=r"the same $T_\mathrm{flash}$, $D_\mathrm{flash}$ and $s$", ylim=(1e-26, 1e-20)
        )
        lower.set(
            xlabel="wavenumber $q$ (rad/m)", ylabel=r"$C$, $C_\mathrm{sm}$ of both faces (m⁴)"
        )
        lower.legend(
            loc="center left",
            bbox_to_anchor=(1.0, 0.5),
            title=r"$C \propto q^{-m}$",
            alignment="left",
        )


FOUND = """So gamma is known to about 0.02 if all four numbers are taken as printed, and the 0.42 ... 0.5 of public
codes cannot have produced them; the level and the lower end of C(q) go with the exponent. Only d_flash = 118 um
tells the exponents apart (1.3 ... 1.7 within its rounding), and what C(q) does where everything has yielded leaves
no trace."""


def main() -> None:
    options = Command(__file__, __doc__, "coarser wavenumbers, fewer spectra").parse()
    points = 400 if options.toy else 3000
    bounds = {name: (bound(name, 1, points), bound(name, -1, points)) for name in SETS}
    print(
        "bounds on gamma for any C(q) that yields fully, from the printed 259 K, 46.58 um, s = 0.938, d = 118 um"
    )
    for name, (low, high) in bounds.items():
        print(f"  {SETS[name]:12} {max(low, 0.0):.3f} ... {high:.3f}")
    family = [member(m) for m in ((1.0, 2.0) if options.toy else (1.0, 1.5, 2.0, 2.5, 3.0))]
    print(
        "one spectrum C ~ q^(-m) for each m has the printed T, D and s; rms height of one face up to 9.4e4 1/m:"
    )
    names = ("gamma", "q_min 1/m", "h_rms um", "T K", "D um", "s", "d um", "r(0.1) um")
    print(f"  {'m':>4}" + "".join(f"{name:>10}" for name in names))
    for spectrum, gamma in family:
        got = check(spectrum, gamma)
        row = f"{got['h']:10.3f}{got['T']:10.3f}{got['D']:10.3f}{got['s']:10.5f}{got['d']:10.2f}{got['r']:10.1f}"
        print(f"  {spectrum.exponent:4g}{gamma:10.4f}{spectrum.q_min:10.0f}{row}")
    print(FOUND)
    chart(options.output, bounds, family)
    if options.evidence:
        show_on_pages(options.output / "inverse.png")
        numbers = {f"gamma_low_{name}": low for name, (low, _) in bounds.items()}
        numbers |= {f"gamma_high_{name}": high for name, (_, high) in bounds.items()}
        write_evidence("inverse", "python experiments/inverse.py --evidence", numbers=numbers)


if __name__ == "__main__":
    main()
