"""How often the ± of the exponents ∂ln/∂ln of a study holds the truth: many small studies against a long one.

    python experiments/trends.py [--toy] [-o FOLDER] [--studies N] [--long N] [--evidence]

Each study varies one number of a rough steel on small grids. Its runs end with 16 realizations of the lower level, or
with "target" at a total error of 6 % of T_flash, of which that of the small cell is a part. C(q) ends at the higher
level; with "cut" it goes on six times as far. The long study has the same levels and other surfaces, so that both have
the same cut-off, pixel and cell: the ± does not have their errors. Printed is how many of the intervals hold its
exponent, how much the exponents scatter, and their mean ±. Studies in FOLDER are not computed again. --toy makes four
studies of one kind.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command, write_evidence

import roughsim as rs

FIRST_SEED, LONG_SEED = 4000, 90002
LOADS = {"sliding.nominal_pressure": ["20 MPa", "60 MPa", "180 MPa"]}
VARY = {
    "load": LOADS,
    "load, target": LOADS,
    "hardness": {"body.penetration_hardness": ["1 GPa", "2 GPa"]},
    "load, cut": LOADS,
}
NAMES = ("flash_temperature", "contact_fraction")


def base(name: str) -> rs.Scene:
    """The scene of the small studies."""
    demo = rs.load_scene("demo")
    side = 1.6e-3
    top = np.pi * 64 / side / 2  # two pixels per half wave at the finer level
    levels = [
        {"column": "capped", "shape": [32, 32], "q_max": top / 2},
        {"column": "capped", "shape": [64, 64], "q_max": top},
    ]
    surface = replace(demo.surface, rms_height=0.6e-6, q_min=2 * np.pi / side, q_roll_off=1.2e4)
    surface = replace(surface, q_max=4e5 if name.endswith("cut") else top)
    numerics = replace(demo.numerics, levels=levels, lengths=(side, side), keep_fields=0)
    until = {"flash_temperature": 0.06} if name.endswith("target") else {}
    ensemble = replace(demo.ensemble, until=until, max_realizations=200 if until else 16)
    return replace(demo, surface=surface, numerics=numerics, ensemble=ensemble)


def exponents(name: str, folder: Path, seed: int, most: int | None = None) -> dict[str, np.ndarray]:
    """Return exponent and ± of each trend of one study, shape (trends, 2), by observable and end of the trend."""
    scene = base(name)
    until = scene.ensemble.until if most is None else {}
    count = most or scene.ensemble.max_realizations
    scene = replace(
        scene, ensemble=replace(scene.ensemble, seed=seed, until=until, max_realizations=count)
    )
    study = rs.study(
        scene,
        vary=VARY[name],
        folder=folder / f"{name.replace(', ', '-').replace(' ', '-')}-{seed}",
    )
    result: dict[str, list[tuple[float, float]]] = {}
    for observable in NAMES:
        for trend in study.trends(observable):
            speed = "" if trend["speed"] is None else f" at {trend['speed']:g} m/s"
            words = f"{observable}{speed}, {trend['from']:g} → {trend['to']:g}"
            result.setdefault(words, []).append((trend["exponent"], trend["exponent_error"]))
    return {words: np.array(pairs) for words, pairs in result.items()}


def told(name: str, folder: Path, studies: int, most: int) -> np.ndarray:
    """Print the coverage of each trend, and return the deviations in ±, shape (trends, studies)."""
    truth = exponents(name, folder, LONG_SEED, most)
    small = [exponents(name, folder, seed) for seed in range(FIRST_SEED, FIRST_SEED + studies)]
    off = []
    for words, ((exact, exact_error),) in truth.items():
        found, error = np.array([each[words][0] for each in small]).T
        off.append((found - exact) / error)
        held = np.count_nonzero(np.abs(off[-1]) <= 1.0)
        print(
            f"{name:13s} {words:48s} {held:4d} of {studies} hold {exact:+.4f} ± {exact_error:.4f}; "
            f"off {(found - exact).mean():+.4f}, scatter {found.std(ddof=1):.4f}, ± {error.mean():.4f}",
            flush=True,
        )
    held = np.count_nonzero(np.abs(off) <= 1.0)
    print(
        f"{name:13s} all: {100 * held / np.size(off):.1f} % of {np.size(off)} hold it", flush=True
    )
    return np.array(off)


def chart(results: dict[str, np.ndarray], path: Path) -> None:
    figure = Figure((6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.axhspan(-1, 1, color="0.93")
    for number, off in enumerate(results.values()):
        axes.plot(number + np.linspace(-0.3, 0.3, off.size), off.ravel(), ".", ms=2)
    axes.set(
        ylabel="(exponent − that of the long study)/±",
        xticks=range(len(results)),
        xticklabels=list(results),
    )
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "four studies")
    command.add_argument("--studies", type=int, default=20, help="small studies of each kind")
    command.add_argument("--long", type=int, default=400, help="realizations of the long study")
    options = command.parse()
    studies, most = (4, 40) if options.toy else (options.studies, options.long)
    names = list(VARY)[:1] if options.toy else list(VARY)
    results = {name: told(name, options.output, studies, most) for name in names}
    chart(results, options.output / "trends.png")
    if options.evidence:
        # a study has a trend of T_flash at three speeds for each of the area
        parts = {
            "flash": [off[: 3 * len(off) // 4] for off in results.values()],
            "area": [
                off[3 * len(off) // 4 :] for name, off in results.items() if "cut" not in name
            ],
            "cut": [off[3 * len(off) // 4 :] for name, off in results.items() if "cut" in name],
        }
        numbers = {}
        for name, offs in parts.items():
            every = np.concatenate(offs).ravel()
            numbers[name] = every.size
            numbers[f"{name}_hold"] = int(np.count_nonzero(np.abs(every) <= 1.0))
        write_evidence("trends", "python experiments/trends.py --evidence", numbers=numbers)


if __name__ == "__main__":
    main()
