"""The law for pictures of a camera, beside pictures of simulated contacts that it has not met.

    python experiments/camera_law.py [--toy] [-o FOLDER] [--evidence]

Contacts are drawn, elastic and yielding, in three kinds of pictures: of the contact through a point spread, the same
with an exposure, and of a line behind the straight edge of a contact as long as half the cell. Each is solved for
several surfaces with the same C(q), and its pictures are taken in real space: a Gaussian filter, and a mean along
sliding. The law has the calibrated stress spectrum of the same waves and the same slid distance. Scenes outside its
range are drawn again. Printed: rms of the picture by the law over that of all surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt
from pathlib import Path

import numpy as np
from figures.style import BLUE, GREEN, ORANGE, new_figure
from scipy.ndimage import gaussian_filter, gaussian_filter1d, uniform_filter1d
from script import Command, Row, Rows, write_evidence

import roughsim as rs
from theory import camera, persson, plasticity

SEED, CONTACTS, SURFACES = 600, 15, 24
SIGMA = 2 * sqrt(2 * np.log(2))  # FWHM of a Gaussian over its standard deviation
KINDS = {"blurred": BLUE, "exposed": ORANGE, "behind": GREEN}  # pictures, and their colours


@dataclass(frozen=True)
class Drawn:
    """A contact and its camera; lengths in m, SI."""

    kind: str
    spectrum: rs.SelfAffineSpectrum
    waves: int  # longest waves along a side
    pixels: int  # per shortest wave
    modulus: float
    pressure: float
    hardness: float
    speed: float
    body: dict[str, float]
    resolution: float
    smear: float
    behind: float

    @property
    def grid(self) -> rs.Grid:
        """The cell, with about as many pixels per shortest wave as asked for."""
        q_min, *_, q_max = self.spectrum.breaks
        points = 16 * round(self.pixels * self.waves * q_max / q_min / 16)
        side = self.waves * 2 * pi / q_min
        return rs.Grid((points, points), (side, side))

    def stress_spectrum(self):
        """Return the calibrated |σ_q|²; ValueError outside its range."""
        load = {"effective_modulus": self.modulus, "nominal_pressure": self.pressure}
        if self.hardness == inf:
            return persson.calibrated_spectrum(self.spectrum, **load)
        return plasticity.stress_spectrum(self.spectrum, penetration_hardness=self.hardness, **load)


def draw(rng: np.random.Generator, kind: str, *, elastic: bool) -> Drawn:
    """Return a contact with a camera."""

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    q_min, rolled, band = log(3e3, 3e4), log(1.5, 4.0), log(4.0, 8.0) if elastic else log(6.0, 16.0)
    q_roll_off, exponent = rolled * q_min, float(rng.choice([0.0, 1.5]))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        log(0.02, 0.3),
        hurst=rng.uniform(0.4, 1.0),
        q_min=q_min,
        q_roll_off=q_roll_off,
        q_max=band * q_roll_off,
        roll_off_exponent=exponent,
    )
    modulus, load = log(5e9, 3e11), log(0.02, 0.15)
    pressure = load * modulus * spectrum.rms_slope
    hardness = inf if elastic else pressure / log(0.02, 0.3)
    conductivity, diffusivity = log(1.0, 100.0), log(1e-6, 5e-5)
    wave = 2 * pi / q_roll_off
    behind = log(0.02, 0.3) * wave
    peclet = log(100.0, 1000.0) if kind == "behind" else log(0.3, 300.0)  # v/(D q_r)
    return Drawn(
        kind=kind,
        spectrum=spectrum,
        waves=4,
        pixels=8 if elastic else 4,
        modulus=modulus,
        pressure=pressure,
        hardness=hardness,
        speed=peclet * diffusivity * q_roll_off,
        body={"conductivity": conductivity, "diffusivity": diffusivity},
        resolution=log(0.03, 0.4) * wave,
        smear=log(0.1, 2.0) * wave,
        behind=behind,
    )


def contacts(seed: int, count: int) -> list[Drawn]:
    """Return as many contacts as asked for, each within the range of the law; kinds and yielding take turns."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        k = len(found)
        one = draw(rng, list(KINDS)[k % 3], elastic=k % 2 == 0)
        try:
            one.stress_spectrum()
        except ValueError:
            continue
        if one.kind != "behind" or one.speed * view(one).behind > 5 * one.body["diffusivity"]:
            found.append(one)
    return found


def mean_square(one: Drawn, pressure: np.ndarray) -> float:
    """Return the mean square of a picture of this pressure for μ = 1, K²."""
    grid, flux = one.grid, one.speed * pressure
    blur = [one.resolution / SIGMA / d for d in grid.spacing]
    if one.kind != "behind":
        field = rs.sliding_temperature(flux, grid, speed=one.speed, **one.body)
        if one.kind == "exposed":
            field = uniform_filter1d(field, exposed_pixels(one), axis=0, mode="wrap")
        return float(np.mean(gaussian_filter(field, blur, mode="wrap", truncate=6.0) ** 2))
    half, n = grid.shape[0] // 2, grid.shape[0]
    row, squares = line_behind(one), []
    heated = np.arange(n)[:, None] >= half
    for shift in range(0, n, n // 4):
        excess = heated * (np.roll(flux, shift, axis=0) - flux.mean())
        field = rs.half_space_temperature(excess, grid, speed=one.speed, **one.body)
        line = gaussian_filter1d(field[row], blur[1], truncate=6.0)
        squares.append(np.mean(line[n // 10 : -(n // 10)] ** 2))
    return float(np.mean(squares))


def exposed_pixels(one: Drawn) -> int:
    """Return the odd number of pixels that the contact moves by during the exposure."""
    return 2 * round((one.smear / one.grid.spacing[0] - 1) / 2) + 1


def line_behind(one: Drawn) -> int:
    """Return the row of pixels next to the distance behind the edge, which is half a pixel before the middle row."""
    return one.grid.shape[0] // 2 - max(2, round(one.behind / one.grid.spacing[0] + 0.5))


def view(one: Drawn) -> camera.View:
    """Return the picture as the law takes it, with lengths of whole pixels."""
    pixel, half = one.grid.spacing[0], one.grid.lengths[0] / 2
    if one.kind == "behind":
        behind = (one.grid.shape[0] // 2 - 0.5 - line_behind(one)) * pixel
        return camera.View(resolution=one.resolution, behind=behind, contact_length=half)
    smear = exposed_pixels(one) * pixel if one.kind == "exposed" else 0.0
    return camera.View(resolution=one.resolution, smear=smear, slid_distance=half)


def seen(one: Drawn, seed: int, surfaces: int) -> Row:
    """Return the rms of the pictures of several surfaces for μ = 1, K, and its relative standard error."""
    grid, squares = one.grid, []
    solid = rs.Solid(one.modulus, one.hardness)
    for k in range(surfaces):
        rng = np.random.default_rng([seed, k])
        heights = rs.synthesize(one.spectrum, grid, rng, amplitudes="fixed")
        contact = rs.solve_contact(heights, grid, solid, nominal_pressure=one.pressure)
        squares.append(mean_square(one, contact.pressure))
    mean, scatter = float(np.mean(squares)), float(np.std(squares, ddof=1))
    return {"rms": sqrt(mean), "error": scatter / mean / 2 / sqrt(surfaces)}


def law(one: Drawn) -> float:
    """Return the same by the law."""
    rms = camera.seen_rms(
        one.speed,
        stress_spectrum=one.stress_spectrum(),
        nominal_pressure=one.pressure,
        friction_coefficient=1.0,
        view=view(one),
        **one.body,
    )
    return float(rms)


def draw_ratios(points: list[tuple[str, float, float, float]], path: Path) -> None:
    """Draw law/simulation over the speed in v/Dq_r, by kind of picture: (kind, speed, ratio, standard error)."""
    with new_figure(path, 2.6) as figure:
        axes = figure.subplots()
        for kind, colour in KINDS.items():
            _, speed, ratio, error = zip(*[p for p in points if p[0] == kind], strict=True)
            axes.errorbar(speed, ratio, error, fmt="o", color=colour, capsize=2.5, label=kind)
        axes.axhline(1.0, color="0.4", lw=0.8)
        axes.set(xscale="log", xlabel="$v/Dq_r$", ylabel="rms, law / simulation")
        axes.legend(ncols=3)


def main() -> None:
    options = Command(__file__, __doc__, "three contacts, two surfaces of each").parse()
    count, surfaces = (3, 2) if options.toy else (CONTACTS, SURFACES)
    rows = Rows(options.output / f"contacts-{surfaces}.json", resume=True)
    table = [["picture", "contact", "v/Dq_r", "law/simulation"]]
    points = []
    for k, one in enumerate(contacts(SEED, count)):
        row = rows.once("contacts", str(k), lambda one=one, k=k: seen(one, k, surfaces))
        ratio = law(one) / row["rms"]
        touch = "elastic" if one.hardness == inf else f"σ₀/σ_P = {one.pressure / one.hardness:.2f}"
        peclet = one.speed / one.body["diffusivity"] / one.spectrum.q_roll_off
        table.append(
            [one.kind, touch, f"{peclet:.3g}", f"{ratio:.3f} ± {ratio * row['error']:.3f}"]
        )
        print(*table[-1], f"{one.grid.shape[0]}²", sep="  ", flush=True)
        points.append((one.kind, peclet, ratio, ratio * float(row["error"])))
    draw_ratios(points, options.output / "camera_law.png")
    ratios, errors = np.array([point[2:] for point in points]).T
    off = 100 * (ratios - 1)
    numbers = {"contacts": count, "rms": float(np.sqrt(np.mean(off**2)))}
    numbers |= {"worst": float(off[np.abs(off).argmax()]), "error": 100 * float(errors.mean())}
    print(numbers)
    if options.evidence:
        command = "python experiments/camera_law.py --evidence"
        write_evidence("camera_law", command, numbers=numbers, tables={"law": table})


if __name__ == "__main__":
    main()
