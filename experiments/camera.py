"""The experiment of the paper, as a camera sees it: hot tracks behind the rim of a hole in the resting block.

    python experiments/camera.py [--toy] [-o FOLDER] [--evidence]

Sutter and Ranc measured steel at 35 m/s through a hole of radius 1 mm: tracks of about 200 K. Here the contact of two
steel faces is solved, the heat inside the hole is left out, and the free half-space is warmed by the rest, which is as
long as the grid. The hottest track is the highest temperature 20 µm behind the rim, over the median along the rim.

- one face: only the block with the hole is rough. Its contact stays where it is, so that exposure makes no difference.
- hole in the block: the same; no load is carried inside the hole, and the load per area outside it is the same.
- two faces: both are rough, each takes half of the heat at every point; long exposure, the mean over positions.

A point spread is a Gaussian across the tracks along the rim, and in both directions on maps. A radiance camera at
0.9 µm averages exp(−c₂/λT), and shows the temperature with this mean; the mean temperature is 973 K.
"""

from __future__ import annotations

import figures
import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d, uniform_filter1d
from script import Command, Row, Rows, show_on_pages, write_evidence

import roughsim as rs

SCENE = rs.load_scene("steel-1.2GPa")
BODY = {"conductivity": 30.0, "diffusivity": SCENE.conduction().diffusivity}
SPEED, PRESSURE, FRICTION, RADIUS = 35.0, 90e6, 0.11, 1e-3
SIDES, CENTRE = (
    (6e-3, 4e-3),
    (1.2e-3, 2e-3),
)  # of the grid and of the hole, m; heat enters from larger x
SHARE = {"one": 0.938, "hole": 0.938, "two": 0.5}
HARDNESSES = {"one": (0.5e9, 0.8e9, 1.2e9, 2e9, 3e9), "two": (0.5e9, 1.2e9, 3e9)}
BEHIND, SPREADS = (0.0, 20e-6, 100e-6), (4e-6, 19e-6, 38e-6, 70e-6)  # of the rim; FWHM; m
WIEN, BACKGROUND, HOTTEST = 1.438777e-2 / 0.9e-6, 973.0, 1e-3  # c₂/λ and T₀, K; share of a map
SLID_SHARE = 0.72  # of the moving body, point by point: experiments/two_bodies.py
SHOWN = 3  # the seed of the picture in the figure
SIGMA = 2 * np.sqrt(2 * np.log(2))  # FWHM of a Gaussian over its standard deviation


def places(grid: rs.Grid) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates of the pixels from the middle of the hole, m."""
    x, y = ((np.arange(n) + 0.5) * d for n, d in zip(grid.shape, grid.spacing, strict=True))
    return x - CENTRE[0], y - CENTRE[1]


def outside(grid: rs.Grid) -> np.ndarray:
    """Return where the resting block is."""
    x, y = places(grid)
    return np.hypot(x[:, None], y) >= RADIUS


def along_rim(field: np.ndarray, grid: rs.Grid, behind: float) -> np.ndarray:
    """Return a field at a distance behind the rim that heat enters by, over y from −.9 to .9 of the radius."""
    x, y = places(grid)
    chosen = np.flatnonzero(np.abs(y) < 0.9 * RADIUS)
    place = (np.sqrt(RADIUS**2 - y[chosen] ** 2) - behind - x[0]) / grid.spacing[0]
    before = np.floor(place).astype(int)
    part = place - before
    return (1 - part) * field[before, chosen] + part * field[before + 1, chosen]


def hottest(line: np.ndarray, pixel: float, spread: float = 0.0) -> float:
    """Return the highest value of a line over its median, K, with a point spread of this full width, m."""
    seen = gaussian_filter1d(line, spread / SIGMA / pixel) if spread else line
    return float(seen.max() - np.median(seen))


def face(spectrum: rs.SelfAffineSpectrum, grid: rs.Grid, *seed: int) -> np.ndarray:
    """Return a rough face, with four pixels in its shortest wave."""
    cut = spectrum.truncated(q_max=grid.nyquist / 2)
    return rs.synthesize(cut, grid, np.random.default_rng(seed), amplitudes="gaussian")


def pressure(kind: str, hardness: float, grid: rs.Grid, seed: int, positions: int) -> np.ndarray:
    """Return the pressure of a picture, Pa; of two faces the mean over positions of the moving one."""
    solid = rs.Solid(SCENE.effective_modulus, hardness)
    load = {"nominal_pressure": PRESSURE, "tolerance": 3e-3}
    if kind == "two":
        resting, moving = (face(side, grid, seed, k) for k, side in enumerate(SCENE.sliding_faces))
        shift = grid.shape[0] // positions
        total, contact = np.zeros(grid.shape), None
        for k in range(positions):
            heights = resting + np.roll(moving, -k * shift, axis=0)
            contact = rs.solve_contact(heights, grid, solid, start=contact, **load)
            total += contact.pressure
        return total / positions
    heights = face(SCENE.spectrum, grid, seed)
    if kind == "hole":
        heights = np.where(outside(grid), heights, -1e-3)  # deeper than all that touches
        load["nominal_pressure"] *= outside(grid).mean()
    return rs.solve_contact(heights, grid, solid, **load).pressure


def rise(stress: np.ndarray, grid: rs.Grid, share: float) -> np.ndarray:
    """Return the steady temperature of the moving face above its interior, K."""
    return rs.half_space_temperature(share * FRICTION * SPEED * stress, grid, speed=SPEED, **BODY)


def picture(kind: str, hardness: float, grid: rs.Grid, seed: int, positions: int) -> np.ndarray:
    """Return the temperature with heat outside the hole alone, K."""
    stress = pressure(kind, hardness, grid, seed, positions)
    return rise(stress * outside(grid), grid, SHARE[kind])


def tracks(kind: str, hardness: float, grid: rs.Grid, seed: int, positions: int) -> Row:
    """Return the hottest track of a picture, K, by its distance behind the rim and by point spread, µm."""
    field, pixel = picture(kind, hardness, grid, seed, positions), grid.spacing[1]
    row: Row = {f"behind {1e6 * d:g}": hottest(along_rim(field, grid, d), pixel) for d in BEHIND}
    line = along_rim(field, grid, BEHIND[1])
    row |= {f"spread {1e6 * s:g}": hottest(line, pixel, s) for s in SPREADS}
    above = np.flatnonzero(line - np.median(line) > hottest(line, pixel) / 2)
    peak = np.flatnonzero(above == line.argmax())[0]
    steps = np.diff(above, prepend=-9, append=line.size + 9) > 1
    first, last = steps[: peak + 1].nonzero()[0][-1], peak + steps[peak + 1 :].nonzero()[0][0]
    row["width"] = 1e6 * pixel * (above[last] - above[first] + 1)
    warm = rise(np.where(outside(grid), PRESSURE, 0.0), grid, SHARE[kind])
    row["variance"] = float(np.mean((line - along_rim(warm, grid, BEHIND[1])) ** 2))
    return row


def radiance_reading(field: np.ndarray, seen: np.ndarray, blur) -> float:
    """Return by how much the hottest part of a picture by radiance is hotter than that of the blurred T, less 1."""
    reading = -WIEN / np.log(blur(np.exp(-WIEN / (BACKGROUND + field)))) - BACKGROUND
    count = max(1, round(HOTTEST * field.size))
    most = [np.partition(each.ravel(), -count)[-count:].mean() for each in (reading, seen)]
    return float(most[0] / most[1] - 1.0)


def readings(grid: rs.Grid, seed: int) -> Row:
    """Return what radiance adds to the hottest part of a map of the contact of one rough face, by blur in µm."""
    stress = pressure("one", 1.2e9, grid, seed, 1)
    flux = SHARE["one"] * FRICTION * SPEED * stress
    field = rs.sliding_temperature(flux, grid, speed=SPEED, **BODY)
    spreads = {f"{1e6 * s:g}": s / SIGMA / grid.spacing[0] for s in SPREADS[:3]}
    ways = {
        name: lambda map_, s=s: gaussian_filter(map_, s, mode="wrap") for name, s in spreads.items()
    }
    pixels = round(1e-3 / grid.spacing[0])
    ways["exposure"] = lambda map_: uniform_filter1d(map_, pixels, axis=0, mode="wrap")
    return {name: radiance_reading(field, blur(field), blur) for name, blur in ways.items()}


def mean_of(rows: list[Row], key: str) -> tuple[float, float, float]:
    """Return mean, standard error and scatter between pictures."""
    values = np.array([row[key] for row in rows], float)
    scatter = float(values.std(ddof=1))
    return float(values.mean()), scatter / np.sqrt(values.size), scatter


def through_hole(field: np.ndarray, grid: rs.Grid, spread: float) -> np.ndarray:
    """Return the square around the hole as seen: K over the median 20 µm behind the rim, NaN where the block is."""
    hole, sigma = ~outside(grid), [spread / SIGMA / d for d in grid.spacing]
    seen = gaussian_filter(field * hole, sigma) / np.maximum(
        gaussian_filter(1.0 * hole, sigma), 0.1
    )
    seen = np.where(hole, seen - np.median(along_rim(field, grid, BEHIND[1])), np.nan)
    x, y = (np.abs(place) < RADIUS for place in places(grid))
    return seen[np.ix_(x, y)]


def numbers_of(found: dict[tuple[str, float], list[Row]], radiance: list[Row]) -> dict[str, float]:
    """Return the numbers of docs/camera.md: K, GPa, per cent."""
    numbers: dict[str, float] = {}
    for (kind, hardness), rows in found.items():
        name = f"{kind}_{hardness / 1e9:g}"
        numbers[f"{name}_rms"] = float(np.sqrt(mean_of(rows, "variance")[0]))
        for key in rows[0]:
            mean, error, scatter = mean_of(rows, key)
            stem = f"{name}_{key.replace(' ', '_')}"
            numbers |= {stem: mean, f"{stem}_error": error, f"{stem}_scatter": 100 * scatter / mean}
    for kind, hardnesses in HARDNESSES.items():
        hot = [numbers[f"{kind}_{h / 1e9:g}_behind_20"] for h in hardnesses]
        power, first = np.polyfit(np.log(np.array(hardnesses) / 1e9), np.log(hot), 1)
        numbers |= {f"{kind}_power": power, f"{kind}_at_200": np.exp((np.log(200) - first) / power)}
        scatter = numbers[f"{kind}_1.2_behind_20_scatter"]
        numbers[f"{kind}_hardness_scatter"] = scatter / power
    numbers["one_slid"] = SLID_SHARE / SHARE["one"] * numbers["one_1.2_behind_20"]
    for key in radiance[0]:
        mean, error, _ = mean_of(radiance, key)
        numbers |= {f"radiance_{key}": 100 * mean, f"radiance_{key}_error": 100 * error}
    return numbers


def table_of(found: dict[tuple[str, float], list[Row]]) -> list[list[str]]:
    """Return the table of the hottest track at 1.2 GPa."""
    heads = ["", "at the rim", "20 µm behind", "100 µm behind", "20 µm, FWHM 19 µm", "FWHM 70 µm"]
    keys = "behind 0", "behind 20", "behind 100", "spread 19", "spread 70"
    names = {"one": "one rough face, share .938", "hole": "the same, no load in the hole"}
    names["two"] = "two rough faces, half of the heat, long exposure"
    table = [heads]
    for kind, name in names.items():
        means = [mean_of(found[kind, 1.2e9], key) for key in keys]
        table.append([name, *(f"{mean:.0f} ± {error:.0f}" for mean, error, _ in means)])
    return table


def main() -> None:
    options = Command(__file__, __doc__).parse()
    points, pictures, positions = (128, 3, 4) if options.toy else (1024, 48, 48)
    grids = {n: rs.Grid((3 * n // 2, n), SIDES) for n in (points, points // 2)}
    fine, coarse = grids.values()
    rows = Rows(options.output / f"pictures-{points}.json", resume=True)
    found: dict[tuple[str, float], list[Row]] = {}
    cases = [("one", h) for h in HARDNESSES["one"]] + [("hole", 1.2e9)]
    cases += [("two", h) for h in HARDNESSES["two"]]
    for kind, hardness in cases:
        grid = coarse if kind == "two" else fine
        count = max(2, pictures // 6) if kind == "two" else pictures
        found[kind, hardness] = [
            rows.once(
                f"{kind} {hardness:g}",
                str(seed),
                lambda case=(kind, hardness, grid, seed, positions): tracks(*case),
            )
            for seed in range(count)
        ]
        mean, error, scatter = mean_of(found[kind, hardness], "behind 20")
        print(
            f"{kind}, {hardness / 1e9:g} GPa: {mean:.0f} ± {error:.0f} K, {scatter:.0f} K apart",
            flush=True,
        )
    square = rs.Grid((2 * points, 2 * points), (SIDES[1], SIDES[1]))
    radiance = [
        rows.once("hottest", str(seed), lambda seed=seed: readings(square, seed))
        for seed in range(max(2, pictures // 6))
    ]
    table, numbers = table_of(found), numbers_of(found, radiance)
    print(*("  ".join(row) for row in table), sep="\n")
    print(*(f"{name}: {value:.4g}" for name, value in numbers.items()), sep="\n")
    path = options.output / "camera.png"
    hot = {
        kind: [(h, *mean_of(found[kind, h], "behind 20")[::2]) for h in hardnesses]
        for kind, hardnesses in HARDNESSES.items()
    }
    one = picture("one", 1.2e9, fine, SHOWN, 1)
    maps = {
        f"one rough face, {1e6 * s:g} µm": through_hole(one, fine, s) for s in (4e-6, 19e-6, 70e-6)
    }
    two = picture("two", 1.2e9, coarse, SHOWN, positions)
    maps["two rough faces, 4 µm"] = through_hole(two, coarse, 4e-6)
    figures.camera(maps, hot, RADIUS, path)
    if options.evidence:
        command = "python experiments/camera.py --evidence"
        write_evidence("camera", command, numbers=numbers, tables={"tracks": table})
        show_on_pages(path)


if __name__ == "__main__":
    main()
