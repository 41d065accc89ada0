"""What the theory says of a scene up to each cut-off of a ladder: the shape by which a run is continued to q_max.

Contact that does not yield goes on rising with the cut-off as the theory does, if not by as much: its steps from one
cut-off to the next, over those of the theory, change slowly. Contact that has yielded falls with the cut-off, and the
theory knows nothing of it. In between it is not known which of the two holds.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.integrals import area_fractions, integrals
from roughsim.scene import Scene

Array = NDArray[np.float64]
# parts of the theory's contact that have yielded: from the first on, T_flash falls with the cut-off; while less than
# the second is added up to q_max, it follows the theory (measured on rocks of 1 to 30 GPa)
_YIELDED, _ADDED = 0.99, 0.1
# T_flash of yielded contact falls as q_c^−(0.3 + 1.05 H) between slow and fast sliding; from H = 2/3 on first order is
# as near, and the smaller step
_FALL = (0.3, 1.05)


@lru_cache(maxsize=64)
def predictions(scene: Scene, q_max: float = inf) -> dict[str, Array]:
    """Return every observable over C(q), or over its part up to q_max, rad/m; NaN where there is no theory.

    The arrays over speed, or of one entry, are read-only. Temperatures are with all the heat in the moving body.
    """
    view = integrals(scene, q_max)
    result = {name: record.of_theory(view, len(scene.speeds)) for name, record in OBSERVABLES.items()}
    for values in result.values():
        values.flags.writeable = False
    return result


@lru_cache(maxsize=64)
def follows_theory(scene: Scene, column: str, q_max: float) -> bool | None:
    """Return whether a column follows the theory from the cut-off q_max, rad/m, to the end of the spectrum.

    False where it falls as a power of the cut-off, None where it is not known.
    """
    if column != "capped":
        return True
    ends = area_fractions(scene, q_max), area_fractions(scene)
    now, at_the_end = (areas["plastic_fraction"] / areas["contact_fraction"] for areas in ends)
    if now >= _YIELDED:
        return False
    return True if at_the_end - now <= _ADDED else None


def usual_exponent(scene: Scene, q_c: float) -> float:
    """Return the exponent with which yielded contact usually falls beyond a cut-off, rad/m, by the H of C(q) there."""
    end = scene.spectrum.breaks[-1]
    if q_c >= end:
        return 1.0
    q = np.array([q_c, min(end, 16.0 * q_c)])
    first, last = np.log(q), np.log(scene.spectrum(q))
    hurst = -0.5 * float((last[1] - last[0]) / (first[1] - first[0])) - 1.0
    return min(1.0, _FALL[0] + _FALL[1] * min(max(hurst, 0.0), 1.0))


def continuation(scene: Scene, column: str, cut_offs: tuple[float, ...], observable: str) -> Array | None:
    """Return what the theory says of an observable up to each cut-off and over all of C(q), (cut-offs + 1, speeds).

    `cut_offs` are those of the levels of the column, rad/m, ascending. All NaN where it is not known whether the column
    follows the theory; None where it falls as a power of the cut-off.
    """
    follows = follows_theory(scene, column, cut_offs[-1])
    if follows is False:
        return None
    values = np.stack([predictions(scene, q)[observable] for q in (*cut_offs, inf)])
    return values if follows else np.full_like(values, np.nan)
