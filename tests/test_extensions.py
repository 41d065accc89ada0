"""What other packages add by entry points: in the order of names, after what roughsim has, and nothing is replaced."""

import pytest

from roughsim.extensions import INSIDE, extensions, loaded


@pytest.mark.parametrize("kind", ["spectra", "solvers", "observables"])
def test_extensions_come_in_the_order_of_their_names_and_take_none_of_the_package(kind, install):
    names = ["zeta", *INSIDE[kind], "alpha"]
    install("others", entry_points={f"roughsim.{kind}": dict.fromkeys(names, "math:pi")})
    assert [*extensions(kind)] == sorted(names)
    assert {name: extensions(kind)[name].value for name in INSIDE[kind]} == INSIDE[kind]
    assert extensions(kind)["zeta"].load() == pytest.approx(3.14159, abs=1e-5)


def test_the_entries_of_the_package_are_there():
    for kind, entries in INSIDE.items():
        for name, target in entries.items():
            record = loaded(kind, name)
            assert f"{record.__module__}:{record.__name__}" == target
