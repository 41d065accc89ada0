"""Deep references of six scenes, independent of plan and estimate: deep.json beside this file.

    PYTHONPATH=experiments:. python experiments/reference/make_deep.py [--only NAME ...]

Each reference is a ladder of cut-offs with 4 pixels per shortest wave, by multilevel Monte Carlo (Giles, Acta Numerica
24, 259, 2015): X = ⟨X₀⟩ Π ⟨X_l⟩/⟨X_{l−1}⟩. Each level has surfaces of its own, on which both cut-offs have the same
modes. Finer pixels at the top follow in the same way. The rest up to the end of C(q) is what a change of first order in
1/q_c leaves, in elastic contact what steps leave that go on shrinking as the last two; the rest by the pixel is what
its order leaves; half of both is in doubt. Nothing comes from a law or a theory, but no value lies beyond the bounds of
the balance of forces under a hardness: A ≥ σ₀/σ_P, g_σ(0) ≤ σ₀(σ_P − σ₀).
Values are with all heat in the moving body; areas are corrected for the pixels along edges. A row that is in the file
is not computed again. All six take an hour of one core.
"""

import argparse
import json
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, log2, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from script import Rows

import roughsim as rs
from roughsim.prediction import yield_wavenumber

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("deep.json")
SEED = 987_001  # of the references alone
PIXELS = 4  # per shortest wave
# of convergence in the pixel; of the area and variance of capped contact .81 and .94, .94 and .93 in the steps of demo
ORDER, ORDER_OF_AREA = 1.4, 0.9
MOST_SIDE = 6144  # points per side of a grid
DRAWN_SIDE = 3072  # the same for scenes that are drawn
STEEL = {
    "youngs_modulus": "200 GPa",
    "poisson_ratio": 0.3,
    "penetration_hardness": "2 GPa",
    "conductivity": "30 W/(m K)",
    "density": "7900 kg/m^3",
    "heat_capacity": "500 J/(kg K)",
}
SLIDING = {"friction_coefficient": 0.11, "speed": [0.1, 3.0, 100.0]}
FACE = {"rms_height": "1 um", "hurst": 0.8, "q_min": 6350.0}
MEASURED = (
    "flash_temperature",
    "contact_fraction_corrected",
    "pressure_variance",
    "resting_flash_temperature",
)


def scene_of(
    surface: dict[str, Any], nominal_pressure: str, counterface: dict[str, Any] | None = None
) -> rs.Scene:
    """Return a scene of steel against a smooth insulating flat, or a counterface."""
    sections: dict[str, Any] = {"surface": FACE | surface, "body": STEEL}
    sections["sliding"] = SLIDING | {"nominal_pressure": nominal_pressure}
    if counterface is not None:
        sections["counterface"] = counterface
    return rs.load_scene(sections)


def elastic_scene() -> rs.Scene:
    """Return elastic steel, H = .7, whose C(q) goes on far beyond what a plan resolves."""
    body = {key: value for key, value in STEEL.items() if key != "penetration_hardness"}
    surface = {"rms_height": "0.6 um", "hurst": 0.7, "q_min": 6350.0, "q_max": 256 * 6350.0}
    sliding = SLIDING | {"nominal_pressure": "80 MPa"}
    return rs.load_scene({"surface": surface, "body": body, "sliding": sliding})


UNLIKE = {  # a smoother and softer face of another material
    "rms_height": "0.5 um",
    "hurst": 0.6,
    "q_min": 12700.0,
    "q_max": 1.2e6,
    "youngs_modulus": "110 GPa",
    "poisson_ratio": 0.34,
    "penetration_hardness": "1.5 GPa",
    "conductivity": "110 W/(m K)",
    "density": "8500 kg/m^3",
    "heat_capacity": "380 J/(kg K)",
}


@dataclass(frozen=True)
class Case:
    """A scene, and the ladder of its reference.

    The cell of the lowest level has `waves` longest waves per side; that of the steps is so many times (`parts`)
    smaller, and smaller still where a grid would be larger than `most_side`: the last one of the steel has seven
    roll-off waves per side. The ladder climbs from `first` to `top`, rad/m; `members` are those of the lowest level, of
    the first step, and at least of any.
    """

    scene: rs.Scene
    waves: float
    parts: int
    first: float
    top: float
    members: tuple[int, int, int]
    most_side: int = MOST_SIDE

    @property
    def cut_offs(self) -> list[float]:
        """The cut-offs, each twice the one before, the last at the top, rad/m."""
        steps = round(np.log2(self.top / self.first))
        return [self.top / 2 ** (steps - step) for step in range(steps + 1)]


def cases() -> dict[str, Case]:
    """Return the six scenes."""
    light = {"rms_height": "2.13 um", "q_max": 96 * 6350.0}  # q_y = 3 q_min
    rough = {
        "rms_height": "1.16 um",
        "hurst": 0.4,
        "q_roll_off": 12700.0,
        "q_max": 210 * 6350.0,
    }  # q_y = 7 q_min
    unlike = {"rms_height": "1.2 um", "q_roll_off": 25400.0, "roll_off_exponent": 1.0, "q_max": 2e6}
    return {
        "demo": Case(rs.load_scene("demo"), 8, 2, 1e5, 2e5, (1500, 200, 24)),
        "steel-1.2GPa": Case(rs.load_scene("steel-1.2GPa"), 8, 4, 2.04e5, 1.3056e7, (1200, 150, 8)),
        "light load": Case(
            scene_of(light, "6 MPa"), 16, 2, 6 * 6350.0, 96 * 6350.0, (1500, 200, 16)
        ),
        "low H": Case(scene_of(rough, "120 MPa"), 8, 4, 26.25 * 6350.0, 210 * 6350.0, (400, 60, 8)),
        "unlike faces": Case(scene_of(unlike, "50 MPa", UNLIKE), 8, 4, 1.25e5, 2e6, (600, 100, 8)),
        "elastic": Case(elastic_scene(), 8, 2, 16 * 6350.0, 256 * 6350.0, (1600, 300, 12)),
    }


def case_of(scene: rs.Scene) -> Case:
    """Return the ladder of a drawn scene, of minutes on one core; q_y and the load set its size, not the estimate.

    The cell of the lowest level has 64 hot spots or more, and 64 waves of q_y per side; in elastic contact it has 16
    longest waves. A cell at the highest cut-off has at least four waves of q_y and half a longest wave per side, in
    elastic contact two of these; for finer pixels it has half of that. If C(q) goes on beyond its grid, the ladder ends
    there.
    """
    q_min, end = scene.spectrum.breaks[0], scene.spectrum.breaks[-1]
    if scene.elastic:
        waves, first, furthest = 16, 8 * q_min, DRAWN_SIDE / (4 * PIXELS) * q_min
    else:
        q_yield = yield_wavenumber(scene)
        share = scene.sliding.nominal_pressure / scene.penetration_hardness
        waves = max(4, 2 * ceil(0.5 * max(64.0, sqrt(64.0 / share)) * q_min / q_yield))
        first, furthest = 2 * q_yield, DRAWN_SIDE / PIXELS * min(q_yield / 8, q_min)
    top = min(end, furthest)
    doublings = max(round(log2(top / first)), 1)
    return Case(scene, waves, 2, top / 2**doublings, top, (400, 160, 12), DRAWN_SIDE)


def moments(case: Case, level: rs.Level, length: float, index: int, seed: int) -> Array:
    """Return what is measured of one member of a level in a cell, one row; equal seed and index are one surface."""
    numerics = rs.Numerics(
        (level,), (length, length)
    )  # one level each: all of them have the same stream
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", message="q_min = ", category=RuntimeWarning
        )  # steps leave out long waves
        found = rs.realize(case.scene, numerics, seed=seed, index=index).observables
    return np.concatenate([np.atleast_1d(getattr(found, name)) for name in MEASURED])


def side(q: float, length: float, pixels: int = PIXELS) -> int:
    """Return the points along a side for so many pixels per shortest wave, less 2 % at most: 2^a · 4, 5 or 6."""
    least = 0.98 * pixels * q * length / (2 * pi)
    return min(k << a for a in range(16) for k in (4, 5, 6) if k << a >= least)


def steps(case: Case, length: float) -> Iterator[tuple[str, float, tuple[rs.Level, ...]]]:
    """Yield name, side of the cell, m, and both levels of each step of the ladder, those of the pixel last."""
    column = "elastic" if case.scene.elastic else "capped"
    for pair in zip(case.cut_offs, case.cut_offs[1:], strict=False):
        while side(pair[1], length) > case.most_side:  # of the shortest waves alone
            length /= 2
        yield (
            f"q_c = {pair[1]:.4g}",
            length,
            tuple(rs.Level(column, (side(q, length),) * 2, q) for q in pair),
        )
    pixels = 2 * PIXELS
    while side(case.top, length, pixels) > case.most_side:  # of the shortest waves alone
        length /= 2
    while side(case.top, length, pixels) <= case.most_side:
        sides = (side(case.top, length, n) for n in (pixels // 2, pixels))
        yield f"{pixels} pixels", length, tuple(rs.Level(column, (n, n), case.top) for n in sides)
        pixels *= 2


def reference(name: str, case: Case, rows: Rows) -> None:
    """Compute what is missing of a reference: mean and relative variance of the mean of each factor."""
    length = 2 * pi / case.scene.spectrum.breaks[0] * case.waves
    column = "elastic" if case.scene.elastic else "capped"
    lowest = rs.Level(column, (side(case.first, length),) * 2, case.first)
    count, of_step, least = case.members

    def level_zero() -> dict[str, Any]:
        values = np.stack([moments(case, lowest, length, index, SEED) for index in range(count)])
        mean = values.mean(axis=0)
        return {
            "factor": mean.tolist(),
            "variance": (values.var(axis=0, ddof=1) / mean**2 / count).tolist(),
            "n": count,
        }

    rows.once(name, "lowest", level_zero)
    for number, (step, part, both) in enumerate(steps(case, length / case.parts)):
        members, seed = max(least, of_step >> (2 * number)), SEED + 1 + number

        def ratio(
            part: float = part,
            both: tuple[rs.Level, ...] = both,
            members: int = members,
            seed: int = seed,
        ) -> dict[str, Any]:
            pairs = np.stack(
                [
                    [moments(case, each, part, index, seed) for each in both]
                    for index in range(members)
                ]
            )
            below, above = pairs.mean(axis=0)
            change = pairs[:, 1] / above - pairs[:, 0] / below
            variance = change.var(axis=0, ddof=1) / members
            return {"factor": (above / below).tolist(), "variance": variance.tolist(), "n": members}

        rows.once(name, step, ratio)
        print(f"{name}: {step}", flush=True)


def entries(case: Case, name: str) -> int:
    """Return how many numbers of `MEASURED` a quantity has: temperatures have one for each speed."""
    return len(case.scene.speeds) if "temperature" in name else 1


def orders(case: Case) -> Array:
    """Return the order of convergence in the pixel of each number of `MEASURED`."""
    of_area = ORDER if case.scene.elastic else ORDER_OF_AREA
    return np.concatenate(
        [
            np.full(entries(case, name), ORDER if "temperature" in name else of_area)
            for name in MEASURED
        ]
    )


def rest_in_cut_off(case: Case, changes: list[Array]) -> Array:
    """Return the relative change from the top to the end of C(q), by those of the steps below.

    In contact that yields each doubling changes half of what the one before did. Area and variance of elastic contact
    go on as a power of the mean slope: in the logarithm steps shrink by the ratio of the last two, or stay as they are.
    """
    doublings = log2(case.scene.spectrum.breaks[-1] / case.top)
    if not case.scene.elastic:
        return changes[-1] * (1.0 - 0.5**doublings)
    last, before = np.log1p(changes[-1]), np.log1p(changes[-2] if len(changes) > 1 else changes[-1])
    ratio = np.abs(np.divide(last, before, out=np.ones_like(last), where=before != 0.0))
    with np.errstate(all="ignore"):  # 0/0 of steps that do not shrink
        shrinking = ratio * (1.0 - ratio**doublings) / (1.0 - ratio)
    return np.expm1(last * np.where(ratio < 1.0, shrinking, doublings))


def assembled(case: Case, factors: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return value and relative standard error of each quantity, with the rest that follows in q_c and the pixel."""
    value, variance = 1.0, 0.0
    changes, finer = [], np.zeros(1)
    for name, row in factors.items():
        factor = np.array(row["factor"])
        value, variance = value * factor, variance + np.array(row["variance"])
        if name.startswith("q_c"):
            changes.append(factor - 1.0)
        finer = factor - 1.0 if name.endswith("pixels") else finer
    for rest in (rest_in_cut_off(case, changes), finer / (2.0 ** orders(case) - 1.0)):
        value, variance = value * (1.0 + rest), variance + (0.5 * rest) ** 2
    error = np.sqrt(variance)
    result, start = {}, 0
    for name in MEASURED:
        count = entries(case, name)
        chosen = slice(start, start + count)
        result[name] = {"value": value[chosen].tolist(), "error": error[chosen].tolist()}
        start += count
    if not case.scene.elastic:
        load, hardness = case.scene.sliding.nominal_pressure, case.scene.penetration_hardness
        area, of_pressure = (
            result[name]["value"] for name in ("contact_fraction_corrected", "pressure_variance")
        )
        area[0], of_pressure[0] = (
            max(area[0], load / hardness),
            min(of_pressure[0], load * (hardness - load)),
        )
    return result


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--only", nargs="*", help="names of scenes")
    chosen = options.parse_args().only
    rows = Rows(FILE, resume=True)
    for name, case in cases().items():
        if chosen is None or name in chosen:
            reference(name, case, rows)
            print(json.dumps(assembled(case, rows[name]), indent=1), flush=True)


if __name__ == "__main__":
    main()
