"""The law for pictures of a camera, beside pictures of simulated contacts that it has not met.

    python experiments/camera_law.py [--toy] [-o FOLDER] [--evidence]

Contacts are drawn, elastic and yielding, in three kinds of pictures: of the contact through a point spread, the same
with an exposure, and of a line behind the straight edge of a contact as long as half the cell. Each is solved for
several surfaces with the same C(q), and its pictures are taken in real space: a Gaussian filter, and a mean along
sliding. Marches are drawn too: from rest a contact slides by a quarter of the cell, pixel by pixel in the end, and a
camera on the body, or on the counterface, takes the mean over the last steps. In slides the same contact heats both
bodies step by step, with one temperature at each of its points, over half the cell; the one at rest conducts next to
nothing. The law has the calibrated stress spectrum of the same waves and the same slid distance. Scenes outside its
range are drawn again. Printed: rms of the picture by the law over that of all surfaces, and the same of the width.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import repeat
from math import inf, sqrt

import figures
import numpy as np
from contacts.pictures import Drawn, contacts, exposed_pixels, line_behind, view
from scipy.ndimage import gaussian_filter, gaussian_filter1d, uniform_filter1d
from script import Command, Row, Rows, show_on_pages, write_evidence

import roughsim as rs
from roughsim.observables.camera import Camera
from roughsim.sliding.path import oblique_path
from roughsim.sliding.pictures import Pictures, Shutter
from roughsim.sliding.stepping import Motion, walk
from theory import camera, plasticity

SEED, CONTACTS, SURFACES, MARCHES, SLIDES = 600, 15, 24, 5, 6
MARCHED = "march, camera on the body", "march, camera on the counterface"
SLID = "slide, camera on the body", "slide, camera on the counterface"
Point = tuple[str, float, float, float]  # kind of picture, v/Dq_r, ratio, its standard error
SIGMA = 2 * sqrt(2 * np.log(2))  # FWHM of a Gaussian over its standard deviation


def picture(one: Drawn, contact: rs.Contact) -> np.ndarray:
    """Return the picture of the contact itself for μ = 1, K."""
    grid, blur = one.grid, [one.resolution / SIGMA / d for d in one.grid.spacing]
    field = rs.sliding_temperature(one.speed * contact.pressure, grid, speed=one.speed, **one.body)
    if one.kind == "exposed":
        field = uniform_filter1d(field, exposed_pixels(one), axis=0, mode="wrap")
    return gaussian_filter(field, blur, mode="wrap", truncate=6.0)


def mean_square(one: Drawn, contact: rs.Contact) -> float:
    """Return the mean square of a picture of this contact for μ = 1, K²."""
    if one.kind != "behind":
        return float(np.mean(picture(one, contact) ** 2))
    grid, flux = one.grid, one.speed * contact.pressure
    blur = one.resolution / SIGMA / grid.spacing[1]
    half, n = grid.shape[0] // 2, grid.shape[0]
    row, squares = line_behind(one), []
    heated = np.arange(n)[:, None] >= half
    for shift in range(0, n, n // 4):
        excess = heated * (np.roll(flux, shift, axis=0) - flux.mean())
        field = rs.half_space_temperature(excess, grid, speed=one.speed, **one.body)
        line = gaussian_filter1d(field[row], blur, truncate=6.0)
        squares.append(np.mean(line[n // 10 : -(n // 10)] ** 2))
    return float(np.mean(squares))


def steps(one: Drawn) -> tuple[int, int]:
    """Return the number of steps of a march during the exposure, and their pixels."""
    pixels = exposed_pixels(one)
    step = max(1, pixels // 8)
    return max(2, round(pixels / step)), step


def march(one: Drawn, contact: rs.Contact) -> tuple[float, float]:
    """Return the mean squares of the pictures from the body and from the counterface for μ = 1, K²."""
    grid, (count, step) = one.grid, steps(one)
    slid = grid.lengths[0] / 4 - np.arange(count)[::-1] * step * grid.spacing[0]
    fields = rs.sliding_temperature(
        one.speed * contact.pressure, grid, speed=one.speed, time=slid / one.speed, **one.body
    )
    moved = [np.roll(field, k * step, axis=0) for k, field in enumerate(fields)]
    blur = [one.resolution / SIGMA / d for d in grid.spacing]
    pictures = np.mean(moved, axis=0), np.mean(fields, axis=0)
    body, counterface = (
        float(np.mean(gaussian_filter(each, blur, mode="wrap", truncate=6.0) ** 2))
        for each in pictures
    )
    return body, counterface


def width(one: Drawn, seed: int, surfaces: int) -> Row:
    """Return the full width of the mean autocorrelation across sliding at half maximum, m, and its relative error."""
    across = []
    for contact in solved(one, seed, surfaces):
        power = np.abs(np.fft.fft2(picture(one, contact))) ** 2
        across.append(np.fft.ifft(power.sum(axis=0)).real)
    widths = [_halved(each) * one.grid.spacing[1] for each in (np.mean(across, axis=0), *across)]
    apart = float(np.std(widths[1:], ddof=1) / widths[0] / sqrt(surfaces))
    return {"width": widths[0], "width, error": apart}


def _halved(correlation: np.ndarray) -> float:
    """Return the pixels between the places left and right of the maximum at which it is halved."""
    relative = correlation / correlation[0] - 0.5
    k = int(np.argmax(relative < 0.0))
    return 2 * (k - relative[k] / (relative[k] - relative[k - 1]))


def slides(count: int, pixels: int = 8) -> list[Drawn]:
    """Return fresh contacts, elastic and yielding in turns, with 8 pixels per wave and not too many points."""
    drawn = [replace(one, pixels=8) for one in contacts(SEED + 2, 30 * count, ("exposed",))]
    small = [one for one in drawn if one.grid.shape[0] <= 448]
    kinds = [
        [one for one in small if (one.hardness == inf) == elastic] for elastic in (True, False)
    ]
    in_turns = [one for pair in zip(*kinds, strict=False) for one in pair][:count]
    return [replace(one, pixels=pixels) for one in in_turns]


def slide(one: Drawn, contact: rs.Contact) -> tuple[float, float]:
    """Return the same of a slide under a body at rest that takes next to no heat."""
    grid, conductivity = one.grid, one.body["conductivity"]
    path = oblique_path(grid, grid.lengths[0] / 2)
    resting = rs.Body(1e-6 * conductivity, one.body["diffusivity"])
    motion = Motion(one.speed, 1.0, rs.Body(**one.body), resting)
    both = [
        Pictures(grid, path, [path.steps], Shutter(Camera((), ()), (one.smear,), on_body))
        for on_body in (True, False)
    ]
    for n, step in enumerate(walk(repeat(contact, path.steps + 1), grid, path, [motion])):
        for pictures in both:
            pictures.add(n, step)
    blur = [one.resolution / SIGMA / d for d in grid.spacing]
    fields = [np.fft.irfft2(each.spectra[0], grid.shape, norm="forward") for each in both]
    body, counterface = (
        float(np.var(gaussian_filter(field, blur, mode="wrap", truncate=6.0))) for field in fields
    )
    return body, counterface


def slid_view(one: Drawn, frame: str) -> camera.View:
    """Return the picture of a slide as the law takes it, as `marched_view`."""
    end = oblique_path(one.grid, one.grid.lengths[0] / 2).distance[-1]
    smear = one.smear if frame == SLID[0] else 0.0
    return camera.View(one.resolution, smear, end - one.smear / 2)


def marched_view(one: Drawn, frame: str) -> camera.View:
    """Return the picture of a march as the law takes it: the distance slid until the middle of the exposure."""
    (count, step), pixel = steps(one), one.grid.spacing[0]
    middle = one.grid.lengths[0] / 4 - (count - 1) / 2 * step * pixel
    smear = count * step * pixel if frame == MARCHED[0] else 0.0
    return camera.View(resolution=one.resolution, smear=smear, slid_distance=middle)


def solved(one: Drawn, seed: int, surfaces: int) -> Iterator[rs.Contact]:
    """Yield the contacts of several surfaces."""
    solid = rs.Solid(one.modulus, one.hardness)
    for k in range(surfaces):
        rng = np.random.default_rng([seed, k])
        heights = rs.synthesize(one.spectrum, one.grid, rng, amplitudes="fixed")
        yield rs.solve_contact(heights, one.grid, solid, nominal_pressure=one.pressure)


Taker = Callable[[Drawn, rs.Contact], float | tuple[float, float]]


def seen(one: Drawn, seed: int, surfaces: int, taken: Taker, kinds: Sequence[str]) -> Row:
    """Return the rms of the pictures of several surfaces for μ = 1, K, and their relative standard errors."""
    squares = [np.atleast_1d(taken(one, contact)) for contact in solved(one, seed, surfaces)]
    means, scatter = np.mean(squares, axis=0), np.std(squares, axis=0, ddof=1)
    row: Row = {}
    for kind, mean, apart in zip(kinds, means, scatter, strict=True):
        row[kind] = sqrt(mean)
        row[f"{kind}, error"] = float(apart / mean / 2 / sqrt(surfaces))
    return row


def law(one: Drawn, picture: camera.View, formula: Callable[..., float] = camera.seen_rms) -> float:
    """Return the same by the law."""
    rms = formula(
        one.speed,
        stress_spectrum=one.stress_spectrum(),
        nominal_pressure=one.pressure,
        friction_coefficient=1.0,
        view=picture,
        **one.body,
    )
    return float(rms)


def of_steel() -> dict[str, float]:
    """Return rms by the law for steel-1.2GPa at 35 m/s, share .938, K, after 2 mm, and along the rim of camera.py."""
    scene = rs.load_scene("steel-1.2GPa")
    cut = rs.Grid((1536, 1024), (6e-3, 4e-3)).nyquist / 2

    def rms(view: camera.View, spectrum=scene.spectrum) -> float:
        stress = plasticity.stress_spectrum(
            spectrum,
            effective_modulus=scene.effective_modulus,
            nominal_pressure=90e6,
            penetration_hardness=scene.penetration_hardness,
        )
        steel = {"conductivity": 30.0, "diffusivity": scene.conduction().diffusivity}
        load = {"nominal_pressure": 90e6, "friction_coefficient": 0.11}
        return 0.938 * float(
            camera.seen_rms(35.0, stress_spectrum=stress, view=view, **steel, **load)
        )

    numbers = {"sharp": rms(camera.View(slid_distance=2e-3))}
    for spread in (4, 19, 70):
        view = camera.View(resolution=spread * 1e-6, slid_distance=2e-3)
        numbers[f"spread_{spread}"] = rms(view)
    for smear in (100, 1000):
        numbers[f"smear_{smear}"] = rms(camera.View(smear=smear * 1e-6, slid_distance=2e-3))
    for behind in (20, 100, 500):
        view = camera.View(behind=behind * 1e-6, contact_length=2e-3)
        numbers[f"behind_{behind}"] = rms(view)
    view = camera.View(behind=20e-6, contact_length=3.95e-3)
    rim = rms(view, scene.spectrum.truncated(q_max=cut))
    return numbers | {"rim": rim, "cut_off": 100 * (rim / rms(view) - 1)}


def compared(
    one: Drawn,
    row: Row,
    kind: str,
    picture: camera.View,
    formula: Callable[..., float] = camera.seen_rms,
) -> Point:
    """Return kind, v/Dq_r, law over simulation and its standard error; print them."""
    peclet = one.speed / one.body["diffusivity"] / one.spectrum.q_roll_off
    ratio = law(one, picture, formula) / float(row[kind])
    error = ratio * float(row[f"{kind}, error"])
    touch = "elastic" if one.hardness == inf else f"σ₀/σ_P = {one.pressure / one.hardness:.2f}"
    print(f"{kind}, {touch}, v/Dq_r = {peclet:.3g}: {ratio:.3f} ± {error:.3f}", flush=True)
    return kind, peclet, ratio, error


def summary(points: list[Point], name: str) -> dict[str, float]:
    """Return number, rms and worst of law/simulation − 1, %, and the mean standard error."""
    off = 100 * (np.array([point[2] for point in points]) - 1)
    numbers = {name: len(points), f"{name}_rms": float(np.sqrt(np.mean(off**2)))}
    numbers[f"{name}_worst"] = float(off[np.abs(off).argmax()])
    return numbers | {f"{name}_error": 100 * float(np.mean([point[3] for point in points]))}


def main() -> None:
    options = Command(
        __file__, __doc__, "three contacts, a march, a slide, two surfaces of each"
    ).parse()
    count, marches, slid, surfaces = (
        (3, 1, 1, 2) if options.toy else (CONTACTS, MARCHES, SLIDES, SURFACES)
    )
    rows, half = (
        Rows(options.output / f"pictures-{surfaces}.json", resume=True),
        max(2, surfaces // 2),
    )
    tables = (
        ("contacts", contacts(SEED, count), surfaces, mean_square, (), lambda one, _: view(one)),
        ("marches", contacts(SEED + 1, marches, ("exposed",)), half, march, MARCHED, marched_view),
        ("slides", slides(slid, 3 if options.toy else 8), half, slide, SLID, slid_view),
    )
    points, numbers = [], {}
    for name, drawn, many, taken, frames, as_law in tables:
        found = []
        for k, one in enumerate(drawn):
            kinds = frames or [one.kind]
            row = rows.once(name, str(k), partial(seen, one, k, many, taken, kinds))
            found += [compared(one, row, kind, as_law(one, kind)) for kind in kinds]
        numbers |= summary(found, name)
        points += found
    found = []
    for k, one in enumerate(tables[0][1]):
        if one.kind != "behind":
            row = rows.once("widths", str(k), partial(width, one, k, max(2, surfaces // 4)))
            found.append(compared(one, row, "width", view(one), camera.seen_width))
    numbers |= summary(found, "widths") | of_steel()
    print(*(f"{name}: {value:.4g}" for name, value in numbers.items()), sep="\n")
    figures.camera_law(points, options.output / "camera_law.png")
    if options.evidence:
        table = [dict(zip(("kind", "speed", "ratio", "error"), p, strict=True)) for p in points]
        command = "python experiments/camera_law.py --evidence"
        write_evidence("camera_law", command, rows=table, numbers=numbers)
        show_on_pages(options.output / "camera_law.png")


if __name__ == "__main__":
    main()
