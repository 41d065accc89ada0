"""What is shared by tests with the run of two levels (`whole` in tests/results/conftest.py)."""

import pickle

COUNT = 9  # members of its lowest level


def bits(run):
    """What estimates are made of, of numbers and of spectra."""
    names = ("flash_temperature", "plastic_fraction", "correlation_radius_50")
    return {name: pickle.dumps(run.values(name)) for name in names}
