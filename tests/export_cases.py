"""Units of the arrays of an exported run."""

UNITS = {
    "flash_temperature": "K", "flash_gradient": "K/m", "flash_laplacian": "K/m^2", "contact_fraction": "1",
    "pressure_variance": "Pa^2", "speed": "m/s", "q_max": "1/m", "pressure_L2": "Pa", "heights_L0": "m", "x_L1": "m",
}  # fmt: skip
