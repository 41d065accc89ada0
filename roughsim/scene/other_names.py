"""Hints for common words that are no keys of a scene: derived quantities, and other names of keys."""

OTHER_NAMES = {
    "diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "thermal_diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "effusivity": "it is √(conductivity·density·heat_capacity); give these three",
    "effective_modulus": "it follows from youngs_modulus and poisson_ratio of both bodies; give these",
    "shear_modulus": "it is youngs_modulus/(2 (1 + poisson_ratio)); give these two",
    "hardness": 'did you mean "penetration_hardness"?',
    "specific_heat": 'did you mean "heat_capacity"?',
    "velocity": 'did you mean "speed"?',
    "load": "the nominal_pressure is the load over the nominal area; give that",
    "friction": 'did you mean "friction_coefficient"?',
    "time": 'did you mean "duration"?',
    "wavelength": "waves are given as q = 2π/wavelength: the longest by q_min, the shortest by q_max",
}
