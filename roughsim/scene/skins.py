"""The skin of a body as a scene file writes it: a layer of another material, such as an oxide or a worked layer."""

from typing import Annotated

from pydantic.dataclasses import dataclass

from roughsim.scene.schema import SECTIONS, Quantity, Record

HeatDepth = Annotated[float, Quantity("m", '"0.5 um"', at_least=0)]


@dataclass(frozen=True, kw_only=True)
class SkinSection(Record, section="body.skin"):
    """A layer on a body, in ideal thermal contact with it; the contact mechanics do not depend on it."""

    thickness: Annotated[float, Quantity("m", '"0.3 um"', above=0)]
    conductivity: Annotated[float, Quantity("W/(m K)", '"3 W/(m K)"', above=0)]
    density: Annotated[float, Quantity("kg/m^3", '"5200 kg/m^3"', above=0)] | None = None
    """None: as the body."""
    heat_capacity: Annotated[float, Quantity("J/(kg K)", '"650 J/(kg K)"', above=0)] | None = None
    """None: as the body."""

    def layer(self, density: float, heat_capacity: float) -> tuple[float, float, float]:
        """Return thickness, m, conductivity, W/(m K), and diffusivity, m²/s, on a body with ρ, kg/m³, and c, J/(kg K).

        In the order of `roughsim.Skin`.
        """
        volumetric = (self.density or density) * (self.heat_capacity or heat_capacity)
        return self.thickness, self.conductivity, self.conductivity / volumetric


SECTIONS["counterface.skin"] = SkinSection
