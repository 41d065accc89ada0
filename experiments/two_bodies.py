"""Two rough bodies that slide over one another, against the frozen contact: flash temperature, share, backgrounds.

    python experiments/two_bodies.py [--toy] [-o FOLDER] [--solve [CASE ...]] [--evidence]

The steel scenes, whose two faces are equally rough. A part f of C(q) rides with the moving body. Each member is one
slide over `Case.distance` at all speeds; it is kept in experiments/reference/two_bodies, and --solve computes those
that are missing (minutes each). Without it, tables and figures come from what is kept. Printed is T_flash of the
sliding bodies, that of `theory.two_bodies`, and the ratio to the frozen contact of the same positions, which all the
heat enters on the moving side.
--toy solves one small slide.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from figures.style import SPEEDS as COLOURS
from figures.style import new_figure
from script import EVIDENCE, Command, show_on_pages, write_evidence

import roughsim as rs
from roughsim.sliding.stepping import NUMBERS
from roughsim.store.disk import place_bytes
from roughsim.surface.synthesis import synthesize
from theory import two_bodies

KEPT = Path(__file__).parent / "reference" / "two_bodies"
SPEEDS = (1.0, 5.0, 35.0, 100.0)
STEEL = rs.Body(conductivity=30.0, diffusivity=30.0 / (7900.0 * 500.0))
CELL = 3.957912004522574e-3  # m, the cell of the plans of these scenes
BINS = 24  # of the slid distance, in geometric sequence
LIVES = (0.1, 0.25, 0.5, 0.75, 0.9, 0.99)  # shares of the spots that have died by then
LONG, SHORTER = (
    16e-3,
    (1 / 16, 1 / 8, 1 / 4, 1 / 2),
)  # m; parts of it from which slides are continued
SEED = 4100
TOLERANCE = 3e-3  # of the contacts
PAGE_HEADS = [
    "hardness",
    "T_flash, both rough, K",
    "one rough, K",
    "both / one",
    "contact temperature, both, K",
    "one rough, K",
]


@dataclass(frozen=True)
class Case:
    """Members that differ by their surfaces only."""

    hardness: str  # "1.2" of steel-1.2GPa
    part: float = 0.5  # f
    q_max: float = 1e5  # 1/m
    points: int = 256
    distance: float = 16e-3  # m
    members: int = 8
    steps: int | None = None

    @property
    def name(self) -> str:
        """Of its files."""
        stride = f"-{self.steps}steps" if self.steps else ""
        return f"{self.hardness}GPa-f{self.part:g}-q{self.q_max:.0e}-{self.points}-{1e3 * self.distance:g}mm{stride}"


CASES = (
    *(Case(hardness, part) for hardness in ("1.2", "0.5", "2.0") for part in (0.5, 0.0)),
    *(
        Case(hardness, q_max=2e5, points=512, distance=4e-3, members=3)
        for hardness in ("1.2", "0.5", "2.0")
    ),
    Case("1.2", part=0.1),
    *(
        Case("1.2", part, points=512, distance=4e-3, members=3) for part in (0.5, 0.0)
    ),  # finer grid, and so finer steps
    Case("1.2", distance=4e-3, steps=128, members=3),  # two pixels a step
)
TOY = Case("1.2", q_max=4e4, points=64, distance=2e-3, members=1)


def member(case: Case, index: int) -> dict[str, list]:
    """Slide one pair of surfaces: means over bins of the slid distance."""
    scene = rs.load_scene(f"steel-{case.hardness}GPa")
    grid = rs.Grid((case.points, case.points), (CELL, CELL))
    spectrum = scene.spectrum.truncated(q_max=case.q_max)
    streams = np.random.SeedSequence(SEED, spawn_key=(index,)).spawn(
        2
    )  # the same waves at every cut-off
    resting, moving = (
        synthesize(spectrum, grid, np.random.default_rng(stream)) for stream in streams
    )
    slid = rs.slide(
        np.sqrt(1 - case.part) * resting,
        grid,
        rs.Solid(scene.effective_modulus, scene.penetration_hardness),
        nominal_pressure=scene.sliding.nominal_pressure,
        friction_coefficient=0.11,
        speed=SPEEDS,
        moving=STEEL,
        resting=STEEL,
        counter_heights=np.sqrt(case.part) * moving if case.part else None,
        slid_distance=case.distance,
        steps=case.steps,
        tolerance=TOLERANCE,
    )
    distances = slid.slid_distance
    edges = edges_of(distances[0], distances[-1])
    place = np.digitize(distances, edges) - 1
    used = np.unique(place)

    def binned(values: np.ndarray) -> list:
        """Means over the bins of what has an entry for each step."""
        return (
            np.stack([values[..., place == k].mean(axis=-1) for k in used], axis=-1)
            .round(6)
            .tolist()
        )

    # how far they have slid when so many of the spots have died; NaN if fewer do, as over a flat
    lives = [min(distances[slid.spot_survival <= 1 - share], default=np.nan) for share in LIVES]
    return {
        "slid_distance": [float(np.mean(distances[place == k])) for k in used],
        **{name: binned(getattr(slid, name)) for name in NUMBERS},
        "contact_fraction": binned(slid.contact_fraction),
        "stress_correlation": binned(slid.stress_correlation),
        "life_of_spots": lives,  # m, of 4 pixels or more
        "frozen_flash_temperature": slid.frozen_flash_temperature.mean(axis=-1).round(6).tolist(),
    }


def kept(case: Case, folder: Path) -> list[dict[str, np.ndarray]]:
    """Return the members that are there."""
    paths = sorted((folder / case.name).glob("*.json"))
    return [
        {name: np.array(v) for name, v in json.loads(path.read_text("utf-8")).items()}
        for path in paths
    ]


def solve(case: Case, folder: Path, most: int) -> None:
    """Compute and keep the members that are missing, of the first `most`."""
    for index in range(min(case.members, most)):
        path = folder / case.name / f"{index}.json"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            place_bytes(path, json.dumps(member(case, index)).encode())
            print(f"{case.name}: member {index}", flush=True)


def edges_of(first: float, last: float) -> np.ndarray:
    """Edges of the bins of the slid distance, from its first step to its last, m."""
    return np.geomspace(first * 0.99, last * 1.01, BINS + 1)


def late(
    case: Case, member: dict[str, np.ndarray], name: str, distance: float | None = None
) -> np.ndarray:
    """Return the mean of a number over the last half of the distance, or of a shorter one, for each speed."""
    end = distance or case.distance
    edges = edges_of(member["slid_distance"][0], case.distance)
    used = np.digitize(member["slid_distance"], edges) - 1
    # each bin counts by the part of it that lies in that half
    inside = np.minimum(edges[1:], end) - np.maximum(edges[:-1], end / 2)
    return np.average(member[name], axis=-1, weights=np.maximum(inside, 0.0)[used])


def mean_and_error(values: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean, and its standard error (NaN for one member)."""
    many = np.array(values)
    spread = many.std(axis=0, ddof=1) if len(values) > 1 else np.full(many.shape[1:], np.nan)
    return many.mean(axis=0), spread / np.sqrt(len(values))


def theory(case: Case, distance: float) -> np.ndarray:
    """T_flash of `theory.two_bodies` at each speed, K: mean over the last half of a distance."""
    scene = rs.load_scene(f"steel-{case.hardness}GPa")
    points, weights = np.polynomial.legendre.leggauss(3)
    slid = two_bodies.sliding_temperatures(
        SPEEDS,
        scene.spectrum.truncated(q_max=case.q_max),
        effective_modulus=scene.effective_modulus,
        nominal_pressure=scene.sliding.nominal_pressure,
        penetration_hardness=scene.penetration_hardness,
        friction_coefficient=0.11,
        conductivity=STEEL.conductivity,
        diffusivity=STEEL.diffusivity,
        moving_roughness=case.part,
        slid_distance=distance * (3 + points[:, None]) / 4,
    )
    return weights @ slid.flash_temperature / 2


def table(case: Case, members: list[dict[str, np.ndarray]]) -> list[str]:
    """Return the lines of the means over the last half of the distance."""
    expected = theory(case, case.distance)
    lines = ["", f"{case.name}, {len(members)} members, last half of the distance"]
    ratio = mean_and_error(
        [late(case, m, "flash_temperature") / m["frozen_flash_temperature"] for m in members]
    )
    share = mean_and_error([late(case, m, "moving_share") for m in members])
    flash, background, total = (
        mean_and_error([late(case, m, name) for m in members])
        for name in ("flash_temperature", "background", "contact_temperature")
    )
    for k, speed in enumerate(SPEEDS):
        lines.append(
            f"{speed:5g} m/s  T_flash {flash[0][k]:7.2f} ± {flash[1][k]:.2f} K, theory {expected[k]:.2f} K, "
            f"over frozen {ratio[0][k]:.3f} ± {ratio[1][k]:.3f}, share {share[0][k]:.3f}, "
            f"background {background[0][k]:.1f} K, contact {total[0][k]:.1f} ± {total[1][k]:.1f} K"
        )
    return lines


def continued(
    results: dict[Case, list[dict[str, np.ndarray]]],
) -> tuple[list[str], dict[str, float]]:
    """Return how well the theory continues slides to a longer distance and to a higher cut-off, and without it.

    As lines, and as numbers: rms and worst of the continued ones, %.
    """
    changes: dict[
        str, list[tuple[np.ndarray, np.ndarray]]
    ] = {}  # of ln T_flash over the true one: as it is, continued
    for case, members in results.items():
        if case.distance == LONG and case.steps is None:
            whole = np.mean([late(case, m, "flash_temperature") for m in members], axis=0)
            for part in SHORTER:
                distance = part * LONG
                short = np.mean(
                    [late(case, m, "flash_temperature", distance) for m in members], axis=0
                )
                change = theory(case, LONG) / theory(case, distance)
                name = f"from {1e3 * distance:g} to {1e3 * LONG:g} mm"
                changes.setdefault(name, []).append(
                    (np.log(short / whole), np.log(short * change / whole))
                )
        higher = replace(case, q_max=2 * case.q_max)
        if higher in results:
            first, second = (
                np.mean([late(one, m, "flash_temperature") for m in results[one]], axis=0)
                for one in (case, higher)
            )
            change = theory(higher, case.distance) / theory(case, case.distance)
            name = f"from q_max = {case.q_max:.0e} to {higher.q_max:.0e} 1/m"
            changes.setdefault(name, []).append(
                (np.log(first / second), np.log(first * change / second))
            )
    lines, numbers = [], {}
    for name, values in changes.items():
        sizes = [(np.sqrt(np.mean(x**2)), np.abs(x).max()) for x in np.stack(values, axis=1)]
        words = [f"rms {rms:.1%}, worst {worst:.1%}" for rms, worst in sizes]
        lines.append(f"{name}: T_flash as it is {words[0]}; continued by the theory {words[1]}")
        key = name.replace(" ", "_")
        numbers |= {f"{key}_rms": 100 * sizes[1][0], f"{key}_worst": 100 * sizes[1][1]}
    return lines, numbers


def rows_of_page(
    results: dict[Case, list[dict[str, np.ndarray]]],
) -> tuple[list[list[str]], dict[str, float]]:
    """Return the table of docs/sliding.md, both faces rough beside one, at 35 m/s, and the numbers of its text."""
    rows, numbers = [PAGE_HEADS], {}
    fast, k = SPEEDS.index(35.0), SPEEDS.index(1.0)
    for hardness in ("0.5", "1.2", "2.0"):
        both, one = (
            {
                name: np.mean([late(case, m, name) for m in results[case]], axis=0)
                for name in ("flash_temperature", "contact_temperature", "moving_share")
            }
            for case in (Case(hardness), Case(hardness, 0.0))
        )
        ratio = both["flash_temperature"] / one["flash_temperature"]
        cells = [f"{each['flash_temperature'][fast]:.1f}" for each in (both, one)]
        contact = [f"{each['contact_temperature'][fast]:.0f}" for each in (both, one)]
        rows.append([f"{hardness} GPa", *cells, f"{ratio[fast]:.2f}", *contact])
        numbers |= {
            f"{hardness}GPa_slow_ratio": ratio[k],
            f"{hardness}GPa_share": one["moving_share"][fast],
        }
        cooler = 1 - both["contact_temperature"] / one["contact_temperature"]
        numbers |= {
            f"{hardness}GPa_cooler_least": 100 * cooler.min(),
            f"{hardness}GPa_cooler_most": 100 * cooler.max(),
        }
    return rows, numbers


def of_theory(results: dict[Case, list[dict[str, np.ndarray]]]) -> dict[str, float]:
    """Return T_flash of the theory over that of all slides: rms, least and most, %."""
    logs = np.concatenate(
        [
            np.log(
                theory(case, case.distance)
                / np.mean([late(case, m, "flash_temperature") for m in members], axis=0)
            )
            for case, members in results.items()
        ]
    )
    off = 100 * np.expm1(logs)
    rms = 100 * np.sqrt(np.mean(logs**2))
    return {
        "temperatures": logs.size,
        "theory_rms": rms,
        "theory_least": off.min(),
        "theory_most": off.max(),
    }


def of_half_the_pixel(results: dict[Case, list[dict[str, np.ndarray]]]) -> dict[str, float]:
    """Return how much half the pixel changes T_flash, least and most over the speeds, and both/one at most, in %."""
    flash = {}
    for part in (0.5, 0.0):
        fine, coarse = Case("1.2", part, points=512, distance=4e-3, members=3), Case("1.2", part)
        count = len(results[fine])  # the same surfaces on both grids
        flash[part] = [
            np.mean(
                [late(case, m, "flash_temperature", fine.distance) for m in results[case][:count]],
                axis=0,
            )
            for case in (fine, coarse)
        ]
    changes = {part: 100 * (fine / coarse - 1) for part, (fine, coarse) in flash.items()}
    ratio = 100 * ((1 + changes[0.5] / 100) / (1 + changes[0.0] / 100) - 1)
    every = np.concatenate(list(changes.values()))
    return {
        "pixel_least": every.min(),
        "pixel_most": every.max(),
        "pixel_ratio": np.abs(ratio).max(),
    }


def draw(results: dict[Case, list[dict[str, np.ndarray]]], path: Path) -> None:
    """Draw T_flash over the frozen one, with the distance: a panel for each hardness, a line for each speed."""
    longest = max(case.distance for case in results)
    panels = [
        case
        for case in results
        if case.part == 0.5 and case.steps is None and case.distance == longest
    ]
    panels.sort(key=lambda case: case.hardness)
    with new_figure(path, 4.9) as figure:
        grid = list(figure.subplots(2, 2, sharey=True).flat)
        for axes, case in zip(grid, panels, strict=False):
            for part, style in ((0.5, "-"), (0.0, "--")):
                members = results.get(replace(case, part=part), [])
                for k, colour in enumerate(COLOURS if members else ()):
                    ratios = [
                        m["flash_temperature"][k] / m["frozen_flash_temperature"][k]
                        for m in members
                    ]
                    mean, error = mean_and_error(ratios)
                    distance, label = (
                        1e3 * members[0]["slid_distance"],
                        f"{SPEEDS[k]:g} m/s" if part else None,
                    )
                    axes.semilogx(distance, mean, style, color=colour, label=label)
                    axes.fill_between(
                        distance, mean - 2 * error, mean + 2 * error, alpha=0.2, color=colour, lw=0
                    )
            axes.axhline(1.0, color="0.6", lw=0.8)
            axes.set(
                title=f"steel, hardness {case.hardness} GPa",
                xlabel="slid distance (mm)",
                ylim=(0.0, None),
            )
            axes.set_xticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
        for style, label in (("-", "both faces rough"), ("--", "resting face rough")):
            grid[0].plot([], [], style, color="0.4", label=label)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        figure.supylabel(
            r"$T_\mathrm{flash}$ over frozen contact, all heat in one body", fontsize=9
        )
        handles, labels = grid[0].get_legend_handles_labels()
        grid[3].legend(handles, labels, loc="center")


def main() -> None:
    command = Command(__file__, __doc__, "one small slide")
    command.add_argument(
        "--solve", nargs="*", metavar="CASE", help="compute missing members, of all cases or these"
    )
    command.add_argument("--members", type=int, default=8, help="at most so many of each case: 8")
    options = command.parse()
    cases, folder = ((TOY,), options.output) if options.toy else (CASES, KEPT)
    if options.toy:
        solve(TOY, folder, 1)
    elif options.solve is not None:
        for case in cases:
            if not options.solve or case.name in options.solve:
                solve(case, folder, options.members)
    results = {case: members for case in cases if (members := kept(case, folder))}
    lines = [line for case, members in results.items() for line in table(case, members)]
    more, numbers = continued(results)
    text = "\n".join([*lines, "", *more])
    print(text)
    draw(results, options.output / "two_bodies.png")
    if options.evidence:
        show_on_pages(options.output / "two_bodies.png")
        (EVIDENCE.parent / "reference" / "two_bodies.txt").write_text(f"{text}\n")
        rows, more_numbers = rows_of_page(results)
        numbers |= more_numbers | of_theory(results) | of_half_the_pixel(results)
        command_line = "python experiments/two_bodies.py --evidence"
        write_evidence("two_bodies", command_line, tables={"steels": rows}, numbers=numbers)


if __name__ == "__main__":
    main()
