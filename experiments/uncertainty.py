"""Does the theory agree with the measured ~200 K within what the data leave open? 10 000 draws, and a tornado chart.

    python experiments/uncertainty.py [--toy] [-o FOLDER] [--draws N] [--seed N] [--evidence]

Steel on steel at 35 m/s. Drawn evenly, within what the paper and its sources allow: conductivity, friction, hardness,
roughness, the longest wavelength, the sliding time, gamma, and the rule of heat sharing ("mean", the paper's, or
"total"). Each draw is one integral over g = G/sigma_P^2, all draws at once; it is checked against
theory.flash on some of them. --toy draws 1000.
"""

from __future__ import annotations

import time
from math import pi, sqrt
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from figures.style import AMBER, BLACK, BLUE, SKY, new_figure
from scipy.special import erf
from script import Command, show_on_pages, write_evidence

import roughsim as rs
from theory import flash, hardness, partition, plasticity

Draws = dict[str, Any]

SPEED, PRESSURE, MODULUS, HEAT_CAPACITY = 35.0, 90e6, 2e11 / (1 - 0.3**2) / 2, 7900.0 * 500.0
SHAPE = {"hurst": 0.8, "q_roll_off": 9.4e4, "q_max": 4.15e7, "roll_off_exponent": 1.5}
MEASURED = 200.0
RANGES = {  # low, the paper's choice, high
    "conductivity": (21.0, 30.0, 50.0),  # work-hardened and hot ... soft and cold
    "friction": (0.08, 0.11, 0.14),  # "not constant during the tests": assumed +-0.03
    "hardness": (0.5e9, 1.2e9, 2.0e9),  # the paper's three
    "rms_height": (
        0.72e-6,
        0.90e-6,
        1.00e-6,
    ),  # R_a = 0.8 um is 1.0 um rms; the paper's 0.90 has R_a = 0.72
    "q_min": (4e3, 6350.0, 1e4),  # assumed: the spectrum is not published
    "gamma": (0.257, 0.294, 0.5),  # what the printed numbers bound ... what simulations give
    "duration": (1e-4, 5e-4, 1e-3),  # s, counts for the rule "total" only
}
NAMES = {
    "conductivity": "conductivity (W/(m K))",
    "friction": "friction coefficient",
    "hardness": "hardness (GPa)",
    "rms_height": "rms height (µm)",
    "q_min": "smallest wavenumber (1/mm)",
    "gamma": "γ",
    "duration": 'sliding time (ms), "total"',
}
UNITS = {"hardness": 1e-9, "rms_height": 1e6, "q_min": 1e-3, "duration": 1e3}
NODES = np.sqrt(
    np.array([0.0, 2e-4, 2e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.5])
)  # panels in sqrt(g); factor < e^(-34) beyond


def draw(count: int, rng: np.random.Generator) -> Draws:
    sample: Draws = {name: rng.uniform(low, high, count) for name, (low, _, high) in RANGES.items()}
    return {**sample, "total": rng.random(count) < 0.5}


def central(count: int) -> Draws:
    return {
        **{name: np.full(count, middle) for name, (_, middle, _) in RANGES.items()},
        "total": np.zeros(count, bool),
    }


def wavenumber(half: np.ndarray, draws: Draws) -> np.ndarray:
    """Invert ∫ q³ C dq = half for C of two powers, m = 3/2 below the roll-off; shape (draws, nodes)."""
    low, roll = draws["q_min"][:, None], SHAPE["q_roll_off"]
    psd = psd_at_roll_off(draws)[:, None] * roll**4
    first, second = 4 - SHAPE["roll_off_exponent"], 2 - 2 * SHAPE["hurst"]
    start, kink = (low / roll) ** first, (1 - (low / roll) ** first) / first
    below = (start + first * np.minimum(half / psd, kink)) ** (1 / first)
    above = (1 + second * np.maximum(half / psd - kink, 0.0)) ** (1 / second)
    return roll * np.where(half / psd <= kink, below, above)


def psd_at_roll_off(draws: Draws) -> np.ndarray:
    """C at the roll-off for both faces together, from ⟨h²⟩ = 2π ∫ q C dq."""
    roll, m, two_h = SHAPE["q_roll_off"], SHAPE["roll_off_exponent"], 2 * SHAPE["hurst"]
    below = (1 - (draws["q_min"] / roll) ** (2 - m)) / (2 - m)
    above = (1 - (SHAPE["q_max"] / roll) ** -two_h) / two_h
    return 2 * draws["rms_height"] ** 2 / (2 * pi * roll**2 * (below + above))


def smoothing(points: np.ndarray, draws: Draws) -> np.ndarray:
    """Eq. (27) at g = points² for each hardness drawn, shape (draws, nodes)."""
    s = PRESSURE / draws["hardness"]
    return np.array([plasticity.smoothing(a, 1 - a, points**2) for a in s])


def stress(draws: Draws) -> tuple[np.ndarray, np.ndarray]:
    """Wavenumbers and s(q) dq of Eq. (4) on Gauss nodes: (π/2) E*² q³ C dq = 2 dG, G = g σ_P²; (draws, nodes)."""
    x, w = np.polynomial.legendre.leggauss(12)
    middle, half = (NODES[1:] + NODES[:-1])[:, None] / 2, np.diff(NODES)[:, None] / 2
    y, weight = (middle + half * x).ravel(), (half * w).ravel()
    factor = smoothing(y, draws)
    degree = np.arange(12)
    fit = np.linalg.inv(np.polynomial.legendre.legvander(x, 11))
    primitive = np.polynomial.legendre.legval(
        x, np.polynomial.legendre.legint(np.eye(12)[:, degree], axis=0, lbnd=-1)
    ).T
    density = (factor * 2 * y).reshape(len(factor), -1, 12)
    whole = (density * (half * w)).sum(axis=2)
    before = np.cumsum(whole, axis=1) - whole
    smooth = (before[..., None] + half * (density @ (primitive @ fit).T)).reshape(factor.shape)
    share = erf((PRESSURE / draws["hardness"])[:, None] / (2 * np.sqrt(smooth)))
    gamma, hardness_drawn = draws["gamma"][:, None], draws["hardness"][:, None]
    weighted = (
        2 * hardness_drawn**2 * factor * share * (gamma + (1 - gamma) * share**2) * 2 * y * weight
    )
    return wavenumber(y**2 * hardness_drawn**2 * 4 / (pi * MODULUS**2), draws), weighted


def flash_temperature(draws: Draws) -> np.ndarray:
    """T_flash with the share of each draw, K."""
    q, s = stress(draws)
    diffusivity = draws["conductivity"] / HEAT_CAPACITY
    moving = (
        (s / q * flash.angular_integrals(SPEED / (diffusivity[:, None] * q))[0]).sum(axis=1)
        * 2
        / pi
    )
    resting = (s / q).sum(axis=1)
    depth = np.sqrt(diffusivity * draws["duration"])
    background = 2 * PRESSURE**2 * depth / sqrt(pi)
    grown = (s / q * erf(q * depth[:, None])).sum(axis=1)
    mean = resting / (resting + moving)
    total = (background + grown) / (2 * background + grown + moving)
    share = np.where(draws["total"], total, mean)
    return share * draws["friction"] * SPEED / (draws["conductivity"] * PRESSURE) * moving


def exact(draws: Draws, index: int) -> float:
    """The same by the package's own adaptive quadrature."""
    one = {name: float(values[index]) for name, values in draws.items()}
    face = rs.SelfAffineSpectrum.from_rms_height(one["rms_height"], q_min=one["q_min"], **SHAPE)
    load = {"effective_modulus": MODULUS, "nominal_pressure": PRESSURE}
    smooth = plasticity.smoothed_spectrum(
        face.scaled(2.0), penetration_hardness=one["hardness"], **load
    )
    body = {"conductivity": one["conductivity"], "diffusivity": one["conductivity"] / HEAT_CAPACITY}
    rule = {"rule": "total", "duration": one["duration"]} if one["total"] else {}
    share = partition.moving_share(SPEED, smooth, **load, **body, gamma=one["gamma"], **rule)
    heat = {"friction_coefficient": one["friction"], "gamma": one["gamma"]}
    return share * flash.flash_temperature(SPEED, smooth, **load, **body, **heat)


def tornado() -> list[tuple[str, float, float, float]]:
    """Return (name, T at low, T at high, width) with all else central, widest last; and the rule of sharing."""
    bars = []
    for name, (low, _, high) in RANGES.items():
        one = central(2)
        one[name] = np.array([low, high])
        one["total"] = np.full(2, name == "duration")
        bars.append((name, *flash_temperature(one).tolist()))
    rule = {**central(2), "total": np.array([False, True])}
    bars.append(("rule", *flash_temperature(rule).tolist()))
    return sorted(((n, a, b, abs(b - a)) for n, a, b in bars), key=lambda bar: bar[3])


def chart(
    folder: Path, sample: Draws, rise: np.ndarray, bars: list[tuple[str, float, float, float]]
) -> None:
    """Draw the distribution of T_flash, and below it how much each input changes it."""
    with new_figure(folder / "uncertainty.png", 4.9) as figure:
        upper, lower = figure.subplots(2, 1, height_ratios=[1, 1.5], sharex=True)
        bins = np.linspace(0, np.quantile(rise, 0.998), 60)
        for rule, colour in ((False, BLUE), (True, AMBER)):
            look = {
                "histtype": "stepfilled",
                "fc": mpl.colors.to_rgba(colour, 0.25),
                "ec": colour,
                "lw": 1.2,
            }
            name = f'heat share by "{"total" if rule else "mean"}"'
            upper.hist(rise[sample["total"] == rule], bins=bins, label=name, **look)
        upper.set(title="random inputs", ylabel="draws", yticks=[])
        upper.spines["left"].set_visible(False)
        middle = float(flash_temperature(central(1))[0])
        for row, (name, low, high, _) in enumerate(bars):
            lower.barh(
                row, high - low, left=low, height=0.62, color=AMBER if name == "rule" else SKY
            )
            words = '"mean"', '"total"'
            if name != "rule":
                words = tuple(f"{RANGES[name][k] * UNITS.get(name, 1):.3g}" for k in (0, 2))
            for value, text in zip((low, high), words, strict=True):
                side = -1 if value == min(low, high) else 1
                place = {
                    "xytext": (4 * side, 0),
                    "textcoords": "offset points",
                    "va": "center",
                    "fontsize": 8.5,
                }
                place["bbox"] = {"color": "w", "pad": 0.6}
                lower.annotate(text, (value, row), ha="right" if side < 0 else "left", **place)
        for axes in (upper, lower):
            axes.axvline(MEASURED, color=BLACK, ls="--", label="measured, about 200 K")
            axes.axvline(middle, color="0.4", label=f"the paper's values, {middle:.0f} K")
            axes.grid(visible=False)
        lower.set(
            yticks=range(len(bars)),
            yticklabels=[NAMES.get(name, "rule of the heat share") for name, *_ in bars],
        )
        lower.set(title="one input at a time", xlabel=r"$T_\mathrm{flash}$ (K)")
        lower.tick_params(left=False)
        figure.legend(*upper.get_legend_handles_labels(), loc="outside lower center", ncols=2)


def hot_hardness() -> tuple[float, float]:
    """The scalar fixed point sigma_P(T0 + T_flash) for an assumed table of a medium carbon steel, T0 = 700 K above."""
    one = central(1)

    def rise(value: float) -> float:
        return float(flash_temperature({**one, "hardness": np.array([value])})[0])

    above, table = (
        [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0],
        [1.2e9, 1.1e9, 0.95e9, 0.6e9, 0.35e9, 0.2e9],
    )
    return hardness.self_consistent(rise, above, table, background=0.0)


def main() -> None:
    command = Command(__file__, __doc__, "1000 draws")
    command.add_argument("--draws", type=int, default=10_000)
    command.add_argument("--seed", type=int, default=1)
    options = command.parse()
    start = time.perf_counter()
    sample = draw(1000 if options.toy else options.draws, np.random.default_rng(options.seed))
    rise = flash_temperature(sample)
    taken = time.perf_counter() - start
    checks = [rise[i] / exact(sample, i) - 1 for i in range(10)]
    off = np.abs(checks).max()
    print(
        f"{rise.size} draws in {taken:.2f} s; ten of them differ from theory.flash by at most {off:.1e}"
    )
    numbers = {}
    for name, chosen in (
        ("mean", ~sample["total"]),
        ("total", sample["total"]),
        ("both", np.full(rise.size, True)),
    ):
        low, median, high = np.quantile(rise[chosen], [0.05, 0.5, 0.95])
        numbers |= {f"{name}_5": low, f"{name}_50": median, f"{name}_95": high}
        below = (rise[chosen] < MEASURED).mean()
        span = f"median {median:4.0f} K, 5 ... 95 %: {low:4.0f} ... {high:4.0f} K"
        print(f"rule {name:6} {span}; below {MEASURED:.0f} K: {100 * below:.0f} %")
    bars = tornado()
    print("one at a time, K:")
    for name, low, high, _ in reversed(bars):
        print(f"  {NAMES.get(name, 'rule mean -> total'):30} {low:6.1f} ... {high:6.1f}")
    softened, hot = hot_hardness()
    print(
        f"with an assumed hot hardness (1.2 GPa cold): sigma_P = {softened / 1e9:.2f} GPa at T_flash = {hot:.0f} K"
    )
    chart(options.output, sample, rise, bars)
    if options.evidence:
        show_on_pages(options.output / "uncertainty.png")
        write_evidence(
            "uncertainty", "python experiments/uncertainty.py --evidence", numbers=numbers
        )


if __name__ == "__main__":
    main()
