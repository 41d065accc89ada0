"""A drawn map, and a scene that names it, to be pressed."""

import math

import numpy as np

import roughsim as rs

SIDE = 1e-3
GRID = rs.Grid((96, 64), (SIDE, SIDE * 2 / 3))
AT_35 = {"sliding.speed": 35}


def drawn_map():
    """Heights, m, of one longest wave along y."""
    spectrum = rs.SelfAffineSpectrum.from_rms_height(3e-7, hurst=0.8, q_min=2 * math.pi / GRID.lengths[1], q_max=9e4)
    return rs.synthesize(spectrum, GRID, np.random.default_rng(2), amplitudes="gaussian")


def write_scene(folder, heights, scene):
    """Write map.npy, in µm, and a scene of one rough face that names it, all else from `scene`; return its path."""
    np.save(folder / "map.npy", 1e6 * heights)
    text = scene.to_toml()
    surface_at, body, counter, sliding = (text.index(f"[{n}]") for n in ("surface", "body", "counterface", "sliding"))
    face = f'[surface]\ntopography = "map.npy"\ntopography_size = {list(GRID.lengths)}\ntopography_unit = "um"\n\n'
    rest = "[counterface]\nyoungs_modulus = 2e11\npoisson_ratio = 0.3\n"
    rest += "conductivity = 30\ndensity = 7900\nheat_capacity = 500\n"
    path = folder / "scene.toml"
    path.write_text(text[:surface_at] + face + text[body:counter] + rest + text[sliding:])
    return path
