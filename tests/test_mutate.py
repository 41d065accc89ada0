"""The list of files in which errors are planted follows the package."""

import pytest
from mutate import ROOT, TESTS, mutants


@pytest.mark.parametrize("file", TESTS)
def test_every_file_to_plant_errors_in_has_formulas_and_tests(file):
    assert next(mutants(file), None) is not None
    assert all((ROOT / "tests" / test).is_file() for test in TESTS[file].split())
