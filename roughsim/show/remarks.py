"""Remarks on a scene: warnings, assumptions, sizes, and choices of the plan, one record for all."""

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from roughsim.show.text import SceneWarning

Kind = Literal["no theory", "slip", "limit", "caution", "assumption", "size", "choice"]
WARNINGS: tuple[Kind, ...] = ("no theory", "slip", "limit", "caution")  # the most serious first


@dataclass(frozen=True, slots=True)
class Remark:
    """A remark on one quantity of a scene.

    Attributes
    ----------
    kind : str
        A warning: "no theory" without a value of it, "slip" of a unit or a key, "limit" of the model, "caution" for an
        assumption that is easily missed. Or "assumption", "size" that follows from the scene, "choice" of the plan.
    quantity : str
        Key or name of the quantity; remarks of one kind on one quantity differ in their numbers alone.
    text : str
        The sentence of a warning; for the others the meaning or the reason.
    value : str
        The value in words; "" for a warning, whose text has it.
    """

    kind: Kind
    quantity: str
    text: str
    value: str = ""

    def __str__(self) -> str:
        return f"{self.quantity}: {self.value}; {self.text}" if self.value else self.text

    @property
    def row(self) -> tuple[str, str, str]:
        """Quantity, value and text: a row of a table."""
        return self.quantity, self.value, self.text


def most_serious_first(remarks: Iterable[Remark]) -> list[Remark]:
    """Return warnings by their kinds, the most serious first."""
    return sorted(remarks, key=lambda remark: WARNINGS.index(remark.kind))


def warn_of(remarks: Iterable[Remark], above: int = 1) -> None:
    """Give warnings to Python, at the line that called the function that calls this, or one some calls `above`."""
    for remark in remarks:
        warnings.warn(str(remark), SceneWarning, stacklevel=2 + above)


def of_several(remarks: Mapping[str, Iterable[Remark]]) -> list[Remark]:
    """Return the warnings of several scenes by their names, of each kind and quantity the first."""
    alike: dict[tuple[str, str], dict[str, Remark]] = {}
    for name, own in remarks.items():
        for remark in own:
            alike.setdefault((remark.kind, remark.quantity), {}).setdefault(name, remark)
    result = []
    for by_name in alike.values():
        name, first = next(iter(by_name.items()))
        others = f" and {len(by_name) - 1} more with other numbers" if len(by_name) > 1 else ""
        if len(by_name) < len(remarks) or len(set(by_name.values())) > 1:
            first = Remark(first.kind, first.quantity, f"{name}{others}: {first.text}", first.value)
        result.append(first)
    return most_serious_first(result)
