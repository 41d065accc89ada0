"""From the members of an elastic point to ratios measured/theory, each with its total error.

ln of every quantity is taken from the main members, shifted by the control variate (coarse members of the same
streams) and by the fine members over the main ones of the same streams. The error holds the Student t of the members
(95 %), the scatter of the shift, and the doubts of pixels and tail.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.stats import t as student

from theory import flash, persson
from validity_map.members import COLUMNS, DISTANCES, PECLET

PER_SPEED = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
QUANTITIES = [*((name, k) for name in PER_SPEED for k in range(PECLET.size)), ("pressure_variance", 0)]
QUANTITIES += [("correlation_radius_50", 0), ("correlation_radius_10", 0)]
LAST_HALVING = 0.007  # of the corrected area from 8 to 16 pixels, where it was measured: 0.3 ... 0.8 %
PIXEL_DOUBT = 0.25  # of the last halving of the pixel: its error falls by a factor of 3 to 8


def linear(mean: Any, quantity: tuple[str, int]) -> tuple[float, Any]:
    """Return ln Q of mean functionals, and the gradient of ln Q with respect to them."""
    name, k = quantity
    gradient = np.zeros(mean.size)
    parts = {
        "flash_width": (("flash_temperature", 0.5), ("flash_laplacian", -0.5)),
        "slope_length": (("flash_temperature", 1.0), ("flash_gradient", -1.0)),
    }.get(name, ((name, 1.0),))
    if name.startswith("correlation_radius"):
        return _radius(mean, 0.01 * int(name[-2:]))
    value = 0.0
    for part, power in parts:
        column = COLUMNS[part].start + k
        value += power * np.log(mean[column])
        gradient[column] += power / mean[column]
    return float(value), gradient


def _radius(mean: Any, fraction: float) -> tuple[float, Any]:
    zero, columns = COLUMNS["pressure_variance"].start, COLUMNS["correlation"]
    share = mean[columns] / mean[zero] - fraction
    curve = CubicSpline(np.log(DISTANCES), share)
    after = int(np.flatnonzero(share < 0.0)[0])
    place = brentq(curve, np.log(DISTANCES[max(after - 1, 0)]), np.log(DISTANCES[after]))
    gradient = np.zeros(mean.size)
    weights = CubicSpline(np.log(DISTANCES), np.eye(DISTANCES.size))(place) / mean[zero]
    gradient[columns], gradient[zero] = weights, -fraction / mean[zero]
    return float(place), -gradient / float(curve(place, 1))


def estimate(raw: Any) -> dict[tuple[str, int], tuple[float, float]]:
    """Return (ln Q, total 95 % error of ln Q) of every quantity of a point, in its dimensionless units."""
    return {quantity: _one(raw, quantity) for quantity in QUANTITIES} | {("contact_fraction", 0): _area(raw)}


def _one(raw: Any, quantity: tuple[str, int]) -> tuple[float, float]:
    main = raw["main"]
    value, gradient = linear(main.mean(axis=0), quantity)
    shift, variance, freedom = _controlled(main @ gradient, raw.get("coarse"), quantity)
    finer, doubts = _fine_shift(raw, quantity)
    statistical = student.ppf(0.975, freedom) * np.sqrt(variance)
    return value + shift + finer, float(np.hypot(statistical, doubts))


def _controlled(own: Any, coarse: Any, quantity: tuple[str, int]) -> tuple[float, float, int]:
    """Return the shift by the control variate, the variance of the mean, and its degrees of freedom."""
    n = own.size
    if coarse is None or coarse.shape[0] <= n:
        return 0.0, float(own.var(ddof=1) / n), n - 1
    return _regressed(own, coarse @ linear(coarse.mean(axis=0), quantity)[1])


def _regressed(own: Any, other: Any) -> tuple[float, float, int]:
    n, many = own.size, other.size
    near = other[:n]
    slope = float(np.cov(own, near)[0, 1] / near.var(ddof=1)) if near.std() > 1e-12 else 0.0  # d_flash = 4D/v at rest
    rest = own - slope * near
    variance = rest.var(ddof=2) / n + slope**2 * other.var(ddof=1) / many
    return slope * float(other.mean() - near.mean()), float(variance), n - 2


def _fine_shift(raw: Any, quantity: tuple[str, int]) -> tuple[float, float]:
    shifts, doubt = [], 0.0
    for pixels in (8, 16):
        if f"fine{pixels}" not in raw:
            continue
        fine = raw[f"fine{pixels}"]
        value, gradient = linear(fine.mean(axis=0), quantity)
        same = raw["reference"][: fine.shape[0]]
        reference, slope = linear(same.mean(axis=0), quantity)
        shifts.append(value - reference)
        scatter = (fine @ gradient - same @ slope).std(ddof=1) / np.sqrt(fine.shape[0]) if fine.shape[0] > 1 else 0.0
        doubt = float(np.hypot(2 * scatter, abs(raw[f"doubt{pixels}"].mean(axis=0) @ gradient)))
    before = shifts[-2] if len(shifts) > 1 else 0.0
    return shifts[-1], float(np.hypot(doubt, PIXEL_DOUBT * (shifts[-1] - before)))


def _area(raw: Any) -> tuple[float, float]:
    """Return ln of the perimeter-corrected area at vanishing pixels: what is left of its error halves with them."""
    main, coarse = raw["main_area"], raw.get("coarse_area")
    mean = main.mean()
    if coarse is not None and coarse.size > main.size:
        shift, variance, freedom = _regressed(main / mean, coarse / coarse.mean())
    else:
        shift, variance, freedom = 0.0, float(main.var(ddof=1) / main.size / mean**2), main.size - 1
    finer = [raw[f"area{pixels}"] for pixels in (8, 16) if f"area{pixels}" in raw]
    logs = [float(np.log(fine.mean() / raw["reference_area"][: fine.size].mean())) for fine in finer]
    last = logs[-1] - logs[-2] if len(logs) > 1 else LAST_HALVING
    doubt = 0.5 * abs(last) + (0.0 if len(logs) > 1 else 2 * LAST_HALVING)
    value = float(np.log(mean)) + shift + logs[-1] + last
    return value, float(np.hypot(student.ppf(0.975, freedom) * np.sqrt(variance), doubt))


def theory_values(spectrum: Any, load: float, **weight: Any) -> dict[tuple[str, int], float]:
    """Return ln Q of the theory over the whole spectrum in the same units; `weight`: gamma=, or stress_spectrum=."""
    if "stress_spectrum" not in weight:
        weight = {"spectrum": spectrum, "effective_modulus": 1.0, "nominal_pressure": load, **weight}
    heat = {"friction_coefficient": load, "conductivity": 1.0, "diffusivity": 1.0, "nominal_pressure": load}
    over_speed = {name: getattr(flash, name)(PECLET, **(weight | heat)) for name in PER_SPEED}
    values = {(name, k): float(np.log(abs(v[k]))) for name, v in over_speed.items() for k in range(PECLET.size)}
    values["pressure_variance", 0] = float(np.log(persson.pressure_correlation(0.0, **weight)))
    for percent in (50, 10):
        radius = persson.correlation_radius(percent / 100, **weight)
        values[f"correlation_radius_{percent}", 0] = float(np.log(radius))
    end = spectrum.breaks[-1]
    share = persson.contact_probability(end, spectrum, effective_modulus=1.0, nominal_pressure=load)
    return values | {("contact_fraction", 0): float(np.log(share))}
