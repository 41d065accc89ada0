"""Sharing the heat of a Hertz contact between two bodies by three rules: "mean", "total", and at every point.

    python experiments/partition.py [--toy] [-o FOLDER] [--evidence]

One body rests, the other moves, both of one steel; then the moving one conducts a tenth; then both move. Drawn over
Pe = vR/D: the share of the moving body, and T_flash and T_max of the two rules with one number against the pointwise
solution, which is steady and has no background. "mean" is steady too. "total" adds the background of a surface with
7.5 % of such contacts after the time t = R²/D, about 1 ms for steel. It warms both bodies alike if they are of one
material, whichever moves, and so more of the heat goes to the one that rests than by the flash temperatures alone. Last
the largest local difference |T₁ - T₂| under "mean": it is the same for the first two cases, whose temperatures have the
same shape.

Printed last: how long a hot spot of the steel scene lives beside the time to warm up at rest, T_flash with the share of
the paper and with 1/2, and the hardness of this steel at the temperature of its contact.
"""

from __future__ import annotations

from dataclasses import replace

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from script import Command, write_evidence

import roughsim as rs
from roughsim.heat import source_temperature
from roughsim.prediction.hot_hardness import hot_hardness
from theory import flash, hertz, plasticity

mpl.rcParams.update(
    {"font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False}
)
mpl.rcParams.update(
    {"legend.frameon": False, "figure.constrained_layout.use": True, "savefig.dpi": 150}
)
CASES = {
    "equal bodies, one at rest": (1.0, 0.0),
    "the moving body has a tenth of the conductivity": (0.1, 0.0),
    "both bodies move, in opposite directions": (1.0, -1.0),
}
COLOURS, WIDTHS = (
    ("#0072B2", "#D55E00", "#009E73"),
    (3.5, 1.4, 1.4),
)  # the first shows behind one that hides it
STYLES = {"pointwise": "-", "mean": "--", "total": ":"}
SCENE, SPEED, FASTEST = "steel-1.2GPa", 35.0, 100.0  # m/s
HARDNESS = (300.0, 600.0, 900.0), (1.5e9, 1.2e9, 0.8e9)  # K, Pa: assumed
CONTACT_FRACTION, TIME = 0.075, 1.0  # of the rule "total"; the time in R²/D


def hertz_source(pixels):
    """A Hertz source of radius 1 with unit peak, on pixels of 1/`pixels`."""
    count = 2 * pixels + 2
    x = (np.arange(count) - (count - 1) / 2) / pixels
    return np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0)), rs.Grid(
        (count, count), (count / pixels,) * 2
    )


def three_rules(flux, grid, peclet, ratio, counter):
    """(share, T_flash, T_max) of the moving body by each rule; and the mismatch of "mean"."""
    moving = rs.Body(conductivity=ratio, diffusivity=ratio, speed=peclet * ratio)
    resting = rs.Body(conductivity=1.0, diffusivity=1.0, speed=counter * peclet)
    point, mean = (
        rs.partition_heat(flux, grid, moving=moving, resting=resting, pointwise=p)
        for p in (True, False)
    )
    found = {
        name: np.array([one.moving_share, one.flash_temperature, one.max_temperature])
        for name, one in (("pointwise", point), ("mean", mean))
    }
    hot, cold = (with_background(flux, grid, body) for body in (moving, resting))
    share = cold / (hot + cold)
    found["total"] = found["mean"] * share / mean.moving_share  # fields are linear in the share
    return found, mean.mismatch


def with_background(flux, grid, body):
    """T_flash and background of a body with all the heat; a body that rests has warmed for the time only."""
    steady = body.speed != 0.0
    flash = source_temperature(
        flux,
        grid,
        speed=body.speed,
        conductivity=body.conductivity,
        diffusivity=body.diffusivity,
        time=np.inf if steady else TIME,
    ).flash_temperature
    mean = CONTACT_FRACTION * flux[flux > 0].mean()
    return flash + 2 * mean / body.conductivity * np.sqrt(body.diffusivity * TIME / np.pi)


def draw(places, peclets, results, colour, width):
    """One case in all four panels."""
    share, flash, hottest, jump = places
    found = {rule: np.array([found[rule] for found, _ in results]).T for rule in STYLES}
    for rule, style in STYLES.items():
        share.semilogx(peclets, found[rule][0], color=colour, ls=style)
        for axis, k in ((flash, 1), (hottest, 2)):
            if rule != "pointwise":
                axis.semilogx(
                    peclets,
                    100 * (found[rule][k] / found["pointwise"][k] - 1),
                    color=colour,
                    ls=style,
                )
    jump.semilogx(peclets, [mismatch for _, mismatch in results], color=colour, lw=width)


def tell(peclets, results, name):
    for peclet, (found, mismatch) in list(zip(peclets, results, strict=True))[
        :: max(1, len(peclets) // 5)
    ]:
        shares = "".join(f"{found[rule][0]:11.4f}" for rule in STYLES)
        against = {rule: 100 * (found[rule] / found["pointwise"] - 1) for rule in ("mean", "total")}
        errors = "".join(f"{error[k]:+10.2f}%" for k in (1, 2) for error in against.values())
        print(f"{name:48}{peclet:9.3g}{shares}{errors}{mismatch:11.3f}")


def largest(results, name):
    """A row of the table: the case, errors of both rules that are largest in size, and the largest mismatch."""
    cells = []
    for rule in ("mean", "total"):
        for k in (1, 2):  # T_flash, T_max
            errors = [100 * (found[rule][k] / found["pointwise"][k] - 1) for found, _ in results]
            cells.append(f"{max(errors, key=abs):+.2g} %".replace("-", "−"))
    return [name, *cells, f"{max(mismatch for _, mismatch in results):.2f}"]


def steel():
    """The scene, its smoothed spectrum, load, and heat, for the functions of `theory.flash`."""
    scene = rs.load_scene(SCENE)
    load = {
        "effective_modulus": scene.effective_modulus,
        "nominal_pressure": scene.sliding.nominal_pressure,
    }
    smooth = plasticity.smoothed_spectrum(
        scene.spectrum, **load, penetration_hardness=scene.penetration_hardness
    )
    body = scene.conduction()
    heat = {
        "conductivity": body.conductivity,
        "diffusivity": body.diffusivity,
        "gamma": scene.theory.gamma,
    }
    return scene, smooth, load | heat | {"friction_coefficient": scene.friction_coefficient()}


def life_of_a_spot():
    """A table of the spot, of the radius R of the Hertz contact that has the theory's D_flash of fast sliding."""
    _, smooth, given = steel()
    radius = float(flash.flash_width(FASTEST, smooth, **given)) / hertz.FAST.flash_width
    warm, lives = radius**2 / given["diffusivity"], 2 * radius / SPEED
    return [
        ["", ""],
        ["radius of a hot spot, R", f"{1e6 * radius:.0f} µm"],
        ["time to warm up at rest, R²/D", f"{1e3 * warm:.1f} ms"],
        ["lifetime of a spot, 2R/v", f"{1e6 * lives:.1f} µs"],
        ["ratio of the two times, Pe/2", f"{warm / lives:.0f}"],
    ]


def hot_steel():
    """Hardness, GPa, and T_flash, K, of the scene at the temperature of its contact, by the law and by the theory."""
    scene = rs.load_scene(SCENE)
    scene = replace(scene, sliding=replace(scene.sliding, speed=SPEED))
    found = hot_hardness(scene, *HARDNESS, background=HARDNESS[0][0])
    return {"hot_hardness": 1e-9 * found.penetration_hardness, "hot_flash": found.flash_temperature}


def main() -> None:
    options = Command(__file__, __doc__).parse()
    flux, grid = hertz_source(6 if options.toy else 32)
    peclets = np.geomspace(0.1, 1e4, 3 if options.toy else 21)
    figure = Figure(figsize=(8, 6.8))
    share, flash, hottest, jump = figure.subplots(2, 2).flat
    print(
        f"{'':57}{'share of the moving body':^33}{'T_flash to pointwise':>22}{'T_max to pointwise':>22}"
    )
    columns = [*STYLES, "mean", "total", "mean", "total", "mismatch"]
    print(f"{'':48}{'Pe':>9}" + "".join(f"{column:>11}" for column in columns))
    rows = [
        [
            "",
            *(f'{what}, "{rule}"' for rule in ("mean", "total") for what in ("T_flash", "T_max")),
            "mismatch",
        ]
    ]
    for (name, case), colour, width in zip(CASES.items(), COLOURS, WIDTHS, strict=True):
        results = [three_rules(flux, grid, peclet, *case) for peclet in peclets]
        draw((share, flash, hottest, jump), peclets, results, colour, width)
        tell(peclets, results, name)
        rows.append(largest(results, name))
    share.set(title="share of the moving body", ylim=(0, 1))
    flash.set(title=r"$T_\mathrm{flash}$ of one number against pointwise, %")
    hottest.set(title=r"$T_\mathrm{max}$ of one number against pointwise, %", xlabel="$vR/D$")
    jump.set(
        title=r"largest $|T_1 - T_2|\,/\,T_\mathrm{max}$ under the rule mean",
        xlabel="$vR/D$",
        ylim=(0, None),
    )
    for axis in (flash, hottest):
        axis.axhline(0, color="0.7", lw=0.8, zorder=0)
    handles = [
        Line2D([], [], color=c, lw=w, label=name)
        for name, c, w in zip(CASES, COLOURS, WIDTHS, strict=True)
    ]
    handles += [Line2D([], [], color="k", ls=style, label=rule) for rule, style in STYLES.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    figure.savefig(options.output / "partition.png")
    spot, numbers = life_of_a_spot(), hot_steel()
    print(*("  ".join(row) for row in spot[1:]), numbers, sep="\n")
    if options.evidence:
        tables = {"rules": rows, "spot": spot}
        write_evidence(
            "partition",
            "python experiments/partition.py --evidence",
            tables=tables,
            numbers=numbers,
        )


if __name__ == "__main__":
    main()
