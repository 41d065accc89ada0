"""The sizes that follow from a scene, for readers to judge it by; what is of the theory is over its whole spectrum."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import lru_cache
from math import inf, isinf, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.cell_size import choose_lengths
from roughsim.scene import Scene
from roughsim.show.table import Column, Table
from roughsim.show.units import json_value

Array = NDArray[np.float64]
ROOM = 293.0  # K, where no background temperature is given
STEEP = 0.5  # rms slope: the model has surfaces of small slope
YIELDED = 32.0  # q_y: shorter waves touch at the hardness alone, and their slope changes nothing


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """What follows from a scene, in SI; arrays over its speeds."""

    rms_height: float  # of both faces together, as all of the roughness
    rms_slope: float
    rms_slope_before_yield: float  # of the waves up to 32 q_y; of all where q_y is inf
    longest_wave: float  # 2π/q_min
    shortest_wave: float  # 2π/q_max
    pressure_over_hardness: float  # σ₀/σ_P; 0 of elastic contact
    pressure_over_modulus: float  # σ₀/E*
    contact_fraction: float  # A/A₀ of the theory
    contact_pressure: float  # its mean, σ₀A₀/A
    yield_wavenumber: float  # q_y; inf of elastic contact, or where C(q) ends before
    hot_spot_radius: float  # r over which the pressure of the theory is correlated by one half
    hot_spots: float  # contact area of a cell over πr²
    cell: tuple[float, float]  # its sides
    speed: Array
    peclet_number: Array  # vr/D
    heat_partition: Array  # share used
    flash_temperature: Array  # of the theory with that share, K above the background
    background_temperature: float  # absolute; `ROOM` if the scene gives none
    melting_temperature: float  # absolute; inf if the scene gives none

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values in SI; NaN and inf as None."""
        values: dict[str, Any] = json_value(asdict(self))
        return values

    def table(self) -> Table:
        """Return name, value and meaning of each for people."""
        elastic = self.pressure_over_hardness == 0.0
        ratio = ("σ₀/σ_P", f"{self.pressure_over_hardness:.3g}", "nominal pressure over penetration hardness")
        if elastic:
            ratio = ("σ₀/E*", f"{self.pressure_over_modulus:.3g}", "nominal pressure over effective modulus")
        yields = "no q_y: elastic" if elastic else "no q_y: less than 99 % yields"
        if not isinf(self.yield_wavenumber):
            yields = f"q_y = {self.yield_wavenumber:.3g} rad/m"
        gentle = f", {self.rms_slope_before_yield:.3g} up to {YIELDED:g} q_y"
        gentle *= self.rms_slope_before_yield < self.rms_slope
        slope = f"of both faces together{gentle}; the model has less than {STEEP:g}"
        waves = f"in waves of {1e3 * self.longest_wave:.3g} mm to {1e6 * self.shortest_wave:.3g} µm"
        area = f"of the nominal area in theory, at {self.contact_pressure:.3g} Pa; {yields}"
        size = f"{1e3 * self.cell[0]:.3g} mm × {1e3 * self.cell[1]:.3g} mm"
        spots = f"of radius {1e6 * self.hot_spot_radius:.3g} µm in a cell of {size}"
        speeds = f"at {range_text(self.speed)} m/s"
        melting = "" if isinf(self.melting_temperature) else f", melts at {self.melting_temperature:g} K"
        background = f"above a background of {self.background_temperature:g} K{melting}"
        rows = [
            ("rms height", f"{1e6 * self.rms_height:.3g} µm", f"of both faces together, {waves}"),
            ("rms slope", f"{self.rms_slope:.3g}", slope),
            ratio,
            ("contact area", f"{self.contact_fraction:.3g}", area),
            ("hot spots", f"{self.hot_spots:.3g}", spots),
            ("Péclet number", range_text(self.peclet_number), f"vr/D with that radius, {speeds}"),
            ("T_flash", f"{range_text(self.flash_temperature)} K", f"in theory, {speeds}, {background}"),
        ]
        return Table([Column("", name=True), Column("", name=True), Column("")], rows)


@lru_cache(maxsize=8)
def facts(scene: Scene) -> Facts:
    """Return what follows from a scene; ValueError, ArithmeticError or RuntimeError where its theory has no value."""
    theory, spectrum, load = prediction.predictions(scene), scene.spectrum, scene.sliding.nominal_pressure
    speeds, lengths = np.array(scene.speeds), choose_lengths(scene)[0]
    share = prediction.heat_partition(scene)
    radius, contact = float(theory["correlation_radius_50"][0]), float(theory["contact_fraction"][0])
    yields = inf if scene.elastic else prediction.yield_wavenumber(scene)
    gentle = spectrum if YIELDED * yields >= spectrum.breaks[-1] else spectrum.truncated(q_max=YIELDED * yields)
    return Facts(
        rms_height=spectrum.rms_height,
        rms_slope=spectrum.rms_slope,
        rms_slope_before_yield=gentle.rms_slope,
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
        speed=speeds,
        peclet_number=speeds * radius / prediction.conduction(scene).diffusivity,
        heat_partition=share,
        flash_temperature=share * theory["flash_temperature"],
        background_temperature=scene.sliding.background_temperature or ROOM,
        melting_temperature=scene.melting_temperature,
    )


def range_text(values: Array) -> str:
    """Return the least and the largest of some numbers, as "0.1 … 35"."""
    return " … ".join(dict.fromkeys(f"{value:.3g}" for value in (float(values.min()), float(values.max()))))
