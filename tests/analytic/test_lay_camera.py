"""Pictures of faces with a lay by theory: brute force over the plane of q, symmetries, and the isotropic limit."""

from math import cos, inf, log, pi, sin

import numpy as np
import pytest
from scipy.special import wofz
from some_rows import some
from test_lay import DIFFUSIVITY, HEAT, KAPPA, MU, Band, Powered, plane

from theory import camera
from theory.camera import View
from theory.scattering import ANSWER
from theory.slope_frame import Directions

VIEWS = {
    "sharp": View(),
    "seen": View(3e-5, 4e-4),
    "young": View(slid_distance=3e-4),
    "behind": View(3e-5, behind=1e-4, contact_length=4e-4),
}


class Mixed(Powered):
    """A stress of which a third is of waves at their own wavenumbers."""

    def own_share(self, q):
        return np.full(np.shape(q), 1 / 3)


class Directed(Mixed):
    """The same with grooves of their own in each wave."""

    directions = Directions((log(2e4), log(8e4)), ((0.3, 0.1), (-0.2, 0.4)))
    angle = 0.4


def erfc(z):
    return np.exp(-(z**2)) * wofz(1j * z)


def seen(qx, qy, direction, speed, view):
    """|H|²/|λ|² of waves, m²."""
    along = np.abs(qx * cos(direction) + qy * sin(direction))
    across = np.abs(qx * sin(direction) - qy * cos(direction))
    rate, square, blurred = speed / DIFFUSIVITY, along**2 + across**2, across**2
    if view.behind is not None:
        decay = across**2 / rate - 1j * along
        ends = (view.behind, view.behind + view.contact_length)
        first, last = (erfc(np.sqrt(decay * end)) for end in ends)
        power = np.abs(first - last) ** 2 / np.abs(decay * rate)
    else:
        root = np.sqrt(square - 1j * along * rate)
        grown = (
            1.0
            if view.slid_distance == inf
            else 1 - erfc(root * np.sqrt(view.slid_distance / rate))
        )
        power = np.abs(grown / root) ** 2 * np.sinc(along * view.smear / (2 * pi)) ** 2
        blurred = square
    return power * np.exp(-blurred * view.resolution**2 / (8 * log(2))), across


def summed(stress, direction, speed, view):
    """The rms, K, and the correlation across sliding by a sum over waves."""
    qx, qy, area = plane(stress.lay, direction)
    ratio = np.sqrt((qx**2 + qy**2) / (stress.lay * qx**2 + qy**2 / stress.lay))
    angle = (np.arange(4000) + 0.5) * pi / 4000
    everywhere = np.sqrt(np.cos(angle) ** 2 / stress.lay + stress.lay * np.sin(angle) ** 2) ** 0.7
    wave, angle = (
        np.hypot(qx * stress.lay**0.5, qy / stress.lay**0.5),
        np.arctan2(qy, qx * stress.lay),
    )
    part = np.log(wave / 2e4) / log(4)
    lays = 1.0
    if isinstance(stress, Directed):
        lays += (0.3 - 0.5 * part) * np.cos(2 * angle) + (0.1 + 0.3 * part) * np.sin(2 * angle)
    own = lays * float(stress.own_share(np.ones(1))[0])
    weight = sum(
        part * ratio ** (0.7 * power) / np.mean(everywhere**power)
        for part, power in ((own, 2.0), (2 / 3, ANSWER))
    )
    power, across = seen(qx, qy, direction, speed, view)
    power = 1e4 * area * weight * power * (MU * speed / KAPPA) ** 2
    return float(np.sqrt(power.sum())), lambda y: float(np.sum(power * np.cos(across * y)))


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2])
@pytest.mark.parametrize("name", some(VIEWS, 2))
def test_picture_is_the_sum_of_its_waves(name, direction):
    stress, view = Mixed(5.0), VIEWS[name]
    for speed in (0.3, 35.0):
        rms, correlation = summed(stress, direction, speed, view)
        arguments = {"stress": stress, "direction": direction, "view": view, **HEAT}
        assert camera.seen_rms(speed, **arguments) == pytest.approx(rms, rel=2e-4)
        half = camera.seen_width(speed, **arguments) / 2
        assert correlation(half) == pytest.approx(rms**2 / 2, rel=2e-3)


def test_waves_with_lays_of_their_own_have_their_share():
    stress, view = Directed(3.0), VIEWS["seen"]
    for direction in (0.3, 1.5):
        rms, _ = summed(stress, direction - 0.4, 35.0, view)
        found = camera.seen_rms(35.0, stress=stress, direction=direction, view=view, **HEAT)
        assert found == pytest.approx(rms, rel=2e-4)


@pytest.mark.parametrize("direction", [0.0, 1.1])
def test_isotropic_face_has_the_isotropic_picture(direction):
    for view in VIEWS.values():
        for formula in (camera.seen_rms, camera.seen_width):
            plain = formula(35.0, stress_spectrum=Band(), view=view, **HEAT)
            one = formula(35.0, stress=Mixed(1.0), direction=direction, view=view, **HEAT)
            assert one == pytest.approx(plain, rel=1e-6)


def test_turned_lay_is_the_inverse():
    for view in VIEWS.values():
        for formula in (camera.seen_rms, camera.seen_width):
            found = formula(3.0, stress=Mixed(4.0), direction=0.5, view=view, **HEAT)
            turned = formula(3.0, stress=Mixed(0.25), direction=pi / 2 - 0.5, view=view, **HEAT)
            assert turned == pytest.approx(found, rel=1e-6)
