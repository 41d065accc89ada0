"""Hints for common words that are no keys of a scene: derived quantities, and other names and symbols of keys."""

_SYMBOLS = {
    "rms_height": ("h_rms", "Rq", "Sq"),
    "rms_slope": ("xi", "Rdq", "Sdq"),
    "hurst": ("H",),
    "q_min": ("q0", "q_0"),
    "q_roll_off": ("q_r", "qr"),
    "q_max": ("q1", "q_1"),
    "youngs_modulus": ("E",),
    "poisson_ratio": ("nu",),
    "penetration_hardness": ("hardness", "sigma_P"),
    "conductivity": ("kappa",),
    "density": ("rho",),
    "heat_capacity": ("specific_heat", "C_p", "c_p", "cp"),
    "nominal_pressure": ("sigma_0", "sigma0"),
    "friction_coefficient": ("friction", "mu"),
    "speed": ("velocity", "v"),
    "duration": ("time",),
}
_MEAN_HEIGHT = "for Gaussian heights the rms_height is 1.25 Ra; give that"

OTHER_NAMES = {
    symbol: f'did you mean "{key}"?' for key, symbols in _SYMBOLS.items() for symbol in symbols
} | {
    "diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "thermal_diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "effusivity": "it is √(conductivity·density·heat_capacity); give these three",
    "effective_modulus": "it follows from youngs_modulus and poisson_ratio of both bodies; give these",
    "shear_modulus": "it is youngs_modulus/(2 (1 + poisson_ratio)); give these two",
    "R_a": _MEAN_HEIGHT,
    "Ra": _MEAN_HEIGHT,
    "load": "the nominal_pressure is the load over the nominal area; give that",
    "wavelength": "waves are given as q = 2π/wavelength: the longest by q_min, the shortest by q_max",
}
