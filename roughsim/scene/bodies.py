"""The bodies of a scene: what follows from their materials, their load and their friction."""

import math
from typing import Any, NamedTuple

from roughsim.scene.sections import BodySection, CounterfaceSection, SlidingSection
from roughsim.scene.tables import Rows, at_temperature


class Layers(NamedTuple):
    """What lies on a body: a skin, and the depth of the heat."""

    skin: tuple[float, float, float] | None = None  # in the order of `roughsim.Skin`
    heat_depth: float = 0.0  # h, m


class Conduction(NamedTuple):
    """κ, W/(m K), and D = κ/(ρc), m²/s, of the moving body and of the counterface; None if that is insulating."""

    conductivity: float
    diffusivity: float
    counter_conductivity: float | None = None
    counter_diffusivity: float | None = None
    layers: Layers = Layers()
    counter_layers: Layers = Layers()


class Bodies:
    """The bodies of a scene, and how they slide."""

    body: BodySection
    counterface: CounterfaceSection | None
    sliding: SlidingSection

    @property
    def effective_modulus(self) -> float:
        """E* of 1/E* = Σ (1 − ν²)/E over both bodies, Pa; a rigid one adds nothing."""
        elastic = (body for body in self.bodies if body.youngs_modulus is not None)
        return 1.0 / sum((1.0 - body.poisson_ratio**2) / body.youngs_modulus for body in elastic)

    @property
    def penetration_hardness(self) -> float:
        """Pressure at which contact yields, Pa: σ_P of the softer body, inf if both are elastic.

        With `junction_growth` it is σ_P/√(1 + αμ²): pressure and friction yield together (Tabor 1959).
        """
        hardness = (body.penetration_hardness for body in self.bodies)
        softer = min((limit for limit in hardness if limit is not None), default=math.inf)
        growth = self.sliding.junction_growth
        return (
            softer
            if growth is None
            else softer / math.sqrt(1.0 + growth * self.friction_coefficient() ** 2)
        )

    @property
    def elastic(self) -> bool:
        """Whether no body has a hardness."""
        return math.isinf(self.penetration_hardness)

    @property
    def background_temperature(self) -> float | None:
        """Temperature of the moving body before sliding, absolute, K; None if the scene gives none."""
        own = self.body.temperature
        return self.sliding.background_temperature if own is None else own

    @property
    def temperature_difference(self) -> float:
        """How much hotter the counterface was than the moving body before sliding, K."""
        other = None if self.counterface is None else self.counterface.temperature
        return (
            0.0 if other is None or self.body.temperature is None else other - self.body.temperature
        )

    @property
    def sections_of_bodies(self) -> dict[str, BodySection | CounterfaceSection]:
        """The sections that may have a material, by their names."""
        counterface = {"counterface": self.counterface} if self.counterface is not None else {}
        return {"body": self.body, **counterface}

    @property
    def bodies(self) -> tuple[BodySection | CounterfaceSection, ...]:
        """The moving body, and the resting one if the scene has it."""
        if self.counterface is None:
            return (self.body,)
        return self.body, self.body if self.counterface.like else self.counterface

    @property
    def melting_temperature(self) -> float:
        """The lower melting temperature of the bodies, absolute, K; inf if none is given."""
        temperatures = (body.melting_temperature for body in self.bodies)
        return min((kelvin for kelvin in temperatures if kelvin is not None), default=math.inf)

    @property
    def missing_second_body(self) -> str:
        """The missing section or key of a heat-conducting second body; empty if it is complete."""
        if self.counterface is None:
            return "[counterface]"
        return "" if self.counterface_conducts else "counterface.conductivity"

    @property
    def counterface_conducts(self) -> bool:
        """Whether a second body conducts heat."""
        return len(self.bodies) == 2 and self.bodies[1].conductivity is not None

    @property
    def tables(self) -> dict[str, list[Rows]]:
        """Tables over the absolute temperature by their keys; no entry if all of a key are numbers."""
        keys = {
            "conductivity": [body.conductivity for body in self.bodies],
            "friction_coefficient": [self.sliding.friction_coefficient],
        }
        tables = {
            key: [value for value in values if isinstance(value, tuple)]
            for key, values in keys.items()
        }
        return {key: rows for key, rows in tables.items() if rows}

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Range of absolute temperatures common to all tables, K: (0, inf) without tables."""
        tables = [rows for several in self.tables.values() for rows in several]
        low, high = ([rows[end][0] for rows in tables] for end in (0, -1))
        return max(low, default=0.0), min(high, default=math.inf)

    def friction_coefficient(self, temperature: float | None = None) -> float:
        """Return μ at an absolute `temperature`, K; SceneError if it is not within a table of μ, or missing then."""
        return at_temperature(self.sliding.friction_coefficient, temperature)

    def conduction(self, temperature: float | None = None) -> Conduction:
        """Return κ and D of both bodies at an absolute `temperature`, K; SceneError as `friction_coefficient`."""
        numbers: list[Any] = []
        for body in self.bodies:
            if body.conductivity is not None:
                kappa = at_temperature(body.conductivity, temperature)
                numbers += [kappa, kappa / (body.density * body.heat_capacity)]
        return Conduction(*numbers, layers=self.layers[0], counter_layers=self.layers[1])  # type: ignore[misc]

    @property
    def layers(self) -> tuple[Layers, Layers]:
        """What lies on the moving body and on the counterface; nothing on one that takes no heat."""
        several = []
        for body in self.bodies:
            skin = None if body.skin is None else body.skin.layer(body.density, body.heat_capacity)
            several.append(Layers(skin, body.heat_depth or 0.0))
        return several[0], several[-1] if len(several) == 2 else Layers()
