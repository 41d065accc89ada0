"""A power law with a bump, as after grinding."""

from typing import Annotated, Any, Literal

import numpy as np

from roughsim.scene.schema import QMax, QMin, Quantity, Record, record


@record()
class Bump(Record):
    """C(q) of a face, m⁴."""

    name: Literal["bump"]
    psd_at_q_min: Annotated[float, Quantity("m^4", '"1e-22 m^4"', gt=0)]
    q_min: QMin
    q_bump: Annotated[float, Quantity("rad/m", '"6e4 1/m"', gt=0)]
    q_max: QMax

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks, rad/m."""
        return self.q_min, self.q_max

    def __call__(self, q: Any) -> Any:
        """Return C(q), m⁴."""
        bump = 1 + 3 * np.exp(-(np.log(q / self.q_bump) ** 2) / 0.1)
        return self.psd_at_q_min * (q / self.q_min) ** -3.6 * bump
