"""Extrapolation of a run from its cut-offs to q_max by theory.

T_flash of contact that does not yield rises with the cut-off roughly in the shape of the theory; its steps over those
of the theory fall by up to a fifth an octave, so elastic contact is better followed by the calibrated law, whose steps
are right to some percent. T_flash of contact that has yielded falls with the cut-off, and only the law describes it. In
between no rule is known.
"""

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import theory
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.prediction.areas import yielded_share
from roughsim.prediction.stress import law_arguments, law_of
from roughsim.prediction.theories import over_speed, predictions
from roughsim.scene import Scene
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum
from theory.yielding import YieldingSpectrum, elastic_steps

# share of the theory's contact that has yielded: T_flash follows the theory if it is at most the first at the end of
# C(q), and falls as a power of the cut-off from the second on. In between it has a maximum: on 24 scenes whose q_y is
# 20 to 2500 q_min the theory was up to 19 % above the end, and a power up to 23 %
_ELASTIC, _YIELDED = 0.05, 0.99
_HALF = 0.5  # from here on areas and the variance of the stress tend to their bounds (experiments/cut_ladders.py)
# T_flash of yielded contact falls as q_c^−(0.3 + 1.05 H) between slow and fast sliding; from H = 2/3 on the exponent 1
# fits as well, and extrapolates less
_FALL = (0.3, 1.05)
_ALIKE = 0.5  # exponents of C(q) that differ by less are the same: H by .25
_SLOW = 1e-12  # m/s: T_flash of so slow bodies is proportional to their speed


def continuation(
    scene: Scene, column: str, cut_offs: tuple[float, ...], observable: str
) -> Array | None:
    """Return an observable of the theory up to each cut-off and over all of C(q), shape (cut-offs + 1, speeds).

    `cut_offs` belong to the levels of the column, rad/m, ascending. All NaN if it is unknown whether the column follows
    the theory; None if it falls as a power of the cut-off, or tends to its bound.
    """
    yielded = _HALF if OBSERVABLES[observable].by_force_balance else _YIELDED
    follows = follows_theory(scene, column, cut_offs, yielded)
    if follows is False:
        return None
    theories = *(predictions(scene, q) for q in cut_offs), predictions(scene)
    values = np.stack([theory[observable] for theory in theories])
    return values if follows else np.full_like(values, nan)


def follows_theory(
    scene: Scene, column: str, cut_offs: tuple[float, ...], yielded: float = _YIELDED
) -> bool | None:
    """Return whether a column follows the theory from the last of its cut-offs, rad/m, to the end of the spectrum.

    False if it falls as a power of the cut-off, as it does if the share `yielded` of contact has yielded at the last
    two cut-offs; None if neither is known.
    """
    if column != "capped" or yielded_share(scene) <= _ELASTIC:
        return True
    return False if yielded_share(scene, min(cut_offs[-2:])) >= yielded else None


def calibrated_flash(scene: Scene, column: str, cut_offs: tuple[float, ...]) -> Array | None:
    """Return T_flash, K, by the calibrated law up to the last two cut-offs, rad/m, and over all of C(q).

    Its shape is (cut-offs + 1, speeds), with all heat in the moving body. None outside the range of the law, and where
    contact is neither elastic nor has yielded. `cut_offs` belong to the levels of the column, ascending.
    """
    if scene.elastic or follows_theory(scene, column, cut_offs) is False:
        return _calibrated_flash(scene, cut_offs[-2:])
    return None


# 10 to 40 ms for each observable in each round
@lru_cache(maxsize=256)
def _calibrated_flash(scene: Scene, cut_offs: tuple[float, ...]) -> Array | None:
    name, speeds = "flash_temperature", np.array(scene.speeds)
    try:
        laws = _laws(scene, cut_offs)
        rows = [over_speed(scene, speeds, stress_spectrum=law, names=(name,))[name] for law in laws]
    except theory.quadrature.QuadratureError:
        return None
    if not rows:
        return None
    values = np.stack(rows)
    values.flags.writeable = False
    return values


def _laws(scene: Scene, cut_offs: tuple[float, ...]) -> list[YieldingSpectrum]:
    """Return |σ_q|² by the law up to each cut-off, rad/m, and of all waves; none if one is out of range.

    Waves of faces with a lay have the modulus of the contact of all waves up to them, which finer ones do not change.
    """
    spectrum: Any = scene.spectrum
    solid = law_arguments(scene)
    modulus = solid.pop("effective_modulus")

    def law(q_max: float, modulus: float) -> YieldingSpectrum:
        return _law(spectrum, q_max, effective_modulus=modulus, **solid)

    try:
        if scene.lay > 1.0:
            whole = theory.lay.in_stretched_frame(partial(law, inf), scene.lay, modulus)
            modulus = whole.effective_modulus
            spectrum = _Stiffened(spectrum, scene.lay, modulus, **solid)
        return [law(q, modulus) for q in (*cut_offs, inf)]
    except ValueError:
        return []


@dataclass(frozen=True)
class _Stiffened:
    """C(q) in m⁴ times the square of E_eff at the elastic area up to q over that of all waves, `modulus`, Pa."""

    spectrum: Spectrum
    lay: float
    modulus: float
    nominal_pressure: float
    penetration_hardness: float | None

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks, rad/m, rising."""
        return tuple(self.spectrum.breaks)

    def __call__(self, q: Array) -> Array:
        """Return its values at wavenumbers `q`, rad/m, elementwise."""
        return np.asarray(self.spectrum(q) * (self._factor(q) / self._factor(self.breaks[-1])) ** 2)

    def _factor(self, q: ArrayLike) -> Array:
        load, hardness = self.nominal_pressure, self.penetration_hardness
        variance = theory.persson.half_variance(q, self.spectrum, effective_modulus=self.modulus)
        if hardness is None:
            elastic = theory.full_contact.probability(variance, load)
        else:
            elastic = theory.plasticity.area_fractions(variance, load, hardness)[1]
        return np.asarray(np.vectorize(theory.lay.stiffening)(self.lay, elastic))


# .01 s each: the same for both bodies, and in each round
_elastic_law = lru_cache(maxsize=64)(elastic_steps)


def _law(
    spectrum: Spectrum, q_max: float, penetration_hardness: float | None, **solid: float
) -> YieldingSpectrum:
    """Return |σ_q|² by the law up to one cut-off, rad/m, without hardness of elastic contact."""
    cut: Any = TruncatedSpectrum(spectrum, q_max) if q_max < inf else spectrum
    if penetration_hardness is None:
        return _elastic_law(cut, **solid)
    return law_of(cut, **solid, penetration_hardness=penetration_hardness)


def follows_power(scene: Scene, cut_offs: tuple[float, ...]) -> bool | None:
    """Return whether C(q) falls alike between the last three cut-offs, rad/m, and in each of four octaves beyond.

    False if it falls more steeply further on, so that less follows than by a power of the cut-off; None if it falls
    less steeply somewhere, or has gaps.
    """
    end, q_c = scene.spectrum.breaks[-1], cut_offs[-1]
    beyond = [q_c * 2.0**k for k in range(1, 5) if q_c * 2.0**k < end * (1 - 1e-9)]
    if len(beyond) < 4:
        beyond.append(end)
    q = np.array([*cut_offs[-3:], *beyond])
    with np.errstate(divide="ignore", invalid="ignore"):  # gaps
        exponents = -np.diff(np.log(scene.spectrum(q))) / np.diff(np.log(q))
        flatter = np.max(np.maximum.accumulate(exponents) - exponents)
    return None if not flatter <= _ALIKE else bool(np.ptp(exponents) <= _ALIKE)


def usual_exponent(scene: Scene, q_c: float) -> float:
    """Return the usual exponent of the fall of T_flash beyond a cut-off, rad/m, for yielded contact of the H there."""
    end = scene.spectrum.breaks[-1]
    if q_c >= end * (1 - 1e-9):  # the cut-off of a map and the end of its C(q) differ by rounding
        return 1.0
    q = np.array([q_c, min(end, 16.0 * q_c)])
    first, last = np.log(q), np.log(scene.spectrum(q))
    hurst = -0.5 * float((last[1] - last[0]) / (first[1] - first[0])) - 1.0
    return min(1.0, _FALL[0] + _FALL[1] * min(max(hurst, 0.0), 1.0))


def slow(scene: Scene) -> Scene:
    """Return a scene whose speeds are slow, one for each of its own: T_flash grows in proportion to them."""
    speeds = tuple(_SLOW * (1 + k) for k in range(len(scene.sliding.speed)))
    return replace(scene, sliding=replace(scene.sliding, speed=speeds))


def in_motion(scene: Scene) -> Scene:
    """Return a scene with a slow speed in place of rest, since a ratio of two zeros is undefined."""
    speeds = tuple(speed or _SLOW for speed in scene.sliding.speed)
    return replace(scene, sliding=replace(scene.sliding, speed=speeds))
