"""What the camera of a scene sees, in a line of a first screen."""

from collections.abc import Iterator, Mapping
from math import inf

import numpy as np

from roughsim import prediction
from roughsim.observables.catalogue import CAMERA, OBSERVABLES, observables_of
from roughsim.results.theories import CALIBRATED, ColumnOf
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
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
    if scene.sliding.history == SLIDING:
        parts.append("unknown of the column sliding, whose pictures change as the faces move")
    yield f"camera at {scene.speeds[k]:g} m/s ({of}): {'; '.join(parts)}."


def meaning_of(scene: Scene) -> Iterator[str]:
    """Yield the meaning of what the camera sees; nothing without one."""
    if scene.camera is None:
        return
    slid = prediction.slid_distances(scene)
    after = "steady" if inf in slid else "after the slid distance of the scene"
    unknown = "; unknown of the column sliding" * (scene.sliding.history == SLIDING)
    yield (
        f"seen: of the picture that [camera] takes, above the mean of the surface, {after}{unknown}. seen_99: 1 % of the "
        "picture is hotter; seen_width: full width at half maximum of the correlation across sliding, √2 times that of a "
        "Gaussian track."
    )
