"""Write ground.npy, a ground face: grooves with γ = 4 at 30° from x, whose highest quarter is worn off."""

import numpy as np

import roughsim as rs
from roughsim.surface.directions import with_lays

grid = rs.Grid((192, 192), (6e-4, 6e-4))
grooves = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=4e4, q_max=4e5)
face = with_lays([(grooves, 4.0, np.radians(30))])
heights = rs.synthesize(face, grid, np.random.default_rng(1))
np.save("ground.npy", np.minimum(heights, np.quantile(heights, 0.75)))
