"""Errors are planted in every module of both packages, and tried on the tests that run their lines."""

import pytest
from mutate import LEFT_OUT, ROOT, LineTests, drawn, modules, room_tests

# modules without a line that computes: names, doors, tables of text
WITHOUT_FORMULAS = {
    *("roughsim/__main__.py", "roughsim/fourier/power.py"),
    *("roughsim/results/unread.py", "theory/typed.py"),
}


EVERY = [
    path.relative_to(ROOT).as_posix()
    for package in ("roughsim", "theory")
    for path in (ROOT / package).rglob("*.py")
]


@pytest.mark.slow
def test_every_module_of_both_packages_is_drawn_from_or_named():
    left_out = set(EVERY) - set(modules())
    assert all(
        reason and any(name.startswith(start) for name in left_out)
        for start, reason in LEFT_OUT.items()
    )
    assert all(name.startswith(tuple(LEFT_OUT)) for name in left_out)
    without = set(modules()) - {mutant.file for mutant in drawn(1, 1, [""])}
    assert {name for name in without if not name.endswith("__init__.py")} == WITHOUT_FORMULAS


def test_room_tests_hold_each_module_and_each_file():
    found = {module: room_tests(module) for module in EVERY}
    assert all(tests or "/__" in module for module, tests in found.items())
    # what stands at the top is of several rooms, or of the pages
    inside = {path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").glob("*/**/test_*.py")}
    assert inside <= {test for tests in found.values() for test in tests}
    assert "tests/estimate/test_bound.py" in found["roughsim/estimate/limit.py"]
    # named by `from roughsim.cli import installation` alone
    assert "tests/test_doctor.py" in found["roughsim/cli/installation.py"]


def test_tests_of_a_line_are_those_that_run_it_the_closest_first(tmp_path):
    coverage = pytest.importorskip("coverage", exc_type=ImportError)  # a script has its name, too
    made = coverage.CoverageData(str(tmp_path / "coverage"))
    for context, lines in {
        "": [1, 9],  # the import
        "tests/test_a.py::test_long[a|b]|run": [1, 2, 3],
        "tests/test_a.py::test_short|run": [2],
        "tests/test_b.py::test_with_a_fixture|setup": [
            4
        ],  # its result may serve other tests of the file
    }.items():
        made.set_context(context)
        made.add_lines({str(ROOT / "theory/flash.py"): lines})
    made.write()
    tests = LineTests(tmp_path / "coverage")
    assert tests.of("theory/flash.py", 2) == [
        "tests/test_a.py::test_short",
        "tests/test_a.py::test_long[a|b]",
    ]
    assert tests.of("theory/flash.py", 4) == ["tests/test_b.py"]
    assert (
        len(tests.of("theory/flash.py", 9)) == 3
    )  # of the module: the process of the tests does not run the line
    assert tests.of("theory/skin.py", 1) == []
