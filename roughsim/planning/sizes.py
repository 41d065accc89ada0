"""The sizes that follow from a scene, which a reader can judge at a glance."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import lru_cache
from math import inf, isfinite, isinf, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.cell_size import choose_lengths
from roughsim.prediction.views import Integrals
from roughsim.show.table import Column, Table

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
ROOM = 293.0  # K, where no background temperature is given
STEEP = 0.5  # rms slope: the model has surfaces of small slope
YIELDED = 32.0  # q_y: shorter waves touch at the hardness alone, and their slope changes nothing


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """Sizes that follow from a scene; what is of the theory is over its whole spectrum.

    Attributes
    ----------
    rms_height, rms_slope : float
        Of both faces together, m and dimensionless.
    rms_slope_before_yield : float
        The same of the waves up to 32 q_y; of all where q_y is inf.
    longest_wave, shortest_wave : float
        2π/q_min and 2π/q_max, m.
    pressure_over_hardness : float
        σ₀/σ_P; 0 of elastic contact.
    pressure_over_modulus : float
        σ₀/E*.
    contact_fraction, contact_pressure : float
        A/A₀ of the theory, and the mean pressure σ₀A₀/A, Pa.
    yield_wavenumber : float
        q_y, rad/m; inf of elastic contact, or where C(q) ends before.
    hot_spot_radius : float
        r, m, over which the pressure of the theory is correlated by one half.
    hot_spots : float
        Contact area of a cell over πr².
    cell : (float, float)
        Sides of the cell, m.
    speed : ndarray
        v, m/s.
    peclet_number : ndarray
        vr/D, over speed.
    heat_partition : ndarray
        Share used, over speed.
    flash_temperature : ndarray
        T_flash of the theory with that share, K above the background, over speed.
    background_temperature : float
        Absolute, K; `ROOM` if the scene gives none.
    melting_temperature : float
        Absolute, K; inf if the scene gives none.
    """

    rms_height: float
    rms_slope: float
    rms_slope_before_yield: float
    longest_wave: float
    shortest_wave: float
    pressure_over_hardness: float
    pressure_over_modulus: float
    contact_fraction: float
    contact_pressure: float
    yield_wavenumber: float
    hot_spot_radius: float
    hot_spots: float
    cell: tuple[float, float]
    speed: Array
    peclet_number: Array
    heat_partition: Array
    flash_temperature: Array
    background_temperature: float
    melting_temperature: float

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values in SI; NaN and inf as None."""
        return {key: _json(value) for key, value in asdict(self).items()}

    def table(self) -> Table:
        """Return name, value and meaning of each for people."""
        elastic = self.pressure_over_hardness == 0.0
        speeds = f"{_range(self.speed)} m/s"
        melting = "" if isinf(self.melting_temperature) else f", melts at {self.melting_temperature:g} K"
        background = f"a background of {self.background_temperature:g} K{melting}"
        yields = "no q_y: elastic" if elastic else "no q_y: less than 99 % yields"
        if isfinite(self.yield_wavenumber):
            yields = f"q_y = {self.yield_wavenumber:.3g} rad/m"
        ratio = ("σ₀/σ_P", self.pressure_over_hardness, "nominal pressure over penetration hardness")
        if elastic:
            ratio = ("σ₀/E*", self.pressure_over_modulus, "nominal pressure over effective modulus")
        part = f", {self.rms_slope_before_yield:.3g} up to {YIELDED:g} q_y"
        part = part if self.rms_slope_before_yield < self.rms_slope else ""
        waves = f"{1e3 * self.longest_wave:.3g} mm to {1e6 * self.shortest_wave:.3g} µm"
        size = f"{1e3 * self.cell[0]:.3g} mm × {1e3 * self.cell[1]:.3g} mm"
        rows = [
            ("rms height", f"{1e6 * self.rms_height:.3g} µm", f"of both faces together, in waves of {waves}"),
            ("rms slope", f"{self.rms_slope:.3g}", f"of both faces together{part}; the model has less than {STEEP:g}"),
            (ratio[0], f"{ratio[1]:.3g}", ratio[2]),
            (
                "contact area",
                f"{self.contact_fraction:.3g}",
                f"of the nominal area in theory, at {self.contact_pressure:.3g} Pa; {yields}",
            ),
            (
                "hot spots",
                f"{self.hot_spots:.3g}",
                f"of radius {1e6 * self.hot_spot_radius:.3g} µm in a cell of {size}",
            ),
            ("Péclet number", _range(self.peclet_number), f"vr/D with that radius, at {speeds}"),
            (
                "T_flash",
                f"{_range(self.flash_temperature)} K",
                f"in theory, at {speeds}, above {background}",
            ),
        ]
        return Table([Column("")] * 3, rows)


@lru_cache(maxsize=8)
def facts(scene: Scene) -> Facts:
    """Return the sizes that follow from a scene.

    Raises
    ------
    ValueError, ArithmeticError, RuntimeError
        Where the theory cannot be evaluated.
    """
    theory, spectrum, load = Integrals(scene), scene.spectrum, scene.sliding.nominal_pressure
    speeds, lengths = np.array(scene.speeds), choose_lengths(scene)[0]
    share = prediction.heat_partition(scene)
    radius = theory.correlation_radius(0.5)
    contact = theory.area_fractions["contact_fraction"]
    yields = inf if scene.elastic else prediction.yield_wavenumber(scene)
    touching = spectrum if YIELDED * yields >= spectrum.breaks[-1] else spectrum.truncated(q_max=YIELDED * yields)
    return Facts(
        rms_height=spectrum.rms_height,
        rms_slope=spectrum.rms_slope,
        rms_slope_before_yield=touching.rms_slope,
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
        flash_temperature=share * theory.over_speed["flash_temperature"],
        background_temperature=scene.sliding.background_temperature or ROOM,
        melting_temperature=scene.melting_temperature,
    )


def _range(values: Array) -> str:
    """The least and the largest of some numbers."""
    return " … ".join(dict.fromkeys(f"{value:.3g}" for value in (float(values.min()), float(values.max()))))


def _json(value: Any) -> Any:
    if isinstance(value, (np.ndarray, tuple)):
        return [_json(float(entry)) for entry in value]
    return value if isfinite(value) else None


__all__ = ["ROOM", "STEEP", "YIELDED", "Facts", "facts"]
