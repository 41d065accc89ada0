"""Pairs of rough bodies that are drawn by chance: their list, C(q) and theory.

Contact has yielded altogether (kind A, 1 % of it still elastic at 1.5 to 5 times below q_max), in part (B, a share from
0.2 to 0.8 still elastic at q_max) or is elastic (E). The bodies are unlike but for every fourth pair. Every sixth pair
has one face that is smooth. Each pair slides at two speeds.
"""

import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from math import exp, log, pi
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

import roughsim as rs
from theory import plasticity, two_bodies

DISTANCE = (1e-4, 16e-3)  # m; one pair in each of as many equal strata of its logarithm
MODULUS, CELL, PERIODS = 110e9, 4e-3, 4
FURTHER = (1.5 * CELL, 16 * CELL)


@dataclass(frozen=True)
class Part:
    """Part of the list."""

    seed: int
    numbers: dict[str, range]  # of the pairs of each kind
    points: int  # along a side
    ends: dict[str, float]  # q_max/q_min
    distance: tuple[float, float] = DISTANCE
    share: tuple[float, float] = (0.03, 0.4)  # σ₀/σ_P
    load: tuple[float, float] = (0.015, 0.3)  # σ₀/(E*h′)
    kappa: tuple[float, float] = (3.0, 100.0)
    speeds: tuple[float, float, float] = (0.5, 7.0, 100.0)


FIRST = Part(
    20261126,
    {"A": range(1, 13), "B": range(1, 9), "E": range(1, 7)},
    256,
    {"A": 16.0, "B": 12.0, "E": 8.0},
)
SECOND = Part(
    20261127,
    {"A": range(13, 23), "B": range(9, 17), "E": range(7, 13)},
    144,
    {"A": 9.0, "B": 9.0, "E": 8.0},
)
# the first seed with a rough body that slides under a smooth one for more than 5 mm
FRESH = Part(
    20261130,
    {"A": range(23, 33), "B": range(17, 25), "E": range(13, 21)},
    160,
    {"A": 9.0, "B": 9.0, "E": 8.0},
)
# to nearly full contact, and up to κ 1:40
DENSE = Part(
    20261205,
    {"A": range(51, 55), "B": range(51, 63), "E": range(51, 67)},
    96,
    {"A": 6.0, "B": 4.0, "E": 4.0},
    (1e-3, 16e-3),
    (0.05, 0.6),
    (0.03, 1.0),
    (2.5, 100.0),
    (1.0, 10.0, 100.0),
)
# the same, drawn when long waves of the pressure stayed with either face
LATER = replace(
    DENSE,
    seed=20261207,
    numbers={"A": range(71, 77), "B": range(71, 81), "E": range(71, 85)},
)
PARTS = {"first": FIRST, "second": SECOND, "fresh": FRESH, "dense": DENSE, "later": LATER}
# of experiments/sliding_distance.py, with a list of its own
FAR = Part(
    20261202,
    {"A": range(41, 47), "B": range(41, 46), "E": range(41, 46)},
    144,
    {"A": 9.0, "B": 9.0, "E": 8.0},
    FURTHER,
)


@dataclass(frozen=True)
class Bodies:
    """Two bodies, in SI units; `part` of C(q) rides with the moving one."""

    name: str  # kind A, B or E, and a number
    hurst: float
    plateau: float  # q_r/q_min
    level: float  # C(q_r), m⁴
    pressure: float
    hardness: float | None
    part: float
    moving: tuple[float, float]  # κ, D
    resting: tuple[float, float]
    speeds: tuple[float, float]
    distance: float

    def spectrum_to(self, end: float) -> rs.SelfAffineSpectrum:
        """Return C(q) of both faces together, up to q_max/q_min."""
        q_min = 2 * pi * PERIODS / CELL
        return rs.SelfAffineSpectrum(
            self.level, self.hurst, q_min, self.plateau * q_min, end * q_min
        )


@dataclass(frozen=True)
class Pair(Bodies):
    """One pair of the list."""

    @property
    def kind(self) -> str:
        """A, B or E."""
        return self.name[0]

    @property
    def drawn(self) -> Part:
        """The part of the list to which it belongs."""
        return next(
            part for part in (*PARTS.values(), FAR) if int(self.name[1:]) in part.numbers[self.kind]
        )

    @property
    def spectrum(self) -> rs.SelfAffineSpectrum:
        """C(q) of both faces together."""
        return self.spectrum_to(self.drawn.ends[self.kind])

    def theory(self, distance: Any, speed: Any = None) -> two_bodies.SlidingTemperatures:
        """Return the theory, with μ = 0.1."""
        return two_bodies.sliding_temperatures(
            self.speeds if speed is None else speed,
            self.spectrum,
            effective_modulus=MODULUS,
            nominal_pressure=self.pressure,
            penetration_hardness=self.hardness,
            friction_coefficient=0.1,
            conductivity=self.moving[0],
            diffusivity=self.moving[1],
            resting_conductivity=self.resting[0],
            resting_diffusivity=self.resting[1],
            moving_roughness=self.part,
            slid_distance=distance,
        )


def drawn(parts: Iterable[Part]) -> list[Pair]:
    """Draw a list; each kind has random numbers of its own. What the laws of the stress refuse is drawn again."""
    return [pair for several in parts for kind in several.numbers for pair in _drawn(several, kind)]


def _drawn(several: Part, kind: str) -> list[Pair]:
    pairs = []
    rng = np.random.default_rng([several.seed, ord(kind)])
    count = len(several.numbers[kind])
    stratum = (rng.permutation(count) + rng.uniform(size=count)) / count
    distances = several.distance[0] * (several.distance[1] / several.distance[0]) ** stratum
    for number, distance in zip(several.numbers[kind], distances.tolist(), strict=True):
        while True:
            pair = _pair(several, kind, number, rounded(distance), rng)
            with suppress(ValueError):
                pair.theory(pair.distance)
                break
        pairs.append(pair)
    return pairs


def _pair(several: Part, kind: str, number: int, distance: float, rng: np.random.Generator) -> Pair:
    def between(low: float, high: float) -> float:
        return rounded(exp(rng.uniform(log(low), log(high))))

    hurst, plateau = rounded(rng.uniform(0.3, 1.0)), between(1.0, 3.0)
    share, hardness = between(*several.share), between(0.5e9, 5e9)
    end = several.ends[kind]
    q_min = 2 * pi * PERIODS / CELL
    unit = rs.SelfAffineSpectrum(1.0, hurst, q_min, plateau * q_min, end * q_min)
    if kind == "E":
        pressure, load, hardness_or_none = share * hardness, between(*several.load), None
        level = (pressure / (MODULUS * load * unit.rms_slope)) ** 2  # σ₀ = load E* h′
    else:
        pressure, hardness_or_none = share * hardness, hardness
        elastic, seen = (
            (0.01, end / between(1.5, 5.0)) if kind == "A" else (rng.uniform(0.2, 0.8), end)
        )
        level = level_at(share, hardness, elastic, unit.truncated(q_max=seen * q_min))
    moving, resting = (
        (between(*several.kappa), between(1e-6, 4e-5)),
        (between(*several.kappa), between(1e-6, 4e-5)),
    )
    slow, middle, fast = several.speeds
    speeds, part = (between(slow, middle), between(middle, fast)), rounded(rng.uniform(0.05, 0.95))
    return Pair(
        f"{kind}{number:02d}",
        hurst,
        plateau,
        rounded(level),
        rounded(pressure),
        hardness_or_none,
        part if number % 6 else float(number % 12 == 0),
        moving,
        resting if number % 4 else moving,
        speeds,
        distance,
    )


def level_at(share: float, hardness: float, elastic: float, unit: rs.SelfAffineSpectrum) -> float:
    """Return the factor on the C(q) `unit` with which this share of the contact is elastic at its end, by walls."""

    def excess(log_g: float) -> float:
        _, still, plastic = plasticity.area_fractions(exp(log_g), share, 1.0)
        return float(still / (still + plastic)) - elastic

    g = exp(brentq(excess, log(1e-6), log(10.0)))
    return 8 * g * (hardness / MODULUS / unit.rms_slope) ** 2  # G = (π/4) E*² ∫ q³ C dq


def rounded(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def points(path: Path) -> list[Pair]:
    """Return a committed list."""
    rows = json.loads(path.read_text("utf-8"))
    return [
        Pair(**{key: tuple(x) if isinstance(x, list) else x for key, x in row.items()})
        for row in rows
    ]


def write(pairs: list[Pair], path: Path) -> None:
    """Write a list as JSON."""
    path.write_text(
        "[\n" + ",\n".join(json.dumps(asdict(pair)) for pair in pairs) + "\n]\n", "utf-8"
    )
