"""Moving circular Hertz source of heat, exact at any speed (Sec. 3 and Appendix A), beside the disc and the square.

The flux q̇₁ √(1 − r²/R²) moves along +x over a half-space. Temperatures are in units of q̇₁R/κ, lengths of R, and
Pe = vR/D; the wake lies at x < 0 (at x > 0 in the Appendix). For the uniform disc q̇₁ is its flux, for the
uniform square R is half its side.
"""

from theory.hertz.limits import (
    DISC_FAST,
    DISC_STATIC,
    FAST,
    SQUARE_FAST,
    SQUARE_STATIC,
    STATIC,
    Limit,
    UniformLimit,
    fast_temperature,
    pressure_correlation,
    static_temperature,
)
from theory.hertz.maximum import (
    disc_hottest_point,
    disc_max_temperature,
    hottest_point,
    max_temperature,
    square_hottest_point,
    square_max_temperature,
)
from theory.hertz.moments import (
    disc_mean_temperature,
    flash_gradient,
    flash_laplacian,
    flash_temperature,
    flash_width,
    mean_temperature,
    slope_length,
    square_mean_temperature,
)

__all__ = [
    "DISC_FAST",
    "DISC_STATIC",
    "FAST",
    "SQUARE_FAST",
    "SQUARE_STATIC",
    "STATIC",
    "Limit",
    "UniformLimit",
    "disc_hottest_point",
    "disc_max_temperature",
    "disc_mean_temperature",
    "fast_temperature",
    "flash_gradient",
    "flash_laplacian",
    "flash_temperature",
    "flash_width",
    "hottest_point",
    "max_temperature",
    "mean_temperature",
    "pressure_correlation",
    "slope_length",
    "square_hottest_point",
    "square_max_temperature",
    "square_mean_temperature",
    "static_temperature",
]
