"""How numbers are written: a value ends where its error does, and what is not known of the error is told."""

import pytest

from roughsim.show.digits import plus_minus, shown

WRITTEN = {
    (208.334, 0.384): "208.33 ± 0.38",
    (-13917.4, 123.4): "-13920 ± 120",  # two digits of the error here too
    (101.096, 0.0996): "101.10 ± 0.10",  # rounded up to one more place
    (9.96, 9.96): "10 ± 10",
    (1.63283e-4, 8.1e-7): "(1.6328 ± 0.0081)e-4",
    (2.5e7, 3e5): "(2.500 ± 0.030)e7",
    (0.0, 0.5): "0.00 ± 0.50",
    (0.0, 0.0): "0",
    (0.07664, 0.0): "0.07664",
    (2.5, float("inf")): "2.5 ± unknown",
    (2.5, float("nan")): "2.5 ± unknown",
    (0.999984941, 6.4e-9): "0.999985 ± 6.4e-09",
    (float("inf"), 1.0): "–",
    (float("nan"), 1.0): "–",
}


@pytest.mark.parametrize(("given", "told"), WRITTEN.items())
def test_a_value_and_its_error_end_at_the_second_digit_of_the_error(given, told):
    assert plus_minus(*given) == told


def test_an_error_with_an_unknown_part_is_a_lower_bound():
    assert plus_minus(208.334, 0.384, ["bandwidth"]) == "208.33 ± ≥0.38"
    assert plus_minus(208.334, 0.0, ["bandwidth"]) == "208.3 ± unknown"
    assert plus_minus(0.0, 0.0, ["bandwidth"]) == "0"  # at rest nothing heats


def test_units_of_tables_are_those_of_figures():
    assert shown("m") == ("µm", 1e6)
    assert shown("W") == ("W", 1.0)


def test_no_zero_is_negative():
    assert plus_minus(-0.0, 0.0) == "0"
