"""What the theory says of a scene up to each cut-off of a ladder: the shape by which a run is continued to q_max.

Contact that does not yield goes on rising with the cut-off as the theory does, if not by as much: its steps from one
cut-off to the next, over those of the theory, change slowly. Contact that has yielded falls with the cut-off, and the
theory knows nothing of it. In between nothing tells.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.views import Integrals, area_fractions

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
# parts of the theory's contact that have yielded: from the first on, T_flash falls with the cut-off; while less than
# the second is added up to q_max, it follows the theory (measured on rocks of 1 to 30 GPa)
_YIELDED, _ADDED = 0.99, 0.1
# T_flash of yielded contact falls as q_c^−(0.3 + 1.05 H) between slow and fast sliding; from H = 2/3 on first order is
# as near, and the smaller step
_FALL = (0.3, 1.05)


def yielded(scene: Scene, q_max: float) -> float:
    """Return the part of the theory's contact that has yielded with the roughness up to q_max, rad/m."""
    areas = area_fractions(scene, q_max)
    return areas["plastic_fraction"] / areas["contact_fraction"]


@lru_cache(maxsize=64)
@lru_cache(maxsize=64)
def follows_theory(scene: Scene, column: str, q_max: float) -> bool | None:
    """Return whether a column follows the theory from the cut-off q_max, rad/m, to the end of the spectrum.

    False where it falls as a power of the cut-off, None where nothing tells.
    """
    if column != "capped":
        return True
    before = yielded(scene, q_max)
    if before >= _YIELDED:
        return False
    return True if yielded(scene, inf) - before <= _ADDED else None


def usual_exponent(scene: Scene, q_c: float) -> float:
    """Return the exponent with which yielded contact usually falls beyond a cut-off, rad/m, by the H of C(q) there."""
    above = scene.spectrum.breaks[-1]
    if q_c >= above:
        return 1.0
    q = np.array([q_c, min(above, 16.0 * q_c)])
    first, last = np.log(q), np.log(scene.spectrum(q))
    hurst = -0.5 * float((last[1] - last[0]) / (first[1] - first[0])) - 1.0
    return min(1.0, _FALL[0] + _FALL[1] * min(max(hurst, 0.0), 1.0))


@lru_cache(maxsize=64)
def up_to(scene: Scene, q_max: float) -> dict[str, Array]:
    """Return every observable of the theory with the roughness up to q_max, rad/m, arrays over speed or of one entry.

    Temperatures are with all the heat in the moving body.
    """
    theory, result = Integrals(scene, q_max), {}
    for name, record in OBSERVABLES.items():
        missing = np.full(len(scene.speeds) if record.per_speed else 1, np.nan)
        result[name] = missing if record.theory is None else np.atleast_1d(record.theory(theory))
    return result


def continuation(scene: Scene, column: str, cut_offs: tuple[float, ...], observable: str) -> Array | None:
    """Return what the theory says of an observable up to each cut-off and over all of C(q), (cut-offs + 1, speeds).

    Parameters
    ----------
    scene : Scene
        What is computed.
    column : {"smoothed", "capped", "elastic"}
        Which contact.
    cut_offs : tuple of float
        Of the levels, rad/m, ascending.
    observable : str
        A key of `roughsim.observables.catalogue.OBSERVABLES`.

    Returns
    -------
    ndarray or None
        All NaN where nothing tells; None where the column falls as a power of the cut-off.
    """
    follows = follows_theory(scene, column, cut_offs[-1])
    if follows is False:
        return None
    found = np.stack([up_to(scene, q)[observable] for q in (*cut_offs, inf)])
    return found if follows else np.full_like(found, np.nan)


__all__ = ["continuation", "follows_theory", "up_to", "usual_exponent", "yielded"]
