"""From a scene to its numerics: pilot, levels, and what follows from the scene's numbers."""
