"""What a camera sees: brute force over waves, exact strips, and limits with their rates."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.special import erf, erfc, exp1, j0, k0e

from theory import camera, flash
from theory.camera import View
from theory.quadrature import QuadratureError

MU, KAPPA, DIFFUSIVITY = 0.11, 30.0, 7.6e-6
HEAT = {"friction_coefficient": MU, "conductivity": KAPPA, "diffusivity": DIFFUSIVITY}
SHARP = {"nominal_pressure": 1e8, **HEAT}
SPEEDS = [1e-3, 0.3, 35.0]


class Band:
    """|σ_q|² = 1e4 Pa² m² from q_min to q_max."""

    def __init__(self, q_min=2e4, q_max=8e4):
        self.breaks = (q_min, q_max)

    def __call__(self, q):
        return np.full(np.shape(q), 1e4)


def seen(speed, view, spectrum=None):
    return camera.seen_rms(speed, stress_spectrum=spectrum or Band(), view=view, **SHARP)


def width(speed, view, spectrum=None):
    return camera.seen_width(speed, stress_spectrum=spectrum or Band(), view=view, **SHARP)


def cartesian(count=400):
    """q_x, q_y over one quadrant of the band, and weights; dense near q_x = 0."""
    q, radial = np.polynomial.legendre.leggauss(40)
    q, radial = 5e4 + 3e4 * q, 3e4 * radial
    u, angular = np.polynomial.legendre.leggauss(count)
    u, angular = (u + 1) / 2, angular / 2  # angle π/2 u⁴
    angle, angular = pi / 2 * u**4, angular * 2 * pi * u**3
    qx, qy = q[:, None] * np.sin(angle), q[:, None] * np.cos(angle)
    return qx, qy, 4 * (q * radial)[:, None] * angular * 1e4


def by_waves(speed, response):
    """The rms and the correlation across of waves μvσ_q/κ times a response, by a sum."""
    qx, qy, weights = cartesian()
    power = weights * np.abs(response(qx, qy)) ** 2 * (MU * speed / KAPPA) ** 2
    return sqrt(power.sum()), lambda y: float((power * np.cos(qy * y)).sum())


def root(qx, qy, speed):
    return np.sqrt(qx**2 + qy**2 - 1j * qx * speed / DIFFUSIVITY)


VIEWS = {
    "resolution": (
        View(resolution=30e-6),
        lambda x, y, v: np.exp(-(x**2 + y**2) * (30e-6 / 2.354820045) ** 2 / 2) / root(x, y, v),
    ),
    "smear": (View(smear=1e-3), lambda x, y, v: np.sinc(x * 1e-3 / 2 / pi) / root(x, y, v)),
    "slid": (
        View(slid_distance=1e-3),
        lambda x, y, v: erf(root(x, y, v) * sqrt(DIFFUSIVITY * 1e-3 / v)) / root(x, y, v),
    ),
    "behind": (
        View(resolution=30e-6, behind=1e-4, contact_length=1e-3),
        lambda x, y, v: (
            np.exp(-(y**2) * (30e-6 / 2.354820045) ** 2 / 2)
            * (erfc(fast(x, y, v) * 1e-2) - erfc(fast(x, y, v) * sqrt(1.1e-3)))
            / (fast(x, y, v) * sqrt(v / DIFFUSIVITY))
        ),
    ),
    "all": (
        View(resolution=20e-6, smear=2e-4, slid_distance=4e-4),
        lambda x, y, v: (
            np.exp(-(x**2 + y**2) * (20e-6 / 2.354820045) ** 2 / 2)
            * np.sinc(x * 2e-4 / 2 / pi)
            * erf(root(x, y, v) * sqrt(DIFFUSIVITY * 4e-4 / v))
            / root(x, y, v)
        ),
    ),
}


def fast(qx, qy, speed):
    return np.sqrt(qy**2 * DIFFUSIVITY / speed - 1j * qx)


@pytest.mark.parametrize("name", VIEWS)
def test_the_picture_is_the_sum_of_its_waves(name):
    view, response = VIEWS[name]
    for speed in SPEEDS:
        rms, correlation = by_waves(speed, lambda x, y, v=speed: response(x, y, v))
        assert seen(speed, view) == pytest.approx(rms, rel=2e-6)
    half = width(speed, view) / 2
    assert correlation(half) == pytest.approx(rms**2 / 2, rel=1e-5)
    assert all(correlation(half * part) > rms**2 / 2 for part in (0.5, 0.9, 0.99))


@pytest.mark.parametrize("skin", [None, (2e-6, 0.3, 2e-7)])
def test_without_a_camera_the_rms_is_that_of_flash(skin):
    heat = {**SHARP, "skin": skin, "heat_depth": 0.0 if skin is None else 1e-6}
    speeds = [0.0, -2.0, 1e-3, 0.3, 35.0, 1e3]
    exact = flash.rms_temperature(speeds, stress_spectrum=Band(), **heat)
    got = camera.seen_rms(speeds, stress_spectrum=Band(), **heat)
    np.testing.assert_allclose(got, exact, rtol=2e-9)


def test_a_slow_blurred_picture_is_closed():
    # T = q̇/κq: T_rms² = (μv/κ)² 2π ∫ e^(−q²b²)/q |σ_q|² dq
    b, speed = 20e-6 / sqrt(8 * np.log(2)), 1e-9
    waves = pi * 1e4 * (exp1((2e4 * b) ** 2) - exp1((8e4 * b) ** 2))
    got = seen(speed, View(resolution=20e-6))
    assert got == pytest.approx(MU * speed / KAPPA * sqrt(waves), rel=1e-6)


def test_the_width_of_one_slow_wave_is_that_of_a_bessel_function():
    # J₀(qy) = 1/2 at qy = 1.521144
    assert width(1e-9, View(), Band(5e4, 5.0001e4)) == pytest.approx(2 * 1.5211444 / 5e4, rel=1e-4)
    assert j0(1.5211444) == pytest.approx(0.5, abs=1e-6)


def test_a_short_slide_warms_each_point_for_itself():
    # T = 2q̇√(t/π)/√(κρc): T_rms² = (μv/κ)² 4DL/(πv) g(0)
    speed, g = 35.0, 2 * pi * 1e4 * (8e4**2 - 2e4**2) / 2
    for slid, error in ((1e-7, 1e-3), (1e-8, 1e-4)):
        short = MU * speed / KAPPA * sqrt(4 * DIFFUSIVITY * slid / (pi * speed) * g)
        assert seen(speed, View(slid_distance=slid)) == pytest.approx(short, rel=error)


@pytest.mark.parametrize("speed", SPEEDS)
def test_sharp_and_blurred_limits_of_the_picture(speed):
    whole = seen(speed, View())
    losses = [1 - seen(speed, View(resolution=w)) / whole for w in (1e-6, 2e-6)]
    assert losses[1] / losses[0] == pytest.approx(4, abs=0.05)
    assert seen(speed, View(resolution=1e-3)) < 1e-9 * whole
    losses = [1 - seen(speed, View(smear=each)) / whole for each in (1e-6, 2e-6)]
    assert losses[1] / losses[0] == pytest.approx(4, abs=0.05)
    # a long exposure leaves the waves along sliding: T_rms² ~ 1/l
    long = [seen(speed, View(smear=each)) for each in (0.1, 0.4)]
    assert long[0] / long[1] == pytest.approx(2, rel=0.02)
    grown = [seen(speed, View(slid_distance=each)) for each in (1e-3, 1e2)]
    assert grown[0] <= grown[1] * (1 + 1e-9)
    assert grown[1] == pytest.approx(whole, rel=1e-6)


def test_a_line_at_the_edge_shows_the_picture_at_it():
    # conduction along sliding does not count: the error falls as 1/v
    errors = []
    for speed in (35.0, 350.0, 3500.0):
        at_edge = seen(speed, View(behind=0.0, contact_length=1e-3))
        errors.append(at_edge / seen(speed, View(slid_distance=1e-3)) - 1)
    assert errors[0] < 6e-4
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.15)


def strip(speed, d, length, wavenumber):
    """Mean square over directions of waves of heat on a strip, at the distance d behind it, in units of q̇/κ."""
    w = speed / 2 / DIFFUSIVITY
    u, weight = np.polynomial.legendre.leggauss(400)
    u, weight = d + length * (u + 1) / 2, length / 2 * weight
    s, share = np.polynomial.legendre.leggauss(300)
    angle, share = pi / 2 * ((s + 1) / 2) ** 3, share * 3 / 2 * ((s + 1) / 2) ** 2
    total = 0.0
    for psi, part in zip(angle, share, strict=True):
        qx, qy = wavenumber * np.sin(psi), wavenumber * np.cos(psi)
        decay = np.hypot(qy, w)
        bessel = k0e(u * decay) * np.exp(u * (w - decay))
        total += part * abs(np.sum(weight * bessel * np.exp(1j * qx * u)) / pi) ** 2
    return total


@pytest.mark.parametrize("length", [2e-4, 1e-3])
def test_behind_a_strip_of_waves_of_heat(length):
    # the fast limit errs by some D/vd: from 100 to 400 some five times less
    d, q = 1e-4, 3e4
    band = Band(q * (1 - 1e-6), q * (1 + 1e-6))
    power = 2 * pi * 1e4 * q * (2e-6 * q)
    errors = []
    for number in (100.0, 400.0):
        speed = number * DIFFUSIVITY / d
        exact = MU * speed / KAPPA * sqrt(power * strip(speed, d, length, q))
        errors.append(seen(speed, View(behind=d, contact_length=length), band) / exact - 1)
    assert errors[0] < 0.01
    assert errors[0] / errors[1] == pytest.approx(5, rel=0.3)


def test_both_directions_of_sliding_look_alike():
    view = View(behind=1e-5, contact_length=1e-3)
    assert seen(-3.0, view) == seen(3.0, view)
    assert width([3.0, -3.0], view)[1] == width(3.0, view)


def test_a_long_contact_behind_is_that_of_the_slid_distance():
    endless = View(behind=1e-5, slid_distance=1e-3)
    assert seen(3.0, endless) == seen(3.0, View(behind=1e-5, contact_length=1e-3))


@pytest.mark.parametrize(
    ("view", "match"),
    [
        (View(resolution=-1e-6), r"resolution = -1e-06 m must not be negative"),
        (View(smear=inf), "smear holds values that are NaN or infinite"),
        (View(slid_distance=0.0), "slid_distance = 0 m must be positive"),
        (View(behind=1e-5, smear=1e-3), "smear = 0.001 m with behind"),
    ],
)
def test_a_camera_that_sees_nothing_is_refused(view, match):
    with pytest.raises(ValueError, match=match):
        seen(1.0, view)


def test_a_skin_is_refused_but_in_steady_sliding():
    skin = {"skin": (1e-6, 1.0, 1e-6), "stress_spectrum": Band(), **SHARP}
    with pytest.raises(ValueError, match="steady sliding only"):
        camera.seen_rms(1.0, view=View(slid_distance=1e-3), **skin)


def test_a_line_behind_a_contact_at_rest_has_no_width():
    with pytest.raises(ValueError, match="the picture is uniform"):
        width(0.0, View(behind=1e-5))


def test_quadratures_that_disagree_are_refused(monkeypatch):
    monkeypatch.setattr("theory.picture.ACCURACY", 1e-17)
    with pytest.raises(QuadratureError, match=r"relative error .* above 1e-17"):
        seen(1.0, View(smear=1e-3, slid_distance=1e-3))
