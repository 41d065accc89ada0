"""Response of single waves of a bare half-space to a moving source: steady, or a time after the start from rest."""

import math

import numpy as np
import scipy

from roughsim.grid import Complex, Field

FORGOTTEN = 40.0  # D q² t from which on a mode is steady: e^-40 = 4e-18 of the start is left
COLD = 40.0  # z/2√(Dt) from which on no heat has come so deep: e^(−40²) is 0
# below |λ|√(Dt) = 0.1 the two terms of the buried transient cancel; a series replaces them
_SERIES = 0.1


def response_of_waves(square: Field, advection: Field, depth: float, spread: float) -> Complex:
    """κT/q̇ of the modes with q² = `square` and q·v/D = `advection`, both 1/m²."""
    modulus = np.sqrt(square**2 + advection**2)  # |λ|²; real numbers cost half of a complex root
    real = np.sqrt((modulus + square) / 2)
    surface: Complex = np.empty(real.shape, complex)
    surface.real, surface.imag = real / modulus, advection / (2 * real * modulus)  # 1/λ
    response = surface if depth == 0.0 else surface * np.exp(-depth * modulus * surface.conj())
    young = square * spread < FORGOTTEN  # not steady yet
    if young.any():
        scaled = math.sqrt(spread) / surface[young]
        if depth > 2 * COLD * math.sqrt(spread):
            response[young] = 0.0
        elif depth > 0.0:
            response[young] = math.sqrt(spread) * _buried(scaled, depth / (2 * math.sqrt(spread)))
        else:
            response[young] *= scipy.special.erf(scaled)
    return response


def _buried(b: Complex, a: float) -> Complex:
    """[e^(−2ab) erfc(a−b) − e^(2ab) erfc(a+b)]/(2b) with b = λ√(Dt), a = z/2√(Dt), free of overflow.

    Either term is e^(−a²−b²) w(i(a∓b)), w the Faddeeva function, for Re(a∓b) ≥ 0.
    """
    tail = np.exp(-(a * a) - b * b)
    shallow = b.real > a
    first = tail * scipy.special.erfcx(np.where(shallow, b - a, a - b))
    first = np.where(shallow, 2 * np.exp(-2 * a * b) - first, first)
    result = (first - tail * scipy.special.erfcx(a + b)) / (2 * b)
    # for small b a series in b²: [f(a−b) − f(a+b)]/(2b) by the derivatives of f(x) = e^(x²) erfc(x), f′ = 2xf − 2/√π
    derivatives = [float(scipy.special.erfcx(a))]
    derivatives.append(2 * a * derivatives[0] - 2 / math.sqrt(math.pi))
    for n in range(1, 14):
        derivatives.append(2 * a * derivatives[n] + 2 * n * derivatives[n - 1])
    series = [-derivatives[n] / math.factorial(n) for n in range(1, 14, 2)]
    small = np.abs(b) < _SERIES
    result[small] = tail[small] * np.polynomial.polynomial.polyval(b[small] ** 2, series)
    return result
