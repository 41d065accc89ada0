"""The temperature over the contact of two rough faces that slide, and what reacts there: theory against slides.

    python experiments/sliding_reactions.py [--draw] [--solve] [--evidence] [--toy] [-o FOLDER]

The pairs were drawn by chance when the theory had its form, and their list was committed before any was slid. `--draw`
writes the list again. Contact has yielded altogether (kind A, 1 % of it still elastic at 1.5 to 4 times below q_max),
in part (B, a share from 0.2 to 0.8 still elastic at q_max) or is elastic (E). The first pair of each kind slides under
a smooth face, in the second the smooth face rests. Bodies are unlike but for every fourth pair.

`--solve` slides what is not there yet, into reference/sliding_reactions_slides.json: four pairs of faces each, in a
cell of 4 mm with the longest waves four times a side, and 192² points. Quantiles are over T_flash, of the moving body
at eight positions on the last half of the slid distance. Rates are those of a contact at 700 K with T_flash = 220 K,
over the rate of the whole nominal area at T_flash itself.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from math import exp, inf, log, sqrt
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from reactions_points import ENERGIES, FLASH, SHARES, Found, row_of
from reference.pairs import CELL, MODULUS, Bodies, level_at, rounded
from script import Command, Row, Rows, write_evidence

import roughsim as rs
from roughsim.estimate.fields import by_law, drawn_slides
from roughsim.observables.record import Sample
from roughsim.prediction.fields import draw_slides, sample_of
from roughsim.sliding.distribution import Sampler
from roughsim.sliding.history import LAST, follow
from roughsim.sliding.path import oblique_path
from roughsim.sliding.stepping import Motion, contacts
from theory import clipped

SEED = 20261128
LIST = Path(__file__).parent / "reference" / "sliding_reactions_points.json"
SLIDES = LIST.with_name("sliding_reactions_slides.json")
POINTS, MEMBERS = 192, 4
KINDS = {"A": "yielded", "B": "yielded in part", "E": "elastic"}
ENDS = {"A": 12.0, "B": 10.0, "E": 8.0}  # q_max/q_min
COUNT = 5  # of each kind
DISTANCE = (3e-4, 8e-3)  # m; one pair of each kind in each of as many equal strata of its logarithm
SPEEDS = {"slow": (1.0, 4.0), "fast": (4.0, 15.0)}  # m/s
COLOURS = {"A": "#0072b2", "B": "#d55e00", "E": "#009e73"}


@dataclass(frozen=True)
class Drawn(Bodies):
    """One pair of the list."""

    @property
    def spectrum(self) -> rs.SelfAffineSpectrum:
        """C(q) of both faces together."""
        return self.spectrum_to(ENDS[self.name[0]])

    def motions(self) -> list[Motion]:
        """Return how the contact moves at both speeds."""
        bodies = rs.Body(*self.moving), rs.Body(*self.resting)
        return [Motion(speed, 0.1, *bodies, self.distance) for speed in self.speeds]

    def theory(self, fields: int = 6, points: int = 160) -> Found:
        """Return drawn fields."""
        solid = {"effective_modulus": MODULUS, "nominal_pressure": self.pressure}
        solid["penetration_hardness"] = self.hardness
        sample = draw_slides(
            self.spectrum, solid, self.motions(), self.part, fields=fields, points=points
        )
        return found_of(sample, clipped.law_of(self.spectrum, **solid).contact_fraction)

    def slide(self, points: int = POINTS, members: int = MEMBERS) -> Found:
        """Return slides."""
        grid = rs.Grid((points, points), (CELL, CELL))
        solid = rs.Solid(MODULUS, inf if self.hardness is None else self.hardness)
        spectrum = self.spectrum.truncated(q_max=min(self.spectrum.breaks[-1], grid.nyquist / 2))
        path = oblique_path(grid, self.distance)
        streams = np.random.SeedSequence(
            SEED, spawn_key=(ord(self.name[0]), int(self.name[1:]))
        ).spawn(2 * members)
        rows, area = [], 0.0
        for n in range(members):
            one, two = (
                rs.synthesize(spectrum, grid, np.random.default_rng(key))
                for key in streams[2 * n : 2 * n + 2]
            )
            riding = sqrt(self.part) * two if self.part else None
            along = contacts(
                sqrt(1 - self.part) * one, riding, grid, solid, self.pressure, path, 1e-3
            )
            sampler = Sampler(grid, [path.steps] * len(self.speeds), LAST)
            history = follow(along, grid, path, self.motions(), watchers=[sampler])
            area += history.curves["contact_fraction"].mean() / members
            flash = sampler.flash_temperature
            rows.append((flash, sampler.together(flash)))
        return found_of(sample_of(spectrum.breaks[-1], points, rows, "sliding_"), area)


def found_of(sample: Sample, area: float) -> Found:
    """Return slides with a T_flash of `FLASH`, without an error of the law; `area` is A/A₀."""
    flash = sample.numbers["flash_temperature"].mean(axis=0)
    given = by_law(np.full(len(flash), FLASH), 0.0, "slide")
    return Found(flash, area, drawn_slides(sample, given, np.ones(len(flash))))


def drawn() -> list[Drawn]:
    """Draw the list; what the law of the stress refuses is drawn again."""
    pairs = []
    for kind in KINDS:
        rng = np.random.default_rng([SEED, ord(kind)])
        strata = (rng.permutation(COUNT) + rng.uniform(size=COUNT)) / COUNT
        for number, stratum in enumerate(strata.tolist(), start=1):
            distance = rounded(DISTANCE[0] * (DISTANCE[1] / DISTANCE[0]) ** stratum)
            while True:
                pair = _pair(kind, number, distance, rng)
                with suppress(ValueError):
                    clipped.clipped_field(
                        pair.spectrum,
                        effective_modulus=MODULUS,
                        nominal_pressure=pair.pressure,
                        penetration_hardness=pair.hardness,
                    )
                    break
            pairs.append(pair)
    return pairs


def _pair(kind: str, number: int, distance: float, rng: np.random.Generator) -> Drawn:
    def between(low: float, high: float) -> float:
        return rounded(exp(rng.uniform(log(low), log(high))))

    hurst, plateau = rounded(rng.uniform(0.3, 1.0)), between(1.0, 3.0)
    share, hardness = between(0.02, 0.3), between(0.5e9, 5e9)
    unit = Drawn(
        f"{kind}0", hurst, plateau, 1.0, 1.0, None, 0.5, (1.0, 1.0), (1.0, 1.0), (1.0, 1.0), 1.0
    ).spectrum
    pressure, cap = share * hardness, None if kind == "E" else hardness
    if kind == "E":
        level = (
            pressure / (MODULUS * between(0.015, 0.3) * unit.rms_slope)
        ) ** 2  # σ₀ from 0.015 to 0.3 E* h′
    else:
        end = unit.breaks[-1]
        elastic, seen = (
            (0.01, end / between(1.5, 4.0)) if kind == "A" else (rng.uniform(0.2, 0.8), end)
        )
        level = level_at(share, hardness, elastic, unit.truncated(q_max=seen))
    moving, resting = (
        (between(3.0, 100.0), between(1e-6, 4e-5)),
        (between(3.0, 100.0), between(1e-6, 4e-5)),
    )
    part = {1: 1.0, 2: 0.0}.get(number, rounded(rng.uniform(0.05, 0.95)))
    return Drawn(
        f"{kind}{number}",
        hurst,
        plateau,
        rounded(level),
        rounded(pressure),
        cap,
        part,
        moving,
        resting if number % 4 else moving,
        (between(*SPEEDS["slow"]), between(*SPEEDS["fast"])),
        distance,
    )


def points() -> list[Drawn]:
    """Return the committed list."""
    rows = json.loads(LIST.read_text("utf-8"))
    return [
        Drawn(**{key: tuple(x) if isinstance(x, list) else x for key, x in row.items()})
        for row in rows
    ]


def table(pairs: list[Drawn], rows: dict[str, tuple[Row, Row]]) -> dict[str, float]:
    """Print theory and slides side by side; return differences of T/T_flash, and of rates in %, rms and worst."""
    print(
        "quantiles of T/T_flash by heat, and rates over that of the nominal area at T_flash: theory / slides ± error"
    )
    kinds = (("quantile", SHARES), ("rate", ENERGIES))
    for pair in pairs:
        theory, slid = rows[pair.name]
        print(f"{pair.name}, {KINDS[pair.name[0]]}, f {pair.part:g}, {1e3 * pair.distance:.2g} mm")
        for speed, v in zip(SPEEDS, pair.speeds, strict=True):
            for kind, names in kinds:
                keys = [f"{speed} {kind} {name:g}" for name in names]
                texts = [
                    f"{float(theory[key]):.3g} / {float(slid[key]):.3g} ± {_error(key, theory, slid):.1g}"
                    for key in keys
                ]
                print(f"  {v:g} m/s {kind} " + "   ".join(texts))
    numbers = {}
    for kind, names in kinds:
        for name in names:
            keys = [f"{speed} {kind} {name:g}" for speed in SPEEDS]
            off = np.array(
                [[float(t[key]) - float(s[key]) for key in keys] for t, s in rows.values()]
            )
            error = np.array([[_error(key, t, s) for key in keys] for t, s in rows.values()])
            unit = ""
            if kind == "rate":
                percent = (
                    np.array([[float(s[key]) for key in keys] for _, s in rows.values()]) / 100
                )
                off, error, unit = off / percent, error / percent, " %"
            worst, rms, chance = (
                float(off.flat[np.abs(off).argmax()]),
                *(sqrt(np.mean(x**2)) for x in (off, error)),
            )
            numbers |= {f"{kind}_{name:g}": rms, f"{kind}_{name:g}_worst": worst}
            print(
                f"{kind} {name:g}: theory − slides rms {rms:.2g}, worst {worst:+.2g}{unit}; by chance {chance:.2g}"
            )
    return numbers


def _error(key: str, theory: Row, slid: Row) -> float:
    return float(np.hypot(float(theory[f"{key} error"]), float(slid[f"{key} error"])))


def draw(rows: dict[str, tuple[Row, Row]], path: Path) -> None:
    """Theory over slides: quantiles."""
    figure = Figure(figsize=(4.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for name, (theory, slid) in rows.items():
        for speed, marker in zip(SPEEDS, "o^", strict=True):
            keys = [f"{speed} quantile {share:g}" for share in SHARES]
            x, y = ([float(row[key]) for key in keys] for row in (slid, theory))
            axes.plot(x, y, marker, ms=4, color=COLOURS[name[0]])
    limits = np.array(axes.get_xlim())
    axes.plot(limits, limits, color="0.6", lw=0.7)
    for kind, words in KINDS.items():
        axes.plot([], [], "s", ms=4, color=COLOURS[kind], label=words)
    axes.legend(frameon=False, fontsize="small")
    axes.set(xlabel=r"$T/T_\mathrm{flash}$, slides", ylabel=r"$T/T_\mathrm{flash}$, theory")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "slide one pair on 64² points")
    command.add_argument("--draw", action="store_true", help="write the list of pairs again")
    command.add_argument(
        "--solve", action="store_true", help="slide the pairs that have no row yet"
    )
    options = command.parse()
    if options.draw:
        LIST.write_text(
            "[\n" + ",\n".join(json.dumps(asdict(pair)) for pair in drawn()) + "\n]\n", "utf-8"
        )
    kept = Rows(options.output / "slid.json" if options.toy else SLIDES, resume=not options.toy)
    pairs = [pair for pair in points() if not options.toy or pair.name == "A5"]
    if options.toy or options.solve:
        for pair in pairs:
            size = (64, 2) if options.toy else (POINTS, MEMBERS)
            kept.once(
                "slid",
                pair.name,
                partial(lambda pair, size: row_of(pair.slide(*size), SPEEDS), pair, size),
            )
            print(f"{pair.name} slid", flush=True)
    slid = kept["slid"]
    pairs = [pair for pair in pairs if pair.name in slid]
    fields = (2, 64) if options.toy else (6, 160)
    found = {pair.name: (row_of(pair.theory(*fields), SPEEDS), slid[pair.name]) for pair in pairs}
    if found:
        numbers = table(pairs, found)
        if options.evidence:
            command_line = "python experiments/sliding_reactions.py --evidence"
            write_evidence("sliding_reactions", command_line, numbers=numbers)
        draw(found, options.output / "sliding_reactions.png")


if __name__ == "__main__":
    main()
