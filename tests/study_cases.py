"""What the studies of the tests vary."""

LOADS = [1e8, 1.2e8, 3e8]
VARY = {"sliding.nominal_pressure": LOADS, "sliding.friction_coefficient": [0.1, 0.2]}
