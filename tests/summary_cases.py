"""What is shared by tests with the run of two levels (`whole` in tests/results/conftest.py)."""

import numpy as np

from roughsim.estimate.ladder import Values

COUNT = 9  # realizations


def bits(run):
    """What estimates are made of, of numbers and of spectra."""
    found = {name: run.values(name) for name in ("flash_temperature", "plastic_fraction", "correlation_radius_50")}
    fields = [(name, field) for name in found for field in Values._fields]
    return {(name, field): np.asarray(getattr(found[name], field)).tobytes() for name, field in fields}
