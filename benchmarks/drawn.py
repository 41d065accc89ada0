"""Scenes drawn at random, to judge by: those of a seed were committed before anything was measured on them.

    python benchmarks/drawn.py [SEED]

Ten scenes: six of one yielding face on a smooth flat or on its like, two of unlike yielding faces, two elastic. Each
range is cut into as many strata as there are scenes that use it, one scene in each. `material_scenes` are three others,
of known materials: wheel on rail, brass, and ice; `soft_scenes` six of soft elastic bodies with wide spectra;
`lay_scenes` twenty whose faces have a lay.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

import roughsim as rs
from roughsim.prediction import yield_wavenumber

Array = NDArray[np.float64]
SEED = 36
SECOND_SEED = 1125  # judges changes that were found by measuring the scenes of the first
ONE_FACE, UNLIKE, ELASTIC, SOFT = 6, 2, 2, 6
# E, Pa, ν, σ_P, Pa, κ, W/(m K), ρ, kg/m³, c, J/(kg K), then ranges of σ₀/σ_P and of q_y/q_min
MATERIALS = {
    "rail": ((206e9, 0.3, 3e9, 48.0, 7850.0, 480.0), (0.1, 0.3), (8.0, 30.0)),
    "brass": ((105e9, 0.34, 1.2e9, 115.0, 8500.0, 380.0), (0.02, 0.2), (2.0, 15.0)),
    "ice": ((9e9, 0.33, 4e7, 2.2, 917.0, 2000.0), (0.01, 0.1), (2.0, 15.0)),
}


def strata(draw: np.random.Generator, low: float, high: float, count: int) -> Array:
    """Return one number of each of `count` strata between two ends, evenly in the logarithm, in random order."""
    return np.asarray(
        low * (high / low) ** ((draw.permutation(count) + draw.uniform(size=count)) / count)
    )


def digits(value: float, count: int = 3) -> float:
    """Return a number to so many significant digits: scenes must not depend on the last bits of a machine."""
    return float(f"{value:.{count - 1}e}")


def body(draw: np.random.Generator, hardness: float | None) -> dict[str, Any]:
    """Return the material of a body."""
    material = {
        "youngs_modulus": digits(draw.uniform(60e9, 300e9)),
        "poisson_ratio": digits(draw.uniform(0.2, 0.35), 2),
        "conductivity": digits(5.0 * 20.0 ** draw.uniform()),
        "density": digits(draw.uniform(4000.0, 9000.0), 2),
        "heat_capacity": digits(draw.uniform(350.0, 900.0), 2),
    }
    return material if hardness is None else material | {"penetration_hardness": digits(hardness)}


def surface(draw: np.random.Generator, hurst: float, q_min: float, plateau: bool) -> dict[str, Any]:
    """Return the shape of C(q) of a face, without its height and end."""
    face = {"hurst": digits(hurst, 2), "q_min": digits(q_min)}
    if plateau:
        face["q_roll_off"] = digits(q_min * draw.uniform(2.0, 8.0))
        face["roll_off_exponent"] = float(draw.choice([0.0, 1.0]))
    return face


def speeds(draw: np.random.Generator, material: dict[str, Any], q: float) -> list[float]:
    """Return three or four speeds, m/s: v/Dq from slow to fast, where waves of q carry most of the stress."""
    diffusivity = material["conductivity"] / material["density"] / material["heat_capacity"]
    slow, fast = 0.01 * 30.0 ** draw.uniform(), 10.0 * 30.0 ** draw.uniform()
    return [
        digits(peclet * diffusivity * q)
        for peclet in np.geomspace(slow, fast, int(draw.integers(3, 5)))
    ]


def yielding_at(sections: dict[str, Any], q_y: float) -> dict[str, Any]:
    """Return the sections with heights of its faces, in their ratio, so that the theory's contact yields at q_y."""

    def scaled(factor: float) -> dict[str, Any]:
        faces = {
            name: section | {"rms_height": digits(factor * section["rms_height"], 4)}
            for name, section in sections.items()
            if "rms_height" in section
        }
        return sections | faces

    low, high = 1e-3, 1e3
    while high / low > 1.001:  # the higher, the longer the waves that yield
        middle = (low * high) ** 0.5
        above = yield_wavenumber(rs.load_scene(scaled(middle))) > q_y
        low, high = (middle, high) if above else (low, middle)
    return scaled(high)


def drawn_scenes(seed: int = SEED) -> dict[str, dict[str, Any]]:
    """Return the sections of ten scenes by name."""
    draw = np.random.default_rng(seed)
    capped = ONE_FACE + UNLIKE
    loads, hursts = strata(draw, 0.003, 0.4, capped), strata(draw, 0.4, 0.9, capped)
    yields, ends = strata(draw, 1.0, 30.0, capped), strata(draw, 8.0, 300.0, capped)
    result = {}
    for k in range(capped):
        q_min, hardness = 2000.0 * 10.0 ** draw.uniform(), draw.uniform(0.5e9, 3e9)
        q_y = q_min * yields[k]
        moving = body(draw, hardness)
        face = surface(draw, hursts[k], q_min, plateau=k % 2 == 0)
        sections: dict[str, Any] = {
            "surface": face | {"rms_height": 1e-6, "q_max": digits(q_y * ends[k])},
            "body": moving,
            "sliding": {
                "nominal_pressure": digits(loads[k] * hardness),
                "friction_coefficient": 0.2,
                "speed": speeds(draw, moving, q_y),
            },
        }
        if k >= ONE_FACE:  # another material, harder, with a C(q) of its own
            other = surface(
                draw,
                draw.uniform(0.4, 0.9),
                q_min * 4.0 ** draw.uniform(-1.0, 1.0),
                plateau=k % 2 == 1,
            )
            other["rms_height"] = 1e-6 * digits(draw.uniform(0.3, 1.0))
            other["q_max"] = digits(q_y * draw.uniform(8.0, 60.0))
            if (
                other.get("q_roll_off", 0.0) >= other["q_max"]
            ):  # no room for a plateau and what follows it
                other = {name: value for name, value in other.items() if "roll_off" not in name}
            sections["counterface"] = other | body(draw, hardness * draw.uniform(1.0, 2.0))
        elif draw.uniform() < 0.5:
            sections["counterface"] = {"like": "body"}
        name = f"unlike {k - ONE_FACE + 1}" if k >= ONE_FACE else f"yielding {k + 1}"
        result[name] = yielding_at(sections, q_y)
    loads, ends = strata(draw, 0.003, 0.2, ELASTIC), strata(draw, 20.0, 300.0, ELASTIC)
    for k in range(ELASTIC):
        q_min, moving = 2000.0 * 10.0 ** draw.uniform(), body(draw, None)
        face = surface(draw, draw.uniform(0.4, 0.9), q_min, plateau=k == 0)
        slope = digits(draw.uniform(0.05, 0.4), 2)
        modulus = moving["youngs_modulus"] / (1.0 - moving["poisson_ratio"] ** 2)
        result[f"elastic {k + 1}"] = {
            "surface": face | {"rms_slope": slope, "q_max": digits(q_min * ends[k])},
            "body": moving,
            "sliding": {
                "nominal_pressure": digits(loads[k] * modulus * slope),
                "friction_coefficient": 0.2,
                "speed": speeds(draw, moving, 3.0 * q_min),
            },
        }
    return result


def material_scenes(seed: int) -> dict[str, dict[str, Any]]:
    """Return the sections of a wheel on a rail, of brass and of ice, each on its like, by name."""
    draw = np.random.default_rng(seed)
    names = (
        "youngs_modulus",
        "poisson_ratio",
        "penetration_hardness",
        "conductivity",
        "density",
        "heat_capacity",
    )
    result = {}
    for name, (constants, share, yields) in MATERIALS.items():
        material = dict(zip(names, constants, strict=True))
        (load,), (times,) = strata(draw, *share, 1), strata(draw, *yields, 1)
        q_min = 2000.0 * 10.0 ** draw.uniform()
        face = surface(draw, draw.uniform(0.5, 0.95), q_min, plateau=name == "brass")
        sections = {
            "surface": face
            | {"rms_height": 1e-6, "q_max": digits(times * q_min * draw.uniform(16.0, 40.0))},
            "body": material,
            "counterface": {"like": "body"},
            "sliding": {
                "nominal_pressure": digits(load * material["penetration_hardness"]),
                "friction_coefficient": 0.2,
                "speed": [0.1, 1.0, 10.0],
            },
        }
        result[name] = yielding_at(sections, times * q_min)
    return result


def soft_scenes(seed: int) -> dict[str, dict[str, Any]]:
    """Return the sections of six soft elastic bodies whose C(q) spans three to six decades, by name."""
    draw = np.random.default_rng(seed)
    ranges = {
        "modulus": (3e6, 3e9),
        "load": (0.003, 0.08),
        "hurst": (0.5, 0.95),
        "q_min": (200.0, 2e4),
        "plateau": (1.01, 8.0),
        "band": (1e3, 1e6),
        "slope": (0.2, 1.5),
        "conductivity": (0.15, 20.0),
    }
    drawn = {name: strata(draw, *ends, SOFT) for name, ends in ranges.items()}
    result = {}
    for k in range(SOFT):
        of = {name: digits(values[k]) for name, values in drawn.items()}
        roll_off = digits(of["q_min"] * of["plateau"])
        material = {
            "youngs_modulus": of["modulus"],
            "poisson_ratio": 0.5,
            "conductivity": of["conductivity"],
            "density": 1200.0,
            "heat_capacity": 1600.0,
        }
        face = {"hurst": of["hurst"], "q_min": of["q_min"], "q_roll_off": roll_off}
        result[f"soft {k + 1}"] = {
            "surface": face | {"rms_slope": of["slope"], "q_max": digits(of["q_min"] * of["band"])},
            "body": material,
            "counterface": {"conductivity": 1.5, "density": 2400.0, "heat_capacity": 900.0},
            "sliding": {
                "nominal_pressure": digits(of["load"] * of["modulus"] / 0.75 * of["slope"]),
                "friction_coefficient": 0.5,
                "speed": speeds(draw, material, 10.0 * roll_off),
            },
        }
    return result


def lay_scenes(seed: int) -> dict[str, dict[str, Any]]:
    """Return the sections of the scenes of two seeds, each with a lay of its own, sliding along, across and between."""
    found = {
        f"{name}, {part}": sections
        for part in (1, 2)
        for name, sections in drawn_scenes(seed + part).items()
    }
    draw = np.random.default_rng(seed)
    for sections, lay in zip(found.values(), strata(draw, 1.5, 10.0, len(found)), strict=True):
        along, between = draw.uniform(0.0, 180.0), draw.uniform(10.0, 80.0)
        for name in ("surface", "counterface"):
            if "hurst" in sections.get(name, {}):
                sections[name] |= {"lay": digits(lay), "lay_direction": f"{along:.1f} deg"}
        ways = (f"{along + turn:.1f} deg" for turn in (0.0, between, 90.0))
        sections["sliding"] |= {"direction": list(ways), "speed": sections["sliding"]["speed"][::2]}
    return found


def main() -> None:
    print(
        "| scene | H | q_max/q_min | roll-off/q_min | q_y/q_min | load: σ₀/σ_P or σ₀/(E* slope) | speeds, m/s |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, sections in drawn_scenes(int(sys.argv[1]) if len(sys.argv) > 1 else SEED).items():
        scene, face = rs.load_scene(sections), sections["surface"]
        full = (
            scene.effective_modulus * face["rms_slope"]
            if scene.elastic
            else scene.penetration_hardness
        )
        q_y = "–" if scene.elastic else f"{yield_wavenumber(scene) / face['q_min']:.3g}"
        ends = (
            f"{face.get(key, face['q_min']) / face['q_min']:.3g}" for key in ("q_max", "q_roll_off")
        )
        load, speed = (
            scene.sliding.nominal_pressure / full,
            ", ".join(f"{v:g}" for v in scene.speeds),
        )
        print(f"| {name} | {face['hurst']:g} | {' | '.join(ends)} | {q_y} | {load:.3g} | {speed} |")


if __name__ == "__main__":
    main()
