"""T_flash of steel with a skin, or heated in depth: over thickness, depth and conductivity, by the calibrated spectrum.

    python experiments/skin.py [--toy] [-o FOLDER]

Prints the ratio of T_flash to that of the bare body, and draws it over the thickness of two skins and over the depth of
the heat at three speeds. The last figure is T_flash at 35 m/s of steel as a handbook has it (κ = 46), with a skin of
any thickness and conductivity: the measured 200 K is one of its lines. No contact is solved.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter
from script import Command

import roughsim as rs
from theory import flash, plasticity

SCENE = "steel-1.2GPa"
SPEEDS = (1.0, 10.0, 35.0)
BODY, HOT = 46.0, 30.0  # W/(m K): of steel at room temperature, and of the scene
STEEL, OXIDE = 7900 * 500.0, 3.4e6  # ρc, J/(m³ K)
SKINS = {"worked layer, κ = 21": (21.0, STEEL), "oxide, κ = 3": (3.0, OXIDE)}
TABLE = (1e-7, 3e-7, 1e-6, 3e-6, 1e-5)  # m
SHARE, MEASURED = 0.938, 200.0  # of the heat; K
COLOURS = ("#0072b2", "#009e73", "#d55e00")


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
        self.contact = {"stress_spectrum": stress, "friction_coefficient": scene.friction_coefficient(), **load}

    def flash_temperature(
        self, conductivity: float, skin: tuple[float, float, float] | None = None, heat_depth: float = 0.0
    ) -> np.ndarray:
        """Return T_flash at `SPEEDS`, K."""
        body = {"conductivity": conductivity, "diffusivity": conductivity / STEEL}
        return flash.flash_temperature(SPEEDS, skin=skin, heat_depth=heat_depth, **self.contact, **body)

    def over_thickness(self, thicknesses: np.ndarray, kappa: float, volumetric: float) -> np.ndarray:
        """Return T_flash with a skin over that of the bare body, (thicknesses, speeds)."""
        skins = [(thickness, kappa, kappa / volumetric) for thickness in thicknesses.tolist()]
        hot = np.array([self.flash_temperature(BODY, skin=skin) for skin in skins])
        return hot / self.flash_temperature(BODY)

    def over_depth(self, depths: np.ndarray) -> np.ndarray:
        """Return T_flash of a body heated in depth over that of one heated in its plane, (depths, speeds)."""
        deep = np.array([self.flash_temperature(HOT, heat_depth=depth) for depth in depths.tolist()])
        return deep / self.flash_temperature(HOT)


def print_table(steel: Steel) -> None:
    at = np.array(TABLE)
    rows = {f"{name} on {BODY:g}": steel.over_thickness(at, *skin) for name, skin in SKINS.items()}
    rows[f"heat in depth, κ = {HOT:g}"] = steel.over_depth(at)
    speeds = "/".join(f"{speed:g}" for speed in SPEEDS)
    print(f"T_flash over that of the bare body at {speeds} m/s, thickness or depth in µm")
    print(f"{'':28}" + "".join(f"{1e6 * depth:>18g}" for depth in TABLE))
    for name, ratios in rows.items():
        print(f"{name:28}" + "".join(f"{'/'.join(f'{ratio:.3f}' for ratio in row):>18}" for row in ratios))


def draw_ratios(steel: Steel, points: int) -> Figure:
    figure = Figure((5.8, 3.7), layout="constrained")  # readable at the width of a telephone
    left, right = figure.subplots(1, 2)
    depths = np.geomspace(1e-8, 3e-5, points)
    lines = []
    for (name, skin), style in zip(SKINS.items(), ("-", "--"), strict=True):
        for ratio, colour in zip(steel.over_thickness(depths, *skin).T, COLOURS, strict=True):
            left.loglog(1e6 * depths, ratio, style, color=colour)
        left.plot([], [], style, color="k", label=name)
    for speed, ratio, colour in zip(SPEEDS, steel.over_depth(depths).T, COLOURS, strict=True):
        lines += right.loglog(1e6 * depths, ratio, color=colour, label=f"{speed:g} m/s")
    left.set(xlabel="thickness of the skin (µm)", ylabel="$T_{flash}$ / bare", ylim=(0.95, 9))
    right.set(xlabel="depth of the heat (µm)", ylabel="$T_{flash}$ / heated in the plane")
    left.legend(fontsize="small", loc="upper left", handlelength=1.6, borderpad=0.3)
    figure.legend(handles=lines, loc="outside upper center", ncols=len(lines), frameon=False)
    with_plain_ticks(left.yaxis, [1, 1.5, 2, 3, 4, 5, 6, 8])
    with_plain_ticks(right.yaxis, [0.05, 0.1, 0.2, 0.5, 1])
    for axes in (left, right):
        with_plain_ticks(axes.xaxis, [0.01, 0.1, 1, 10])
        axes.grid(alpha=0.3)
    return figure


def with_plain_ticks(axis: Axis, values: list[float]) -> None:
    """Write numbers as 0.1, 1 and 10 on a logarithmic axis."""
    axis.set_major_locator(FixedLocator(values))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def draw_map(steel: Steel, points: int) -> Figure:
    thicknesses, kappas = np.geomspace(1e-8, 1e-5, points), np.geomspace(1.0, 46.0, points)
    hot = [
        [SHARE * steel.flash_temperature(BODY, skin=(d, kappa, kappa / STEEL))[-1] for d in thicknesses.tolist()]
        for kappa in kappas.tolist()
    ]
    figure = Figure((5.2, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.set(xscale="log", yscale="log", xlabel="thickness of the skin (µm)", ylabel="its conductivity (W/(m K))")
    lines = axes.contour(1e6 * thicknesses, kappas, hot, levels=[170, 250, 300, 400, 600], colors="#777")
    axes.clabel(lines, fmt="%g K")
    measured = axes.contour(1e6 * thicknesses, kappas, hot, levels=[MEASURED], colors="#d55e00", linewidths=2.0)
    axes.clabel(measured, fmt="%g K, measured")
    with_plain_ticks(axes.xaxis, [0.01, 0.1, 1, 10])
    with_plain_ticks(axes.yaxis, [1, 2, 5, 10, 20, 40])
    axes.set_title(f"$T_{{flash}}$ at {SPEEDS[-1]:g} m/s, steel with κ = {BODY:g}", fontsize="medium")
    return figure


def main() -> None:
    options = Command(__file__, __doc__).parse()
    steel = Steel()
    print_table(steel)
    bare = SHARE * steel.flash_temperature(BODY)[-1]
    print(f"bare, κ = {BODY:g}: {bare:.1f} K at {SPEEDS[-1]:g} m/s with {SHARE:g} of the heat")
    draw_ratios(steel, 7 if options.toy else 41).savefig(options.output / "skin.png", dpi=150)
    draw_map(steel, 5 if options.toy else 25).savefig(options.output / "skin_map.png", dpi=150)


if __name__ == "__main__":
    main()
