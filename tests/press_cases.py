"""A drawn map, and a scene that names it, to be pressed."""

import math

import numpy as np

import roughsim as rs

SIDE = 1e-3
GRID = rs.Grid((96, 64), (SIDE, SIDE * 2 / 3))
AT_35 = {"sliding.speed": 35}


def drawn_map():
    """Heights, m, of one longest wave along y."""
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        3e-7, hurst=0.8, q_min=2 * math.pi / GRID.lengths[1], q_max=9e4
    )
    return rs.synthesize(spectrum, GRID, np.random.default_rng(2), amplitudes="gaussian")


def write_scene(folder, heights, scene):
    """Write map.npy, in µm, and a scene of one rough face that names it, all else from `scene`; return its path."""
    np.save(folder / "map.npy", 1e6 * heights)
    text = scene.with_("numerics.levels", None).to_toml()  # they are of another C(q)
    surface_at, body, counter, sliding = (
        text.index(f"[{n}]") for n in ("surface", "body", "counterface", "sliding")
    )
    face = f'[surface]\ntopography = "map.npy"\ntopography_size = {list(GRID.lengths)}\ntopography_unit = "um"\n\n'
    rest = "[counterface]\nyoungs_modulus = 2e11\npoisson_ratio = 0.3\n"
    rest += "conductivity = 30\ndensity = 7900\nheat_capacity = 500\n"
    path = folder / "scene.toml"
    path.write_text(text[:surface_at] + face + text[body:counter] + rest + text[sliding:])
    return path


def levelled(heights):
    """A map less its mean plane, as it is read."""
    result = heights - heights.mean()
    for axis in (0, 1):
        along = np.linspace(-1, 1, heights.shape[axis])
        slope = np.tensordot(result, along, ([axis], [0])).mean() / (along @ along)
        result = result - slope * (along[:, None] if axis == 0 else along)
    return result


def on_finer_points(heights, factor):
    """Trigonometric interpolation of a periodic map, wave by wave, as a matrix for each axis."""
    for axis, n in enumerate(heights.shape):
        k = np.fft.fftfreq(n) * n
        weights = (
            np.exp(2j * np.pi * np.outer(np.arange(n * factor) / (n * factor), k))
            @ np.fft.fft(np.eye(n))
            / n
        )
        heights = np.moveaxis(np.tensordot(weights.real, heights, ([1], [axis])), 0, axis)
    return heights
