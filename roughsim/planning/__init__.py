"""From a scene to its numerics: cell, levels, cost, and sizes and warnings of the scene."""
