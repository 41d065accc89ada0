"""A capped scene and one of full contact that run in seconds."""

CAPPED = """
title = "small capped"
[surface]
rms_height = "0.9 um"
hurst = 0.8
q_min = 6350
q_roll_off = 2e4
q_max = 2e5
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
penetration_hardness = "1 GPa"
conductivity = 30
density = 7900
heat_capacity = 500
[counterface]
like = "body"
[sliding]
nominal_pressure = "90 MPa"
friction_coefficient = 0.11
speed = [0, 0.1, 35]
heat_partition = 0.9
[theory]
gamma = 0.3
[ensemble]
seed = 3
max_realizations = 6
until = {}
[numerics]
lengths = [2e-3, 2e-3]
tolerance = 1e-4
levels = [
  { column = "smoothed", shape = [64, 64], q_max = 5e4 },
  { column = "capped", shape = [64, 64], q_max = 5e4 },
  { column = "capped", shape = [128, 128], q_max = 1e5 },
]
"""

# σ₀ ≥ 11 √G: full contact, where W = 1 to rounding and every mode sum is exact
FULL = """
title = "full contact"
[surface]
rms_height = "5 nm"
hurst = 0.8
q_min = 6283.1853
q_max = 1e5
[body]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[counterface]
conductivity = 15
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "2 MPa"
friction_coefficient = 0.11
speed = [0, 0.001, 1, 35]
[ensemble]
seed = 3
max_realizations = 4
until = {}
[numerics]
lengths = [2e-3, 2e-3]
tolerance = 1e-12
levels = [{ column = "elastic", shape = [96, 96], q_max = 1e5 }]
"""
