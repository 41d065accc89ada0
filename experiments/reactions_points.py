"""Contacts drawn by chance, drawn clipped fields and solved ones, for the temperature over a contact.

    python experiments/reactions_points.py [--draw] [--solve] [--toy] [-o FOLDER]

The list was committed before any contact was solved; nothing in the form of the theory was fitted to them. `--draw`
writes it again. They are of four kinds: light load, where all has yielded (kind L), yielded in part (P), nearly elastic
(N), and without a hardness (E). The part "first" was there when the theory got its form. "band" was solved to set
errors of the form, `estimate.contacts`, "judge" to test them and for nothing else. "walk" was drawn after the form of
`theory.at_rest` was committed, to test it, and "pooled" after that of `prediction.fields.walked`.

`--solve` solves what is not there yet, into reference/reactions_solved.json: six surfaces, eight of "walk", with four
longest waves a side and four pixels along the shortest wave, slide from rest over half of the cell. A cell of a light
contact has some 70 spots, too few for its hottest hundredth, which is .25 T_flash too cold on average: "pooled" has 64
cells, and eight count as one contact. Quantiles are over T_flash. Rates are those of a contact at 700 K with T_flash =
220 K, over the rate of the whole nominal area at T_flash.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from math import exp, inf, log, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from reference.pairs import level_at, rounded
from script import Command, Row, Rows

import roughsim as rs
from roughsim.estimate import fields
from roughsim.estimate.asked import of_reaction
from roughsim.estimate.contacts import WALKED, Contacts
from roughsim.estimate.errors import estimate
from roughsim.estimate.fields import by_law, drawn_frozen
from roughsim.estimate.reactions import BOLTZMANN, ELECTRONVOLT
from roughsim.observables.distribution import LEVELS
from roughsim.observables.moments import HeatSource
from roughsim.observables.temperatures import (
    SlideFromRest,
    contact_fields,
    distribution_of,
    own_flash,
)
from roughsim.prediction.fields import FrozenFields, draw_frozen, sample_of
from roughsim.scene.reactions import ReactionSection
from theory import clipped

LIST = Path(__file__).parent / "reference" / "reactions_points.json"
SOLVED = LIST.with_name("reactions_solved.json")
TOY = "two contacts of 128² points, which are not those of the list"
MODULUS, CELL, PERIODS = 110e9, 4e-3, 4
KINDS = {"L": "light load", "P": "yielded in part", "N": "nearly elastic", "E": "elastic"}
DIFFUSIVITY = 7.6e-6  # m²/s
SHARES = (0.05, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999)
ENERGIES = (0.6, 1.0, 1.5)  # eV
BACKGROUND, FLASH = 700.0, 220.0  # K


@dataclass(frozen=True)
class Part:
    """Part of the list."""

    seed: int
    numbers: dict[str, range]  # of the contacts of each kind
    points: int  # along a side
    speeds: dict[str, float]  # m/s
    hurst: tuple[float, float]
    share: dict[str, tuple[float, float]]  # σ₀/σ_P, but for kind E
    elastic: dict[str, tuple[float, float]]  # share of the contact that has not yielded
    members: int = 6
    together: int = 1  # cells of a member, whose contacts count as one


_LOAD = (0.02, 0.3)  # σ₀/(E* h′) of kind E
_SLOW, _FAST = {"slow": 1.0}, {"fast": 35.0}
FIRST = Part(
    20261127,
    {kind: range(1, 6) for kind in "LPN"},
    512,
    _SLOW | _FAST,
    (0.4, 1.0),
    {"L": (0.006, 0.02), "P": (0.03, 0.3), "N": (0.03, 0.3)},
    {"L": (0.003, 0.01), "P": (0.3, 0.7), "N": (0.9, 0.97)},
)
BAND = Part(
    20261129,
    {"L": range(6, 8), "P": range(6, 10), "N": range(6, 9), "E": range(6, 11)},
    384,
    {"resting": 0.01, "slower": 0.2} | _SLOW | {"faster": 6.0} | _FAST,
    (0.3, 1.0),
    dict.fromkeys("LPN", (0.006, 0.3)),
    {"L": (0.003, 0.05), "P": (0.1, 0.85), "N": (0.85, 0.99)},
)
JUDGE = replace(
    BAND,
    seed=20261130,
    numbers={"L": range(11, 13), "P": range(11, 15), "N": range(11, 14), "E": range(11, 15)},
)
WALK = replace(
    BAND,
    seed=20261201,
    numbers={"L": range(21, 25), "P": range(21, 29), "N": range(21, 28), "E": range(21, 28)},
    points=256,
    # v/(D q_min) = .1, 3 and 1000
    speeds={
        name: number * DIFFUSIVITY * 2 * pi * PERIODS / CELL
        for name, number in (("still", 0.1), ("slowly", 3.0), ("rushing", 1000.0))
    },
    members=8,
)
POOLED = replace(
    WALK,
    seed=20261202,
    numbers={"L": range(31, 36), "P": range(31, 39), "N": range(31, 38), "E": range(31, 39)},
    together=8,
)
PARTS = {"first": FIRST, "band": BAND, "judge": JUDGE, "walk": WALK, "pooled": POOLED}


@dataclass(frozen=True)
class Drawn:
    """One contact, in SI units."""

    name: str  # kind L, P, N or E, and a number
    hurst: float
    plateau: float  # q_r/q_min
    level: float  # C(q_r), m⁴
    pressure: float
    hardness: float | None

    @property
    def part(self) -> Part:
        """The part of the list to which it belongs."""
        return part_of(self.name)

    def solid(self) -> dict[str, Any]:
        """Return E*, σ₀ and σ_P."""
        return {
            "effective_modulus": MODULUS,
            "nominal_pressure": self.pressure,
            "penetration_hardness": self.hardness,
        }

    def spectrum(self, points: int) -> rs.SelfAffineSpectrum:
        """Return C(q) up to the waves of four pixels."""
        q_min = 2 * pi * PERIODS / CELL
        return rs.SelfAffineSpectrum(
            self.level, self.hurst, q_min, self.plateau * q_min, 2 * pi * points / CELL / 4
        )

    @property
    def source(self) -> HeatSource:
        """The heat of all of its speeds."""
        return HeatSource([*self.part.speeds.values()], 1.0, 1.0, DIFFUSIVITY)

    def theory(self, points: int | None = None, fields: int = 8) -> Found:
        """Return drawn fields."""
        points = points or self.part.points
        spectrum = self.spectrum(points)
        drawn = draw_frozen(spectrum, self.solid(), self.source, points=points, fields=fields)
        law = clipped.law_of(spectrum, **self.solid())
        doubt, shifts = WALKED
        contacts = column_of(drawn, spectrum, doubt)._replace(shifts=shifts)
        return Found(drawn.flash[-1], law.contact_fraction, contacts)

    def solve(self, points: int | None = None, members: int | None = None) -> Found:
        """Return solved contacts of drawn surfaces."""
        points, members = points or self.part.points, members or self.part.members
        grid = rs.Grid((points, points), (CELL, CELL))
        solid = rs.Solid(MODULUS, inf if self.hardness is None else self.hardness)
        spawned, together = (ord(self.name[0]), int(self.name[1:])), self.part.together
        pressures, rows, area = [], [], 0.0
        seeds = np.random.SeedSequence(FIRST.seed, spawn_key=spawned)
        for stream in seeds.spawn(members * together):
            heights = rs.synthesize(self.spectrum(points), grid, np.random.default_rng(stream))
            pressures.append(
                rs.solve_contact(
                    heights, grid, solid, nominal_pressure=self.pressure, tolerance=1e-4
                ).pressure
            )
            if len(pressures) == together:
                rows.append(_as_one(pressures, grid, self.source))
                area += np.mean(np.array(pressures) > 0.0) / members
                pressures.clear()
        spectrum = self.spectrum(points)
        sample = sample_of(spectrum.breaks[-1], points, rows)
        flash = sample.numbers["flash_temperature"].mean(axis=0)
        solved = FrozenFields((sample,), flash[None])
        return Found(flash, area, column_of(solved, spectrum, 0.0))


def _as_one(pressures: list[np.ndarray], grid: rs.Grid, source: HeatSource) -> tuple[Any, Any]:
    """Return T_flash of contacts together, K, (speeds,), and the distribution of the temperature over all of them."""
    slide = SlideFromRest(slid_distance=CELL / 2)
    cells = [contact_fields(pressure, grid, source, slide) for pressure in pressures]
    fields = [np.concatenate(each) for each in zip(*cells, strict=True)]
    heat = np.concatenate([pressure[pressure > 0.0] for pressure in pressures])
    flash = own_flash(fields, heat, float(np.mean(pressures)), source)
    return flash, distribution_of(fields, [heat] * len(fields), flash)


class Found(NamedTuple):
    """Contacts at all speeds: T_flash, K, A/A₀, and what they are at `FLASH`."""

    flash_temperature: np.ndarray
    contact_fraction: float
    drawn: Contacts


def column_of(found: FrozenFields, spectrum: rs.SelfAffineSpectrum, doubt: Any) -> Contacts:
    """Return contacts with a T_flash of `FLASH` at all speeds, without an error of the law."""
    flash = by_law(np.full(found.flash.shape[1:], FLASH), 0.0)
    return drawn_frozen(found, spectrum.breaks[-1], flash, doubt)


def drawn() -> list[Drawn]:
    """Draw the list; what the law of the stress refuses is drawn again."""
    contacts = []
    for part in PARTS.values():
        for kind, numbers in part.numbers.items():
            rng = np.random.default_rng([part.seed, ord(kind)])
            for number in numbers:
                while True:
                    contact = _contact(part, kind, number, rng)
                    with suppress(ValueError):
                        contact.theory(fields=2)
                        break
                contacts.append(contact)
    return contacts


def _contact(part: Part, kind: str, number: int, rng: np.random.Generator) -> Drawn:
    def between(low: float, high: float) -> float:
        return rounded(exp(rng.uniform(log(low), log(high))))

    hurst, plateau, hardness = (
        rounded(rng.uniform(*part.hurst)),
        between(1.0, 4.0),
        between(0.5e9, 5e9),
    )
    unit = Drawn("", hurst, plateau, 1.0, 0.0, None).spectrum(part.points)
    if kind == "E":
        pressure = between(0.006, 0.3) * hardness
        level = rounded(
            (pressure / (MODULUS * between(*_LOAD) * unit.rms_slope)) ** 2
        )  # σ₀ = load E* h′
        return Drawn(f"{kind}{number}", hurst, plateau, level, rounded(pressure), None)
    share = between(*part.share[kind])
    level = rounded(level_at(share, hardness, rng.uniform(*part.elastic[kind]), unit))
    return Drawn(f"{kind}{number}", hurst, plateau, level, rounded(share * hardness), hardness)


def points() -> list[Drawn]:
    """Return the committed list."""
    return [Drawn(**row) for row in json.loads(LIST.read_text("utf-8"))]


def part_of(name: str) -> Part:
    """Return the part of the list to which a contact belongs."""
    return next(one for one in PARTS.values() if int(name[1:]) in one.numbers.get(name[0], ()))


def speeds_of(name: str, solved: Row) -> dict[str, float]:
    """Return the speeds at which a contact of the list was solved, m/s, by name."""
    part = part_of(name)
    return {speed: v for speed, v in part.speeds.items() if f"{speed} flash" in solved}


def row_of(found: Found, speeds: Iterable[str]) -> Row:
    """Return T_flash, quantiles over T_flash, and rates over that of the nominal area at T_flash, with errors."""
    row: Row = {"contact_fraction": found.contact_fraction}
    drawn = found.drawn
    background = np.full(len(drawn.flash.value), BACKGROUND)
    area = by_law(np.full(1, found.contact_fraction), 0.0)
    contacts = drawn._replace(speeds=(0.0,) * len(background), area=area, background=background)
    estimates = {}
    for kind, names in ("quantile", LEVELS), ("area", [f"area_{name}" for name in LEVELS]):
        for name, share in zip(names, SHARES, strict=True):
            quantile = f"temperature_quantile_{name}"
            value = estimate(quantile, fields.quantile_of(found.drawn, quantile))
            estimates[kind, share] = value, FLASH
    for energy in ENERGIES:
        barrier = energy * ELECTRONVOLT
        at_flash = exp(-barrier / (BOLTZMANN * (BACKGROUND + FLASH)))
        rate, kelvin = of_reaction(
            contacts, ReactionSection(activation_energy=(barrier,), prefactor=1.0), barrier
        )
        estimates |= {("rate", energy): (rate, at_flash), ("kelvin", energy): (kelvin, 1.0)}
    for (kind, name), (value, unit) in estimates.items():
        columns = {"": value.mean, " error": value.standard_error, " form": value.budget["form"]}
        for column, numbers in columns.items():
            for speed, number in zip(speeds, numbers, strict=True):
                row[f"{speed} {kind} {name:g}{column}"] = float(number) / unit
    return row | {
        f"{speed} flash": float(kelvin)
        for speed, kelvin in zip(speeds, found.flash_temperature, strict=True)
    }


def beside(theory: Row, solved: Row, key: str) -> str:
    """Return a number of the theory beside that of the solved contact, with the standard error of both."""
    error = np.hypot(float(theory[f"{key} error"]), float(solved[f"{key} error"]))
    return f"{float(theory[key]):.3g} / {float(solved[key]):.3g} ± {error:.1g}"


def found(options: argparse.Namespace, *, solve: bool) -> dict[str, tuple[Row, Row]]:
    """Return the rows of drawn fields and of the solved contact, by its name; two small ones with --toy."""
    kept = Rows(options.output / "solved.json" if options.toy else SOLVED, resume=not options.toy)
    size = (128, 2) if options.toy else (None, None)
    contacts = [contact for contact in points() if not options.toy or contact.name in ("P1", "L1")]
    if options.toy or solve:
        for contact in contacts:
            kept.once(
                "solved",
                contact.name,
                partial(lambda c: row_of(c.solve(*size), c.part.speeds), contact),
            )
            print(f"{contact.name} solved", flush=True)
    solved = kept["solved"]
    return {
        c.name: (row_of(c.theory(size[0]), c.part.speeds), solved[c.name])
        for c in contacts
        if c.name in solved
    }


def main() -> None:
    command = Command(__file__, __doc__, TOY)
    command.add_argument("--draw", action="store_true", help="write the list of contacts again")
    command.add_argument(
        "--solve", action="store_true", help="solve the contacts that have no row yet"
    )
    options = command.parse()
    if options.draw:
        rows = ",\n".join(json.dumps(asdict(contact)) for contact in drawn())
        LIST.write_text(f"[\n{rows}\n]\n", "utf-8")
    for name, (theory, solved) in found(options, solve=options.solve).items():
        for speed in speeds_of(name, solved):
            key = f"{speed} quantile {SHARES[5]:g}"
            print(f"{name} {speed}: 99 % of the heat {beside(theory, solved, key)}")


if __name__ == "__main__":
    main()
