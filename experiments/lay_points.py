"""Faces with a lay, drawn by chance before the law of theory/lay.py had its form, to tune it and to judge it.

    python experiments/lay_points.py [--draw] [--solve LIST] [--toy] [-o FOLDER]

The lists are in reference/lay_points.json and were committed before any was solved; `--draw` writes them anew. "tuned"
chose the form of the law, "judged" was solved when it was committed, "beyond" later. A third of a list is elastic. γ in
1.5 … 10, beyond in 10 … 20, H in 0.3 … 1, A/A₀ in .03 … .9 by Persson's theory,
σ_P/E*h′ in .03 … 2, C(q) up to 6 … 32 q_min with a plateau of up to 4 q_min; faces outside the range of the calibrated
law are drawn again. `--solve` adds to reference/lay_solved.json: for four members on 512² points, in cells of four
longest waves, ⟨Tσ⟩/⟨σ⟩ from rest over half the chord at two speeds in three directions, and the areas. Beside them its
twin, of the same waves without a lay and with the modulus E_eff of the law: pixel and cell err alike in both.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from math import inf, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.special import erfinv
from script import Command, Rows

import roughsim as rs
from roughsim.observables.moments import HeatSource
from roughsim.observables.temperatures import flash_temperature_along
from theory import lay
from theory.persson import pressure_correlation

FOLDER = Path(__file__).parent / "reference"
# seed, number of faces, and lays
LISTS = {
    "tuned": (6101, 12, (1.5, 10.0)),
    "judged": (6102, 30, (1.5, 10.0)),
    "beyond": (6103, 12, (10.0, 20.0)),
}
POINTS, WAVES, MEMBERS = 512, 4, 4
MODULUS, BODY = 1.1e11, {"conductivity": 30.0, "diffusivity": 7.6e-6}
DIRECTIONS = (0.0, pi / 4, pi / 2)
FRICTION = 0.1


def without_lay(face: Any) -> rs.SelfAffineSpectrum:
    """Return C(q) of a face by its slope, exponents and ends."""
    ends = {"q_min": face.q_min, "q_max": face.band * face.q_min}
    return rs.SelfAffineSpectrum.from_rms_slope(
        face.slope,
        hurst=face.hurst,
        q_roll_off=face.plateau * face.q_min,
        roll_off_exponent=getattr(face, "exponent", 0.0),
        **ends,
    )


@dataclass(frozen=True)
class Face:
    """A face with a lay under load; SI."""

    lay: float
    hurst: float
    q_min: float
    plateau: float  # q_r/q_min
    band: float  # q_max/q_min
    slope: float  # h′ without the lay
    pressure: float
    hardness: float | None
    speeds: tuple[float, float]

    @property
    def spectrum(self) -> rs.SelfAffineSpectrum:
        """C(q) without the lay."""
        return without_lay(self)

    def stress(self) -> lay.LayStress:
        """Return the stress by the law; ValueError outside its range."""
        return lay.stress_of_lay(
            self.spectrum,
            self.lay,
            effective_modulus=MODULUS,
            nominal_pressure=self.pressure,
            penetration_hardness=self.hardness,
        )

    def law(self, stress: lay.LayStress) -> np.ndarray:
        """Return T_flash by the law, (directions, speeds), steady, K."""
        heat = {"nominal_pressure": self.pressure, "friction_coefficient": FRICTION}
        angles = np.array(DIRECTIONS)[:, None]
        return np.asarray(lay.flash_temperature(self.speeds, angles, stress, **heat, **BODY))


def draw(rng: np.random.Generator, lays: tuple[float, float], *, elastic: bool) -> Face:
    """Return a face, which may lie outside the range of the law."""

    def log(low: float, high: float) -> float:
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}")

    gamma, area, slope = log(*lays), log(0.03, 0.9), log(0.02, 0.3)
    light, full = (sqrt(gamma) + 1 / sqrt(gamma)) / 2, sqrt((gamma + 1 / gamma) / 2)
    steep = MODULUS * slope * (light + (full - light) * area)
    pressure, hardness = steep / sqrt(2) * float(erfinv(area)), None
    if not elastic:
        hardness = float(f"{steep * log(0.03, 2.0):.4g}")
        pressure = 1 / (1 / pressure + 1 / (area * hardness))
    return Face(
        lay=gamma,
        hurst=round(rng.uniform(0.3, 1.0), 3),
        q_min=log(5e3, 5e4),
        plateau=log(1.0, 4.0),
        band=log(6.0, 21.0 if elastic else 32.0),
        slope=slope,
        pressure=float(f"{pressure:.4g}"),
        hardness=hardness,
        speeds=(log(1.0, 8.0), log(8.0, 60.0)),
    )


def drawn(name: str) -> list[Face]:
    """Return the faces of a list, of which each third one is elastic."""
    seed, count, lays = LISTS[name]
    rng, faces = np.random.default_rng(seed), []
    while len(faces) < count:
        face = draw(rng, lays, elastic=len(faces) % 3 == 0)
        try:
            face.stress()
        except ValueError:
            continue
        faces.append(face)
    return faces


def points(name: str) -> list[Face]:
    """Return the faces of a list as they were committed."""
    rows = json.loads((FOLDER / "lay_points.json").read_text("utf-8"))[name]
    return [Face(**row | {"speeds": tuple(row["speeds"])}) for row in rows]


def member(face: Face, gamma: float, modulus: float, seed: int, points: int) -> dict[str, Any]:
    """Return T_flash, (directions, speeds), and the areas of one member with a lay γ."""
    side = WAVES * 2 * pi / face.q_min
    square = rs.Grid((points, points), (side, side))
    cut = face.spectrum.truncated(q_max=min(face.band * face.q_min, square.nyquist / 2))
    heights = rs.synthesize(cut, square, np.random.default_rng([61, seed]), amplitudes="fixed")
    grid = rs.Grid(square.shape, (side * sqrt(gamma), side / sqrt(gamma)))
    hardness = face.hardness or inf
    contact = rs.solve_contact(
        heights, grid, rs.Solid(modulus, hardness), nominal_pressure=face.pressure
    )
    source = HeatSource(face.speeds, FRICTION, **BODY)
    pressure = contact.pressure
    found = [flash_temperature_along(pressure, grid, source, angle) for angle in DIRECTIONS]
    yielded = float(np.mean(pressure >= hardness * (1 - 1e-9)))
    areas = {"contact": float(np.mean(pressure > 0)), "yielded": yielded}
    return {"flash": np.array(found), "variance": float(pressure.var())} | areas


def solve(face: Face, members: int, points: int) -> dict[str, Any]:
    """Return the means over members of a face and of its twin, and the standard errors of ln T_flash."""
    twin = face.stress().stress_spectrum.effective_modulus
    row: dict[str, Any] = {}
    for name, gamma, modulus in (("face", face.lay, MODULUS), ("twin", 1.0, twin)):
        all_of = [member(face, gamma, modulus, seed, points) for seed in range(members)]
        logs = np.log([each["flash"] for each in all_of])
        row[name] = {
            "flash": np.exp(logs.mean(axis=0)).tolist(),
            "error": (logs.std(axis=0, ddof=1) / sqrt(members)).tolist(),
        }
        for key in ("contact", "yielded", "variance"):
            row[name][key] = float(np.mean([each[key] for each in all_of]))
        row[name]["modulus"] = modulus
    return row


def compared(face: Face, row: dict[str, Any], stress: lay.LayStress) -> dict[str, Any]:
    """Return ln of law over simulation, (directions, speeds), as it is and beside that of the twin."""
    modulus = row["twin"]["modulus"]
    twin = lay.LayStress(replace(stress.stress_spectrum, effective_modulus=modulus), 1.0, modulus)
    raw = np.log(face.law(stress) / row["face"]["flash"])
    plain = np.log(face.law(twin) / np.mean(row["twin"]["flash"], axis=0))
    return {"raw": raw, "lay": raw - plain, "twin": plain[0]}


def line(k: int, face: Face, row: dict[str, Any], stress: lay.LayStress) -> str:
    """Return a line of the table, in percent."""
    off = compared(face, row, stress)
    law, one = stress.stress_spectrum, row["face"]

    def text(values: Any) -> str:
        return " ".join(f"{100 * value:+5.1f}" for value in np.ravel(np.transpose(values)))

    areas = f"{one['contact']:.3f} {one['yielded'] / one['contact']:.2f}"
    mine = f"{law.contact_fraction:.3f} {law.plastic_fraction / law.contact_fraction:.2f}"
    variance = float(pressure_correlation(0.0, stress_spectrum=law)) / one["variance"]
    return (
        f"{k:2} γ {face.lay:5.2f} H {face.hurst:.2f} A, A_pl/A {areas} law {mine} "
        f"g(0) {variance:.2f} | {text(off['raw'])} | {text(off['lay'])} | {text(off['twin'])}"
    )


def main() -> None:
    command = Command(__file__, __doc__, "two faces, two members on 64² points")
    command.add_argument("--draw", action="store_true", help="write the lists anew")
    command.add_argument("--solve", choices=list(LISTS), help="solve what is not there yet")
    options = command.parse()
    if options.draw:
        lists = {name: [asdict(face) for face in drawn(name)] for name in LISTS}
        (FOLDER / "lay_points.json").write_text(json.dumps(lists, indent=1) + "\n")
    path = options.output / "toy.json" if options.toy else FOLDER / "lay_solved.json"
    rows = Rows(path, resume=True)
    names = ["tuned"] if options.toy else list(LISTS)
    figure = Figure(figsize=(5.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for name in names:
        for k, face in enumerate(points(name)[: 2 if options.toy else None]):
            if options.toy or options.solve == name:
                size = (2, 64) if options.toy else (MEMBERS, POINTS)
                row: Any = rows.once(name, str(k), lambda face=face, size=size: solve(face, *size))
            elif str(k) in rows[name]:
                row = rows[name][str(k)]
            else:
                continue
            stress = face.stress()
            print(name, line(k, face, row, stress), flush=True)
            axes.plot([face.lay] * 6, np.exp(compared(face, row, stress)["raw"]).ravel(), "k.")
    axes.set(xscale="log", xlabel="lay", ylabel=r"$T_\mathrm{flash}$, law / simulation")
    figure.savefig(options.output / "lay_points.png", dpi=130)


if __name__ == "__main__":
    main()
