"""The temperature over a contact, and what reacts there: drawn clipped fields against solved contacts.

    python experiments/reactions.py [--slide] [--toy] [-o FOLDER] [--evidence]

The contacts are those of reactions_points.py. `--slide` slides two equally rough steels (two minutes), as `--evidence`
does.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from figures.style import BLUE, GREEN, ORANGE, PINK, legend_below, new_figure
from reactions_points import (
    ENERGIES,
    FIRST,
    KINDS,
    PARTS,
    SHARES,
    TOY,
    beside,
    found,
    part_of,
    speeds_of,
)
from script import Command, Row, show_on_pages, write_evidence

import roughsim as rs
from roughsim import prediction
from roughsim.estimate import fields
from roughsim.observables.distribution import LEVELS
from roughsim.planning.realization import slide_problem
from roughsim.sliding.member import solve_slide
from theory.yielding import ELASTIC_BANDS

COLOURS = {"L": BLUE, "P": ORANGE, "N": GREEN, "E": PINK}
AREA = ELASTIC_BANDS["contact_fraction"]


def coverage(rows: dict[str, tuple[Row, Row]]) -> dict[str, float]:
    """Print and return the share of the solved values within the band of the theory, by kind, in %.

    A rate also has the error of the contact area of the law.
    """
    shares = {}
    for kind, names in (
        ("quantile", SHARES),
        ("area", SHARES),
        ("rate", ENERGIES),
        ("kelvin", ENERGIES),
    ):
        within = []
        for contact, (theory, solved) in rows.items():
            for key in (
                f"{speed} {kind} {name:g}" for speed in speeds_of(contact, solved) for name in names
            ):
                if key not in solved:
                    continue
                value, other, form = (
                    float(x) for x in (theory[key], solved[key], theory[f"{key} form"])
                )
                area = AREA * value if kind == "rate" else 0.0
                drawing = [2 * float(row[f"{key} error"]) for row in (theory, solved)]
                within.append(abs(value - other) <= np.linalg.norm([form, area, *drawing]))
        if not within:
            continue
        shares[f"within_{kind}"] = 100 * float(np.mean(within))
        print(f"{kind}: {np.sum(within)} of {len(within)} within the band")
    return shares


def table(rows: dict[str, tuple[Row, Row]]) -> dict[str, float]:
    """Print theory and solved contacts side by side; return departures, of T/T_flash and in % of a rate.

    They are the rms, and that of 95 %.
    """
    numbers = {}
    print("quantiles of T/T_flash by heat, and rates over that of the nominal area at T_flash")
    print("theory / solved ± standard error of both")
    for name, (theory, solved) in rows.items():
        area = 100 * float(solved["contact_fraction"])
        print(f"{name}, {KINDS[name[0]]}, contact area {area:.2g} %")
        for speed, v in speeds_of(name, solved).items():
            flash = float(theory[f"{speed} flash"]) / float(solved[f"{speed} flash"]) - 1
            print(f"  {v:g} m/s, T_flash {100 * flash:+.1f} %")
            for kind, names in ("quantile", SHARES), ("rate", ENERGIES):
                texts = [
                    f"{name:g}: {beside(theory, solved, f'{speed} {kind} {name:g}')}"
                    for name in names
                ]
                print(f"    {kind} " + "   ".join(texts))
    for kind, names in ("quantile", SHARES), ("rate", ENERGIES):
        for name in names:
            pairs = [
                (float(t[key]), float(s[key]))
                for contact, (t, s) in rows.items()
                for key in (f"{speed} {kind} {name:g}" for speed in speeds_of(contact, s))
            ]
            drawn_, solved_ = np.array(pairs).T
            off = drawn_ - solved_
            relative = off / solved_
            shown, unit = (100 * relative, " %") if kind == "rate" else (off, "")
            worst = shown.flat[np.abs(shown).argmax()]
            numbers[f"{kind}_{name:g}"] = rms = float(np.sqrt(np.mean(shown**2)))
            numbers[f"{kind}_{name:g}_95"] = most = float(np.quantile(np.abs(shown), 0.95))
            print(
                f"{kind} {name:g}: theory − solved rms {rms:.2g}, 95 % {most:.2g}, worst {worst:+.2g}{unit}"
            )
    return numbers


def of_steel() -> dict[str, float]:
    """Return T above which the hottest hundredth of the heat is set free, over T_flash, of steel-1.2GPa in theory."""
    asks = {"sliding.speed": [*FIRST.speeds.values()], "sliding.heat_partition": "all"}
    scene = rs.load_scene("steel-1.2GPa", asks | {"observables.temperature_distribution": True})
    flash = prediction.calibrated_predictions(scene)["flash_temperature"]
    ratios = fields.quantiles(scene)["temperature_quantile_99"].mean / flash
    return {f"steel_{name}": float(ratio) for name, ratio in zip(FIRST.speeds, ratios, strict=True)}


def draw(rows: dict[str, tuple[Row, Row]], path: Path) -> None:
    """Theory over solved contacts: quantiles and rates."""
    with new_figure(path, 3.3) as figure:
        panels = figure.subplots(1, 2)
        for axes, kind, names in ((panels[0], "quantile", SHARES), (panels[1], "rate", ENERGIES)):
            for contact, (theory, solved) in rows.items():
                speeds = [*speeds_of(contact, solved)]
                for speed, marker in (speeds[0], "o"), (speeds[-1], "^"):
                    keys = [f"{speed} {kind} {each:g}" for each in names]
                    x, y = ([float(row[key]) for key in keys] for row in (solved, theory))
                    errors = [
                        [2 * float(row[f"{key} error"]) for key in keys] for row in (solved, theory)
                    ]
                    style: dict[str, Any] = {"fmt": marker, "color": COLOURS[contact[0]], "lw": 0.8}
                    axes.errorbar(x, y, xerr=errors[0], yerr=errors[1], **style)
            limits = np.array(axes.get_xlim())
            axes.plot(limits, limits, color="0.6", lw=0.8)
        for kind, words in KINDS.items():
            panels[0].plot([], [], "s", color=COLOURS[kind], label=words)
        for marker, words in ("o", "slowest"), ("^", "fastest"):
            panels[0].plot([], [], marker, color="0.4", label=words)
        panels[0].set(title=r"quantiles of $T/T_\mathrm{flash}$", xlabel="solved", ylabel="theory")
        panels[1].set(
            title=r"rate / that of $A_0$ at $T_\mathrm{flash}$",
            xlabel="solved",
            xscale="log",
            yscale="log",
        )
        legend_below(figure, [panels[0]], 3)


def slide(points: int | None) -> dict[str, float]:
    """Print quantiles of the heat over T_flash of two equally rough steels that slide, at two cut-offs.

    Return those at the highest cut-off and speed.
    """
    numbers = {}
    asks = {
        "history": "sliding",
        "slid_distance": "2 mm",
        "heat_partition": 0.5,
        "speed": [1.0, 35.0],
    }
    changes = {f"sliding.{key}": value for key, value in asks.items()}
    scene = rs.load_scene("steel-1.2GPa", changes | {"observables.temperature_distribution": True})
    numerics = rs.plan(scene)
    level = numerics.levels[numerics.slide]
    side = points or level.shape[0]
    for q_max in (0.5 * level.q_max * side / level.shape[0], level.q_max * side / level.shape[0]):
        chosen = replace(level, shape=(side, side), q_max=q_max)
        levels = [chosen if one is level else one for one in numerics.levels]
        slid = solve_slide(slide_problem(scene, replace(numerics, levels=tuple(levels)))).numbers
        for k, speed in enumerate(scene.speeds):
            flash = slid["sliding_flash_temperature"][k]
            numbers = {
                f"slide_{name}": slid[f"sliding_temperature_quantile_{name}"][k] / flash
                for name in LEVELS
            }
            quantiles = ", ".join(f"{value:.3f}" for value in numbers.values())
            print(
                f"two steels, q_c = {q_max:.3g} 1/m, {speed:g} m/s: T_flash {flash:.1f} K, {quantiles}"
            )
    return numbers


def main() -> None:
    command = Command(__file__, __doc__, TOY)
    command.add_argument(
        "--slide", action="store_true", help="slide two steels, and print their quantiles"
    )
    options = command.parse()
    slid = (
        slide(64 if options.toy else None)
        if options.slide or options.toy or options.evidence
        else {}
    )
    rows, numbers = found(options, solve=False), {}
    for name, part in PARTS.items():
        chosen = {contact: pair for contact, pair in rows.items() if part_of(contact) is part}
        if chosen:
            print(f"part {name}:")
            numbers |= {
                f"{name}_{key}": each for key, each in (table(chosen) | coverage(chosen)).items()
            }
    draw(rows, options.output / "reactions.png")
    if options.evidence:
        show_on_pages(options.output / "reactions.png")
        command_line = "python experiments/reactions.py --evidence"
        write_evidence("reactions", command_line, numbers=numbers | of_steel() | slid)


if __name__ == "__main__":
    main()
