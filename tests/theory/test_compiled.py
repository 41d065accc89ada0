"""Functions of SciPy without its packages: the same numbers, and whoever wants the packages gets them whole."""

import subprocess
import sys
from math import cos, nan, pi
from pathlib import Path

import numpy as np
import pytest
import scipy.interpolate
import scipy.optimize

from theory.compiled import brentq
from theory.scattering import Table
from theory.yielding import _smooth


def run(code):
    root = Path(__file__).parents[2]
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    return result.stdout.split()


def test_a_plan_and_a_comparison_load_no_packages_of_scipy():
    heavy = "{'scipy.special', 'scipy.linalg', 'scipy.optimize', 'scipy.interpolate', 'scipy.fft', 'scipy.sparse'}"
    code = (
        "import sys, roughsim as rs; from roughsim.comparison.trust import trust;"
        f"scene = rs.load_scene('steel-1.2GPa'); rs.plan(scene); trust(scene); print(*({heavy} & set(sys.modules)))"
    )
    assert run(code) == []


def test_packages_that_are_imported_later_are_whole():
    code = (
        "import theory.compiled as c, roughsim.observables.special as s;"
        "import scipy.special, scipy.linalg.lapack, scipy.optimize, scipy.stats;"
        "print(scipy.special.erf is c.special.erf, scipy.special.j0 is s.j0, scipy.special.stdtrit is s.stdtrit,"
        "scipy.linalg.lapack.dgtsv is c.lapack.dgtsv, scipy.special.factorial(5) == 120, scipy.stats.norm.cdf(0) == .5)"
    )
    assert run(code) == ["True"] * 6


def test_packages_that_were_imported_before_are_used():
    code = (
        "import scipy.special, scipy.linalg, scipy.optimize, sys; before = sys.modules['scipy.special'];"
        "import theory.compiled as c, roughsim.observables.special as s;"
        "print(scipy.special.erf is c.special.erf, scipy.special.j0 is s.j0, sys.modules['scipy.special'] is before)"
    )
    assert run(code) == ["True"] * 3


def test_roots_are_those_of_scipy():
    assert brentq(cos, 0.0, 3.0, xtol=1e-15) == scipy.optimize.brentq(cos, 0.0, 3.0, xtol=1e-15)
    assert brentq(cos, 0.0, 3.0, xtol=1e-15) == pytest.approx(pi / 2, rel=1e-15)
    coarse = {"xtol": 1e-3, "rtol": 1e-2}
    assert brentq(cos, 0.0, 3.0, **coarse) == scipy.optimize.brentq(cos, 0.0, 3.0, **coarse)


def test_no_root_is_refused():
    with pytest.raises(ValueError, match="different signs"):
        brentq(cos, 0.0, 1.0, xtol=1e-15)
    with pytest.raises(ValueError, match="not a number at"):
        brentq(lambda x: nan if x > 0.5 else x, -1.0, 2.0, xtol=1e-15)


def test_the_spline_nearest_to_a_table_is_that_of_scipy():
    rng = np.random.default_rng(7)
    x = np.sort(rng.uniform(0.0, 9.0, 300))
    weight = np.exp(rng.uniform(-3.0, 0.0, x.size))
    table = Table(x, np.sin(x) + 0.1 * rng.standard_normal(x.size), weight)
    spline = _smooth(table, 0.25)
    other = scipy.interpolate.make_lsq_spline(x, table.value, spline.t, k=5, w=weight)
    at = np.linspace(x[0], x[-1], 1001)
    np.testing.assert_allclose(spline(at), other(at), rtol=0, atol=1e-11)
    exact = _smooth(Table(x, x**5 - 3 * x, weight), 0.25)
    np.testing.assert_allclose(exact(at), at**5 - 3 * at, rtol=1e-10, atol=1e-8)  # a polynomial of its degree
