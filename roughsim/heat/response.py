"""What each mode of the heat flux answers with: κT/q̇, steady or from rest, at any depth; and the times to ask for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from roughsim.errors import number, real_field
from roughsim.fourier import convolution
from roughsim.grid import Grid

Field = NDArray[Any]
ROWS = 32  # rows of the half spectrum in one block: the work arrays stay in the cache
FORGOTTEN = 40.0  # e^-40 = 4e-18: beyond D q² t = 40 a mode has forgotten its start
_SERIES = 0.1  # below |λ|√(Dt) = 0.1 the two terms of the buried transient cancel; a series replaces them


def unit_vector(direction: float) -> tuple[float, float]:
    """Return (cos, sin) of `direction`, exact at quarter turns.

    The rounding of cos(π/2) would let a source at Péclet number 1e12 drift across its own track.
    """
    angle = number("direction", direction, "rad")
    ux, uy = math.cos(angle), math.sin(angle)
    return (ux if abs(ux) > 1e-15 else 0.0), (uy if abs(uy) > 1e-15 else 0.0)


def responses(
    grid: Grid, drift: tuple[float, float], depth: float = 0.0, spread: float = math.inf
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.complex128]]]:
    """Yield (rows, κT/q̇ in m) block by block: every row of the half spectrum once, q = 0 with response 0.

    `drift` is v/D along x and y, 1/m; `depth` the distance below the surface, m; `spread` D t, m², t the time since the
    start from rest; inf is the steady state.
    """
    qx = grid.wavevectors[0]
    count, half = grid.shape[0], grid.shape[0] // 2 + 1
    for start in range(0, half, ROWS):
        rows = np.arange(start, min(start + ROWS, half))
        response = _response_rows(grid, rows, qx[rows], drift, depth, spread)
        if start == 0:
            response[0, 0] = 0.0
        yield rows, response
        # the rows at −q_x follow from those at q_x where the source slides along an axis
        inner = (rows > 0) & (2 * rows != count)  # those have a partner at −q_x
        if not inner.any():
            continue
        if drift[1] == 0.0:
            partner = response[inner].conj()
        elif drift[0] == 0.0:
            partner = response[inner]
        else:
            partner = _response_rows(grid, rows, -qx[rows], drift, depth, spread)[inner]
        yield count - rows[inner], partner


def _response_rows(
    grid: Grid, rows: NDArray[np.intp], qx: Field, drift: tuple[float, float], depth: float, spread: float
) -> NDArray[np.complex128]:
    """κT/q̇ at the wavevectors (qx, q_y ≥ 0), averaged over both signs where an axis is at its Nyquist wavenumber."""
    qy = grid.wavevectors[1]
    along, across, square = drift[0] * qx, drift[1] * qy, qx**2 + qy**2
    square[square == 0.0] = 1.0  # q = 0: any finite response, replaced by the caller

    def both_signs_of_qy(part: slice, along: Field) -> NDArray[np.complex128]:
        response = response_of_modes(square[part], along + across, depth, spread)
        if grid.shape[1] % 2 == 0:
            flipped = response_of_modes(square[part, -1:], along - across[:, -1:], depth, spread)
            response[:, -1:] = (response[:, -1:] + flipped) / 2
        return response

    response = both_signs_of_qy(slice(None), along)
    if 2 * rows[-1] == grid.shape[0]:
        response[-1:] = (response[-1:] + both_signs_of_qy(slice(-1, None), -along[-1:])) / 2
    return response


def response_of_modes(square: Field, advection: Field, depth: float, spread: float) -> NDArray[np.complex128]:
    """κT/q̇ of the modes with q² = `square` and q·v/D = `advection`, both 1/m²."""
    modulus = np.sqrt(square**2 + advection**2)  # |λ|²; real numbers cost half of a complex root
    real = np.sqrt((modulus + square) / 2)
    surface: NDArray[np.complex128] = np.empty(real.shape, np.complex128)
    surface.real, surface.imag = real / modulus, advection / (2 * real * modulus)  # 1/λ
    response = surface if depth == 0.0 else surface * np.exp(-depth * modulus * surface.conj())
    young = square * spread < FORGOTTEN  # these remember their start
    if young.any():
        scaled = math.sqrt(spread) / surface[young]
        if depth > 0.0:
            response[young] = math.sqrt(spread) * _buried(scaled, depth / (2 * math.sqrt(spread)))
        else:
            response[young] *= special.erf(scaled)
    return response


def _buried(b: NDArray[np.complex128], a: float) -> NDArray[np.complex128]:
    """[e^(−2ab) erfc(a−b) − e^(2ab) erfc(a+b)]/(2b) with b = λ√(Dt), a = z/2√(Dt), free of overflow.

    Either term is e^(−a²−b²) w(i(a∓b)), w the Faddeeva function, where Re(a∓b) ≥ 0.
    """
    tail = np.exp(-(a * a) - b * b)
    shallow = b.real > a
    first = tail * special.erfcx(np.where(shallow, b - a, a - b))
    first = np.where(shallow, 2 * np.exp(-2 * a * b) - first, first)
    result: NDArray[np.complex128] = (first - tail * special.erfcx(a + b)) / (2 * b)
    # for small b a series in b²: [f(a−b) − f(a+b)]/(2b) by the derivatives of f(x) = e^(x²) erfc(x), f′ = 2xf − 2/√π
    derivatives = [float(special.erfcx(a))]
    derivatives.append(2 * a * derivatives[0] - 2 / math.sqrt(math.pi))
    for n in range(1, 14):
        derivatives.append(2 * a * derivatives[n] + 2 * n * derivatives[n - 1])
    series = [-derivatives[n] / math.factorial(n) for n in range(1, 14, 2)]
    small = np.abs(b) < _SERIES
    result[small] = tail[small] * np.polynomial.polynomial.polyval(b[small] ** 2, series)
    return result


def fields_over_time(
    flux: Field,
    spreads: NDArray[np.float64],
    response: Any,
    arguments: tuple[Any, ...],
    shape: tuple[int, int],
    factor: float,
) -> Field:
    """Return one field per entry of `spreads`: one forward transform for all, one inverse each; zero where D t = 0.

    `response(*arguments, spread)` is what `convolution.convolve` takes; its `lru_cache` keeps that of a single field,
    but not those of a series, which would fill the memory.
    """
    flowing = np.flatnonzero(spreads > 0.0)
    if spreads.size == flowing.size == 1:
        return convolution.convolve(flux, response(*arguments, float(spreads[0])), shape, factor)[None]
    fields = np.zeros((spreads.size, *flux.shape), flux.dtype)
    if flowing.size:
        series = (response.__wrapped__(*arguments, float(spread)) for spread in spreads[flowing])
        for index, field in zip(flowing, convolution.convolutions(flux, series, shape, factor), strict=True):
            fields[index] = field
    return fields


def checked_times(time: ArrayLike) -> NDArray[np.float64]:
    """`time` as a float array of at most one axis, s, ≥ 0; inf may stay."""
    instants = np.asarray(time)
    if instants.dtype.kind not in "iuf":
        raise TypeError(f"time has dtype {instants.dtype}; real numbers in s are needed")
    if instants.ndim > 1 or instants.size == 0:
        raise ValueError(f"time has shape {instants.shape}; give one number or a 1-D array, in s")
    if not (instants >= 0).all():
        raise ValueError(f"time = {instants.min()} s must not be negative or NaN")
    return instants.astype(np.float64)


def checked_duration(time: ArrayLike) -> float:
    """`time` as one number, s, > 0; inf may stay."""
    instant = checked_times(time)
    if instant.ndim or instant == 0.0:
        raise ValueError(f"time = {time!r} s must be one positive number")
    return float(instant)


def checked_flux(heat_flux: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    """`heat_flux` as a float64 field of `shape`, W/m², ≥ 0."""
    flux = real_field("heat_flux", heat_flux, shape).astype(np.float64)
    if flux.min() < 0.0:
        raise ValueError(f"heat_flux = {flux.min():.6g} W/m² must not be negative: friction only heats")
    return flux
