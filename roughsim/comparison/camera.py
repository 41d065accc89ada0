"""What the camera of a scene sees, in a line of a first screen."""

from collections.abc import Iterator, Mapping
from math import degrees, inf

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


def pictured(scene: Scene, columns: Mapping[str, ColumnOf], *simulated: str) -> Iterator[str]:
    """Yield a line on the picture at the highest speed, by simulated columns that have it, and the calibrated law.

    Of several directions it is the first.
    """
    if scene.camera is None:
        return
    names = seen(scene)
    shown = [*(name for name in simulated if columns[name](names[0]) is not None), CALIBRATED]
    k, parts = int(np.argmax(scene.speeds)), []
    for name in names:
        found = (columns[column](name) for column in shown)
        values = [
            str(one.number(*map(int, np.unravel_index(k, one.mean.shape))))
            for one in found
            if one is not None
        ]
        if values:
            parts.append(f"{with_unit(name, OBSERVABLES[name].unit)} {', '.join(values)}")
    angle = scene.cases[k].get("direction")
    way = "" if angle is None else f" and {degrees(angle):.4g}°"
    yield f"camera at {scene.speeds[k]:g} m/s{way} ({', '.join(shown)}): {'; '.join(parts)}."


def meaning_of(scene: Scene) -> Iterator[str]:
    """Yield the meaning of what the camera sees; nothing without one."""
    if scene.camera is None:
        return
    slid = prediction.slid_distances(scene)
    after = "steady" if inf in slid else "after the slid distance of the scene"
    yield (
        f"seen: of the picture that [camera] takes, above the mean of the surface, {after}{_of_slide(scene)}. seen_99: "
        "1 % of the picture is hotter; seen_width: full width at half maximum of the correlation across sliding, √2 times "
        "that of a Gaussian track."
    )


def _of_slide(scene: Scene) -> str:
    """Return what the column sliding has of the picture; empty of a scene without it."""
    if scene.sliding.history != SLIDING:
        return ""
    if scene.camera is not None and scene.camera.behind is not None:
        return "; unknown in the column sliding, where no line behind the contact is followed"
    return "; in the column sliding its mean over the exposure, with which the slide ends: unknown if that is longer"
