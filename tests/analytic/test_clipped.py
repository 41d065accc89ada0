"""The contact as a clipped Gaussian field: closed means against drawn pairs and series, and the laws it repeats."""

from math import factorial

import numpy as np
import pytest
from numpy.polynomial.hermite_e import hermeval
from scipy.optimize import brentq
from scipy.special import erf, gamma, hyp1f1, ive, jv, ndtr, ndtri, owens_t
from yielding_cases import HARDNESS, MODULUS, SelfAffine

from theory import clipped, persson, plasticity

STEEL = {
    "effective_modulus": MODULUS,
    "nominal_pressure": 0.1 * HARDNESS,
    "penetration_hardness": HARDNESS,
}
YIELDED, PARTLY = SelfAffine(level=1e-24), SelfAffine(level=1e-26, q_max=2e6)


def hermite_coefficients(levels, heights, degree):
    """⟨F h_k⟩ of F = Σ h 1(z > u) with normalised Hermite polynomials: φ(u) He_(k−1)(u)/√k!, and P(z > u) for k = 0."""
    normal = np.exp(-(levels**2) / 2) / np.sqrt(2 * np.pi)
    later = [
        heights @ (normal * hermeval(levels, np.eye(degree)[k - 1])) / np.sqrt(float(factorial(k)))
        for k in range(1, degree)
    ]
    return np.array([heights @ ndtr(-levels), *later])


def test_one_step_has_the_probability_that_two_normal_heights_exceed_it():
    u = 1.3
    table = clipped.products([u], [1.0])
    p = np.cos(np.linspace(0, np.pi, table.joint.size))[1:-1]
    both = ndtr(-u) - 2 * owens_t(u, np.sqrt((1 - p) / (1 + p)))
    # the trapezoidal rule over steps of π/256 of what varies within a radian
    assert table.joint[1:-1] == pytest.approx(both, abs=2e-5)
    assert table.variance == pytest.approx(ndtr(-u) * ndtr(u), rel=2e-4)


def rim_over_contact(edge, z):
    """1/(z − u + .1) less its mean over z > u, at heights z above the edge u."""
    t = np.linspace(edge, 9.0, 200_001)
    weight = np.exp(-(t**2) / 2)
    mean = np.trapezoid(weight / (t - edge + 0.1), t) / np.trapezoid(weight, t)
    return 1 / (z - edge + 0.1) - mean


@pytest.mark.slow
def test_products_are_those_of_the_hermite_series():
    levels, heights = np.array([-0.4, 0.7, 1.5]), np.array([0.3, 1.0, 2.0])
    height = heights @ ndtr(-levels) / ndtr(0.4)  # the contact has the mean of the pressure
    c = hermite_coefficients(levels, heights, 120)
    g = hermite_coefficients(levels[:1], np.array([height]), 120)
    table = clipped.products(levels, heights)
    z = np.linspace(-0.4, 9.0, 20_001)
    rim = height * rim_over_contact(-0.4, z) * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    h, factorials = np.zeros(c.size), np.sqrt(np.cumprod(np.append(1.0, np.arange(1.0, 120.0))))
    for n in range(c.size):
        h[n] = np.trapezoid(rim * hermeval(z, np.eye(c.size)[n]) / factorials[n], z)
    angle = np.linspace(0, np.pi, table.joint.size)
    p = np.cos(angle)
    k = np.arange(c.size)
    near = np.abs(p) < 0.85  # 0.85^120 is 3e-9

    def series(first, second):
        terms = min(first.size, second.size)
        return p[near, None] ** k[:terms] @ (first[:terms] * second[:terms])

    of_slope, of_step = np.sqrt(k[1:]) * c[1:], np.sqrt(k[1:]) * g[1:]  # of F_z and G_z
    of_rim = np.sqrt(k[1:]) * h[1:]
    expected = [
        series(c, c),
        series(c, g),
        series(of_slope, g),
        series(c, of_step),
        series(g, g),
        series(of_step, g),
        series(of_step, of_step) * np.sin(angle[near]),
    ]
    with_rim = [
        series(of_slope, h),
        series(g, h),
        series(of_step, h),
        series(of_step, of_rim) * np.sin(angle[near]),
        series(h, h),
        series(of_rim, of_rim) * np.sin(angle[near]),
    ]
    assert table.level == -0.4
    for found, values in zip(table.table[:7, near], expected, strict=True):
        assert found == pytest.approx(values, rel=2e-5, abs=1e-5)
    for found, values in zip(table.table[7:, near], with_rim, strict=True):
        assert found == pytest.approx(values, rel=1e-3, abs=2e-3)  # 48 steps


def test_the_contact_may_reach_beyond_the_lowest_step_of_the_pressure():
    table = clipped.products([0.3, 0.9], [1.0, 2.0], -0.2)
    mean = ndtr(-0.3) + 2.0 * ndtr(-0.9)
    assert table.level == -0.2
    # all means of places far apart are those of F, but 0 of the rim
    middle = table.joint.size // 2
    assert table.table[[0, 1, 4], middle] == pytest.approx(mean**2, rel=1e-12)
    assert table.table[[8, 11], middle] == pytest.approx(0.0, abs=1e-12)
    assert table.table[4, 0] == pytest.approx(mean**2 / ndtr(0.2), rel=1e-3)
    assert clipped.products([0.3, 0.9], [1.0, 2.0], 0.5).level == 0.3


@pytest.mark.parametrize(
    ("own", "other", "part"),
    [
        (0.6, -0.2, 0.2),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in ((0.9, 0.3, 0.5), (0.1, 0.8, 0.7), (0.97, 0.9, 0.5), (0.5, 0.5, 0.4))
        ),
    ],
)
def test_shared_products_are_those_of_drawn_normal_heights(own, other, part):
    levels, heights = np.array([-0.8, 1.1, 1.2]), np.array([0.5, 1.0, 1.5])
    rng = np.random.default_rng([int(100 * own), int(100 * part)])
    draws = 300_000
    # z, χ and ζ of both bodies, here and there; χ is odd
    odd, even, alike = (0.05, -0.03), (0.9 * own, 0.8 * other), 0.7
    level = 0.7 * own + 0.04 * (1 - own), 0.7 * other - 0.1 * (1 - other)
    turned, potentials = (0.02, -0.03), (0.96 * own, 0.95 * other)
    given = [
        clipped.Correlations(*map(np.asarray, values))
        for values in zip((own, other), odd, even, level, turned, potentials, strict=True)
    ]
    here = np.array([[1.0, 0.0, alike], [0.0, 1.0, 0.0], [alike, 0.0, 1.0]])
    bodies = []
    for rho, n, c, lv, t, k in given:
        across = np.array([[rho, n, lv], [-n, c, -t], [lv, t, k]])
        covariance = np.block([[here, across], [across.T, here]])
        bodies.append(rng.multivariate_normal(np.zeros(6), covariance, draws, method="cholesky").T)
    weighted = []
    for place in (slice(0, 3), slice(3, 6)):
        (first, first_chi, first_zeta), (second, second_chi, second_zeta) = (
            body[place] for body in bodies
        )
        z = np.sqrt(1 - part) * first + np.sqrt(part) * second
        psi = np.sqrt(part) * first - np.sqrt(1 - part) * second
        chi = np.sqrt(1 - part) * first_chi + np.sqrt(part) * second_chi
        zeta = np.sqrt(1 - part) * first_zeta + np.sqrt(part) * second_zeta
        # ⟨Gζ⟩ = a⟨Gz⟩, and ⟨z; z > u⟩ is the normal density at u
        zeta -= alike * np.exp(-(levels[0] ** 2) / 2) / np.sqrt(2 * np.pi) / ndtr(-levels[0])
        pressure = (z[:, None] > levels) @ heights
        contact = (z > levels[0]) * (heights @ ndtr(-levels) / ndtr(-levels[0]))
        weighted.append(
            (
                pressure,
                contact - pressure,
                contact * psi,
                contact
                * np.where(contact > 0, rim_over_contact(levels[0], np.maximum(z, levels[0])), 0)
                * psi,
                contact * chi,
                contact * zeta,
            )
        )
    values = clipped.products(levels, heights).shared(*given, part, alike)
    mean = (heights @ ndtr(-levels)) ** 2
    for value, (i, j) in zip(values, clipped.PAIRS, strict=True):
        drawn = weighted[0][i] * weighted[1][j] - (mean if i == j == 0 else 0.0)
        # four standard errors, and 1e-3 of the heights' squares for the table
        assert value == pytest.approx(drawn.mean(), abs=4 * drawn.std() / np.sqrt(draws) + 1e-3)


def test_the_riesz_transform_of_a_gaussian_correlation_is_closed():
    # half of the area is in contact: ⟨FF′⟩ − ¼ = arcsin ρ/2π; S is e^(−q²/2) for ρ = e^(−r²/2)
    r = np.exp(np.arange(-4096, 4096) * 2e-3 + 1e-3)
    rho = np.exp(-(r**2) / 2)
    steps = np.array([0.0]), np.array([1.0])
    field = clipped.ClippedField(
        *steps, r, np.arcsin(rho) / (2 * np.pi), 0.25, clipped.products(*steps)
    )
    first, second = field.riesz(100.0)
    near = (r > 0.1) & (r < 10.0)
    r = r[near]
    expected = np.sqrt(np.pi / 8) * r * (ive(0, r**2 / 4) - ive(1, r**2 / 4))
    assert first[near] == pytest.approx(expected, abs=3e-4)
    assert second[near] == pytest.approx(2 * (1 - rho[near]) / r**2 - rho[near], abs=3e-4)


def test_the_half_potential_of_a_gaussian_correlation_is_closed():
    r = np.exp(np.arange(-4096, 4096) * 3.2e-3 + 1.6e-3)
    rho = np.exp(-(r**2) / 2)
    steps = np.array([0.0]), np.array([1.0])
    field = clipped.ClippedField(
        *steps, r, np.arcsin(rho) / (2 * np.pi), 0.25, clipped.products(*steps)
    )
    found = field.half_potential(100.0)
    # Weber: ∫ q^(μ − 1) e^(−q²/2) J_k(qr) dq; ⟨ζ²⟩ = ∫ e^(−q²/2) dq
    unit = np.sqrt(np.pi / 2)
    expected = (
        gamma(0.75) * 2**-0.25 * hyp1f1(0.75, 1.0, -(r**2) / 2) / np.sqrt(unit),
        r * gamma(1.25) * 2**-0.75 * hyp1f1(1.25, 2.0, -(r**2) / 2) / np.sqrt(unit),
        ive(0, r**2 / 4),
    )
    for values, exact in zip(found, expected, strict=True):
        assert values[r < 10.0] == pytest.approx(exact[r < 10.0], abs=3e-4)


def test_heights_have_no_negative_power():
    # ρ = (e^(−r²/2) − a e^(−r²/2w²))/(1 − a), with the power (e^(−q²/2) − a w² e^(−w²q²/2))/(1 − a): negative below q₀
    a, width = 0.05, 8.0
    r = np.exp(np.arange(-4096, 4096) * 3.2e-3 + 1.6e-3)
    rho = (np.exp(-(r**2) / 2) - a * np.exp(-((r / width) ** 2) / 2)) / (1 - a)
    steps = np.array([0.0]), np.array([1.0])
    field = clipped.ClippedField(
        *steps, r, np.arcsin(rho) / (2 * np.pi), 0.25, clipped.products(*steps)
    )
    first = np.sqrt(2 * np.log(a * width**2) / (width**2 - 1))
    q = np.linspace(first, 8.0, 5_001)
    power = q * (np.exp(-(q**2) / 2) - a * width**2 * np.exp(-((width * q) ** 2) / 2))
    near = (r > 0.1) & (r < 30.0)
    some = np.flatnonzero(near)[::100]

    def transformed(order, weight=1.0):
        waves = jv(order, np.multiply.outer(r[some], q)) * power * weight
        return (waves[:, 1:] + waves[:, :-1]).sum(axis=1)

    variance, potential = ((values[1:] + values[:-1]).sum() for values in (power, power / q))
    unit = np.sqrt(variance * potential)
    assert field.possible_correlation(1e3)[some] == pytest.approx(
        transformed(0) / variance, abs=5e-4
    )
    first_order, second_order = field.riesz(1e3)
    assert first_order[some] == pytest.approx(transformed(1) / variance, abs=5e-4)
    assert second_order[some] == pytest.approx(transformed(2) / variance, abs=5e-4)
    found = field.half_potential(1e3)
    expected = (
        transformed(0, q**-0.5) / unit,
        transformed(1, q**-0.5) / unit,
        transformed(0, 1 / q) / potential,
    )
    for values, exact in zip(found, expected, strict=True):
        assert values[some] == pytest.approx(exact, abs=5e-4)


@pytest.mark.parametrize("turn", [0.0, 0.4, np.pi / 2, 2.0, np.pi])
def test_waves_of_one_length_and_all_directions_have_the_correlations_of_a_riesz_transform(turn):
    # z = ∫ cos(q⃗x⃗ + phase) over all directions θ of q⃗, and χ shifts each wave by −i cos θ; N_k = J_k(qr)
    distance = np.array([0.3, 1.7, 4.0, 9.0])
    theta = np.arange(400) * 2 * np.pi / 400
    phase = np.multiply.outer(distance, np.cos(theta - turn))
    orders = jv(np.array([0, 1, 2, 0, 1, 0])[:, None], distance)  # of one length, ζ is z
    found = clipped.directed_correlations(orders, np.cos(turn))
    odd = np.sin(phase) * np.cos(theta)
    expected = (
        np.cos(phase),
        odd,
        np.cos(phase) * np.cos(theta) ** 2,
        np.cos(phase),
        odd,
        np.cos(phase),
    )
    for values, waves in zip(found, expected, strict=True):
        np.testing.assert_allclose(values, waves.mean(axis=1), atol=1e-13)


@pytest.mark.parametrize("spectrum", [YIELDED, PARTLY])
def test_the_field_repeats_the_mean_and_the_correlation_of_the_law(spectrum):
    field = clipped.clipped_field(spectrum, **STEEL)
    stress = plasticity.stress_spectrum(spectrum, **STEEL)
    r = np.geomspace(1e-8, 3e-4, 12)
    expected = persson.pressure_correlation(r, stress_spectrum=stress)
    c = hermite_coefficients(field.levels, field.heights, 150)
    assert c[0] == pytest.approx(0.1 * HARDNESS, rel=1e-9)
    rho = field.correlation(r)
    middle = np.abs(rho) < 0.9
    assert middle.sum() > 3
    share = (rho[middle, None] ** np.arange(150) @ c**2 - c[0] ** 2) / field.products.variance
    whole = float(persson.pressure_correlation(0.0, stress_spectrum=stress))
    assert share == pytest.approx(expected[middle] / whole, abs=3e-4)
    assert field.variance == pytest.approx(whole, rel=1e-9)
    assert field.products.variance == pytest.approx(whole, rel=0.01)  # 48 steps


def test_what_has_yielded_altogether_is_one_step():
    field = clipped.clipped_field(YIELDED, **STEEL)
    assert field.levels == pytest.approx(-ndtri(0.1) * np.ones(field.levels.size), abs=0.2)
    assert field.heights.sum() == pytest.approx(HARDNESS, rel=1e-12)
    assert field.pressure([0.9, 1.6]).tolist() == pytest.approx([0.0, HARDNESS])


def test_what_has_yielded_in_part_has_the_areas_of_the_law():
    field = clipped.clipped_field(PARTLY, **STEEL)
    stress = plasticity.stress_spectrum(PARTLY, **STEEL)
    z = -ndtri((np.arange(200_000) + 0.5) / 200_000)
    pressure = field.pressure(z)
    # the first and the last of the 48 steps are 6e-4 σ_P high
    assert (pressure > 0).mean() == pytest.approx(sum(stress.between_walls()), rel=0.01)
    assert (pressure > 0.999 * HARDNESS).mean() == pytest.approx(stress.plastic_fraction, rel=0.03)
    # heat crosses wherever they touch, at low pressure too
    assert ndtr(-field.products.level) == pytest.approx(stress.contact_fraction, rel=1e-9)
    assert stress.contact_fraction > 1.01 * (pressure > 0).mean()


def test_full_contact_is_a_gaussian_field():
    spectrum = SelfAffine(level=1e-29, q_max=1e6)
    mean = 0.5e11
    field = clipped.clipped_field(
        spectrum, effective_modulus=MODULUS, nominal_pressure=mean, penetration_hardness=1e11
    )
    z = np.array([-1.5, -0.5, 0.5, 1.5])
    deviation = np.sqrt(field.variance)
    assert (field.pressure(z) - mean) / deviation == pytest.approx(
        z, abs=0.2
    )  # steps of 0.3 standard deviations
    r = np.geomspace(1e-6, 1e-4, 6)
    shape = (
        np.interp(np.log(r), np.log(field.distance), field.pressure_correlation) / field.variance
    )
    assert field.correlation(r) == pytest.approx(
        shape, abs=0.012
    )  # of steps of 0.3 standard deviations


def test_elastic_contact_has_no_highest_pressure():
    spectrum = SelfAffine(level=3e-27, q_max=1e6, q_min=2e4)
    pressure = 3e8
    field = clipped.clipped_field(spectrum, effective_modulus=MODULUS, nominal_pressure=pressure)
    assert hermite_coefficients(field.levels, field.heights, 2)[0] == pytest.approx(
        pressure, rel=1e-3
    )
    assert field.products.variance == pytest.approx(field.variance, rel=0.01)
    # one wall at 0: x = σ₀/2√G has ⟨σ²⟩ = (σ₀² + 2G) erf x + 2σ₀√(G/π) e^(−x²), and erf x is the contact area

    def excess(x):
        half = (pressure / (2 * x)) ** 2
        square = (pressure**2 + 2 * half) * erf(x) + 2 * pressure * np.sqrt(half / np.pi) * np.exp(
            -(x**2)
        )
        return square - pressure**2 - field.variance

    assert ndtr(-field.levels[0]) == pytest.approx(erf(brentq(excess, 1e-3, 3.0)), rel=0.01)
