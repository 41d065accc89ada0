"""Does the bandwidth error hold what follows? Deep ladders of contact that yields, continued without their upper rungs.

    python experiments/bandwidth.py [--toy] [-o FOLDER]

Contacts are solved at q_c = 4, 8 … 128 q_y with four pixels per shortest wave, as plans do, many on the coarse rungs
and few on the fine ones, which share their streams; to 64 q_y only where the finest grid would have more than MOST
points per side. Then T_flash is continued to the end from rungs up to 8, 16, 32 and 64 q_y alone, as a power of q_c and
by the law for contact that yields. `seen` are contacts that DOUBT_FITTED and DOUBT_OF_LAW were set by, the last seven
drawn at random. Those of `fresh` were drawn and solved when the second of DOUBT_OF_LAW was .2; it became .15 after
that, by the others alone.

Printed is how many of the statements hold, at seven Péclet numbers each: first those of the ladder itself, whose
scatter is small, by the bandwidth error alone; then those of RUNS short ladders on streams of their own, with the
scatter of few realizations, by the bandwidth and the statistical error. What is in FOLDER is not solved again.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from script import Command
from validity_map import members
from validity_map.capped import CappedPoint, steels

import roughsim as rs
from roughsim.estimate.errors import estimate
from roughsim.estimate.ladder import Values, observe
from roughsim.observables.record import Sample
from theory import flash, plasticity

NAME, PIXELS, END, STEP = "flash_temperature", 4.0, 128.0, 0.1
DEEP = {4.0: 240, 8.0: 120, 16.0: 60, 32.0: 24, 64.0: 10, END: 4}  # q_c/q_y, and how many are solved
MOST = 4700  # points per side
SHORT, RUNS = {4.0: 16, 8.0: 6, 16.0: 4}, 24


class Contact(CappedPoint):
    """A point of the map in a cell of its own: eight waves of q_r, or four or one of the longest."""

    @property
    def periods(self) -> float:
        """Waves of q_r along a side."""
        return max(8.0, self.plateau if self.plateau > 8.0 else 4.0 * self.plateau)


SEEN = [Contact(s, 1.0, h) for h in (0.3, 0.55, 0.8) for s in (0.03, 0.25)]
SEEN += [Contact(0.1, 1.0, 0.8), Contact(0.1, 1.0, 1.0), Contact(0.01, 1.0, 0.8), Contact(0.1, 0.5, 0.65, 4.0)]
SEEN += [Contact(p.share, p.yields, p.hurst, p.plateau, p.low_exponent, label=p.label) for p in steels()]
SEEN += [Contact(0.0224, 0.448, 0.549, 3.01), Contact(0.0207, 0.575, 0.461, 3.54), Contact(0.0333, 0.31, 0.846, 3.58)]


def drawn(seed: int, count: int) -> list[Contact]:
    """Draw contacts with q_y > 1.5 q_min, whose grid to 64 q_y has no more than 2200 points per side."""
    rng, contacts = np.random.default_rng(seed), []
    while len(contacts) < count:
        hurst = round(rng.uniform(0.3, 1.0), 3)
        place = [(0.02, 0.4), (0.3, 1.1), (1.0, 5.0)]
        share, yields, plateau = (float(f"{np.exp(rng.uniform(*np.log(ends))):.3g}") for ends in place)
        contact = Contact(share, yields, hurst, plateau)
        if yields * plateau > 1.5 and contact.periods * yields * PIXELS * 64.0 <= 2200:
            contacts.append(contact)
    return contacts


def seen() -> list[Contact]:
    """Return the contacts that the errors were set by."""
    return [*SEEN, *drawn(20261126, 4)]


def fresh() -> list[Contact]:
    """Return those that were no part of that."""
    return drawn(20261124, 6)


def solve(contact: Contact, depth: float, stream: int, count: int) -> Any:
    """Return T_flash of so many members on a rung, (members, Péclet numbers)."""
    grid = contact.grid(depth * contact.yields, PIXELS)
    spectrum, solid = contact.spectrum.truncated(q_max=depth * contact.yields), rs.Solid(1.0, contact.hardness)
    rows = []
    for index in range(count):
        seed = np.random.SeedSequence(11, spawn_key=(stream, index))
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed))
        load = contact.pressures["nominal_pressure"]
        solved = rs.solve_contact(heights, grid, solid, nominal_pressure=load, tolerance=1e-4)
        rows.append(members.stress_table(solved.pressure, grid) @ members.kernels(grid)[:, : members.PECLET.size])
    return np.array(rows)


def measured(contact: Contact, folder: Path, *, runs: int, toy: bool) -> dict[str, Any]:
    """Return the members of the deep ladder and of the short ones, solved or read."""
    path = folder / f"{contact.name}.npz"
    if not path.exists():
        few = {4.0: 8, 8.0: 6, 16.0: 4} if toy else DEEP
        few = {depth: n for depth, n in few.items() if contact.grid(depth * contact.yields, PIXELS).shape[0] <= MOST}
        rows = {f"ref{depth:g}": solve(contact, depth, 0, count) for depth, count in few.items()}
        for k in range(runs):
            rows |= {f"run{k}-{depth:g}": solve(contact, depth, k + 1, count) for depth, count in SHORT.items()}
        np.savez_compressed(path, **rows)
        print(f"{contact.name} solved", flush=True)
    return dict(np.load(path))


def by_law(contact: Contact, depths: list[float]) -> Any:
    """Return T_flash by the law with C(q) up to each depth, (depths, Péclet numbers)."""
    load = contact.pressures["nominal_pressure"]
    unit = {"conductivity": 1.0, "diffusivity": 1.0, "friction_coefficient": load, "nominal_pressure": load}
    cut = [contact.spectrum.truncated(q_max=depth * contact.yields) for depth in depths]
    laws = [plasticity.stress_spectrum(spectrum, **contact.pressures, step=STEP) for spectrum in cut]
    return np.array([flash.flash_temperature(members.PECLET, **unit, stress_spectrum=law) for law in laws])


def continued(contact: Contact, rungs: dict[float, Any], end: float, *, law: bool) -> Values:
    """Return T_flash at `end` from rungs below it, as a run states it."""
    y, depths = contact.yields, list(rungs)
    samples = [
        Sample(depth * y, 64.0 * depth, np.arange(len(rows)), {NAME: rows}, np.ones(1), np.ones((len(rows), 1)), 1.0)
        for depth, rows in rungs.items()
    ]
    table = by_law(contact, [*depths[-2:], end]) if law else None
    usual = min(1.0, 0.3 + 1.05 * contact.hurst)
    return observe(NAME, samples, capped=True, end=end * y, settled=4.0 * y, usual=usual, law=table)


def truth(raw: dict[str, Any]) -> tuple[dict[float, Any], Any]:
    """Return T_flash at each rung, chained over shared members, and the relative error of the steps (95 %)."""
    depths = [depth for depth in DEEP if f"ref{depth:g}" in raw]
    values = {depths[0]: raw[f"ref{depths[0]:g}"].mean(axis=0)}
    square = np.zeros(members.PECLET.size)
    for low, high in pairwise(depths):
        fine = raw[f"ref{high:g}"]
        coarse = raw[f"ref{low:g}"][: len(fine)]
        values[high] = values[low] * fine.mean(axis=0) / coarse.mean(axis=0)
        change = fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0)
        square += change.var(axis=0, ddof=1) / len(fine) if high > 8.0 else 0.0
    return values, 1.96 * np.sqrt(square)


def exact(values: dict[float, Any], depths: list[float]) -> dict[float, Any]:
    """Return rungs without scatter."""
    return {depth: np.repeat(values[depth][None], 13, axis=0) for depth in depths}


def ladders_told(groups: dict[str, list[tuple[Contact, dict[str, Any]]]]) -> list[Any]:
    """Print how many statements of ladders without scatter hold, and return what the law leaves over."""
    left = []
    for group, contacts in groups.items():
        for top in (8.0, 16.0, 32.0, 64.0):
            for law in (False, True):
                rows = []
                for contact, raw in contacts:
                    values, _ = truth(raw)
                    end = max(values)
                    depths = [depth for depth in values if top / 4 <= depth <= top]
                    if top >= end or len(depths) < 2:
                        continue
                    result = continued(contact, exact(values, depths), end, law=law)
                    off = result.extrapolated.mean(axis=0) / values[end] - 1
                    rows.append((off, result.bandwidth / values[end], values[top] / values[end] - 1))
                if rows:
                    off, stated, follows = (np.array(x) for x in zip(*rows, strict=True))
                    held, way = np.sum(np.abs(off) <= stated), "law or power" if law else "power"
                    rms = [100 * np.sqrt(np.mean(x**2)) for x in (off, stated, follows)]
                    print(
                        f"{group:12} to {top:2g} q_y, {way:12}: {held:3d} of {off.size:3d} hold; off {rms[0]:.2f} % "
                        f"(rms; worst {100 * np.abs(off).max():.2f}), stated {rms[1]:.2f}, follows {rms[2]:.1f}"
                    )
                    left += [(group, top, off, stated)] if law else []
    return left


def runs_told(contacts: list[tuple[Contact, dict[str, Any]]]) -> None:
    """Print how many intervals of short ladders hold, by bandwidth and statistical error."""
    for top in (8.0, 16.0):
        for law in (False, True):
            held, count, errors = 0, 0, []
            for contact, raw in contacts:
                values, doubt = truth(raw)
                end, start = max(values), raw["ref4"]
                own = 1.96 * start.std(axis=0, ddof=1) / np.sqrt(len(start)) / start.mean(axis=0)
                for k in range(sum(name.endswith("-4") for name in raw)):
                    rungs = {depth: raw[f"run{k}-{depth:g}"] for depth in SHORT if depth <= top}
                    if top >= end:
                        continue
                    found = estimate(NAME, continued(contact, rungs, end, law=law))
                    error = found.total_error / values[end]
                    off = np.abs(found.mean / values[end] - 1)
                    held += int(np.sum(off <= np.sqrt(error**2 + own**2 + doubt**2)))
                    count += off.size
                    errors.append(error)
            if count:
                way = "law or power" if law else "power"
                print(
                    f"runs to {top:2g} q_y, {way:12}: {held} of {count} hold ({held / count:.1%}), "
                    f"stated {100 * np.sqrt(np.mean(np.square(errors))):.2f} % (rms)"
                )


def draw(left: list[Any], path: Path) -> None:
    """What the law or the power leaves over, against the error stated."""
    figure = Figure((5.0, 3.6), layout="constrained")
    axes = figure.add_subplot()
    for (group, top), colour in zip(
        dict.fromkeys((g, t) for g, t, *_ in left), [f"C{k % 10}" for k in range(20)], strict=False
    ):
        some = [(o, s) for g, t, o, s in left if (g, t) == (group, top)]
        off, stated = (np.concatenate([x[k].ravel() for x in some]) for k in (0, 1))
        axes.plot(100 * stated, 100 * off, ".", ms=4, color=colour, label=f"{group}, {top:g} $q_y$")
    ends = np.array([0.0, 100 * max(float(s.max()) for *_, s in left)])
    axes.fill_between(ends, -ends, ends, color="0.92", zorder=0)
    axes.set(xlabel="bandwidth error stated, %", ylabel="left over, %")
    axes.legend(frameon=False, fontsize=7, ncols=2)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "one contact up to 16 q_y")
    options = command.parse()
    groups = {"seen": [Contact(0.25, 1.0, 0.8)]} if options.toy else {"seen": seen(), "fresh": fresh()}
    solved = {}
    for group, contacts in groups.items():
        runs = 2 if options.toy else RUNS
        solved[group] = [(c, measured(c, options.output, runs=runs, toy=options.toy)) for c in contacts]
    left = ladders_told(solved)
    runs_told([pair for pairs in solved.values() for pair in pairs])
    draw(left, options.output / "bandwidth.png")


if __name__ == "__main__":
    main()
