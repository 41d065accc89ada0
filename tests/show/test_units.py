"""How numbers are written: a value ends where its error does, and what is not known of the error is told."""

import pytest

from roughsim.show.table import Number, shown, with_unit

WRITTEN = {
    (208.334, 0.384): "208.33 ± 0.38",
    (-13917.4, 123.4): "-13920 ± 120",  # two digits of the error here too
    (101.096, 0.0996): "101.10 ± 0.10",  # rounded up to one more place
    (9.96, 9.96): "10 ± 10",
    (1.63283e-4, 8.1e-7): "(1.6328 ± 0.0081)e-4",
    (1.63283e-3, 8.1e-6): "0.0016328 ± 0.0000081",  # from 1e-3 on without a power of ten
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
    assert str(Number(given[0], "1", given[1])) == told


def test_an_error_with_an_unknown_part_is_a_lower_bound():
    assert str(Number(208.334, "1", 0.384, ["bandwidth"])) == "208.33 ± ≥0.38"
    assert str(Number(208.334, "1", 0.0, ["bandwidth"])) == "208.3 ± unknown"
    assert str(Number(0.0, "1", 0.0, ["bandwidth"])) == "0"  # at rest nothing heats


def test_units_of_tables_are_those_of_figures():
    assert shown("m") == ("µm", 1e6)
    assert shown("W") == ("W", 1.0)
    assert (with_unit("slope_length", "m"), with_unit("contact_fraction", "1")) == (
        "slope_length, µm",
        "contact_fraction",
    )


def test_no_zero_is_negative():
    assert str(Number(-0.0, "1", 0.0)) == "0"


def test_a_number_of_a_table_is_written_in_the_unit_of_the_tables():
    assert str(Number(2.0e-4, "m", 1.26e-6)) == "200.0 ± 1.3"
    assert str(Number(-777.3e3, "K/m")) == "-777.3"
    assert str(Number(3.0e-4, "m", 1e-6, ["size"])) == "300.0 ± ≥1.0"
    assert str(Number(1.234e-4, "m", digits=2)) == "120"
    assert [str(Number(x)) for x in (12345.6, 99999.0, 123456.0)] == [
        "12350",
        "100000",
        "1.235e+05",
    ]
    assert Number(1.6328e-4, "1", 8.1e-7).written() == ("1.6328", "0.0081", -4)
