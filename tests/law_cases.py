"""Scenes of elastic contact, and the contacts that the calibrated law was compared with."""

import json
import sys
from pathlib import Path

from roughsim.scene import parse_scene

EXPERIMENTS = Path(__file__).parents[1] / "experiments"
sys.path.insert(0, str(EXPERIMENTS))

CONTACTS = json.loads((EXPERIMENTS / "reference" / "contacts.json").read_text())
SCENE = """
[surface]
rms_slope = {slope}
hurst = {hurst}
q_min = 1e4
q_roll_off = 2e4
q_max = {q_max}
[body]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "{pressure} Pa"
friction_coefficient = 0.1
speed = [0, 0.1, 35]
[theory]
gamma = {gamma}
"""
MODULUS = 1e8 / (1 - 0.3**2)
DIFFUSIVITY = 30 / (7900 * 500)


def scene(load=0.05, hurst=0.7, bandwidth=10.0, gamma=0.45, slope=0.01):
    text = SCENE.format(
        slope=slope,
        hurst=hurst,
        q_max=2e4 * bandwidth,
        pressure=load * MODULUS * slope,
        gamma=gamma,
    )
    return parse_scene(text)
