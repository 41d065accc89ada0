"""Comparison of theory and simulation, slope of the stress spectrum, and error of the theory."""
