"""What a camera sees of faces with a lay, by the law and by simulation, on faces that the law was not chosen with.

    python experiments/lay_camera.py [--toy] [-o FOLDER] [--evidence]

Nine faces are drawn as in lay_points.py, with a seed that was committed before any was solved. Each second camera has a
point spread of .01 … .1 of the longest wave and an exposure of .05 … 1 of it. Compared are the rms of the picture and
the width of its correlation at two speeds in three directions, of two members on 256² points up to waves of four.
"""

from math import inf, pi, sqrt
from typing import Any

import numpy as np
from lay_points import BODY, DIRECTIONS, FRICTION, MODULUS, Face, draw
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim.heat.camera import Lens
from roughsim.heat.periodic import MovingSource, unit_vector
from roughsim.observables.camera import Camera, correlations_of, distances, widths
from theory import camera, lay

SEED, FACES, MEMBERS, POINTS, WAVES = 6104, 9, 2, 256, 4


def drawn(count: int, points: int) -> list[tuple[Face, Lens, lay.LayStress]]:
    """Return faces, cameras, and the stress by the law up to waves of four pixels."""
    rng, found = np.random.default_rng(SEED), []
    while len(found) < count:
        face = draw(rng, (1.5, 10.0), elastic=len(found) % 3 == 0)
        blur, smear = np.exp(rng.uniform(np.log([0.01, 0.05]), np.log([0.1, 1.0])))
        blurred = (2 * pi / face.q_min) * np.array([blur, smear]) * (len(found) % 2)
        try:
            stress = lay.stress_of_lay(
                spectrum(face, points),
                face.lay,
                effective_modulus=MODULUS,
                nominal_pressure=face.pressure,
                penetration_hardness=face.hardness,
            )
        except ValueError:
            continue
        found.append((face, Lens(*blurred.tolist()), stress))
    return found


def spectrum(face: Face, points: int) -> Any:
    """Return C(q) up to waves of four pixels."""
    return face.spectrum.truncated(q_max=min(face.band, points / (4 * WAVES)) * face.q_min)


def cases(face: Face) -> list[tuple[float, float]]:
    """Return the speeds and directions."""
    return [(speed, angle) for angle in DIRECTIONS for speed in face.speeds]


def seen(face: Face, lens: Lens, points: int, members: int) -> dict[str, Any]:
    """Return rms, K, and width, m, of the pictures of some members."""
    side = WAVES * 2 * pi / face.q_min
    square = rs.Grid((points, points), (side, side))
    grid, curves = square.stretched(face.lay), []
    sources = []
    for speed, angle in cases(face):
        ahead, aside = unit_vector(angle)
        rate = speed / BODY["diffusivity"]
        sources.append(MovingSource((rate * ahead, rate * aside), inf, lens=lens))
    solid = rs.Solid(MODULUS, face.hardness or inf)
    for seed in range(members):
        rng = np.random.default_rng([SEED, seed])
        heights = rs.synthesize(spectrum(face, points), square, rng, amplitudes="fixed")
        contact = rs.solve_contact(heights, grid, solid, nominal_pressure=face.pressure)
        looking = Camera(tuple(sources), (1.0,) * len(sources), directed=True)
        curves.append(correlations_of(contact.pressure, grid, looking))
    mean = np.mean(curves, axis=0)
    y = distances(0.5 * float(np.hypot(*grid.lengths)))
    heating = FRICTION * np.array([speed for speed, _ in cases(face)]) / BODY["conductivity"]
    width = [float(widths(curve[None], y)[0]) for curve in mean]
    return {"rms": (heating * np.sqrt(mean[:, 0])).tolist(), "width": width}


def by_law(face: Face, lens: Lens, stress: lay.LayStress) -> dict[str, list[float]]:
    """Return rms, K, and width, m, by the law."""
    heat = {"nominal_pressure": face.pressure, "friction_coefficient": FRICTION, **BODY}
    view = camera.View(lens.resolution, lens.smear)
    formulas = {"rms": camera.seen_rms, "width": camera.seen_width}
    return {
        name: [
            float(formula(speed, stress=stress, direction=angle, view=view, **heat))
            for speed, angle in cases(face)
        ]
        for name, formula in formulas.items()
    }


def main() -> None:
    options = Command(__file__, __doc__, "two faces, one member on 96² points").parse()
    count, members, points = (2, 1, 96) if options.toy else (FACES, MEMBERS, POINTS)
    rows, off = Rows(options.output / f"pictures-{points}.json", resume=True), []
    inside: list[Any] = []
    for k, (face, lens, stress) in enumerate(drawn(count, points)):
        row: Any = rows.once("seen", str(k), lambda f=face, c=lens: seen(f, c, points, members))
        law = by_law(face, lens, stress)
        each = 100 * np.array([np.array(law[name]) / row[name] - 1 for name in ("rms", "width")])
        band = [100 * camera.error_band(name, face.lay) for name in camera.ERROR_BANDS]
        areas = stress.stress_spectrum.contact_fraction
        print(
            f"γ {face.lay:.3g} A {areas:.2g} band {np.round(band, 1)} %:",
            each.round(1).tolist(),
            flush=True,
        )
        off.append(each)
        inside.append(np.abs(each) <= np.array(band)[:, None])
    numbers: dict[str, float] = {"faces": count, "inside": 100 * float(np.mean(inside))}
    for name, each in zip(("rms", "width"), np.moveaxis(off, 1, 0), strict=True):
        numbers[f"{name}_rms"] = sqrt(np.nanmean(each**2))
        numbers[f"{name}_worst"] = float(each.ravel()[np.nanargmax(np.abs(each))])
    print(numbers)
    if options.evidence:
        write_evidence("lay_camera", "python experiments/lay_camera.py --evidence", numbers=numbers)


if __name__ == "__main__":
    main()
