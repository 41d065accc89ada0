"""Every figure of the paper that its data allow, and its numbers: printed, exact, and as computed here.

    python experiments/paper.py [--toy] [-o FOLDER] [--evidence]

The scene is steel on steel, two equal faces: C(q) doubled, E* = 109.89 GPa. C(q) itself is not published; the set used
here reproduces the paper's printed numbers (with gamma = 0.294; see experiments/inverse.py). --toy draws fewer points;
--evidence writes the numbers, the table and the figures of docs/theory.md.
"""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from figures.style import BLACK, BLUE, HARDNESS, ORANGE, legend_below, new_figure
from script import EVIDENCE, Command, show_on_pages, write_evidence

import roughsim as rs
from theory import background, flash, hertz, partition, persson, plasticity

FACE = rs.SelfAffineSpectrum.from_rms_height(
    0.9e-6, hurst=0.8, q_min=6350.0, q_roll_off=9.4e4, q_max=4.15e7, roll_off_exponent=1.5
)
PAIR = FACE.scaled(2.0)
LOAD = {"effective_modulus": 2e11 / (1 - 0.3**2) / 2, "nominal_pressure": 90e6}
BODY = {"conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500)}
CONTACT = {**LOAD, "gamma": 0.294}
SLIDING = {**CONTACT, **BODY, "friction_coefficient": 0.11}
SHARE, SPEED = 0.938, 35.0
SMOOTH = {y: plasticity.smoothed_spectrum(PAIR, penetration_hardness=y, **LOAD) for y in HARDNESS}


def label(hardness: float) -> str:
    return f"$\\sigma_P$ = {hardness / 1e9:g} GPa"


def spectra(folder: Path, points: int) -> None:
    """Draw C(q) and C_sm(q), and the stress correlation beside them."""
    q = np.geomspace(PAIR.breaks[0], 2e6, points)
    r = np.linspace(0, 400e-6, points)
    with new_figure(folder / "spectra.png", 3.1) as figure:
        psd, correlation = figure.subplots(1, 2)
        psd.loglog(q, PAIR(q), color=BLACK, label="$C$ of both faces")
        for y, colour in HARDNESS.items():
            psd.loglog(q, SMOOTH[y](q), color=colour, label=label(y))
            stress = persson.pressure_correlation(r, SMOOTH[y], **CONTACT)
            correlation.plot(r * 1e6, stress / 1e16, color=colour)
        psd.set(
            xlabel="wavenumber $q$ (rad/m)",
            ylabel=r"$C$, $C_\mathrm{sm}$ (m⁴)",
            ylim=(1e-30, 3e-21),
        )
        radius = flash.flash_width(SPEED, SMOOTH[1.2e9], **SLIDING) / hertz.FAST.flash_width
        pair = persson.pressure_correlation(0.0, SMOOTH[1.2e9], **CONTACT) / 1e16
        pair *= hertz.pressure_correlation(r / radius)
        psd.plot([], [], color=BLUE, ls=":", label=f"Hertz, $2R$ = {2e6 * radius:.0f} µm")
        correlation.plot(r * 1e6, pair, color=BLUE, ls=":")
        correlation.axhline(0, color="0.5", lw=0.8)
        correlation.set(
            xlabel="distance $r$ (µm)", ylabel=r"$g_\sigma$ ($10^{16}$ Pa²)", xlim=(0, 400)
        )
        psd.set_title("spectrum")
        correlation.set_title("stress correlation")
        legend_below(figure, [psd], 3)


def over_speed(folder: Path, points: int) -> None:
    v = np.geomspace(1e-3, 1e3, points)
    with new_figure(folder / "over_speed.png", 4.9) as figure:
        (rise, width), (slope, free) = figure.subplots(2, 2)
        for y, colour in HARDNESS.items():
            rise.loglog(
                v,
                SHARE * flash.flash_temperature(v, SMOOTH[y], **SLIDING),
                color=colour,
                label=label(y),
            )
            width.semilogx(v, flash.flash_width(v, SMOOTH[y], **SLIDING) * 1e6, color=colour)
            slope.loglog(v, flash.slope_length(v, SMOOTH[y], **SLIDING) * 1e6, color=colour)
        slope.loglog(v, 4e6 * BODY["diffusivity"] / v, color=BLACK, ls=":", label="$4D/v$")
        rise.set(title="flash temperature", ylabel=r"$T_\mathrm{flash}$ (K)")
        width.set(title="width", ylabel=r"$D_\mathrm{flash}$ (µm)", ylim=(0, None))
        slope.set(title="slope length", ylabel=r"$d_\mathrm{flash}$ (µm)", ylim=(30, 1e5))
        for axes in (rise, width, slope):
            axes.axvline(SPEED, color="0.5", ls="--", lw=0.9, label="35 m/s")
            axes.set(xlabel="$v$ (m/s)", xticks=[1e-3, 1e-1, 1e1, 1e3])
            axes.minorticks_off()
        free.set_axis_off()
        keys = [
            dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
            for axes in (rise, slope)
        ]
        names = keys[0] | keys[1]
        free.legend(names.values(), names.keys(), loc="center")


def maps(folder: Path, points: int) -> None:
    x = np.linspace(-2.5, 1.5, points)
    y = np.linspace(-1.5, 1.5, points * 3 // 4)
    columns = {
        "at rest": hertz.static_temperature,
        "fast, moving to the right": hertz.fast_temperature,
    }
    with new_figure(folder / "hertz_maps.png", 3.75) as figure:
        axes = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=[3.3, 2.2])
        for (title, field), (top, bottom) in zip(columns.items(), axes.T, strict=True):
            image = field(x[:, None], y)
            image = image / image.max()
            extent = (x[0], x[-1], y[0], y[-1])
            drawn = top.imshow(
                image.T, origin="lower", extent=extent, cmap="inferno", vmin=0, vmax=1
            )
            angle = np.linspace(0, 2 * pi, 200)
            top.plot(np.cos(angle), np.sin(angle), color="w", lw=0.8, ls="--")
            top.set_title(title)
            top.grid(visible=False)
            profile = field(x, 0.0)
            bottom.axvspan(-1, 1, color="0.92", lw=0, label="contact")
            bottom.plot(x, profile / profile.max(), color=ORANGE, label="temperature at $y$ = 0")
            bottom.plot(x, np.sqrt(np.maximum(1 - x**2, 0)), color=BLACK, ls=":", label="heat flux")
            bottom.set(xlabel="$x/R$", ylim=(0, 1.05), xlim=(x[0], x[-1]))
        axes[0, 0].set_ylabel("$y/R$")
        axes[1, 0].set_ylabel("over its maximum")
        figure.colorbar(drawn, ax=axes[0, :], label=r"$T/T_\mathrm{max}$")
        legend_below(figure, [axes[1, 0]], 3)


def areas(folder: Path, points: int) -> float:
    """Draw the elastoplastic contact area beside the elastic one of the smoothed surface; return how far they part."""
    q = np.geomspace(PAIR.breaks[0] * 1.0001, 1e6, points)
    worst = 0.0
    with new_figure(folder / "contact_area.png", 3.0) as figure:
        axes = figure.subplots()
        for y, colour in HARDNESS.items():
            half = persson.half_variance(q, PAIR, effective_modulus=LOAD["effective_modulus"])
            _, elastic, plastic = plasticity.area_fractions(half, LOAD["nominal_pressure"], y)
            smoothed = persson.contact_probability(q, SMOOTH[y], **LOAD)
            worst = max(worst, float(np.abs(smoothed / (elastic + plastic) - 1).max()))
            some = slice(None, None, points // 18)
            axes.loglog(q / PAIR.breaks[0], elastic + plastic, color=colour, label=label(y))
            axes.loglog(
                q[some] / PAIR.breaks[0], smoothed[some], "o", color=colour, ms=4, mfc="none"
            )
            axes.loglog(q / PAIR.breaks[0], plastic, color=colour, ls="--", lw=0.9)
        axes.plot([], [], "-", color="0.4", label=r"$A_\mathrm{el} + A_\mathrm{pl}$")
        axes.plot(
            [], [], "o", color="0.4", mfc="none", ms=4, label=r"elastic area of $C_\mathrm{sm}$"
        )
        axes.plot([], [], "--", color="0.4", lw=0.9, label=r"$A_\mathrm{pl}$")
        axes.set(
            xlabel=r"magnification $q/q_\mathrm{min}$",
            ylabel="area over the nominal area",
            ylim=(3e-3, 1.2),
        )
        figure.legend(loc="outside right center")
    return worst


def hertz_rows() -> list[tuple[str, str, float, float]]:
    """Return (what, printed, exact limit, value of the finite-speed code at Pe = 0 or 1e10)."""
    static, fast, pe = hertz.STATIC, hertz.FAST, 1e10
    per = 3 / (2 * pi)

    def quick(value: Any) -> float:
        return float(value) * sqrt(pe)

    at, rest = hertz.flash_temperature(pe), hertz.flash_temperature(0.0)
    return [
        ("T_flash/T_1 at rest (14)", "0.8", 0.8, rest / hertz.max_temperature(0.0)),
        ("T_flash, rest (14)", "0.3", per * static.flash_temperature, per * rest),
        (
            "T_max, rest (15)",
            "0.375",
            per * static.max_temperature,
            per * hertz.max_temperature(0.0),
        ),
        (
            "T_av, rest (16)",
            "0.281",
            per * static.mean_temperature,
            per * hertz.mean_temperature(0.0),
        ),
        ("-Lap T R^2/T, rest (18)", "2.5", 2.5, -hertz.flash_laplacian(0.0) / rest),
        ("D_flash/R, rest", "0.63", static.flash_width, hertz.flash_width(0.0)),
        ("f_flash, fast (A2)", "1.305", fast.flash_temperature * sqrt(pi), quick(at) * sqrt(pi)),
        ("T_flash, fast (21)", "0.352", per * fast.flash_temperature, per * quick(at)),
        (
            "T_max, fast (22)",
            "0.590",
            per * fast.max_temperature,
            per * quick(hertz.max_temperature(pe)),
        ),
        (
            "T_av, fast (23)",
            "0.323",
            per * fast.mean_temperature,
            per * quick(hertz.mean_temperature(pe)),
        ),
        (
            "T_av/T_max, fast",
            "0.549",
            fast.mean_temperature / fast.max_temperature,
            hertz.mean_temperature(pe) / hertz.max_temperature(pe),
        ),
        ("-Lap T R^2/T, fast (24)", "4.93", 81 / 16, -hertz.flash_laplacian(pe) / at),
        ("D_flash/R, fast", "0.45", fast.flash_width, hertz.flash_width(pe)),
        ("-T'R/T, fast (A7)", "0.734", 1 / fast.slope_length, -hertz.flash_gradient(pe) / at),
        ("d_flash/R, fast", "1.36", fast.slope_length, hertz.slope_length(pe)),
        (
            "d_flash/D_flash, fast",
            "3.0",
            fast.slope_length / fast.flash_width,
            hertz.slope_length(pe) / hertz.flash_width(pe),
        ),
        ("d_flash/2R, fast", "0.68", fast.slope_length / 2, hertz.slope_length(pe) / 2),
    ]


def steel_rows() -> list[tuple[str, str, float, float]]:
    """Return the numbers of Sec. 4; the exact column is the theory of this C(q) to ten digits where there is one."""
    smooth = SMOOTH[1.2e9]
    width = flash.flash_width(SPEED, smooth, **SLIDING)
    radius = width / hertz.FAST.flash_width
    share = partition.moving_share(SPEED, smooth, **CONTACT, **BODY)
    zero = persson.correlation_radius(0.0, smooth, **CONTACT)
    nan = float("nan")
    flux = share * SLIDING["friction_coefficient"] * LOAD["nominal_pressure"] * SPEED
    return [
        ("share s at 35 m/s", "0.938", nan, share),
        (
            "T_flash at 35 m/s, K",
            "259",
            nan,
            SHARE * flash.flash_temperature(SPEED, smooth, **SLIDING),
        ),
        ("D_flash, um", "46.58", nan, width * 1e6),
        (
            "2R = 2 D_flash/alpha, um",
            "207",
            2 * width / hertz.FAST.flash_width * 1e6,
            2 * width / 0.45 * 1e6,
        ),
        ("d_flash, um", "118", nan, flash.slope_length(SPEED, smooth, **SLIDING) * 1e6),
        (
            "d_flash of Hertz, 2R = 200 um",
            "136",
            200 * hertz.FAST.slope_length / 2,
            200 * hertz.slope_length(1e10) / 2,
        ),
        ("g_sigma = 0 at r, um", "~200", nan, zero * 1e6),
        (
            "g_sigma/g_sigma(0) = 0.1 at, um",
            "~200",
            nan,
            persson.correlation_radius(0.1, smooth, **CONTACT) * 1e6,
        ),
        ("v* = D/R, m/s", "D/R", nan, BODY["diffusivity"] / radius),
        ("background 700 K after, ms", "-", nan, time_to(700.0, flux) * 1e3),
        ("R_a of h_rms = 0.90 um, um", "~0.8", nan, 0.90 * sqrt(2 / pi)),
        ("h_rms of R_a = 0.8 um, um", "0.90", nan, 0.80 * sqrt(pi / 2)),
    ]


def with_printed_modulus() -> float:
    """Return T_flash at 35 m/s with the printed E/2 = 100 GPa in place of E*, K."""
    softer = {"effective_modulus": 100e9}
    smooth = plasticity.smoothed_spectrum(PAIR, penetration_hardness=1.2e9, **(LOAD | softer))
    return float(SHARE * flash.flash_temperature(SPEED, smooth, **(SLIDING | softer)))


def time_to(rise: float, flux: float) -> float:
    return float((rise / background.temperature(1.0, heat_flux=flux, **BODY)) ** 2)


def table() -> str:
    """Return the numbers as printed, exact, and computed here; docs/theory.md explains the differences."""
    lines = [f"{'':34}{'printed':>9}{'exact':>13}{'this run':>13}"]
    for what, printed, exact, value in [*hertz_rows(), *steel_rows()]:
        known = "" if np.isnan(exact) else f"{exact:.7g}"
        lines.append(f"{what:34}{printed:>9}{known:>13}{value:>13.6g}")
    return "\n".join(lines) + "\n"


def main() -> None:
    options = Command(__file__, __doc__, "fewer points").parse()
    points = 60 if options.toy else 300
    for draw in (spectra, over_speed, maps):
        draw(options.output, points)
    worst = areas(options.output, points)
    numbers = table()
    (options.output / "paper.txt").write_text(numbers)
    print(numbers)
    print(
        f"A_el + A_pl and the smoothed surface's elastic area differ by at most {100 * worst:.3f} %"
    )
    if options.evidence:
        names = ("spectra", "over_speed", "hertz_maps", "contact_area")
        show_on_pages(*(options.output / f"{name}.png" for name in names))
        (EVIDENCE.parent / "reference" / "paper.txt").write_text(numbers)
        compliant = {"flash_temperature_at_100GPa": with_printed_modulus()}
        write_evidence("paper", "python experiments/paper.py --evidence", numbers=compliant)


if __name__ == "__main__":
    main()
