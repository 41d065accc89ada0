"""Theory beside simulation: the comparison, the slope of the stress spectrum, and how far the theory can be trusted."""
