"""The observables of a scene by a theory, each computed when it is asked for: some take far longer than others."""

from collections.abc import Container, Iterator, Mapping
from math import nan

from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, observables_of
from roughsim.observables.record import TheoryOfScene
from roughsim.scene import Scene

NOTHING = TheoryOfScene(
    {}, nan, correlation_radius=lambda _: nan, total=lambda _: nan
)  # without a theory


class Predicted(Mapping[str, Array]):
    """Every observable by a theory, read-only, over speeds or of one entry; computed when it is first asked for."""

    def __init__(self, view: TheoryOfScene, scene: Scene, known: Container[str] = OBSERVABLES):
        self._view, self._speeds, self._known = (
            view,
            len(scene.speeds),
            known,
        )  # NaN where it is not known
        self._names = list(observables_of(scene.asks))
        self._values: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._values:
            view = self._view if name in self._known else NOTHING
            self._values[name] = OBSERVABLES[name].of_theory(view, self._speeds)
            self._values[name].flags.writeable = False
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
