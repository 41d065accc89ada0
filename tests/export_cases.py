"""Units of the arrays of an exported run, and of those of its dataset."""

BOTH = {
    "flash_temperature": "K", "flash_gradient": "K/m", "flash_laplacian": "K/m^2", "contact_fraction": "1",
    "pressure_variance": "Pa^2", "speed": "m/s",
}  # fmt: skip
UNITS = {f"results/{name}": unit for name, unit in BOTH.items()} | {
    "results/flash_temperature_total_error": "K", "members/pressure_L2": "Pa", "members/heights_L0": "m",
    "members/x_L1": "m", "members/temperature_L2": "K", "members/flash_temperature": "K",
}  # fmt: skip
FLAT_UNITS = BOTH | {
    "q_max": "1/m",
    "pressure_L2": "Pa",
    "heights_L0": "m",
    "x_L1": "m",
    "temperature_L2": "K",
}
