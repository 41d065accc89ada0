"""A file that a crafted one wants to get at."""

import h5py
import numpy as np
import pytest


@pytest.fixture
def secret(tmp_path):
    """What a crafted file wants to get at."""
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["pressure"] = np.full((32, 32), 42.0, np.float32)
    (tmp_path / "secret.raw").write_bytes(np.full((32, 32), 42.0, np.float32).tobytes())
    return tmp_path / "secret.h5"
