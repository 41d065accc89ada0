"""Figures: a comparison with the theory, the pictures of a run, error over cost. Only this room uses matplotlib."""
