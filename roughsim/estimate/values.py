"""How a value is made of the levels of one column: heat shared, continued to the end of C(q), exact at rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.estimate.ladder import Values, observe
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics

ROUNDING = 1e-9  # relative, of wavenumbers


def values_of(
    scene: Scene, column: str, observable: str, samples: list[Sample], *, extrapolated: bool = True
) -> Values:
    """Return the values of an observable from the levels of a column, coarsest first, with all heat in the moving body.

    Not extrapolated they are those of the highest cut-off.
    """
    if observable == "heat_partition":
        samples = [prediction.balanced(scene, sample) for sample in samples]
    cut_offs = tuple(sorted({sample.q_max for sample in samples}))
    end = scene.spectrum.breaks[-1] if extrapolated else cut_offs[-1]
    theory, fall = None, dict[str, Any]()
    if cut_offs[-1] < end * (1 - ROUNDING):
        theory = prediction.continuation(scene, column, cut_offs, observable)
    if column == "capped" and theory is None:  # it has yielded, and falls as a power of the cut-off from 4 q_y on
        fall["settled"] = 4.0 * prediction.yield_wavenumber(scene)
        fall["usual"] = prediction.usual_exponent(scene, cut_offs[-1])
    values = observe(observable, samples, capped=column == "capped", end=end, theory=theory, **fall)
    at_rest = OBSERVABLES[observable].at_rest
    if at_rest is None:
        return values
    # members are measured at a tiny speed instead of at rest: there the exact limit counts, without error
    moving = np.array(scene.speeds) > 0.0
    exact = dict.fromkeys(("extrapolated", "finest", "base"), at_rest) | {"bandwidth": 0.0, "pixel": 0.0}
    return values._replace(**{key: np.where(moving, getattr(values, key), x) for key, x in exact.items()})


def notes_of(scene: Scene, numerics: Numerics, column: str, observable: str, values: Values) -> tuple[str, ...]:
    """Return in words what values were made of: the levels, how they were continued to the end of C(q), the speeds."""
    levels = [numerics.levels[i] for i in numerics.of_column(column)]
    grids = ", ".join(f"{level.shape[0]} × {level.shape[1]} to {level.q_max:.3g}" for level in levels)
    notes = [f"{column} contact on {grids} rad/m, solver tolerance {numerics.tolerance:.1g}"]
    if np.any(np.isfinite(values.exponent)):
        exponents = ", ".join(dict.fromkeys(f"{p:.2f}" for p in values.exponent))
        notes.append(f"extrapolated as q_c^(−p) with p = {exponents}")
    elif column == "capped" and not OBSERVABLES[observable].limit:
        notes.append("does not converge with the grid: the value of the finest level, not extrapolated")
    elif levels[-1].q_max < scene.spectrum.breaks[-1] * (1 - ROUNDING):
        if values.extrapolated is values.finest and np.any(values.bandwidth > 0.0):
            notes.append("shorter than a wave of the cut-offs: the value of the highest q_c, the last step is in doubt")
        elif np.any(values.bandwidth > 0.0):
            notes.append("continued from q_c to q_max with the shape of the theory")
        if np.any(np.isnan(values.bandwidth)):
            notes.append("where the bandwidth is unknown, the value of the highest q_c")
    if OBSERVABLES[observable].per_speed:
        notes.append(f"speeds {', '.join(f'{v:g}' for v in scene.speeds)} m/s")
    return tuple(notes)
