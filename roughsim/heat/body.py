"""`Body`: one of the two half-spaces of a sliding contact."""

from dataclasses import dataclass

from roughsim.errors import not_negative, number, sized
from roughsim.heat.skin import Layering, SkinLike, checked_skin


@dataclass(frozen=True, slots=True)
class Body:
    """A half-space that the contact slides over.

    TypeError or ValueError for a value that is not one finite number, and for κ or D ≤ 0.

    Parameters
    ----------
    conductivity, diffusivity : float
        κ, W/(m K); D, m²/s.
    speed : float
        Speed of the contact through this body along axis 0, m/s, of either sign.
    skin : Skin, optional
        A layer of another material on it: thickness, m, conductivity, W/(m K), and diffusivity, m²/s.
    heat_depth : float
        Depth h, m, ≥ 0, in which its heat is released, with the density q̇ e^(−z/h)/h; 0 is the surface.
    """

    conductivity: float
    diffusivity: float
    speed: float = 0.0
    skin: SkinLike | None = None
    heat_depth: float = 0.0

    def __post_init__(self) -> None:
        checked = {
            "conductivity": sized("conductivity", self.conductivity, "W/(m K)"),
            "diffusivity": sized("diffusivity", self.diffusivity, "m²/s"),
            "speed": number("speed", self.speed, "m/s"),
            "skin": checked_skin(self.skin),
            "heat_depth": not_negative("heat_depth", self.heat_depth, "m"),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def layers(self) -> Layering | None:
        """The skin and the depth of release in units of the body; None of a bare one."""
        materials = self.conductivity, self.diffusivity
        if self.skin is None or self.skin[1:] == materials:  # or of the same material
            return Layering(0.0, 1.0, 1.0, self.heat_depth) if self.heat_depth else None
        thickness, conductivity, diffusivity = self.skin
        return Layering(
            thickness,
            conductivity / self.conductivity,
            self.diffusivity / diffusivity,
            self.heat_depth,
        )
