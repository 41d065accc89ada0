"""The section [ensemble] of a scene: seed, number of realizations, and targets."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator

from roughsim.observables.catalogue import OBSERVABLES, observables_of
from roughsim.scene.schema import Quantity, Record, as_written, did_you_mean, record, whole

TARGET = Quantity("", '"1 %"', gt=0, lt=1)


def _read_targets(value: Any) -> tuple[tuple[str, float], ...]:
    """Read observables with the relative total error that each should reach: a mapping, or pairs; return pairs."""
    if isinstance(value, Mapping):
        value = tuple(value.items())
    if not isinstance(value, (list, tuple)) or any(
        not isinstance(p, (list, tuple)) or len(p) != 2 for p in value
    ):
        example = 'until = { flash_temperature = "1 %" }'
        raise ValueError(f" = {as_written(value)} must name observables and targets: {example}")
    for name, _ in value:
        if name not in OBSERVABLES:
            names = observables_of()
            raise ValueError(f".{name} is not an observable; {did_you_mean(str(name), names)}")
    return tuple((name, TARGET(target, f".{name}")) for name, target in value)


@record("ensemble")
class EnsembleSection(Record):
    """Seed, number of realizations or the largest one, and targets."""

    seed: Annotated[int, whole("1", 0)] = 1
    realizations: Annotated[int, whole("100", 1, 1_000_000)] | None = None
    """Members of a lowest level, in place of targets; None: as many as the targets need."""
    max_realizations: Annotated[int, whole("400", 1, 1_000_000)] = 400
    """Most members of a lowest level."""
    until: Annotated[tuple[tuple[str, float], ...], BeforeValidator(_read_targets)] = (
        ("flash_temperature", 0.01),
    )
    """Pairs of an observable and the relative total 95 % error that it should reach at its worst speed."""

    @property
    def most(self) -> int:
        """Most members of a lowest level."""
        return self.realizations or self.max_realizations

    @property
    def ends(self) -> dict[str, float]:
        """The targets that end a run; none with a number of realizations, for which they only set the plan."""
        return {} if self.realizations else dict(self.until)
