"""The list of files in which errors are planted follows the package."""

import pytest
from mutate import ROOT, TESTS, mutants


@pytest.mark.parametrize("file", TESTS)
def test_every_file_to_plant_errors_in_has_formulas_and_tests(file):
    assert next(mutants(file), None) is not None
    assert all((ROOT / "tests" / test).is_file() for test in TESTS[file].split())


# no formulas: arguments and their errors, rounding of float32
EXEMPT = {"theory/arguments.py", "roughsim/heat/precision.py"}


def test_every_module_with_formulas_of_theory_and_heat_is_in_the_list():
    modules = {
        path.relative_to(ROOT).as_posix()
        for room in ("theory", "roughsim/heat")
        for path in (ROOT / room).rglob("*.py")
    }
    assert {name for name in modules if not name.endswith("__init__.py")} == EXEMPT | {
        name for name in TESTS if name.startswith(("theory/", "roughsim/heat/"))
    }
