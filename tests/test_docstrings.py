"""The public interface says of every argument and result what it is: shapes, units, errors and where it comes from."""

import importlib
import inspect
import re
from dataclasses import is_dataclass
from pathlib import Path

import pytest

import roughsim as rs
import theory

# public to the other modules of `theory` only
INSIDE = {
    "persson": {"half_variance_table", "probability", "weight", "StressDensity", "stress_density"},
    "plasticity": {"reached", "between", "smoothing"},
}
FORMULAS = [name for name in theory.__all__ if name != "quadrature"]
REFERS = re.compile(r"(?:[Aa]s(?: in)?|[Ss]ee(?: also)?) `(?:roughsim\.)?(\w+)`")


def interface():
    """Every public function, class and method, by its name."""
    for name in sorted(set(rs.__all__) - {"__version__"}):
        yield from whole(f"roughsim.{name}", getattr(rs, name))
    for part in FORMULAS:
        module = importlib.import_module(f"theory.{part}")
        names = getattr(module, "__all__", None) or [
            n for n in vars(module) if not n.startswith("_")
        ]
        for name in names:
            if name in INSIDE.get(part, ()):
                continue
            found = getattr(module, name)
            home = getattr(found, "__module__", "")
            if (
                callable(found)
                and home.startswith("theory")
                and (home == module.__name__ or hasattr(module, "__path__"))
            ):
                yield from whole(f"theory.{part}.{name}", found)


def whole(name, found):
    if inspect.isclass(found):
        yield name, found
        for part, member in vars(found).items():
            if not part.startswith("_") and (
                inspect.isfunction(member) or isinstance(member, (classmethod, property))
            ):
                yield f"{name}.{part}", getattr(member, "__func__", member)
    elif inspect.isfunction(found) or name == "roughsim.theory":
        yield name, found if inspect.isfunction(found) else inspect.unwrap(found)


INTERFACE = dict(interface())


def text_of(name, found):
    """The docstring, and those it refers to, which may refer further."""
    home = importlib.import_module(
        found.fget.__module__ if isinstance(found, property) else found.__module__
    )
    beside, doc, seen = name.rsplit(".", 1)[0], inspect.getdoc(found) or "", set()
    while more := set(REFERS.findall(doc)) - seen:
        seen |= more
        for other in more:
            target = (
                getattr(home, other, None)
                or INTERFACE.get(f"{beside}.{other}")
                or getattr(rs, other, None)
            )
            doc += "\n" + ((inspect.getdoc(target) or "") if target is not None else "")
    return doc


def arguments(found):
    if inspect.isclass(found) and not is_dataclass(found):
        return []
    return [
        p for p in inspect.signature(found).parameters if p not in ("self", "cls", "args", "kwargs")
    ]


def test_every_argument_and_result_is_described():
    for name, found in INTERFACE.items():
        doc = text_of(name, found)
        assert doc, name
        if isinstance(found, property):
            continue
        undescribed = [word for word in arguments(found) if not re.search(rf"\b{word}\b", doc)]
        assert undescribed == [], f"{name} says nothing of {undescribed}"
        if inspect.isfunction(found):
            result = inspect.signature(found).return_annotation
            if result not in (None, "None", inspect.Signature.empty):
                assert re.search(r"Returns|Return |Yields|, m\b|K\b|[A-Za-z]+\.|share", doc), name


def test_functions_that_check_their_arguments_say_what_they_raise():
    for name, found in INTERFACE.items():
        if not inspect.isfunction(found) or name.count(".") >= 3:
            continue
        source = inspect.getsource(found)
        if re.search(r"\braise \w*Error|= (real_array|positive|not_negative)\(", source):
            assert re.search(r"Raises|errors: as|[Ee]rror", text_of(name, found)), name


@pytest.mark.parametrize(
    "part", [part for part in FORMULAS if part != "hardness"]
)  # whose equation defines it
def test_formulas_say_which_equation_or_source_they_are(part):
    folder = Path(theory.__file__).parent
    texts = [
        path.read_text() for path in [*folder.glob(f"{part}.py"), *folder.glob(f"{part}/*.py")]
    ]
    assert any(re.search(r"Eqs?\. \(|Sec\. |Source: ", text) for text in texts)


def test_both_packages_are_typed():
    for package in ("roughsim", "theory"):
        assert (Path(importlib.import_module(package).__file__).parent / "py.typed").exists()
