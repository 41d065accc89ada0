"""Contacts with cameras for experiments/camera_law.py, drawn by a rule that no picture was known for."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np

import roughsim as rs
from theory import camera, persson, plasticity

KINDS = "blurred", "exposed", "behind"  # of pictures


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


def contacts(seed: int, count: int, kinds: tuple[str, ...] = KINDS) -> list[Drawn]:
    """Return as many contacts as asked for, each within the range of the law; kinds and yielding take turns."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        k = len(found)
        one = draw(rng, kinds[k % len(kinds)], elastic=k % 2 == 0)
        try:
            one.stress_spectrum()
        except ValueError:
            continue
        if one.kind != "behind" or one.speed * view(one).behind > 5 * one.body["diffusivity"]:
            found.append(one)
    return found


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
