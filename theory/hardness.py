"""Hardness of a hot contact: the penetration hardness at the temperature that the contact reaches with it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, real_array
from theory.roots import root


def self_consistent(
    flash_temperature: Callable[[float], float],
    temperature: ArrayLike,
    penetration_hardness: ArrayLike,
    *,
    background: float = 0.0,
) -> tuple[float, float]:
    """Solve σ_P = H(T₀ + T_flash(σ_P)) for one effective hardness.

    A softer body is less hot, and a hotter one softer, so there is one solution at most.

    Parameters
    ----------
    flash_temperature : callable
        T_flash in K of one penetration hardness in Pa, rising with it.
    temperature : array_like
        Temperatures of the table of hot hardness, shape (n,), n ≥ 2, rising, K above the same zero as `background`.
    penetration_hardness : array_like
        H at these temperatures, shape (n,), Pa, > 0, not rising; straight lines between.
    background : float
        T₀, the temperature to which T_flash adds, K.

    Returns
    -------
    (penetration_hardness, flash_temperature) : float, float
        σ_P in Pa and T_flash in K that belong together.

    Raises
    ------
    TypeError, ValueError
        If the table is not as above, T₀ lies below it, or the contact becomes hotter than the table reaches.
    """
    temperatures, hardness = _table(temperature, penetration_hardness)
    start = float(real_array("background", background, "K"))
    if not temperatures[0] <= start <= temperatures[-1]:
        raise ValueError(
            f"background = {start:.6g} K lies outside the table of {temperatures[0]:.6g} to {temperatures[-1]:.6g} K"
        )

    def excess(contact: float) -> float:
        """Return T₀ + T_flash at the hardness of the temperature `contact`, less that temperature."""
        return (
            start + flash_temperature(float(np.interp(contact, temperatures, hardness))) - contact
        )

    if excess(float(temperatures[-1])) > 0.0:
        raise ValueError(
            f"the contact becomes hotter than the table, whose last temperature is {temperatures[-1]:.6g} K; extend "
            "the table"
        )
    accuracy = 1e-12 * max(abs(start), 1.0)
    contact = root(excess, start, float(temperatures[-1]), accuracy=accuracy, relative=1e-14)
    return float(np.interp(contact, temperatures, hardness)), contact - start


def _table(temperature: ArrayLike, penetration_hardness: ArrayLike) -> tuple[Array, Array]:
    temperatures = real_array("temperature", temperature, "K")
    hardness = real_array("penetration_hardness", penetration_hardness, "Pa")
    if (
        temperatures.ndim != 1
        or temperatures.size < 2
        or hardness.shape != temperatures.shape
        or (np.diff(temperatures) <= 0.0).any()
    ):
        raise ValueError(
            f"temperature and penetration_hardness have shapes {temperatures.shape} and {hardness.shape}; "
            "give one hardness for each of two or more rising temperatures"
        )
    if (hardness <= 0.0).any() or (np.diff(hardness) > 0.0).any():
        raise ValueError(
            "penetration_hardness must be positive and must not rise with the temperature"
        )
    return temperatures, hardness
