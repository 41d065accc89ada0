"""Mean temperature of a heated disc against integrals over waves and ages that share no code with it."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from refused_cases import assert_refused
from scipy.integrate import quad
from scipy.special import erf, j0, j1, jv

from theory import background, hertz
from theory.disc import mean_rise, remaining

POINTS, WEIGHTS = leggauss(16)
YOUNG = 1e-7  # age up to which only the rim of the disc counts
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}


def on(edges):
    """Gauss points and weights between all edges."""
    half = np.diff(edges) / 2
    points = edges[:-1, None] + half[:, None] * (1 + POINTS)
    return points.ravel(), (half[:, None] * WEIGHTS).ravel()


def under_the_disc(age, moved):
    """S as the integral over waves, (2/q) J₁² J₀(ql) e^(−q²t), in blocks of ages alike."""
    found = np.empty(age.size)
    octave = np.floor(np.log2(age))
    for each in np.unique(octave):
        these = np.flatnonzero(octave == each)
        end = 6.0 / sqrt(2.0**each)
        q, weight = on(np.linspace(0.0, end, 3 + int(end * (2 + moved[these].max()) / 5)))
        decay = np.exp(-(q**2) * age[these, None]) * j0(q * moved[these, None])
        found[these] = decay @ (weight * 2 / q * j1(q) ** 2)
    return found


def by_waves(time, way, lap=inf):
    """U by Gauss panels over the ages, narrow about whole laps; `way` is the distance moved in an age."""
    end = min(time, lap / 2)
    root, weight = on(np.linspace(sqrt(YOUNG), sqrt(end), 13))
    total = 2 / sqrt(pi) * under_the_disc(root**2, way(root**2)) @ weight
    total += 2 * sqrt(YOUNG / pi) - 2 * YOUNG / pi  # S = 1 − 2√(t/π)
    if time > end:
        near = np.array([-0.5, -0.2, -0.07, -0.02, 0.0, 0.02, 0.07, 0.2])
        edges = np.append((np.arange(1, time / lap + 1)[:, None] + near).ravel() * lap, time)
        age, weight = on(np.append(edges[edges < time], time))
        total += under_the_disc(age, way(age)) / np.sqrt(pi * age) @ weight
    return total


@pytest.mark.parametrize(
    ("time", "mean"), [(0.01, 0.10648), (0.1, 0.29398), (1, 0.58763), (10, 0.76035)]
)
def test_disc_at_rest_is_a_sum_of_waves(time, mean):
    q, weight = on(np.linspace(0, 4000, 16000))
    waves = 2 * (j1(q) / q) ** 2 * erf(q * sqrt(time)) @ weight + 1 / (pi * 4000**2)
    assert mean_rise(time, 0.0) == pytest.approx(waves, rel=1e-9)
    assert mean_rise(time, 0.0) == pytest.approx(mean, abs=5e-6)


def test_disc_at_rest_tends_to_8_over_3_pi():
    assert mean_rise(inf, 0.0) == pytest.approx(8 / (3 * pi), rel=1e-12)
    # what is missing falls as 1/(2√(πτ)): heat of that age is spread over a half-space
    missing = [(8 / (3 * pi) - mean_rise(t, 0.0)) * 2 * sqrt(pi * t) for t in (1e4, 1e6)]
    assert missing == pytest.approx([1, 1], rel=1e-4)


def test_disc_soon_after_the_start_is_a_plane():
    # less the heat that has left over the edge, (2/a)√(Dt/π) of its area
    for time, peclet in [(1e-4, 0.0), (1e-6, 0.0), (1e-6, 3.0)]:
        plane = 2 * sqrt(time / pi)
        assert 1 - mean_rise(time, peclet) / plane == pytest.approx(
            sqrt(time / pi), rel=2e-2 * sqrt(time * 1e4) + 1e-4
        )


@pytest.mark.parametrize("peclet", [1e-4, 0.1, 1.0, 7.3, 100.0, 1e4, 1e7])
def test_steady_disc_is_the_moving_source(peclet):
    assert mean_rise(inf, peclet) == pytest.approx(hertz.disc_mean_temperature(peclet), rel=1e-8)


@pytest.mark.parametrize(("time", "peclet"), [(0.5, 1.0), (0.02, 100.0), (0.01, 100.0), (2.0, 4.0)])
def test_disc_that_slides_for_a_time(time, peclet):
    exact = by_waves(time, lambda age: peclet * age)
    assert mean_rise(time, peclet) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize(
    ("time", "peclet", "track"),
    [(1.0, 5.0, 2.0), (3.0, 5.0, 2.0), (0.7, 40.0, 1.0), (21.3, 30.0, 1.5)],
)
def test_disc_on_a_ring_meets_its_own_heat(time, peclet, track):
    # the last has 68 laps, of which all but the first and the last ones are replaced by their mean
    def way(age):
        return 2 * track * np.abs(np.sin(peclet * age / (2 * track)))

    exact = by_waves(time, way, 2 * pi * track / peclet)
    assert mean_rise(time, peclet, track) == pytest.approx(exact, rel=3e-9)


def test_steady_ring_is_a_sum_of_harmonics():
    # Graf: J₀(2qρ|sin φ/2|) = Σ J_m(qρ)² cos mφ, and each harmonic has 1/√(q² + imPe/ρ); straight where q is large
    peclet, track, end = 3.0, 2.0, 31.5 * pi / 2  # where cos 2q = 0: J₁² beyond is 1/πq to 1/q²
    q, weight = on(np.linspace(0, np.sqrt(end), 120) ** 2)
    turns = sum(
        jv(m, q * track) ** 2 * (1 / np.sqrt(q**2 + 1j * m * peclet / track)).real * (1 + (m > 0))
        for m in range(140)
    )
    exact = (2 / q * j1(q) ** 2 * turns) @ weight + 1 / (pi * end**2)
    assert mean_rise(inf, peclet, track) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("track", [pytest.param(1.0, marks=pytest.mark.slow), 8.33])
def test_fast_ring_is_an_annulus_for_ever(track):
    def waves(q):
        return 2 * (j1(q) / q) ** 2 * j0(q * track) ** 2

    q, weight = on(np.linspace(0, 400, 8000))
    exact = waves(q) @ weight
    # the passing disc adds its own steady mean, which falls as Pe^(−1/2)
    above = [mean_rise(inf, peclet, track) - exact for peclet in (1e6, 1e8)]
    assert above[0] / above[1] == pytest.approx(10, rel=0.05)
    assert above[1] < 1e-3 * exact


def test_long_fast_ring_has_both_its_lap_and_its_passing():
    track, peclet = 2e3, 1e8
    q, weight = on(np.linspace(0, 15, 30000))
    annulus = (2 * (j1(q) / q) ** 2 * j0(q * track) ** 2) @ weight
    both = annulus + mean_rise(inf, peclet)
    assert mean_rise(inf, peclet, track) == pytest.approx(both, rel=0.01)


def test_slow_ring_rests_and_long_ring_is_straight():
    assert mean_rise(inf, 1e-9, 3.0) == pytest.approx(8 / (3 * pi), rel=1e-6)
    assert mean_rise(inf, 50.0, 1e9) == pytest.approx(mean_rise(inf, 50.0), rel=1e-7)
    assert mean_rise(1e-3, 50.0, 100.0) == pytest.approx(mean_rise(1e-3, 50.0), rel=1e-6)


def test_ring_is_hotter_than_straight_and_cooler_than_rest():
    for time in (0.1, inf):
        straight, ring, rest = (mean_rise(time, *way) for way in ((200.0,), (200.0, 2.0), (0.0,)))
        assert straight <= ring * (1 + 1e-9)
        assert ring < rest


@pytest.mark.parametrize(
    ("time", "peclet", "track"),
    [
        (1e-30, 0.0, inf),
        (1e30, 1e-20, 1.0),
        (1e-12, 1e12, inf),
        (1e12, 1e12, inf),
        (inf, 1e11, 1e3),
        pytest.param(2e13, 3e10, 1e3, marks=pytest.mark.slow),
    ],
)
def test_disc_of_any_size_has_a_number(time, peclet, track):
    assert 0.0 < mean_rise(time, peclet, track) <= 8 / (3 * pi)


def test_background_of_a_disc_is_q_a_over_kappa():
    at = background.temperature(
        [1e-3, inf], heat_flux=2e6, contact_radius=3e-3, speed=[-0.4, 0.4], **STEEL
    )
    exact = [
        mean_rise(7.6e-6 * 1e-3 / 9e-6, 0.4 * 3e-3 / 7.6e-6),
        mean_rise(inf, 0.4 * 3e-3 / 7.6e-6),
    ]
    assert at == pytest.approx(2e6 * 3e-3 / 30 * np.array(exact), rel=1e-12)
    ring = background.temperature(
        inf, heat_flux=2e6, contact_radius=3e-3, speed=0.4, track_radius=6e-3, **STEEL
    )
    assert ring == pytest.approx(
        2e6 * 3e-3 / 30 * mean_rise(inf, 0.4 * 3e-3 / 7.6e-6, 2.0), rel=1e-12
    )
    plane = background.temperature(1e-3, heat_flux=2e6, **STEEL)
    wide = background.temperature(1e-3, heat_flux=2e6, contact_radius=1e3, speed=0.4, **STEEL)
    assert wide == pytest.approx(plane, rel=1e-6)


def test_background_of_a_disc_with_a_skin():
    # a skin adds (q̇d/κ_s)(1 − κ_s²D/κ²D_s), under a disc as under a plane
    skin = (1e-6, 3.0, 1e-6)
    given = {"heat_flux": 2e6, "contact_radius": 3e-3, "speed": 0.4, **STEEL}
    added = background.temperature(1.0, **given, skin=skin) - background.temperature(1.0, **given)
    assert added == pytest.approx(2e6 * 1e-6 / 3 * (1 - (3 / 30) ** 2 * 7.6), rel=1e-9)


REFUSED = {
    "duration is missing: an endless plane": {"t": inf, "contact_radius": None},
    "t holds values that are NaN": {"t": np.nan},
    "contact_radius = -1 m must be positive": {"contact_radius": -1.0},
    "track_radius = 1 m is of a round contact": {"contact_radius": None, "track_radius": 1.0},
    "track_radius = 0.001 m must be at least": {"track_radius": 1e-3},
    "go with a constant heat_flux": {"heat_flux": np.sin},
    "contact_radius: heat spreads": {"skin": (1e-4, 3.0, 1e-6), "speed": 100.0},
    "speed holds values": {"speed": inf},
}


@pytest.mark.parametrize("words", REFUSED)
def test_background_of_a_disc_refuses(words):
    given = {"t": 1.0, "heat_flux": 1e6, "contact_radius": 3e-3, **STEEL} | REFUSED[words]
    if words.startswith("duration is"):
        words = "t holds values"
    assert_refused(lambda: background.temperature(**given), words)


def test_disc_of_an_age_is_the_area_in_common():
    # soon after it was released all heat is where the disc was: S = C(l)/π
    area = quad(lambda x: 4 / pi * sqrt(1 - x * x), 0.3, 1)[0]  # of two discs at the distance 0.6
    assert remaining(np.array([1e-10]), np.array([0.6]))[0] == pytest.approx(area, rel=1e-6)
