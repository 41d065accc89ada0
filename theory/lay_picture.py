"""Waves of the picture of a face with a lay, in one direction of sliding.

|σ_q′|² w(q′, φ) of `theory.lay` in place of |σ_q|², at the true q = q′(cosφ/√γ, √γ sinφ); all else is `theory.picture`.
"""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from theory.arguments import Array
from theory.flash import HeatSource
from theory.lay_waves import Weighted
from theory.picture import Picture, View, growing
from theory.scattering import ANSWER

# directions of waves; the others are mirror images
_ALL = np.linspace(pi / 512, pi / 2 - pi / 512, 128)


class LayPicture(Picture):
    """The picture at one speed, m/s, in a direction, rad from the grooves, in units of μv/κ."""

    def __init__(
        self, source: HeatSource, speed: float, view: View, stress: Weighted, direction: float
    ) -> None:
        super().__init__(source, speed, view)
        direction -= stress.angle
        self._lay_stress, root = stress, sqrt(stress.lay)
        ux, uy = (one if abs(one) > 1e-15 else 0.0 for one in (cos(direction), sin(direction)))
        # times cosφ and sinφ
        self._along, self._across = (ux / root, uy * root), (-uy / root, ux * root)
        self._stretch = max(root, 1 / root)

    def _parts(self, angle: Array) -> tuple[Array, Array, Array]:
        ways = np.array([self._along, self._across]) @ np.array([np.cos(angle), np.sin(angle)])
        along, across = np.abs(ways)
        return along, across, np.hypot(along, across)

    def _share(self, q: Array, angle: Array, width: Array) -> Array:
        stress = self._lay_stress
        own, share = stress.own_share(q), np.zeros((q.size, angle.size))
        lays = stress.directions.at(q[:, 0]) @ stress.directions.waves(angle).T  # M
        for part, power in ((own * lays, 2.0), (1 - own, ANSWER)):
            mean = np.mean(self._response(q, _ALL) ** power, axis=1, keepdims=True)
            share += part * self._response(q, angle) ** power / mean
        return share * width / pi

    def _response(self, q: Array, angle: Array) -> Array:
        lay = self._lay_stress.lay
        return self._lay_stress.response(
            q, np.sqrt(np.cos(angle) ** 2 / lay + lay * np.sin(angle) ** 2)
        )

    def _edges(self, low: float, high: float, lengths: list[float], distance: float) -> Array:
        """Return edges over half a turn: they grow from q·v = 0, from q along v, and from the grooves."""
        resting, ahead = (atan2(-one, other) for one, other in (self._along, self._across))
        at_rest = float(self._parts(np.array([resting]))[2][0])
        few, last = self._narrow(low, high * self._stretch, lengths, distance)
        few *= min(1.0, at_rest**2 / hypot(*self._along))
        grooves = min(self._lay_stress.lay, 1 / self._lay_stress.lay)
        edges = [
            (place + sign * growing(start, pi / 2) - resting + pi / 2) % pi
            for place, start in ((resting, few), (ahead, last), (0.0, grooves))
            for sign in (-1.0, 1.0)
        ]
        return resting - pi / 2 + np.unique(np.concatenate([[0.0, pi], *edges]))
