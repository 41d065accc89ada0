"""The sizes that follow from a scene: roughness, load, contact area, hot spots, Péclet numbers and temperatures."""

from dataclasses import asdict, dataclass
from math import exp, inf, isfinite, isinf, log, nan, pi
from typing import Any

import numpy as np

from roughsim.grid import Array
from roughsim.prediction.areas import yield_wavenumber
from roughsim.prediction.bodies import background, conduction, heat_partition
from roughsim.prediction.theories import hot_spot_radius, predictions
from roughsim.scene import Scene
from roughsim.scene.faces import steeper
from roughsim.scene.slips import STEEP
from roughsim.show.remarks import Remark
from roughsim.show.table import json_value
from roughsim.surface.topography.texture import Texture
from theory.roots import root

_ROOM = 293.0  # K, the background temperature where none is given
YIELDED = 32.0  # q_y: shorter waves touch at the hardness alone, and their slope changes nothing


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """Sizes that follow from a scene, in SI; arrays run over its speeds."""

    rms_height: float  # of both faces together, as all of the roughness
    rms_slope: float
    textures: dict[str, tuple[Texture, ...]]  # of the maps of each face
    rms_slope_before_yield: float  # of the waves up to 32 q_y; of all where q_y is inf
    longest_wave: float
    shortest_wave: float
    pressure_over_hardness: float  # σ₀/σ_P; 0 of elastic contact
    pressure_over_modulus: float  # σ₀/E*
    contact_fraction: float  # A/A₀ of the theory
    contact_pressure: float  # its mean, σ₀A₀/A
    yield_wavenumber: float  # q_y; inf of elastic contact, or where C(q) ends before
    hot_spot_radius: float  # over which the correlation of the pressure falls to a half, in theory
    hot_spots: float  # contact area of a cell over πr²
    cell: tuple[float, float]  # its sides
    speed: Array
    peclet_number: Array  # vr/D
    heat_partition: Array  # share used
    flash_temperature: Array  # of the theory with that share, K above the background
    background_temperature: float  # absolute, before sliding
    warming: Array  # T₀ of the moving body with that share, K; 0 where no time or radius is given
    melting_temperature: float  # absolute; inf if the scene gives none

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values in SI; NaN and inf as None."""
        textures = {face: [one._asdict() for one in maps] for face, maps in self.textures.items()}
        values: dict[str, Any] = json_value(asdict(self) | {"textures": textures})
        return values

    def rows(self) -> list[Remark]:
        """Return name, value and meaning of each for people."""
        ratio = (
            "σ₀/σ_P",
            f"{self.pressure_over_hardness:.3g}",
            "nominal pressure over penetration hardness",
        )
        yields = "no q_y: less than 99 % yields"
        if self.pressure_over_hardness == 0.0:
            ratio = (
                "σ₀/E*",
                f"{self.pressure_over_modulus:.3g}",
                "nominal pressure over effective modulus",
            )
            yields = "no q_y: elastic"
        elif isfinite(self.yield_wavenumber):
            yields = f"q_y = {self.yield_wavenumber:.3g} rad/m"
        waves = f"in waves of {1e3 * self.longest_wave:.3g} mm to {1e6 * self.shortest_wave:.3g} µm"
        gentle = self.rms_slope_before_yield < self.rms_slope
        before = f", {self.rms_slope_before_yield:.3g} up to {YIELDED:g} q_y" if gentle else ""
        slope = f"of both faces together{before}; the model has less than {STEEP:g}"
        size = f"{1e3 * self.cell[0]:.3g} mm × {1e3 * self.cell[1]:.3g} mm"
        spots = f"of radius {1e6 * self.hot_spot_radius:.3g} µm in a cell of {size}"
        speeds = f"at {_range_text(self.speed)} m/s"
        melting = (
            "" if isinf(self.melting_temperature) else f", melts at {self.melting_temperature:g} K"
        )
        background = f"above a background of {self.background_temperature:g} K{melting}"
        area = f"of the nominal area in theory, at {self.contact_pressure:.3g} Pa; {yields}"
        rows = [
            ("rms height", f"{1e6 * self.rms_height:.3g} µm", f"of both faces together, {waves}"),
            ("rms slope", f"{self.rms_slope:.3g}", slope),
            ratio,
            ("contact area", f"{self.contact_fraction:.3g}", area),
            ("hot spots", f"{self.hot_spots:.3g}", spots),
            ("Péclet number", _range_text(self.peclet_number), f"vr/D with that radius, {speeds}"),
            (
                "T_flash",
                f"{_range_text(self.flash_temperature)} K",
                f"in theory, {speeds}, {background}",
            ),
        ]
        return [Remark("size", name, meaning, value) for name, value, meaning in rows]


def facts_of(scene: Scene, lengths: tuple[float, float]) -> Facts:
    """Return the sizes of a scene in a cell of these sides, m.

    ValueError, ArithmeticError or RuntimeError where the theory of the scene has no value.
    """
    theory, spectrum, load = predictions(scene), scene.spectrum, scene.sliding.nominal_pressure
    speed, share = np.array(scene.speeds), heat_partition(scene)
    yields = inf if scene.elastic else yield_wavenumber(scene)
    gentle = spectrum
    if YIELDED * yields < spectrum.breaks[-1]:
        gentle = spectrum.truncated(q_max=YIELDED * yields)
    contact = float(theory["contact_fraction"][0])
    radius = hot_spot_radius(scene)
    return Facts(
        rms_height=spectrum.rms_height,
        rms_slope=scene.rms_slope,
        textures=scene.textures,
        rms_slope_before_yield=gentle.rms_slope * steeper(scene.lay),
        longest_wave=2 * pi / spectrum.breaks[0],
        shortest_wave=2 * pi / spectrum.breaks[-1],
        pressure_over_hardness=load / scene.penetration_hardness,
        pressure_over_modulus=load / scene.effective_modulus,
        contact_fraction=contact,
        contact_pressure=load / contact if contact > 0.0 else inf,
        yield_wavenumber=yields,
        hot_spot_radius=radius,
        hot_spots=contact * lengths[0] * lengths[1] / (pi * radius**2),
        cell=lengths,
        speed=speed,
        peclet_number=speed * radius / conduction(scene).diffusivity,
        heat_partition=share,
        flash_temperature=share * theory["flash_temperature"],
        background_temperature=scene.background_temperature or _ROOM,
        warming=share * background(scene),
        melting_temperature=scene.melting_temperature,
    )


def _range_text(values: Array) -> str:
    """Return the least and the largest of some numbers, as "0.1 … 35"."""
    return " … ".join(
        dict.fromkeys(f"{value:.3g}" for value in (float(values.min()), float(values.max())))
    )


def gentle_end(scene: Scene) -> float:
    """Return the wavenumber up to which the rms slope stays below `STEEP`, rad/m; NaN if the first waves are steep."""

    def excess(log_q: float) -> float:
        return scene.spectrum.truncated(q_max=exp(log_q)).rms_slope * steeper(scene.lay) - STEEP

    first, last = log(1.01 * scene.spectrum.breaks[0]), log(scene.spectrum.breaks[-1])
    if excess(first) > 0.0:
        return nan
    return exp(root(excess, first, last, accuracy=1e-9))
