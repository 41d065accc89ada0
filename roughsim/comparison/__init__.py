"""Theory beside simulation: the comparison, the slope of the stress spectrum, and the error of the theory."""
