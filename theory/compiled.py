"""Compiled functions of SciPy, without the packages around them: to load those takes half a second.

`special` has the functions of scipy.special, `lapack` those of scipy.linalg.lapack, and `brentq` is that of
scipy.optimize. Where a release of SciPy has its compiled modules elsewhere, the packages are loaded after all.
"""

import math
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import scipy

RTOL, MOST_STEPS = 4 * sys.float_info.epsilon, 100  # as scipy.optimize.brentq has them


def alone(package: str, module: str) -> Any:
    """Import a module of a package of SciPy without the package, unless that is loaded already."""
    name = f"scipy.{package}"
    if name in sys.modules:
        return import_module(f"{name}.{module}")
    # an empty package stands in for the time of the import; whoever imports the package later gets the whole
    sys.modules[name] = empty = ModuleType(name)
    empty.__path__ = [str(Path(scipy.__file__).parent / package)]
    try:
        return import_module(f"{name}.{module}")
    finally:
        del sys.modules[name]


try:
    special, lapack, zeros = alone("special", "_ufuncs"), alone("linalg", "_flapack"), alone("optimize", "_zeros")
except ImportError:
    special, lapack, zeros = import_module("scipy.special"), import_module("scipy.linalg.lapack"), None


def brentq(excess: Callable[[float], float], low: float, high: float, *, xtol: float, rtol: float = RTOL) -> float:
    """Return where `excess` is zero, by Brent's method; ValueError unless it has unlike signs at `low` and `high`."""

    def value(x: float) -> float:
        if math.isnan(result := excess(x)):
            raise ValueError(f"no root: the function is not a number at {x:.6g}")
        return result

    if zeros is None:
        return float(scipy.optimize.brentq(value, low, high, xtol=xtol, rtol=rtol))
    return float(zeros._brentq(value, low, high, xtol, rtol, MOST_STEPS, (), False, True))
