from math import cos, exp, pi, sqrt, tanh

import numpy as np
import pytest
from scipy.optimize import brentq

from theory.roots import root


@pytest.mark.parametrize(
    ("function", "low", "high", "exact"),
    [
        (lambda x: x * x - 2.0, 0.0, 2.0, sqrt(2.0)),
        (cos, 3.0, 0.0, pi / 2),
        (lambda x: 1e-170 * (x - 0.25), -1.0, 1.0, 0.25),  # its products underflow
        (lambda x: 1.0 if x >= 0.1 else -1.0, 0.0, 1.0, 0.1),
        (lambda x: x, 0.0, 1.0, 0.0),
        (lambda x: x - 1.0, 0.0, 1.0, 1.0),
    ],
)
def test_root_finds_exact_cases(function, low, high, exact):
    assert root(function, low, high, accuracy=1e-15) == pytest.approx(exact, rel=1e-15, abs=2e-15)


def test_root_has_the_bits_of_scipy():
    rng = np.random.default_rng(1)
    families = [
        lambda a, b: lambda x: exp(x) - b - 1.1,
        lambda a, b: lambda x: tanh(20 * (x - a)) + 0.3 * b,
        lambda a, b: lambda x: x**3 - a,
        lambda a, b: lambda x: cos(3 * x) - (1 + a) * x,
        lambda a, b: lambda x: np.sign(x - a) * abs(x - a) ** 0.2,
    ]
    for _ in range(200):
        for family in families:
            function = family(*rng.random(2))
            ends = sorted((-0.1, 1.0 + rng.random()), key=lambda _: rng.random())
            accuracy, relative = 10 ** rng.uniform(-13, -3), 10 ** rng.uniform(-15, -8)
            found = root(function, *ends, accuracy=accuracy, relative=relative)
            assert found == brentq(function, *ends, xtol=accuracy, rtol=relative)


def test_root_refuses_one_sign_nan_and_roots_of_a_high_order():
    with pytest.raises(ValueError, match="1 at 0 and 2 at 1; the signs must differ"):
        root(lambda x: 1.0 + x, 0.0, 1.0, accuracy=1e-9)
    with pytest.raises(ValueError, match="the function is NaN at -?0"):
        root(lambda x: x if abs(x) >= 1.0 else np.nan, -1.0, 2.0, accuracy=1e-9)
    with pytest.raises(RuntimeError, match="no root between -1 and 2.1 in 100 steps"):
        root(lambda x: (x - 0.3) ** 9, -1.0, 2.1, accuracy=1e-15)
