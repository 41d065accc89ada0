"""Contacts of roughness with gaps and at the corners of the range, to see where the law for contact that yields fails.

    python experiments/yielding_gaps.py [--solve] [--toy] [-o FOLDER] [--evidence]

The contacts are drawn from seeds. Those of TUNED chose the measure of a gap and its limit in `theory.validity`; those
of FRESH were solved after both were final, and only they are a test. Three kinds, in the units of yielding_points.py:

G   C(q) is a self-affine one from q = 1 on, of which two bands are whole and the waves between them are left out but
    for a share of C, about 1e-6, 1e-3, 1e-2, 1e-1. The upper band begins at about 2, 4, 8 or 16 times the end of the
    lower one, each reaches a factor of 1.15 to 4. Contact has yielded in part, or all of it.
P   Self-affine C(q) with plateaus of 1, 2 and 4 octaves, H of .3 and .6, that ends within two octaves of q_r.
L   Self-affine C(q) of which little has yielded, A_pl/A ≤ .1.

`--solve` solves what is not there yet into reference/yielding_gaps, a file for each contact, on grids of up to 2048
points along a side, as contacts/ladder.py says. The table sets the law beside them: ln of T_flash at the Péclet
numbers .001, 1 and 1000, g_σ(0), the largest departure of g_σ(r) over g_σ(0), and both areas, all in percent; "refused"
is what `plasticity.stress_spectrum` says.
"""

from __future__ import annotations

import dataclasses
import json
import time
from itertools import product
from math import exp, log, nan
from pathlib import Path
from typing import Any

import numpy as np
import yielding_points
from contacts import ladder
from matplotlib.figure import Figure
from script import Command, write_evidence

import roughsim as rs
from theory import flash, persson, plasticity
from theory.arguments import octaves_of_gaps
from theory.validity import FAINT
from theory.validity import GAPS as GAPS_ALLOWED
from theory.yielding import YieldingSpectrum

MEASURED = Path(__file__).parent / "reference" / "yielding_gaps"
TUNED, FRESH = 20261201, 20261202
GAPS, FILLS = (2.0, 4.0, 8.0, 16.0), (1e-6, 1e-3, 1e-2, 1e-1)
WAVES = 32.0  # q_max/q_r of roughness with a gap
SIDE = 2048  # points along a side
CERTAIN = 0.05  # the largest relative error of g_σ(r), measured, at which it is compared
SHOWN = (0, 3, 6)  # of the Péclet numbers: .001, 1 and 1000


@dataclasses.dataclass(frozen=True)
class Gapped:
    """C(q) of a self-affine surface times `fill` between the wavenumbers `low` and `high`."""

    whole: rs.SelfAffineSpectrum
    low: float
    high: float
    fill: float

    @property
    def breaks(self) -> tuple[float, ...]:
        """Both ends of C(q) and of the gap, which changes within a ten thousandth of q."""
        edges = (self.low, self.low * (1 + 1e-4), self.high * (1 - 1e-4), self.high)
        return tuple(sorted({*self.whole.breaks, *edges}))

    def __call__(self, q: Any) -> Any:
        """Return C at wavenumbers q."""
        inside = np.interp(
            np.log(q),
            np.log([self.low, self.low * (1 + 1e-4), self.high * (1 - 1e-4), self.high]),
            [0.0, 1.0, 1.0, 0.0],
        )
        return self.whole(q) * self.fill**inside


@dataclasses.dataclass(frozen=True)
class Contact(yielding_points.Contact):
    """A contact whose C(q) has a gap from `low` to `high`, filled to `fill`; none where `fill` is 1."""

    low: float = nan
    high: float = nan
    fill: float = 1.0

    @property
    def periods(self) -> float:
        """Waves of q_r along a side of the cell."""
        return 4.0 if self.fill < 1.0 else yielding_points.periods(self.plateau)

    @property
    def solid(self) -> dict[str, float]:
        """What theory.plasticity asks for."""
        return {
            "effective_modulus": 1.0,
            "nominal_pressure": self.load,
            "penetration_hardness": self.hardness,
        }

    def spectrum(self, q_max: float | None = None) -> Any:
        """Return C(q), which always ends at its own q_max."""
        whole = yielding_points.roughness(self.hurst, self.plateau, self.q_max)
        return Gapped(whole, self.low, self.high, self.fill) if self.fill < 1.0 else whole


def half_square(spectrum: Any) -> float:
    """Return ∫ q³ C dq/8, which is G for E* = 1, over 2π."""
    return float(persson.half_variance(spectrum.breaks[-1], spectrum, effective_modulus=1.0))


def with_hardness(contact: Contact) -> Contact:
    """Return the contact with the hardness at which, by the theory, its share `yielded` of the contact has yielded."""
    from scipy.optimize import brentq

    def excess(log_g: float) -> float:
        _, still, plastic = plasticity.area_fractions(exp(log_g), contact.share, 1.0)
        return float(plastic / (still + plastic)) - contact.yielded

    g = exp(brentq(excess, log(1e-7), log(10.0)))
    return dataclasses.replace(
        contact, hardness=float((half_square(contact.spectrum()) / g) ** 0.5)
    )


def drawn(seed: int) -> list[Contact]:
    """Return the contacts of one seed."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(f"{exp(rng.uniform(log(low), log(high))):.4g}")

    contacts = []
    for middle, about, light in product(GAPS, FILLS, (True, False)):
        gap, fill = middle * between(0.75, 1.4), about * between(0.4, 1.5)
        low, above = (
            between(1.15, (WAVES / gap) ** 0.5),
            between(1.15, min((WAVES / gap) ** 0.5, 4.0)),
        )
        share, hurst = between(0.005, 0.03) if light else between(0.03, 0.4), between(0.3, 1.0)
        contacts.append(
            Contact(
                "G",
                hurst,
                share,
                1.0,
                low * gap * above,
                nan,
                between(0.3, 0.97),
                nan,
                low,
                low * gap,
                fill,
            )
        )
    for hurst, plateau, depth in product((0.3, 0.6), (2.0, 4.0, 16.0), (1.5, 3.0)):
        contacts.append(
            Contact("P", hurst, between(0.005, 0.1), plateau, depth, nan, between(0.8, 0.995), nan)
        )
    for _ in range(8):
        share, depth = between(0.005, 0.2), between(3.0, 8.0)
        contacts.append(
            Contact(
                "L",
                between(0.3, 1.0),
                share,
                between(1.0, 8.0),
                depth,
                nan,
                between(0.06, 0.45),
                nan,
            )
        )
    named = [
        dataclasses.replace(contact, name=f"{contact.name}{k:02d}")
        for k, contact in enumerate(contacts)
    ]
    return [with_hardness(contact) for contact in named]


def effort(contact: Contact) -> float:
    """Return the pixels of all members of a rung: light contacts scatter most."""
    return 2e6 * float(np.clip(0.05 / contact.share, 1.0, 6.0)) if contact.fill < 1.0 else 1e7


def solve(contact: Contact, seed: int, pixels: float, side: int) -> dict[str, Any]:
    """Solve one contact."""
    start = time.process_time()
    large, rungs = ladder.ladder(contact, pixels, side)
    stream = [seed, ord(contact.kind), int(contact.name[1:])]
    result = ladder.values(rungs, ladder.measure(contact, large, rungs, stream))
    return {"name": contact.name, "seconds": time.process_time() - start} | result


def row(contact: Contact, record: dict[str, Any]) -> dict[str, Any]:
    """Return how far the law lies from what was measured, ln, with the errors of that."""
    stress = YieldingSpectrum(contact.spectrum(), 1.0, contact.load, contact.hardness)
    unit = {"conductivity": 1.0, "diffusivity": 1.0, "friction_coefficient": contact.load}
    measured = record["flash_temperature"]
    speeds = np.array(measured["peclet"])[list(SHOWN)]
    flashes = flash.flash_temperature(
        speeds, nominal_pressure=contact.load, stress_spectrum=stress, **unit
    )
    variance = record["pressure_variance"]["value"]
    table = {key: np.array(column) for key, column in record["correlation"].items()}
    mine = persson.pressure_correlation(table["r"], stress_spectrum=stress)
    areas = {"contact": stress.contact_fraction, "yielded": stress.plastic_fraction}
    known = table["error"] < CERTAIN
    return {
        "flash": np.log(flashes / np.array(measured["value"])[list(SHOWN)]),
        "error": np.array(measured["error"])[list(SHOWN)],
        "variance": log(
            float(persson.pressure_correlation(0.0, stress_spectrum=stress)) / variance
        ),
        "curve": float(np.abs(mine - table["value"])[known].max(initial=0.0) / variance),
        "curve_error": float(table["error"][known].max(initial=0.0)),
        "contact": log(areas["contact"] / record["contact_fraction"]["value"]),
        "yielded": log(areas["yielded"] / record["yielded_fraction"]["value"]),
        "yielded_error": record["yielded_fraction"]["error"],
        "share": record["yielded_fraction"]["value"] / record["contact_fraction"]["value"],
    }


def line(contact: Contact, record: dict[str, Any]) -> str:
    """Return one line of the table."""
    found, why = row(contact, record), refused(contact)
    verdict = f"refused: {why}" if why else ""
    temperature = "/".join(f"{100 * x:+.1f}" for x in found["flash"])
    error = "/".join(f"{100 * x:.1f}" for x in found["error"])
    made = f"{contact.hurst:.2f} {contact.share:.4f} {contact.high / contact.low:5.1f} {contact.fill:7.0e}"
    return (
        f"{contact.name} {made} {temperature:>17} ± {error:12} {100 * found['variance']:+6.1f} "
        f"{100 * found['curve']:5.1f} ± {100 * found['curve_error']:4.1f} {100 * found['contact']:+6.1f} "
        f"{100 * found['yielded']:+6.1f} ± {100 * found['yielded_error']:4.1f} {found['share']:.3f} {verdict}"
    )


def refused(contact: Contact) -> str:
    """Return why the law refuses a contact; an empty text if it does not."""
    try:
        plasticity.stress_spectrum(contact.spectrum(), **contact.solid)
    except ValueError as error:
        return str(error).split(" lies")[0]
    return ""


def of_page(rows: list[tuple[Contact, Any]]) -> dict[str, float]:
    """Return how far the law is off in each kind, and in gaps that it refuses, least and most, %."""
    numbers: dict[str, float] = {}
    for name, kind, taken in (
        ("P", "P", True),
        ("L", "L", True),
        ("G", "G", True),
        ("refused", "G", False),
    ):
        chosen = [
            found
            for contact, found in rows
            if contact.kind == kind and (not refused(contact)) == taken
        ]
        for quantity in ("flash", "variance", "curve", "contact", "yielded"):
            off = 100 * np.concatenate([np.atleast_1d(found[quantity]) for found in chosen])
            numbers |= {
                f"{name}_{quantity}_least": float(off.min()),
                f"{name}_{quantity}_most": float(off.max()),
            }
    return numbers


def draw(rows: list[tuple[Contact, Any]], path: Path) -> None:
    """Draw how far T_flash of the law lies from the contacts, over the octaves of their gaps."""
    figure = Figure(figsize=(5.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for contact, found in rows:
        spectrum = contact.spectrum()
        q = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1], 2001)
        gaps = octaves_of_gaps(q, q**4 * spectrum(q), FAINT)
        axes.plot(
            [gaps] * 3,
            100 * found["flash"],
            "o-",
            color="C0" if contact.share < 0.03 else "C1",
            markersize=3,
        )
    axes.axvline(GAPS_ALLOWED[1], color="0.4", linewidth=0.8)
    axes.set(
        xlabel="octaves of gaps in C(q)",
        ylabel=r"law less measured $T_\mathrm{flash}$, %",
        title="blue: light load",
    )
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "solve three small contacts with few members")
    command.add_argument(
        "--solve", action="store_true", help="solve the contacts that have no file yet"
    )
    options = command.parse()
    folder = options.output if options.toy else MEASURED
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in (FRESH,) if options.toy else (TUNED, FRESH):
        print(
            f"seed {seed}: name, H, share, gap, fill, T_flash, g(0), g(r), contact, yielded, A_pl/A"
        )
        contacts = drawn(seed)
        for contact in contacts[:: 15 if options.toy else 1]:
            path = folder / f"{seed}-{contact.name}.json"
            if not path.exists():
                if not (options.solve or options.toy):
                    continue
                record = solve(
                    contact, seed, *((1e4, 1024) if options.toy else (effort(contact), SIDE))
                )
                path.write_text(
                    json.dumps(yielding_points.short(record), separators=(",", ":")) + "\n"
                )
            record = json.loads(path.read_text())
            print(line(contact, record), flush=True)
            rows.append((contact, row(contact, record)))
    draw(rows, options.output / "yielding_gaps.png")
    if options.evidence:
        write_evidence(
            "yielding_gaps", "python experiments/yielding_gaps.py --evidence", numbers=of_page(rows)
        )


if __name__ == "__main__":
    main()
