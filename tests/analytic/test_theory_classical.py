"""Classical formulas against the exact moving sources: their limits and the errors that their docstrings state."""

import numpy as np
import pytest
from some_rows import some

from theory import classical, hertz

PECLET = np.geomspace(1e-3, 1e5, 161)
EXACT = {
    ("hertz", "flash"): hertz.flash_temperature,
    ("hertz", "max"): hertz.max_temperature,
    ("hertz", "mean"): hertz.mean_temperature,
    ("disc", "max"): hertz.disc_max_temperature,
    ("disc", "mean"): hertz.disc_mean_temperature,
    ("square", "max"): hertz.square_max_temperature,
    ("square", "mean"): hertz.square_mean_temperature,
}


def errors(values, exact):
    return np.asarray(values) / np.asarray(exact) - 1


@pytest.mark.parametrize(
    ("source", "quantity", "low", "high"),
    some(
        [
            ("hertz", "flash", -0.0473, 0.0),
            ("hertz", "max", -0.0110, 0.0023),
            ("hertz", "mean", -0.0460, 0.0),
            ("disc", "max", -0.0072, 0.0232),
            ("disc", "mean", -0.0377, 0.0),
            ("square", "max", -0.0264, 0.0085),
            ("square", "mean", -0.0171, 0.0273),
        ],
        2,
    ),
)
def test_greenwoods_interpolation_errs_by_a_few_per_cent(source, quantity, low, high):
    peclet = PECLET[::4] if quantity == "max" else PECLET
    error = errors(
        classical.greenwood(peclet, source=source, quantity=quantity),
        EXACT[source, quantity](peclet),
    )
    assert error.min() == pytest.approx(low, abs=4e-4)
    assert error.max() == pytest.approx(high, abs=4e-4)
    assert classical.greenwood(0.0, source=source, quantity=quantity) == pytest.approx(
        EXACT[source, quantity](0.0)
    )
    fast = classical.greenwood(1e14, source=source, quantity=quantity) / EXACT[source, quantity](
        1e14
    )
    assert fast == pytest.approx(1, abs=1e-6)


def test_greenwoods_rule_adds_inverse_squares():
    slow, fast = hertz.STATIC.flash_temperature, hertz.FAST.flash_temperature / np.sqrt(7.0)
    assert classical.greenwood(-7.0) ** -2 == pytest.approx(slow**-2 + fast**-2, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "low", "high"),
    [("hertz", -0.0113, 0.0024), ("disc", -0.0072, 0.0232), ("square", -0.0264, 0.0085)],
)
def test_tian_and_kennedy_err_as_the_interpolation_does(source, low, high):
    error = errors(
        classical.tian_kennedy(PECLET[::4], source=source), EXACT[source, "max"](PECLET[::4])
    )
    assert error.min() == pytest.approx(low, abs=4e-4)
    assert error.max() == pytest.approx(high, abs=4e-4)
    for limit in (0.0, 1e10):
        exact = EXACT[source, "max"](limit)
        assert classical.tian_kennedy(limit, source=source) == pytest.approx(exact, rel=5e-4)


def test_jaegers_two_formulas_bound_the_square_from_above():
    error = errors(classical.jaeger(PECLET), hertz.square_mean_temperature(PECLET))
    assert error.min() > -1e-3  # three digits printed
    assert error.max() == pytest.approx(0.388, abs=0.005)
    assert PECLET[error.argmax()] == pytest.approx(1.26, rel=0.06)
    assert classical.jaeger(10.0) / hertz.square_mean_temperature(10.0) == pytest.approx(
        1.085, abs=5e-4
    )
    assert classical.jaeger([0.0, 1e6]) == pytest.approx([0.946, 1.064e-3], rel=1e-12)


def test_archards_regimes_are_those_of_a_disc():
    error = errors(classical.archard(PECLET), hertz.disc_mean_temperature(PECLET))
    assert error.min() == pytest.approx(-0.238, abs=0.003)
    assert error[0] == pytest.approx(np.pi / 4 / (8 / 3 / np.pi) - 1, abs=2e-3)
    assert error[-1] == pytest.approx(0, abs=3e-4)
    assert classical.archard(-10.001) / hertz.disc_mean_temperature(10.001) == pytest.approx(
        1.0465, abs=5e-4
    )
    # the ends of the middle regime: α = 0.85 and 0.35 of 0.25 Q̇/κR
    assert classical.archard([0.2, 10.0]) == pytest.approx(
        [0.85 * np.pi / 4, 0.35 * np.pi / 4], rel=1e-12
    )
    assert classical.archard(2.0**0.5) == pytest.approx(
        (0.85 + 0.35) / 2 * np.pi / 4, rel=1e-12
    )  # half-way in log L


@pytest.mark.parametrize(
    "formula", [classical.jaeger, classical.archard, classical.greenwood, classical.tian_kennedy]
)
def test_classical_formulas_are_even(formula):
    assert formula(-3.0) == formula(3.0)
    assert formula([[1.0, 2.0]]).shape == (1, 2)
