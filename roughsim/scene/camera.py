"""The section [camera] of a scene file: an instrument that looks at the surface of the moving body."""

from typing import Annotated, Literal

from pydantic import model_validator

from roughsim.scene.schema import Quantity, Record, record


@record("camera")
class CameraSection(Record):
    """A camera, for which observables of the picture are computed: `seen_rms`, `seen_99` and `seen_width`."""

    resolution: Annotated[float, Quantity("m", '"4 um"', ge=0)] = 0.0
    """Full width at half maximum of its Gaussian point spread."""
    exposure: Annotated[float, Quantity("s", '"1 us"', ge=0)] = 0.0
    """Time during which the shutter is open."""
    fixed_to: Literal["counterface", "body"] = "counterface"
    """What the camera moves with. Frozen contact rests on the counterface, and moves past a camera on the body."""
    behind: Annotated[float, Quantity("m", '"20 um"', ge=0)] | None = None
    """Distance of a line behind the straight trailing edge of the contact; None: it looks at the contact itself."""

    @model_validator(mode="after")
    def _fits(self) -> "CameraSection":
        if self.behind is not None and self.exposure > 0.0 and self.fixed_to == "body":
            raise ValueError(
                f'exposure = {self.exposure:.6g} s does not go with behind and fixed_to = "body": the line would move '
                'away from the contact; write fixed_to = "counterface", or leave the exposure out'
            )
        return self

    def smear(self, speed: float) -> float:
        """Return the distance, m, by which frozen contact moves past the camera at a speed, m/s."""
        return speed * self.exposure if self.fixed_to == "body" else 0.0
