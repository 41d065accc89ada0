"""The skin of a body as a scene file writes it: a layer of another material, such as an oxide or a worked layer."""

from typing import Annotated

from roughsim.scene.schema import SECTIONS, Quantity, Record, record

HeatDepth = Annotated[float, Quantity("m", '"0.5 um"', ge=0)]


@record("body.skin")
class SkinSection(Record):
    """A layer on a body, in ideal thermal contact with it; the contact mechanics do not depend on it."""

    thickness: Annotated[float, Quantity("m", '"0.3 um"', gt=0)]
    conductivity: Annotated[float, Quantity("W/(m K)", '"3 W/(m K)"', gt=0)]
    density: Annotated[float, Quantity("kg/m^3", '"5200 kg/m^3"', gt=0)] | None = None
    """None: as the body."""
    heat_capacity: Annotated[float, Quantity("J/(kg K)", '"650 J/(kg K)"', gt=0)] | None = None
    """None: as the body."""

    def layer(self, density: float, heat_capacity: float) -> tuple[float, float, float]:
        """Return thickness, m, conductivity, W/(m K), and diffusivity, m²/s, on a body with ρ, kg/m³, and c, J/(kg K).

        In the order of `roughsim.Skin`.
        """
        volumetric = (self.density or density) * (self.heat_capacity or heat_capacity)
        return self.thickness, self.conductivity, self.conductivity / volumetric


SECTIONS["counterface.skin"] = SkinSection
