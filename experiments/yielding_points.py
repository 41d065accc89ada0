"""Fresh contacts that yield, drawn by chance, to test a law of their stress spectrum that was fitted to others.

    python experiments/yielding_points.py [--draw] [--solve] [--toy] [-o FOLDER]

The first list was drawn before the law had any form; the later ones, numbers from A15, B07, C13, from A21, B14, C24,
and from A23, B17, C29 on, when it had a form that seemed final, the last one that of today. All were committed before
any was solved. Contact is elastic and perfectly plastic, 0 ≤ p ≤ σ_P, with H in 0.3 … 1, σ₀/σ_P in 0.005 … 0.6 and
q_r/q_min, the plateau of C(q), in 1 … 16. Let q_y be the wavenumber up to which roughness must be seen for 1 % of
the contact to stay elastic, by the theory. Kind A has yielded altogether under roughness without end, q_y/q_r in
0.25 … 8. Kind B has yielded too, and C(q) ends at q_max = 1 … 10 q_y. Kind C has yielded in part where C(q) ends, at
q_max/q_r in 1 … 32. Its hardness aims at A_pl/A in 0.1 … 0.9; that of the first list was corrected once, after pilots
of a few members that looked at this share alone.

H and A_pl/A of kind C are drawn uniformly, the rest log-uniformly: one point of a kind in each of as many equal strata,
in random order. Only q_r/q_min, and q_y/q_r of kind B, are drawn until a grid holds all waves, q_min lies well below
q_y or q_max, and q_max is not below q_r. `--draw` writes the list anew.

`--solve` solves what is not there yet, the kinds in turn and the quick ones first, into reference/yielding_measured: a
file for each contact, written whole. `measured()` reads them; contacts/ladder.py says how they were solved. Units
are those of `Contact`, with μ = κ = D = 1: a speed is the Péclet number v/(D q_r), and "flash_temperature" is ⟨Tσ⟩, so
that theory.flash gives it with friction_coefficient = nominal_pressure. Every quantity has "value" and relative errors:
"error" is the total one (95 %), made of "standard_error" (68 %), "ladder" (what cut-offs or pixels leave open) and
"size" (of the cell). "bias" is how far the finest rung lies from the value. "contact_fraction", "yielded_fraction",
"pressure_variance" are one number; "correlation" is g_σ(r) over "r"; "spectrum" is |σ_q|² over "q" on the finest rung,
as a density in the plane of q, with its statistical error (95 %).
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass
from math import exp, inf, log, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from contacts import ladder
from matplotlib.figure import Figure
from scipy.optimize import brentq
from script import Command

import roughsim as rs
from theory import plasticity

SEED = 20261123
LIST = Path(__file__).parent / "reference" / "yielding_points.json"
MEASURED = LIST.parent / "yielding_measured"
LISTS = {  # contacts of each kind by seed
    SEED: {"A": 14, "B": 6, "C": 12},
    20261124: {"A": 6, "B": 7, "C": 11},
    20261125: {"A": 2, "B": 3, "C": 5},
    20261126: {"A": 3, "B": 8, "C": 14},
}
KINDS = "ABC"
HURST, SHARE, PLATEAU = (0.3, 1.0), (0.005, 0.6), (1.0, 16.0)
YIELDS, DEPTH, END = (
    (0.25, 8.0),
    (1.0, 10.0),
    (1.0, 32.0),
)  # q_y/q_r of A and B, q_max/q_y of B, q_max/q_r of C
YIELDED, SOONER = (
    (0.08, 0.97),
    7.0,
)  # A_pl/A of C aimed at; A_pl/A_el is so much larger by the theory (pilots of C)
ELASTIC = 0.01  # A_el/A at q_y
ROOM = {
    "A": 64.0,
    "B": 256.0,
    "C": 256.0,
}  # the most waves along a side: of q_y for A, of q_max for B and C
TARGET = (
    0.015  # of the error of T_flash: there are more members, once, if they scatter too much for it
)
WIDTH = 2.0  # the least q_y/q_min of A and B, and q_max/q_min of C


@dataclass(frozen=True)
class Contact:
    """One contact in units of E* = 1 and q_r = 1, with C(q_r) = 1: C = 1 from 1/plateau to 1, and q^(−2−2H) beyond."""

    name: str  # kind A, B or C, and a number
    hurst: float
    share: float  # σ₀/σ_P
    plateau: float  # q_r/q_min
    q_max: float  # over q_r; infinite for kind A
    yields: float  # q_y/q_r of A and B, NaN for C
    yielded: float  # A_pl/A by the theory where C(q) ends; for A as at q_y
    hardness: float  # σ_P/E*

    @property
    def kind(self) -> str:
        """A, B or C."""
        return self.name[0]

    @property
    def load(self) -> float:
        """σ₀/E*."""
        return self.share * self.hardness

    @property
    def periods(self) -> float:
        """Waves of q_r along a side of the cell: it holds two of the longest waves or more."""
        return periods(self.plateau)

    def spectrum(self, q_max: float | None = None) -> rs.SelfAffineSpectrum:
        """Return C(q) up to its own end, which kind A has not, or up to `q_max`."""
        return roughness(self.hurst, self.plateau, self.q_max if q_max is None else q_max)


def periods(plateau: float) -> float:
    """Return the waves of q_r along a side of the cell."""
    return max(8.0, 2.0 * plateau)


def roughness(hurst: float, plateau: float, q_max: float) -> rs.SelfAffineSpectrum:
    """Return C(q) with C(q_r) = 1 and q_r = 1."""
    return rs.SelfAffineSpectrum(1.0, hurst, 1.0 / plateau, 1.0, q_max)


def hardness_at(share: float, elastic: float, spectrum: rs.SelfAffineSpectrum) -> float:
    """Return σ_P/E* with which, by the theory, this share of the contact is elastic at the end of `spectrum`."""

    def excess(log_g: float) -> float:
        _, still, plastic = plasticity.area_fractions(exp(log_g), share, 1.0)
        return float(still / (still + plastic)) - elastic

    g = exp(brentq(excess, log(1e-6), log(10.0)))
    return sqrt(
        spectrum.moment(2.0) / 8.0 / g
    )  # G = (π/4) E*² ∫ q³ C dq, an eighth of the square of the slope


def drawn() -> list[Contact]:
    """Draw all contacts of the lists, one after another; each kind of a list has random numbers of its own."""
    contacts, number = [], dict.fromkeys(KINDS, 1)
    for seed, counts in LISTS.items():
        for kind, count in counts.items():
            contacts += _drawn(kind, count, seed, number[kind])
            number[kind] += count
    return contacts


def _drawn(kind: str, count: int, seed: int, number: int) -> list[Contact]:
    rng = np.random.default_rng([seed, ord(kind)])

    def strata(low: float, high: float) -> Any:
        """One number in each of `count` equal strata, in random order."""
        return low + (high - low) * (rng.permutation(count) + rng.uniform(size=count)) / count

    def between(low: float, high: float) -> float:
        return _rounded(exp(rng.uniform(log(low), log(high))))

    hursts, shares, targets = strata(*HURST), np.exp(strata(*np.log(SHARE))), strata(*YIELDED)
    reaches = np.exp(strata(*np.log({"A": YIELDS, "B": DEPTH, "C": END}[kind])))
    contacts = []
    for k in range(count):
        hurst, share, reach = (_rounded(x[k]) for x in (hursts, shares, reaches))
        while True:
            plateau, seen = between(*PLATEAU), between(*YIELDS) if kind == "B" else reach
            q_max = {"A": inf, "B": _rounded(reach * seen), "C": reach}[kind]
            waves = periods(plateau) * (seen if kind == "A" else q_max)
            if waves <= ROOM[kind] and seen * plateau >= WIDTH and q_max >= 1.0:
                break
        odds = SOONER * targets[k] / (1.0 - targets[k])
        yielded = _rounded(odds / (1.0 + odds)) if kind == "C" else 1.0 - ELASTIC
        hardness = hardness_at(share, 1.0 - yielded, roughness(hurst, plateau, seen))
        yields = float("nan") if kind == "C" else seen
        contacts.append(
            Contact(
                f"{kind}{k + number:02d}",
                hurst,
                share,
                plateau,
                q_max,
                yields,
                yielded,
                _rounded(hardness, 7),
            )
        )
    return contacts


def _rounded(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def write(contacts: list[Contact], path: Path) -> None:
    """Write the list as JSON, null for what is infinite or not there."""
    rows = [
        json.dumps(
            {
                key: x if isinstance(x, str) or np.isfinite(x) else None
                for key, x in asdict(contact).items()
            }
        )
        for contact in contacts
    ]
    path.write_text("[\n" + ",\n".join(rows) + "\n]\n")


def points() -> list[Contact]:
    """Return the committed list."""
    rows = json.loads(LIST.read_text())
    return [
        Contact(
            **{
                key: (inf if key == "q_max" else float("nan")) if x is None else x
                for key, x in row.items()
            }
        )
        for row in rows
    ]


def draw(contacts: list[Contact], path: Path) -> None:
    """Where the contacts lie: H and how far the roughness is seen over σ₀/σ_P."""
    figure = Figure(figsize=(7.0, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for kind, colour in zip(KINDS, ("#0072b2", "#d55e00", "#009e73"), strict=True):
        some = [contact for contact in contacts if contact.kind == kind]
        shares = [contact.share for contact in some]
        left.scatter(shares, [contact.hurst for contact in some], s=12, color=colour, label=kind)
        seen = [contact.q_max if kind == "C" else contact.yields for contact in some]
        right.scatter(shares, seen, s=12, color=colour)
    left.set(xscale="log", xlabel=r"$\sigma_0/\sigma_P$", ylabel="H")
    right.set(
        xscale="log",
        yscale="log",
        xlabel=r"$\sigma_0/\sigma_P$",
        ylabel=r"$q_y/q_r$, or $q_{max}/q_r$ of C",
    )
    figure.legend(loc="outside upper center", ncols=3)
    figure.savefig(path, dpi=130)


def measured(folder: Path = MEASURED) -> dict[str, dict[str, Any]]:
    """Return what was measured by the name of the contact: the values, errors and units of the head of this module."""
    return {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}


def in_turn(contacts: list[Contact]) -> list[Contact]:
    """Return the contacts in the order in which they are solved: kinds in turn, small grids first."""
    order = []
    for kind in KINDS:
        some = [contact for contact in contacts if contact.kind == kind]
        some.sort(
            key=lambda contact: sum(
                rung.side**2 * rung.members for rung in ladder.ladder(contact)[1]
            )
        )
        order += [
            ((rank + 0.5) / len(some), contact.name, contact) for rank, contact in enumerate(some)
        ]
    return [contact for *_, contact in sorted(order)]


def solve(contact: Contact, folder: Path, *, toy: bool = False) -> dict[str, Any]:
    """Solve one contact, with more members until its error is small enough, and store it whole."""
    start, effort = time.process_time(), ladder.EFFORT
    stream = [SEED, ord(contact.kind), int(contact.name[1:])]
    while True:
        large, rungs = ladder.ladder(contact, *((1e4, 1024) if toy else (effort,)))
        result = ladder.values(rungs, ladder.measure(contact, large, rungs, stream))
        error, scatter = (
            np.array(result["flash_temperature"][key]) for key in ("error", "standard_error")
        )
        if toy or effort > ladder.EFFORT or ((error <= TARGET) | (2 * scatter < 0.7 * error)).all():
            break
        effort *= 3.0
    record = {"name": contact.name, "seconds": time.process_time() - start}
    record |= {"large": asdict(large), "rungs": [asdict(rung) for rung in rungs]} | result
    text = json.dumps(short(record), separators=(",", ":")) + "\n"
    temporary = folder / f"{contact.name}.tmp"
    temporary.write_text(text)
    temporary.replace(folder / f"{contact.name}.json")
    return record


def short(entry: Any) -> Any:
    """Return a record with all its numbers to five digits."""
    if isinstance(entry, dict):
        return {key: short(value) for key, value in entry.items()}
    if isinstance(entry, list):
        return [short(value) for value in entry]
    return _rounded(entry, 5) if isinstance(entry, float) else entry


def main() -> None:
    command = Command(__file__, __doc__, "solve one small contact of each kind with few members")
    command.add_argument("--draw", action="store_true", help="write the list of contacts anew")
    command.add_argument(
        "--solve", action="store_true", help="solve the contacts that have no file yet"
    )
    options = command.parse()
    if options.draw:
        write(drawn(), LIST)
    contacts, folder = points(), MEASURED
    if options.toy:
        folder = options.output
    chosen = in_turn(contacts)
    folder.mkdir(parents=True, exist_ok=True)
    for contact in (chosen[:3] if options.toy else chosen) if options.solve or options.toy else []:
        if options.toy or not (folder / f"{contact.name}.json").exists():
            solve(contact, folder, toy=options.toy)
            print(f"{contact.name} solved", flush=True)
    for name, record in measured(folder).items():
        flash = record["flash_temperature"]
        errors = ", ".join(f"{100 * flash['error'][k]:.1f}" for k in (0, 3, 6))
        print(
            f"{name}: T_flash at Pe 0.001, 1, 1000 to {errors} %; {record['seconds']:.0f} s of CPU"
        )
    draw(contacts, options.output / "yielding_points.png")


if __name__ == "__main__":
    main()
