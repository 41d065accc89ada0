"""Scenes at given places of the map of validity, and a map that is linear in its coordinates."""

import sys
from math import nan, sqrt
from pathlib import Path

import numpy as np

from roughsim.comparison.validity_map import Table
from roughsim.scene import parse_scene

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))
from validity_map import capped, members

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


def scene(load=0.05, hurst=0.7, bandwidth=10.0, gamma=0.45, slope=0.01):
    text = SCENE.format(slope=slope, hurst=hurst, q_max=2e4 * bandwidth, pressure=load * MODULUS * slope, gamma=gamma)
    return parse_scene(text)


def simple_map():
    """ln(measured/theory) = x + ln H + y − z of x = ln load, y = ln bandwidth, z = ln Péclet: linear."""
    quantities = (*(("flash_temperature", pe) for pe in (1e-3, 1.0, 1e3)), ("pressure_variance", nan))
    place = np.array(
        [(p, h, r, 2.0, 0.0) for p in (0.01, 0.03, 0.1) for h in (0.5, 0.8, 1.0) for r in (4.0, 16.0, 64.0)]
    )
    base = np.log(place[:, :3]).sum(axis=1)
    value = np.exp(base[:, None] - np.array([np.log(1e-3), 0.0, np.log(1e3), 0.0]))
    coordinates = ("load", "hurst", "bandwidth", "plateau", "low_exponent")
    return {"elastic": Table(coordinates, ("",) * len(place), quantities, place, value, np.full(value.shape, 0.02))}


def capped_scene(share=0.1, yields=1.0, hurst=0.8, depth=16.0, plateau=2.0, low_exponent=0.0):
    """A scene at these coordinates of the capped map; its C(q) ends at q_max = depth q_y."""
    point = capped.CappedPoint(share, yields, hurst, plateau, low_exponent)
    q_max = depth * yields
    of_slope_1 = members.spectrum_of(hurst, plateau, q_max, low_exponent)
    slope, pressure = 0.01 * sqrt(point.spectrum(1.0) / of_slope_1(1.0)), share * point.hardness * MODULUS * 0.01
    text = SCENE.format(slope=slope, hurst=hurst, q_max=2e4 * q_max, pressure=pressure, gamma=0.45)
    text = text.replace("q_min = 1e4", f"q_min = {2e4 / plateau}\nroll_off_exponent = {low_exponent}")
    text = text.replace("[sliding]", f"penetration_hardness = {point.hardness * MODULUS * 0.01}\n[sliding]")
    speeds = [pe * 2e4 * 30 / (7900 * 500) for pe in (0.01, 1.0, 100.0)]
    return parse_scene(text.replace("[0, 0.1, 35]", str(speeds)))
