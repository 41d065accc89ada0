"""What the camera of a scene sees, in a line of a first screen."""

from collections.abc import Iterator, Mapping

import numpy as np

from roughsim.observables.catalogue import CAMERA, OBSERVABLES, observables_of
from roughsim.results.theories import CALIBRATED, ColumnOf
from roughsim.scene import Scene
from roughsim.show.table import with_unit


def seen(scene: Scene) -> list[str]:
    """Return the names of the observables of the camera; none without one."""
    return [name for name in observables_of(scene.asks) if OBSERVABLES[name].asked == CAMERA]


def pictured(scene: Scene, columns: Mapping[str, ColumnOf], column: str = "") -> Iterator[str]:
    """Yield a line on the picture at the highest speed, by the calibrated law and, if named, by another column."""
    if scene.camera is None:
        return
    k, parts = int(np.argmax(scene.speeds)), []
    for name in seen(scene):
        by_law = columns[CALIBRATED](name)
        own = columns[column](name) if column else None
        values = [str(one.number(k)) for one in (own, by_law) if one is not None]
        if values:
            parts.append(f"{with_unit(name, OBSERVABLES[name].unit)} {', '.join(values)}")
    of = f"{column}, calibrated" if column else CALIBRATED
    yield f"camera at {scene.speeds[k]:g} m/s ({of}): {'; '.join(parts)}."
