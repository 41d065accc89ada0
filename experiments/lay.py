"""A face with a lay in all directions of sliding, by the law and by simulation, and the law beside drawn faces.

    python experiments/lay.py [--toy] [-o FOLDER] [--evidence]

The steel of 1.2 GPa at 35 m/s, share .938, with γ = 1, 3 and 10: an isotropic surface on L × L, its cell called
L√γ × L/√γ. ⟨Tσ⟩/⟨σ⟩ is that of the field of temperature, from rest over half the chord of the cell. The law is of the
same waves. Below, law over simulation of the faces of lay_points.py, which are solved there.
"""

from __future__ import annotations

from math import sqrt

import figures
import lay_points
import numpy as np
from script import Command, Row, Rows, show_on_pages, write_evidence

import roughsim as rs
from roughsim.observables.moments import HeatSource
from roughsim.observables.temperatures import flash_temperature_along
from theory import lay

SCENE, SPEED, SHARE = "steel-1.2GPa", 35.0, 0.938
LAYS, ANGLES = (1.0, 3.0, 10.0), np.linspace(0.0, 90.0, 9)  # degrees from the grooves
POINTS, SIDE, MEMBERS = 1024, 4e-3, 8
GROUPS = {"low": (1.0, 3.0), "high": (3.0, 10.0), "highest": (10.0, 20.0)}  # lays


class Steel:
    """The steel with the waves of a grid."""

    def __init__(self, points: int):
        scene = rs.load_scene(SCENE)
        self.square = rs.Grid((points, points), (SIDE, SIDE))
        self.spectrum = scene.spectrum.truncated(q_max=self.square.nyquist / 2)
        self.modulus, self.hardness = scene.effective_modulus, scene.penetration_hardness
        self.pressure, self.friction = scene.sliding.nominal_pressure, 0.11
        body = scene.conduction()
        self.body = {"conductivity": body.conductivity, "diffusivity": body.diffusivity}

    def simulated(self, gamma: float, seed: int) -> list[float]:
        """Return T_flash at `ANGLES` of one member, K."""
        rng = np.random.default_rng([35, seed])
        heights = rs.synthesize(self.spectrum, self.square, rng, amplitudes="fixed")
        grid = rs.Grid(self.square.shape, (SIDE * sqrt(gamma), SIDE / sqrt(gamma)))
        solid = rs.Solid(self.modulus, self.hardness)
        contact = rs.solve_contact(heights, grid, solid, nominal_pressure=self.pressure)
        source = HeatSource((SPEED,), self.friction, **self.body, heat_partition=SHARE)
        return [
            float(flash_temperature_along(contact.pressure, grid, source, angle)[0])
            for angle in np.radians(ANGLES)
        ]

    def law(self, gamma: float, angles: np.ndarray) -> np.ndarray:
        """Return T_flash at angles, degrees, by the law, K."""
        stress = lay.stress_of_lay(
            self.spectrum,
            gamma,
            effective_modulus=self.modulus,
            nominal_pressure=self.pressure,
            penetration_hardness=self.hardness,
        )
        load = {"nominal_pressure": self.pressure, "friction_coefficient": self.friction}
        return SHARE * np.asarray(
            lay.flash_temperature(SPEED, np.radians(angles), stress, **load, **self.body)
        )


def simulations(steel: Steel, gamma: float, members: int) -> Row:
    """Return means of T_flash at `ANGLES` over members, K, and their standard errors."""
    rows = np.array([steel.simulated(gamma, seed) for seed in range(members)])
    errors = rows.std(axis=0, ddof=1) / sqrt(members)
    names = [f"{angle:g}" for angle in ANGLES]
    row: Row = dict(zip(names, rows.mean(axis=0).tolist(), strict=True))
    return row | {f"{name} error": float(e) for name, e in zip(names, errors, strict=True)}


def judged(shown: tuple[str, ...]) -> tuple[dict[str, float], list[tuple[float, float, str]]]:
    """Return numbers of law over simulation − 1 by list and lay, %, and all points: γ, ratio, kind of contact."""
    rows = Rows(lay_points.FOLDER / "lay_solved.json", resume=True)
    found: dict[str, list[float]] = {}
    points = []
    for name in shown:
        for k, face in enumerate(lay_points.points(name)):
            off = lay_points.compared(face, rows[name][str(k)], face.stress())["raw"].ravel()
            group = next(key for key, (low, high) in GROUPS.items() if low < face.lay <= high)
            for key in (name, f"{name}_{group}"):
                found.setdefault(key, []).extend(off.tolist())
            kind = "elastic" if face.hardness is None else "yielding"
            points += [(face.lay, float(np.exp(each)), kind) for each in off]
    numbers: dict[str, float] = {}
    for key, values in found.items():
        off = 100 * np.expm1(values)
        numbers |= {key: len(off), f"{key}_rms": float(np.sqrt(np.mean(off**2)))}
        numbers[f"{key}_worst"] = float(off[np.abs(off).argmax()])
        numbers[f"{key}_most"] = float(np.percentile(np.abs(off), 95))
    return numbers, points


def main() -> None:
    options = Command(__file__, __doc__, "one member on 128² points, the faces that tuned").parse()
    points, members = (128, 2) if options.toy else (POINTS, MEMBERS)
    steel, rows = Steel(points), Rows(options.output / f"lay-{points}.json", resume=True)
    curves, numbers = {}, {}
    fine = np.linspace(0.0, 90.0, 13 if options.toy else 46)
    table = [["γ", *(f"{angle:g}°" for angle in ANGLES[::2])]]
    for gamma in LAYS:
        row = rows.once("steel", f"{gamma:g}", lambda g=gamma: simulations(steel, g, members))
        mean, error = (
            np.array([float(row[f"{angle:g}{end}"]) for angle in ANGLES]) for end in ("", " error")
        )
        law = steel.law(gamma, ANGLES)
        curves[gamma] = (fine, steel.law(gamma, fine), ANGLES, mean)
        table.append(
            [f"{gamma:g}", *(f"{a:.0f}, {b:.0f}" for a, b in zip(law[::2], mean[::2], strict=True))]
        )
        numbers[f"steel_{gamma:g}"] = float(np.abs(100 * (law / mean - 1)).max())
        numbers[f"steel_{gamma:g}_error"] = float((100 * error / mean).max())
    print("law, simulation, K", *("  ".join(line) for line in table), sep="\n")
    found, ratios = judged(("tuned",) if options.toy else tuple(lay_points.LISTS))
    numbers |= found
    print(*(f"{name}: {value:.3g}" for name, value in numbers.items()), sep="\n")
    figures.lay(curves, ratios, options.output / "lay.png")
    if options.evidence:
        command = "python experiments/lay.py --evidence"
        write_evidence("lay", command, tables={"steel": table}, numbers=numbers)
        show_on_pages(options.output / "lay.png")


if __name__ == "__main__":
    main()
