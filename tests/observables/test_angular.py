"""The averages over all directions of sliding are the integrals of the paper."""

from math import pi

import mpmath as mp
import numpy as np
import pytest
from moments_cases import ANGULAR

from roughsim.observables.moments import angular_means


@pytest.mark.parametrize("case", ANGULAR, ids=lambda case: f"a = {case['a']:g}")
def test_the_angular_means_are_the_integrals_of_the_paper(case):
    even, odd = angular_means(np.array([case["a"]]))
    assert even[0] == pytest.approx(2 / pi * case["A"], rel=1e-15)
    assert odd[0] == pytest.approx(2 / pi * case["B"], rel=1e-15, abs=0)


def test_the_angular_means_are_the_elliptic_integrals_everywhere():
    mp.mp.dps = 60
    ratios = np.concatenate((np.geomspace(1e-8, 1e8, 65), np.linspace(0.2, 4.0, 40)))
    even, odd = angular_means(ratios)
    for i, a in enumerate(ratios):
        root = (1 + mp.mpf(a) ** 2) ** mp.mpf("0.25")
        m = (1 - root**-2) / 2
        a_exact = mp.ellipk(m) / root
        b_exact = (a_exact - root * (2 * mp.ellipe(m) - mp.ellipk(m))) / mp.mpf(a)
        assert even[i] == pytest.approx(float(2 / mp.pi * a_exact), rel=1e-15)
        assert odd[i] == pytest.approx(float(2 / mp.pi * b_exact), rel=1e-15)


def test_the_angular_means_keep_their_limits():
    even, odd = angular_means(np.array([1e-9, 1e150]))
    np.testing.assert_allclose(even * pi / 2, [pi / 2, 1.8540746773013719e-75], rtol=1e-15)
    np.testing.assert_allclose(odd * pi / 2, [-1e-9 * pi / 8, -0.8472130847939791e-75], rtol=1e-15)
