from math import pi

import numpy as np
import pytest
from power_law import Flat, PowerLaw
from scipy.special import j1

from theory import quadrature
from theory.arguments import breaks_of
from theory.hankel import hankel_transform


def primitive(spectrum):
    return quadrature.primitive(lambda q, _: spectrum(q), breaks_of(spectrum))


def test_a_power_law_over_eight_decades_is_integrated_to_rounding():
    spectrum = PowerLaw(2.0, (1e2, 1e4, 1e10), 0.8, 1.5)
    q = np.geomspace(1e2, 1e10, 97)
    low = 2.0 * 1e4 * ((np.minimum(q, 1e4) / 1e4) ** -0.5 - 1e-2**-0.5) / -0.5
    high = 2.0 * 1e4 * ((np.maximum(q, 1e4) / 1e4) ** -2.6 - 1) / -2.6
    np.testing.assert_allclose(primitive(spectrum)(q)[1:], (low + high)[1:], rtol=1e-13)


def test_the_integral_keeps_its_relative_accuracy_just_above_q_min():
    # q itself resolves the distance from q_min to 1e-16/distance: no more can be asked
    table = primitive(Flat(3.0, (1e3, 1e6)))
    distance = np.array([1e-12, 1e-9, 1e-6, 1e-3])
    q = 1e3 * (1 + distance)
    np.testing.assert_allclose(table(q), 3.0 * (q - 1e3), rtol=1e-10)


def test_nothing_is_added_outside_the_ends():
    table = primitive(Flat(3.0, (1e3, 1e6)))
    assert table(np.array([0.0, 1e3])).tolist() == [0.0, 0.0]
    assert table(np.array([1e6, 1e30])) == pytest.approx([3.0 * (1e6 - 1e3)] * 2, rel=1e-14)


def test_the_inverse_returns_the_wavenumber_where_the_integral_is_reached():
    table = primitive(PowerLaw(2.0, (1e2, 1e4, 1e10), 0.8))
    for q in [1e2 * (1 + 1e-7), 5e3, 1e4, 3e5]:
        assert table.inverse(float(table(np.array(q)))) == pytest.approx(q, rel=1e-12)
    assert table.inverse(0.0) == pytest.approx(1e2, rel=1e-12)
    assert table.inverse(1e300) == np.inf


def test_a_kink_that_is_not_named_is_found_and_resolved():
    kink = 12345.6789
    spectrum = Flat(1.0, (1e3, 1e6))
    table = quadrature.primitive(lambda q, _: np.minimum(q, kink), breaks_of(spectrum))
    exact = (kink**2 - 1e6) / 2 + kink * (1e6 - kink)
    assert float(table(np.array(1e6))) == pytest.approx(exact, rel=1e-11)


def test_noise_is_refused_and_never_averaged():
    rng = np.random.default_rng(1)
    with pytest.raises(quadrature.QuadratureError, match="more than 20000 panels"):
        quadrature.primitive(lambda q, _: rng.uniform(size=q.shape), np.array([1.0, 2.0]))


@pytest.mark.parametrize("r", [0.0, 1e-8, 1e-5, 3e-4, 1e-2, 1.0, 1e4])
def test_the_transform_of_a_disc_is_a_bessel_function_at_any_distance(r):
    # ∫ q J₀(qr) dq = [q J₁(qr)]/r; the two ends cancel to 1e-16 of the larger
    panels = quadrature.panels_between(np.array([1e2, 1e6]))
    q, slope = panels.nodes()
    value = hankel_transform(panels, q * slope, np.array(r))
    exact = (1e6 * j1(1e6 * r) - 1e2 * j1(1e2 * r)) / r if r else (1e12 - 1e4) / 2
    assert value == pytest.approx(
        exact, abs=max(1e-12 * abs(exact), 2e-15 * 1e6 / max(r, 1e-6) + 1e-9 * 1e6 * min(r, 1))
    )


def test_the_envelope_of_the_far_transform_decays_as_the_power_three_halves():
    panels = quadrature.panels_between(np.array([1e2, 1e4]))
    q, slope = panels.nodes()
    r = np.geomspace(1, 1e3, 4)[:, None] * (1 + 1e-2 * np.linspace(0, 1, 40))
    size = np.abs(hankel_transform(panels, q * slope, r)).max(axis=1)
    bound = np.sqrt(2 * 1e4 / pi) * np.geomspace(1, 1e3, 4) ** -1.5
    assert (size <= 1.12 * bound).all()
    assert (size >= 0.8 * bound).all()


def test_the_integral_up_to_the_last_number_below_a_break_is_that_up_to_the_break():
    breaks = np.array([1.0, 2.0, 50.0])
    table = quadrature.primitive(lambda q, _: q, breaks)
    np.testing.assert_allclose(
        table(np.nextafter(breaks[1:], 0.0)), (breaks[1:] ** 2 - 1) / 2, rtol=1e-13
    )
    np.testing.assert_allclose(
        table.above(breaks[:2], np.log(breaks[1:] / breaks[:2])), table(breaks[1:]), rtol=1e-13
    )
