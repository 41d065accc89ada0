"""From a scene to its numerics: cell, levels, cost, and what follows from the numbers of the scene."""
