"""T_flash of steel with a skin, or heated in depth: over thickness, depth and conductivity, by the calibrated spectrum.

    python experiments/skin.py [--slides] [--toy] [-o FOLDER] [--evidence]

Prints the ratio of T_flash to that of the bare body, and draws it over the thickness of two skins and over the depth of
the heat at three speeds. The last figure is T_flash at 35 m/s of steel as a handbook has it (κ = 46), with a skin of
any thickness and conductivity: the measured 200 K is one of its lines. No contact is solved but for --evidence, which
runs the study of docs/skin.md, too: a minute.

`--slides` slides two such faces with skins over one another, in a cell of 4 mm with 256² points and waves down to
63 µm, and prints T_flash beside `theory.two_bodies`, means over the last half of 4 mm: two minutes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from figures.style import BLUE, GREEN, ORANGE, legend_below, new_figure
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, NullFormatter
from scipy.optimize import brentq
from script import Command, show_on_pages, write_evidence

import roughsim as rs
from theory import flash, plasticity, two_bodies

SCENE = "steel-1.2GPa"
SPEEDS = (1.0, 10.0, 35.0)
BODY, HOT = 46.0, 30.0  # W/(m K): of steel at room temperature, and of the scene
STEEL, OXIDE = 7900 * 500.0, 3.4e6  # ρc, J/(m³ K)
OXIDE_CONDUCTIVITY = 3.0  # W/(m K)
SKINS = {"worked layer, κ = 21": (21.0, STEEL), "oxide, κ = 3": (OXIDE_CONDUCTIVITY, OXIDE)}
TABLE = (1e-7, 3e-7, 1e-6, 3e-6, 1e-5)  # m
SHARE, MEASURED = 0.938, 200.0  # of the heat; K
CELL, CUT_OFF, SLID, MEMBERS = 4e-3, 1e5, (1.0, 35.0), 2  # m, rad/m, m/s: of slides
# the study of docs/skin.md: m, W/(m K)
VARIED = {
    "body.skin.thickness": {"logspace": ["0.1 um", "10 um", 5]},
    "body.skin.conductivity": ["3 W/(m K)", "21 W/(m K)"],
}
GROWTH = {"junction_9": (9.0, 0.11), "junction_25": (25.0, 0.11)}  # α, μ
GROWTH |= {"junction_9_rough": (9.0, 0.3), "junction_25_rough": (25.0, 0.3)}
COLOURS = (BLUE, GREEN, ORANGE)


class Steel:
    """T_flash of the contact of the scene at any speeds, with all the heat in one body."""

    def __init__(self) -> None:
        scene = rs.load_scene(SCENE)
        load = {"nominal_pressure": scene.sliding.nominal_pressure}
        stress = plasticity.stress_spectrum(
            scene.spectrum,
            effective_modulus=scene.effective_modulus,
            penetration_hardness=scene.penetration_hardness,
            **load,
        )
        self.contact = {
            "stress_spectrum": stress,
            "friction_coefficient": scene.friction_coefficient(),
            **load,
        }

    def flash_temperature(
        self,
        conductivity: float,
        skin: tuple[float, float, float] | None = None,
        heat_depth: float = 0.0,
    ) -> np.ndarray:
        """Return T_flash at `SPEEDS`, K."""
        body = {"conductivity": conductivity, "diffusivity": conductivity / STEEL}
        return flash.flash_temperature(
            SPEEDS, skin=skin, heat_depth=heat_depth, **self.contact, **body
        )

    def over_thickness(
        self, thicknesses: np.ndarray, kappa: float, volumetric: float
    ) -> np.ndarray:
        """Return T_flash with a skin over that of the bare body, (thicknesses, speeds)."""
        skins = [(thickness, kappa, kappa / volumetric) for thickness in thicknesses.tolist()]
        hot = np.array([self.flash_temperature(BODY, skin=skin) for skin in skins])
        return hot / self.flash_temperature(BODY)

    def over_depth(self, depths: np.ndarray) -> np.ndarray:
        """Return T_flash of a body heated in depth over that of one heated in its plane, (depths, speeds)."""
        deep = np.array(
            [self.flash_temperature(HOT, heat_depth=depth) for depth in depths.tolist()]
        )
        return deep / self.flash_temperature(HOT)


def print_table(steel: Steel) -> list[list[str]]:
    """Print T_flash over that of the bare body; return it at the first and the last speed, as a table of cells."""
    at = np.array(TABLE)
    rows = {f"{name} on {BODY:g}": steel.over_thickness(at, *skin) for name, skin in SKINS.items()}
    rows[f"heat in depth, κ = {HOT:g}"] = steel.over_depth(at)
    speeds = "/".join(f"{speed:g}" for speed in SPEEDS)
    print(f"T_flash over that of the bare body at {speeds} m/s, thickness or depth in µm")
    print(f"{'':28}" + "".join(f"{1e6 * depth:>18g}" for depth in TABLE))
    for name, ratios in rows.items():
        print(
            f"{name:28}"
            + "".join(f"{'/'.join(f'{ratio:.3f}' for ratio in row):>18}" for row in ratios)
        )
    heads = ["", *(f"{1e6 * depth:g} µm" for depth in TABLE)]
    return [
        heads,
        *(
            [name, *(f"{row[0]:.2f}/{row[-1]:.2f}" for row in ratios)]
            for name, ratios in rows.items()
        ),
    ]


def quoted(steel: Steel) -> dict[str, float]:
    """Return other numbers of docs/skin.md, of T_flash at the last speed: K, W/(m K), or % of change."""
    bare = steel.flash_temperature(BODY)[-1]

    def of_measured(thickness: float) -> float:
        """Return κ of a skin of this thickness under which T_flash is the measured one."""

        def excess(kappa: float) -> float:
            skin = (thickness, kappa, kappa / STEEL)
            return float(SHARE * steel.flash_temperature(BODY, skin=skin)[-1] - MEASURED)

        return float(brentq(excess, 0.1, BODY))

    kappa, volumetric = SKINS["oxide, κ = 3"]
    thin = steel.over_thickness(np.array([1e-8]), kappa, volumetric)[0, -1]
    found = {"bare": SHARE * bare, "oxide_10nm": 100 * (thin - 1)}
    found["effusivities"] = np.sqrt(BODY * STEEL / (kappa * volumetric))
    found |= {
        f"kappa_{name}": of_measured(d)
        for name, d in (("10nm", 1e-8), ("100nm", 1e-7), ("thick", 1e-4))
    }
    scene = rs.load_scene(SCENE)
    without = flash_of_law(scene)
    for name, (growth, friction) in GROWTH.items():
        changed = rs.load_scene(
            SCENE, {"sliding.junction_growth": growth, "sliding.friction_coefficient": friction}
        )
        found[name] = 100 * (
            flash_of_law(changed) / without * scene.friction_coefficient() / friction - 1
        )
    return found


def flash_of_law(scene: rs.Scene) -> float:
    """Return T_flash at the last speed by the law for contact that yields, all heat in the body of κ = `HOT`, K."""
    load = {"nominal_pressure": scene.sliding.nominal_pressure}
    stress = plasticity.stress_spectrum(
        scene.spectrum,
        effective_modulus=scene.effective_modulus,
        penetration_hardness=scene.penetration_hardness,
        **load,
    )
    body = {"conductivity": HOT, "diffusivity": HOT / STEEL}
    contact = {
        "stress_spectrum": stress,
        "friction_coefficient": scene.friction_coefficient(),
    } | load
    return float(flash.flash_temperature(SPEEDS[-1], **contact, **body))


def of_study(folder: Path) -> dict[str, float]:
    """Run the study of docs/skin.md; return T_flash of capped contact at the highest speed, and the law over it."""
    study = rs.study(SCENE, vary=VARIED, folder=folder, target_error=0.02)
    found: dict[str, float] = {}
    rows = list(study.rows("flash_temperature"))
    place = ("point", "speed")
    laws = {
        tuple(row[key] for key in place): row["value"]
        for row in rows
        if row["column"] == "calibrated"
    }
    capped = [row for row in rows if row["column"] == "capped"]
    ratios = [laws[tuple(row[key] for key in place)] / row["value"] for row in capped]
    found |= {"law_least": min(ratios), "law_most": max(ratios)}
    found["error_most"] = 100 * max(row["total_error"] / row["value"] for row in capped)
    fastest = max(row["speed"] for row in capped)
    oxides = [
        row
        for row in capped
        if row["speed"] == fastest and row["conductivity"] == OXIDE_CONDUCTIVITY
    ]
    for name, row in (("thin", oxides[0]), ("thick", oxides[-1])):
        found |= {f"{name}_flash": row["value"], f"{name}_error": row["total_error"]}
    return found


def slide_rows(points: int) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield for each skin on both bodies T_flash of slides, its standard error, and T_flash in theory, K, (speeds,)."""
    scene, grid = rs.load_scene(SCENE), rs.Grid((points, points), (CELL, CELL))
    q_max = CUT_OFF * points / 256  # 4 points in the shortest wave
    face, both = scene.faces[0].truncated(q_max=q_max), scene.spectrum.truncated(q_max=q_max)
    hardness = scene.penetration_hardness
    solid = rs.Solid(scene.effective_modulus, hardness)
    load = {
        "nominal_pressure": scene.sliding.nominal_pressure,
        "friction_coefficient": scene.friction_coefficient(),
    }
    body = {"conductivity": HOT, "diffusivity": HOT / STEEL}
    oxide, worked = (1e-6, 3.0, 3.0 / OXIDE), (1e-5, HOT / 2, HOT / 2 / STEEL)
    for name, skin in (("none", None), ("oxide, 1 µm", oxide), ("half the κ, 10 µm", worked)):
        hot = []
        for member in range(MEMBERS):
            still, riding = (
                rs.synthesize(face, grid, np.random.default_rng([7, member, k])) for k in range(2)
            )
            layered = rs.Body(**body, skin=skin)
            slid = rs.slide(
                still,
                grid,
                solid,
                speed=SLID,
                moving=layered,
                resting=layered,
                counter_heights=riding,
                slid_distance=CELL,
                **load,
            )
            hot.append(slid.flash_temperature[:, slid.slid_distance > CELL / 2].mean(axis=1))
        late = np.linspace(0.5, 1.0, 9)[:, None] * CELL
        theory = two_bodies.sliding_temperatures(
            SLID,
            both,
            effective_modulus=scene.effective_modulus,
            penetration_hardness=hardness,
            skin=skin,
            resting_skin=skin,
            slid_distance=late,
            **body,
            **load,
        )
        error = np.std(hot, axis=0, ddof=1) / np.sqrt(MEMBERS)
        yield name, np.mean(hot, axis=0), error, theory.flash_temperature.mean(axis=0)


def print_slides(points: int) -> None:
    print(
        f"two sliding faces at {SLID[0]:g} and {SLID[1]:g} m/s: T_flash of slides, K, and of the theory over it"
    )
    for name, hot, error, theory in slide_rows(points):
        cells = (
            f"{t:8.1f} ± {e:.1f}, {p / t:.3f}" for t, e, p in zip(hot, error, theory, strict=True)
        )
        print(f"{name:20}" + "   ".join(cells), flush=True)


def draw_ratios(steel: Steel, points: int, path: Path) -> None:
    with new_figure(path, 3.6) as figure:
        left, right = figure.subplots(1, 2)
        depths = np.geomspace(1e-8, 3e-5, points)
        for speed, ratio, colour in zip(SPEEDS, steel.over_depth(depths).T, COLOURS, strict=True):
            right.loglog(1e6 * depths, ratio, color=colour, label=f"{speed:g} m/s")
        for (name, skin), style in zip(SKINS.items(), ("-", "--"), strict=True):
            for ratio, colour in zip(steel.over_thickness(depths, *skin).T, COLOURS, strict=True):
                left.loglog(1e6 * depths, ratio, style, color=colour)
            right.plot([], [], style, color="0.4", label=f"{name} W/(m K)")
        left.set(
            title="skin",
            xlabel="thickness of the skin (µm)",
            ylabel=r"$T_\mathrm{flash}$ / bare",
            ylim=(0.95, 9),
        )
        right.set(
            title="heat in depth",
            xlabel="depth of the heat (µm)",
            ylabel=r"$T_\mathrm{flash}$ / heated in the plane",
        )
        with_plain_ticks(left.yaxis, [1, 1.5, 2, 3, 4, 5, 6, 8])
        with_plain_ticks(right.yaxis, [0.05, 0.1, 0.2, 0.5, 1])
        for axes in (left, right):
            with_plain_ticks(axes.xaxis, [0.01, 0.1, 1, 10])
        legend_below(figure, [right], 2)


def with_plain_ticks(axis: Axis, values: list[float]) -> None:
    """Write numbers as 0.1, 1 and 10 on a logarithmic axis."""
    axis.set_major_locator(FixedLocator(values))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def draw_map(steel: Steel, points: int, path: Path) -> None:
    thicknesses, kappas = np.geomspace(1e-8, 1e-5, points), np.geomspace(1.0, 46.0, points)
    hot = [
        [
            SHARE * steel.flash_temperature(BODY, skin=(d, kappa, kappa / STEEL))[-1]
            for d in thicknesses.tolist()
        ]
        for kappa in kappas.tolist()
    ]
    with new_figure(path, 3.6) as figure:
        axes = figure.subplots()
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="thickness of the skin (µm)",
            ylabel="its conductivity (W/(m K))",
        )
        lines = axes.contour(
            1e6 * thicknesses, kappas, hot, levels=[170, 250, 300, 400, 600], colors="0.4"
        )
        axes.clabel(lines, fmt="%g K", fontsize=8.5)
        measured = axes.contour(
            1e6 * thicknesses, kappas, hot, levels=[MEASURED], colors=ORANGE, linewidths=1.8
        )
        axes.clabel(measured, fmt="%g K, measured", fontsize=8.5)
        with_plain_ticks(axes.xaxis, [0.01, 0.1, 1, 10])
        with_plain_ticks(axes.yaxis, [1, 2, 5, 10, 20, 40])
        axes.set_title(
            rf"$T_\mathrm{{flash}}$ at {SPEEDS[-1]:g} m/s, steel with $\kappa$ = {BODY:g} W/(m K)"
        )


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument("--slides", action="store_true", help="slide two faces with skins, too")
    options = command.parse()
    steel = Steel()
    table, numbers = print_table(steel), quoted(steel)
    print(
        f"bare, κ = {BODY:g}: {numbers['bare']:.1f} K at {SPEEDS[-1]:g} m/s with {SHARE:g} of the heat"
    )
    if options.slides:
        print_slides(64 if options.toy else 256)
    draw_ratios(steel, 7 if options.toy else 41, options.output / "skin.png")
    draw_map(steel, 5 if options.toy else 25, options.output / "skin_map.png")
    if options.evidence:
        numbers |= of_study(options.output / "study")
        show_on_pages(options.output / "skin.png", options.output / "skin_map.png")
        write_evidence(
            "skin",
            "python experiments/skin.py --evidence",
            tables={"sizes": table},
            numbers=numbers,
        )


if __name__ == "__main__":
    main()
