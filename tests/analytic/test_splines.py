import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline

from theory.splines import DEGREE, Spline, nearest_spline

INNER = np.array([-1.0, 0.25, 0.75, 2.0])


@pytest.fixture
def points():
    rng = np.random.default_rng(5)
    x = np.sort(np.concatenate([[-2.0, 3.0], rng.uniform(-2.0, 3.0, 58)]))
    return x, np.sin(2 * x) + 0.1 * rng.normal(size=x.size), rng.uniform(0.1, 1.0, x.size)


def test_nearest_spline_is_that_of_scipy(points):
    x, y, weight = points
    ends = np.repeat(x[0], DEGREE + 1), np.repeat(x[-1], DEGREE + 1)
    expected = make_lsq_spline(x, y, np.concatenate([ends[0], INNER, ends[1]]), k=DEGREE, w=weight)
    fine = np.linspace(x[0], x[-1], 500)
    spline = nearest_spline(x, y, weight, INNER)
    np.testing.assert_array_equal(spline.knots, expected.t)
    np.testing.assert_allclose(spline(fine), expected(fine), rtol=0, atol=1e-12)


def test_nearest_spline_has_every_polynomial_of_its_degree(points):
    x, _, weight = points
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.5, 1.5, -0.25, 0.125])
    fine = np.linspace(x[0], x[-1], 77).reshape(7, 11)
    found = nearest_spline(x, polynomial(x), weight, INNER)(fine)
    np.testing.assert_allclose(found, polynomial(fine), rtol=0, atol=1e-10)


def test_spline_is_constant_beyond_its_ends(points):
    spline = nearest_spline(*points, INNER)
    inside, outside = spline(np.array([-2.0, 3.0])), spline(np.array([-7.0, 1e9]))
    np.testing.assert_array_equal(inside, outside)


def test_splines_on_the_same_knots_are_evaluated_together():
    knots = np.concatenate([np.zeros(DEGREE + 1), [0.5], np.ones(DEGREE + 1)])
    x = np.linspace(0.0, 1.0, 9)
    each = Spline(knots, np.eye(DEGREE + 2))(x)
    assert each.shape == (DEGREE + 2, 9)
    np.testing.assert_allclose(each.sum(axis=0), 1.0, rtol=1e-14)  # B-splines add up to 1
    np.testing.assert_array_equal(each[3], Spline(knots, np.eye(DEGREE + 2)[3])(x))
