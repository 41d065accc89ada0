"""Bessel functions and Student's t of SciPy, without the rest of scipy.special: that takes a fifth of a second to load.

`j0` and `j1` are J₀ and J₁; `stdtrit(freedom, share)` is the quantile of Student's t.
"""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import scipy

_PACKAGE = "scipy.special"


def _functions() -> Any:
    """Return the compiled module, imported without the package around it, unless that is loaded already."""
    if _PACKAGE in sys.modules:
        return sys.modules[_PACKAGE]
    # an empty package stands in for the time of the import; whoever imports the package later gets the whole
    sys.modules[_PACKAGE] = empty = ModuleType(_PACKAGE)
    empty.__path__ = [str(Path(scipy.__file__).parent / "special")]
    try:
        return import_module(f"{_PACKAGE}._ufuncs")
    finally:
        del sys.modules[_PACKAGE]


try:
    _found = _functions()
except ImportError:  # a release of SciPy that has its compiled module elsewhere
    _found = import_module(_PACKAGE)
j0, j1, stdtrit = _found.j0, _found.j1, _found.stdtrit
