"""Power spectra: values, ends and exact moments, against formulas and quadrature written here."""

import itertools
import math
import pickle

import numpy as np
import pytest
from some_rows import some

from roughsim.scene.spectra.k_correlation import Spectrum as KCorrelation
from roughsim.surface.power_laws import PowerLaws, SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.spectrum import SumSpectrum, TruncatedSpectrum

Q_MIN, Q_ROLL_OFF, Q_MAX = 2.0e3, 3.0e4, 5.0e6
BAND = {"q_min": Q_MIN, "q_roll_off": Q_ROLL_OFF, "q_max": Q_MAX}
EXPONENTS = list(itertools.product([0.0, 0.3, 0.5, 0.8, 1.0], [0.0, 1.5, 2.0, 4.0]))
STEEL = {
    "hurst": 0.8,
    "q_min": 6350.0,
    "q_roll_off": 9.4e4,
    "q_max": 4.15e7,
    "roll_off_exponent": 1.5,
}


def shape_of(q, hurst, m, kink=Q_ROLL_OFF):
    """C(q)/C(q_roll_off) as it is defined."""
    return (q / kink) ** (-m) if q < kink else (q / kink) ** (-2 - 2 * hurst)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def integral(function, *points):
    """∫ q f(q) d(ln q) between the points: 40 Gauss points in each of eight panels in ln q, exact to rounding."""
    total = 0.0
    for left, right in itertools.pairwise(np.log(points)):
        for start, end in itertools.pairwise(np.linspace(left, right, 9)):
            q = np.exp(start + (end - start) * (NODES + 1) / 2)
            total += (end - start) / 2 * (WEIGHTS @ (q * function(q)))
    return total


def quadrature(order, hurst, m, ends=(Q_MIN, Q_MAX)):
    """2π ∫ q^(1+order) C/C(q_roll_off) dq, piece by piece."""
    low, high = min(Q_ROLL_OFF, ends[1]), ends[1]
    total = integral(lambda q: q ** (1 + order) * (q / Q_ROLL_OFF) ** -m, ends[0], low)
    if high > low:
        total += integral(
            lambda q: q ** (1 + order) * (q / Q_ROLL_OFF) ** (-2 - 2 * hurst), low, high
        )
    return 2 * np.pi * total


@pytest.mark.parametrize(("hurst", "m"), EXPONENTS)
def test_two_branches_meet_at_the_roll_off(hurst, m):
    spectrum = SelfAffineSpectrum(3e-22, hurst, roll_off_exponent=m, **BAND)
    q = np.geomspace(Q_MIN, Q_MAX, 50)[1:-1]
    expected = [3e-22 * shape_of(value, hurst, m) for value in q]
    np.testing.assert_allclose(spectrum(q), expected, rtol=1e-12)
    for side in (1 - 1e-14, 1.0, 1 + 1e-14):
        assert spectrum(Q_ROLL_OFF * side) == pytest.approx(3e-22, rel=1e-12)


def test_the_ends_are_sharp_and_belong_to_the_band():
    spectrum = SelfAffineSpectrum(3e-22, 0.8, roll_off_exponent=1.5, **BAND)
    assert spectrum(Q_MIN) == pytest.approx(3e-22 * (Q_MIN / Q_ROLL_OFF) ** -1.5, rel=1e-13)
    assert spectrum(Q_MAX) == pytest.approx(3e-22 * (Q_MAX / Q_ROLL_OFF) ** -3.6, rel=1e-13)
    outside = [0.0, 1e-3, np.nextafter(Q_MIN, 0), np.nextafter(Q_MAX, np.inf), 1e12, np.inf]
    assert (spectrum(np.array(outside)) == 0).all()
    assert spectrum.breaks == (Q_MIN, Q_ROLL_OFF, Q_MAX)


def test_a_number_gives_a_number_and_an_array_keeps_its_shape():
    spectrum = SelfAffineSpectrum(3e-22, 0.8, **BAND)
    assert type(spectrum(1e5)) is float
    assert spectrum(np.full((3, 4), 1e5)).shape == (3, 4)
    assert type((spectrum + spectrum)(1e5)) is float


@pytest.mark.parametrize(("hurst", "m"), some(EXPONENTS, 2))
@pytest.mark.parametrize("order", [0, 2, 4, 1])
def test_moments_are_exact_including_the_logarithms(hurst, m, order):
    # H = 1 at order 2, H = 0 at order 0, m = 2 at order 0 and m = 4 at order 2 are logarithms
    spectrum = SelfAffineSpectrum(3e-22, hurst, roll_off_exponent=m, **BAND)
    assert spectrum.moment(order) == pytest.approx(3e-22 * quadrature(order, hurst, m), rel=1e-12)


@pytest.mark.parametrize("tiny", [1e-3, 1e-8, 1e-13, 1e-16])
def test_moments_pass_smoothly_into_the_logarithm(tiny):
    # ∫ q^(t−1) dq from 1 to e^s is s + t s²/2 + t² s³/6 + …; (e^(ts) − 1)/t as it stands loses all digits
    near = SelfAffineSpectrum(1.0, 1.0 - tiny / 2, q_min=1.0, q_roll_off=1.0, q_max=1e3)
    span, rest = np.log(1e3), 4 - (2 + 2 * near.hurst)  # what is left of `tiny` after rounding
    exact = 2 * np.pi * sum(rest**k * span ** (k + 1) / math.factorial(k + 1) for k in range(6))
    assert near.moment(2) == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize(("hurst", "m"), EXPONENTS)
def test_rms_height_is_what_was_asked_for(hurst, m):
    spectrum = SelfAffineSpectrum.from_rms_height(9e-7, hurst=hurst, roll_off_exponent=m, **BAND)
    level = 9e-7**2 / quadrature(0, hurst, m)
    assert spectrum(Q_ROLL_OFF) == pytest.approx(level, rel=1e-12)
    assert spectrum.rms_height == pytest.approx(9e-7, rel=1e-12)
    assert spectrum.rms_slope == pytest.approx(np.sqrt(level * quadrature(2, hurst, m)), rel=1e-12)


@pytest.mark.parametrize(("hurst", "m"), EXPONENTS)
def test_rms_slope_is_what_was_asked_for(hurst, m):
    spectrum = SelfAffineSpectrum.from_rms_slope(0.3, hurst=hurst, roll_off_exponent=m, **BAND)
    level = 0.09 / quadrature(2, hurst, m)
    assert spectrum(Q_ROLL_OFF) == pytest.approx(level, rel=1e-12)
    assert spectrum.rms_slope == pytest.approx(0.3, rel=1e-12)
    assert spectrum.rms_height == pytest.approx(np.sqrt(level * quadrature(0, hurst, m)), rel=1e-12)


def test_without_a_roll_off_the_self_affine_branch_begins_at_q_min():
    spectrum = SelfAffineSpectrum.from_rms_slope(0.1, hurst=0.8, q_min=Q_MIN, q_max=Q_MAX)
    assert spectrum.breaks == (Q_MIN, Q_MAX)
    assert spectrum(10 * Q_MIN) / spectrum(Q_MIN) == pytest.approx(10**-3.6, rel=1e-12)
    # h_rms² = 2π C(q_min) q_min² [1 − (q_max/q_min)^(−2H)]/(2H), in closed form
    height = 2 * np.pi * spectrum(Q_MIN) * Q_MIN**2 * (1 - (Q_MAX / Q_MIN) ** -1.6) / 1.6
    assert spectrum.rms_height**2 == pytest.approx(height, rel=1e-12)


def test_a_roll_off_at_either_end_is_allowed():
    at_start = SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=0.8, q_min=1e3, q_roll_off=1e3, q_max=1e6
    )
    at_end = SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=0.8, q_min=1e3, q_roll_off=1e6, q_max=1e6
    )
    assert at_start.breaks == at_end.breaks == (1e3, 1e6)
    assert at_end(2e3) == pytest.approx(at_end(9e5), rel=1e-12)
    assert at_end(2e3) == pytest.approx(1e-12 / (np.pi * (1e12 - 1e6)), rel=1e-12)


def test_the_steel_surface():
    one_face = SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    assert one_face.rms_slope == pytest.approx(0.300, abs=5e-4)
    assert one_face.scaled(2)(9.4e4) == pytest.approx(1.386e-23, rel=5e-4)


def test_two_equal_faces_have_twice_the_spectrum():
    one = SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    two = one.scaled(2)
    q = np.geomspace(6350.0, 4.15e7, 20)
    np.testing.assert_allclose(two(q), 2 * one(q), rtol=1e-14)
    np.testing.assert_allclose((one + one)(q), two(q), rtol=1e-14)
    assert two.rms_height == pytest.approx(9e-7 * np.sqrt(2), rel=1e-12)
    assert two.breaks == one.breaks == (one + one).breaks


@pytest.mark.parametrize("q_max", [1e6, Q_ROLL_OFF, 1.1e4])
def test_truncation_keeps_the_level(q_max):
    whole = SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.7, roll_off_exponent=1.5, **BAND)
    part = whole.truncated(q_max=q_max)
    q = np.geomspace(Q_MIN, q_max, 30)
    np.testing.assert_array_equal(part(q), whole(q))
    assert part(q_max * 1.0001) == 0.0
    assert part.breaks == (*(b for b in whole.breaks if b < q_max), q_max)
    expected = whole(Q_ROLL_OFF) * quadrature(2, 0.7, 1.5, ends=(Q_MIN, q_max))
    assert part.moment(2) == pytest.approx(expected, rel=1e-12)


def test_truncation_beyond_the_end_changes_nothing():
    whole = SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.7, **BAND)
    assert whole.truncated(q_max=1e9) == whole
    table = TabulatedSpectrum([1.0, 2.0], [3.0, 4.0])
    assert table.truncated(q_max=5.0) == table


def test_a_table_is_a_power_law_between_its_points():
    table = TabulatedSpectrum([1.0, 4.0, 8.0], [16.0, 1.0, 8.0])
    np.testing.assert_allclose(
        table([1.0, 2.0, 4.0, 2**2.5, 8.0]), [16.0, 4.0, 1.0, 2**1.5, 8.0], rtol=1e-14
    )
    assert (table([0.0, 0.999, 8.001, 1e9]) == 0).all()
    assert table.breaks == (1.0, 4.0, 8.0)
    # ∫ q C = ∫ 16 q^(−1) + ∫ q⁴/64, ∫ q³ C = ∫ 16 q + ∫ q⁶/64
    assert table.moment(0) == pytest.approx(
        2 * np.pi * (16 * np.log(4) + (8**5 - 4**5) / 320), rel=1e-13
    )
    assert table.moment(2) == pytest.approx(2 * np.pi * (120 + (8**7 - 4**7) / 448), rel=1e-13)


@pytest.mark.parametrize(("hurst", "m"), [(0.8, 1.5), (1.0, 0.0), (0.0, 4.0)])
def test_a_table_sampled_from_a_self_affine_spectrum_equals_it(hurst, m):
    spectrum = SelfAffineSpectrum.from_rms_height(1e-6, hurst=hurst, roll_off_exponent=m, **BAND)
    q = np.unique([*np.geomspace(Q_MIN, Q_MAX, 40)[1:-1], *spectrum.breaks])
    table = TabulatedSpectrum(q, [spectrum(value) for value in q])
    between = np.geomspace(Q_MIN, Q_MAX, 333)[1:-1]
    np.testing.assert_allclose(table(between), spectrum(between), rtol=1e-11)
    assert table.rms_height == pytest.approx(1e-6, rel=1e-11)
    assert table.moment(2) == pytest.approx(
        spectrum(Q_ROLL_OFF) * quadrature(2, hurst, m), rel=1e-11
    )


def test_truncating_a_table_inserts_the_new_end():
    table = TabulatedSpectrum([1.0, 4.0, 8.0], [16.0, 1.0, 8.0])
    part = table.truncated(q_max=2.0)
    assert part.breaks == (1.0, 2.0)
    np.testing.assert_allclose(part.psd, [16.0, 4.0], rtol=1e-14)
    assert part(2.0001) == 0.0
    assert table.truncated(q_max=4.0).breaks == (1.0, 4.0)
    np.testing.assert_allclose(table.scaled(3)([1.0, 2.0]), [48.0, 12.0], rtol=1e-14)


def test_tables_compare_by_value_and_cannot_be_changed():
    q, psd = np.array([1.0, 2.0, 3.0]), np.array([3.0, 2.0, 1.0])
    table = TabulatedSpectrum(q, psd)
    q[0] = 0.5  # the table holds a copy
    assert table == TabulatedSpectrum([1, 2, 3], [3, 2, 1])
    assert hash(table) == hash(TabulatedSpectrum([1, 2, 3], [3, 2, 1]))
    assert table != TabulatedSpectrum([1, 2, 3], [3, 2, 1.5])
    assert table != TabulatedSpectrum([1, 2, 4], [3, 2, 1])
    assert table != "table"
    for copy in (table, pickle.loads(pickle.dumps(table))):
        assert copy == table
        with pytest.raises(ValueError, match="read-only"):
            copy.q[0] = 9.0
        with pytest.raises(ValueError, match="read-only"):
            copy.psd[0] = 9.0


def test_self_affine_spectra_and_sums_compare_by_value_and_survive_pickling():
    one = SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    both = one + TabulatedSpectrum([1.0, 2.0], [1.0, 1.0])
    for spectrum in (one, both):
        again = pickle.loads(pickle.dumps(spectrum))
        assert again == spectrum
        assert hash(again) == hash(spectrum)
    assert one == SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    assert one != one.scaled(2)


def test_whole_numbers_and_numpy_numbers_are_numbers():
    floats = SelfAffineSpectrum(1.0, 0.0, 2.0, 3.0, 4.0)
    others = SelfAffineSpectrum(np.float32(1), 0, np.int64(2), np.array(3.0), 4)
    assert others == floats
    assert hash(others) == hash(floats)


def test_uncorrelated_surfaces_add_their_spectra():
    rough = SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=0.8, q_min=1e3, q_roll_off=1e4, q_max=1e6
    )
    fine = SelfAffineSpectrum.from_rms_height(2e-7, hurst=0.5, q_min=5e4, q_max=3e6)
    table = TabulatedSpectrum([2e3, 4e6], [1e-21, 1e-27])
    total = rough + fine + table
    assert isinstance(total, SumSpectrum)
    assert total.breaks == (1e3, 2e3, 1e4, 5e4, 1e6, 3e6, 4e6)
    q = np.geomspace(500.0, 5e6, 70)
    np.testing.assert_allclose(total(q), rough(q) + fine(q) + table(q), rtol=1e-15)
    power = -6 / np.log10(2000)
    tail = 2 * np.pi * 1e-21 * integral(lambda k: k * (k / 2e3) ** power, 2e3, 4e6)
    assert total.rms_height**2 == pytest.approx(1e-12 + 4e-14 + tail, rel=1e-12)
    other_order = fine + (table + rough)
    np.testing.assert_allclose(other_order(q), total(q), rtol=1e-14)
    assert (rough + rough).rms_slope == pytest.approx(np.sqrt(2) * rough.rms_slope, rel=1e-13)


def test_a_sum_is_scaled_and_truncated_term_by_term():
    rough = SelfAffineSpectrum.from_rms_height(
        1e-6, hurst=0.8, q_min=1e3, q_roll_off=1e4, q_max=1e6
    )
    fine = SelfAffineSpectrum.from_rms_height(2e-7, hurst=0.5, q_min=5e4, q_max=3e6)
    total = rough + fine
    assert total.scaled(4).rms_height == pytest.approx(2 * total.rms_height, rel=1e-13)
    assert total.truncated(q_max=2e4).breaks == (1e3, 1e4, 2e4)  # `fine` begins above and is gone
    part = total.truncated(q_max=2e6)
    assert part.breaks == (1e3, 1e4, 5e4, 1e6, 2e6)
    q = np.geomspace(1e3, 2e6, 30)
    np.testing.assert_array_equal(part(q), total(q))


def test_every_spectrum_of_one_kind_is_a_set_of_power_laws():
    for spectrum in (
        SelfAffineSpectrum.from_rms_height(9e-7, **STEEL),
        TabulatedSpectrum([1.0, 2.0], [1.0, 1.0]),
    ):
        assert isinstance(spectrum, PowerLaws)
        for left, right, psd, exponent in spectrum.pieces:
            middle = np.sqrt(left * right)
            assert spectrum(middle) == pytest.approx(psd * (middle / left) ** -exponent, rel=1e-13)


@pytest.mark.parametrize("order", [-1.0, 0.0, 2.0, 4.0])
def test_moments_of_any_callable_are_those_of_the_spectrum_it_stands_for(order):
    steel = SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    whole, cut = TruncatedSpectrum(steel), TruncatedSpectrum(steel, 2e5).scaled(3.0)
    assert whole.moment(order) == pytest.approx(steel.moment(order), rel=1e-12, abs=0)
    assert cut.moment(order) == pytest.approx(
        3.0 * steel.truncated(q_max=2e5).moment(order), rel=1e-12, abs=0
    )
    assert (cut + steel).moment(order) == pytest.approx(
        cut.moment(order) + steel.moment(order), rel=1e-12, abs=0
    )


def test_any_callable_is_scaled_cut_and_zero_outside_its_ends():
    steel = SelfAffineSpectrum.from_rms_height(9e-7, **STEEL)
    cut = TruncatedSpectrum(steel).scaled(2.0).truncated(q_max=2e5).truncated(q_max=9e5)
    q = np.array([0.0, 6349.0, 6350.0, 9e4, 2e5, 2.0001e5])
    np.testing.assert_array_equal(cut(q), np.where((q >= 6350.0) & (q <= 2e5), 2.0 * steel(q), 0.0))
    assert cut.breaks == (6350.0, 9.4e4, 2e5)


def test_a_kink_that_is_not_named_is_refused():
    class Kinked:
        breaks = (1e3, 1e6)

        def __call__(self, q):
            return np.where(np.asarray(q) < 3.1e4, 1e-20, 1e-22)

    with pytest.raises(ValueError, match="not smooth between its breaks"):
        _ = TruncatedSpectrum(Kinked()).rms_height


@pytest.mark.parametrize("hurst", [0.0, 0.3, 0.8, 1.0])
def test_the_k_correlation_spectrum_has_its_rms_height_its_plateau_and_its_fall(hurst):
    given = {"rms_height": 9e-7, "hurst": hurst, "q_min": 6e3, "q_roll_off": 1e5, "q_max": 4e8}
    k = KCorrelation(name="k_correlation", **given)
    x = np.linspace(math.log(6e3), math.log(4e8), 200_001)  # ⟨h²⟩ = 2π ∫ q² C d(ln q)
    assert 2 * np.pi * np.trapezoid(np.exp(2 * x) * k(np.exp(x)), x) == pytest.approx(
        9e-7**2, rel=1e-7, abs=0
    )
    assert TruncatedSpectrum(k).rms_height == pytest.approx(9e-7, rel=1e-12, abs=0)
    assert k(1e5) / k(1e-3) == pytest.approx(2 ** (-1 - hurst), rel=1e-12, abs=0)
    assert k(2e8) / k(1e8) == pytest.approx(2 ** (-2 - 2 * hurst), rel=1e-5, abs=0)
