"""Interpolation between the nodes of a table, against SciPy, which the package does without: it takes long to load."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from roughsim.comparison.interpolation import linear, monotone, spline

PLACES = np.linspace(0.0, 1.0, 23)


@pytest.fixture(params=[2, 3, 4, 5, 9])
def table(request):
    rng = np.random.default_rng(request.param)
    nodes = np.cumsum(0.3 + rng.random(request.param))
    return nodes, rng.standard_normal((nodes.size, 3))


@pytest.mark.parametrize("share", PLACES)
def test_splines_and_lines_are_those_of_scipy(table, share):
    nodes, values = table
    x = float(nodes[0] + share * np.ptp(nodes))
    # the basis of powers costs some digits
    np.testing.assert_allclose(spline(nodes, values, x), CubicSpline(nodes, values)(x), rtol=0, atol=1e-11)
    np.testing.assert_allclose(linear(nodes, values, x), [np.interp(x, nodes, v) for v in values.T], rtol=0, atol=1e-14)


@pytest.mark.parametrize("share", PLACES)
@pytest.mark.parametrize("rising", [False, True])
def test_monotone_cubics_are_those_of_scipy(table, share, rising):
    nodes, values = table
    column = np.sort(values[:, 0]) if rising else values[:, 0]
    x = float(nodes[0] + share * np.ptp(nodes))
    assert monotone(nodes, column, x) == pytest.approx(float(PchipInterpolator(nodes, column)(x)), rel=0, abs=1e-14)


@pytest.mark.parametrize("values", [[0.0, 0.0, 1.0, 1.0, 5.0], [5.0, 1.0, 1.0, 0.9, -3.0], [0.0, 1e-3, 1.0, 0.5, 0.6]])
def test_monotone_cubics_stay_between_their_nodes(values):
    nodes = np.array([0.0, 1.0, 1.5, 3.0, 3.5])
    for k in range(4):
        inside = [monotone(nodes, np.array(values), x) for x in np.linspace(nodes[k], nodes[k + 1], 17)]
        assert min(values[k : k + 2]) - 1e-14 <= min(inside) <= max(inside) <= max(values[k : k + 2]) + 1e-14
