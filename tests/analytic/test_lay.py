"""Faces with a lay: brute force over the plane of q, exact contacts, symmetries, and refusals."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.special import erf

from theory import flash, lay, slope_frame
from theory.yielding import YieldingSpectrum

MU, KAPPA, DIFFUSIVITY, PRESSURE = 0.11, 30.0, 7.6e-6, 1e8
HEAT = {
    "nominal_pressure": PRESSURE,
    "friction_coefficient": MU,
    "conductivity": KAPPA,
    "diffusivity": DIFFUSIVITY,
}
SKIN = {"skin": (2e-6, 0.3, 2e-7), "heat_depth": 1e-6}
QUANTITIES = ("flash_temperature", "flash_gradient", "flash_laplacian")


class Band:
    """|σ_q|² = 1e4 Pa² m² from q_min to q_max."""

    breaks = (2e4, 8e4)

    def __call__(self, q):
        return np.full(np.shape(q), 1e4)


class Powered:
    """A stress of which each direction has the share m^1.4."""

    stress_spectrum = Band()
    directions = slope_frame.ISOTROPIC
    angle = 0.0

    def __init__(self, lay):
        self.lay = lay

    def own_share(self, q):
        return np.ones(np.shape(q))

    def response(self, q, ratio):
        return ratio**0.7 * np.ones(np.shape(q))


def plane(gamma, direction):
    """q_x, q_y of the face itself over the stretched band, dense where q·v = 0, and d²q."""
    q, radial = np.polynomial.legendre.leggauss(30)
    q, radial = 5e4 + 3e4 * q, 3e4 * radial
    u, angular = np.polynomial.legendre.leggauss(24)
    outer = pi / 2 * 2.0 ** -np.arange(29.0)
    outer = np.concatenate([np.linspace(1.0, 0.55, 9) * pi / 2, outer[1:], [0.0]])
    outer = np.concatenate([-outer, outer[-2::-1]])
    half = np.diff(outer)[:, None] / 2
    resting = np.arctan2(-np.cos(direction), gamma * np.sin(direction))
    angle = (resting + outer[:-1, None] + half * (1 + u)).ravel()
    angular = (half * angular).ravel()
    area = 2 * (q * radial)[:, None] * angular
    return q[:, None] * np.cos(angle) / sqrt(gamma), q[:, None] * np.sin(angle) * sqrt(gamma), area


def summed(speed, direction, gamma, weight, response):
    """(μv/κσ₀) ∫ |σ_q|² Re[response(|q|², λ², q·v/v)] d²q, the weight a function of |q|/|q′|."""
    qx, qy, area = plane(gamma, direction)
    square, along = qx**2 + qy**2, qx * np.cos(direction) + qy * np.sin(direction)
    share = area * weight(np.sqrt(square / (gamma * qx**2 + qy**2 / gamma)))
    power = 1e4 * share / share.sum() * area.sum()
    response = response(square, square - 1j * along * speed / DIFFUSIVITY, along)
    return MU * abs(speed) / KAPPA / PRESSURE * float((power * response.real).sum())


RESPONSES = {
    "flash_temperature": lambda square, root, along: 1 / np.sqrt(root),
    "flash_gradient": lambda square, root, along: 1j * along / np.sqrt(root),
    "flash_laplacian": lambda square, root, along: -square / np.sqrt(root),
}


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2])
@pytest.mark.parametrize("name", QUANTITIES)
def test_the_sum_over_the_plane_of_waves(name, direction):
    speeds = [1e-3, -0.3, 35.0]
    got = getattr(lay, name)(speeds, direction, Powered(4.0), **HEAT)
    exact = [summed(v, direction, 4.0, lambda m: m**1.4, RESPONSES[name]) for v in speeds]
    np.testing.assert_allclose(got, exact, rtol=1e-8)


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2])
def test_waves_from_rest(direction):
    for speed, slid, accuracy in ((0.3, 1e-5, 1e-8), (35.0, 1e-4, 1e-6), (35.0, 1e-3, 3e-4)):
        spread = DIFFUSIVITY * slid / speed

        for name in ("flash_temperature", "flash_gradient"):

            def young(square, root, along, name=name, spread=spread):
                return erf(np.sqrt(root * spread)) * RESPONSES[name](square, root, along)

            exact = summed(speed, direction, 4.0, lambda m: m**1.4, young)
            got = getattr(lay, name)(speed, direction, Powered(4.0), **HEAT, slid_distance=slid)
            assert got == pytest.approx(exact, rel=accuracy)


@pytest.mark.parametrize("body", [{}, SKIN])
@pytest.mark.parametrize("name", QUANTITIES)
def test_no_lay_is_the_isotropic_face(name, body):
    speeds = np.array([0.0, -2.0, 1e-3, 35.0, 1e7])
    exact = getattr(flash, name)(speeds, stress_spectrum=Band(), **HEAT, **body)
    stress = Powered(1.0)
    got = getattr(lay, name)(speeds, [[0.3], [pi / 2]], stress, **HEAT, **body)
    np.testing.assert_allclose(got, [exact, exact], rtol=1e-10 if not body else 1e-9)


def test_grooves_turned_by_a_quarter():
    along, across = (Powered(gamma) for gamma in (5.0, 0.2))
    for body in ({}, SKIN, {"slid_distance": 1e-4}):
        one = lay.flash_temperature(35.0, 0.4, along, **HEAT, **body)
        other = lay.flash_temperature(35.0, pi / 2 - 0.4, across, **HEAT, **body)
        assert one == pytest.approx(other, rel=1e-8)
        mirrored = lay.flash_temperature(-35.0, [-0.4, pi + 0.4], along, **HEAT, **body)
        assert mirrored == pytest.approx([one, one], rel=1e-8)


def test_a_long_slide_is_steady():
    stress = Powered(5.0)
    for body in ({}, SKIN):
        steady = lay.flash_temperature(35.0, 0.4, stress, **HEAT, **body)
        far = lay.flash_temperature(35.0, 0.4, stress, **HEAT, **body, slid_distance=1.0)
        assert far == pytest.approx(steady, rel=1e-6)
    with pytest.raises(ValueError, match="slid_distance"):
        lay.flash_temperature(35.0, 0.4, stress, **HEAT, **SKIN, slid_distance=1e-6)
    with pytest.raises(ValueError, match="slid_distance = 0 m"):
        lay.flash_temperature(35.0, 0.4, stress, **HEAT, slid_distance=0.0)


class PowerLaw:
    """C(q) = 1e-32 (q/2e4)^-3.6 m⁴ from q_min to q_max."""

    breaks = (2e4, 4e5)

    def __call__(self, q):
        return np.where((q >= 2e4) & (q <= 4e5), 1e-32 * (np.asarray(q) / 2e4) ** -3.6, 0.0)


def test_full_contact_is_that_of_the_waves():
    # G of the face itself is (γ + 1/γ)/2 of that of the isotropic one
    modulus = 1e11
    variance = modulus**2 / 2 * pi * 1e-32 * 2e4**3.6 * (4e5**0.4 - 2e4**0.4) / 0.4 * (4 + 0.25) / 2
    stress = lay.stress_of_lay(
        PowerLaw(), 4.0, effective_modulus=modulus, nominal_pressure=8 * sqrt(variance)
    )
    assert stress.stress_spectrum.contact_fraction == pytest.approx(1.0, abs=1e-9)
    q, m = np.geomspace(2.1e4, 3.9e5, 5), np.linspace(0.5, 2.0, 4)
    exact = (modulus * q / 2) ** 2 * PowerLaw()(q) * (4 + 0.25) / 2
    np.testing.assert_allclose(stress.stress_spectrum(q), exact, rtol=2e-3)
    np.testing.assert_allclose(stress.own_share(q), 1.0, atol=1e-6)
    np.testing.assert_allclose(stress.response(q[:, None], m), np.tile(m, (5, 1)), rtol=1e-6)


def gauss(edges, count):
    """Nodes and weights between edges."""
    x, w = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()


def by_law(direction, gamma, law, weights):
    """T_flash at 35 m/s by a sum over the plane of q′: `weights` of q′ (n, 1) and m, their means taken here."""
    log_q, radial = gauss(np.log(law.breaks), 12)
    q = np.exp(log_q)[:, None]
    steps = np.append(0.0, pi / 2 * 2.0 ** -np.arange(25.0)[::-1])
    angle, width = gauss(np.unique(np.concatenate([-steps, steps, [-0.9, -1.2, 0.9, 1.2]])), 10)
    angle += np.arctan2(-np.cos(direction), gamma * np.sin(direction))
    along, across = np.cos(angle) / sqrt(gamma), np.sin(angle) * sqrt(gamma)
    m = np.hypot(along, across)
    turns = pi * (np.arange(200) + 0.5) / 200
    ring = np.hypot(np.cos(turns) / sqrt(gamma), np.sin(turns) * sqrt(gamma))
    advection = along * np.cos(direction) + across * np.sin(direction)
    heat = (1 / np.sqrt(q**2 * m**2 - 1j * q * advection * 35.0 / DIFFUSIVITY)).real
    total = 0.0
    for share, weight in weights(q, m, ring):
        part = (share * weight[0] / weight[1].mean(axis=1, keepdims=True) * heat) @ width
        total += 2 * float((q[:, 0] ** 2 * law(q[:, 0]) * part) @ radial)
    return MU * 35.0 / KAPPA / PRESSURE * total


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2])
def test_waves_meet_the_interface_in_series(direction):
    law = YieldingSpectrum(PowerLaw(), 8e15, 1e8, 1e9)
    modulus = 5e15

    def weights(q, m, ring):
        # κ of a wave of true wavenumber mq′: 1/κ = ⟨c⟩ + 2/(E*mq′)
        kappa = [1 / (law.compliance(q) + 2 / (modulus * q * each)) for each in (m, ring)]
        own = law.own_share(q)
        return [(own, [k**2 for k in kappa]), (1 - own, [k**0.8 for k in kappa])]

    exact = by_law(direction, 5.0, law, weights)
    got = lay.flash_temperature(35.0, direction, lay.LayStress(law, 5.0, modulus), **HEAT)
    assert got == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2])
def test_full_contact_is_as_hot_as_its_waves(direction):
    # σ_q = E*|q|h_q/2
    modulus, gamma = 1e11, 4.0
    stress = lay.stress_of_lay(
        PowerLaw(), gamma, effective_modulus=modulus, nominal_pressure=PRESSURE
    )

    class Whole(PowerLaw):
        def __call__(self, q):
            return (modulus * q / 2) ** 2 * super().__call__(q)

    def weights(q, m, ring):
        return [(np.ones_like(q), [q**0 * m**2, np.ones((q.size, 1))])]

    exact = by_law(direction, gamma, Whole(), weights)
    got = lay.flash_temperature(35.0, direction, stress, **HEAT)
    assert got == pytest.approx(exact, rel=3e-3)


def test_a_hardness_knows_no_direction():
    for modulus, rest in ((1e20, 2e-3), (1e23, 2e-6)):  # falls as σ_P/E*
        law = YieldingSpectrum(PowerLaw(), modulus, 1e8, 1e9)
        stress, m = lay.LayStress(law, 7.0, modulus), np.array([7**-0.5, 1.0, 7**0.5])
        response = stress.response(np.array([[2.1e4], [4e5]]), m)
        np.testing.assert_allclose(response / response[:, :1], 1.0, rtol=rest)


def test_what_has_yielded_does_not_stiffen():
    load = {"nominal_pressure": 1e8, "penetration_hardness": 1e9}
    stress = lay.stress_of_lay(PowerLaw(), 7.0, effective_modulus=1e16, **load)
    law = stress.stress_spectrum
    elastic, plastic = law.between_walls()
    assert elastic < 0.3 * (elastic + plastic)
    factor = lay.stiffening(7.0, elastic)
    assert law.effective_modulus == pytest.approx(1e16 * factor, rel=1e-4)


def test_the_modulus_of_waves_of_all_directions():
    # log-mean and rms of |q|/|q′| over directions
    angle = pi / 4000 * np.arange(4000)
    m = np.sqrt(np.cos(angle) ** 2 / 7 + 7 * np.sin(angle) ** 2)
    assert lay.stiffening(7.0, 0.0) == pytest.approx(np.exp(np.log(m).mean()), rel=1e-12)
    assert lay.stiffening(7.0, 1.0) == pytest.approx(sqrt((m**2).mean()), rel=1e-12)
    assert lay.stiffening(1.0, 0.3) == 1.0
    third = lay.stiffening(7.0, 1 / 3)  # sin 30°
    assert third * 2 == pytest.approx(lay.stiffening(7.0, 0.0) + lay.stiffening(7.0, 1.0))


def test_a_lay_below_one_is_refused():
    with pytest.raises(ValueError, match=r"lay = 0.5 must be 1 or more"):
        lay.stress_of_lay(PowerLaw(), 0.5, effective_modulus=1e11, nominal_pressure=1e9)


def test_the_band_is_that_of_the_isotropic_law_and_grows():
    assert lay.error_band(1.0, 0.05) == 0.05
    assert lay.error_band(10.0, 0.08) == pytest.approx(0.1)


class Grooved:
    """C(q⃗) of a face with a lay: the power law at q′, grooves at .4 rad from x."""

    lay, angle = 2.0, 0.4

    def at(self, q, angle):
        turned = np.asarray(angle) - self.angle
        ratio = np.hypot(np.cos(turned) * sqrt(self.lay), np.sin(turned) / sqrt(self.lay))
        return PowerLaw()(q * ratio)

    def __init__(self):
        rows = np.geomspace(1.44e4, 5.5e5, 120)
        angle = (np.arange(720) + 0.5) * (pi / 720)
        level = self.at(rows[:, None], angle).mean(axis=1)
        self.mean = slope_frame.MeanSpectrum(
            tuple(np.log(rows).tolist()), tuple(np.log(level).tolist())
        )
        self.breaks = self.mean.breaks

    def __call__(self, q):
        return self.mean(np.asarray(q))


class Sum:
    """C(q⃗) = C(q)[1 + a(q) cos 2(φ − .3)], a from .9 to −.5 over C(q)."""

    breaks = PowerLaw.breaks

    def __call__(self, q):
        return PowerLaw()(q)

    def at(self, q, angle):
        uneven = 0.9 - 1.4 * np.log(q / 2e4) / np.log(20.0)
        return PowerLaw()(q) * (1 + uneven * np.cos(2 * (np.asarray(angle) - 0.3)))


@pytest.mark.parametrize("hardness", [None, 1e9])
def test_waves_of_one_lay_are_a_face_with_it(hardness):
    load = {
        "effective_modulus": 1e11,
        "nominal_pressure": 1e8,
        "penetration_hardness": hardness,
    }
    one = lay.stress_of_lay(PowerLaw(), 2.0, **load)
    other = lay.stress_of_waves(Grooved(), **load)
    assert other.lay == pytest.approx(2.0, rel=2e-3)
    assert other.angle == pytest.approx(0.4, abs=1e-3)
    angles, speeds = np.array([[0.0], [0.7], [pi / 2]]), [1.0, 35.0]
    exact = lay.flash_temperature(speeds, angles, one, **HEAT)
    got = lay.flash_temperature(speeds, angles + 0.4, other, **HEAT)
    np.testing.assert_allclose(got, exact, rtol=1e-2)


def test_the_frame_has_equal_slopes_and_all_waves():
    frame = slope_frame.slope_frame(Sum())
    # the slope tensor by its integrals: a(q) weighs q³C ~ q^−.6
    x = np.linspace(np.log(2e4), np.log(4e5), 4001)
    weight = np.exp(0.4 * x)
    uneven = weight @ (0.9 - 1.4 * (x - x[0]) / np.ptp(x)) / weight.sum() / 2
    assert frame.lay == pytest.approx(sqrt((1 + abs(uneven)) / (1 - abs(uneven))), rel=1e-3)
    assert frame.angle % pi == pytest.approx((0.3 + (pi / 2 if uneven > 0 else 0.0)) % pi)
    # at waves of the frame, C′M is C(q⃗) of the face
    q, angle = np.array([5e4, 9e4]), np.array([0.2, 1.1, 2.5])
    m = sqrt(frame.lay)
    x, y = np.cos(angle) * q[:, None] / m, np.sin(angle) * q[:, None] * m
    harmonics = frame.directions.at(q)[:, None] * frame.directions.waves(angle)
    got = frame.spectrum(q)[:, None] * harmonics.sum(axis=-1)
    exact = Sum().at(np.hypot(x, y), np.arctan2(y, x) + frame.angle)
    np.testing.assert_allclose(got, exact, rtol=3e-3)


class Turning(Sum):
    """C(q)[1 + .6 cos 2(φ − ψ)], ψ from .3 to 1.2 over C(q)."""

    def at(self, q, angle):
        turn = 0.3 + 0.3 * np.log(q / 2e4)
        return PowerLaw()(q) * (1 + 0.6 * np.cos(2 * (np.asarray(angle) - turn)))


def test_waves_of_a_turning_lay_keep_their_sides():
    frame, face = slope_frame.slope_frame(Turning()), Turning()
    q, angle = np.array([4e4, 2e5]), np.array([0.3, 1.1, 2.0, 2.8])
    m = sqrt(frame.lay)
    x, y = np.cos(angle) * q[:, None] / m, np.sin(angle) * q[:, None] * m
    harmonics = frame.directions.at(q)[:, None] * frame.directions.waves(angle)
    exact = face.at(np.hypot(x, y), np.arctan2(y, x) + frame.angle)
    got = frame.spectrum(q)[:, None] * harmonics.sum(axis=-1)
    np.testing.assert_allclose(got, exact, rtol=5e-3)


def test_light_contact_of_waves_of_own_lays_is_softer():
    # in the frame of an isotropic tensor an octave with (a − b)/(a + b) = .6 has √[(1 + .8)/2]
    rows = tuple(np.log(np.geomspace(1e4, 1e6, 41)).tolist())
    directions = slope_frame.Directions(rows, ((0.72, 0.96),) * 41)
    mean = slope_frame.MeanSpectrum(rows, tuple(-4.0 * np.array(rows)))
    frame = slope_frame.SlopeFrame(1.0, 0.0, mean, directions)
    assert frame.softer == pytest.approx(sqrt(0.9))
    assert slope_frame.SlopeFrame(1.0, 0.0, mean, slope_frame.ISOTROPIC).softer == 1.0
    # of octaves that differ the mean is over the slopes, q⁴C a step of ln q: here in proportion to q
    uneven = np.where(np.arange(41) < 38, 1.2, 0.0)
    directions = slope_frame.Directions(rows, tuple((each, 0.0) for each in uneven.tolist()))
    mean = slope_frame.MeanSpectrum(rows, tuple(-3.0 * np.array(rows)))
    steep = np.geomspace(1e4, 1e6, 41)
    exact = steep @ np.where(uneven > 0, sqrt(0.9), 1.0) / steep.sum()
    assert slope_frame.SlopeFrame(1.0, 0.0, mean, directions).softer == pytest.approx(exact)
    assert lay.stiffening(4.0, 0.0, 0.8) == pytest.approx(0.8 * 1.25)
    assert lay.stiffening(4.0, 1.0, 0.8) == pytest.approx(sqrt(2.125))


def test_waves_of_own_lays_in_the_plane():
    # 1 + .5 cos 2φ − .3 sin 4φ of a band, steady and from rest, by the plane
    rows = tuple(np.log(Band.breaks).tolist())
    stress = Powered(4.0)
    stress.directions = slope_frame.Directions(rows, ((0.5, 0.0, 0.0, -0.3),) * 2)
    stress.angle = 0.2
    direction, speed = 0.7, 3.0
    qx, qy, area = plane(4.0, direction)
    ratio = np.hypot(qx, qy) / np.hypot(2 * qx, qy / 2)
    angle = np.arctan2(qy / 2, qx * 2)
    share = area * ratio**1.4
    power = 1e4 * share / share.sum() * area.sum()
    power = power * (1 + 0.5 * np.cos(2 * angle) - 0.3 * np.sin(4 * angle))
    along = qx * np.cos(direction) + qy * np.sin(direction)
    root = np.sqrt(qx**2 + qy**2 - 1j * along * speed / DIFFUSIVITY)
    for slid in (np.inf, 3e-5):
        young = erf(root * sqrt(DIFFUSIVITY * slid / speed)) if slid < np.inf else 1.0
        exact = MU * speed / KAPPA / PRESSURE * float((power * (young / root).real).sum())
        got = lay.flash_temperature(speed, direction + 0.2, stress, **HEAT, slid_distance=slid)
        assert got == pytest.approx(exact, rel=1e-6)


def test_the_band_of_waves_of_own_lays_is_wider():
    assert lay.error_band(10.0, 0.0, own_lays=True) == pytest.approx(sqrt(0.06**2 + 0.09**2))
