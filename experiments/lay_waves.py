"""Faces whose lay differs from wave to wave, or is crossed: the law of theory/lay.py beside simulations.

    python experiments/lay_waves.py [--draw] [--solve LIST] [--toy] [-o FOLDER]

The lists are in reference/lay_waves.json and were committed before any was solved; `--draw` writes them anew. "tuned"
chose the form, "judged" was solved when it was committed. "wide" has, as scans have, four octaves or more of longer
waves that count for little: C ~ q^(−0 … −1.3) below q_r. A third has one direction and a γ of its own in each octave,
1 … 10, a third also a direction of its own, a third two crossed lays; each second face is elastic. `--solve` adds to
reference/lay_waves_solved.json ⟨Tσ⟩/⟨σ⟩ over half the cell from rest, in four directions, of members on 256² points in
cells of four longest waves (wide: 1024², one), and of their twins of the same C(q) without directions: pixel and cell
err alike in both.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from math import inf, log, pi, radians, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from lay_points import BODY, FRICTION, MODULUS, without_lay
from scipy.special import erfinv
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim.observables.moments import HeatSource
from roughsim.observables.temperatures import flash_temperature_along
from roughsim.surface.directions import DirectedSpectrum, Directions, with_lays
from theory import lay

FOLDER = Path(__file__).parent / "reference"
LISTS = {"tuned": (6111, 8), "judged": (6112, 18), "wide": (6113, 9)}  # seed, number of faces
SIZES = {"wide": (1024, 1, 2)}  # points per side, longest waves, members; of the others:
SIZE = 256, 4, 4
DIRECTIONS = (0.0, pi / 4, pi / 2, 3 * pi / 4)
KINDS = ("octaves", "turned", "crossed")
ANGLES = 90


@dataclass(frozen=True)
class Face:
    """A face under load; SI."""

    kind: str
    lays: tuple[
        tuple[float, float], ...
    ]  # γ and degrees of each octave from q_min on, or of two crossed lays
    hurst: float
    q_min: float
    plateau: float  # q_r/q_min
    band: float  # q_max/q_min
    slope: float  # h′
    pressure: float
    hardness: float | None
    speeds: tuple[float, float]
    exponent: float = 0.0  # of C(q) below q_r

    @property
    def mean(self) -> rs.SelfAffineSpectrum:
        """C(q), the mean over directions; of crossed lays of each before it is stretched."""
        return without_lay(self)

    @property
    def spectrum(self) -> DirectedSpectrum:
        """C(q⃗)."""
        if self.kind == "crossed":
            half = self.mean.scaled(0.5)
            terms = [(half, gamma, radians(angle)) for gamma, angle in self.lays]
            whole = with_lays(terms).truncated(q_max=self.band * self.q_min)
            return whole.scaled((self.slope / whole.rms_slope) ** 2)
        angles = np.arange(ANGLES) * (pi / ANGLES)
        rows = [
            (np.cosh(log(g)) + np.sinh(log(g)) * np.cos(2 * (angles - radians(a))))
            ** -(1 + self.hurst)
            for g, a in self.lays
        ]
        q = self.q_min * 2.0 ** (0.5 + np.arange(len(rows)))
        return DirectedSpectrum(
            self.mean, Directions(tuple(q.tolist()), tuple(tuple(row.tolist()) for row in rows))
        )


def draw(rng: np.random.Generator, kind: str, *, elastic: bool) -> Face:
    """Return a face, which may lie outside the range of the law."""

    def logarithmic(low: float, high: float) -> float:
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}")

    area, slope, band = logarithmic(0.03, 0.9), logarithmic(0.02, 0.3), logarithmic(6.0, 16.0)
    steep = MODULUS * slope
    pressure, hardness = steep / sqrt(2) * float(erfinv(area)), None
    if not elastic:
        hardness = float(f"{steep * logarithmic(0.03, 2.0):.4g}")
        pressure = 1 / (1 / pressure + 1 / (area * hardness))
    mean, spread = rng.uniform(0.0, 180.0), 40.0 if kind == "turned" else 0.0
    if kind == "crossed":
        turn = rng.uniform(40.0, 90.0)
        lays = [(logarithmic(1.5, 10.0), mean), (logarithmic(1.5, 10.0), mean + turn)]
    else:
        octaves = 1 + int(np.log2(band))
        lays = [(logarithmic(1.0, 10.0), mean + rng.normal(0.0, spread)) for _ in range(octaves)]
    return Face(
        kind=kind,
        lays=tuple((gamma, round(angle % 180.0, 1)) for gamma, angle in lays),
        hurst=round(rng.uniform(0.3, 1.0), 3),
        q_min=logarithmic(5e3, 5e4),
        plateau=logarithmic(1.0, 3.0),
        band=band,
        slope=slope,
        pressure=float(f"{pressure:.4g}"),
        hardness=hardness,
        speeds=(logarithmic(1.0, 8.0), logarithmic(8.0, 60.0)),
    )


def wider(rng: np.random.Generator, face: Face) -> Face:
    """Return a face with four octaves or more of longer waves, which fit into a cell of 1024² points."""
    factor = float(np.exp(rng.uniform(log(16.0), log(250.0 / face.band))))
    octaves = 0 if face.kind == "crossed" else round(np.log2(factor))
    longer = [
        (round(rng.uniform(1.0, 8.0), 2), round(rng.uniform(0, 180), 1)) for _ in range(octaves)
    ]
    return replace(
        face,
        lays=(*longer, *face.lays),
        q_min=face.q_min / factor,
        plateau=face.plateau * factor,
        band=face.band * factor,
        exponent=round(rng.uniform(0.0, 1.3), 2),
    )


def isotropic(face: Face) -> Any:
    """Return the stress of its C(q) without directions, by the law; ValueError outside its range."""
    return lay.stress_of_lay(
        face.spectrum.whole,
        1.0,
        effective_modulus=MODULUS,
        nominal_pressure=face.pressure,
        penetration_hardness=face.hardness,
    )


def drawn(name: str) -> list[Face]:
    """Return the faces of a list."""
    seed, count = LISTS[name]
    rng, faces = np.random.default_rng(seed), []
    while len(faces) < count:
        number = len(faces)
        face = draw(rng, KINDS[number % 3], elastic=number % 2 == 0)
        if name == "wide":
            face = wider(rng, face)
        try:
            isotropic(face)
        except ValueError:
            continue
        faces.append(face)
    return faces


def points(name: str) -> list[Face]:
    """Return the faces of a list as they were committed."""
    rows = json.loads((FOLDER / "lay_waves.json").read_text("utf-8"))[name]
    return [
        Face(**row | {"lays": tuple(map(tuple, row["lays"])), "speeds": tuple(row["speeds"])})
        for row in rows
    ]


def member(face: Face, spectrum: Any, seed: int, size: tuple[int, int]) -> dict[str, Any]:
    """Return T_flash, (directions, speeds), and the areas of one member."""
    count, waves = size
    side = waves * 2 * pi / face.q_min
    grid = rs.Grid((count, count), (side, side))
    cut = spectrum.truncated(q_max=min(face.band * face.q_min, grid.nyquist / 2))
    heights = rs.synthesize(cut, grid, np.random.default_rng([61, seed]), amplitudes="fixed")
    solid = rs.Solid(MODULUS, face.hardness or inf)
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=face.pressure)
    source = HeatSource(face.speeds, FRICTION, **BODY)
    found = [
        flash_temperature_along(contact.pressure, grid, source, angle, side / 2)
        for angle in DIRECTIONS
    ]
    areas = {"contact": contact.contact_fraction, "yielded": contact.plastic_fraction}
    return {"flash": np.array(found)} | areas


def solve(face: Face, *size: int) -> dict[str, Any]:
    """Return the means over members of a face and of its twin, and the standard errors of ln T_flash."""
    row: dict[str, Any] = {}
    *cell, members = size
    for name, spectrum in (("face", face.spectrum), ("twin", face.spectrum.whole)):
        all_of = [member(face, spectrum, seed, tuple(cell)) for seed in range(members)]
        logs = np.log([each["flash"] for each in all_of])
        row[name] = {
            "flash": np.exp(logs.mean(axis=0)).tolist(),
            "error": (logs.std(axis=0, ddof=1) / sqrt(members)).tolist(),
        }
        for key in ("contact", "yielded"):
            row[name][key] = float(np.mean([each[key] for each in all_of]))
    return row


def law(face: Face, waves: int, *, directed: bool) -> np.ndarray:
    """Return T_flash by the law, (directions, speeds), K, with the directions of C(q⃗) or without."""
    contact = {
        "effective_modulus": MODULUS,
        "nominal_pressure": face.pressure,
        "penetration_hardness": face.hardness,
    }
    if directed:
        stress = lay.stress_of_waves(face.spectrum, **contact)
    else:
        stress = lay.stress_of_lay(face.spectrum.whole, 1.0, **contact)
    load = {"nominal_pressure": face.pressure, "friction_coefficient": FRICTION}
    angles = np.array(DIRECTIONS)[:, None]
    slid = waves * pi / face.q_min
    found = lay.flash_temperature(face.speeds, angles, stress, **load, **BODY, slid_distance=slid)
    return np.asarray(found)


def compared(face: Face, row: dict[str, Any], waves: int) -> list[np.ndarray]:
    """Return ln of law over simulation, (directions, speeds), beside the twin: in directions, and without.

    The third is of the twin itself.
    """
    twin = np.log(row["twin"]["flash"]).mean(axis=0)
    simulated = np.log(row["face"]["flash"]) - twin
    plain = law(face, waves, directed=False)
    ratio = np.log(law(face, waves, directed=True) / plain)
    return [ratio - simulated, -simulated, np.log(plain) - twin]


def main() -> None:
    command = Command(__file__, __doc__, "two faces, two members on 64² points")
    command.add_argument("--draw", action="store_true", help="write the lists anew")
    command.add_argument("--solve", choices=list(LISTS), help="solve what is not there yet")
    options = command.parse()
    if options.draw:
        lists = {name: [asdict(face) for face in drawn(name)] for name in LISTS}
        (FOLDER / "lay_waves.json").write_text(json.dumps(lists, indent=1) + "\n")
    path = options.output / "toy.json" if options.toy else FOLDER / "lay_waves_solved.json"
    rows, numbers = Rows(path, resume=True), {}
    for name in ["tuned"] if options.toy else list(LISTS):
        every = []
        for k, face in enumerate(points(name)[: 2 if options.toy else None]):
            if options.toy or options.solve == name:
                size = (64, 4, 2) if options.toy else SIZES.get(name, SIZE)
                rows.once(name, str(k), lambda face=face, size=size: solve(face, *size))
            if str(k) in rows[name]:
                row: Any = rows[name][str(k)]
                every.append(100 * np.expm1(compared(face, row, SIZES.get(name, SIZE)[1])))
                print(name, k, face.kind, *(f"{off:+.1f}" for off in every[-1][0].ravel()), "%")
        if not every:
            continue
        for key, off in zip(("", "_isotropic", "_twin"), np.swapaxes(every, 0, 1), strict=True):
            numbers[f"{name}{key}_rms"] = float(np.sqrt(np.mean(off**2)))
            numbers[f"{name}{key}_worst"] = float(off.flat[np.abs(off).argmax()])
    print(*(f"{name}: {value:.3g}" for name, value in numbers.items()), sep="\n")
    if options.evidence:
        write_evidence("lay_waves", "python experiments/lay_waves.py --evidence", numbers=numbers)


if __name__ == "__main__":
    main()
